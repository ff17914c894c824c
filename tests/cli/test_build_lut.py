"""`railcli build-lut` as a user sees it."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from railcli.cli import main
from railcli.files import tables
from railcli.model import contact_table

ROOT = Path(__file__).parents[2]
GRID = ["--normal", "hertz", "--y-step", "0.5", "--roll-step", "5", "--yaw-count", "3"]
COARSE = [*GRID, "--poses", "100", "-q"]


def build(*arguments):
    return CliRunner().invoke(main, ["build-lut", *map(str, arguments)], prog_name="railcli")


@pytest.fixture(scope="module")
def coarse(tmp_path_factory):
    """A coarse table as the command writes it, and what it printed."""
    path = tmp_path_factory.mktemp("build-lut") / "table.h5"
    result = build(*COARSE, "-o", path, "--format", "json")
    assert result.exit_code == 0, result.stderr
    return path, json.loads(result.stdout)


def test_prints_positions_time_size_and_certificate(coarse):
    path, record = coarse
    assert record["positions"] == 81 * 11 * 3
    assert record["bytes"] == path.stat().st_size
    assert record["cpu_s"] > 0.0
    assert record["certificate"]["poses"] == 100
    assert {"gap_um", "position_mm", "angle_mrad", "radius_um"} <= set(record["certificate"])


def test_errors_are_told_by_part_of_the_profile(coarse):
    """Built and checked alike: lines for each part, with contacts or poses and errors of geometry or of forces."""
    lines = build("--check", coarse[0], "--poses", "150", "--seed", "1", "-q").stdout.splitlines()
    parts = [line.split() for line in lines if line.split()[:1] in (["tread"], ["root"], ["flank"], ["tip"])]
    heads = [k for k, line in enumerate(lines) if line.startswith("By part of the wheel profile")]
    assert len(heads) == 2  # measured now, and when it was built
    assert {words[0] for words in parts} >= {"tread", "flank", "tip"}
    assert all(int(words[1].replace(",", "")) > 0 and words.count("/") in (4, 10) for words in parts)


SMALL = ["--y-range", "5", "--roll-range", "5", "--yaw-range", "10", *GRID, "--poses", "300", "-q"]


def test_accuracy_refines_until_it_is_met(tmp_path):
    """Each grid is finer than the one before; the last keeps what was asked, and the file holds it."""
    result = build(*SMALL, "--accuracy", "0.02", "-o", tmp_path / "t.h5", "--format", "json")
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    stages = record["refinement"]
    assert len(stages) >= 2 and [stage["error_over_allowed"] <= 1.0 for stage in stages].index(True) == len(stages) - 1
    assert all(after["bytes"] > before["bytes"] for before, after in zip(stages, stages[1:], strict=False))
    tread = record["certificate"]["angle_mrad"]["by_region"]["tread"]["p999"]
    assert tread <= 0.02 and record["certificate"]["radius_um"]["by_region"]["tread"]["p999"] <= 0.2
    kept = tables.read(tmp_path / "t.h5").table.settings
    assert kept.yaw_count == stages[-1]["yaw_count"] and kept.roll_step * 1e3 == stages[-1]["roll_step_mrad"]


def test_accuracy_beyond_the_largest_size_is_one_line(tmp_path):
    result = build(*SMALL, "--accuracy", "0.002", "--largest", "0.2", "-o", tmp_path / "t.h5")
    assert result.exit_code == 4
    (line,) = result.stderr.splitlines()
    assert "0.002 mrad" in line and "--largest" in line and not (tmp_path / "t.h5").exists()


@pytest.mark.parametrize("arguments", [("--accuracy", "0.1", "--poses", "0"), ("--accuracy", "0"), ("--largest", "0")])
def test_accuracy_that_makes_no_sense(arguments):
    assert build(*arguments).exit_code == 2


def test_method_twins_give_one_table(coarse, tmp_path):
    """Simplex and closed-form locus find the same number of contact points to one in two hundred."""
    result = build(*COARSE, "--method", "locus", "-o", tmp_path / "twin.h5", "--format", "json")
    assert json.loads(result.stdout)["nodes"] == pytest.approx(coarse[1]["nodes"], rel=0.005)


def test_picture_is_drawn_beside_the_table(tmp_path):
    result = build(*COARSE, "-o", tmp_path / "t.h5", "--plot")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")


def test_check_finds_a_coarse_table_wanting(coarse):
    """A table ten times coarser than the default is beyond the limits: exit 4, and the quantity is named."""
    result = build("--check", coarse[0], "--poses", "1500", "-q")
    assert result.exit_code == 4
    assert "angle" in result.stderr or "radius" in result.stderr


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.999])
def test_one_flipped_bit_is_found(coarse, tmp_path, share):
    content = bytearray(coarse[0].read_bytes())
    content[int(share * len(content))] ^= 1
    bad = tmp_path / "bad.h5"
    bad.write_bytes(content)
    result = build("--check", bad)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert str(bad) in line and "railcli build-lut" in line


def test_truncated_foreign_and_missing_tables(coarse, tmp_path):
    content = coarse[0].read_bytes()
    for name, data in (("cut.h5", content[: len(content) // 2]), ("text.h5", b"y,z\n" * 40), ("empty.h5", b"")):
        (tmp_path / name).write_bytes(data)
    for name in ("cut.h5", "text.h5", "empty.h5", "none.h5"):
        result = build("--check", tmp_path / name)
        assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1, result.stderr


def test_table_of_another_version(coarse, tmp_path, monkeypatch):
    monkeypatch.setattr(contact_table, "VERSION", contact_table.VERSION + 1)
    result = build("--check", coarse[0])
    assert result.exit_code == 2 and "version" in result.stderr


def test_table_for_other_profiles(coarse):
    result = build("--check", coarse[0], "--rail", "60E1")
    assert result.exit_code == 2 and "60E1" in result.stderr and "UIC60" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--gauge", "1300"], ["no wheelset fits", "1300"]),
        (["--gauge", "100"], ["gauge", "0.5 ... 2"]),
        (["--y-step", "0"], ["y_step"]),
        (["--wheel", "nothere.csv"], ["nothere.csv"]),
        (["--wheel", "UIC60"], ["UIC60"]),
        (["--inclination", "2"], ["inclination"]),
    ],
)
def test_geometry_that_cannot_be_built(tmp_path, arguments, words):
    result = build(*COARSE, *arguments, "-o", tmp_path / "t.h5")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert all(word in line for word in words), line
    assert list(tmp_path.iterdir()) == []


def test_existing_file_is_spared(coarse, tmp_path):
    path = tmp_path / "t.h5"
    path.write_text("mine")
    result = build(*COARSE, "-o", path)
    assert result.exit_code == 2 and "--overwrite" in result.stderr
    assert path.read_text() == "mine"


def test_ctrl_c_leaves_nothing(tmp_path):
    """Ctrl-C in a build: exit 130, no file under the name and none beside it."""
    code = "from railcli.cli import main; main()"
    arguments = ["build-lut", "-o", "t.h5", "--normal", "hertz", "--y-step", "0.01", "--roll-step", "0.5"]
    with subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        time.sleep(6.0)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=300)
    assert process.returncode == 130, message
    assert list(tmp_path.iterdir()) == []


def test_table_that_falls_short_says_so(tmp_path):
    """A grid too coarse for the flange: built and written, with a warning that names figures and remedies."""
    result = build(*COARSE, "-o", tmp_path / "coarse.h5")
    assert result.exit_code == 0 and (tmp_path / "coarse.h5").exists()
    assert "Warning: contact table of ORES1002 on UIC60: p99 of " in result.stderr
    assert "--smooth 4" in result.stderr and "--accuracy" in result.stderr


HEIGHTS = ["--y-range", "3", "--roll-range", "2", "--yaw-range", "5", "--poses", "100", "-q"]


@pytest.fixture(scope="module")
def heights(tmp_path_factory):
    """A small table of heights as the command writes it, with its picture, and what it printed."""
    path = tmp_path_factory.mktemp("heights") / "table.h5"
    result = build(*HEIGHTS, "-o", path, "--plot", "--format", "json")
    assert result.exit_code == 0, result.stderr
    return path, json.loads(result.stdout)


def test_table_of_heights_is_certified_by_its_forces(heights):
    path, record = heights
    forces = record["certificate"]["forces"]
    assert record["positions"] == math.prod(tables.read(path).table.counts) and "branches" not in record["certificate"]
    assert forces["compared"] == 100 == sum(forces["by_region"].values()) and forces["refused"] == 0
    assert forces["normal_percent"]["p99"] < 4.0 and forces["centre_mm"]["p99"] < 0.5
    assert path.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_check_of_heights(heights):
    """Grid, errors, aims and limits in words; the verdict for machines."""
    text = build("--check", heights[0], "--poses", "100", "--seed", "4", "-q")
    assert text.exit_code == 0, text.stderr
    lines = text.stdout.splitlines()
    assert sum(line.startswith("Error of forces by look-up") for line in lines) == 2  # now, and when it was built
    assert sum(line.startswith("Aims of p99") for line in lines) == 2
    assert any("knots" in line and "fineness 1" in line for line in lines)
    assert lines[-1] == "Limits of p99: normal_percent 4, centre_mm 0.5: kept"
    result = build("--check", heights[0], "--poses", "100", "--seed", "4", "-q", "--format", "json")
    record = json.loads(result.stdout)
    assert record["verdict"] == "passed" and record["certificate"]["seed"] == 4
    assert record["certificate_when_built"] == heights[1]["certificate"]


def test_hertz_is_certified_by_both(coarse):
    certificate = coarse[1]["certificate"]
    assert certificate["branches"] and certificate["forces"]["compared"] == 100
    assert set(certificate["forces"]["by_region"]) <= {"tread", "root", "flank", "tip"}


def test_accuracy_of_forces(tmp_path):
    """What the first grid gives; and what closer knots do not: one line, nothing written."""
    result = build(*HEIGHTS, "--accuracy", "10", "-o", tmp_path / "t.h5", "--format", "json")
    record = json.loads(result.stdout)
    assert record["accuracy_percent"] == 10.0 and record["refinement"][-1]["error_over_allowed"] <= 1.0
    assert record["certificate"]["forces"]["normal_percent"]["p99"] <= 5.0
    text = build(*HEIGHTS, "--accuracy", "10", "-o", tmp_path / "t.h5", "--overwrite").stdout
    assert "Accuracy 10 %" in text and "fineness" in text
    result = build(*HEIGHTS, "--accuracy", "0.01", "--largest", "0.3", "-o", tmp_path / "none.h5")
    assert result.exit_code == 4 and not (tmp_path / "none.h5").exists()
    (line,) = result.stderr.splitlines()
    assert "0.01 %" in line and "--largest" in line


def test_fineness_is_kept_and_told(tmp_path):
    assert build(*HEIGHTS, "--fineness", "1.5", "--poses", "0", "-o", tmp_path / "fine.h5").exit_code == 0
    table = tables.read(tmp_path / "fine.h5").table
    assert table.settings.fineness == 1.5
    wanted = tables.Expected(*tables.profiles_of(table, ""), table.settings)
    assert "--fineness 1.5" in wanted.rebuild("t.h5")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--y-step", "0.1"], ["--y-step", "--fineness"]),
        (["--curvature-window", "1"], ["--curvature-window", "--fineness"]),
        (["--normal", "hertz", "--fineness", "2"], ["fineness", "hertz"]),
        (["--fineness", "100"], ["fineness", "0.25 ... 3"]),
    ],
)
def test_grids_that_a_law_does_not_take(arguments, words):
    result = build(*arguments)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert all(word in line for word in words), line
