"""`railcli diff`: what differs, where, by how much."""

import json
import shutil

import h5py
import numpy as np
import pytest
import scenes
from click.testing import CliRunner

from railcli.cli import main

FORCE = "wheels/W2_right/Q"
ROW = 123


def run(*arguments):
    return CliRunner().invoke(main, ["diff", *map(str, arguments), "-q"], prog_name="railcli")


@pytest.fixture
def altered(recorded, tmp_path):
    """Function that copies the results and lets a function change the file of the copy."""

    def copy(change):
        shutil.copytree(recorded(), tmp_path / "copy")
        with h5py.File(tmp_path / "copy" / "timeseries.h5", "r+") as file:
            change(file)
        scenes.reseal(tmp_path / "copy" / "timeseries.h5")
        return tmp_path / "copy"

    return copy


def add(name, value, row=ROW, component=()):
    def change(file):
        file[name][(row, *component)] += value

    return change


def test_a_result_is_the_same_as_itself(recorded):
    result = run(recorded(), recorded())
    assert result.exit_code == 0 and "bit for bit" in result.stdout and not result.stderr


def test_two_runs_of_a_scenario_are_the_same(recorded, tmp_path):
    """The program is deterministic: a second run gives the same values."""
    again = tmp_path / "again"
    scenario = recorded().parent / f"{recorded().name}.toml"
    done = CliRunner().invoke(main, ["run", "scenario", str(scenario), "-o", str(again), "-q", "--no-figures"])
    assert done.exit_code == 0
    assert "bit for bit" in run(recorded(), again).stdout


def test_a_changed_value_is_found(recorded, altered):
    copy = altered(add(FORCE, 1000.0))
    result = run(recorded(), copy)
    assert result.exit_code == 4
    (line,) = result.stderr.splitlines()
    assert f"channels differ beyond tolerance, most {FORCE}: 1e+03 N at t = 1.24 s, s = 24.80 m" in line
    assert line.startswith("Error: diff: 1 of ")
    record = json.loads(run(recorded(), copy, "--format", "json").stdout)
    (found,) = record["channels"]
    assert record["differs"] and found["channel"] == FORCE and found["rows_beyond"] == 1
    assert found["largest"] == pytest.approx(1000.0) and found["time_s"] == pytest.approx(1.24)
    assert found["B"] - found["A"] == pytest.approx(1000.0)
    assert run(copy, recorded()).exit_code == 4


def test_tolerances_are_those_given(recorded, altered):
    copy = altered(add("bodies/car body/position", 0.001, component=(1,)))
    assert "bodies/car body/position/y: 0.001 m" in run(recorded(), copy).stderr
    assert run(recorded(), copy, "--absolute", "m=0.0009").exit_code == 4
    result = run(recorded(), copy, "--absolute", "m=0.0011")
    assert result.exit_code == 0 and "within tolerance" in result.stdout and "car body/position/y" in result.stdout
    with h5py.File(recorded() / "timeseries.h5") as file:
        extent = np.ptp(file["bodies/car body/position"][:, 1])
    for share, code in ((0.99 * 0.001 / extent, 4), (1.01 * 0.001 / extent, 0)):
        assert run(recorded(), copy, "--relative", f"{share:.6g}").exit_code == code


def test_only_the_chosen_channels_count(recorded, altered):
    copy = altered(add(FORCE, 1000.0))
    assert run(recorded(), copy, "--channel", "bodies/*").exit_code == 0
    assert run(recorded(), copy, "--channel", "wheels/W2*/Q").exit_code == 4


def test_another_sampling_is_told(recorded):
    """The same run recorded every 10 and every 20 ms: equal where both have rows, and that is not enough."""
    result = run(recorded(), recorded(interval=20.0))
    assert result.exit_code == 4 and "different instants" in result.stderr
    assert "every 10 ms" in result.stdout and "every 20 ms" in result.stdout
    assert "Channels that differ" not in result.stdout and "channels of means and extremes" in result.stdout
    assert run(recorded(), recorded(interval=20.0), "--common").exit_code == 0


def test_settings_that_differ_are_named(recorded):
    result = run(recorded(), recorded(friction=0.2), "--show", "3")
    assert result.exit_code == 4
    assert any(line.split() == ["contact.friction", "0.3", "0.2"] for line in result.stdout.splitlines())
    assert "the worst 3 of" in result.stdout


def drop(file):
    del file[FORCE]


def rename_unit(file):
    file[FORCE].attrs["units"] = "kN"


def lose(file):
    file["wheels/W1_right/contact/xi"][ROW, 0] = np.nan


@pytest.mark.parametrize(
    ("change", "words", "common"),
    [
        (drop, [f"Only in A: {FORCE}", "1 channels are in one of them only"], 0),
        (rename_unit, [f"{FORCE} is in N in A, in kN in B"], 4),
        (lose, ["wheels/W1_right/contact/xi/1: only one of them has a value in 1 rows", "t = 1.24 s"], 4),
    ],
)
def test_other_channels_units_and_gaps_are_told(recorded, altered, change, words, common):
    copy = altered(change)
    result = run(recorded(), copy)
    assert result.exit_code == 4
    assert all(word in result.stdout for word in words), result.stdout
    assert run(recorded(), copy, "--common").exit_code == common


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--absolute", "N"], ["N=10"]),
        (["--absolute", "N=nan"], ["N=10"]),
        (["--absolute", "m=-1"], ["value >= 0"]),
        (["--relative", "2"], ["0.0<=x<=1.0"]),
        (["--channel", "wheels/W9_right/Q"], ["no such channel", "did you mean"]),
    ],
)
def test_bad_options_are_refused(recorded, arguments, words):
    result = run(recorded(), recorded(), *arguments)
    assert result.exit_code == 2
    assert all(word in result.stderr for word in words), result.stderr


def test_what_is_no_result_is_refused(recorded, tmp_path):
    result = run(recorded(), tmp_path)
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1
