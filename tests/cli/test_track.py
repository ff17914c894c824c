"""`railcli track show` as a user sees it."""

import json
import struct

import pytest
from click.testing import CliRunner

from railcli.cli import main

TABLE = """position_m,curvature_1_per_km,cant_mm,gradient_permille,gauge_mm
0,0,0,0,1435
80,3,60,0,1443
200,3,60,8,1443
"""


def show(*arguments):
    return CliRunner().invoke(main, ["track", "show", *map(str, arguments)], prog_name="railcli")


def test_draws_and_prints_a_built_in_scenario(tmp_path):
    result = show("s-curve", "-o", tmp_path / "s.png")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "s.png").stat().st_size > 20_000
    rows = [line.split()[:4] for line in result.stdout.splitlines() if line[2:3].isdigit()]
    assert rows == [
        ["1", "straight", "0", "40"],
        ["2", "clothoid", "40", "100"],
        ["3", "curve", "100", "180"],
        ["4", "clothoid", "180", "300"],
        ["5", "curve", "300", "500"],
    ]
    assert "300 L > 300 R" in result.stdout and "middle of the track" in result.stdout
    assert "the standard itself could not be consulted" in result.stdout


def test_numbers_of_a_table(tmp_path):
    """A CSV file has no speed of its own: what needs one is there only with --speed."""
    path = tmp_path / "line.csv"
    path.write_text(TABLE)
    without = json.loads(show(path, "--format", "json", "-o", tmp_path / "a.svg").stdout)
    assert set(without["sections"][0]["largest"]) == {"cant_m", "twist_m_per_m"}
    record = json.loads(show(path, "--speed", 30, "--format", "json", "-o", tmp_path / "b.svg").stdout)
    ramp, curve = record["sections"]
    assert (ramp["kind"], curve["kind"]) == ("transition", "curve") and ramp["to_m"] == pytest.approx(80.0)
    assert curve["largest"]["cant_deficiency_m"] == pytest.approx(1.5 * 900.0 * 3e-3 / 9.81 - 0.060)
    assert ramp["largest"]["twist_m_per_m"] == pytest.approx(0.060 / 80.0)
    assert ramp["gauge_over_nominal_m"]["high"] == pytest.approx(0.008)
    assert curve["gradient_m_per_m"]["last"] == pytest.approx(0.008)
    quantities = {warning["quantity"] for warning in record["warnings"]}
    assert quantities == {"cant_deficiency", "cant_deficiency_rate"}
    assert (tmp_path / "b.svg").read_text().startswith("<?xml")


def test_default_place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert show("twist").exit_code == 0
    assert (tmp_path / "railcli-out/track-twist-1/track.png").is_file()


def test_refusals(tmp_path):
    (tmp_path / "line.csv").write_text("position_m,cant_mm\n0,0\n1,1\n")
    for arguments, message in (
        (("no-such",), "no built-in scenario"),
        ((tmp_path / "line.csv",), "line 1: found 'position_m, cant_mm'; needed are"),
        (("s-curve", "-o", tmp_path / "x.bmp"), "figures end with one of"),
        (("s-curve", "--speed", "0"), "--speed"),
    ):
        result = show(*arguments)
        assert result.exit_code == 2 and message in result.stderr and result.stdout == ""


def test_irregularity_has_panels_of_its_own(tmp_path):
    """Of the same width as a picture without, and higher."""
    sizes = {}
    for name in ("random-track", "straight-60"):
        picture = tmp_path / f"{name}.png"
        assert CliRunner().invoke(main, ["track", "show", name, "-o", str(picture)]).exit_code == 0
        sizes[name] = struct.unpack(">II", picture.read_bytes()[16:24])
    assert sizes["random-track"][0] == sizes["straight-60"][0] and sizes["random-track"][1] > sizes["straight-60"][1]
