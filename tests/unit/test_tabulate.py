"""Contact tables: what they hold at their nodes, between them, and in a pool of several."""

from dataclasses import replace

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import METHODS, build_table
from railcli.kernels.contact import look_up
from railcli.kernels.layout import MAX_CONTACT, NODE_CHANNELS, Node, Status, new_data
from railcli.kernels.step import evaluate
from railcli.model.system import pool

DEEP = 0.02  # deeper than any minimum of D [m]
KEPT = [Node.SLOPE, Node.LATERAL, Node.RADIUS, *range(Node.HERTZ, Node.F33 + 1)]


def contacts(record, arrays, pose, depth=DEEP):
    """Branches of one pose, all of them unless a smaller depth is given."""
    sample = np.full((MAX_CONTACT, NODE_CHANNELS), np.nan)
    count = look_up(record, *arrays, *pose, depth, sample)
    assert 0 <= count <= MAX_CONTACT
    return sample[:count]


def arrays(table):
    return table.node, table.cell, table.branch


@pytest.fixture(scope="module")
def twins(profiles):
    """The same coarse table by both methods."""
    settings = replace(scenes.SMALL, y_step=0.4e-3, roll_step=2.5e-3)
    return [build_table(*profiles, settings, method)[0] for method in METHODS]


def test_both_methods_build_the_same_table(twins):
    """Simplex and locus: the contacts within 0.1 mm of the deepest, at random poses."""
    rng = np.random.default_rng(1)
    agreed = 0
    for pose in rng.uniform(-1, 1, (2000, 3)) * [9.9e-3, 7.4e-3, 13e-3]:
        rows = [contacts(table.record[0], arrays(table), pose) for table in twins]
        loaded = [np.count_nonzero(found[:, Node.GAP] > found[:, Node.GAP].max() - 0.1e-3) for found in rows]
        deepest = [found[np.argmax(found[:, Node.GAP])] for found in rows]
        assert_allclose(*(row[Node.GAP] for row in deepest), rtol=0, atol=tol.SIMPLEX_GAP)
        assert_allclose(*(row[Node.LATERAL] for row in deepest), rtol=0, atol=tol.SIMPLEX_PLACE)
        agreed += loaded[0] == loaded[1]
    assert agreed > 0.98 * 2000


def test_nodes_come_back_as_they_are(table):
    """At a pose of the grid the look-up gives the nodes of that pose, every branch of them."""
    settings, record = table.settings, table.record[0]
    rng = np.random.default_rng(2)
    shape = (settings.roll_count - 1, settings.yaw_count - 1, settings.y_count - 1)
    for _ in range(500):
        ir, iw, iy = (rng.integers(n) for n in shape)
        cell = (ir * shape[1] + iw) * shape[2] + iy
        corner = table.branch[table.cell[cell] : table.cell[cell + 1], 0]
        expected = table.node[corner[corner >= 0]]
        expected[:, Node.RADIUS] += 0.5 * expected[:, Node.WHEEL_SLOPE] * expected[:, Node.LATERAL]
        pose = (
            record["y_start"] + iy * settings.y_step + 1e-15,
            record["roll_start"] + ir * settings.roll_step + 1e-16,
            np.sqrt(iw * record["yaw2_step"]) * (1 + 1e-13),
        )
        found = contacts(record, arrays(table), pose)
        assert len(found) == len(expected)
        assert_allclose(DEEP - found[:, Node.GAP], expected[:, Node.GAP], rtol=0, atol=tol.AT_A_NODE)
        assert_allclose(found[:, KEPT], expected[:, KEPT], rtol=tol.AT_A_NODE_RELATIVE, atol=tol.AT_A_NODE)


@pytest.mark.parametrize("angle", [0.025, 0.1])
def test_smooth_surface_between_the_nodes(angle):
    """Cones on round rails have closed forms: between nodes 1 mm and 1 mrad apart their D is exact to nanometres."""
    table = scenes.cone_table(angle)
    settings = table.settings
    rng = np.random.default_rng(3)
    for pose in rng.uniform(-1, 1, (300, 3)) * [settings.y_range, settings.roll_range, settings.yaw_range]:
        (row,) = contacts(table.record[0], arrays(table), pose)
        s, gap, lean, radius = naive.cone_on_circle(pose, angle, settings.radius, scenes.HEAD)
        expected = -np.tan(lean), s, radius
        assert_allclose(DEEP - row[Node.GAP], gap, rtol=0, atol=tol.SMOOTH_GAP)
        assert_allclose(row[[Node.SLOPE, Node.LATERAL, Node.RADIUS]], expected, rtol=0, atol=tol.SMOOTH_PLACE)


@pytest.mark.parametrize("direction", range(3), ids=["y", "roll", "yaw"])
def test_first_touch_is_continuous(table, direction):
    """The deepest contact changes without a step, also where it jumps from tread to flange: no force falls in."""
    rng = np.random.default_rng(4 + direction)
    reach = np.array([9.9e-3, 7.4e-3, 13e-3])
    step = np.array([4e-6, 10e-6, 10e-6])[direction]

    def first_touch(place, pose):
        pose = np.where(np.arange(3) == direction, place, pose)
        return DEEP - contacts(table.record[0], arrays(table), pose)[:, Node.GAP].max()

    for pose in rng.uniform(-1, 1, (6, 3)) * reach:
        places = np.arange(-reach[direction], reach[direction], step)
        moves = np.abs(np.diff([first_touch(place, pose) for place in places]))
        for k in np.argsort(moves)[-4:]:
            parts = np.abs(np.diff([first_touch(place, pose) for place in np.linspace(places[k], places[k + 1], 65)]))
            assert parts.max() < max(0.1 * moves[k], tol.GAP_GRAIN), (pose, places[k])


def test_pool_of_two(profiles, twins):
    """In a pool each wheel reads its own table: wheels of another radius and the first ones as before."""
    other = build_table(*profiles, replace(twins[0].settings, radius=0.42))[0]
    records, *shared, _ = pool([twins[0], other])
    rng = np.random.default_rng(5)
    for pose in rng.uniform(-1, 1, (100, 3)) * [9.9e-3, 7.4e-3, 13e-3]:
        for record, table in zip(records, (twins[0], other), strict=True):
            assert_allclose(contacts(record, shared, pose), contacts(table.record[0], arrays(table), pose), rtol=0)
    assert abs(contacts(records[1], shared, (0, 0, 0))[0, Node.RADIUS] - 0.42) < 1e-3


@pytest.mark.parametrize("lift, status", [(0.029, Status.OK), (0.031, Status.DERAILED)])
def test_lifted_wheelset_has_derailed(table, lift, status):
    """Beyond the height of its flange, 30 mm with its margin, a wheel is no longer on its rail."""
    system = scenes.lone_wheelset(table, 20.0)
    data = new_data(system.model, system.rest, 0)
    data.q[0, 2] -= lift
    assert evaluate(system.model, data, 0.0) == status
    assert status == Status.OK or data.fault[0] == 0
