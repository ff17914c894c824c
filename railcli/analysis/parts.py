"""A measured alignment split into the straights, curves and transitions that it was built as.

Curvature over the position becomes a polyline with as few corners as keep it within a tolerance (Ramer, Douglas and
Peucker); its level pieces are straights and curves, the others transitions. A dense recording whose curvature is rough
is first averaged over SMOOTHED. A table whose points are the ends of its sections keeps them exactly.
"""

from typing import NamedTuple

import numpy as np

STRAIGHT = 1e-4  # curvature below which outer and inner rail mean nothing [1/m]
TOLERANCE = 2e-5  # of curvature: between straight track and a radius of 50 km [1/m]
SHARE = 0.02  # likewise, of the largest curvature
ROUGH = 3.5  # likewise, of the scatter about a mean over LONG that is left after averaging
EXACT = 2e-6  # scatter below which a recording is not averaged [1/m]
SMOOTHED, LONG = 20.0, 100.0  # [m]
FINEST = 1e-3  # step that a recording may have [m]
DENSE = 4  # positions in that length, from which a recording is averaged
SHORTEST = 20.0  # of a level piece between two transitions that go on alike, and of a first or last part [m]
LEVEL_CANT = 0.010  # by which cant may vary where a motion counts as steady [m]


class Part(NamedTuple):
    """A straight, curve or transition of a track.

    Attributes
    ----------
    start, end : float
        Arc length [m].
    kind : {"straight", "curve", "transition"}
    curvature : float
        Its mean, positive to the right; of a straight 0 [1/m].
    """

    start: float
    end: float
    kind: str
    curvature: float


def parts(section, start=0.0):
    """Parts of a measured section that begins at arc length `start`: list of Part, end to end."""
    at = np.array(section.position) - section.position[0]
    curvature = np.array(section.curvature)
    smooth, scatter = _averaged(at, curvature)
    tolerance = max(TOLERANCE, SHARE * float(np.abs(smooth).max()), ROUGH * scatter)
    corners = _with_reversals(_corners(at, smooth, tolerance), smooth, tolerance)
    level = np.abs(np.diff(smooth[corners])) <= 2.0 * tolerance
    rise = np.diff(smooth[corners])
    _drop_short(level, rise, np.diff(at[corners]))
    found = []
    for k, flat in enumerate(level):
        first, last = corners[k], corners[k + 1]
        mean = _mean(at, smooth, first, last)
        kind = "transition" if not flat else "straight" if abs(mean) < STRAIGHT else "curve"
        if found and _goes_on(found[-1], kind, mean, tolerance):
            before = found.pop()
            first = before[0]
            mean = _mean(at, smooth, first, last)
        found.append((first, last, kind, mean))
    if scatter:
        found = _without_stubs(found, at)
    return [Part(float(start + at[first]), float(start + at[last]), kind, 0.0 if kind == "straight" else mean)
            for first, last, kind, mean in found]  # fmt: skip


def _goes_on(before, kind, mean, tolerance):
    """True if a piece belongs to the part before it; a transition ends where its curvature changes its sign."""
    if before[2] != kind:
        return False
    if kind == "transition":
        return before[3] * mean > 0.0
    return kind == "straight" or abs(mean - before[3]) <= 2.0 * tolerance


def _averaged(at, curvature):
    """Curvature averaged where it lies densely and is rough, and the scatter that is left in it [1/m]."""
    step = max(float(np.median(np.diff(at))), FINEST)
    width, long = int(SMOOTHED / step), int(LONG / step)
    if width < DENSE or curvature.size < 2 * long:
        return curvature, 0.0
    once = _sliding(curvature, width)
    if _scatter(curvature - once) < EXACT:
        return curvature, 0.0
    return once, _scatter(once - _sliding(once, long))


def _scatter(rest):
    """Standard deviation of what scatters, whatever a few places do."""
    return float(1.4826 * np.median(np.abs(rest - np.median(rest))))


def _without_stubs(found, at):
    """The same parts, a first or last one that is short given to its neighbour."""
    for end in (0, -1):
        inner = 1 if end == 0 else -2
        while len(found) > 1 and at[found[end][1]] - at[found[end][0]] < SHORTEST:
            stub, neighbour = found[end], found[inner]
            low, high = min(stub[0], neighbour[0]), max(stub[1], neighbour[1])
            found[inner] = (low, high, *neighbour[2:])
            del found[end]
    return found


def _sliding(values, width):
    """Mean over `width` values around each, the ends continued by their mirror images."""
    half = width // 2
    total = np.concatenate([[0.0], np.cumsum(np.pad(values, half, mode="reflect"))])
    return (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)


def _corners(at, values, tolerance):
    """Indices of the corners of a polyline that stays within a tolerance of the values."""
    kept, open_ = {0, at.size - 1}, [(0, at.size - 1)]
    while open_:
        first, last = open_.pop()
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        line = values[first] + (values[last] - values[first]) * (at[inner] - at[first]) / (at[last] - at[first])
        off = np.abs(values[inner] - line)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            open_ += [(first, middle), (middle, last)]
    return np.array(sorted(kept))


def _with_reversals(corners, values, tolerance):
    """The corners, and the places in between where a piece that is not level changes its sign."""
    more = []
    for first, last in zip(corners[:-1], corners[1:], strict=True):
        one, two = values[first], values[last]
        if one * two < 0.0 and abs(two - one) > 2.0 * tolerance and last - first > 1:
            more.append(first + 1 + int(np.argmin(np.abs(values[first + 1 : last]))))
    return np.array(sorted({*corners.tolist(), *more}))


def _drop_short(level, rise, length):
    """Short level pieces amid a transition that goes on behind them belong to it."""
    for k in np.flatnonzero(level[1:-1]) + 1:
        if length[k] < SHORTEST and not level[k - 1] and not level[k + 1] and rise[k - 1] * rise[k + 1] > 0.0:
            level[k] = False


def _mean(at, values, first, last):
    here = slice(first, last + 1)
    return float(np.trapezoid(values[here], at[here]) / (at[last] - at[first]))
