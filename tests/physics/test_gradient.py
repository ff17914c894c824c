"""The wagon on gradients, in vertical curves and on twisted track: balances, energy, hand calculations."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import TOLERANCE, rising, static, steady
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.sections import Gradient, Straight, Transition
from railcli.model.track import Track, constant_track, pack

CURVATURE, CANT, BASE, GRAVITY, SPEED = 1.0 / 600.0, 0.100, 1.5, 9.81, 20.0
MIRRORED = np.array([1, -1, 1, -1, 1, -1])
OTHER_SIDE = [1, 0, 3, 2, 5, 4, 7, 6]


@pytest.fixture(scope="module")
def slow(table):
    return scenes.wagon(table, run={"speed": SPEED})


def rows_of(system, data, seconds, interval=10e-3):
    """Recorded instants of a run."""
    rows = new_rows(system.model, round(seconds / interval))
    count, status = record(system.model, data, rows, round(interval / system.model.param["step"][0]))
    assert (count, status) == (rows.time.size, 0)
    return rows


@pytest.mark.parametrize("slope", [0.035, -0.035])
def test_balance_on_a_graded_curve(slow, slope):
    """Traction less what the rails take forwards carries m g sin; lateral and normal sums have the cosine."""
    found = steady(slow, CURVATURE, CANT, gradient=slope)
    assert found.residual < TOLERANCE
    rail, mass = found.data.rail, slow.model.body["mass"].sum()
    sine, climb = CANT / BASE, np.arctan(slope)
    cosine, centrifugal = np.sqrt(1 - sine**2), found.data.rate[0, 0] ** 2 * CURVATURE
    along = found.data.traction[0] - rail["x"].sum()
    assert along == pytest.approx(mass * GRAVITY * np.sin(climb), abs=tol.CURVE_BALANCE)
    across = mass * np.cos(climb) * (GRAVITY * sine - centrifugal * cosine)
    assert rail["y"].sum() == pytest.approx(across, abs=tol.CURVE_BALANCE)
    down = mass * np.cos(climb) * (GRAVITY * cosine + centrifugal * sine)
    assert rail["q"].sum() == pytest.approx(down, abs=tol.CURVE_BALANCE)


def test_left_mirrors_right_on_a_gradient(slow):
    right = steady(slow, CURVATURE, CANT, gradient=0.03).data
    left = steady(slow, -CURVATURE, -CANT, gradient=0.03).data
    assert_allclose(left.q * MIRRORED, right.q, rtol=0, atol=tol.MIRRORED_PLACE)
    for key, sign in (("x", 1.0), ("y", -1.0), ("q", 1.0)):
        assert_allclose(sign * left.rail[key][OTHER_SIDE], right.rail[key], rtol=0, atol=tol.MIRRORED_FORCE)


def test_steady_motion_on_a_gradient_stays(slow):
    """A time run that starts in it: nothing moves but along the track."""
    track = pack(constant_track(CURVATURE, CANT), 800.0, gradients=rising(0.03), pivot="inner")
    there = scenes.replaced(slow, track=track)
    state = steady(slow, CURVATURE, CANT, gradient=0.03).data
    data = there.start()
    data.q[:], data.v[:], data.damper[:], data.held[:] = state.q, state.v, state.damper, state.held
    scenes.run(there, data, 30.0)
    assert_allclose(data.q[:, [1, 2, 3, 5]], state.q[:, [1, 2, 3, 5]], rtol=0, atol=tol.STEADY_PLACE)


@pytest.mark.parametrize("way", [1.0, -1.0], ids=["sag", "crest"])
def test_vertical_curve_changes_the_load(slow, way):
    """Sum Q = m (g cos(gradient) + V^2/R) in a sag, minus on a crest, once the bounce of its beginning has died."""
    radius, speed = 2000.0, 25.0
    gradients = Gradient(at=0.0, gradient=-0.04 * way), Gradient(at=80.0, gradient=0.04 * way, radius=radius)
    track = pack(Track((Straight(length=200.0),)), gradients=gradients)
    system = scenes.replaced(scenes.tuned(slow, speed=speed), track=track)
    data = system.start()
    data.q[:, 2:] = static(system).data.q[:, 2:]
    data.v[:, 0] *= speed / SPEED
    data.v[:, 4] *= speed / SPEED
    rows_of(system, data, 3.0)
    rows = rows_of(system, data, 2.0)
    mass, climb = system.model.body["mass"].sum(), (rows.q[:, 0, 0] - 80.0) / radius * way
    expected = mass * (GRAVITY * np.cos(climb).mean() + way * speed**2 / radius)
    share = tol.VERTICAL_CURVE * mass * speed**2 / radius
    assert rows.rail["q"].sum(axis=1).mean() == pytest.approx(expected, abs=share)


def test_cant_about_a_rail_lifts_the_wagon(slow):
    """On a ramp of 100 mm over 80 m about the inner rail the speed takes m g h' / 2 more than about the centre."""
    track = Track((Straight(length=30.0), Transition(length=80.0), Straight(length=60.0, cant=0.1)))
    tractions = []
    for pivot in ("centre", "inner"):
        system = scenes.replaced(slow, track=pack(track, pivot=pivot))
        data = system.start()
        data.q[:, 2:] = static(system).data.q[:, 2:]
        rows_of(system, data, 3.0)
        tractions.append(rows_of(system, data, 2.0).traction.mean())
    lifting = system.model.body["mass"].sum() * GRAVITY * 0.1 / 80.0 / 2.0
    assert tractions[1] - tractions[0] == pytest.approx(lifting, rel=tol.LIFTING)


def test_twist_unloads_wheels(slow):
    """1 in 400 on straight track, at walking pace: loads of the wheels from the roll stiffnesses by hand.

    Track, car body and bogies: the car body stays level between bogies that are turned against each other, each on
    secondary and primary roll stiffness in series; within a bogie the wheelsets are turned against each other on the
    primary one. What stands on a turned bogie leans over to the low side. The moment of each wheelset over the distance
    of the contacts is what its wheels gain and lose; the mean of front and rear, since wheelsets on a slope roll aside.
    """
    primary = 2 * 1.22e6 * 1.0**2
    secondary = 2 * 430e3 * 1.0**2 + 940e3 + 2 * 10.5e3
    bogie = 1.0 / (1.0 / secondary + 1.0 / (2 * primary))
    turn = 1.0 / 400.0 / BASE
    leaning = GRAVITY * (16000.0 * 0.8275 + 2615.0 * 0.6 + 2 * 1813.0 * 0.46)
    common = turn * 9.5 * (bogie - leaning) / 2
    moments = np.array([common + turn * primary * 1.28, common - turn * primary * 1.28])
    change = moments / 1.5
    high = Straight(length=30.0, cant=0.1)
    track = Track((Straight(length=30.0, cant=-0.1), Transition(length=80.0), high))
    system = scenes.replaced(scenes.tuned(slow, speed=2.0), track=pack(track))
    data = system.start(30.0)
    data.q[:, 2:] = static(system).data.q[:, 2:]
    data.v[:, 0] *= 2.0 / SPEED
    data.v[:, 4] *= 2.0 / SPEED
    rows_of(system, data, 19.5)
    rows = rows_of(system, data, 1.0)
    q = rows.rail["q"].mean(axis=0)
    difference = (q[1::2] - q[::2]) / 2.0  # left less right: the left rail rises in the direction of travel
    assert_allclose((difference[:2] - difference[:1:-1]) / 2.0, change, atol=tol.TWIST_BY_HAND * change[0])
