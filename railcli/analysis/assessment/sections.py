"""Stretches of track that an assessment evaluates one by one: straights, full curves and transitions, cut in parts."""

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval

from railcli.model.assessment import section_length
from railcli.model.track import pack

from ..parts import STRAIGHT, parts

STEADY = 2e-7  # change of curvature per metre below which a curve is a full one [1/m^2]
ALIKE = 0.02  # share of its curvature by which two pieces of one curve may differ
NEARLY = 0.9  # share of its length that makes a section
SHORTEST = 10.0  # [m]


class Section(NamedTuple):
    """A stretch of track that is evaluated by itself.

    Attributes
    ----------
    start, end : float
        Arc length [m].
    kind : {"straight", "curve", "transition"}
    curvature : float
        Its mean, positive to the right [1/m].
    short : bool
        Shorter than EN 14363 asks for; transitions have no length to keep.
    """

    start: float
    end: float
    kind: str
    curvature: float
    short: bool

    @property
    def radius(self):
        """[m]; infinite on straight track."""
        return math.inf if self.kind == "straight" else 1.0 / max(abs(self.curvature), 1e-9)

    @property
    def outer(self):
        """Side of the outer rail: 0 right, 1 left; None on straight track."""
        if self.kind == "straight":
            return None
        return 1 if self.curvature > 0.0 else 0

    @property
    def place(self):
        """Where it is and what it is, for a reader."""
        return f"{self.start:.0f} to {self.end:.0f} m, {self.name}"

    @property
    def name(self):
        """As a reader calls it."""
        if self.kind == "straight":
            return "straight"
        hand = "right-hand" if self.curvature > 0.0 else "left-hand"
        return f"{hand} curve, R = {self.radius:.0f} m" if self.kind == "curve" else f"{hand} transition"


def sections(track, start, end, speed, length=None):
    """Sections between two places.

    Parameters
    ----------
    track : Track
    start, end : float
        Arc length [m].
    speed : float
        [m/s]; it decides how long a section is.
    length : float, optional
        Of a section, instead of what EN 14363 says [m].

    Returns
    -------
    list of Section
        Straights and curves in equal parts at least nine tenths as long as a section should be, or whole if they are
        shorter; transitions whole. Stretches below 10 m are left out.
    """
    found = []
    for begin, stop, kind, curvature in _stretches(track):
        begin, stop = max(begin, start), min(stop, end)
        if stop - begin < SHORTEST:
            continue
        if kind == "transition":
            found.append(Section(begin, stop, kind, curvature, False))
            continue
        wanted = length or section_length(speed, math.inf if kind == "straight" else 1.0 / abs(curvature))
        count = max(1, int((stop - begin) / wanted + 1.0 - NEARLY))
        edges = np.linspace(begin, stop, count + 1)
        short = (stop - begin) / count < NEARLY * wanted
        found += [Section(float(a), float(b), kind, curvature, short) for a, b in zip(edges, edges[1:], strict=False)]
    return found


def _stretches(track):
    """Start, end, kind and mean curvature of what belongs together; the first and the last one have no end."""
    merged = []
    for start, length, kind, mean in sorted(_simple(track)):
        if merged and _one(merged[-1], kind, mean):
            first, last, _, before = merged[-1]
            share = length / (last - first + length)
            merged[-1] = (first, start + length, kind, before + share * (mean - before))
        else:
            merged.append((start, start + length, kind, mean))
    merged[0] = (-math.inf, *merged[0][1:])
    merged[-1] = (merged[-1][0], math.inf, *merged[-1][2:])
    return merged


def _simple(track):
    """Start, length, kind and mean curvature of the pieces of described sections, and of the parts of measured ones."""
    measured = [(start, start + one.length, one) for start, one in track.located() if one.kind == "measured"]
    for start, _, one in measured:
        yield from ((part.start, part.end - part.start, part.kind, part.curvature) for part in parts(one, start))
    for piece in pack(track):
        start, length = float(piece["start"]), float(piece["length"])
        middle = start + 0.5 * length
        if any(low < middle < high for low, high, _ in measured):
            continue
        ends = [float(polyval(u, piece["curvature"])) for u in (0.0, length)]
        mean = float(polyval(length, np.concatenate([[0.0], piece["curvature"] / np.arange(1, 5)]))) / length
        kind = "transition" if abs(ends[1] - ends[0]) > STEADY * length else "curve"
        if kind == "curve" and abs(mean) < STRAIGHT:
            kind, mean = "straight", 0.0
        yield start, length, kind, mean


def _one(before, kind, mean):
    if before[2] != kind:
        return False
    if kind == "transition":
        return before[3] * mean > 0.0
    return abs(mean - before[3]) <= ALIKE * abs(mean)
