"""`railcli validate curves` from the outside."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner

from railcli.analysis import curves_check
from railcli.analysis.curving_check import KINDS, NOMINAL, UPPER_END, Curve, judge, variations
from railcli.analysis.decay_check import HUNTING, Wagon
from railcli.analysis.decay_check import judge as judge_wagon
from railcli.cli import main
from railcli.files import curves_reference
from railcli.model.submodels import CREEP_LAWS, NORMAL_LAWS

FILES = {"validation.md", "validation.json", "validation.csv"}
FIGURES = {"curve-150.png", "cooperrider.png"}


def run(*arguments):
    arguments = ["validate", "curves", "-q", *(str(item) for item in arguments)]
    return CliRunner().invoke(main, arguments, prog_name="railcli")


def names(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def invented(shift=0.1, rate=0.0):
    """A comparison without a run: values beside ADAMS by a shift, decay rates beside the published ones."""

    def compare(references, criteria, curve, wagon, wheelset, wide, tables_of, progress):
        progress(0.5, "half")
        codes, decays = references.codes, references.decays
        values = np.where(np.isnan(codes.values[:, 1]), codes.values[:, 0], codes.values[:, 1])
        curves = {
            name: Curve(case, values + shift, (-23.0, -23.0), (436.0, 436.0))
            for name, case in variations(curve).items()
        }
        curves["none found"] = Curve(curve, np.full(values.size, np.nan), (np.nan, -23.0), (np.nan, 436.0))
        ones = np.ones(len(HUNTING))
        contact = np.column_stack([decays.on_wheel, decays.radius, decays.angle])
        found = Wagon(
            wagon, decays.swing, ones, ones, decays.rate + rate, decays.frequency, decays.rate, (110.0, np.nan), contact
        )  # fmt: skip
        rows = judge(criteria["curve_150"], codes, curves) + judge_wagon(criteria["cooperrider"], decays, found)
        wide = {"creep hard, normal hertz": {"rms_simulink_mm": 0.6, "rms_adams_mm": 0.7, "max_mm": 1.3}}
        return curves_check.Outcome(references, curves, found, wide, rows)

    return compare


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr("railcli.analysis.warm.warm", lambda announce: None)
    monkeypatch.setattr(curves_check, "compare_curves", invented())


def test_values_deviations_and_verdict(quick, tmp_path):
    folder = tmp_path / "out"
    result = run("--no-figures", "--format", "json", "-o", folder)
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert json.loads((folder / "validation.json").read_text(encoding="utf-8")) == record
    assert names(folder) == FILES
    assert record["verdict"] == "accepted"
    for row in record["curve_150"]:
        code = row["um"] if row["adams"] is None else row["adams"]
        assert row["railcli"] == pytest.approx(code + 0.1)
        assert row["unit"] == KINDS[row["quantity"][0]]
    assert len(record["curve_150"]) == 28
    found = {row["name"]: row for row in record["criteria"]}
    assert found["R 150 m: y from the nearer code [mm]"]["found"] == pytest.approx(0.1)
    assert found["R 150 m: Y from the nearer code [kN]"]["limit"] == pytest.approx(1.3 + 0.15)
    assert not found["R 150 m: Q from the nearer code [kN]"]["counts"]
    assert found[f"R 150 m: Q from the nearer code, {UPPER_END} [kN]"]["counts"]
    assert found["Cooperrider: conicity of the wheels"]["found"] == 0.0
    assert [row["speed_m_per_s"] for row in record["cooperrider"]["decay"]] == [100.0, 105.0, 110.0]
    assert record["cooperrider"]["critical_m_per_s"] == {"its_moments": 110.0, "right_moments": None}
    rows = list(csv.DictReader((folder / "validation.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["adams"] for row in rows].count("") == 1 and len(rows) == 28


def test_text_and_figures(quick, tmp_path):
    folder = tmp_path / "out"
    result = run("-o", folder)
    assert result.exit_code == 0, result.stderr
    assert names(folder) == FILES | FIGURES
    assert all((folder / name).read_bytes().startswith(b"\x89PNG") for name in FIGURES)
    assert "Verdict: accepted (8 of 8" in result.stdout and str(folder) in result.stdout
    assert "nan" not in result.stdout
    text = (folder / "validation.md").read_text(encoding="utf-8")
    assert all(f"({name})" in text for name in FIGURES)
    assert all(line in text for line in result.stdout.splitlines() if line.startswith("  "))


@pytest.mark.parametrize(
    "shift, rate, missed",
    [(0.7, 0.0, "R 150 m: y from the nearer code"), (0.0, 0.5, "Cooperrider: decay rate")],
    ids=["displacements", "decay"],
)
def test_rejected_is_exit_code_4_with_all_files(monkeypatch, quick, tmp_path, shift, rate, missed):
    monkeypatch.setattr(curves_check, "compare_curves", invented(shift, rate))
    result = run("--no-figures", "-o", tmp_path / "out")
    assert result.exit_code == 4
    assert result.stderr.startswith("Error: validate curves: rejected (") and missed in result.stderr
    assert names(tmp_path / "out") == FILES


def test_laws_of_both_comparisons_are_an_option(monkeypatch, quick, tmp_path):
    taken = {}

    def spy(references, criteria, curve, wagon, *rest):
        taken.update(curve=curve.contact, wagon=wagon.contact)
        return invented()(references, criteria, curve, wagon, *rest)

    monkeypatch.setattr(curves_check, "compare_curves", spy)
    assert run("--no-figures", "--creep-law", "hard", "--normal", "hertz", "-o", tmp_path / "out").exit_code == 0
    for contact in taken.values():
        assert (contact.creep_law, contact.normal) == ("hard", "hertz")


@pytest.mark.parametrize("option", ["--creep-law", "--normal"])
def test_unknown_law_is_one_line(quick, tmp_path, option):
    result = run(option, "herz", "-o", tmp_path / "out")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert option in result.stderr and "herz" in result.stderr
    assert not (tmp_path / "out").exists()


def test_each_variation_changes_one_thing_the_table_leaves_open():
    curve = curves_reference.curves_scenarios()[0]
    found = variations(curve)
    assert found.pop(NOMINAL) is curve
    for name, case in found.items():
        changed = [key for key in type(curve.contact).model_fields
                   if getattr(case.contact, key) != getattr(curve.contact, key)]  # fmt: skip
        assert len(changed) == (0 if name == UPPER_END else 1), name
        assert (case.vehicle != curve.vehicle) == (name == UPPER_END)
    laws = {(case.contact.creep_law, case.contact.normal) for case in (curve, *found.values())}
    assert {law for law, _ in laws} == set(CREEP_LAWS) and {law for _, law in laws} == set(NORMAL_LAWS)


@pytest.mark.parametrize(
    "name, change",
    [
        ("curve_150.csv", ("y,1,6.9,7.2", "y,1,6.9 mm,7.2")),
        ("decay.csv", ("rate_1_per_s", "rate")),
        ("contact_table.csv", ("angle_rad", "angle_deg")),
        ("accept.toml", ("rounding = 0.15", "rounding =")),
    ],
    ids=["unit in a cell", "column renamed", "other unit", "criteria malformed"],
)
def test_broken_reference_is_one_line(tmp_path, monkeypatch, quick, name, change):
    bundled = curves_reference.resource

    def resource(relative):
        if not str(relative).endswith(name):
            return bundled(relative)
        text = bundled(relative).read_text(encoding="utf-8")
        assert change[0] in text
        (tmp_path / name).write_text(text.replace(*change), encoding="utf-8")
        return tmp_path / name

    monkeypatch.setattr(curves_reference, "resource", resource)
    result = run("-o", tmp_path / "out")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert "is not the file that came with railcli" in result.stderr
    assert not (tmp_path / "out").exists()
