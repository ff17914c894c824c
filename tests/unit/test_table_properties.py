"""Contact tables of random profiles: nothing missed, nothing invented, continuous, mirrored, defined or refused."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from railcli.analysis.build_table import build_table, solve_orientation, stations
from railcli.analysis.certify import certify
from railcli.errors import InputError
from railcli.files.profiles import load_profile
from railcli.kernels.branches import PER_CORNER
from railcli.kernels.contact import look_up
from railcli.kernels.layout import MAX_CONTACT, NODE_CHANNELS, Node
from railcli.kernels.step import evaluate
from railcli.model.contact_table import TableSettings, mount
from railcli.model.profile import Profile

GRID = {"y_range": 4e-3, "y_step": 0.25e-3, "roll_range": 4e-3, "roll_step": 2e-3, "yaw_range": 30e-3, "yaw_count": 6}
REACH = np.array([GRID["y_range"], GRID["roll_range"], GRID["yaw_range"]])
DEEP = 0.02  # deeper than any minimum of D [m]
SEVERAL = settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
UNIT = st.floats(-1.0, 1.0)
POSES = st.tuples(UNIT, UNIT, UNIT).map(lambda share: np.array(share) * REACH * (1.0 - 1e-9))


def hollow(profile, place, depth, width):
    """A profile worn by a bell-shaped hollow, normal to z."""
    y, z = profile.y, profile.z
    worn = depth * np.exp(-(((y - place) / width) ** 2))
    return Profile.from_points("worn", profile.kind, y, z + (worn if profile.kind == "rail" else -worn))


@st.composite
def cones(draw):
    return scenes.cone(draw(st.floats(0.0, 0.12))), scenes.round_rail(), scenes.round_settings(**GRID)


@st.composite
def circles(draw):
    """Hollow or crowned treads on a round rail."""
    bend = draw(st.floats(-20.0, 0.9 / scenes.HEAD))
    y = np.linspace(-0.05, 0.05, 401)
    slope = draw(st.floats(0.0, 0.08))
    wheel = Profile.from_points("circle", "wheel", y, 0.5 * bend * y**2 - slope * y)
    return wheel, scenes.round_rail(), scenes.round_settings(**GRID)


@st.composite
def splines(draw):
    """A cone with waves some millimetres long, which touches in several places at once."""
    knots = np.linspace(-0.05, 0.05, 13)
    height = np.array(draw(st.lists(st.floats(-0.15e-3, 0.15e-3), min_size=13, max_size=13)))
    y = np.linspace(-0.05, 0.05, 401)
    wheel = Profile.from_points("spline", "wheel", y, CubicSpline(knots, height)(y) - draw(st.floats(0.0, 0.1)) * y)
    return wheel, scenes.round_rail(), scenes.round_settings(**GRID)


@st.composite
def worn(draw):
    """S1002 with a hollow tread on UIC60 with a worn head, around the passage from tread to flange."""
    wheel = hollow(
        load_profile("ORES1002", "wheel"), draw(st.floats(-5e-3, 15e-3)), draw(st.floats(0.0, 1.5e-3)), 15e-3
    )
    rail = hollow(load_profile("UIC60", "rail"), draw(st.floats(-15e-3, 5e-3)), draw(st.floats(0.0, 1e-3)), 12e-3)
    return wheel, rail, TableSettings(normal="hertz", gauge=draw(st.floats(1.430, 1.440)), **{**GRID, "y_range": 8e-3})


PAIRS = st.one_of(cones(), circles(), splines(), worn())


def built(pair):
    """Table of a pair; one on whose treads no centred wheelset stands is refused and counts for nothing here."""
    wheel, rail, grid = pair
    try:
        return build_table(wheel, rail, grid)[0]
    except InputError:
        reject()


def looked_up(table, pose, depth=DEEP, node=None):
    """Rows of the loaded branches; None off the table."""
    sample = np.full((MAX_CONTACT, NODE_CHANNELS), np.nan)
    node = table.node if node is None else node
    count = look_up(table.record[0], node, table.cell, table.branch, *pose, depth, sample)
    return None if count < 0 else sample[: min(count, MAX_CONTACT)]


def surface(mounting, pose, s):
    """Lowest D over the circle at places s of the wheel, on a grid, from the graphs and the geometry alone [m]."""
    y, roll, yaw = pose
    sr, cr, sy, cy = np.sin(roll), np.cos(roll), np.sin(yaw), np.cos(yaw)
    axle, ahead, down = np.array([-sy * cr, cy * cr, sr]), np.array([cy, sy, 0.0]), np.array([sy * sr, -cy * sr, cr])
    wheel_s = mounting.wheel_start + mounting.wheel_step * np.arange(mounting.wheel.shape[0])
    rail_y = mounting.rail_start + mounting.rail_step * np.arange(mounting.rail.shape[0])
    radius = mounting.radius + CubicSpline(wheel_s, mounting.wheel[:, 0])(s)
    rail = CubicSpline(rail_y, mounting.rail[:, 0])
    slope = CubicSpline(wheel_s, mounting.wheel[:, 0])(s, 1)
    middle = slope * axle[0] - sy * sr
    turn = middle[:, None] + np.linspace(-6e-3, 6e-3, 49)
    place = (
        s[:, None, None] * axle
        + (radius[:, None] * np.sin(turn))[..., None] * ahead
        + (radius[:, None] * np.cos(turn) - mounting.radius)[..., None] * down
    )
    at = y + mounting.seat + place[..., 1]
    inside = (at > rail_y[0]) & (at < rail_y[-1])
    return np.where(inside, rail(np.clip(at, rail_y[0], rail_y[-1])) - place[..., 2], np.inf).min(axis=1)


def basins(place, value):
    """Minima of values on a grid: place, value, and the lower of the rises on both sides."""
    low = np.flatnonzero((value[1:-1] < value[:-2]) & (value[1:-1] <= value[2:])) + 1
    rows = []
    for k, i in enumerate(low):
        before = value[low[k - 1] : i].max() if k else np.inf
        after = value[i : low[k + 1]].max() if k + 1 < low.size else np.inf
        rows.append((place[i], value[i], min(before, after) - value[i]))
    return np.array(rows).reshape(-1, 3)


@SEVERAL
@given(PAIRS, POSES)
def test_no_basin_is_missed(pair, pose):
    """Every loaded dip of the difference surface that rises on both sides is found by the simplex, where it is."""
    wheel, rail, grid = pair
    mounting = mount(wheel, rail, grid)
    station = stations(mounting)
    found, counts = np.zeros((1, PER_CORNER, 6)), np.zeros(1, np.int64)
    solve_orientation(0, pose[1], abs(pose[2]), pose[:1], *mounting.kernel_arguments, station, found, counts)
    place = np.arange(station[0], station[-1], 20e-6)
    expected = basins(place, surface(mounting, pose, place))
    expected = expected[(expected[:, 1] < expected[:, 1].min() + 0.1e-3) & (expected[:, 2] > tol.SCAN_BARRIER)]
    for s, value, _ in expected:
        near = np.argmin(np.abs(found[0, : counts[0], 0] - s))
        assert abs(found[0, near, 1] - value) < tol.GRID_DIP, (s, value, found[0, : counts[0]])
        assert abs(found[0, near, 0] - s) < tol.GRID_DIP_PLACE, (s, value, found[0, : counts[0]])


@SEVERAL
@given(PAIRS, st.data())
def test_no_value_of_a_branch_that_does_not_exist(pair, data):
    """What the cell's branches do not reach may hold anything: it never enters."""
    table = built(pair)
    record = table.record[0]
    for _ in range(8):
        pose = data.draw(POSES)
        place = (pose * [1.0, 1.0, pose[2]] - [record["y_start"], record["roll_start"], 0.0]) / [
            record["y_step"], record["roll_step"], record["yaw2_step"],
        ]  # fmt: skip
        iy, ir, iw = np.minimum(place.astype(int), [record[f"{axis}_count"] - 2 for axis in ("y", "roll", "yaw2")])
        cell = (ir * (record["yaw2_count"] - 1) + iw) * (record["y_count"] - 1) + iy
        reached = table.branch[table.cell[cell] : table.cell[cell + 1]]
        node = np.full_like(table.node, 1e30)
        keep = np.unique(reached[reached >= 0])
        node[keep] = table.node[keep]
        node[0] = table.node[0]  # stands for a missing corner, with weight zero
        rows, poisoned = looked_up(table, pose), looked_up(table, pose, node=node)
        assert np.array_equal(rows, poisoned)
        assert len(rows) <= len(reached)


@SEVERAL
@given(PAIRS, POSES, POSES)
def test_first_touch_is_continuous(pair, start, end):
    """Along any straight way through the table the depth of first touch moves little by little."""
    table = built(pair)

    def touch(share):
        return DEEP - looked_up(table, start + share * (end - start))[:, Node.GAP].max()

    places = np.linspace(0.0, 1.0, 801)
    moves = np.abs(np.diff([touch(share) for share in places]))
    for k in np.argsort(moves)[-3:]:
        parts = np.abs(np.diff([touch(share) for share in np.linspace(places[k], places[k + 1], 65)]))
        assert parts.max() < max(0.1 * moves[k], tol.GAP_GRAIN), (start, end, places[k])


@SEVERAL
@given(PAIRS, POSES, st.tuples(UNIT, UNIT, UNIT))
def test_mirrored_wheelset_gives_mirrored_loads(pair, pose, motion):
    """Pose and motion mirrored: the wheels change places, lateral force, roll and yaw moment change sign."""
    system = scenes.lone_wheelset(built(pair), 20.0)
    pose = pose * [0.4, 0.1, 1.0]
    speed = np.array(motion) * [0.05, 0.05, 0.05]
    loads = []
    for sign in (1.0, -1.0):
        q = system.rest.copy()
        q[0] = 5.0, sign * pose[0], q[0, 2], sign * pose[1], 0.0, sign * pose[2]
        v = np.array([[20.0, sign * speed[0], 0.01, sign * speed[1], -43.0, sign * speed[2]]])
        data = system.start(5.0)
        data.q[:], data.v[:] = q, v
        assert evaluate(system.model, data, 0.0) == 0
        loads.append(data.load[0].copy())
    scale = max(np.abs(loads[0]).max(), 1e4)
    assert_allclose(loads[1], loads[0] * [1, -1, 1, -1, 1, -1], rtol=0, atol=tol.MIRROR * scale)


@SEVERAL
@given(PAIRS)
def test_no_contact_is_missed_or_invented(pair):
    """Loaded contacts at random poses, but near the ends of branches, are those of direct minimisation."""
    certificate = certify(built(pair), *pair[:2], poses=60)
    assert certificate["missed"] == 0 and certificate["invented"] == 0 and certificate["overfull"] == 0


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.fixture(scope="module")
def worst(profiles):
    """A coarse table of S1002 on UIC60, with folds and flange, and a wheelset on it."""
    table = build_table(*profiles, replace(scenes.SMALL, y_step=0.25e-3, roll_step=2.5e-3))[0]
    return table, scenes.lone_wheelset(table, 20.0)


@settings(max_examples=200, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(pose=st.tuples(FINITE, FINITE, FINITE), near=POSES, which=st.integers(0, 7), depth=FINITE)
def test_look_up_is_defined_or_refused(worst, pose, near, which, depth):
    """Any finite pose: in range all that comes back is a number; out of range by any axis it is refused."""
    table, _ = worst
    s = table.settings
    mixed = np.where([which & 1, which & 2, which & 4], pose, near * 0.9)
    rows = looked_up(table, mixed, depth)
    beyond = np.abs(mixed) - [s.y_range, s.roll_range, s.yaw_range]
    at_the_edge = (np.abs(beyond) < tol.ROUNDING).any()
    assert at_the_edge or (rows is None) == (beyond > 0.0).any()
    assert rows is None or np.isfinite(rows).all()


@settings(max_examples=200, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(near=POSES, depth=st.floats(-1e-3, 2e-3), v=st.lists(st.floats(-1e6, 1e6), min_size=6, max_size=6))
def test_no_nan_leaves_the_step(worst, near, depth, v):
    """Any pose and any finite motion: a status, or loads that are numbers."""
    _, system = worst
    data = system.start(5.0)
    data.q[0, [1, 3, 5]] = near * [1.0, 0.3, 1.0]
    data.q[0, 2] += depth
    data.v[0] = v
    if evaluate(system.model, data, 0.0) == 0:
        assert np.isfinite(data.load).all() and np.isfinite(data.dv).all()
        assert all(np.isfinite(data.contact[key]).all() for key in ("normal", "creep_x", "creep_t", "radius"))
