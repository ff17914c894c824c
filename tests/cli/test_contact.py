"""`railcli contact` from the outside."""

import csv
import json

import pytest
from click.testing import CliRunner

from railcli.cli import main

QUICK = ["contact", "-q", "--no-roll", "--inclination", "40"]
HEADS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


def run(*arguments):
    return CliRunner().invoke(main, [str(item) for item in arguments], prog_name="railcli")


def rows(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def test_bare_command(tmp_path, monkeypatch):
    """The built-in default: tables, sentences, and a new folder with the picture."""
    monkeypatch.chdir(tmp_path)
    result = run("contact", "-q")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.startswith("ORES1002 on UIC60, inclination 1:20") and "with roll" in result.stdout
    assert "delta-r jumps by +4.340 mm at y = 5.981 mm" in result.stdout
    assert "The flank of the right wheel touches from y = 6.37 mm on." in result.stdout
    assert "At y = 6 mm the right wheel bears on 3" in result.stdout
    (folder,) = (tmp_path / "railcli-out").iterdir()
    names = {"contact.png", "contact.json", "contact.csv", "functions.csv", "patches.csv"}
    assert names <= {path.name for path in folder.iterdir()}
    contact = rows(folder / "contact.csv")
    assert [float(row["y_mm"]) for row in contact] == list(range(-10, 11))
    for row, other in zip(contact, contact[::-1], strict=True):
        assert float(row["delta_r_mm"]) == -float(other["delta_r_mm"])
        assert row["region_right"] == other["region_left"]


@pytest.mark.parametrize("picture", HEADS)
def test_folder_holds_what_is_printed(tmp_path, picture):
    folder = tmp_path / "out"
    arguments = [*QUICK, "--picture", picture, "--at=-2,5", "--load", "80", "--yaw", "5", "--left-radius", "459"]
    result = run(*arguments, "--format", "json", "-o", folder)
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert record == json.loads((folder / "contact.json").read_text())
    assert (folder / f"contact.{picture}").read_bytes().startswith(HEADS[picture])
    patches = rows(folder / "patches.csv")
    assert sorted({float(row["y_mm"]) for row in patches}) == [-2.0, 5.0]
    assert [float(row["pressure_MPa"]) for row in patches] == pytest.approx(
        [item["pressure_MPa"] for item in record["patches"]], abs=1e-6
    )
    assert record["load_kN"] == 80.0 and record["yaw_mrad"] == 5.0 and record["left_radius"] == 0.459
    assert {row["wheel"] for row in patches} == {"right", "left"}


def test_overwrite(tmp_path):
    folder = tmp_path / "out"
    assert run(*QUICK, "-o", folder).exit_code == 0
    refused = run(*QUICK, "-o", folder)
    assert refused.exit_code == 2 and "--overwrite" in refused.stderr
    assert run(*QUICK, "--curvature-window", "1.5", "-o", folder, "--overwrite").exit_code == 0


@pytest.mark.parametrize(
    "arguments, word",
    [
        (["--at", "0,11"], "--at"),
        (["--at", "nan"], "--at"),
        (["--at", "left"], "--at"),
        (["--at", ""], "--at"),
        (["--at", "0,1,2,3,4,5"], "--at"),
        (["--load", "0"], "--load"),
        (["--load", "nan"], "--load"),
        (["--yaw", "inf"], "--yaw"),
        (["--yaw", "-60"], "--yaw"),
        (["--left-radius", "4.6"], "--left-radius"),
        (["--picture", "gif"], "--picture"),
        (["--young", "0"], "young"),
        (["--poisson", "nan"], "poisson"),
        (["--wheel", "UIC60"], "UIC60"),
        (["--rail", "nowhere.csv"], "nowhere.csv"),
        (["--gauge", "1420"], "no wheelset fits"),
    ],
)
def test_bad_input_is_one_line(tmp_path, monkeypatch, arguments, word):
    monkeypatch.chdir(tmp_path)
    result = run("contact", "-q", "--no-roll", *arguments)
    assert result.exit_code == 2, result.output
    assert result.stdout == "" and word in result.stderr and "Traceback" not in result.stderr
    assert "fault of railcli" not in result.stderr and list(tmp_path.iterdir()) == []
