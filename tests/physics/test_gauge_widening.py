"""Gauge widening: the inner rail stands aside, and the contact meets it there."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import build_table
from railcli.analysis.equilibrium import steady, touching_depth
from railcli.files.scenario import load
from railcli.model import rails
from railcli.model.sections import Curve, Straight, Transition
from railcli.model.system import assemble
from railcli.model.track import Track

ASIDE = 2e-3  # of each rail, a whole number of cells of the tables [m]
WIDE = 12e-3
RADIUS, CANT = 600.0, 0.06


@pytest.fixture(scope="module")
def tables():
    """Contact tables of the same wheels on two gauges."""
    grid = {"y_step": 1e-3, "roll_step": 1e-3, "y_range": 12e-3, "roll_range": 4e-3, "yaw_range": 12e-3, "yaw_count": 4}
    usual = scenes.round_settings(**grid)
    gauges = usual.gauge, usual.gauge + 2.0 * ASIDE
    return [build_table(scenes.cone(0.05), scenes.round_rail(), replace(usual, gauge=gauge))[0] for gauge in gauges]


def curve(hand, widening):
    return Track(
        (
            Straight(length=30.0),
            Transition(length=40.0),
            Curve(length=300.0, radius=RADIUS, hand=hand, cant=CANT, gauge_widening=widening),
        )
    )


@pytest.mark.parametrize("pose", [(0.0, 0.0), (0.1e-3, 2e-3), (-0.25e-3, -4e-3)])
def test_rails_moved_apart_are_a_wider_gauge(tables, pose):
    usual, wide = (scenes.lone_wheelset(table, 20.0) for table in tables)
    shift, start, step = rails.constant(-ASIDE, ASIDE)
    moved = scenes.tuned(scenes.replaced(usual, shift=shift), shift_start=start, shift_step=step)
    q = wide.start().q.copy()
    q[0, 1], q[0, 5] = pose
    q[0, 2] += touching_depth(wide.model) + 60e-6
    v = np.array([[20.0, 0.02, 0.0, 0.0, -20.0 / tables[0].settings.radius, 0.01]])
    one, two = scenes.data_at(moved.model, q, v), scenes.data_at(wide.model, q, v)
    assert two.rail["patches"].min() == 1
    for key in ("x", "y", "q"):
        assert_allclose(one.rail[key], two.rail[key], atol=tol.SHIFTED_FORCE)


@pytest.mark.parametrize("hand", ["right", "left"])
def test_scenario_moves_the_inner_rail(hand):
    case = load("curve-1200-45").varied(track=curve(hand, WIDE), run={"distance": 300.0})
    shift, start, step = rails.pack(case)
    s = start + step * np.arange(shift.shape[0])
    inner, sign = (0, 1.0) if hand == "right" else (4, -1.0)
    outer = 4 - inner
    assert not shift[:, outer : outer + 4].any() and not shift[:, inner + 2 : inner + 4].any()
    assert_allclose(shift[s > 71.0, inner], sign * WIDE)
    assert_allclose(shift[s < 29.0, inner], 0.0, atol=tol.ROUNDING)
    ramp = (s > 31.0) & (s < 69.0)
    assert_allclose(shift[ramp, inner], sign * WIDE * (s[ramp] - 30.0) / 40.0, rtol=1e-9)
    assert_allclose(shift[ramp, inner + 1], sign * WIDE / 40.0, rtol=1e-9)


def test_without_widening_the_rails_stay():
    case = load("curve-1200-45").varied(track=curve("right", 0.0), run={"distance": 300.0})
    assert rails.pack(case)[0].shape[0] == 0


def test_steady_motion_on_the_widened_curve_is_that_of_the_wider_gauge(tables):
    """Both rails of a wide gauge moved outwards by half of what it is wider: then only the inner one is moved."""
    case = load("curve-1200-45").varied(run={"speed": 20.0}, contact={"friction": 0.6})
    usual, wide = (assemble(case, [table]) for table in tables)
    curvature = 1.0 / 3000.0
    one = steady(usual, curvature, 0.0, aside=(0.0, 2.0 * ASIDE)).data
    two = steady(wide, curvature, 0.0, aside=(ASIDE, ASIDE)).data
    wheelsets = list(usual.wheelsets)
    assert_allclose(one.q[wheelsets, 1], two.q[wheelsets, 1], atol=tol.WIDENED)
    assert_allclose(one.rail["y"], two.rail["y"], atol=tol.WIDENED_FORCE)
    assert np.ptp(two.q[wheelsets, 1]) > 1e-4
