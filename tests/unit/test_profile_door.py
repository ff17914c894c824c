"""Profiles as instruments and other programs write them, given where a canonical file is expected."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tolerances as tol
from click.testing import CliRunner
from numpy.testing import assert_allclose

from railcli.cli import main
from railcli.errors import InputError
from railcli.files.formats import read_points
from railcli.files.profile_import import ImportSettings, convert, import_profile
from railcli.files.profiles import load_profile
from railcli.files.scenario import load

SAMPLES = Path(__file__).parents[1] / "data" / "samples"
WHEELS = ["Car7216_0001r", "avg_wheel", "left-wheel-v1-pre-dry", "whl_left_iter288"]
RUN = "[run]\nspeed_m_per_s = 20\ndistance_m = 12\n[[track]]\nkind = 'straight'\nlength_m = 200\n"


@pytest.mark.parametrize(("name", "kind"), [("avg_wheel.whl", "wheel"), ("avg_low2.ban", "rail"),
                                            ("MBench_UIC60_v3.prr", "rail")])  # fmt: skip
def test_a_raw_file_is_imported_and_that_is_said(name, kind, caplog):
    """The same profile as `profile import` gives by default, and one line to the logger."""
    caplog.set_level("INFO", "railcli")
    found = load_profile(SAMPLES / name, kind)
    assert found.digest() == import_profile(SAMPLES / name, ImportSettings(kind=kind)).profile.digest()
    (line,) = caplog.messages
    assert line.startswith(f"Imported {SAMPLES / name} (") and "with default decisions: units mm" in line
    assert "`railcli profile import` tells all" in line


def test_scenarios_and_commands_take_raw_files(tmp_path):
    for name in ("avg_wheel.whl", "avg_low2.ban"):
        shutil.copy(SAMPLES / name, tmp_path)
    case = tmp_path / "case.toml"
    case.write_text(RUN + "[contact]\nwheel_profile = 'avg_wheel.whl'\nrail_profile = 'avg_low2.ban'\n")
    assert {profile.kind for profile in load(case).contents.values()} == {"wheel", "rail"}
    raw_file, done_file = str(tmp_path / "avg_wheel.whl"), str(tmp_path / "w.csv")
    raw = CliRunner().invoke(main, ["conicity", "--wheel", raw_file, "--amplitude", "3", "-q"])
    assert raw.exit_code == 0 and "Imported" in raw.stderr
    assert CliRunner().invoke(main, ["profile", "import", raw_file, "-o", done_file]).exit_code == 0
    by_hand = CliRunner().invoke(main, ["conicity", "--wheel", done_file, "--amplitude", "3", "-q"])
    assert by_hand.stdout.splitlines()[1:] == raw.stdout.splitlines()[1:] and by_hand.stderr == ""


def test_a_text_file_that_needs_decisions_names_the_command(tmp_path):
    """Mirrored points are not turned without a word; where import can do it, the error says so."""
    profile = load_profile("ORES1002", "wheel")
    path = tmp_path / "mirrored wheel.csv"
    np.savetxt(path, np.column_stack([-1e3 * profile.y, 1e3 * profile.z]))
    with pytest.raises(InputError, match="multiply y by -1; or convert it: `railcli profile import '.*wheel.csv'`"):
        load_profile(path, "wheel")
    path.write_text("1 2\n3 4\n")
    with pytest.raises(InputError, match="only 2 points; a profile needs at least 10$"):
        load_profile(path, "wheel")


@pytest.mark.parametrize("name", WHEELS)
def test_a_wheel_that_stands_turned_is_noticed(name):
    """By two degrees either way; none of the samples as it is."""
    measured = read_points(SAMPLES / f"{name}.whl")

    def warned(degrees):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        turned = replace(measured, y=c * measured.y - s * measured.z, z=s * measured.y + c * measured.z)
        account = convert(turned, ImportSettings(kind="wheel")).account
        return [one["reason"] for one in account["decisions"] if one["choice"] == "turned?"]

    assert not warned(0.0)
    assert len(warned(2.0)) == len(warned(-2.0)) == 1 and "mm/m from 10 to 40 mm" in warned(2.0)[0]


def miniprof(change):
    text = (SAMPLES / "avg_wheel.whl").read_text()
    head, rows = text.replace("\r\n", "\n").split("\n\n", 1)
    return change(head, rows)


NUMBERS_IN_TEXT = {
    "words alone": lambda head, rows: f"{head}\n\n{rows}",
    "a line of numbers": lambda head, rows: f"MINIPROF 2020\n32.58 37.11 14.71\n(Sd/Sh/qR)\n\n{rows}",
    "several": lambda head, rows: f"MINIPROF\n1 2 3\n4 5\n\n\n{rows}",
    "decimal commas": lambda head, rows: f"Filename=x\nColumnDef=X,Y,A\n\n{rows.replace('.', ',')}",
    "tabs, decimal commas": lambda head, rows: "ColumnDef=X,Y,A\n\n" + "\n".join(
        "\t".join(row.split()) for row in rows.replace(".", ",").splitlines()),
    "no empty line": lambda head, rows: f"MINIPROF 2020\n32.58 37.11 14.71 (Sd/Sh/qR)\n{rows}",
    "an empty line among the points": lambda head, rows: "\n\n".join(
        ("\n".join(rows.splitlines()[:40]), "\n".join(rows.splitlines()[40:]))),
}  # fmt: skip


@pytest.mark.parametrize("way", NUMBERS_IN_TEXT)
def test_ways_of_miniprof(tmp_path, way):
    """The same points, whatever stands before them and however decimals are marked."""
    wanted = read_points(SAMPLES / "avg_wheel.whl")
    path = tmp_path / "a.whl"
    path.write_text(miniprof(NUMBERS_IN_TEXT[way]))
    found = read_points(path)
    assert_allclose(found.y, wanted.y, atol=tol.ROUNDING)
    assert_allclose(found.z, wanted.z, atol=tol.ROUNDING)
