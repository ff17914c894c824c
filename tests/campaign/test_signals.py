"""Commands that are stopped at random moments: one line, the right exit code, nothing half-written, and on again."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest

from railcli.errors import InputError
from railcli.files.output import LIST, is_changed, parts
from railcli.files.read_results import Results

pytestmark = [pytest.mark.campaign, pytest.mark.skipif(os.name != "posix", reason="signals of Unix")]

LONG = """
[run]
speed_m_per_s = 20
average_over_m = 50
[contact]
table = "{table}"
normal = "hertz"
[[track]]
kind = "straight"
length_m = 900
[[track]]
kind = "transition"
length_m = 50
[[track]]
kind = "curve"
radius_m = 600
hand = "left"
length_m = 200
"""
COMMANDS = {  # arguments with {run}, {results}, {table}, and what is written with -o
    "run": ("run scenario {run}", "folder"),
    "assess": ("assess {results}", "folder"),
    "report": ("report {results}", "folder"),
    "diff": ("diff {results} {results}", None),
    "export": ("export {results}", "out.csv"),
    "parquet": ("export {results}", "out.parquet"),
    "modes": ("modes straight-60", "folder"),
    "conicity": ("conicity", "folder"),
    "profile": ("profile import {wheel}", "wheel.csv"),
    "track": ("track show {run}", "track.png"),
    "irregularity": ("track irregularity", "folder"),
    "vehicle": ("vehicle copy locomotive", "copy.toml"),
    "build-lut": ("build-lut --normal hertz --y-range 6 --roll-range 5 --yaw-range 5 --poses 500", "t.h5"),
}
SOFT = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
COMMAND = [sys.executable, "-m", "railcli"]


@pytest.fixture(scope="module")
def places(recorded, table, tmp_path_factory):
    from railcli.files import tables

    folder = tmp_path_factory.mktemp("stopped")
    tables.save(table, folder / "table.h5")
    (folder / "run.toml").write_text(LONG.format(table=folder / "table.h5"))
    wheel = sorted((Path(__file__).parents[1] / "data/samples").glob("*.whl"))[0]
    return {"run": folder / "run.toml", "results": recorded(), "table": folder / "table.h5", "wheel": wheel}


@pytest.fixture(scope="module")
def starts(places, tmp_path_factory):
    """Function that starts a command in an empty folder; gives the process and the folder."""
    seconds = {}

    def start(name, overwrite=False, folder=None):
        words, output = COMMANDS[name]
        folder = folder or tmp_path_factory.mktemp(name)
        words = [*words.format(**places).split(), *(["-o", output] if output else []), *(["--overwrite"] * overwrite)]
        files = [open(folder.with_suffix(end), "w+") for end in (".out", ".err")]
        process = subprocess.Popen([*COMMAND, *words], cwd=folder, stdout=files[0], stderr=files[1])
        return process, folder, files

    def ended(process, files):
        code = process.wait(timeout=600)
        texts = []
        for file in files:
            file.seek(0)
            texts.append(file.read())
            file.close()
        return code, *texts

    def length(name):
        if name not in seconds:
            began = time.monotonic()
            process, folder, files = start(name)
            code, _, said = ended(process, files)
            assert code == 0, said
            seconds[name] = time.monotonic() - began
            shutil.rmtree(folder)
        return seconds[name]

    return start, ended, length


def whole(folder):
    """Assert that each file that is there under its name is as it was written."""
    for path in folder.rglob("*"):
        if not path.is_file() or path.name == LIST or path.name.startswith(".railcli-part-"):
            continue
        assert not is_changed(path), path
        if path.suffix == ".json":
            json.loads(path.read_text(encoding="utf-8"))
        elif path.suffix == ".h5":
            with h5py.File(path, "r", locking=False) as file:
                assert len(file)
        elif path.suffix == ".png":
            assert path.read_bytes().endswith(b"IEND\xaeB`\x82")
        assert path.stat().st_size > 0


@pytest.mark.parametrize("name", COMMANDS)
def test_stopped_at_random_moments(starts, many, random, counts, name):
    start, ended, length = starts
    for _ in range(many(4)):
        number = [*SOFT, signal.SIGKILL][random.integers(4)]
        process, folder, files = start(name)
        time.sleep(length(name) * random.uniform(0.0, 1.1))
        process.send_signal(int(number))
        if random.random() < 0.3:
            time.sleep(0.02)
            process.send_signal(int(number))
        code, out, said = ended(process, files)
        what = f"{name} {signal.Signals(number).name}: {code}\n{said}"
        assert "Traceback" not in said and "fault of railcli" not in said and "Exception ignored" not in said, what
        whole(folder)
        if number == signal.SIGKILL:
            assert code in (-9, 0), what
        else:
            assert code in (SOFT[number], -number, 0), what  # -number: before Python itself listens
            assert parts(folder) == [] and parts(folder / "folder") == [], what
            if code > 0:
                assert said.splitlines()[-1].startswith(("Interrupted.", "Stopped by SIG")), what
        kind = "too late" if code == 0 else "before it listens" if code < 0 and number in SOFT else f"{number.name}"
        counts[kind] += 1
        _goes_on(start, ended, name, folder, what, counts)


def _goes_on(start, ended, name, folder, what, counts):
    """What was left can be read, and the command can be given again."""
    if name == "run" and parts(folder / "folder", "timeseries.h5"):
        try:
            with Results(folder / "folder") as results:
                for channel in results.channels:
                    results.read(channel)
                assert "killed" in results.fault
            counts["of these with rows read"] += 1
        except InputError as error:
            counts["of these without rows"] += 1
            assert "rows" in str(error) or "damaged" in str(error) or "cannot be read" in str(error), what
    process, _, files = start(name, overwrite=COMMANDS[name][1] is not None, folder=folder)
    code, _, said = ended(process, files)
    assert code == 0, f"after {what}\n{said}"
    whole(folder)
    assert parts(folder) == [] and parts(folder / "folder") == []
    shutil.rmtree(folder)
