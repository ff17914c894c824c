"""Wheels on rails beside their ideal place: shifts and rotations of the scene, geometry, energy, rates, signs."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.optimize import minimize_scalar

from railcli.analysis import faults
from railcli.analysis.equilibrium import touching_depth
from railcli.analysis.simulate import settled_start
from railcli.kernels.layout import MAX_CONTACT, Status
from railcli.kernels.step import advance, evaluate

RIGHT, LEFT, LATERAL, DOWN = 0, 1, 0, 1


@pytest.fixture(scope="module")
def cones():
    """Table of cones on round rails: one contact, everything smooth."""
    return scenes.cone_table(0.025)


def pressed(system, s=5.0, depth=0.05e-3):
    """Data of a lone wheelset on its rails."""
    data = system.start(s)
    data.q[0, 2] += touching_depth(system.model) + depth
    return data


def still(s):
    """No displacement: values and slopes."""
    return np.zeros((2, 2, s.size)), np.zeros((2, 2, s.size))


def shifted(lateral=0.0, down=0.0):
    """Both rails displaced by the same distance everywhere."""

    def displacement(s):
        value, slope = still(s)
        value[:, LATERAL], value[:, DOWN] = lateral, down
        return value, slope

    return displacement


def test_rails_in_place_change_nothing(wagon):
    """Displacement zero everywhere gives the run without any: other operations for the same pose, rounding apart."""
    moved = scenes.on_rails(wagon, still)
    one, two = (scenes.run(system, settled_start(system, 3e-3), 0.5) for system in (wagon, moved))
    assert_allclose(two.q, one.q, rtol=0, atol=tol.SHIFTED_PLACE)
    assert_allclose(two.rail["q"], one.rail["q"], rtol=0, atol=tol.SHIFTED_FORCE)


@pytest.mark.parametrize("way", [{"lateral": 7e-3}, {"down": -12e-3}], ids=["lateral", "up"])
def test_both_rails_shift_the_scene(wagon, way):
    """A constant displacement of both rails shifts the whole motion and nothing else."""
    straight = scenes.replaced(wagon, track=scenes.pack(scenes.Track((scenes.Straight(length=300.0),))))
    one = scenes.run(straight, settled_start(straight, 3e-3), 0.5)
    system = scenes.on_rails(straight, shifted(**way))
    data = settled_start(system, 3e-3)
    move = np.array([0.0, way.get("lateral", 0.0), way.get("down", 0.0), 0.0, 0.0, 0.0])
    data.q[:] += move
    two = scenes.run(system, data, 0.5)
    assert_allclose(two.q - move, one.q, rtol=0, atol=tol.SHIFTED_PLACE)
    assert_allclose(two.rail["q"], one.rail["q"], rtol=0, atol=tol.SHIFTED_FORCE)
    assert_allclose(two.rail["y"], one.rail["y"], rtol=0, atol=tol.SHIFTED_FORCE)


def turned(yaw, pitch, half):
    """Two straight rails at +-half that are turned as one body about the origin: first in pitch, then in yaw."""
    axes = scenes.turn_z(yaw) @ scenes.turn_y(pitch)

    def displacement(s):
        value, slope = still(s)
        for rail, side in ((RIGHT, 1.0), (LEFT, -1.0)):
            along, start = axes[:, 0], axes @ [0.0, side * half, 0.0]
            reach = (s - start[0]) / along[0]
            for direction, axis in ((LATERAL, 1), (DOWN, 2)):
                value[rail, direction] = start[axis] + reach * along[axis]
                slope[rail, direction] = along[axis] / along[0]
            value[rail, LATERAL] -= side * half
        return value, slope

    return displacement, axes


@pytest.mark.parametrize("yaw, pitch", [(8e-3, 0.0), (0.0, 9e-3), (-6e-3, -11e-3)], ids=["yaw", "pitch", "both"])
def test_rotated_rails_rotate_the_forces(cones, yaw, pitch):
    """Rails turned in yaw and pitch with the wheelset on them: the same contact, with forces turned alike."""
    system = scenes.tuned(scenes.lone_wheelset(cones, 20.0), gravity=0.0, hold=0.0)
    displacement, axes = turned(yaw, pitch, float(system.model.wheel[0]["lateral"]))
    data = pressed(system, s=0.0)
    data.q[0, [1, 3, 5]] = 1.5e-3, 0.1e-3, 1.2e-3
    data.v[0] = 20.0, 0.03, -0.02, 0.05, -20.0 / 0.46 + 0.1, 0.02
    assert evaluate(system.model, data, 0.0) == 0
    moved = scenes.on_rails(system, displacement)
    other = moved.start(0.0)
    place = axes @ [0.0, data.q[0, 1], data.q[0, 2]]
    own = axes @ scenes.turn_z(data.q[0, 5]) @ scenes.turn_x(data.q[0, 3])
    axle = own[:, 1]
    roll, heading = np.arcsin(axle[2]), np.arctan2(-axle[0], axle[1])
    other.q[0] = [place[0], place[1], place[2], roll, 0.0, heading]
    frame = scenes.turn_z(heading) @ scenes.turn_x(roll)
    other.v[0, :3], other.v[0, 3:] = axes @ data.v[0, :3], frame.T @ own @ data.v[0, 3:]
    assert evaluate(moved.model, other, 0.0) == 0
    for key in ("normal", "creep_x", "creep_t", "spin_moment", "xi", "eta", "phi", "depth"):
        size = np.abs(data.contact[key]).max()
        assert_allclose(other.contact[key], data.contact[key], rtol=0, atol=tol.TURNED_CONTACT * size, err_msg=key)
    forces = [np.stack([one.rail[key] for key in ("x", "y", "q")]) for one in (data, other)]
    assert_allclose(forces[1], axes @ forces[0], rtol=0, atol=tol.TURNED_CONTACT * np.abs(forces[0]).max())


def bump(height, length, start, rails=(RIGHT, LEFT)):
    """A cosine that raises the rails."""

    def displacement(s):
        value, slope = still(s)
        u = np.clip((s - start) / length, 0.0, 1.0)
        for rail in rails:
            value[rail, DOWN] = -0.5 * height * (1.0 - np.cos(2.0 * np.pi * u))
            slope[rail, DOWN] = -np.pi * height / length * np.sin(2.0 * np.pi * u)
        return value, slope

    return displacement


def test_wheelset_over_a_bump_at_vanishing_speed(cones):
    """The axle keeps the distance of the radius from the bump, square to it: the parallel curve, by search."""
    height, length, speed = 5e-3, 1.0, 0.3
    system = scenes.on_rails(scenes.lone_wheelset(cones, speed), bump(height, length, 5.2), step=0.01, reach=(0, 10.0))
    level = scenes.run(system, pressed(system), 0.5)
    rest, radius = level.q[0, 2], 0.46
    data, found, wanted = level, [], []

    def rail(s):
        u = np.clip((s - 5.2) / length, 0.0, 1.0)
        return -0.5 * height * (1.0 - np.cos(2.0 * np.pi * u))

    while data.q[0, 0] < 5.2 + length:
        scenes.run(system, data, 0.05)
        s = data.q[0, 0]
        # highest place (least z) at which the circle about the axle still clears the rail
        clear = minimize_scalar(
            lambda x, s=s: -(np.sqrt(radius**2 - (x - s) ** 2) - rail(x)), (s - 0.05, s, s + 0.05), tol=1e-10
        )
        wanted.append(clear.fun + radius)
        found.append(data.q[0, 2] - rest)
    assert min(wanted) < -0.99 * height
    assert_allclose(found, wanted, rtol=0, atol=tol.PARALLEL_CURVE)


@pytest.mark.parametrize("friction", [0.0, 50.0], ids=["sliding", "rolling"])
def test_energy_over_a_bump(cones, friction):
    """A coasting wheelset climbs a bump on its own speed: kinetic, potential and contact energy stay together.

    Rolling, spin takes its toll: the power of the creep forces is counted in.
    """
    height, speed, gravity, mass = 8e-3, 3.0, 9.81, 2000.0
    system = scenes.lone_wheelset(cones, speed, step=0.1e-3, mass=mass)
    system = scenes.tuned(scenes.edited(system, "wheel", friction=friction), hold=0.0, damping=0.0)
    system = scenes.on_rails(system, bump(height, 2.0, 5.5), step=0.02, reach=(0.0, 20.0))
    data = pressed(system)
    lost, climbed = [], []

    def energy():
        body, v = system.model.body[0], data.v[0]
        evaluate(system.model, data, 0.0)
        spring = 0.4 * np.sum(data.contact["normal"][:, 0] * data.contact["depth"][:, 0])
        rolling = body["inertia"][1] * v[4] ** 2 if friction else 0.0
        return 0.5 * (mass * v[:3] @ v[:3] + rolling) - mass * gravity * data.q[0, 2] + spring

    def slipping():
        pairs = (("creep_x", "xi"), ("creep_t", "eta"), ("spin_moment", "phi"))
        return sum(np.sum(data.contact[force] * data.contact[slip]) for force, slip in pairs) * data.v[0, 0]

    before, start, spent = energy(), data.q[0, 2], 0.0
    while data.q[0, 0] < 8.0:
        scenes.run(system, data, 0.02)
        spent -= 0.02 * slipping()
        lost.append(energy() - before + spent)
        climbed.append(start - data.q[0, 2])
    raised = mass * gravity * height
    assert max(climbed) > 0.98 * height
    assert np.abs(lost).max() < tol.BUMP_ENERGY * raised


def test_rate_of_approach(wagon):
    """The rate that the contact's damper sees is that of the penetration, the rails' slopes times the speed in it."""
    rng = np.random.default_rng(11)
    plain = scenes.on_rails(scenes.tuned(wagon, damping=0.0), scenes.waves)
    damped = scenes.on_rails(scenes.tuned(wagon, damping=1e-3), scenes.waves)
    errors, rates = [], []
    for place in np.linspace(5.0, 80.0, 12):
        data = settled_start(plain, 0.0)
        data.q[:, 0] += place
        value = scenes.waves(data.q[:, 0])[0].mean(axis=0)
        spins = plain.model.body["spins"] == 1
        data.q[spins, 1:3] += value.T[spins]
        data.q[spins, 5] += rng.uniform(-2e-3, 2e-3, spins.sum())
        data.q[spins, 2] += 0.1e-3
        assert evaluate(plain.model, data, 0.0) == 0
        spring, rate = data.contact["normal"].copy(), data.rate.copy()
        angle = np.arctan(data.contact["slope"])
        assert evaluate(damped.model, data, 0.0) == 0
        lone = data.rail["patches"] == 1
        approach = np.where(spring > 0.0, (data.contact["normal"] / np.where(spring > 0.0, spring, 1.0) - 1.0), 0.0)
        depth = []
        for step in (1e-6, -1e-6):
            other = scenes.new_data(plain.model, data.q + step * rate, data.damper.size)
            assert evaluate(plain.model, other, 0.0) == 0
            depth.append(other.contact["depth"].copy())
        sinking = (depth[0] - depth[1]) / 2e-6 * np.cos(angle)
        errors.extend((approach / 1e-3 - sinking)[lone, 0])
        rates.extend(sinking[lone, 0])
    assert len(rates) > 30
    assert_allclose(errors, 0.0, atol=tol.APPROACH * np.abs(rates).max())


@pytest.mark.parametrize("rail, direction", [(RIGHT, DOWN), (LEFT, DOWN), (RIGHT, LATERAL), (LEFT, LATERAL)])
def test_signs_of_each_rail(wagon, rail, direction):
    """A rail that lies lower lets its side of the wagon down; one that moves to the right pulls the wheelsets along."""
    size = 4e-3

    def displacement(s):
        value, slope = still(s)
        value[rail, direction] = size
        return value, slope

    straight = scenes.replaced(wagon, track=scenes.pack(scenes.Track((scenes.Straight(length=300.0),))))
    system = scenes.on_rails(scenes.tuned(straight, speed=5.0), displacement)
    data = settled_start(system)
    data.v[:] *= 5.0 / data.v[0, 0]
    for _ in range(4):
        scenes.run(system, data, 1.0)
    side = 1.0 if rail == RIGHT else -1.0
    if direction == DOWN:
        assert_allclose(data.q[3:, 3], side * size / 1.5, rtol=tol.CROSS_LEVEL_ROLL)
        assert (side * data.q[0, 3]) > size / 1.5  # the body on its springs leans further out
        assert side * (data.rail["q"][::2] - data.rail["q"][1::2]).sum() > 0.0
    else:
        assert_allclose(data.q[3:, 1], 0.5 * size, rtol=0, atol=tol.GAUGE_CENTRE)


def test_end_of_the_displacement(wagon):
    """A wheel beyond what is given ends the run with a sentence, at the first step there."""
    system = scenes.on_rails(wagon, still, reach=(-45.0, 30.0))
    data = settled_start(system)
    status = advance(system.model, data, 10000)
    assert status == Status.LEFT_SHIFT
    assert 30.0 < data.q[3, 0] < 30.0 + 45.0 * 1e-3
    assert "wheel W1 right ran beyond the stretch" in faults.sentence(system, data, status)
    assert data.contact.shape[1] == MAX_CONTACT
