"""A run begins in equilibrium, wherever its track begins."""

import pytest
import scenes
import tolerances as tol

from railcli.analysis.simulate import SteadyWindow, simulate
from railcli.errors import InputError, SimulationError
from railcli.model.sections import Gradient

CURVE = scenes.Curve(length=200.0, radius=300.0, hand="right", cant=0.1)
TRACKS = {
    "straight": ((scenes.Straight(length=200.0),), ()),
    "curve": ((CURVE,), ()),
    "left": ((CURVE.model_copy(update={"hand": "left", "cant": 0.05}),), ()),
    "wider": ((CURVE.model_copy(update={"gauge_widening": 3e-3}),), ()),
    "cant": ((scenes.Straight(length=200.0, cant=0.03),), ()),
    "gradient": ((scenes.Straight(length=200.0),), (Gradient(at=0.0, gradient=0.03),)),
    "both": ((CURVE,), (Gradient(at=0.0, gradient=-0.02),)),
}


def beginning(table, sections, gradients=(), **start):
    """Scenario of two seconds at 10 m/s, and its system."""
    groups = {"track": scenes.Track(sections), "gradients": gradients}
    groups["start"] = {"lateral": 0.0, **start}
    groups["run"] = {"speed": 10.0, "duration": 2.0, "distance": None, "step": 1e-3, "output_interval": 1e-2}
    case = scenes.load("straight-60").varied(**groups)
    return case, scenes.assemble(case, [table])


@pytest.mark.parametrize("name", TRACKS)
def test_nothing_moves(table, name):
    case, system = beginning(table, *TRACKS[name])
    window = SteadyWindow()
    outcome = simulate(case, system, window)
    assert outcome.fault == "" and outcome.jolt == ""
    assert window.peak_to_peak("q")[:, [1, 2, 3, 5]].max() < tol.BEGINNING
    assert window.peak_to_peak("q_force").max() < tol.BEGINNING_FORCE


def test_bodies_are_put_aside_on_straight_track_only(table):
    case, system = beginning(table, TRACKS["curve"][0], lateral=2e-3)
    with pytest.raises(InputError, match="begin the track with a straight"):
        simulate(case, system, SteadyWindow())


def test_a_curve_in_which_there_is_no_steady_motion(table):
    case, system = beginning(table, (CURVE.model_copy(update={"radius": 40.0}),))
    with pytest.raises(SimulationError, match="begin the track with a straight"):
        simulate(case, system, SteadyWindow())


def test_a_start_that_is_no_equilibrium_is_told(table):
    """The front of the wagon stands on a rise that begins under its middle."""
    rise = (Gradient(at=20.0, gradient=0.04, radius=1000.0),)
    case, system = beginning(table, TRACKS["straight"][0], rise)
    outcome = simulate(case, system, SteadyWindow())
    assert outcome.jolt.startswith("The run begins with a jolt of") and "at bogie 1" in outcome.jolt
