"""Energy of the contact on displaced, turned and yielding rails: what forces and couple do is what the energy loses."""

import math

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels.step import evaluate

STEPS = 1e-7, 1e-8, 1e-8, 1e-7, None, 1e-7  # of differences of the energy; the pitch of a wheel of revolution has none
PLACES = (3e-3, 5.9e-3, 5.95e-3, -6.2e-3)  # tread, tread and flank together, both of the left wheel [m]
PRESSED = 60e-6  # [m]
STILL = np.zeros((2, 2))


def axes_of(lateral_slope, vertical_slope):
    """Matrix whose columns are the axes of a rail with these slopes."""
    yaw = math.atan(lateral_slope)
    return scenes.turn_z(yaw) @ scenes.turn_y(math.atan(-vertical_slope * math.cos(yaw)))


def energy(table, q, rails, give=STILL):
    """Elastic energy of both wheels of a wheelset at its coordinates q, apart from the kernels that run in a step.

    rails : called with an arc length; displacement and slopes, each (rail, direction).  give : further displacement.
    """
    place, slope = rails(q[0])
    half, radius, total = table.settings.lateral, table.settings.radius, 0.0
    own = scenes.turn_z(q[5]) @ scenes.turn_x(q[3])
    for k, side in enumerate((1.0, -1.0)):
        axes, seat = axes_of(*slope[k]), np.array([0.0, side * half, 0.0])
        axle = axes.T @ own[:, 1]
        centre = axes.T @ (np.array([0.0, q[1], q[2]]) - seat - [0.0, *(place[k] + give[k])]) + seat
        roll, yaw = math.asin(axle[2]), math.atan2(-axle[0], axle[1])
        bottom = centre + scenes.turn_z(yaw) @ scenes.turn_x(roll) @ [0.0, side * half, radius]
        pose = side * bottom[1] - half, bottom[2], side * roll, side * yaw
        total += scenes.stored_at(table, *pose)[0]
    return total


def turned(yaw, pitch, bend, half):
    """Both rails turned as one body about the origin, in pitch and then in yaw, and waves on them."""
    axes = scenes.turn_z(yaw) @ scenes.turn_y(pitch)

    def displacement(s):
        value, slope = (bend * each for each in scenes.waves(s))
        for k, side in enumerate((1.0, -1.0)):
            start = axes @ [0.0, side * half, 0.0]
            for direction, axis in enumerate((1, 2)):
                rate = axes[axis, 0] / axes[0, 0]
                value[k, direction] += start[axis] + rate * (s - start[0])
                slope[k, direction] += rate
            value[k, 0] -= side * half
        return value, slope

    return displacement, axes


def on_turned_rails(heights, lateral, yaw, pitch, bend, give=STILL):
    """A wheelset pressed on its rails, and these."""
    displacement, axes = turned(yaw, pitch, bend, heights.settings.lateral)

    def rails(s):
        return (each[..., 0] for each in displacement(np.array([s])))

    system = scenes.lone_wheelset(heights, 10.0, friction=0.0, damping=0.0)
    system = scenes.on_rails(system, displacement, step=0.01, reach=(-5.0, 5.0))
    data = system.start(0.0)
    q = data.q[0]
    s, y, z = axes @ [0.0, lateral, q[2]]
    axle = (axes @ scenes.turn_z(3e-3) @ scenes.turn_x(0.8e-3))[:, 1]
    moved = bend * scenes.waves(np.array([s]))[0].mean(axis=0)[:, 0]
    y, z = y + moved[0], z + moved[1]
    q[:] = s, y, z - 3e-3, math.asin(axle[2]), 0.0, math.atan2(-axle[0], axle[1])
    for _ in range(400):
        if energy(heights, q, rails, give) > 0.0:
            break
        q[2] += 20e-6
    q[2] += PRESSED
    return system, data, rails


def slopes(function, q):
    """Central differences of a function of a wheelset's coordinates."""
    found = np.zeros(6)
    for k, step in enumerate(STEPS):
        if step:
            ahead, behind = q.copy(), q.copy()
            ahead[k], behind[k] = ahead[k] + step, behind[k] - step
            found[k] = (function(ahead) - function(behind)) / (2.0 * step)
    return found


def generalised(data):
    """Loads of the rails on a wheelset by its coordinates: along, right, down, roll, spin and yaw [N], [N m]."""
    q, load = data.q[0], data.rail_load[0]
    moment = scenes.turn_z(q[5]) @ scenes.turn_x(q[3]) @ load[3:]
    return np.array([*load[:3], moment @ scenes.turn_z(q[5])[:, 0], load[4], moment[2]])


@pytest.mark.parametrize("lateral", PLACES)
@pytest.mark.parametrize(
    "yaw, pitch, bend", [(0.0, 0.0, 0.0), (0.25, 0.0, 0.0), (0.0, 0.3, 0.0), (-0.2, -0.3, 0.0), (-0.2, -0.3, 0.2)]
)
def test_work_on_displaced_rails_is_the_loss_of_energy(heights, lateral, yaw, pitch, bend):
    """Along the track too, over which displaced rails rise and turn: d U = - F dq for every coordinate."""
    system, data, rails = on_turned_rails(heights, lateral, yaw, pitch, bend)
    assert evaluate(system.model, data, 0.0) == 0
    force, lost = generalised(data), -slopes(lambda q: energy(heights, q, rails), data.q[0])
    size = np.linalg.norm(force[:3])
    assert size > 5e3
    assert_allclose(force, lost, rtol=0, atol=(tol.STORED_SLOPE_BENT if bend else tol.STORED_SLOPE) * size)


def test_the_couple_turns_with_its_rail(heights):
    """Where tread and flank share the load: a couple left in track axes would be seen by the test above."""
    system, data, rails = on_turned_rails(heights, 5.95e-3, -0.2, -0.3, 0.0)
    assert evaluate(system.model, data, 0.0) == 0
    couple, axes = data.rail["couple"][0], axes_of(*tuple(rails(0.0))[1][0])
    assert data.rail["patches"][0] == 2
    left = np.linalg.norm(axes.T @ couple - couple)
    assert left > 10.0 * tol.STORED_SLOPE * np.linalg.norm(data.rail_load[0, :3])


@pytest.mark.parametrize("lateral", PLACES)
def test_work_on_yielding_rails_is_the_loss_of_energy(heights, lateral):
    """For coordinates of the wheelset and for the places of both rails."""
    give = np.array([[0.1e-3, 0.2e-3], [-0.15e-3, 0.25e-3]])
    system, data, rails = on_turned_rails(heights, lateral, 0.02, -0.03, 0.2, give)
    system = scenes.tuned(system, rail_stiffness=(2e7, 5e7), rail_damping=(1e4, 1e4))
    moved = system.start(0.0)
    moved.q[:], moved.yielded[:] = data.q, give
    assert evaluate(system.model, moved, 0.0) == 0
    force = generalised(moved)
    lost = -slopes(lambda q: energy(heights, q, rails, give), moved.q[0])
    size = np.linalg.norm(force[:3])
    assert size > 5e3
    assert_allclose(force, lost, rtol=0, atol=tol.STORED_SLOPE_BENT * size)
    on_rails = np.column_stack([moved.rail["y"], moved.rail["q"]])
    for k in np.ndindex(2, 2):
        ends = []
        for step in (1e-8, -1e-8):
            there = give.copy()
            there[k] += step
            ends.append(energy(heights, moved.q[0], rails, there))
        assert on_rails[k] == pytest.approx(-(ends[0] - ends[1]) / 2e-8, abs=tol.STORED_SLOPE_BENT * size)
