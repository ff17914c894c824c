"""Bodies without rails in moving track frames: what they keep, and closed forms of their motion."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from benchmarks.speed import numpy_twin
from railcli.model.sections import Gradient
from railcli.model.track import constant_track, pack

SAG = Gradient(at=0.0, gradient=-0.02), Gradient(at=40.0, gradient=0.03, radius=1600.0)  # from 0 to 80 m
VALLEY = Gradient(at=0.0, gradient=-0.02), Gradient(at=130.0, gradient=0.02, radius=6499.0)  # from 0 to 260 m
MASS = np.array([3000.0, 1800.0])
INERTIA = np.array([[1700.0, 1500.0, 3100.0], [1100.0, 110.0, 1100.0]])
SPINS = np.array([0, 1])


def body_and_wheelset(wagon, track, step, gravity=0.0):
    system = scenes.floating(scenes.bodies(wagon, MASS, INERTIA, SPINS), track)
    return scenes.tuned(system, step=step, gravity=gravity)


def thrown(system, speed=40.0):
    """A tumbling body and a wheelset that rolls, yaws and drifts."""
    q = np.array([[2.0, 0.3, -0.8, 0.1, -0.2, 0.05], [5.0, -0.2, -0.4, 0.02, 0.0, -0.1]])
    v = np.array([[speed, 0.8, -0.5, 0.3, -0.4, 0.2], [0.95 * speed, -0.3, 0.4, 0.1, -80.0, 0.05]])
    return scenes.data_at(system.model, q, v)


def kept(system, data):
    """Momentum, angular momentum about the ground's origin, kinetic energy; one row per body, ground axes."""
    at = numpy_twin.kinematics(system.model, data.q, data.v)
    momentum = MASS[:, None] * at.velocity
    spin = np.einsum("nij,nj->ni", at.axes, INERTIA * data.v[:, 3:])
    energy = 0.5 * np.sum(MASS[:, None] * at.velocity**2, axis=1) + 0.5 * np.sum(INERTIA * data.v[:, 3:] ** 2, axis=1)
    return momentum, spin + np.cross(at.position, momentum), energy[:, None]


def losses(wagon, track, step, seconds=6.0):
    """Largest relative change of momentum, angular momentum and energy over a run."""
    system = body_and_wheelset(wagon, track, step)
    data = thrown(system)
    before = kept(system, data)
    scenes.run(system, data, seconds)
    return np.array([np.abs(b - a).max() / np.abs(a).max() for a, b in zip(before, kept(system, data), strict=True)])


@pytest.mark.parametrize("hilly", [False, True], ids=["level", "hills"])
def test_free_bodies_keep_momentum_and_energy(wagon, hilly):
    """Along 240 m of transitions and canted curves of both hands, through a sag and over a crest."""
    track = pack(scenes.WINDING, gradients=scenes.HILLS, pivot="inner") if hilly else scenes.WINDING
    allowed = tol.FREE_HILLS if hilly else (tol.FREE_MOMENTUM, tol.FREE_ANGULAR, tol.FREE_ENERGY)
    assert (losses(wagon, track, 0.25e-3) < allowed).all()


@pytest.mark.parametrize("gradients", [(), VALLEY], ids=["level", "valley"])
def test_loss_falls_with_the_square_of_the_step(wagon, gradients):
    """Where the roll of the track has no kinks (a linear cant ramp has them at its ends), nor its pitch."""
    track = pack(scenes.SMOOTH, gradients=gradients, pivot="inner")
    series = np.array([losses(wagon, track, step, 5.0) for step in (1e-3, 0.5e-3, 0.25e-3)])
    assert_allclose(series[:-1] / series[1:], 4.0, rtol=tol.ORDER_TWO)
    assert (series[-1] < tol.FREE_SMOOTH).all()


@pytest.mark.parametrize("gradients", [(), SAG], ids=["level", "sag"])
def test_thrown_body_flies_in_a_parabola(wagon, gradients):
    """On a canted curve, seen from the ground: straight on in plan, g t^2 / 2 downwards."""
    step, seconds = 0.25e-3, 1.5
    curve = scenes.Curve(length=100.0, radius=200.0, hand="right", cant=0.15)
    track = pack(scenes.Track((curve,)), gradients=gradients, pivot="inner")
    system = body_and_wheelset(wagon, track, step, gravity=9.81)
    data = thrown(system)
    start = numpy_twin.kinematics(system.model, data.q, data.v)
    scenes.run(system, data, seconds)
    end = numpy_twin.kinematics(system.model, data.q, data.v)
    fall = np.array([0.0, 0.0, 9.81])
    flown = seconds * start.velocity + 0.5 * seconds**2 * fall
    assert_allclose(end.position, start.position + flown, atol=tol.PARABOLA)
    assert_allclose(end.velocity, start.velocity + seconds * fall, atol=tol.PARABOLA)


def test_spinning_wheelset_precesses(wagon):
    """Free of torque its axle goes round the angular momentum L at the rate L / I about a transverse axis."""
    seconds = 2.0
    system = body_and_wheelset(wagon, constant_track(0.0, 0.0), 0.1e-3)
    data = thrown(system, 5.0)
    data.v[:, :3] = 0.0
    data.v[1, 3:] = 1.5, -80.0, 1.0
    data = scenes.data_at(system.model, data.q, data.v)

    def axle_and_moment():
        axes = numpy_twin.kinematics(system.model, data.q, data.v).axes[1]
        return axes[:, 1].copy(), axes @ (INERTIA[1] * data.v[1, 3:])

    axle, moment = axle_and_moment()
    scenes.run(system, data, seconds)
    expected = Rotation.from_rotvec(moment / INERTIA[1, 0] * seconds).apply(axle)
    assert np.linalg.norm(expected - axle) > 0.1
    assert_allclose(axle_and_moment()[0], expected, atol=tol.PRECESSION)


def test_gyroscopic_moment(wagon):
    """A wheelset that rolls forwards (omega_y < 0) and yaws to the right rolls to the left, by Iyy omega_y / Ixx."""
    system = body_and_wheelset(wagon, constant_track(0.0, 0.0), 1e-3)
    v = np.zeros((2, 6))
    v[1, 4:] = -100.0, 0.2
    data = scenes.data_at(system.model, np.zeros((2, 6)), v)
    assert_allclose(data.dv[1], [0, 0, 0, 110.0 / 1100.0 * -100.0 * 0.2, 0, 0], atol=tol.ROUNDING)
