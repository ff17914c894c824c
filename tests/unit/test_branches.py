"""Branches of a contact table: every minimum in one of them, and cells that agree about the faces they share."""

import numpy as np
import pytest

from railcli.analysis.build_table import build_table
from railcli.model.contact_table import TableSettings

REACH = TableSettings(y_range=7e-3, yaw_range=30e-3 * 0.3**0.5, yaw_count=4)  # usual steps, all rolls
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
    places = wide.node[wide.branch, 4]
    reached = wide.branch >= 0
    mean = np.sum(places * reached, axis=1) / reached.sum(axis=1)
    same_cell = np.ones(mean.size, bool)
    same_cell[wide.cell[:-1][wide.cell[:-1] < mean.size]] = False
    assert (np.diff(mean)[same_cell[1:]] >= 0.0).all()
