"""Track: sections in any sequence with gradients, and its pieces for the compiled core (theory.md section 2)."""

from typing import Annotated

import numpy as np
from pydantic import Field, RootModel, model_validator

from railcli.errors import InputError
from railcli.kernels.layout import PATH_ORDER, PIECE

from .sections import Curve, Measured, Straight, Transition
from .submodels import TRANSITIONS

MARGIN = 50.0  # track that continues before the first and after the last section [m]
LONGEST = 1e6  # of a track [m]
LONGEST_PIECE = 25.0  # [m]
MOST_PIECES = 100_000
LARGEST_TURN = 0.1  # of a piece, in plan or in height [rad]
REMAINDER = 1e-13  # largest sum of the neglected terms of a piece's position [m]
SERIES = 41  # terms of a power series that are looked at
SAME_PLACE = 1e-9  # breaks closer than this are one [m]
PIVOTS = {"centre": 0.0, "inner": 0.5, "outer": -0.5}  # rise of the middle of the track per cant

Section = Annotated[Straight | Curve | Transition | Measured, Field(discriminator="kind")]


class Track(RootModel[tuple[Section, ...]]):
    """Sections in the order of travel: ``Track((Straight(length=100.0), ...))``."""

    model_config = {"frozen": True}

    @property
    def sections(self):
        return self.root

    @property
    def length(self):
        """Of all sections together [m]."""
        return sum(section.length for section in self.root)

    @property
    def origin(self):
        """Position along the line where it begins: the first one of a measured table, else 0 [m]."""
        first = self.root[0]
        return first.position[0] if first.kind == "measured" else 0.0

    @model_validator(mode="after")
    def _joins(self):
        if not self.root:
            raise ValueError("has no section; give at least one of kind 'straight', 'curve' or 'measured'")
        if self.length > LONGEST:
            raise ValueError(
                f"is {self.length:.6g} m long; at most {LONGEST:g} m are allowed: check the units of its lengths or "
                "positions, or run it in parts"
            )
        kinds = [section.kind for section in self.root]
        if "transition" in (kinds[0], kinds[-1]):
            raise ValueError("begins or ends with a transition; it needs a straight or a curve on either side")
        for number, (one, two) in enumerate(zip(self.root, self.root[1:], strict=False), start=1):
            where = f"sections {number} and {number + 1}"
            if one.kind == two.kind == "transition":
                raise ValueError(f"{where} are both transitions; put a straight or a curve between them")
            if "transition" in (one.kind, two.kind):
                continue
            if one.ends[1] != two.ends[0]:
                raise ValueError(
                    f"curvature or cant jumps between {where} ({one.kind}, {two.kind}); "
                    "put a section of kind 'transition' between them"
                )
            if one.kind == two.kind == "curve" and one.gauge_widening != two.gauge_widening:
                raise ValueError(f"gauge jumps between {where}; put a section of kind 'transition' between them")
        return self

    def located(self):
        """Pairs of arc length at its beginning [m] and section."""
        start = 0.0
        for section in self.root:
            yield start, section
            start += section.length

    def widest(self, gauge):
        """Farthest lateral displacement of a rail from its place at the nominal gauge, anywhere [m]."""
        shifts = [section.shift(gauge) for section in self.root if section.kind != "transition"]
        return max(float(np.abs(rail).max()) for pair in shifts for rail in pair)

    def shifts(self, s, gauge):
        """Lateral displacement of the rails from their places at the nominal gauge.

        Gauge widening of a curve is given to its inner rail and grows over the adjoining transitions with their shape;
        what the gauge of a measured table exceeds the nominal one is shared evenly by both rails.

        Parameters
        ----------
        s : array (n,)
            Arc lengths [m]; before and behind the track its ends hold.
        gauge : float
            Nominal gauge [m].

        Returns
        -------
        array (2, n)
            Of left and right rail [m], positive to the right.
        """
        s = np.clip(np.asarray(s, float), 0.0, self.length)
        found = np.zeros((2, s.size))
        located = list(self.located())
        for i, (start, section) in enumerate(located):
            inside = (s >= start) & (s <= start + section.length)
            if section.kind == "transition":
                before, after = (located[k][1].shift(gauge) for k in (i - 1, i + 1))
                share = TRANSITIONS[section.shape].value((s[inside] - start) / section.length)
                for rail in range(2):
                    low, high = np.atleast_1d(before[rail])[-1], np.atleast_1d(after[rail])[0]
                    found[rail, inside] = low + (high - low) * share
            elif section.kind == "measured" and section.gauge is not None:
                at = np.array(section.position) - section.position[0] + start
                for rail, values in enumerate(section.shift(gauge)):
                    found[rail, inside] = np.interp(s[inside], at, values)
            else:
                found[:, inside] = np.array(section.shift(gauge))[:, None]
        return found


def gradient_course(track, gradients=()):
    """Gradient of a track as knots between which its angle runs straight (circular vertical curves).

    Parameters
    ----------
    track : Track
    gradients : sequence of Gradient
        None where measured sections have gradients of their own.

    Returns
    -------
    s, angle : arrays
        Arc lengths [m] and angles, positive where the track rises [rad]; beyond the ends their angle goes on.

    Raises
    ------
    ValueError
        Gradients that do not fit together, told in words.
    """
    measured = [(start, one) for start, one in track.located() if one.kind == "measured" and one.gradient is not None]
    if not gradients:
        knots = [(0.0, 0.0)] if not measured else []
        for start, one in measured:
            knots += zip(np.array(one.position) - one.position[0] + start, np.arctan(one.gradient), strict=True)
        s, angle = np.array(knots).T
        if (np.diff(s) == 0.0).any():
            k = int(np.argmax(np.diff(s) == 0.0))
            if angle[k] != angle[k + 1]:
                raise ValueError(f"the gradients of two measured tables differ where they meet, at {s[k]:g} m")
            s, angle = np.unique(s), angle[np.unique(s, return_index=True)[1]]
        return s, angle
    if measured:
        raise ValueError("gradient: a measured table has gradients already; give one or the other")
    s, angle, slope = [], [], 0.0
    for number, one in enumerate(gradients, start=1):
        where = f"gradient {number}"
        after = float(np.arctan(one.gradient))
        if number == 1 and one.at == 0.0:
            s, angle, slope = [0.0], [after], after
            continue
        if one.at > track.length:
            raise ValueError(f"{where}: at {one.at:g} m is behind the end of the track, {track.length:g} m")
        if one.radius is None:
            raise ValueError(f"{where}: radius_m of the vertical curve is missing")
        half = 0.5 * one.radius * abs(after - slope)
        begin = s[-1] if s else 0.0
        if one.at - half < begin:
            raise ValueError(
                f"{where}: its vertical curve would begin at {one.at - half:.6g} m, before {begin:.6g} m where "
                f"{'the one before it ends' if number > 1 else 'the track begins'}; reduce radius_m or move at_m"
            )
        s += [one.at - half, one.at + half]
        angle += [slope, after]
        slope = after
    return np.array(s), np.array(angle)


def pack(track, margin=MARGIN, gradients=(), pivot="centre"):
    """Pieces of the track for the compiled core.

    Parameters
    ----------
    track : Track
    margin : float
        Length by which the first section is continued backwards and the last one forwards [m].
    gradients : sequence of Gradient
    pivot : str
        One of PIVOTS: what stays at its height where there is cant.

    Returns
    -------
    numpy.ndarray of PIECE
        Read-only, in order of `start`; at arc length 0, where the first section begins, plan position, height of the
        line and heading are zero.
    """
    stretches = _stretches(track, margin)
    knots, angles = gradient_course(track, gradients)
    turns = list(_reversals(stretches)) if PIVOTS[pivot] else []
    stretches = _broken(stretches, np.concatenate([knots, turns]))
    largest = np.abs(_valued(stretches.curvature, stretches.length[:, None] * np.linspace(0.0, 1.0, 9))).max(axis=1)
    climb = np.interp(stretches.start + stretches.length, knots, angles) - np.interp(stretches.start, knots, angles)
    turn = np.maximum(largest * stretches.length, np.abs(climb))
    count = np.ceil(np.maximum(stretches.length / LONGEST_PIECE, turn / LARGEST_TURN))
    while True:
        if not count.sum() <= MOST_PIECES:
            raise InputError(
                "track",
                f"{track.length:.6g} m of it turn by {turn.sum():.4g} rad in all: {count.sum():.3g} pieces, more than "
                f"the {MOST_PIECES} that a track may have; shorten it or check its radii and lengths",
            )
        count = count.astype(int)
        pieces, of = _cut(stretches, count, knots, angles)
        path, neglected = _paths(pieces)
        coarse = np.unique(of[neglected > REMAINDER])
        if coarse.size == 0:
            break
        count[coarse] *= 2
    middle = _valued(pieces["cant"], pieces["length"][:, None] / 2.0)[:, 0]
    pieces["lift"] = PIVOTS[pivot] * np.sign(middle)
    _join(pieces, path)
    pieces.flags.writeable = False
    return pieces


class _Stretches:
    """Arrays over stretches of track: start, length and cubics of curvature and cant in u = s - start."""

    def __init__(self, start, length, curvature, cant):
        self.start, self.length = np.array(start), np.array(length)
        self.curvature, self.cant = np.array(curvature), np.array(cant)


def _stretches(track, margin):
    """Margins, straights and curves whole; transitions and measured tables cut where their polynomials change."""
    first, last = track.sections[0].ends[0], track.sections[-1].ends[1]
    rows = [(-margin, margin, _constant(first.curvature), _constant(first.cant))]
    for i, (start, section) in enumerate(track.located()):
        if section.kind == "transition":
            before, after = track.sections[i - 1].ends[1], track.sections[i + 1].ends[0]
            rows += _transition(start, section, before, after)
        elif section.kind == "measured":
            rows += _measured(start, section)
        else:
            edge = section.ends[0]
            rows.append((start, section.length, _constant(edge.curvature), _constant(edge.cant)))
    rows.append((track.length, margin, _constant(last.curvature), _constant(last.cant)))
    return _Stretches(*zip(*rows, strict=True))


def _constant(value):
    return np.array([value, 0.0, 0.0, 0.0])


def _transition(start, section, before, after):
    shape, length = TRANSITIONS[section.shape].value, section.length
    ends = np.append(shape.start[1:], 1.0)
    for low, high, coefficients in zip(shape.start, ends, shape.coefficients, strict=True):
        share = coefficients / length ** np.arange(4)
        yield (
            start + low * length,
            (high - low) * length,
            _constant(before.curvature) + (after.curvature - before.curvature) * share,
            _constant(before.cant) + (after.cant - before.cant) * share,
        )


def _measured(start, section):
    at = np.array(section.position) - section.position[0]
    step = np.diff(at)
    columns = []
    for name in ("curvature", "cant"):
        values = section.column(name)
        rows = np.zeros((step.size, 4))
        rows[:, 0], rows[:, 1] = values[:-1], np.diff(values) / step
        columns.append(rows)
    return zip(start + at[:-1], step, *columns, strict=True)


def _reversals(stretches):
    """Arc lengths within stretches at which cant changes its sign: there an inner or outer rail changes its side."""
    ends = _valued(stretches.cant, stretches.length[:, None] * [0.0, 1.0])
    for k in np.flatnonzero(ends[:, 0] * ends[:, 1] < 0.0):
        roots = np.polynomial.polynomial.polyroots(np.trim_zeros(stretches.cant[k], "b"))
        real = roots.real[np.abs(roots.imag) < SAME_PLACE]
        yield from stretches.start[k] + real[(real > 0.0) & (real < stretches.length[k])]


def _broken(stretches, places):
    """The same stretches, cut at more places."""
    ends = np.append(stretches.start, stretches.start[-1] + stretches.length[-1])
    places = places[(places > ends[0]) & (places < ends[-1])]
    behind = np.searchsorted(ends, places)
    places = places[np.minimum(ends[behind] - places, places - ends[behind - 1]) > SAME_PLACE]
    edges = np.unique(np.concatenate([ends, places]))
    of = np.searchsorted(stretches.start, edges[:-1], side="right") - 1
    u = edges[:-1] - stretches.start[of]
    length = np.where(np.isin(edges[1:], ends) & (u == 0.0), stretches.length[of], np.diff(edges))
    return _Stretches(edges[:-1], length, _shifted(stretches.curvature[of], u), _shifted(stretches.cant[of], u))


def _cut(stretches, count, knots, angles):
    """Pieces of equal length, so many of each stretch, without their paths; and the stretch that each is of."""
    of = np.repeat(np.arange(count.size), count)
    k = np.arange(of.size) - np.repeat(np.cumsum(count) - count, count)
    step = (stretches.length / count)[of]
    pieces = np.zeros(of.size, PIECE)
    pieces["start"], pieces["length"] = stretches.start[of] + k * step, step
    for name in ("curvature", "cant"):
        pieces[name] = _shifted(getattr(stretches, name)[of], k * step)
    low, high = (np.interp(pieces["start"] + end, knots, angles) for end in (0.0, step))
    pieces["gradient"] = np.column_stack([low, (high - low) / step])
    pieces["graded"] = (low != 0.0) | (high != 0.0)
    return pieces, of


def _valued(polynomials, u):
    """Values of cubics (n, 4) at u (n, m)."""
    c = polynomials[:, :, None]
    return c[:, 0] + u * (c[:, 1] + u * (c[:, 2] + u * c[:, 3]))


def _shifted(polynomials, u):
    """Coefficients of the same cubics (n, 4) about u (n,)."""
    c0, c1, c2, c3 = polynomials.T
    return np.column_stack(
        [c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + u * 3.0 * c3), c2 + 3.0 * u * c3, c3]
    )


def _paths(pieces):
    """Position along, right of and below the level first tangent of every piece as polynomials of u.

    With w = exp(i turn) the series of the tangent follows from dw/du = i curvature w; likewise exp(i gradient).

    Returns
    -------
    path : array (n, 3, PATH_ORDER)
        Coefficients of u^1 ... u^PATH_ORDER [m].
    neglected : array (n,)
        Sum of the magnitudes of the terms left out, at the end of the piece [m].
    """
    curvature, (angle, bend) = pieces["curvature"], pieces["gradient"].T
    heading, rise = np.zeros((2, pieces.size, SERIES), complex)
    heading[:, 0], rise[:, 0] = 1.0, np.exp(1j * angle)
    for m in range(SERIES - 1):
        reach = min(m, 3)
        terms = heading[:, m - reach : m + 1] * curvature[:, reach::-1]
        heading[:, m + 1] = 1j * terms.sum(axis=1) / (m + 1)
        rise[:, m + 1] = 1j * bend * rise[:, m] / (m + 1)
    plan = np.stack([np.sum(heading[:, : m + 1] * rise.real[:, m::-1], axis=1) for m in range(SERIES)], axis=1)
    exponent = np.arange(1, SERIES + 1)
    path = np.stack([plan.real, plan.imag, -rise.imag], axis=1) / exponent
    tail = np.abs(path[:, :, PATH_ORDER:]) * pieces["length"][:, None, None] ** exponent[PATH_ORDER:]
    return path[:, :, :PATH_ORDER], tail.sum(axis=2).max(axis=1)


def _join(pieces, path):
    """Put the pieces end to end, from plan position, height and heading zero at arc length 0."""
    length = pieces["length"]
    turn = np.sum(pieces["curvature"] * length[:, None] ** np.arange(1, 5) / np.arange(1, 5), axis=1)
    x, y, z = np.sum(path * length[:, None, None] ** np.arange(1, PATH_ORDER + 1), axis=2).T
    first = np.searchsorted(pieces["start"], 0.0)
    heading = _running(turn, first)
    plan = _running(np.exp(1j * heading) * (x + 1j * y), first)
    pieces["heading"], pieces["cos_heading"], pieces["sin_heading"] = heading, np.cos(heading), np.sin(heading)
    pieces["x"], pieces["y"], pieces["z"] = plan.real, plan.imag, _running(z, first)
    for k, name in enumerate(("path_x", "path_y", "path_z")):
        pieces[name] = path[:, k]


def _running(steps, first):
    """Sum of all steps before each, zero at index `first`."""
    total = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
    return total - total[first]


def constant_track(curvature, cant):
    """Track of one curvature [1/m], right-hand positive, and cant [m], left over right rail, however far one goes.

    With a constant gradient, ``pack(track, gradients=(Gradient(gradient=...),))``, it is a helix.
    """
    if curvature == 0.0:
        return Track((Straight(length=1.0, cant=cant),))
    hand = "left" if curvature < 0.0 else "right"
    return Track((Curve(length=1.0, radius=1.0 / abs(curvature), hand=hand, cant=cant if hand == "right" else -cant),))
