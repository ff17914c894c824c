"""From a recording car's files to a run: scenarios take them as they are, and `track import` tells what it sees."""

import json
from pathlib import Path

import numpy as np
import pytest
import tolerances as tol
from click.testing import CliRunner
from numpy.testing import assert_allclose

from railcli.analysis.parts import parts
from railcli.analysis.steady_values import final_stretch
from railcli.cli import main
from railcli.errors import InputError
from railcli.files import tables
from railcli.files.scenario import load
from railcli.model import rails
from railcli.model.irregularity import channels

START = 12400.0
ALIGNMENT = """position_km;radius_m;cant_mm;gradient_permille;gauge_mm
12,40000;0;0;2;1435
12,46000;0;0;2;1435
12,52000;800;100;2;1435
12,64000;800;100;2;1435
"""
SCENARIO = """
[run]
speed_kmh = 110
distance_m = 220
average_over_m = 40
{contact}
[[track]]
kind = "measured"
file = "alignment.csv"
[[irregularity]]
kind = "measured"
file = "coach.csv"
{more}
"""
S = 0.25 * np.arange(1000)
EXAMPLE = Path(__file__).parents[2] / "examples/recording/coach.toml"


def waves(seed):
    """Smooth irregularity [mm] in waves of 4 to 60 m."""
    rng = np.random.default_rng(seed)
    return sum(0.3 * np.sin(2 * np.pi * S / wave + rng.uniform(0, 6)) for wave in (4.7, 8.0, 14.0, 22.0, 37.0, 60.0))


COLUMNS = {"level_left [mm]": waves(1), "level_right [mm]": waves(2), "alignment_left [mm]": waves(3),
           "alignment_right [mm]": waves(4)}  # fmt: skip


def cant():
    """Of ALIGNMENT [mm]."""
    return np.interp(S, (60.0, 120.0), (0.0, 100.0))


def coach(columns, position=START + S):
    rows = [f"{s / 1e3:.5f};" + ";".join(f"{value:.4f}" for value in values)
            for s, *values in zip(position, *columns.values(), strict=True)]  # fmt: skip
    return "\n".join([";".join(["km", *columns]), *rows]) + "\n"


@pytest.fixture
def folder(tmp_path):
    def write(columns=COLUMNS, more="", contact="", position=START + S):
        (tmp_path / "alignment.csv").write_text(ALIGNMENT)
        (tmp_path / "coach.csv").write_text(coach(columns, position))
        (tmp_path / "case.toml").write_text(SCENARIO.format(more=more, contact=contact))
        return tmp_path

    return write


def railcli(*arguments):
    return CliRunner().invoke(main, [str(word) for word in arguments], prog_name="railcli")


def test_files_are_brought_together_by_their_positions(folder):
    """The rails of the scenario lie where the recording has them, 12.4 km being s = 0."""
    case = load(folder(more='vertical_positive = "down"') / "case.toml")
    s = np.linspace(30.0, 200.0, 681)
    value, _ = rails.displacement(case, s)
    at = np.searchsorted(S, s)
    for rail, side in enumerate(("right", "left")):
        assert_allclose(value[rail, 0], 1e-3 * COLUMNS[f"alignment_{side} [mm]"][at], atol=tol.FOUR_DECIMALS)
        assert_allclose(value[rail, 1], 1e-3 * COLUMNS[f"level_{side} [mm]"][at], atol=tol.FOUR_DECIMALS)
    assert case.track.origin == START and case.irregularity[0].offset is None


def test_example_of_the_tutorial():
    """The files as they are: five sections, steady values at the end, rails where the recording has them."""
    case = load(EXAMPLE)
    assert [part.kind for part in parts(case.track.sections[0])] == [
        "straight", "transition", "curve", "transition", "straight",
    ]  # fmt: skip
    assert final_stretch(case).kind == "straight" and final_stretch(case).gradient == pytest.approx(0.002)
    (line,) = [line for line in (EXAMPLE.parent / "coach.csv").read_text().splitlines() if line.startswith("12.90000;")]
    left, right, left_aside, right_aside = (float(cell) * 1e-3 for cell in line.split(";")[1:])
    moved = sum(moved(np.array([500.0]))[0] for _, moved in rails.irregularities(case))[:, :, 0]
    assert_allclose(moved, [[right_aside, right], [left_aside, left]], atol=tol.ROUNDING)  # the car counts down


def test_another_origin_is_said(folder):
    """A recording that counts from 0 beside an alignment that does not: told, and mended by offset_m."""
    place = folder(position=S)
    with pytest.raises(InputError, match="covers 0 to 249.75 m, but the run needs 12410.78 to .* by the track"):
        load(place / "case.toml")
    folder(position=S, more="offset_m = 0")
    assert load(place / "case.toml").irregularity[0].offset == 0.0


def test_absolute_cross_level_and_gauge_in_a_run(folder):
    """Cant and nominal gauge are taken off by position; what is left is the irregularity."""
    level, gauge = waves(5), waves(6)
    absolute = {"superelevation [mm]": cant() + level, "gauge [mm]": 1435.0 + gauge}
    case = load(folder(absolute) / "case.toml")
    s = np.linspace(30.0, 200.0, 681)
    moved = sum(moved(s)[0] for _, moved in rails.irregularities(case))
    found = channels(moved, rails.course(case).level)
    at = np.searchsorted(S, s)
    assert_allclose(found["cross_level"], 1e-3 * level[at], atol=tol.CANT_BY_PLACE)
    assert_allclose(found["gauge"], 1e-3 * gauge[at], atol=tol.FOUR_DECIMALS)
    with pytest.raises(InputError, match="does not follow the cant of the track"):
        load(folder({"cant [mm]": level - cant()}) / "case.toml")


def test_from_the_files_to_an_assessment(folder, table):
    """Steady values in the measured curve, and figures by section."""
    contact = '[contact]\ntable = "table.h5"\nnormal = "hertz"\ncreep_law = "table"'
    tables.save(table, folder(contact=contact) / "table.h5")
    place = folder(contact=contact)
    result = railcli("run", "scenario", place / "case.toml", "-o", place / "out", "-q", "--no-figures")
    assert result.exit_code == 0, result.stderr
    assert "right-hand curve" in result.stdout and "no steady values" not in result.stdout
    (place / "limits.toml").write_text("run_in_s = 0.5\nrun_out_s = 0.2\n")
    options = ("-q", "--no-figures", "--limits", place / "limits.toml", "-o", place / "a", "--format", "json")
    result = railcli("assess", place / "out", *options)
    assert result.exit_code == 0, result.stderr
    (record,) = json.loads(result.stdout)["results"]
    text = (place / "a/sections.csv").read_text()
    assert "straight" in text and "transition" in text and "curve" in text
    assert record["figures"]["Y_qst"]["value"] > 0.0


def test_import_tells_and_writes_what_a_run_reads(folder):
    """The tables it writes give the same rails and the same track, exactly."""
    place = folder()
    result = railcli("track", "import", place / "alignment.csv", place / "coach.csv", "-o", place / "line")
    assert result.exit_code == 0, result.stderr
    told = ("decimals   behind commas", "left_vertical: level_left [mm]", "12400 to 12640 m (by their own", "within",
            "the standard itself could not be consulted", "transition", "800 R")  # fmt: skip
    assert all(words in result.stdout for words in told)
    one = load(place / "case.toml")
    text = (place / "case.toml").read_text().replace('"alignment.csv"', '"line/alignment.csv"')
    (place / "case.toml").write_text(text.replace('"coach.csv"', '"line/irregularity.csv"'))
    two = load(place / "case.toml")
    assert one.track == two.track and one.irregularity[0].digest == two.irregularity[0].digest
    assert one.digest() == two.digest()
    record = json.loads((place / "line/import.json").read_text())
    assert [part["kind"] for part in record["alignment"]["sections"]] == ["straight", "transition", "curve"]


def test_one_file_may_hold_both(folder):
    place = folder()
    radius = np.where(S < 100.0, 0.0, 800.0)
    (place / "both.csv").write_text(coach({"radius [m]": radius, "cant [mm]": cant(), **COLUMNS}))
    result = railcli("track", "import", place / "both.csv", "-o", place / "line", "--format", "json")
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert record["alignment"]["positions"] == S.size
    rails_of = [f"{side}_{kind}" for kind in ("vertical", "alignment") for side in ("left", "right")]
    assert record["irregularity"]["channels"] == rails_of


def test_judgement_of_a_recording(folder):
    """The rms of a sine in D1 is its amplitude over root two; what is no track is named."""
    wave = 2.0 * np.sin(2 * np.pi * S / 10.0)
    columns = {"level_left [mm]": wave, "level_right [mm]": 1e-3 * wave, "alignment_left [mm]": 40.0 * wave}
    place = folder(columns)
    result = railcli("track", "import", place / "coach.csv", "-o", place / "line", "--format", "json")
    assert result.exit_code == 0, result.stderr
    rows = {(row["quantity"], row["side"], row["band"]): row
            for row in json.loads(result.stdout)["irregularity"]["quality"]}  # fmt: skip
    left = rows["level", "left", "D1"]
    assert left["rms"] == pytest.approx(2e-3 / np.sqrt(2.0), rel=0.02) and left["words"] == ""
    assert "quieter than any track" in rows["level", "right", "D1"]["words"]
    assert rows["alignment", "left", "D1"]["words"] == "beyond the range"


def test_refusals(folder):
    place = folder()
    (place / "else.csv").write_text("km;speed [km/h]\n1;2\n")
    for arguments, words in (
        ((place / "coach.csv", place / "coach.csv"), "holds irregularity, as coach.csv does"),
        ((place / "else.csv",), "no column is curvature"),
        ((place / "none.csv",), "no such file"),
        ((place / "coach.csv", "--chord", "x"), "give a length such as 20"),
    ):
        result = railcli("track", "import", *arguments, "-o", place / "line")
        assert result.exit_code == 2 and words in result.stderr and not (place / "line").exists()
