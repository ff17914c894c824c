"""`railcli run scenario` as a user sees it."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import scenes
import tolerances as tol
from click.testing import CliRunner

from railcli.analysis.build_table import build_table
from railcli.cli import main
from railcli.files import growing_hdf5, tables
from railcli.files.profiles import load_profile
from railcli.files.read_results import Results

SCENARIO = """
[run]
speed_m_per_s = {speed}
{run}
[contact]
table = "{table}"
normal = "hertz"
creep_law = "table"
[[track]]
kind = "straight"
length_m = 10
[[track]]
kind = "transition"
length_m = 40
[[track]]
kind = "curve"
length_m = {length}
radius_m = {radius}
hand = "right"
cant_mm = 90
"""
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def table_file(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "table.h5"
    tables.save(table, path)
    return path


@pytest.fixture
def scenario_file(tmp_path, table_file):
    """Function that writes a scenario file."""

    def write(speed=20.0, radius=1200.0, length=60.0, run="average_over_m = 20"):
        path = tmp_path / "case.toml"
        path.write_text(SCENARIO.format(speed=speed, radius=radius, length=length, run=run, table=table_file))
        return path

    return write


def run(*arguments):
    return CliRunner().invoke(main, ["run", "scenario", *map(str, arguments)], prog_name="railcli")


def test_list_names_every_built_in_scenario():
    result = run("--list")
    assert result.exit_code == 0
    listed = {line.split()[0] for line in result.stdout.splitlines()}
    folders = ("benchmarks/manchester", "benchmarks/braking", "vehicles/*")
    places = [path for folder in folders for path in ROOT.glob(f"{folder}/cases/*.toml")]
    assert listed == {path.stem for path in places}


def test_results_folder_holds_what_was_run(scenario_file, tmp_path):
    """Sums of the recorded rail forces balance the acceleration; every channel has a unit."""
    result = run(scenario_file(), "-o", tmp_path / "out", "--format", "json", "-q")
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    folder = tmp_path / "out"
    assert {path.name for path in folder.iterdir()} == {*record["files"], "summary.json", ".railcli"}
    assert json.loads((folder / "summary.json").read_text()) == record
    steady = record["steady"]
    assert steady["sum_Y_kN"] == pytest.approx(steady["expected_Y_kN"], abs=tol.BALANCE_KN)
    assert steady["sum_Q_kN"] == pytest.approx(steady["expected_Q_kN"], abs=tol.BALANCE_KN)
    with h5py.File(folder / "timeseries.h5") as file:
        assert file["time"].size == record["rows"]
        items = []
        file.visititems(lambda name, item: items.append(item))
        assert all(item.attrs["units"] for item in items if isinstance(item, h5py.Dataset))
        total = sum(file[f"wheels/{name}/Q"][-1] for name in file["wheels"])
        assert total * 1e-3 == pytest.approx(steady["expected_Q_kN"], abs=tol.BALANCE_KN)
        lateral = file["bodies/wheelset 1/position"][:, 1]
    header, *lines = (folder / "main.csv").read_text().splitlines()
    column = header.split(",").index("W1_y_mm")
    np.testing.assert_allclose([float(line.split(",")[column]) for line in lines], 1e3 * lateral, rtol=1e-8, atol=1e-12)


def test_table_for_people_names_direction_and_balances(scenario_file, tmp_path):
    result = run(scenario_file(), "-o", tmp_path / "out", "--no-figures", "-q")
    assert result.exit_code == 0, result.stderr
    assert "towards the outer rail" in result.stdout
    assert all(f"  W{k} " in result.stdout for k in range(1, 5))
    assert not list((tmp_path / "out").glob("*.png"))


def test_derailment_keeps_what_was_computed(scenario_file, tmp_path):
    """Far too fast for the curve: exit 3, which wheel, when and where; results readable up to there."""
    out = tmp_path / "out"
    result = run(scenario_file(speed=60.0, radius=120.0), "-o", out, "--no-figures", "-q")
    assert result.exit_code == 3
    (line,) = result.stderr.splitlines()
    assert "wheel W" in line and "t = " in line and "s = " in line and str(out) in line
    record = json.loads((out / "summary.json").read_text())
    assert not record["finished"] and record["fault"] in line
    with h5py.File(out / "timeseries.h5") as file:
        assert file["time"].size == record["rows"] > 0
        assert np.isfinite(file["bodies/wheelset 1/position"][()]).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--speed", "0"], ["speed_m_per_s: must be > 0 m/s, got 0"]),
        (["--step", "0"], ["step_ms: must be >= 0.001 ms, got 0"]),
        (["--step", "0.3"], ["multiple of the step"]),
        (["--friction", "-0.1"], ["friction: must be >= 0, got -0.1"]),
    ],
)
def test_overrides_are_checked(scenario_file, tmp_path, arguments, words):
    result = run(scenario_file(), *arguments, "-o", tmp_path / "out")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert all(word in line for word in words), line
    assert not (tmp_path / "out").exists()


def test_track_shorter_than_the_run_is_refused(scenario_file, tmp_path):
    result = run(scenario_file(run="distance_m = 500"), "-o", tmp_path / "out")
    assert result.exit_code == 2 and "track shorter than the run" in result.stderr
    assert not (tmp_path / "out").exists()


def test_existing_folder_is_spared(scenario_file, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")
    for extra in ([], ["--overwrite"]):
        result = run(scenario_file(), "-o", tmp_path / "out", *extra)
        assert result.exit_code == 2 and str(tmp_path / "out") in result.stderr
    assert (tmp_path / "out" / "mine.txt").read_text() == "mine"


def test_full_disk_is_one_line_and_keeps_the_rows_before(scenario_file, tmp_path, monkeypatch):
    """The third block of rows finds no room: exit 2, and the file holds the rows of the two before."""
    calls = []

    def grant(self, count, honest=growing_hdf5.Granted.grant):
        calls.append(count)
        if len(calls) > 4:
            raise OSError(errno.ENOSPC, "No space left on device")
        honest(self, count)

    monkeypatch.setattr(growing_hdf5.Granted, "grant", grant)
    path = scenario_file(run="average_over_m = 20\noutput_interval_ms = 1")
    result = run(path, "-o", tmp_path / "out", "--no-figures", "-q")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert "timeseries.h5" in line and "space" in line.lower()
    with h5py.File(tmp_path / "out" / "timeseries.h5") as file:
        assert file["time"].size % 1000 == 0 and file["time"].size > 0
        assert f"until t = {file['time'][-1]:.2f} s is kept" in line


def test_ctrl_c_keeps_what_was_computed(scenario_file, tmp_path):
    """Ctrl-C in a long run: exit 130, and a readable file."""
    out = tmp_path / "out"
    path = scenario_file(speed=1.0, length=5000.0)
    code = "from railcli.cli import main; main()"
    with subprocess.Popen(
        [sys.executable, "-c", code, "run", "scenario", str(path), "-o", str(out), "-q", "--no-figures"],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        patience = time.monotonic() + 120.0
        while not any(file.stat().st_size > 5e6 for file in out.glob("*timeseries*")):
            assert process.poll() is None and time.monotonic() < patience
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=300)
    assert process.returncode == 130 and len(message.splitlines()) == 1
    with h5py.File(out / "timeseries.h5") as file:
        assert file["time"].size > 0
        assert file["wheels/W1_left/Q"].size == file["time"].size
        assert f"until t = {file['time'][-1]:.2f} s is kept in {out}" in message


def test_sides_that_differ_are_named(scenario_file, tmp_path, table_file, profiles):
    """Another left rail: a table of its own, told in text and summary."""
    case = scenario_file()
    left = table_file.parent / "left.h5"
    tables.save(build_table(profiles[0], load_profile("60E1", "rail"), scenes.SMALL)[0], left)
    text = case.read_text().replace("[contact]", f'[contact]\nleft_rail_profile = "60E1"\nleft_table = "{left}"')
    case.write_text(text)
    out = tmp_path / "out"
    result = CliRunner().invoke(main, ["run", "scenario", str(case), "-o", str(out), "-q", "--no-figures"])
    assert result.exit_code == 0, result.output
    assert "right ORES1002 on UIC60; left ORES1002 on 60E1" in result.output
    used = json.loads((out / "summary.json").read_text())["provenance"]["contact_tables"]
    assert [table["rail"]["name"] for table in used] == ["UIC60", "60E1"]


def test_contact_channels_that_do_not_exist_leave_nothing(tmp_path):
    result = CliRunner().invoke(main, ["run", "scenario", "-q", "--contact", "*/none", "-o", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "'*/none' fits none" in result.stderr
    assert not (tmp_path / "out").exists()


def test_results_of_a_run_shorter_than_the_usual_average_are_read_again(tmp_path):
    """What is recorded of the scenario describes it as it ran: 60 m, averaged over all of them."""
    file = tmp_path / "short.toml"
    file.write_text('[run]\nspeed_m_per_s = 20\n[[track]]\nkind = "straight"\nlength_m = 60\n')
    result = CliRunner().invoke(main, ["run", "scenario", str(file), "-q", "--no-figures", "-o", str(tmp_path / "out")])
    assert result.exit_code == 0, result.stderr
    with Results(tmp_path / "out") as results:
        assert results.scenario.average_over == 60.0
    assert "error" not in json.loads((tmp_path / "out/summary.json").read_text())["assessment"]
