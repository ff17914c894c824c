"""Tables of heights in the rows that the core reads (theory.md section 6.8)."""

import hashlib
import json

import numpy as np

from railcli.kernels.columns import POWER
from railcli.kernels.heights import BASIS, CREEP, HEAD, LEVEL_ROWS, PART_W, REGIONS, SHAPES, SHEAR, SLENDER
from railcli.kernels.kalker import coefficients as creep_coefficients
from railcli.kernels.layout import LEVELS, PART_LEVELS, PARTS, ROW

from . import strips

ORDER, LEVEL_ORDER = 2, 3  # of the splines over the pose and over w
LEAST = 4  # knots of an axis
BINS = 1024
BIN_ROWS = 1 + BINS // ROW
DEPTHS = np.array([5.0, 9.0, 15.0, 23.0, 34.0, 48.0, 66.0, 88.0, 115.0, 150.0, 200.0, 270.0]) * 1e-6
REFERENCE = 82e9  # N over depth^1.5 of the contact in which DEPTHS are reached, a usual one on a tread [N/m^1.5]
STORED = (0.4 * REFERENCE * DEPTHS**2.5) ** POWER  # w = U^POWER of the levels [J^POWER]


def making():
    """Digest of the splines, levels and strips of which tables of heights are made."""
    parts = [
        ORDER, LEVEL_ORDER, BINS, HEAD, DEPTHS.tolist(), REFERENCE, PART_LEVELS,
        strips.LEVEL_WIDTHS, strips.LEVEL_DEPTH, strips.HAT, strips.BEYOND,
    ]  # fmt: skip
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:16]


def pack(levels, regions, radius, poisson, shear, axes, values, parts):
    """Rows of a table of heights.

    Parameters
    ----------
    levels : array (LEVELS,)
        w = U^0.4 [J^0.4].
    regions : array (3,)
        Profile coordinates of the wheel that part tip | flank | root | tread [m].
    radius, poisson : float
        Of the tape circle [m]; of wheel and rail [-].
    shear : (float, float)
        The grid is in y less these times roll and yaw^2 [m/rad, m/rad^2].
    axes : three arrays
        Rising knots of that [m], roll [rad] and yaw^2 [rad^2]; the heights are given there.
    values : array (n_roll, n_yaw2, n_y, LEVELS)
        [m]
    parts : array (n, ROW)
        Of the contact, as `kernels.columns.fill_columns`.

    Returns
    -------
    array (n, ROW)
    """
    from scipy.interpolate import make_interp_spline

    head = np.zeros((HEAD, ROW))
    head[:LEVEL_ROWS] = _rows(levels)
    head[BASIS : BASIS + 2 * (LEVELS - 1)] = _rows(cubics(levels))
    head[PART_W, :PARTS] = levels[list(PART_LEVELS)]
    head[REGIONS, :3] = regions
    head[SHEAR, :3] = *shear, radius
    head[CREEP : CREEP + SHAPES] = _creep(poisson)
    coefficients = values
    for axis, knots in zip((2, 0, 1, 3), (*axes, levels), strict=True):
        order = LEVEL_ORDER if axis == 3 else ORDER
        coefficients = np.moveaxis(make_interp_spline(knots, coefficients, k=order, axis=axis).c, 0, axis)
    rows = [head]
    for knots in axes:
        rows += [_bins(knots), _rows(knots), _rows(parabolas(knots))]
    return np.ascontiguousarray(np.concatenate([*rows, _rows(coefficients), parts]))


def _creep(poisson):
    """Rows of Kalker's coefficients C11, C22, C23, C33 at even (a - b) / (a + b), and what they grow by to the next."""
    shape = np.linspace(-SLENDER, SLENDER, SHAPES + 1)
    found = np.array([creep_coefficients((1.0 + each) / (1.0 - each), poisson) for each in shape])
    return np.hstack([found[:-1], np.diff(found, axis=0)])


def places(counts):
    """Rows at which bins, knots and cubics of each axis in turn, coefficients, and the parts of the contact begin.

    counts : numbers of knots of y, roll and yaw^2.
    """
    found, at = [], HEAD
    for count in counts:
        found += [at, at + BIN_ROWS, at + BIN_ROWS + _row_count(count)]
        at = found[-1] + 2 * (count - 2)
    return [*found, at, at + _row_count(LEVELS * int(np.prod(counts)))]


def knots_of(heights, counts):
    """Knots of y, roll and yaw^2 from the rows of `pack`."""
    starts = places(counts)
    return [
        heights[start : start + _row_count(count)].ravel()[:count]
        for start, count in zip(starts[1:9:3], counts, strict=True)
    ]


def parabolas(knots):
    """The three B-splines around each knot within, by the distance from it: shape (n - 2, 4, 4), power first.

    Splines as scipy's `make_interp_spline` makes them: parabolas between the middles of intervals, but for the first
    and the last one. The fourth of either axis is nothing.
    """
    from scipy.interpolate import BSpline, make_interp_spline

    n = knots.size
    basis = BSpline(make_interp_spline(knots, np.zeros(n), k=ORDER).t, np.eye(n), ORDER)
    found = np.zeros((n - 2, 4, 4))
    for i in range(n - 2):
        for power in range(3):
            found[i, power, :3] = basis(knots[i + 1], nu=power)[i : i + 3] / (1, 1, 2)[power]
    return found


def cubics(levels):
    """The four B-splines over w above each level as cubics of the place, 0 ... 1: shape (n - 1, 4, 4), power first.

    Splines as scipy's `make_interp_spline` makes them: the second and the last but one level are no knots of theirs.
    """
    from scipy.interpolate import BSpline, make_interp_spline

    n = levels.size
    basis = BSpline(make_interp_spline(levels, np.zeros(n), k=LEVEL_ORDER).t, np.eye(n), LEVEL_ORDER)
    found = np.zeros((n - 1, 4, 4))
    place = np.array([0.05, 0.35, 0.65, 0.95])
    powers = np.linalg.inv(place[:, None] ** np.arange(4))
    for i in range(n - 1):
        first = min(max(i - 1, 0), n - 4)
        found[i] = powers @ basis(levels[i] + place * (levels[i + 1] - levels[i]))[:, first : first + 4]
    return found


def _bins(knots):
    """Rows that tell the interval in which each of BINS equal bins begins."""
    start = knots[0] + (knots[-1] - knots[0]) / BINS * np.arange(BINS)
    interval = np.clip(np.searchsorted(knots, start, side="right") - 1, 0, knots.size - 2)
    return np.concatenate([_rows([BINS / (knots[-1] - knots[0]), BINS]), _rows(interval)])


def _row_count(count):
    return -(-count // ROW)


def _rows(values):
    flat = np.ravel(values)
    padded = np.zeros(_row_count(flat.size) * ROW)
    padded[: flat.size] = flat
    return padded.reshape(-1, ROW)
