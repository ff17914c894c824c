"""Every built-in scenario runs to its end, and its rails carry what the motion asks for."""

from dataclasses import replace

import pytest
import scenes
import tolerances as tol

from railcli.analysis.build_table import build_table
from railcli.analysis.simulate import SteadyWindow, simulate
from railcli.analysis.steady_values import expected_forces, final_stretch, weight_along
from railcli.analysis.step_choice import with_step
from railcli.files.scenario import builtin_scenarios, load

KILO = 1e-3


@pytest.fixture(scope="module")
def wide(profiles):
    """The small table with more yaw, 19 mrad, and more play, for the tightest curve, whose gauge is wider."""
    return build_table(*profiles, replace(scenes.SMALL, y_range=20e-3, yaw_range=30e-3 * 0.4**0.5, yaw_count=5))[0]


@pytest.mark.parametrize("name", builtin_scenarios())
def test_built_in_scenario(name, wide):
    case = load(name)
    assert case.title and case.description
    case, system, _ = with_step(case, scenes.wagon(wide, name))
    window = SteadyWindow(case.distance - case.average_over)
    outcome = simulate(case, system, window)
    assert outcome.fault == ""
    stretch = final_stretch(case)
    if stretch is None or case.irregularity:
        return
    lateral, vertical = expected_forces(case, stretch)
    sums = [float(window.mean(key).sum()) * KILO for key in ("y_force", "q_force")]
    assert sums == pytest.approx([stretch.outwards * lateral * KILO, vertical * KILO], abs=tol.BALANCE_KN)
    if stretch.gradient:
        assert window.mean("traction") * KILO == pytest.approx(weight_along(case, stretch) * KILO, abs=tol.BALANCE_KN)
