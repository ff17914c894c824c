"""`railcli validate contact` from the outside."""

import csv
import json

import pytest
from click.testing import CliRunner

from railcli.analysis import contact_check
from railcli.cli import main
from railcli.files import contact_reference
from railcli.model.submodels import CREEP_LAWS, NORMAL_LAWS

FILES = {"validation.md", "validation.json", "validation.csv"}
FIGURES = {"benchmark.png", "forces.png", "creep.png", "normal.png"}


def run(*arguments):
    arguments = ["validate", "contact", "-q", *(str(item) for item in arguments)]
    return CliRunner().invoke(main, arguments, prog_name="railcli")


def names(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


@pytest.fixture(scope="module")
def accepted(tmp_path_factory):
    """The real thing, once."""
    folder = tmp_path_factory.mktemp("contact") / "out"
    return run("-o", folder), folder


def test_report_files_and_figures(accepted):
    result, folder = accepted
    assert result.exit_code == 0, result.stderr
    assert names(folder) == FILES | FIGURES
    assert all((folder / name).read_bytes().startswith(b"\x89PNG") for name in FIGURES)
    assert "Verdict: accepted" in result.stdout and str(folder) in result.stdout
    report = (folder / "validation.md").read_text(encoding="utf-8")
    assert all(f"({name})" in report for name in FIGURES)
    assert all(line in report for line in result.stdout.splitlines() if line.startswith("  "))


def test_machine_readable_results(accepted):
    _, folder = accepted
    record = json.loads((folder / "validation.json").read_text(encoding="utf-8"))
    assert record["verdict"] == "accepted"
    assert all(row["kept"] == (row["found"] <= row["limit"]) for row in record["criteria"])
    assert all(row["kept"] for row in record["criteria"] if row["counts"])
    assert set(CREEP_LAWS) <= set(record["creep_laws"])
    values = record["benchmark"]
    combinations = {(row["normal_law"], row["creep_law"]) for row in values}
    assert combinations == {(normal, law) for normal in NORMAL_LAWS for law in CREEP_LAWS}
    assert {row["y_mm"] for row in values} == {0.0, 0.5, *map(float, range(1, 11))}
    place = {"creep_law": "hard", "normal_law": "hertz", "y_mm": 4.0, "wheel": "right", "quantity": "on_rail"}
    (row,) = [row for row in values if place.items() <= row.items()]
    assert row["contact"] == pytest.approx(-21.79) and row["unit"] == "mm"
    assert row["deviation"] == pytest.approx(row["railcli"] - row["contact"])
    assert record["known_spread"]["area"] == [-0.42, 0.0]
    states = record["normal_states"]
    assert {row["normal_law"] for row in states} == {"elements", *NORMAL_LAWS}
    assert len(states) == 174 * (1 + len(NORMAL_LAWS))
    rows = list(csv.DictReader((folder / "validation.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == len(values)
    assert float(rows[7]["railcli"]) == pytest.approx(values[7]["railcli"], rel=1e-5)


def test_rejected_is_exit_code_4_with_all_files(monkeypatch, tmp_path):
    criteria = contact_reference.contact_criteria()
    criteria["benchmark"]["position_mm"] = 0.001
    monkeypatch.setattr(contact_reference, "contact_criteria", lambda: criteria)
    monkeypatch.setattr(contact_check, "CREEP_LAWS", {"hard": CREEP_LAWS["hard"]})
    monkeypatch.setattr("railcli.studies.tables.NORMAL_LAWS", {"hertz": NORMAL_LAWS["hertz"]})
    folder = tmp_path / "out"
    result = run("--no-figures", "--format", "json", "-o", folder)
    assert result.exit_code == 4
    record = json.loads(result.stdout)
    assert record["verdict"] == "rejected"
    assert json.loads((folder / "validation.json").read_text(encoding="utf-8")) == record
    wanted = "Error: validate contact: rejected (A-2.2, hertz and hard: position [mm], 2 to 10 mm)\n"
    assert result.stderr == wanted
    assert names(folder) == FILES
    assert "Verdict: rejected" in (folder / "validation.md").read_text(encoding="utf-8")


def test_existing_folder_is_refused_and_left_alone(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    for arguments in (["-o", folder], ["-o", folder, "--overwrite"]):
        result = run("--no-figures", *arguments)
        assert (result.exit_code, result.stdout) == (2, "")
        assert str(folder) in result.stderr and result.stderr.count("\n") == 1
    assert names(folder) == {"notes.txt"}


def test_ctrl_c_leaves_nothing(monkeypatch, tmp_path):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(contact_check, "compare_contact", interrupted)
    assert run("-o", tmp_path / "out").exit_code == 130
    assert not (tmp_path / "out").exists()


PRINTED = {
    name: contact_reference.resource(f"benchmarks/contact/{name}").read_text(encoding="utf-8")
    for name in ("reference/a22.csv", "reference/hertz.csv", "reference/normal.csv", "accept.toml")
}


@pytest.mark.parametrize(
    "name, text",
    [
        ("reference/a22.csv", PRINTED["reference/a22.csv"].replace("-41.49", "-41.49 mm")),
        ("reference/a22.csv", PRINTED["reference/a22.csv"].replace("-41.49,", "")),
        ("reference/a22.csv", PRINTED["reference/a22.csv"].replace("y_mm,", "y,")),
        ("reference/hertz.csv", PRINTED["reference/hertz.csv"].replace("10000,", "ten,", 1)),
        ("reference/hertz.csv", ""),
        ("reference/normal.csv", PRINTED["reference/normal.csv"].replace("touch_um", "touch")),
        ("accept.toml", "[hertz]\nrelative = \n"),
    ],
    ids=["unit in a cell", "cell missing", "other column", "word", "empty", "own states", "criteria malformed"],
)
def test_broken_reference_is_one_line(tmp_path, monkeypatch, name, text):
    bundled = contact_reference.resource
    broken = tmp_path / "broken"

    def resource(relative):
        if not relative.endswith(name):
            return bundled(relative)
        broken.write_text(text, encoding="utf-8")
        return broken

    monkeypatch.setattr(contact_reference, "resource", resource)
    result = run("-o", tmp_path / "out")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"Error: {broken}: is not the file that came with railcli")
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
