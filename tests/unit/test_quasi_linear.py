"""Quasi-linear contact: harmonics with a closed form, and the table that carries the lines."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.quasi_linear import PATCH, QuasiLinear, harmonics, linear_table
from railcli.kernels.contact import enter, look_up
from railcli.kernels.layout import NODE_CHANNELS, SAMPLE_ROWS, Node
from railcli.model.contact_table import TableSettings

LINE = QuasiLinear(
    3e-3, 0.18, 0.18, 15.0, -0.06, -4.0, -1.1e-3, 0.4602, 0.13e-3, tuple(range(1, 1 + len(PATCH))), False
)  # fmt: skip


@pytest.mark.parametrize(
    "function, mean, slope",
    [
        (lambda y, a: 2.0 + 3.0 * y, 2.0, lambda a: 3.0),
        (lambda y, a: y**3, 0.0, lambda a: 0.75 * a**2),
        (lambda y, a: y**2, lambda a: 0.5 * a**2, lambda a: 0.0),
        (lambda y, a: np.where(y > 0.0, 1.0, -1.0), 0.0, lambda a: 4.0 / (np.pi * a)),
    ],
    ids=["line", "cubic", "square", "jump"],
)
@pytest.mark.parametrize("amplitude", [1.0, 2.5])
def test_describing_functions(function, mean, slope, amplitude):
    """Closed forms of harmonic linearisation (Gelb and Vander Velde 1968)."""
    y = np.linspace(-3.0, 3.0, 6001)
    y = np.sort(np.append(y[y != 0.0], [-1e-9, 1e-9]))
    found = harmonics(y, function(y, amplitude), amplitude)
    wanted = mean(amplitude) if callable(mean) else mean, slope(amplitude)
    assert_allclose(found, wanted, atol=tol.DESCRIBING)


def test_packed_lines_give_the_path_back():
    """On the path on which both wheels touch, the table shows conicity, contact angle, roll and place that went in."""
    settings = TableSettings(normal="hertz", inclination=40.0)
    table = linear_table(LINE, settings)
    record = table.record[0]
    sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))

    def wheel(side, y, roll):
        u, z = enter(side, settings.lateral, settings.radius, y, 0.0, np.sin(roll), np.cos(roll), 1.0)
        count = look_up(record, table.node, table.cell, table.branch, u, side * roll, 0.0, 1.0, sample)
        assert count == 1
        return z - (1.0 - sample[0, Node.GAP]), sample[0].copy()

    y = 1e-4
    roll = LINE.roll * y
    right, left = wheel(1.0, y, roll), wheel(-1.0, y, roll)
    assert right[0] == pytest.approx(left[0], abs=tol.BOTH_TOUCH)
    right, left = right[1], left[1]
    assert 0.5 * (right[Node.RADIUS] - left[Node.RADIUS]) / y == pytest.approx(LINE.conicity, rel=tol.LINE)
    assert -0.5 * (right[Node.SLOPE] - left[Node.SLOPE]) / y == pytest.approx(LINE.angle, rel=tol.LINE)
    assert 0.5 * (right[Node.LATERAL] - left[Node.LATERAL]) / y == pytest.approx(LINE.travel, rel=tol.LINE)
    assert [right[Node[name]] for name in PATCH] == pytest.approx(list(LINE.patch))


def test_slopes_in_the_table_are_those_of_its_distance():
    """dD/dy, dD/droll of a node's channels against differences of D between nodes."""
    settings = TableSettings(normal="hertz", inclination=40.0)
    table = linear_table(LINE, settings)
    record = table.record[0]
    node = table.node.reshape(record["roll_count"], record["yaw2_count"], record["y_count"], NODE_CHANNELS)
    gap = node[..., Node.GAP]
    for axis, channel, step in ((2, Node.SLOPE, "y_step"), (0, Node.GAP_ROLL, "roll_step"),
                                (1, Node.GAP_YAW2, "yaw2_step")):  # fmt: skip
        slope = np.moveaxis(node[..., channel], axis, 0)
        rise = np.diff(np.moveaxis(gap, axis, 0), axis=0) / record[step]
        assert_allclose(0.5 * (slope[1:] + slope[:-1]), rise, atol=tol.DESCRIBING)
