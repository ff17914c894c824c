"""The cross-section of a rail or wheel as one smooth plane curve.

Axes: right-hand rail and wheel in track axes, y to the field side, z down [m]. A rail's origin is the crown of its
symmetric, uninclined head; a wheel's origin lies on the tape circle, usually 70 mm from the flange back. The curve is
walked from the gauge side to the field side; its tangent angle is atan2(dz, dy), and positive curvature means that this
angle grows. So a rail's head has positive curvature, the convex parts of a wheel (flange tip) negative, its root
positive.
"""

import hashlib
import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from railcli.errors import InputError

KINDS = ("rail", "wheel")
TAPE_TO_BACK = 0.070  # from the tape circle to the flange back unless another is said [m], EN 13715
TAPE_LIMITS = 0.055, 0.085  # of that distance [m]
FLANGE_THICKNESS_HEIGHT = 0.010  # flange thickness is taken this far below the tape circle [m], EN 13715
QR_BELOW_TIP = 0.002  # upper point of qR below the flange tip [m], EN 13715
LEAN_REACH = 0.010  # where the lean of a head is seen, to both sides of its middle [m]
STEP = 0.05e-3  # grid of `graph` [m]
SLOPE_LIMIT = math.tan(math.radians(80.0))
WINDOW = 1.0e-3  # arc length over which `graph` averages curvature [m]
_GAUSS_T, _GAUSS_WEIGHT = np.polynomial.legendre.leggauss(6)
_GAUSS_T, _GAUSS_WEIGHT = (_GAUSS_T + 1.0) / 2.0, _GAUSS_WEIGHT / 2.0
_SAMPLES = np.linspace(0.0, 1.0, 5)


class FlangeDimensions(NamedTuple):
    """Dimensions of a wheel's flange and rim [m], as EN 13715 defines them."""

    height: float
    thickness: float
    qr: float
    width: float


@dataclass(frozen=True, eq=False)
class Profile:
    """Smooth curve through nodes with given tangents.

    Between two nodes runs a cubic Hermite curve whose end tangents have the length chord / cos(turn / 4)^2: position
    and tangent are continuous, curvature jumps only at nodes, vertical faces need no special case. An arc that turns by
    `turn` between its nodes is met to radius * turn^6 / 55000, another smooth curve to the fourth power of the node
    distance.

    Parameters
    ----------
    name : str
    kind : "rail" or "wheel"
    y, z : array (n,)
        Nodes [m], from the gauge side to the field side.
    angle : array (n,)
        Tangent angles atan2(dz, dy) at the nodes [rad].
    inclined : bool or None
        Of a rail: whether it stands in these axes with its inclination (True) or upright (False); None: not known.
    tape_to_back : float or None
        Of a wheel: from its tape circle, the origin, to its flange back [m]; None: not known.

    Attributes
    ----------
    arc : array (n,)
        Arc length from the first node [m].
    """

    name: str
    kind: str
    y: np.ndarray = field(repr=False)
    z: np.ndarray = field(repr=False)
    angle: np.ndarray = field(repr=False)
    inclined: bool | None = None
    tape_to_back: float | None = None
    arc: np.ndarray = field(init=False, repr=False)
    _cubic: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        if self.kind not in KINDS:
            raise InputError(self.name, f"a profile is a rail or a wheel, not {self.kind!r}")
        nodes = np.array([self.y, self.z, self.angle], dtype=float)
        if nodes.ndim != 2 or nodes.shape[1] < 2 or not np.isfinite(nodes).all():
            raise InputError(self.name, "a profile needs at least 2 nodes of finite y, z and angle")
        chord = np.diff(nodes[:2])
        length = np.hypot(*chord)
        if not length.all():
            raise InputError(self.name, f"nodes {int(np.argmin(length)) + 1} and the next are the same point")
        scale = length / np.cos(_turn(nodes[2, :-1], nodes[2, 1:]) / 4.0) ** 2
        start, end = scale * _direction(nodes[2, :-1]), scale * _direction(nodes[2, 1:])
        cubic = np.array([nodes[:2, :-1], start, 3.0 * chord - 2.0 * start - end, start + end - 2.0 * chord])
        self._set("_cubic", cubic)
        segment = np.arange(length.size)
        lengths = self._length_to(segment, np.ones(length.size))
        for key, array in zip(("y", "z", "angle"), nodes, strict=True):
            self._set(key, array)
        self._set("arc", np.concatenate([[0.0], np.cumsum(lengths)]))

    def _set(self, key, array):
        array = np.ascontiguousarray(array)
        array.flags.writeable = False
        object.__setattr__(self, key, array)

    @classmethod
    def from_points(cls, name, kind, y, z, angle=None, inclined=None, tape_to_back=None):
        """Profile through points [m]; without `angle` [rad] the tangents come from the neighbours.

        The tangent at a point is that of the circle through it and its two neighbours (at an end: through the last
        three points): exact on arcs, whatever the spacing, and purely local, so that nothing rings. A corner is rounded
        over one point distance to both sides.
        """
        y, z = np.asarray(y, dtype=float), np.asarray(z, dtype=float)
        if angle is None:
            angle = _circle_tangents(name, y, z)
        return cls(name, kind, y, z, angle, inclined, tape_to_back)

    def at(self, sigma):
        """Point of the curve at arc length `sigma` [m]; beyond its ends, the end point.

        Returns
        -------
        y, z, angle, curvature : arrays shaped like `sigma` [m, m, rad, 1/m]
            At a node, curvature is that of the side that follows.
        """
        sigma = np.clip(np.asarray(sigma, dtype=float), 0.0, self.arc[-1])
        segment = np.clip(np.searchsorted(self.arc, sigma, side="right") - 1, 0, self.arc.size - 2)
        wanted = sigma - self.arc[segment]
        t = wanted / np.diff(self.arc)[segment]
        for _ in range(3):
            t = t - (self._length_to(segment, t) - wanted) / np.hypot(*self._velocity(segment, t))
        return self._evaluate(segment, t)

    def rotated(self, angle):
        """The profile turned about its origin by `angle` [rad], right-handed about x (forward): from y towards z.

        Every tangent angle grows by `angle`. A right-hand rail inclined 1:n (head turned inwards, gauge side down) is
        ``rail.rotated(-math.atan(1 / n))``.
        """
        c, s = math.cos(angle), math.sin(angle)
        return replace(self, y=c * self.y - s * self.z, z=s * self.y + c * self.z, angle=self.angle + angle)

    def translated(self, dy, dz):
        """The profile moved by `dy`, `dz` [m]."""
        return replace(self, y=self.y + dy, z=self.z + dz)

    def mirrored(self):
        """The profile with y reversed (right hand to left hand and back), still walked towards growing y."""
        return replace(self, y=-self.y[::-1], z=self.z[::-1], angle=-self.angle[::-1])

    def digest(self):
        """SHA-256 (hexadecimal) over kind, nodes and whether it is inclined already; the name does not enter."""
        digest = hashlib.sha256(self.kind.encode() + (b", inclined" if self.inclined else b""))
        for array in (self.y, self.z, self.angle):
            digest.update(array.astype("<f8").tobytes())
        return digest.hexdigest()

    def __eq__(self, other):
        """Equal curves of one kind, whatever their names."""
        return isinstance(other, Profile) and self.digest() == other.digest()

    def __hash__(self):
        return hash(self.digest())

    def graph(self, step=STEP, slope_limit=SLOPE_LIMIT, window=WINDOW):
        """The part of the profile that is a graph z(y), on a uniform grid.

        This is the contiguous part around the top of a rail, or around a wheel's tape circle y = 0, on which y grows
        along the walk and abs(dz/dy) <= `slope_limit`. A wheel's part goes over the flange tip unless the flank is
        steeper than the limit.

        Parameters
        ----------
        step : float
            Distance of grid nodes [m]; they lie at integer multiples of it.
        slope_limit : float
            Largest abs(dz/dy) [-].
        window : float
            Arc length [m], centred at the node, over which the curvature is averaged: change of the tangent angle
            divided by arc length (shortened where the profile ends). 0: the local curvature.

        Returns
        -------
        y0 : float
            First grid node [m].
        step : float
            As given [m].
        values : array (n, 3)
            z [m], dz/dy [-], mean curvature [1/m] (sign as the class says).
        """
        first, last = self._graph_ends(slope_limit)
        low, high = (self._evaluate(np.array([i]), np.array([t]))[0][0] for i, t in (first, last))
        grid = np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1) * step
        if grid.size < 2:
            raise InputError(self.name, f"no two grid nodes {step * 1e3:g} mm apart fit on the running surface")
        segment = np.clip(np.searchsorted(self.y[first[0] : last[0] + 1], grid, side="right") - 1, 0, None) + first[0]
        t = self._solve(segment, 0, grid)
        _, z, angle, curvature = self._evaluate(segment, t)
        if window > 0.0:
            sigma = self.arc[segment] + self._length_to(segment, t)
            before = np.maximum(sigma - window / 2.0, 0.0)
            after = np.minimum(sigma + window / 2.0, self.arc[-1])
            curvature = (self.at(after)[2] - self.at(before)[2]) / (after - before)
        return float(grid[0]), step, np.column_stack([z, np.tan(angle), curvature])

    def gauge_point(self, depth=0.014):
        """Where a rail's gauge is measured; the profile is that of an inclined right-hand rail.

        Returns
        -------
        y_gauge : float
            Lateral position of the innermost point (smallest y) between the top and `depth` [m] below it [m].
        z_top : float
            z of the top [m]. Both are exact on the continuous curve.
        """
        top, t_top, z_top = self._lowest(1, 0, self.y.size - 2)
        below = np.flatnonzero(self.z[: top + 1] > z_top + depth)
        if below.size == 0:
            raise InputError(self.name, f"the gauge face ends less than {depth * 1e3:g} mm below the top of the rail")
        start = int(below[-1])
        t_level = float(self._solve(np.array([start]), 1, np.array([z_top + depth]))[0])
        y_inner = self._lowest(0, start, top, t_level, t_top)[2]
        return y_inner, z_top

    @property
    def lean(self):
        """Angle of the middle of a rail's head from the horizontal [rad], positive inwards (gauge side down)."""
        middle = (self.y.min() + self.y.max()) / 2.0
        low, high = np.interp([middle - LEAN_REACH, middle + LEAN_REACH], np.maximum.accumulate(self.y), self.z)
        return float(np.arctan2(low - high, 2.0 * LEAN_REACH))

    def flange_dimensions(self):
        """Flange height, thickness, qR and the rim's width of a wheel [m]; see `FlangeDimensions`.

        The height is that of the flange tip over the tape circle; the thickness runs from the flange back (70 mm from
        the tape circle if the profile does not know) to the flank 10 mm below the tape circle; qR is the lateral
        distance from there to the point of the flank 2 mm below the flange tip; the width is the extent of the profile.
        """
        back = TAPE_TO_BACK if self.tape_to_back is None else self.tape_to_back
        tape = self._crossing(0, 0.0, np.arange(self.y.size - 1))
        if tape is None or self.kind != "wheel":
            raise InputError(self.name, "flange dimensions need a wheel whose profile passes the tape circle, y = 0")
        z_tape = self._evaluate(*tape)[1][0]
        tip, _, minus_height = self._lowest(1, 0, int(tape[0][0]), sign=-1.0)
        height = -minus_height - z_tape
        flank = np.arange(tip, int(tape[0][0]) + 1)
        lower = self._crossing(1, z_tape + FLANGE_THICKNESS_HEIGHT, flank)
        upper = self._crossing(1, z_tape + height - QR_BELOW_TIP, flank)
        if lower is None or upper is None:
            raise InputError(self.name, f"the flange is only {height * 1e3:.1f} mm high: too low for its dimensions")
        y_lower, y_upper = self._evaluate(*lower)[0][0], self._evaluate(*upper)[0][0]
        width = self.y.max() - self.y.min()
        return FlangeDimensions(float(height), float(back + y_lower), float(y_lower - y_upper), float(width))

    # Segments: arrays of indices `segment` with parameters t in 0..1

    def _position(self, segment, t, axis):
        c = self._cubic[:, axis, segment]
        return c[0] + t * (c[1] + t * (c[2] + t * c[3]))

    def _velocity(self, segment, t):
        c = self._cubic[:, :, segment]
        return c[1] + t * (2.0 * c[2] + 3.0 * t * c[3])

    def _length_to(self, segment, t):
        segment, t = np.asarray(segment), np.asarray(t)
        nodes = t[..., None] * _GAUSS_T
        speed = np.hypot(*self._velocity(segment[..., None], nodes))
        return t * (speed @ _GAUSS_WEIGHT)

    def _evaluate(self, segment, t):
        dy, dz = self._velocity(segment, t)
        c = self._cubic[:, :, segment]
        ddy, ddz = 2.0 * c[2] + 6.0 * t * c[3]
        curvature = (dy * ddz - dz * ddy) / np.hypot(dy, dz) ** 3
        return self._position(segment, t, 0), self._position(segment, t, 1), np.arctan2(dz, dy), curvature

    def _solve(self, segment, axis, value):
        """Parameter at which a coordinate that is monotonic in the segment has the given value; Newton in a bracket."""
        low, high = np.zeros(value.shape), np.ones(value.shape)
        rising = self._position(segment, high, axis) > self._position(segment, low, axis)
        t = np.full(value.shape, 0.5)
        for _ in range(60):
            miss = self._position(segment, t, axis) - value
            after = (miss > 0.0) == rising
            high, low = np.where(after, t, high), np.where(after, low, t)
            rate = self._velocity(segment, t)[axis]
            newton = t - miss / np.where(rate == 0.0, 1.0, rate)
            inside = (newton >= low) & (newton <= high) & (rate != 0.0)
            t_next = np.where(inside, newton, (low + high) / 2.0)
            if np.array_equal(t_next, t):
                break
            t = t_next
        return t

    def _crossing(self, axis, value, segments):
        """Last of `segments` whose ends enclose a value of a coordinate, and the parameter there; None without any."""
        nodes = (self.y, self.z)[axis]
        enclosing = segments[(nodes[segments] <= value) != (nodes[segments + 1] <= value)]
        if enclosing.size == 0:
            return None
        segment = enclosing[-1:]
        return segment, self._solve(segment, axis, np.array([value]))

    def _lowest(self, axis, first, last, t_first=0.0, t_last=1.0, sign=1.0):
        """Smallest value of sign * coordinate from (first, t_first) to (last, t_last): segment, parameter, value."""
        segment = np.arange(first, last + 1)
        c = sign * self._cubic[:, axis, segment]
        low, high = np.zeros(segment.size), np.ones(segment.size)
        low[0], high[-1] = t_first, t_last
        root = np.sqrt(np.maximum(c[2] ** 2 - 3.0 * c[1] * c[3], 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):  # two forms of one root, each where it does not cancel
            inner = np.nan_to_num(np.where(c[2] < 0.0, (root - c[2]) / (3.0 * c[3]), -c[1] / (c[2] + root)))
        t = np.array([low, np.clip(inner, low, high), high])
        value = sign * self._position(segment, t, axis)
        best = np.unravel_index(np.argmin(value), value.shape)
        return int(segment[best[1]]), float(t[best]), float(value[best])

    def _graph_ends(self, slope_limit):
        """Ends (segment, parameter) of the single-valued part around the top or the tape circle."""
        segment = np.arange(self.y.size - 1)
        dy, dz = self._velocity(segment[:, None], _SAMPLES)
        good = (dy > 0.0) & (np.abs(dz) <= slope_limit * dy)
        if self.kind == "rail":
            middle = self._lowest(1, 0, segment[-1])[0]
        else:
            tape = self._crossing(0, 0.0, segment)
            middle = None if tape is None else int(tape[0][0])
        if middle is None or not good[middle].all():
            where = "top of the rail" if self.kind == "rail" else "tape circle (y = 0)"
            raise InputError(self.name, f"the profile has no running surface z(y) at the {where}")
        good = good.ravel()
        start = middle * _SAMPLES.size
        before, after = np.flatnonzero(~good[:start]), np.flatnonzero(~good[start:])
        first, last = (0, 0.0), (int(segment[-1]), 1.0)
        if before.size:
            first = self._slope_end(int(before[-1]), 1, slope_limit)
        if after.size:
            last = self._slope_end(start + int(after[0]), -1, slope_limit)
        return first, last

    def _slope_end(self, bad, towards_good, slope_limit):
        """Where the slope limit is met, given a sample beyond it whose neighbour is within it."""
        (segment, i), (other, j) = divmod(bad, _SAMPLES.size), divmod(bad + towards_good, _SAMPLES.size)
        if segment != other:  # the same node seen from both sides
            return other, float(_SAMPLES[j])
        outside, inside = float(_SAMPLES[i]), float(_SAMPLES[j])
        for _ in range(60):
            t = (outside + inside) / 2.0
            dy, dz = self._velocity(segment, t)
            if dy > 0.0 and abs(dz) <= slope_limit * dy:
                inside = t
            else:
                outside = t
        return segment, inside


def _turn(before, after):
    """Difference of two directions [rad], in -pi..pi."""
    return np.remainder(after - before + math.pi, 2.0 * math.pi) - math.pi


def _direction(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def _circle_tangents(name, y, z):
    """Tangent angles [rad] at points, each from the circle through three neighbours.

    On a circle the directions of the chords 1-2, 2-3 and 1-3 are means of the tangent angles at their ends; so the
    tangent angle at 2 is their sum 12 + 23 - 13, and those at 1 and 3 follow likewise.
    """
    if y.ndim != 1 or y.shape != z.shape or y.size < 3:
        raise InputError(name, "tangents from points need at least 3 points")
    first = np.arctan2(np.diff(z), np.diff(y))
    wide = np.arctan2(z[2:] - z[:-2], y[2:] - y[:-2])
    half, rest = _turn(first[:-1], wide), _turn(wide, first[1:])
    angle = np.concatenate([[first[0] - rest[0]], first[:-1] + rest, [first[-1] + half[-1]]])
    return np.unwrap(angle)
