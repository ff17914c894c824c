"""Branches of a contact table: every minimum in one of them, and cells that agree about the faces they share."""

import numpy as np
import pytest
import tolerances as tol

from railcli.analysis.build_table import build_table
from railcli.kernels.branches import fill_slopes
from railcli.kernels.layout import NODE_CHANNELS, Node
from railcli.model.contact_table import TableSettings

REACH = TableSettings(normal="hertz", y_range=7e-3, yaw_range=30e-3 * 0.3**0.5, yaw_count=4)  # usual steps, all rolls
AROUND = (5.9e-3, 6.6e-3)  # where S1002 on UIC60 passes from tread to flange [m]


@pytest.fixture(scope="module")
def wide(profiles):
    return build_table(*profiles, REACH)[0]


def cells(table):
    """Branches (n, 8) of every cell as a nested list [roll][yaw^2][y]."""
    rows = np.split(table.branch, table.cell[1:-1])
    shape = REACH.roll_count - 1, REACH.yaw_count - 1, REACH.y_count - 1
    return np.array([*rows, None], dtype=object)[:-1].reshape(shape)


def on_face(rows, bit, upper):
    """What the branches of a cell hold at the corners of one face: a set of node groups, in the face's own order."""
    corners = [c for c in range(8) if (c >> bit & 1) == upper]
    groups = [tuple(int(k) for k in row[corners]) for row in rows]
    return sorted(group for group in groups if max(group) >= 0)


def near_the_flange():
    """Indices of the cells around the passage from tread to flange."""
    y = REACH.y_step * (np.arange(REACH.y_count - 1) - REACH.y_count // 2)
    return np.flatnonzero((y >= AROUND[0]) & (y <= AROUND[1]))


def test_cells_agree_about_their_faces(wide):
    """Two cells that share a face join its minima into the same groups: no contact jumps on the way across."""
    at = cells(wide)
    compared = ended = 0
    for ir in range(at.shape[0]):
        for iw in range(at.shape[1]):
            for iy in near_the_flange():
                for bit, after in enumerate([(ir, iw, iy + 1), (ir + 1, iw, iy), (ir, iw + 1, iy)]):
                    if after[0] == at.shape[0] or after[1] == at.shape[1]:
                        continue
                    here, there = on_face(at[ir, iw, iy], bit, 1), on_face(at[after], bit, 0)
                    assert here == there, f"cell roll {ir}, yaw {iw}, y {iy}, direction {bit}"
                    compared += 1
                    ended += any(min(group) < 0 for group in here)
    assert compared > 4000 and ended > 100


def test_every_minimum_is_in_one_branch_of_each_cell_around_it(wide):
    """A cell's corner holds the same minima for all cells that meet there, each in one branch, none twice."""
    at = cells(wide)
    held = {}
    for (ir, iw, iy), rows in np.ndenumerate(at):
        for c in range(8):
            pose = ir + (c >> 1 & 1), iw + (c >> 2), iy + (c & 1)
            nodes = rows[:, c][rows[:, c] >= 0]
            assert nodes.size == np.unique(nodes).size
            assert held.setdefault(pose, sorted(nodes)) == sorted(nodes)
    assert sum(len(nodes) for nodes in held.values()) == wide.node.shape[0]


def test_order_from_flange_to_field_side(wide):
    """Branches of a cell follow each other from the flange to the field side."""
    places = wide.node[wide.branch, Node.LATERAL]
    reached = wide.branch >= 0
    mean = np.sum(places * reached, axis=1) / reached.sum(axis=1)
    same_cell = np.ones(mean.size, bool)
    same_cell[wide.cell[:-1][wide.cell[:-1] < mean.size]] = False
    assert (np.diff(mean)[same_cell[1:]] >= 0.0).all()


STEPS = 0.5e-3, 1e-3, 1e-4  # of y, roll and yaw^2


def chain(values, direction):
    """Slopes of nodes that are linked one behind the other in one direction and hold these places."""
    node = np.zeros((len(values), NODE_CHANNELS))
    node[:, Node.LATERAL] = values
    link = np.full((len(values), 3), -1, np.int32)
    link[:-1, direction] = np.arange(1, len(values))
    fill_slopes(node, link, *STEPS)
    slopes = node[:, [Node.LATERAL_Y, Node.LATERAL_ROLL, Node.LATERAL_YAW2]]
    assert not np.delete(slopes, direction, axis=1).any() and not node[:, Node.SLOPE_Y].any()
    return slopes[:, direction]


@pytest.mark.parametrize("direction", range(3))
def test_slopes_of_a_parabola(direction):
    """Exact along a branch on one side of the vertex, its ends too."""
    x = STEPS[direction] * np.arange(12)
    expected = 0.3 + 2.0 * x / STEPS[direction]
    found = chain(0.3 * x + x**2 / STEPS[direction], direction)
    assert np.allclose(found, expected, rtol=0, atol=tol.PARABOLA_SLOPE)


def test_slopes_beside_a_fast_motion():
    """Where a contact runs from one place to another within a cell, the slopes beside it swing past neither."""
    found = chain([0.0, 0.1e-3, 0.2e-3, 10.2e-3, 10.3e-3, 10.4e-3], 0) * STEPS[0]
    assert (found > 0.0).all() and (found <= 0.2e-3 + tol.ROUNDING).all()


def test_slopes_of_short_branches():
    """One node has none, two have their difference."""
    assert chain([1.0], 0) == [0.0]
    assert np.allclose(chain([1.0, 3.0], 1), 2.0 / STEPS[1])
