"""An alignment as it runs along s, and what EN 13803 says to it (field practice; sources in LIMITS)."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from railcli.kernels.layout import PATH_ORDER

from .parts import parts

POINTS = 201  # per section at which it is judged, at least; measured tables at every position too
FINEST = 0.5  # [m]
SMALL_RADIUS = 320.0  # below it the standard limits cant by the radius [m]
INSIDE = 1e-9  # distance from its ends at which a section is looked at: there the next one has begun [m]
ROUNDING = 1e-9  # relative excess over a limit that is none


class Standard(NamedTuple):
    """A limit of the standard, SI units."""

    normal: float
    exceptional: float
    where: str  # what of the standard


NOT_CONSULTED = (
    "Values of EN 13803 as commonly quoted; the standard itself could not be consulted. [limits] sets your own."
)
LIMITS = {  # all of them for conventional vehicles and plain line, as NOT_CONSULTED says
    "cant": Standard(0.160, 0.180, "cant D, ballasted track"),
    "cant_deficiency": Standard(0.130, 0.153, "cant deficiency I, vehicles that do not tilt, up to 200 km/h"),
    "cant_excess": Standard(0.110, 0.110, "cant excess E"),
    "cant_rate": Standard(0.050, 0.060, "rate of change of cant dD/dt"),
    "cant_deficiency_rate": Standard(0.055, 0.090, "rate of change of cant deficiency dI/dt"),
    "twist": Standard(2.25e-3, 2.5e-3, "cant gradient dD/ds"),
    "vertical_acceleration": Standard(0.22, 0.31, "vertical curve, R_v >= 0.35 V^2 and 0.25 V^2 (m, km/h)"),
}
AT_A_PLACE = ("cant", "cant_deficiency", "cant_excess")
TIMED = ("cant_deficiency", "cant_excess", "cant_rate", "cant_deficiency_rate", "vertical_acceleration")


@dataclass(frozen=True)
class Course:
    """Arrays over arc length s [m].

    Attributes
    ----------
    curvature : array
        Positive to the right [1/m].
    cant : array
        Left over right rail [m].
    gradient : array
        Angle, positive where the track rises [rad].
    bend : array
        Change of that angle per metre [1/m].
    place : array (n, 3)
        Of the track frame's origin in ground axes: x, y, z down [m].
    heading : array
        Positive to the right [rad].
    """

    s: np.ndarray
    curvature: np.ndarray
    cant: np.ndarray
    gradient: np.ndarray
    bend: np.ndarray
    place: np.ndarray
    heading: np.ndarray


def course(pieces, s):
    """The Course of packed pieces of track at arc lengths s [m], which must lie on them."""
    s = np.asarray(s, float)
    piece = pieces[np.clip(np.searchsorted(pieces["start"], s, side="right") - 1, 0, None)]
    u = (s - piece["start"])[:, None]

    def value(coefficients):
        return np.sum(coefficients * u ** np.arange(coefficients.shape[1]), axis=1)

    def series(coefficients):
        return np.sum(coefficients * u ** np.arange(1, PATH_ORDER + 1), axis=1)

    along = np.exp(1j * piece["heading"]) * (series(piece["path_x"]) + 1j * series(piece["path_y"]))
    cant = value(piece["cant"])
    place = [piece["x"] + along.real, piece["y"] + along.imag]
    place.append(piece["z"] + series(piece["path_z"]) - piece["lift"] * cant)
    turned = np.sum(piece["curvature"] * u ** np.arange(1, 5) / np.arange(1, 5), axis=1)
    return Course(
        s=s,
        curvature=value(piece["curvature"]),
        cant=cant,
        gradient=value(piece["gradient"]),
        bend=piece["gradient"][:, 1].copy(),
        place=np.stack(place, axis=1),
        heading=piece["heading"] + turned,
    )


def deficiency(found, speed, gravity, base):
    """What cant lacks of balance at a speed, signed like cant: b V^2 curvature / g - cant [m]."""
    return base * speed**2 * found.curvature / gravity - found.cant


class Finding(NamedTuple):
    """A value beyond its limit."""

    section: int  # counted from 1
    key: str  # of LIMITS
    value: float
    s: float  # where it is largest [m]
    limit: float
    kind: str  # "own", "normal", "exceptional" or "small radius"


class Span(NamedTuple):
    """Values over a section."""

    first: float
    last: float
    low: float
    high: float

    @property
    def turns(self):
        """True when values lie beyond both ends."""
        return min(self.first, self.last) - self.low > 1e-12 or self.high - max(self.first, self.last) > 1e-12


def _span(values):
    return Span(*(float(value) for value in (values[0], values[-1], values.min(), values.max())))


@dataclass(frozen=True)
class Judged:
    """One section of track; of a measured table one of the straights, curves and transitions found in it.

    Attributes
    ----------
    number : int
        Counted from 1.
    kind : str
        ``straight``, ``curve``, ``transition`` of a measured table, or the shape of a described one.
    start, end : float
        [m]
    curvature, cant, gradient, widening : Span
        [1/m, m, rad]; of the gauge over the nominal one [m].
    values : dict
        Largest values by the keys of LIMITS, SI; those of TIMED only where there is a speed.
    findings : list of Finding
    """

    number: int
    kind: str
    start: float
    end: float
    curvature: Span
    cant: Span
    gradient: Span
    widening: Span
    values: dict
    findings: list


def judge(track, pieces, limits, cant_base, gauge, gravity=9.81, speed=None):
    """Largest values of each section, and those beyond their limits.

    Parameters
    ----------
    track : Track
    pieces : array of PIECE
        The same, packed.
    limits : Limits
    cant_base, gauge : float
        [m]
    gravity : float
        [m/s^2]
    speed : float, optional
        Without it what depends on time is left out [m/s].

    Returns
    -------
    list of Judged
    """
    half = 0.5 * limits.base
    result = []
    for number, (start, end, kind, places) in enumerate(_sections(track), start=1):
        s = np.linspace(start, end, max(POINTS, int((end - start) / FINEST)))
        s = np.clip(np.union1d(s, places) if len(places) else s, start + INSIDE, end - INSIDE)
        from_, to = np.maximum(s - half, start), np.minimum(s + half, end)
        here, behind, ahead = (course(pieces, at) for at in (s, from_, to))
        twist = np.abs(ahead.cant - behind.cant) / (to - from_)
        courses = {"cant": np.abs(here.cant), "twist": twist}
        if speed is not None:
            lack = deficiency(here, speed, gravity, cant_base)
            outwards = np.where(here.curvature == 0.0, -np.abs(here.cant), np.sign(here.curvature) * lack)
            change = deficiency(ahead, speed, gravity, cant_base) - deficiency(behind, speed, gravity, cant_base)
            courses |= {
                "cant_deficiency": np.maximum(outwards, 0.0),
                "cant_excess": np.maximum(-outwards, 0.0),
                "cant_rate": speed * twist,
                "cant_deficiency_rate": speed * np.abs(change) / (to - from_),
                "vertical_acceleration": speed**2 * np.abs(here.bend),
            }
        values = {key: float(courses[key].max()) for key in LIMITS if key in courses}
        findings = [one for key in values if (one := _finding(number, key, s, courses[key], limits, here))]
        if kind not in ("straight", "curve"):  # what is largest at its ends belongs to its neighbours
            findings = [one for one in findings if one.key not in AT_A_PLACE or start + FINEST < one.s < end - FINEST]
        wide = np.diff(track.shifts(s, gauge), axis=0)[0]
        result.append(
            Judged(
                number,
                kind,
                start,
                end,
                *(_span(values) for values in (here.curvature, here.cant, here.gradient, wide)),
                values,
                findings,
            )
        )
    return result


def _sections(track):
    """Start, end and kind of what is judged by itself, and places that must be looked at: (start, end, kind, s)."""
    for start, section in track.located():
        if section.kind != "measured":
            kind = section.shape if section.kind == "transition" else section.kind
            yield start, start + section.length, kind, ()
            continue
        at = np.array(section.position) - section.position[0] + start
        for part in parts(section, start):
            yield part.start, part.end, part.kind, at[(at >= part.start) & (at <= part.end)]


def _finding(number, key, s, values, limits, here):
    """The Finding of one quantity in one section, or None."""
    worst = int(np.argmax(values))
    value, place = float(values[worst]), float(s[worst])
    own = getattr(limits, key)
    if own is not None:
        return Finding(number, key, value, place, own, "own") if value > own * (1.0 + ROUNDING) else None
    standard = LIMITS[key]
    for limit, kind in ((standard.exceptional, "exceptional"), (standard.normal, "normal")):
        if value > limit * (1.0 + ROUNDING):
            return Finding(number, key, value, place, limit, kind)
    if key == "cant":
        with np.errstate(divide="ignore"):
            radius = np.abs(1.0 / here.curvature)
        allowed = np.where(radius < SMALL_RADIUS, (radius - 50.0) / 1.5e3, np.inf)
        worst = int(np.argmax(values - allowed))
        if values[worst] > allowed[worst] * (1.0 + ROUNDING):
            return Finding(number, key, float(values[worst]), float(s[worst]), float(allowed[worst]), "small radius")
    return None
