"""Polylines in the plane: turning angles, and where one meets itself."""

import math

import numpy as np

PAIRS_AT_ONCE = 1_000_000


def turns(y, z):
    """Angle by which the polyline turns at each inner point [rad], -pi..pi, positive from y towards z."""
    direction = np.arctan2(np.diff(z), np.diff(y))
    return np.remainder(np.diff(direction) + math.pi, 2.0 * math.pi) - math.pi


def meeting(y, z):
    """Two segments of the polyline that meet without being neighbours, or None."""
    order = np.argsort(np.minimum(y[:-1], y[1:]), kind="stable")
    low, high = np.minimum(y[:-1], y[1:])[order], np.maximum(y[:-1], y[1:])[order]
    count = np.searchsorted(low, high, side="right") - np.arange(low.size) - 1
    total = np.cumsum(count)
    start = 0
    while start < count.size:
        stop = max(start + 1, int(np.searchsorted(total, total[start] + PAIRS_AT_ONCE)))
        first = np.repeat(np.arange(start, stop), count[start:stop])
        offset = np.arange(first.size) - np.repeat(np.cumsum(count[start:stop]) - count[start:stop], count[start:stop])
        i, j = order[first], order[first + 1 + offset]
        i, j = i[np.abs(i - j) > 1], j[np.abs(i - j) > 1]
        overlap = np.minimum(np.maximum(z[i], z[i + 1]), np.maximum(z[j], z[j + 1])) >= np.maximum(
            np.minimum(z[i], z[i + 1]), np.minimum(z[j], z[j + 1])
        )
        i, j = i[overlap], j[overlap]
        apart = (_side(y, z, i, j) * _side(y, z, i, j + 1) > 0.0) | (_side(y, z, j, i) * _side(y, z, j, i + 1) > 0.0)
        if not apart.all():
            k = int(np.argmin(apart))
            return int(i[k]), int(j[k])
        start = stop
    return None


def _side(y, z, segment, point):
    """Sign says on which side of a segment's line a point lies."""
    along_y, along_z = y[segment + 1] - y[segment], z[segment + 1] - z[segment]
    return np.sign(along_y * (z[point] - z[segment]) - along_z * (y[point] - y[segment]))
