"""Tables of heights in the rows that the core reads (theory.md section 6.8)."""

import numpy as np

from railcli.kernels.heights import HEAD, REGIONS, SHEAR, WEIGHTS
from railcli.kernels.layout import HEIGHTS

ORDER = 3
LEAST = ORDER + 1  # knots of an axis
BINS = 1024
BIN_ROWS = 1 + BINS // HEIGHTS


def pack(levels, regions, shear, axes, values, parts):
    """Rows of a table of heights.

    Parameters
    ----------
    levels : array (HEIGHTS,)
        w = U^0.4 [J^0.4].
    regions : array (3,)
        Profile coordinates of the wheel that part tip | flank | root | tread [m].
    shear : (float, float)
        The grid is in y less these times roll and yaw^2 [m/rad, m/rad^2].
    axes : three arrays
        Rising knots of that [m], roll [rad] and yaw^2 [rad^2]; the heights are given there.
    values : array (n_roll, n_yaw2, n_y, HEIGHTS)
        [m]
    parts : array (n, HEIGHTS)
        Of the contact, as `kernels.columns.fill_columns`.

    Returns
    -------
    array (n, HEIGHTS)
    """
    from scipy.interpolate import make_interp_spline

    head = np.zeros((HEAD, HEIGHTS))
    head[0] = levels
    head[WEIGHTS : WEIGHTS + 3] = slope_weights(levels).T
    head[REGIONS, :3] = regions
    head[SHEAR, :2] = shear
    coefficients = values
    for axis, knots in zip((2, 0, 1), axes, strict=True):
        coefficients = np.moveaxis(make_interp_spline(knots, coefficients, k=ORDER, axis=axis).c, 0, axis)
    rows = [head]
    for knots in axes:
        rows += [_bins(knots), _rows(knots), _rows(cubics(knots))]
    return np.ascontiguousarray(np.concatenate([*rows, coefficients.reshape(-1, HEIGHTS), parts]))


def places(counts):
    """Rows at which bins, knots and cubics of each axis in turn, coefficients, and the parts of the contact begin.

    counts : numbers of knots of y, roll and yaw^2.
    """
    found, at = [], HEAD
    for count in counts:
        found += [at, at + BIN_ROWS, at + BIN_ROWS + _row_count(count)]
        at = found[-1] + 2 * (count - 1)
    return [*found, at, at + int(np.prod(counts))]


def knots_of(heights, counts):
    """Knots of y, roll and yaw^2 from the rows of `pack`."""
    starts = places(counts)
    return [
        heights[start : start + _row_count(count)].ravel()[:count]
        for start, count in zip(starts[1:9:3], counts, strict=True)
    ]


def slope_weights(levels):
    """Weights (HEIGHTS, 3) that give dz/dw at every level by the parabola through it and its neighbours [1/J^0.4]."""
    found = np.zeros((HEIGHTS, 3))
    for i, x in enumerate(levels):
        k = min(max(i - 1, 0), HEIGHTS - 3)
        a, b, c = levels[k : k + 3]
        found[i] = (
            (2 * x - b - c) / ((a - b) * (a - c)),
            (2 * x - a - c) / ((b - a) * (b - c)),
            (2 * x - a - b) / ((c - a) * (c - b)),
        )
    return found


def cubics(knots):
    """The four B-splines of each interval as cubics of the place in it, 0 ... 1: shape (n - 1, 16), power fastest.

    Splines as scipy's `make_interp_spline` makes them: the second and the last but one knot are none of theirs.
    """
    from scipy.interpolate import BSpline, make_interp_spline

    n = knots.size
    basis = make_interp_spline(knots, np.eye(n), k=ORDER)
    basis = BSpline(basis.t, np.eye(n), ORDER)
    found = np.zeros((n - 1, 4, 4))
    place = np.array([0.05, 0.35, 0.65, 0.95])
    powers = np.linalg.inv(place[:, None] ** np.arange(4))
    for i in range(n - 1):
        first = min(max(i - 1, 0), n - LEAST)
        at = knots[i] + place * (knots[i + 1] - knots[i])
        found[i] = (powers @ basis(at)[:, first : first + 4]).T
    return found.reshape(n - 1, 16)


def _bins(knots):
    """Rows that tell the interval in which each of BINS equal bins begins."""
    start = knots[0] + (knots[-1] - knots[0]) / BINS * np.arange(BINS)
    interval = np.clip(np.searchsorted(knots, start, side="right") - 1, 0, knots.size - 2)
    return np.concatenate([_rows([BINS / (knots[-1] - knots[0]), BINS]), _rows(interval)])


def _row_count(count):
    return -(-count // HEIGHTS)


def _rows(values):
    flat = np.ravel(values)
    padded = np.zeros(_row_count(flat.size) * HEIGHTS)
    padded[: flat.size] = flat
    return padded.reshape(-1, HEIGHTS)
