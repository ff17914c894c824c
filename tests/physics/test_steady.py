"""Static equilibrium and steady curving: balances of forces, mirror images, and Newton's method against time runs."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import TOLERANCE, static, steady
from railcli.files.scenario import load
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.system import assemble
from railcli.model.track import constant_track, pack

RADIUS, CANT, BASE, GRAVITY = 1200.0, 0.090, 1.5, 9.81
MIRRORED = np.array([1, -1, 1, -1, 1, -1])  # coordinates of a mirrored motion
OTHER_SIDE = [1, 0, 3, 2, 5, 4, 7, 6]
SPEEDS = (15, 30, 45)


@pytest.fixture(scope="module")
def curving(table):
    """Steady motions in the right-hand curve, by speed [m/s]: system and data."""
    systems = {speed: scenes.wagon(table, f"curve-1200-{speed}") for speed in SPEEDS}
    return {speed: (system, steady(system, 1 / RADIUS, CANT).data) for speed, system in systems.items()}


def in_curve(system, hand=1.0, length=3000.0, **param):
    """The same system on nothing but its curve."""
    return scenes.replaced(
        scenes.tuned(system, **param), track=pack(constant_track(hand / RADIUS, hand * CANT), length)
    )


def started(system, state):
    """Data that moves on from a steady motion."""
    data = system.start()
    data.q[:], data.v[:], data.damper[:], data.held[:] = state.q, state.v, state.damper, state.held
    return data


def test_static_wheel_loads(wagon):
    """Every wheel carries an eighth of the weight, 54.546 kN, and nothing pushes sideways or along."""
    data = static(wagon).data
    weight = wagon.model.body["mass"].sum() * GRAVITY
    assert_allclose(data.rail["q"], 54546.0, rtol=0, atol=tol.STATIC_LOAD)
    assert data.rail["q"].sum() == pytest.approx(weight, abs=tol.STATIC_BALANCE)
    assert_allclose(data.rail["y"][::2], -data.rail["y"][1::2], rtol=0, atol=tol.STATIC_BALANCE)
    assert_allclose(data.rail["x"], 0.0, atol=tol.STATIC_BALANCE)


def test_static_balance_of_every_body(wagon):
    """Weight, suspension and rails cancel on each of the seven bodies; the wagon stands upright in the middle."""
    result = static(wagon)
    assert result.residual < TOLERANCE
    assert_allclose(result.data.dv, 0.0, atol=TOLERANCE)
    assert_allclose(result.data.q[:, [1, 3, 5]], 0.0, atol=tol.UPRIGHT)


@pytest.mark.parametrize("speed", SPEEDS)
def test_balance_in_the_curve(curving, speed):
    """Sum Y = m (g sin - V^2/R cos) to the right, sum Q = m (g cos + V^2/R sin), normal to the track plane."""
    system, data = curving[speed]
    sine = CANT / BASE
    cosine = np.sqrt(1 - sine**2)
    mass, outwards = system.model.body["mass"].sum(), speed**2 / RADIUS
    assert data.rail["y"].sum() == pytest.approx(mass * (GRAVITY * sine - outwards * cosine), abs=tol.CURVE_BALANCE)
    assert data.rail["q"].sum() == pytest.approx(mass * (GRAVITY * cosine + outwards * sine), abs=tol.CURVE_BALANCE)


@pytest.mark.parametrize("speed", SPEEDS)
def test_holding_the_speed_takes_little(curving, speed):
    """The force that holds the speed equals what the rails drag, some hundred newtons."""
    system, data = curving[speed]
    assert data.traction[0] == pytest.approx(data.rail["x"].sum(), abs=tol.CURVE_BALANCE)
    assert 0.0 < data.traction[0] < 2000.0


def test_balanced_cant(table):
    """Where V^2/R = g tan(cant) the rails give no lateral force in sum, and both sides carry nearly the same."""
    system = scenes.wagon(table, "curve-1200-30")
    angle = np.arctan(30.0**2 / RADIUS / GRAVITY)
    data = steady(system, 1 / RADIUS, BASE * np.sin(angle)).data
    assert abs(data.rail["y"].sum()) < tol.CURVE_BALANCE
    one, other = data.rail["q"][::2].sum(), data.rail["q"][1::2].sum()
    assert abs(one - other) < tol.EVEN_LOADS * (one + other)


@pytest.mark.parametrize("speed", [15, 45])
def test_left_curve_mirrors_the_right(curving, speed):
    """The steady motion in a left-hand curve is the mirror image of that in a right-hand one."""
    system, right = curving[speed]
    left = steady(system, -1 / RADIUS, -CANT).data
    assert_allclose(left.q * MIRRORED, right.q, rtol=0, atol=tol.MIRRORED_PLACE)
    for key, sign in (("x", 1.0), ("y", -1.0), ("q", 1.0)):
        assert_allclose(sign * left.rail[key][OTHER_SIDE], right.rail[key], rtol=0, atol=tol.MIRRORED_FORCE)


def test_run_into_a_left_curve_mirrors_the_right(wagon):
    """The same for a run through a transition into the curve and out again."""

    def ran(hand):
        curve = scenes.Curve(length=30.0, radius=300.0, hand=hand, cant=0.1)
        track = (scenes.Straight(length=30.0), scenes.Transition(length=40.0), curve)
        system = scenes.replaced(scenes.tuned(wagon, speed=20.0), track=pack(scenes.Track(track)))
        data = system.start()
        data.v[:, 0] = 20.0
        data.v[:, 4] *= 20.0 / 45.0
        return scenes.run(system, data, 4.5)

    right, left = ran("right"), ran("left")
    assert np.abs(right.q[:, 1]).max() > 2e-3
    assert_allclose(left.q * MIRRORED, right.q, rtol=0, atol=tol.MIRRORED_PLACE)


def test_newton_against_a_time_run(curving):
    """At 30 m/s the wagon that starts in the middle of the track ends in the steady motion that Newton finds."""
    system, expected = curving[30]
    system = in_curve(system)
    data = scenes.run(system, system.start(), 60.0)
    assert_allclose(data.q[:, 1:4], expected.q[:, 1:4], rtol=0, atol=tol.STEADY_PLACE)
    assert_allclose(data.q[:, 5], expected.q[:, 5], rtol=0, atol=tol.STEADY_PLACE)
    assert_allclose(data.rail["y"], expected.rail["y"], rtol=0, atol=tol.STEADY_FORCE)
    assert_allclose(data.rail["q"], expected.rail["q"], rtol=0, atol=tol.STEADY_FORCE)


@pytest.mark.parametrize("speed", [15, 45])
def test_half_the_step_moves_no_wheelset(curving, speed):
    """No mean lateral displacement in the curve moves by more than 0.005 mm when the step is halved."""
    system, state = curving[speed]
    means = []
    for step in (0.5e-3, 0.25e-3):
        there = in_curve(system, step=step)
        data = started(there, state)
        scenes.run(there, data, 5.0)
        rows = new_rows(there.model, 200)
        assert record(there.model, data, rows, round(10e-3 / step)) == (200, 0)
        means.append(rows.q[:, list(system.wheelsets), 1].mean(axis=0))
    assert_allclose(means[0], means[1], rtol=0, atol=tol.HALVED_STEP)


def test_turned_scene(curving):
    """A track that sets out elsewhere in another direction changes nothing that is seen from the track."""
    system, state = curving[45]
    here = in_curve(system)
    track = here.model.track.copy()
    plan = (track["x"] + 1j * track["y"]) * np.exp(0.7j) + (800.0 - 300.0j)
    track["x"], track["y"], track["heading"] = plan.real, plan.imag, track["heading"] + 0.7
    track["cos_heading"], track["sin_heading"] = np.cos(track["heading"]), np.sin(track["heading"])
    there = scenes.replaced(here, track=track)
    one, two = (scenes.run(one, started(one, state), 2.0) for one in (here, there))
    assert_allclose(two.q, one.q, rtol=0, atol=tol.TURNED)
    assert np.abs(two.frame["position"] - one.frame["position"]).max() > 100.0


def test_steady_motion_where_the_path_from_straight_track_is_not_smooth(table):
    """At friction 0.125 and 45 m/s W2 leaves its flange on the way into the curve; the steady motion is still found."""
    system = assemble(load("curve-1200-45").varied(contact={"friction": 0.125}), [table])
    found = steady(system, 1.0 / 1200.0, 0.090, 45.0)
    assert np.abs(found.data.dv).max() < TOLERANCE
