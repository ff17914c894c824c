"""Repairs of measured points: what is no metal is dropped, what was stitched is joined, and every case is told.

All functions take and give points in the axes of `railcli.model.profile` [m], from the gauge side to the field side.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from railcli.errors import InputError

from .polyline import meeting, turns

SAME = 1e-7  # points closer than this are one [m]
ZIGZAG = math.radians(150.0)  # both turns of a stitch are sharper
SPIKE_TURN = math.radians(60.0)  # at the foot or the tip of a spike
SMOOTH_TURN = math.radians(30.0)  # what remains where a spike was taken out
SPIKE_HEIGHT = 0.05e-3  # [m]
SPIKE_POINTS = 3  # as many neighbours may be one spike
DOUBLED = math.radians(120.0)  # no profile turns so sharply at a point
LARGEST_LOOP = 10e-3  # length of the part between two passes of one point [m]
BACK, OVERHANG = 0.02e-3, 3.0  # a step back in y [m], and |dz| / |dy| from which it is a face that overhangs
RIM = 10e-3  # faces of flange back and rim are cut this far above the tape circle [m]
GAUGE_DEPTH = 15e-3  # the gauge face must reach this far below the top [m]
SHALLOWEST_FACE = 8e-3  # one that ends higher is not continued [m]
FACE_STEP = 0.1e-3  # of points that continue it [m]
KINK, KINK_NEIGHBOUR, KINK_REACH = math.radians(30.0), math.radians(6.0), 2e-3
MOST_DROPPED = 0.2  # share of the points that may be faulty
ROUNDS = 50


@dataclass
class Fault:
    """One kind of fault: how many points were affected, on which lines, how far off they were."""

    reason: str
    treatment: str
    points: int = 0
    lines: list = field(default_factory=list)
    largest: float = 0.0

    def as_dict(self):
        """For a report: `lines` as pairs of first and last, `largest_mm` 0 where no distance says anything."""
        return {
            "reason": self.reason,
            "treatment": self.treatment,
            "points": self.points,
            "lines": _ranges(self.lines),
            "largest_mm": self.largest * 1e3,
        }


_FAULTS = {
    "duplicate": ("closer than 0.0001 mm to the point before", "dropped"),
    "zigzag": ("stitching: two turns of more than 150 degrees in a row", "replaced in pairs by their mean"),
    "spike": ("spike of up to 3 points, over 0.05 mm high", "dropped"),
    "doubled": ("turn of more than 120 degrees at one point", "dropped"),
    "loop": ("loop: the curve passes the same point twice", "dropped"),
    "back": ("y goes back on the running surface", "dropped"),
    "undercut": ("behind the side, where no wheel or gauge reaches", "dropped"),
    "end": ("face of flange back or rim more than 10 mm above the tape circle", "dropped"),
    "face": ("gauge face ends at a lip, less than 15 mm below the top; continued straight down", "added"),
}
_HARMLESS = ("duplicate", "undercut", "end", "face")


class Curation:
    """Points under repair, and the faults found so far.

    Parameters
    ----------
    path : path-like
        Named in errors.
    kind : "rail" or "wheel"
    y, z : array (n,)
        [m]
    lines : array (n,)
        Line numbers; 0 for points that were added.
    """

    def __init__(self, path, kind, y, z, lines):
        self.path, self.kind = path, kind
        self.y, self.z, self.lines = np.array(y), np.array(z), np.array(lines)
        self.read = self.y.size
        self.faults = {}

    def run(self):
        """All repairs, in order; returns self.

        Raises
        ------
        InputError
            The curve crosses itself in a large loop, or more than a fifth of the points are faulty.
        """
        self._drop("duplicate", self._duplicates())
        self._join_zigzags()
        for _ in range(ROUNDS):
            if not self._drop_spikes():
                break
        self._drop_doubled()
        self._cut_loops()
        self._cut_ends()
        for side in (1, -1):
            self._cut_back(side)
        for _ in range(ROUNDS):
            back = _turned_back(self.y, self.z)[0]
            if not back.any():
                break
            self._drop("back", np.flatnonzero(back))
        self._drop("duplicate", self._duplicates())
        self._drop_doubled()
        if self.kind == "rail":
            self._continue_face()
        bad = sum(fault.points for key, fault in self.faults.items() if key not in _HARMLESS)
        if bad > MOST_DROPPED * self.read:
            raise InputError(
                self.path, f"{bad} of {self.read} points are faulty ({self._worst()}): not a usable profile"
            )
        return self

    def kinks(self):
        """Indices of corners: turns of more than 30 degrees while neighbours within 2 mm turn by less than 6."""
        turn = np.abs(self._turns())
        found = []
        for i in np.flatnonzero(turn > KINK):
            near = np.hypot(self.y[1:-1] - self.y[i + 1], self.z[1:-1] - self.z[i + 1]) < KINK_REACH
            near[i] = False
            if not (turn[near] >= KINK_NEIGHBOUR).any():
                found.append(int(i) + 1)
        return found

    def _turns(self):
        return turns(self.y, self.z) if self.y.size > 2 else np.zeros(0)

    def _drop(self, key, index, largest=0.0):
        index = np.asarray(index, dtype=int)
        if index.size == 0:
            return
        self._count(key, self.lines[index], largest)
        self.y, self.z, self.lines = (np.delete(array, index) for array in (self.y, self.z, self.lines))
        if self.y.size < 10:
            raise InputError(self.path, f"{self.read} points, of which fewer than 10 are usable ({self._worst()})")

    def _count(self, key, lines, largest=0.0):
        fault = self.faults.setdefault(key, Fault(*_FAULTS[key]))
        fault.points += len(lines)
        fault.lines += [int(line) for line in lines if line]
        fault.largest = max(fault.largest, float(largest))

    def _worst(self):
        faults = [fault for key, fault in self.faults.items() if key not in _HARMLESS] or list(self.faults.values())
        worst = max(faults, key=lambda fault: fault.points)
        where = f", first at line {min(worst.lines)}" if worst.lines else ""
        return f"mostly: {worst.reason}{where}"

    def _duplicates(self):
        return np.flatnonzero(np.hypot(np.diff(self.y), np.diff(self.z)) < SAME) + 1

    def _join_zigzags(self):
        for _ in range(ROUNDS):
            sharp = np.abs(self._turns()) > ZIGZAG
            pairs = np.flatnonzero(sharp[:-1] & sharp[1:]) + 1
            if not pairs.size:
                return
            i = int(pairs[0])
            gap = math.hypot(self.y[i + 1] - self.y[i], self.z[i + 1] - self.z[i])
            self.y[i], self.z[i] = (self.y[i] + self.y[i + 1]) / 2.0, (self.z[i] + self.z[i + 1]) / 2.0
            self._count("zigzag", self.lines[[i]], gap / 2.0)
            self._drop("zigzag", [i + 1], gap / 2.0)

    def _drop_spikes(self):
        """Drop the spikes seen in one pass; True if there were any."""
        turn = np.abs(self._turns())
        steep = np.flatnonzero(turn > SPIKE_TURN) + 1
        taken, blocked = [], -1
        largest = 0.0
        for i in steep:
            if i <= blocked:
                continue
            for count in range(1, SPIKE_POINTS + 1):
                height = max((self._spike(first, count) for first in range(i - count + 1, i + 2)), default=0.0)
                first = next((k for k in range(i - count + 1, i + 2) if self._spike(k, count) == height), i)
                if height > 0.0:
                    taken += range(first, first + count)
                    blocked = first + count + 1
                    largest = max(largest, height)
                    break
        self._drop("spike", sorted(set(taken)), largest)
        return bool(taken)

    def _spike(self, first, count):
        """Height of the points `first` ... over their neighbours' chord if they are a spike, else 0 [m]."""
        before, after = first - 1, first + count
        if before < 1 or after > self.y.size - 2:
            return 0.0
        y, z = self.y, self.z
        along = np.array([y[after] - y[before], z[after] - z[before]])
        length = math.hypot(*along)
        if length == 0.0:
            return 0.0
        off = np.abs(along[0] * (z[first:after] - z[before]) - along[1] * (y[first:after] - y[before])) / length
        kept = [before - 1, before, after, after + 1]
        if off.max() < SPIKE_HEIGHT or np.abs(turns(y[kept], z[kept])).max() > SMOOTH_TURN:
            return 0.0
        feet = np.abs(turns(y[before - 1 : after + 2], z[before - 1 : after + 2]))
        return float(off.max()) if np.count_nonzero(feet > SMOOTH_TURN) >= 2 and feet.max() > SPIKE_TURN else 0.0

    def _drop_doubled(self):
        for _ in range(ROUNDS):
            sharp = np.flatnonzero(np.abs(self._turns()) > DOUBLED) + 1
            if not sharp.size:
                return
            self._drop("doubled", sharp[np.r_[True, np.diff(sharp) > 1]])

    def _cut_loops(self):
        for _ in range(ROUNDS):
            pair = meeting(self.y, self.z) if np.diff(self.y).min() <= 0.0 else None
            if pair is None:
                return
            i, j = sorted(pair)
            part = slice(i, j + 2)
            length = np.hypot(np.diff(self.y[part]), np.diff(self.z[part])).sum()
            if length > LARGEST_LOOP:
                break
            self._drop("loop", np.arange(i + 1, j + 1), length / 2.0)
        raise InputError(
            f"{self.path}, line {self.lines[j]}",
            f"the curve crosses itself: this part meets the part at line {self.lines[i]}; points must follow the curve",
        )

    def _cut_ends(self):
        if self.kind != "wheel":
            return
        low = np.flatnonzero(self.z >= -RIM)
        if low.size:
            beyond = np.r_[np.arange(0, low[0]), np.arange(low[-1] + 1, self.z.size)]
            self._drop("end", beyond)

    def _middle(self):
        return int(np.argmin(self.z)) if self.kind == "rail" else int(np.argmin(np.abs(self.y)))

    def _cut_back(self, side):
        """Walk from the middle to one side: drop what steps back, and all that lies behind the outermost point."""
        for _ in range(ROUNDS):
            middle = self._middle()
            walk = np.arange(middle, self.y.size) if side > 0 else np.arange(middle, -1, -1)
            y, z = side * self.y[walk], self.z[walk]
            turned, at = _turned_back(y, z)
            furthest = y[at]
            back = furthest - y
            if not turned.any():
                return
            first = int(np.argmax(turned))
            if furthest[-1] > furthest[first] + BACK:
                returned = first + int(np.argmax(furthest[first:] > furthest[first]))
                index = np.arange(first, returned)
                self._drop("back", walk[index[turned[first:returned]]], back[first:returned].max())
            else:
                self._drop("undercut", walk[at[first] + 1 :], back[first:].max())

    def _continue_face(self):
        """A gauge face that ends too high goes on vertically, so that gauge can be measured as by a gauge's pin."""
        depth = self.z[0] - self.z.min()
        if not SHALLOWEST_FACE <= depth < GAUGE_DEPTH:
            return
        more = self.z[0] + FACE_STEP * np.arange(math.ceil((GAUGE_DEPTH - depth) / FACE_STEP), 0, -1)
        self._count("face", np.zeros(more.size, dtype=int), more[0] - self.z[0])
        self.y = np.r_[np.full(more.size, self.y[0]), self.y]
        self.z = np.r_[more, self.z]
        self.lines = np.r_[np.zeros(more.size, dtype=int), self.lines]


def _turned_back(y, z):
    """Walking towards growing y: which points step back other than on an overhanging face, and behind which point."""
    furthest = np.maximum.accumulate(y)
    at = np.maximum.accumulate(np.where(y == furthest, np.arange(y.size), 0))
    back = furthest - y
    return (back > BACK) & (np.abs(z - z[at]) < OVERHANG * back), at


def _ranges(numbers):
    """Sorted whole numbers as pairs [first, last] of neighbours."""
    found = []
    for value in sorted(set(numbers)):
        if found and value == found[-1][1] + 1:
            found[-1][1] = value
        else:
            found.append([value, value])
    return found
