"""`railcli conicity` and `railcli validate conicity` from the outside."""

import csv
import json
from pathlib import Path

import pytest
import tolerances as tol
from click.testing import CliRunner

from railcli.cli import main

SAMPLES = Path(__file__).parents[1] / "data" / "samples"
QUICK = ["conicity", "-q", "--inclination", "40", "--amplitude", "2,3"]


def run(*arguments):
    return CliRunner().invoke(main, [str(item) for item in arguments], prog_name="railcli")


def test_table_on_stdout_and_nothing_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*QUICK)
    assert result.exit_code == 0, result.stderr
    assert "inclination 1:40" in result.stdout and "0.180" in result.stdout
    assert list(tmp_path.iterdir()) == []


def test_folder_and_json_hold_the_same_numbers(tmp_path):
    folder = tmp_path / "out"
    result = run(*QUICK, "--format", "json", "--plot", "-o", folder)
    assert result.exit_code == 0, result.stderr
    printed, stored = json.loads(result.stdout), json.loads((folder / "conicity.json").read_text())
    assert printed == stored
    rows = list(csv.DictReader((folder / "conicity.csv").read_text().splitlines()))
    assert [float(row["amplitude_mm"]) for row in rows] == [2.0, 3.0]
    for row, item in zip(rows, printed["amplitudes"], strict=True):
        assert abs(float(row["conicity"]) - item["conicity"]) < 1e-6
    y = [float(row["y_mm"]) for row in csv.DictReader((folder / "functions.csv").read_text().splitlines())]
    assert y == sorted(y) and y[0] == -3.0 and y[-1] == 3.0
    assert (folder / "conicity.png").read_bytes().startswith(b"\x89PNG")
    assert run(*QUICK, "-o", folder).exit_code == 2
    assert run(*QUICK, "-o", folder, "--overwrite").exit_code == 0


def test_beyond_the_flange_is_said():
    result = run("conicity", "-q", "--amplitude", "5,8")
    assert "beyond the flange" in next(line for line in result.stdout.splitlines() if line.startswith("  8 "))
    assert "beyond" not in next(line for line in result.stdout.splitlines() if line.startswith("  5 "))


def test_quasi_elastic_points_beside_rigid_ones(tmp_path):
    """Pressed in, the wheel's jump in the root becomes a fast motion; on the tread delta-r is that of rigid points."""
    common = ("conicity", "-q", "--amplitude", "2,7", "--format", "json")
    rigid, pressed = (json.loads(run(*common, *more).stdout) for more in ((), ("--pressed", "0.2")))
    assert "rigid" not in rigid and pressed["settings"]["pressed"] == pytest.approx(0.2e-3)
    found = pressed["rigid"]
    assert found["jumps"]["rigid"] == len(rigid["jumps"]) > found["jumps"]["quasi_elastic"] == len(pressed["jumps"])
    assert abs(found["largest_change_mm"]) > 1.0 and found["at_y_mm"] > 6.0
    assert found["share_of_y_changed_by_10_um"] < 0.2
    on_tread = [record["amplitudes"][0]["conicity"] for record in (rigid, pressed)]
    assert on_tread[0] == pytest.approx(on_tread[1], rel=0.01)
    text = run(*common[:4], "--pressed", "0.2").stdout
    assert "pressed in by 0.2 mm" in text and "Quasi-elastic against rigid contact points" in text
    assert run(*common, "--pressed", "5").exit_code == 2


def test_unlike_sides_and_range():
    unlike = ["--left-rail", "60E1", "--left-radius", "459.9"]
    result = run("conicity", "-q", *unlike, "--amplitude", "1-2:0.5", "--format", "json")
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert [item["amplitude_mm"] for item in record["amplitudes"]] == pytest.approx([1.0, 1.5, 2.0])
    assert all(item["centre_mm"] != 0.0 for item in record["amplitudes"])


@pytest.mark.parametrize(
    "arguments, word",
    [
        (["--amplitude", "0-5"], "--amplitude"),
        (["--amplitude", "5-1"], "--amplitude"),
        (["--amplitude", "1-10:0"], "--amplitude"),
        (["--amplitude", "1-2-3"], "--amplitude"),
        (["--amplitude", "x"], "--amplitude"),
        (["--amplitude", ""], "--amplitude"),
        (["--curve", "-300"], "--curve"),
        (["--curve", "nan"], "--curve"),
        (["--left-radius", "4.6"], "--left-radius"),
        (["--gauge", "nan"], "gauge"),
        (["--wheel", "UIC60"], "UIC60"),
        (["--rail", "nowhere.csv"], "nowhere.csv"),
        (["--gauge", "1420"], "no wheelset fits"),
    ],
)
def test_bad_input_is_one_line(arguments, word):
    result = run("conicity", "-q", *arguments)
    assert result.exit_code == 2, result.output
    assert result.stdout == "" and word in result.stderr and "Traceback" not in result.stderr


def test_inclined_rail_is_not_inclined_twice(tmp_path):
    """The rail of the Manchester benchmark is UIC60 as it stands at 1:40."""
    rail = tmp_path / "rail.csv"
    nominal = json.loads(run(*QUICK, "--format", "json").stdout)["amplitudes"]
    for word in ("included", None):
        option = ["--inclination", word] if word else []
        arguments = ["profile", "import", SAMPLES / "MBench_UIC60_v3.prr", *option, "-o", rail, "--overwrite"]
        assert run(*arguments).exit_code == 0
        result = run("conicity", "-q", "--rail", rail, "--amplitude", "2,3", "--format", "json")
        found = [item["conicity"] for item in json.loads(result.stdout)["amplitudes"]]
        if word:
            assert result.stderr == ""
            assert found == pytest.approx([item["conicity"] for item in nominal], rel=tol.SAME_RAIL_CONICITY)
        else:
            assert "its head leans by 1.25 degrees" in result.stderr and result.stderr.count("\n") == 1
            assert max(found) < 0.01
        refused = run("conicity", "-q", "--rail", rail, "--amplitude", "3", "--inclination", "40")
        assert refused.exit_code == (2 if word else 0)
        assert ("leave out inclination 40" in refused.stderr) == bool(word)


def test_validate_conicity(tmp_path):
    folder = tmp_path / "v"
    result = run("validate", "conicity", "-q", "-o", folder)
    assert result.exit_code == 0, result.stderr
    assert "Verdict: accepted" in result.stdout and "cone 1:20" in result.stdout
    record = json.loads((folder / "validation.json").read_text())
    assert record["verdict"] == "accepted"
    assert {row["name"] for row in record["criteria"] if row["counts"] and not row["kept"]} == set()
    assert (folder / "validation.csv").exists() and (folder / "conicity.png").exists()


def test_validate_conicity_can_fail(tmp_path, monkeypatch):
    """With a stricter limit the same comparison is rejected with exit code 4."""
    from railcli.files import conicity_reference

    strict = conicity_reference.conicity_criteria()
    strict["conicity"]["away_from_jumps"] = 1e-6
    monkeypatch.setattr(conicity_reference, "conicity_criteria", lambda: strict)
    result = run("validate", "conicity", "-q", "--no-figures", "-o", tmp_path / "v")
    assert result.exit_code == 4
    assert "Verdict: rejected" in result.stdout and "rejected" in result.stderr
    assert not (tmp_path / "v" / "conicity.png").exists()
