"""`railcli assess` as a user sees it, and the assessment in a run's summary."""

import csv
import json
import shutil

import h5py
import numpy as np
import pytest
import tolerances as tol
from click.testing import CliRunner

from railcli.cli import main
from railcli.files import tables
from railcli.model.assessment import FIGURES

SCENARIO = """
title = "Into a curve"
[run]
speed_m_per_s = 30
average_over_m = 50
[contact]
table = "{table}"
normal = "hertz"
creep_law = "table"
[[track]]
kind = "straight"
length_m = 60
[[track]]
kind = "transition"
length_m = 60
[[track]]
kind = "curve"
length_m = 300
radius_m = 900
hand = "right"
cant_mm = 60
"""


def railcli(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])

DRY_CURVE = """
[run]
speed_m_per_s = 8
average_over_m = 20
output_interval_ms = {interval}
[contact]
table = "{table}"
normal = "hertz"
friction = 0.5
creep_law = "table"
[[track]]
kind = "straight"
length_m = 20
[[track]]
kind = "transition"
length_m = 60
shape = "bloss"
[[track]]
kind = "curve"
length_m = 60
radius_m = 250
hand = "right"
cant_mm = 100
"""  # its wheels rattle at more than 100 Hz: rows of instants every 50 ms gave other figures than those every 5 ms


@pytest.fixture(scope="module")
def finished(table, tmp_path_factory):
    """A results folder, and what `run scenario` printed."""
    path = tmp_path_factory.mktemp("assess")
    tables.save(table, path / "table.h5")
    (path / "case.toml").write_text(SCENARIO.format(table=path / "table.h5"))
    result = railcli("run", "scenario", path / "case.toml", "-o", path / "before", "--no-figures", "-q")
    assert result.exit_code == 0, result.stderr
    return path / "before", result.stdout


def test_run_prints_and_keeps_a_short_assessment(finished):
    folder, text = finished
    assert f"All figures: railcli assess {folder}" in text and "0 fail" in text
    summary = json.loads((folder / "summary.json").read_text())
    assert list(summary["assessment"]["figures"]) == list(FIGURES)
    assert summary["assessment"]["figures"]["Y_Q"]["status"] == "pass"


def test_figures_do_not_know_the_output_interval(table, tmp_path):
    """A dry tight curve, from rows at every step to rows every 50 ms; all with the same step."""
    tables.save(table, tmp_path / "table.h5")
    found = {}
    for interval in (1, 5, 10, 50):
        case, out = tmp_path / f"{interval}.toml", tmp_path / f"{interval}"
        case.write_text(DRY_CURVE.format(interval=interval, table=tmp_path / "table.h5"))
        result = railcli("run", "scenario", case, "-o", out, "--contact", "none", "--step", 1, "--no-figures", "-q")
        assert result.exit_code == 0, result.stderr
        figures = json.loads((out / "summary.json").read_text())["assessment"]["figures"]
        found[interval] = {key: one["value"] for key, one in figures.items() if one.get("value") is not None}
    assert len(found[1]) >= 15 and found[1]["unloading"] < 1.0
    for interval, figures in found.items():
        assert figures == pytest.approx(found[1], rel=tol.OVER_INTERVALS), interval


def test_run_without_an_assessment(finished, tmp_path):
    case = finished[0].parent / "case.toml"
    result = railcli("run", "scenario", case, "-o", tmp_path / "out", "--no-figures", "--no-assessment", "-q")
    assert result.exit_code == 0 and "Assessment" not in result.stdout
    assert "assessment" not in json.loads((tmp_path / "out" / "summary.json").read_text())


def test_assess_agrees_with_the_steady_end_of_the_run(finished, tmp_path):
    """Quasi-static values of the last section against the means that the run itself took, by another way."""
    folder, _ = finished
    out = tmp_path / "out"
    result = railcli("assess", folder, "-o", out, "-q")
    assert result.exit_code == 0, result.stderr
    steady = json.loads((folder / "summary.json").read_text())["steady"]["mean"]
    with open(out / "sections.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows] == ["transition", "curve", "curve"]
    assert float(rows[-1]["radius_m"]) == pytest.approx(900.0)
    outer_y, outer_q = max(y[0] for y in steady["Y_kN"]), max(q[0] for q in steady["Q_kN"])
    assert float(rows[-1]["Y_qst_kN"]) == pytest.approx(outer_y, rel=tol.STEADY_END)
    assert float(rows[-1]["Q_qst_kN"]) == pytest.approx(outer_q, rel=tol.STEADY_END)
    record = json.loads((out / "assessment.json").read_text())
    assert record["figures"]["Y_qst"]["value"] == pytest.approx(float(rows[-1]["Y_qst_kN"]), rel=1e-5)
    assert record["figures"]["Y_qst"]["standard_consulted"] is False
    assert record["limits"]["Y_over_Q"] == 0.8 and record["provenance"]["railcli"]
    assert (out / "assessment.png").stat().st_size > 10_000


def test_wear_against_the_file(finished, tmp_path):
    """Mean of T-gamma over the evaluated rows, straight from the file."""
    folder, _ = finished
    result = railcli("assess", folder, "-o", tmp_path / "out", "-q", "--no-figures", "--format", "json")
    (record,) = json.loads(result.stdout)["results"]
    with h5py.File(folder / "timeseries.h5") as file:
        contact = {key: file[f"wheels/W1_left/contact/{key}"][()] for key in ("creep_x", "creep_t", "xi", "eta")}
        s = file["bodies/wheelset 1/position"][:, 0]
    number = np.nansum(np.abs(contact["creep_x"] * contact["xi"]) + np.abs(contact["creep_t"] * contact["eta"]), axis=1)
    inside = (s >= record["conditions"]["from_m"]) & (s < record["conditions"]["to_m"])
    expected = number[inside].mean()
    assert record["T_gamma_N"]["W1_left"]["all contacts"]["mean"] == pytest.approx(expected, rel=tol.ONE_ROW)


def test_several_results_stand_side_by_side(finished, tmp_path):
    folder, _ = finished
    shutil.copytree(folder, tmp_path / "after")
    result = railcli("assess", folder, tmp_path / "after", "-o", tmp_path / "out", "-q", "--no-figures")
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    header = lines[next(i for i, line in enumerate(lines) if line.startswith("Side by side")) + 1]
    assert header.split() == ["before", "after"]
    for name in ("before", "after"):
        assert (tmp_path / "out" / name / "assessment.json").is_file()
    again = railcli("assess", folder, "-o", tmp_path / "out", "-q", "--no-figures", "--overwrite")
    assert again.exit_code == 0 and not (tmp_path / "out" / "before" / "assessment.json").exists()


def test_own_limits_and_check(finished, tmp_path):
    folder, _ = finished
    limits = tmp_path / "limits.toml"
    limits.write_text("Q_qst_kN = 60\nsection_length_m = 60\nrun_in_s = 4.5\n")
    arguments = ("assess", folder, "-q", "--no-figures", "--limits", limits)
    result = railcli(*arguments, "-o", tmp_path / "one")
    assert result.exit_code == 0 and "1 fail" in result.stdout
    assert "without the first 4.5 and the last 2 s" in result.stdout
    result = railcli(*arguments, "-o", tmp_path / "two", "--check")
    assert result.exit_code == 4 and result.stderr.splitlines() == ["Error: over the limits, or broken off: before"]
    assert (tmp_path / "two" / "assessment.json").is_file()


def test_a_run_that_broke_off_says_so(finished, tmp_path):
    folder, _ = finished
    shutil.copytree(folder, tmp_path / "one")
    summary = json.loads((tmp_path / "one" / "summary.json").read_text())
    (tmp_path / "one" / ".railcli").unlink()  # which has its checksum
    (tmp_path / "one" / "summary.json").write_text(json.dumps({**summary, "fault": "wheel W1 left derailed"}))
    shutil.copytree(folder, tmp_path / "two")
    (tmp_path / "two" / "summary.json").unlink()
    for name, words in (("one", "wheel W1 left derailed"), ("two", "interrupted")):
        result = railcli("assess", tmp_path / name, "-q", "--no-figures", "-o", tmp_path / f"{name}-out", "--check")
        assert result.exit_code == 4 and "Verdict: the run broke off; " in result.stdout
        assert words in result.stdout and "broken off" in result.stderr


@pytest.mark.parametrize(
    "text, words",
    [
        ("Y_over_Q = -1", ["Y_over_Q", "> 0", "-1"]),
        ("Y_over_q = 0.8", ["unknown key", "Y_over_Q"]),
        ("Q_qst_kN = 'much'", ["Q_qst_kN", "number"]),
        ("ay_rms_m_per_s = 2", ["ay_rms_m_per_s", "unknown key"]),
        ("flange_angle_deg = 95", ["flange_angle_deg", "89"]),
    ],
)
def test_bad_limits_are_one_line(finished, tmp_path, text, words):
    path = tmp_path / "limits.toml"
    path.write_text(text)
    result = railcli("assess", finished[0], "--limits", path, "-o", tmp_path / "out")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert all(word in line for word in [str(path), *words]), line
    assert not (tmp_path / "out").exists()


def test_what_is_no_result_is_one_line(finished, tmp_path):
    for folders in ([tmp_path / "nowhere"], [finished[0], tmp_path / "nowhere"]):
        result = railcli("assess", *folders, "-o", tmp_path / "out")
        assert result.exit_code == 2 and "no such folder" in result.stderr and len(result.stderr.splitlines()) == 1
        assert not (tmp_path / "out").exists()
    (tmp_path / "empty").mkdir()
    result = railcli("assess", tmp_path / "empty", "-o", tmp_path / "out")
    assert result.exit_code == 2 and "no timeseries.h5" in result.stderr
