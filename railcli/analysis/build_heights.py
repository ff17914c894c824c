"""Tables of heights from profiles: where the wheel stores given energies, and its patches there (theory.md 6.8)."""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from railcli.errors import InputError
from railcli.kernels.branches import PER_CORNER
from railcli.kernels.columns import fill_columns
from railcli.kernels.difference import height
from railcli.kernels.layout import LEVELS, PARTS, ROW
from railcli.kernels.tabulate import solve_orientation
from railcli.model.heights import DEPTHS, LEAST, ORDER, STORED
from railcli.model.strips import strips_at

NO_CONTACT = "at some position of the table no part of the wheel stands on the rail's running surface"
TOLERANCE, MOST = 1e-4, 12  # share of the energy that the last iteration adds, and iterations
ROUGH, ROUGH_MOST = 1e-4, 10  # where only the grid is chosen
ACCURACY = 2e-3  # error of a height over its depth that the grid allows
LEAST_ERROR = 0.08e-6  # that is not worth refinement [m]
LEAST_DEPTH = 12e-6  # over which errors are measured [m]
LIFTED, CLIMBED = 6e-3, 4.0  # height [m] of a wheel that has climbed its flange, and by what its error may be greater
LINES = (  # roll [rad] and yaw^2 [rad^2] along which the knots of y are chosen
    (0.0, 0.0), (-8e-3, 0.0), (4e-3, 2e-5), (2e-3, 1e-4), (12e-3, 4e-4)
)  # fmt: skip
FIRST = 2e-3  # first distance of the knots of y [m]
FINEST = 0.02e-3  # and least [m]
USUAL_ROLL = 10e-3  # roll of a wheelset that runs [rad]
ROLL_STEPS = 1e-3, 2.5e-3  # distances of the knots of roll up to that and beyond [rad]
YAW2_STEP = 7.5e-5  # [rad^2]
TILTS = 8e-3, 3e-4  # changes of roll [rad] and yaw^2 [rad^2] over which the flange's place is followed
STEEP = 1.0  # slope of a contact on the flange [-]
GENTLE = 0.27  # and of one that has left the tread [-]
SCAN = 0.02e-3  # of the lateral position in the search for them [m]


class Stored(NamedTuple):
    """What a table of heights is made of; poses ordered roll, yaw^2, y (fastest)."""

    counts: tuple  # knots of y, roll and yaw^2
    shear: tuple  # the grid is in y less these times roll and yaw^2 [m/rad, m/rad^2]
    axes: tuple  # knots [m], [rad], [rad^2]
    values: np.ndarray  # (n_roll, n_yaw2, n_y, LEVELS) [m]
    minima: np.ndarray  # (n_pose,) minima of D at each pose
    lateral: np.ndarray  # (n,) their places on the wheel [m]
    basin: np.ndarray  # (n, 2) ends of their basins [m]
    parts: np.ndarray  # (n PARTS, ROW) as `columns.fill_columns`


class Columns:
    """Heights of a wheel over lateral positions, orientation by orientation."""

    def __init__(self, mounting, settings, station):
        self.mounting, self.station = mounting, station
        strips = strips_at(mounting, DEPTHS)
        self.strips = np.concatenate([each.strip for each in strips])
        self.first = np.cumsum([0, *(each.strip.size for each in strips)])
        self.apart = np.concatenate([each.apart.ravel() for each in strips])
        self.elastic = settings.young / (2.0 * (1.0 - settings.poisson**2))
        self.evaluations = self.crowded = self.solutions = 0

    def __call__(self, y, roll, yaw2, tolerance=TOLERANCE, most=MOST, method=0, patches=False):
        """Heights at positions y [m].

        Returns
        -------
        heights : array (n_y, LEVELS)
            [m]
        found, counts, parts
            Minima of D, as `tabulate.solve_orientation` says, and rows of `columns.fill_columns`; empty unless patches.
        """
        found, counts = self.minima(y, roll, yaw2, method)
        heights = np.zeros((y.size, LEVELS))
        parts = np.zeros((PARTS * int(counts.sum()) if patches else 0, ROW))
        solved = fill_columns(
            roll, math.sqrt(yaw2), y, *self.mounting.kernel_arguments, self.strips, self.first, self.apart,
            self.elastic, STORED, tolerance, most, found, counts, heights, parts,
        )  # fmt: skip
        if solved < 0:
            raise InputError("contact geometry", f"{NO_CONTACT}; choose a smaller range of y or roll")
        self.solutions += solved
        return heights, found, counts, parts

    def minima(self, y, roll, yaw2, method=0):
        """Minima of D, as `tabulate.solve_orientation` says."""
        found, counts = np.zeros((y.size, PER_CORNER, 6)), np.zeros(y.size, np.int64)
        used, full = solve_orientation(
            method, roll, math.sqrt(yaw2), y, *self.mounting.kernel_arguments, self.station, found, counts
        )
        self.evaluations, self.crowded = self.evaluations + used, self.crowded + full
        return found, counts

    def wheel_slope(self, s):
        """Of the profile at s [m]."""
        return height(self.mounting.wheel, self.mounting.wheel_start, self.mounting.wheel_step, s)[1]


def refined(knots, evaluate, finest, accuracy):
    """Knots of one axis, halved until the spline through them is accurate midway.

    Parameters
    ----------
    knots : array
        To begin with.
    evaluate : callable
        Of positions (n,): heights (lines, n, LEVELS) [m].
    finest : float
        No interval is less than this.
    accuracy : float
        Error of a height over the depth beyond the least of its column.
    """
    from scipy.interpolate import make_interp_spline

    values = evaluate(knots)
    left = np.ones(knots.size - 1, bool)
    while left.any():
        middle = 0.5 * (knots[:-1] + knots[1:])[left]
        true = evaluate(middle)
        guess = make_interp_spline(knots, values, k=ORDER, axis=1)(middle)
        allowed = np.maximum(accuracy * (true - true[..., :1] + LEAST_DEPTH), LEAST_ERROR * accuracy / ACCURACY)
        allowed = np.where(true[..., :1] < -LIFTED, CLIMBED * allowed, allowed)
        worst = (np.abs(guess - true) / allowed).max(axis=(0, 2))
        wide = (knots[1:] - knots[:-1])[left] > 1.99 * finest
        order = np.argsort(np.concatenate([knots, middle]))
        split = np.zeros(order.size - 1, bool)
        parents = np.flatnonzero(left)
        knots = np.concatenate([knots, middle])[order]
        values = np.concatenate([values, true], axis=1)[:, order]
        for k, parent in enumerate(parents):
            at = parent + k
            split[at : at + 2] = worst[k] > 1.0 and wide[k]
        left = split
    return knots


def shears(columns, y_range):
    """How far to the right the flange's contact is found per roll [m/rad] and per yaw^2 [m/rad^2].

    Jumps of the contact lie along one lateral position of a grid that follows them. Over roll two jumps differ, to the
    root and to the flank: their mean; over yaw^2 it is the flank that moves.
    """
    y = np.arange(0.0, y_range, SCAN)

    def jump(roll, yaw2, slope):
        found, counts = columns.minima(y, roll, yaw2)
        for i, each in enumerate(y):
            if not counts[i]:
                continue
            deepest = found[i, np.argmin(found[i, : counts[i], 1]), 0]
            if columns.wheel_slope(deepest) < -slope:
                return each
        return None

    def rate(slope, roll, yaw2, per):
        low, high = jump(-roll, 0.0, slope), jump(roll, yaw2, slope)
        return 0.0 if low is None or high is None else (high - low) / per

    roll = [rate(slope, TILTS[0], 0.0, 2.0 * TILTS[0]) for slope in (GENTLE, STEEP)]
    return 0.5 * sum(roll), rate(STEEP, 0.0, TILTS[1], TILTS[1])


def knots_of(columns, settings, shear, accuracy=1.0):
    """Knots of the sheared lateral position [m], of roll [rad] and yaw^2 [rad^2] over the range of the settings.

    shear : as `shears`: the grid is in y - shear[0] roll - shear[1] yaw^2.  accuracy : divides the distances.
    """
    reach = settings.y_range + abs(shear[0]) * settings.roll_range + abs(shear[1]) * settings.yaw_range**2

    def rough(x):
        return np.array([
            columns(x + shear[0] * roll + shear[1] * yaw2, roll, yaw2, ROUGH, ROUGH_MOST)[0]
            for roll, yaw2 in LINES
        ])  # fmt: skip

    y = refined(even(-reach, reach, FIRST), rough, FINEST / accuracy, ACCURACY / accuracy**4)
    usual = min(USUAL_ROLL, settings.roll_range)
    inner = even(-usual, usual, ROLL_STEPS[0] / accuracy)
    outer = even(usual, settings.roll_range, ROLL_STEPS[1] / accuracy)[1:] if settings.roll_range > usual else []
    roll = np.concatenate([-np.flip(outer), inner, outer])
    return y, roll, even(0.0, settings.yaw_range**2, YAW2_STEP / accuracy)


def even(low, high, step):
    """Evenly spaced knots, at most a step apart."""
    return np.linspace(low, high, max(math.ceil((high - low) / step * (1.0 - 1e-9)) + 1, LEAST))


def store_heights(columns, settings, method=0, progress=None, accuracy=1.0):
    """Heights and patches over a grid of poses, two orientations at a time where there are two cores.

    Parameters
    ----------
    columns : Columns
    settings : TableSettings
    method : int
        Search for the minima of D, as `difference.minima`.
    progress : callable, optional
        Called with the share done, 0 ... 1.
    accuracy : float
        Divides the distances of knots.

    Returns
    -------
    Stored
    """
    shear = shears(columns, settings.y_range)
    y, rolls, yaws2 = axes = knots_of(columns, settings, shear, accuracy)
    values = np.empty((rolls.size, yaws2.size, y.size, LEVELS))
    poses = [(i, j) for i in range(rolls.size) for j in range(yaws2.size)]

    def solve(pose):
        i, j = pose
        at = y + shear[0] * rolls[i] + shear[1] * yaws2[j]
        values[i, j], found, counts, part = columns(at, rolls[i], yaws2[j], method=method, patches=True)
        kept = np.arange(PER_CORNER) < counts[:, None]
        return counts, found[kept][:, [0, 4, 5]], part

    solved = []
    with ThreadPoolExecutor(usable_cores()) as pool:
        for number, each in enumerate(pool.map(solve, poses)):
            solved.append(each)
            if progress:
                progress(0.95 * (number + 1) / len(poses))
    counts, minima, parts = (np.concatenate(each) for each in zip(*solved, strict=True))
    basin = np.where(np.isfinite(minima[:, 1:]), minima[:, 1:], [-np.inf, np.inf])
    return Stored((y.size, rolls.size, yaws2.size), shear, axes, values, counts, minima[:, 0], basin, parts)


def usable_cores():
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
