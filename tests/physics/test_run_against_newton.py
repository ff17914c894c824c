"""Where time runs come to rest and where Newton's method finds the steady motion: the same, from 0.2 to 90 m/s.

`benchmarks/steady/run.py` runs the whole grid (docs/theory.md, section 9).
"""

from dataclasses import replace

import pytest
import scenes
import tolerances as tol

from benchmarks.steady.run import Case, against_newton
from railcli.analysis.build_table import build_table
from railcli.analysis.simulate import SteadyWindow, simulate
from railcli.files.scenario import load
from railcli.model.system import assemble

STABLE = [  # law, friction, radius, speed, step [ms], from the straight
    ("table", 0.3, 300.0, 0.5, 1.0, True),
    ("table", 0.3, 300.0, 1.0, 1.0, False),
    ("table", 0.3, 300.0, 4.0, 1.0, True),
    ("hard", 0.6, 1200.0, 1.0, 0.5, False),
    ("hard", 0.3, 300.0, 0.5, 1.0, False),
    ("smooth", 0.1, 150.0, 0.5, 1.0, False),
    ("polach", 0.1, 300.0, 2.0, 1.0, False),
    ("fastsim", 0.3, 300.0, 4.0, 1.0, False),
    ("table", 0.3, 1200.0, 45.0, 1.0, False),
    ("table", 0.1, 5000.0, 90.0, 1.0, False),
]
SLOW = """
vehicle = "manchester"
[run]
speed_m_per_s = 2
step_ms = 0.5
average_over_m = 5
[contact]
creep_law = "table"
[[track]]
kind = "straight"
length_m = 10
[[track]]
kind = "transition"
length_m = 20
shape = "bloss"
[[track]]
kind = "curve"
length_m = 30
radius_m = 300
hand = "right"
cant_mm = 50
"""


@pytest.fixture(scope="module")
def wide_table(profiles):
    """Over the yaw that R = 150 m takes."""
    return build_table(*profiles, replace(scenes.SMALL, yaw_range=20e-3))[0]


@pytest.mark.parametrize("law, friction, radius, speed, step, into", STABLE)
def test_a_run_ends_where_newton_says(wide_table, law, friction, radius, speed, step, into):
    """No wheel force alternates from step to step, and the linearised model agrees that this motion is stable."""
    found = against_newton(Case(law, friction, radius, speed, 1e-3 * step, into), [wide_table])
    assert not found.fault
    assert found.alternation < tol.NO_ALTERNATION
    assert found.lateral < tol.RUN_PLACE
    assert found.force < tol.RUN_FORCE
    assert into or found.growth < 0.0


def test_a_motion_that_vibrates_is_unstable(wide_table):
    """R = 150 m, friction 0.3, 0.5 m/s: flange contact swings at the frequency of the root that grows."""
    found = against_newton(Case("table", 0.3, 150.0, 0.5, 1e-3), [wide_table])
    assert found.growth > 1.0
    assert found.swing > 100.0
    assert found.frequency == pytest.approx(found.at, abs=tol.SMALL_CYCLE_HZ)


def test_two_metres_per_second_in_300_m(wide_table, tmp_path):
    """W1 presses the outer rail with 20.03 kN, W2 runs 4.70 mm inside; a step that alternates gives 13.95 and 5.74."""
    (tmp_path / "slow.toml").write_text(SLOW)
    case = load(tmp_path / "slow.toml")
    system = assemble(case, [wide_table])
    window = SteadyWindow(case.distance - case.average_over)
    assert not simulate(case, system, window).fault
    assert -1e-3 * window.mean("y_force")[1] == pytest.approx(20.03, abs=tol.SLOW_CURVE_KN)
    assert -1e3 * window.mean("q")[system.wheelsets[1], 1] == pytest.approx(-4.70, abs=tol.SLOW_CURVE_MM)
