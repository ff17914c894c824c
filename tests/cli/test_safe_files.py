"""Small files cannot ask for the machine: what is no regular file, or declares too much, is one line at once.

Commands run in a child with little memory, several in one, so that a fault fails these tests and nothing else.
"""

import json
import os
import resource
import shutil
import subprocess
import sys

import h5py
import numpy as np
import pytest
import scenes

from railcli.errors import InputError
from railcli.files import tables

MEMORY = 3_000_000_000  # bytes that a refusal may address; libraries alone map more than one of them
SECONDS = 120  # a hang is a fault; how long a refusal takes is not looked at here
CHILD = """
import json, sys
from click.testing import CliRunner
from railcli.cli import main
for arguments in json.loads(sys.stdin.read()):
    result = CliRunner().invoke(main, arguments, prog_name="railcli")
    print(json.dumps([result.exit_code, result.stdout, result.stderr]), flush=True)
"""
RUN = "[run]\nspeed_m_per_s = 20\n"
STRAIGHT = "[[track]]\nkind = 'straight'\nlength_m = {}\n"


def refusals(folder, commands):
    """The one line with which each of several commands refuses its input."""
    words = [[str(word) for word in command] for command in commands]
    done = subprocess.run(
        [sys.executable, "-c", CHILD], input=json.dumps(words), cwd=folder, capture_output=True, text=True,
        timeout=SECONDS, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = []
    for command, answer in zip(words, done.stdout.splitlines(), strict=True):
        code, output, errors = json.loads(answer)
        assert code == 2 and output == "", (command, code, output, errors)
        (line,) = errors.splitlines()
        assert len(line) < 1000
        found.append(line)
    return found


DEVICES = {
    "vehicle": "vehicle = '{}'\n" + RUN + STRAIGHT.format(200),
    "track": RUN + "[[track]]\nkind = 'measured'\nfile = '{}'\n",
    "irregularity": RUN + STRAIGHT.format(200) + "[[irregularity]]\nkind = 'measured'\nfile = '{}'\n",
    "wheel": RUN + STRAIGHT.format(200) + "[contact]\nwheel_profile = '{}'\n",
    "table": RUN + STRAIGHT.format(200) + "[contact]\ntable = '{}'\n",
}


def test_no_device_and_no_pipe_is_read(tmp_path):
    """Whatever key of a scenario names it."""
    os.mkfifo(tmp_path / "pipe.toml")
    places, commands = [], []
    for place in ("/dev/zero", str(tmp_path / "pipe.toml")):
        for key, text in DEVICES.items():
            case = tmp_path / f"{key}-{len(commands)}.toml"
            case.write_text(text.format(place))
            places.append(place)
            commands.append(("run", "scenario", case, "-q", "-o", "out", "--no-figures"))
    for place, line in zip(places, refusals(tmp_path, commands), strict=True):
        assert "is not a regular file" in line and place in line


def test_no_argument_is_a_pipe(tmp_path):
    for ending in ("toml", "csv", "whl", "h5"):
        os.mkfifo(tmp_path / f"pipe.{ending}")
    commands = [
        ("run", "scenario", "./pipe.toml", "-q"),
        ("track", "show", "pipe.csv"),
        ("track", "irregularity", "pipe.csv"),
        ("profile", "import", "pipe.whl"),
        ("conicity", "--wheel", "pipe.whl"),
        ("build-lut", "--check", "pipe.h5"),
        ("assess", "pipe.h5"),
        ("export", "pipe.h5"),
    ]
    assert all("is not a regular file" in line for line in refusals(tmp_path, commands))


TURNS = RUN + "distance_m = 10\n" + STRAIGHT.format(20) + "[[track]]\nkind = 'transition'\nlength_m = 10\n" + (
    "[[track]]\nkind = 'curve'\nradius_m = 10\nhand = 'left'\nlength_m = 9e5\n")  # fmt: skip
LARGE = [
    ("track.toml", RUN + "distance_m = 10\n" + 200 * STRAIGHT.format("1e6"), "is 2e+08 m long; at most 1e+06 m"),
    ("track.toml", TURNS, "pieces, more than the 100000"),
    ("track.csv", "position_m,curvature_1_per_km\n0,0\n1e9,0\n", "is 1e+09 m long; at most 1e+06 m"),
    ("track.csv", "s_km;radius_m;cant_m\n0;inf;0\n0,010;3000;0,01\n4096,02;;0\n", "is 4.09602e+06 m long"),
    ("track.csv", "position_m,radius_m\n" + "1,0\n" * 100_001, "100001 rows; an alignment table may have at most"),
    ("track.toml", "title = '" + 4_000_000 * "x" + "'\n", "4.0 MB; a TOML file may have at most 4 MB"),
    ("track.toml", ".".join(10_000 * "a") + " = 1\n", "more than 50 parts with dots"),
    ("track.toml", "a = " + 5000 * "[" + 5000 * "]" + "\n", "nested too deeply"),
]


def test_totals_are_bounded(tmp_path):
    commands = []
    for number, (name, text, _) in enumerate(LARGE):
        (tmp_path / f"{number}-{name}").write_text(text)
        commands.append(("track", "show", f"./{number}-{name}", "-o", "a.png"))
    for (_, _, words), line in zip(LARGE, refusals(tmp_path, commands), strict=True):
        assert words in line


def test_poses_positions_and_names_are_bounded(tmp_path):
    wide = ("--y-range", 100, "--y-step", 0.001, "--roll-range", 200, "--roll-step", 0.01, "--yaw-count", 200)
    wide = ("--normal", "hertz", *wide)
    (tmp_path / "case.toml").write_text(f"vehicle = '{5000 * 'x'}'\n" + RUN + STRAIGHT.format(10))
    positions, long = refusals(
        tmp_path, [("build-lut", *wide, "-o", "t.h5"), ("run", "scenario", "./case.toml", "-q")]
    )
    assert "positions of the wheel" in positions and "[...]" in long


def test_names_with_null_characters(tmp_path):
    commands = []
    for key, text in DEVICES.items():
        (tmp_path / f"{key}.toml").write_text(text.replace("'{}'", '"a/\\u0000b.toml"'))
        commands.append(("run", "scenario", f"./{key}.toml", "-q", "-o", "out"))
    assert all("null character" in line for line in refusals(tmp_path, commands))


def test_damaged_results(recorded, tmp_path):
    """Channels of 1e12 rows in a file of some hundred kilobytes; a scenario that is a pipe; one that is nested."""
    large, pipe, nested = (shutil.copytree(recorded(), tmp_path / name) for name in ("large", "pipe", "nested"))
    with h5py.File(large / "timeseries.h5", "r+") as file:
        names = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        for name in names:
            if not name.startswith("filtered"):
                file[name].resize(10**12, axis=0)
    scenes.reseal(large / "timeseries.h5")
    (pipe / "scenario.json").unlink()
    os.mkfifo(pipe / "scenario.json")
    (nested / "scenario.json").write_text(100_000 * "[")
    lines = refusals(tmp_path, [
        ("export", large, "--channel", "time", "-o", "a.csv"),
        ("assess", pipe, "-q", "-o", "a"),
        ("assess", nested, "-q", "-o", "a"),
    ])  # fmt: skip
    for line, words in zip(lines, ("is damaged", "is not a regular file", "checksum"), strict=True):
        assert words in line


def test_table_longer_than_its_head_says(table, tmp_path):
    tables.save(table, tmp_path / "t.h5")
    with open(tmp_path / "t.h5", "ab") as file:
        file.write(np.zeros(100).tobytes())
    with pytest.raises(InputError, match="but its head says"):
        tables.load(tmp_path / "t.h5")
