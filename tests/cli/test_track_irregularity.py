"""`railcli track irregularity` from the outside."""

import json

import numpy as np
import pytest
import tolerances as tol
from click.testing import CliRunner

from railcli.cli import main
from railcli.model.spectra import CHANNELS, SPECTRA

FILES = {"irregularity.csv", "irregularity.json"}
FIGURES = {"channels.png", "spectra.png"}


def run(*arguments):
    return CliRunner().invoke(main, ["track", "irregularity", *(str(item) for item in arguments)], prog_name="railcli")


def names(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def columns(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return lines[0].split(","), np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])


def test_made_and_read_again(tmp_path):
    """A made track has the closed RMS of its band; its file, read as a measured one, gives the same table."""
    made = run("--spectrum", "fra-6", "--length", 1400, "--seed", 3, "-o", tmp_path / "made", "--format", "json")
    assert made.exit_code == 0
    assert names(tmp_path / "made") == FILES | FIGURES
    record = json.loads(made.stdout)
    whole = {row["channel"]: row for row in record["bands"] if row["band"] == "all"}
    assert set(whole) == set(CHANNELS)
    for name, row in whole.items():
        assert row["target_mm"] == pytest.approx(1e3 * SPECTRA["fra-6"].channels[name].band_rms(3.0, 70.0))
        assert row["rms_mm"] == pytest.approx(row["target_mm"], rel=tol.DETRENDED)  # 1400 m are one period
    assert record["read_back_difference_m"] < tol.WRITTEN
    path = tmp_path / "made" / "irregularity.csv"
    header, values = columns(path)
    assert header == [
        "position_m", "right_alignment_mm", "left_alignment_mm", "right_vertical_mm", "left_vertical_mm",
    ]  # fmt: skip
    assert values[0, 0] == 0.0 and values[-1, 0] == 1400.0
    again = run(path, "--spectrum", "fra-6", "-o", tmp_path / "again", "--no-figures", "--format", "json")
    assert names(tmp_path / "again") == FILES
    for one, two in zip(record["bands"], json.loads(again.stdout)["bands"], strict=True):
        assert one["band"] == two["band"] and two["rms_mm"] == pytest.approx(one["rms_mm"], rel=1e-6)


def test_text(tmp_path):
    """The table says convention, target and what was realised."""
    result = run("--length", 500, "--sided", "two", "--no-figures", "-o", tmp_path / "out")
    assert result.exit_code == 0
    assert "b176-low (S two-sided, so counted twice; cross-level at 1.5 m), wavelengths 3 to 70 m" in result.stdout
    assert "vertical, up" in result.stdout and "D2  25 to 70 m" in result.stdout
    target = f"{1e3 * np.sqrt(2.0) * SPECTRA['b176-low'].channels['vertical'].band_rms(3.0, 25.0):.3f}"
    assert target in result.stdout


def test_scenario(tmp_path):
    """A scenario's rails where they have their full size; a defect has no target."""
    result = run("bump", "--format", "json", "--no-figures", "-o", tmp_path / "out")
    record = json.loads(result.stdout)
    assert {row["channel"] for row in record["bands"]} == {"vertical"}
    assert all(row["target_mm"] is None for row in record["bands"])
    _, values = columns(tmp_path / "out" / "irregularity.csv")
    assert values[:, 3].max() == pytest.approx(3.0, abs=0.01) and not values[:, 1:3].any()
    assert json.loads(run("random-track", "--format", "json", "--no-figures", "-o", tmp_path / "two").stdout)[
        "settled_from_m"
    ] == pytest.approx(20.78)


def test_list():
    result = run("--list")
    assert [line.split()[0] for line in result.stdout.splitlines()] == list(SPECTRA)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--shortest", 0.4], "waves of 0.4 m need samples every 0.2 m at least, these lie 0.25 m apart"),
        (["--longest", 3000], "waves of 3000 m do not fit into 2000 m"),
        (["--shortest", 80], "must be > 0 and rise, got 80 and 70 m"),
        (["--spectrum", "fra-7"], "unknown name 'fra-7'"),
        (["--length", -5], "--length: must be > 0"),
        (["--spacing", 1e-5], "--spacing: must be > 0 and give at most 2,000,000 values"),
        (["curve-300"], "curve-300: has no [[irregularity]]"),
        (["nowhere.csv"], "nowhere.csv: there is no such file"),
    ],
)
def test_refused(tmp_path, monkeypatch, arguments, words):
    """One line, exit code 2, nothing written."""
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2
    assert words in result.stderr and len(result.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
