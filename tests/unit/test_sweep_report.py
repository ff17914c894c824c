"""Indices, figures and page of parameter studies; the study as Python users ask for it."""

import importlib.util
from pathlib import Path

import numpy as np
import pandas
import pytest
import scenes
from tolerances import ISHIGAMI, ISHIGAMI_BY_BALANCE

import railcli
from railcli.analysis.design import Design
from railcli.files import tables
from railcli.model.study import Study
from railcli.report import sensitivity, sweep_figures, sweep_page
from railcli.report.sweep import lines

EXAMPLE = Path(__file__).parents[2] / "examples/sweep/curve-speed.toml"
needs_salib = pytest.mark.skipif(
    importlib.util.find_spec("SALib") is None, reason="needs SALib: pip install 'railcli[sensitivity]'"
)


def sampled(method, count):
    """A study of three angles and a table of Ishigami's function of them (a = 7, b = 0.1)."""
    angle = {"distribution": "uniform", "min": -np.pi, "max": np.pi}
    study = Study.model_validate(
        {
            "name": "ishigami", "vary": [{"key": f"k.x{i}", **angle} for i in (1, 2, 3)],
            "sample": {"method": method, "count": count},
        }, by_alias=True, by_name=False,
    )  # fmt: skip
    design = Design(study)
    table = pandas.DataFrame([design.point(number) for number in range(design.count)])
    x1, x2, x3 = (table[f"k.x{i}"].to_numpy() for i in (1, 2, 3))
    table.insert(0, "run", range(len(table)))
    table["steady.f"] = np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)
    table["steady.constant"] = 3.0
    for name, value in {"status": "done", "verdict": "", "cause": "", "cpu_s": 0.1, "time_s": 0.1}.items():
        table[name] = value
    return study, design, table


def closed_form(a=7.0, b=0.1):
    """First-order and total indices of Ishigami's function (Saltelli et al. 2000)."""
    v1 = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2
    v2, v13 = a * a / 8.0, b * b * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = v1 + v2 + v13
    return np.array([v1, v2, 0.0]) / whole, np.array([v1 + v13, v2, v13]) / whole


@needs_salib
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_sobol_indices_are_those_of_a_known_function():
    study, design, table = sampled("sobol-indices", 1024)
    found = sensitivity.indices(study, design, table, ["steady.f", "steady.constant"])
    assert list(found) == ["steady.f"]
    first, total = closed_form()
    np.testing.assert_allclose(found["steady.f"].first, first, atol=ISHIGAMI)
    np.testing.assert_allclose(found["steady.f"].total, total, atol=ISHIGAMI)
    table.loc[7, "steady.f"] = np.nan  # its block counts no more
    again = sensitivity.indices(study, design, table, ["steady.f"])["steady.f"]
    assert again.rows == len(table) - 5
    np.testing.assert_allclose(again.first, first, atol=ISHIGAMI)


@needs_salib
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_other_samples_give_first_order_indices():
    study, design, table = sampled("latin-hypercube", 4000)
    found = sensitivity.indices(study, design, table, ["steady.f"])["steady.f"]
    np.testing.assert_allclose(found.first, closed_form()[0], atol=ISHIGAMI_BY_BALANCE)
    assert found.total is None


def test_a_study_without_salib_says_what_brings_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "SALib", None)
    study, design, table = sampled("latin-hypercube", 8)
    with pytest.raises(railcli.InputError, match="needs SALib, which is not installed; .*sensitivity"):
        sensitivity.indices(study, design, table, ["steady.f"])


def gridded(*vary, seeds=None):
    study = Study.model_validate(
        {"name": "grid", "title": "A <grid> & $more$", "vary": list(vary), **({"seeds": seeds} if seeds else {})},
        by_alias=True, by_name=False,
    )  # fmt: skip
    design = Design(study)
    table = pandas.DataFrame([design.point(number) for number in range(design.count)])
    table.insert(0, "run", range(len(table)))
    table["steady.f"] = np.linspace(0.0, 1.0, len(table))
    table.loc[0, "steady.f"] = np.nan
    table["status"], table["verdict"], table["cause"] = "done", "pass", ""
    table.loc[0, ["status", "verdict", "cause"]] = "failed", "", "<derailed> at 3 m"
    table["cpu_s"] = table["time_s"] = 0.1
    return study, design, table


SPEED = {"key": "run.speed_kmh", "values": [60, 70, 80]}
PROFILE = {"key": "contact.wheel_profile", "values": ["a.csv", "_$b.csv"]}
MASS = {"key": "vehicle.body[1].mass_t", "from": 20.0, "to": 30.0, "count": 3}


@pytest.mark.parametrize(
    "given, names",
    [
        (gridded(SPEED), ["response"]),
        (gridded(PROFILE, seeds=3), ["response"]),
        (gridded(SPEED, PROFILE), ["response", "map"]),
        (gridded(SPEED, PROFILE, MASS), ["scatter"]),
        (sampled("random", 20), ["scatter"]),
    ],
)
def test_a_study_is_drawn_by_what_it_varies(given, names, tmp_path):
    study, design, table = given
    figures = sweep_figures.figures(study, design, table, {})
    assert [one.name for one in figures] == names
    for one in figures:
        one.write(tmp_path / f"{one.name}.png")
        assert (tmp_path / f"{one.name}.png").stat().st_size > 5000


def test_the_page_escapes_what_users_and_runs_say():
    study, design, table = gridded(SPEED, PROFILE)
    scenario = railcli.load("curve-300").model
    page = sweep_page.render(study, scenario, design, table, {}, [], ["rows.csv"], "1", "today")
    assert "A &lt;grid&gt; &amp; $more$" in page and "&lt;derailed&gt; at 3 m" in page and "<derailed>" not in page
    text = "\n".join(lines(study, scenario, design, table, {}))
    assert "5 of 6 done, 1 failed" in text and "1 (run 0): <derailed> at 3 m" in text


@pytest.fixture(scope="module")
def curve(table, tmp_path_factory):
    folder = tmp_path_factory.mktemp("curve")
    tables.save(table, folder / "table.h5")
    text = scenes.SHORT_CURVE.format(table=folder / "table.h5", friction=0.3, interval=10.0)
    (folder / "curve.toml").write_text(text)
    return folder / "curve.toml"


def test_the_door_makes_a_study_of_a_scenario(curve, tmp_path):
    scenario = railcli.load(curve)
    told = []
    asked = {"outputs": ["steady.*"], "workers": 0}
    values = {"friction": np.array([0.2, 0.3])}
    found = railcli.sweep(scenario, None, lambda *step: told.append(step), vary=values, **asked)
    assert list(found.frame["friction"]) == [0.2, 0.3] and found.folder is None and found["folder"] is None
    assert found.frame["steady.W1_y_mm"][0] == railcli.steady(scenario.replace(friction=0.2))["lateral_mm"][0]
    assert ("Sweep", 1.0, "") in told
    drawn = {"friction": {"distribution": "uniform", "min": 0.2, "max": 0.3}}
    kept = railcli.sweep(str(curve), tmp_path / "kept", vary=drawn, sample={"count": 4}, **asked)
    assert kept.folder == tmp_path / "kept" and kept.frame["friction"].between(0.2, 0.3).all()
    with pytest.raises(railcli.InputError, match="give a list of values or a dict"):
        railcli.sweep(scenario, vary={"friction": 0.2})


def test_the_example_is_a_study_whose_runs_can_be_made(tmp_path, monkeypatch):
    """Its first points, on the table of the default laws."""
    found = railcli.sweep(str(EXAMPLE), sample={"count": 2}, workers=0, figures=True)
    assert len(found.frame) == 8 and found["done"] == 8
    stiffness = found.frame["vehicle.joint[primary suspension].bushing[primary spring].stiffness_N_per_m[1]"]
    assert stiffness.nunique() == 2 and stiffness.between(15e6, 60e6).all()
    assert found.frame.groupby("run.speed_kmh")["steady.W1_sum_Y_kN"].mean().is_monotonic_increasing


def test_the_longitudinal_stiffness_moves_the_yaw(tmp_path):
    """What a key inside a list reaches: a softer primary suspension steers better."""
    key = "vehicle.joint[primary suspension].bushing[primary spring].stiffness_N_per_m[1]"
    found = railcli.sweep("curve-1200-45", vary={key: [3e6, 31.391e6]}, outputs=["steady.W1_yaw_mrad"], workers=0)
    soft, stiff = found.frame["steady.W1_yaw_mrad"]
    assert abs(soft) < abs(stiff)
