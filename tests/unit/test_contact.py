"""Look-up in a contact table and what is made of it: against direct minimisation, continuous, never undefined."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.certify import certify, shortcomings
from railcli.analysis.equilibrium import touching_depth
from railcli.kernels.contact import elastic_share, look_up
from railcli.kernels.layout import MAX_CONTACT, NODE_CHANNELS, Node, Status
from railcli.kernels.step import evaluate
from railcli.model.submodels import CREEP_LAWS

PRESSED = 60e-6  # beyond first touch: about a wheel load of 60 kN [m]


def loaded(table, pose, depth):
    """Rows of the loaded branches; None off the table."""
    sample = np.full((MAX_CONTACT, NODE_CHANNELS), np.nan)
    count = look_up(table.record[0], table.node, table.cell, table.branch, *pose, depth, sample)
    return None if count < 0 else sample[: min(count, MAX_CONTACT)]


def first_touch(table, pose):
    """Depth at which the wheel first touches [m]."""
    deep = 0.02
    return deep - loaded(table, pose, deep)[:, Node.GAP].max()


def elastic_force(table, pose, depth):
    """Lateral and vertical sum of the elastic normal forces of a wheel [N]."""
    rows = loaded(table, pose, depth)
    force = np.zeros(2)
    for j, row in enumerate(rows):
        cosine = 1.0 / np.sqrt(1.0 + row[Node.SLOPE] ** 2)
        share = elastic_share(rows, len(rows), j, cosine)
        force += row[Node.HERTZ] * share * cosine * np.array([-row[Node.SLOPE], 1.0])
    return force


def test_against_direct_minimisation(table, profiles):
    """D, position, contact angle and rolling radius at random poses keep the limits that a table must keep."""
    certificate = certify(table, *profiles, poses=1500)
    assert shortcomings(certificate) == []
    assert certificate["branches"] > 1500 and certificate["near_end_share"] < 0.2


@pytest.mark.parametrize("direction", range(3), ids=["y", "roll", "yaw"])
def test_elastic_force_is_continuous(table, direction):
    """On the way over from tread to flange no force jumps: where it moves most, it moves little by little."""
    rng = np.random.default_rng(direction)
    low, high = np.array([5e-3, -7e-3, 0.0]), np.array([8e-3, 7e-3, 13e-3])
    step = np.array([2e-6, 8e-6, 8e-6])[direction]
    for _ in range(8):
        pose = rng.uniform(low, high)

        def at(place, pose=pose):
            pose = np.where(np.arange(3) == direction, place, pose)
            return elastic_force(table, pose, first_touch(table, pose) + PRESSED)

        places = np.arange(low[direction], high[direction], step)
        moves = np.abs(np.diff([at(place) for place in places], axis=0)).max(axis=1)
        for k in np.argsort(moves)[-4:]:
            parts = np.abs(np.diff([at(place) for place in np.linspace(places[k], places[k + 1], 65)], axis=0))
            assert parts.max() < max(0.2 * moves[k], tol.FORCE_GRAIN), (pose, places[k])


def test_force_grows_with_depth(table):
    """Pressed in farther, no wheel pushes back less, however many branches come into contact and merge."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        pose = rng.uniform([4e-3, -7e-3, -13e-3], [8e-3, 7e-3, 13e-3])
        touch = first_touch(table, pose)
        forces = [elastic_force(table, pose, touch + depth)[1] for depth in np.linspace(0.0, 0.2e-3, 41)]
        assert (np.diff(forces) > 0.0).all(), pose


def test_every_pose_in_range_is_defined(table):
    """Somewhere it touches, everything that comes back is a number, and penetrations are positive."""
    s = table.settings
    rng = np.random.default_rng(6)
    for pose in rng.uniform(-1, 1, (5000, 3)) * [s.y_range, s.roll_range, s.yaw_range]:
        rows = loaded(table, pose, 0.02)
        assert len(rows) >= 1 and np.isfinite(rows).all() and (rows[:, Node.GAP] > 0.0).all()


@pytest.mark.parametrize("axis", range(3), ids=["y", "roll", "yaw"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 0.021, -0.021])
def test_off_the_table(table, axis, value):
    """Not a number, infinite or out of range: -1, before any index is made of it."""
    pose = [0.0, 0.0, 0.0]
    pose[axis] = value
    assert loaded(table, pose, 1e-3) is None


def test_edge_of_the_table_belongs_to_it(table):
    s = table.settings
    for signs in np.ndindex(2, 2, 2):
        pose = (2 * np.array(signs) - 1) * [s.y_range, s.roll_range, s.yaw_range] * (1 - 1e-12)
        assert loaded(table, pose, 0.03) is not None


def pressed(system, pose, depth=0.15e-3):
    """Coordinates of a wheelset in a pose (y, roll, yaw), its axle this much below a centred wheel's first touch."""
    q = system.rest.copy()
    q[0] += 5.0, pose[0], touching_depth(system.model) + depth, pose[1], 0.0, pose[2]
    return q


def wheelset_at(table, pose, velocity=(0.0, 0.0, 0.0)):
    """A wheelset pressed into both rails in a pose (y, roll, yaw), rolling, with lateral, roll and yaw velocity."""
    system = scenes.lone_wheelset(table, 20.0)
    q = pressed(system, pose)
    v = np.array([[20.0, velocity[0], 0.01, velocity[1], -20.0 / table.settings.radius, velocity[2]]])
    return scenes.data_at(system.model, q, v)


@pytest.mark.parametrize("pose", [(2e-3, 0.05e-3, 3e-3), (6.2e-3, -1e-3, 5e-3), (-6.1e-3, 0.0, 2e-3)])
def test_left_wheel_mirrors_the_right(table, pose):
    """A mirrored pose and motion give mirrored forces: the wheels change places, Y and the moments change sign."""
    motion = np.array([0.02, 0.03, -0.01])
    one, two = wheelset_at(table, pose, motion), wheelset_at(table, -np.array(pose), -motion)
    assert one.rail["patches"].sum() >= 2
    for key, sign in (("x", 1.0), ("y", -1.0), ("q", 1.0)):
        assert_allclose(two.rail[key][::-1], sign * one.rail[key], rtol=tol.MIRROR, atol=tol.MIRROR * 1e5)
    assert_allclose(two.load[0], one.load[0] * [1, -1, 1, -1, 1, -1], rtol=0, atol=tol.MIRROR * 1e5)


@pytest.mark.parametrize("pose", [(0.0, 0.0, 2e-3), (6.2e-3, -1e-3, 8e-3)])
def test_normal_forces_meet_the_axle(table, pose):
    """Without friction the rails give no moment about the axle and none of their force points along the rail."""
    system = scenes.lone_wheelset(table, 20.0, friction=0.0)
    q = pressed(system, pose)
    data = scenes.data_at(system.model, q, np.array([[20.0, 0.1, 0.0, 0.0, -50.0, 0.2]]))
    size = np.abs(data.rail["q"]).max()
    assert size > 1e4
    assert abs(data.load[0, 4]) < tol.MIRROR * size
    assert_allclose(data.rail["x"], 0.0, atol=tol.MIRROR * size)


def test_spin_gives_no_approach(table):
    """The approach of a yawed flange does not depend on how fast the wheel spins."""
    system = scenes.lone_wheelset(table, 20.0)
    q = pressed(system, (6.4e-3, 0.0, 10e-3))
    still, spinning = (scenes.data_at(system.model, q, np.array([[20.0, 0, 0, 0, w, 0]])) for w in (0.0, -60.0))
    assert_allclose(still.contact["normal"], spinning.contact["normal"], rtol=tol.MIRROR)


@pytest.mark.parametrize("falling", [{}, {"friction_ratio": 0.4, "friction_decay": 20.0}], ids=["", "falling"])
@pytest.mark.parametrize("law", CREEP_LAWS)
def test_creep_damping_is_the_slope_of_the_loads(table, law, falling):
    """data.creep_damping = -d load / d v of the creep forces, at constant normal forces and speed, by differences."""
    speed = 20.0
    system = scenes.lone_wheelset(table, speed, creep_law=law, damping=0.0, **falling)
    smooth = scenes.edited(system, "wheel", friction=0.0)
    q = pressed(system, (6.0e-3, 0.0, 1.0e-3))
    v = np.array([speed, 0.01, 0.0, 0.0, -speed / table.settings.radius * 1.0005, 0.005])

    def creep_load(v):
        with_friction, without = (scenes.data_at(one.model, q, v[None]).load[0].copy() for one in (system, smooth))
        return with_friction - without

    data = scenes.data_at(system.model, q, v[None])
    assert data.rail["patches"].sum() >= 3
    h = 1e-6
    slopes = np.column_stack([-(creep_load(v + h * e) - creep_load(v - h * e)) / (2 * h) for e in np.eye(6)])
    assert_allclose(data.creep_damping[0], slopes, rtol=0, atol=tol.CREEP_SLOPE * np.abs(slopes).max())


@pytest.mark.parametrize(
    "change, status",
    [((1, 0.03), Status.LEFT_TABLE), ((3, 0.02), Status.LEFT_TABLE), ((1, np.nan), Status.NOT_FINITE)],
    ids=["aside", "rolled", "not a number"],
)
def test_faults_name_the_culprit(table, change, status):
    """A wheel off its table and a pose that is not a number end the step with a status, not with a crash."""
    system = scenes.lone_wheelset(table, 20.0)
    data = system.start(5.0)
    data.q[(0, *change[:1])] = change[1]
    assert evaluate(system.model, data, 0.0) == status
