"""Track: straights, transitions and curves in any sequence, and their pieces for the compiled core.

Curvature is positive in a right-hand curve; cant inside is the height of the left over the right rail, so it is
positive there too. Users give the hand, and cant as the height of the outer over the inner rail.
"""

from math import factorial
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, RootModel, model_validator

from railcli.kernels.layout import PATH_ORDER, PIECE

from .checks import Description, Real, one_of
from .submodels import TRANSITIONS

MARGIN = 50.0  # track that continues before the first and after the last section [m]
LONGEST_PIECE = 25.0  # [m]
LARGEST_TURN = 0.1  # of a piece [rad]
REMAINDER = 1e-13  # largest sum of the neglected terms of a piece's position [m]

Length = Annotated[Real, Field(ge=1e-3, le=1e6)]


class Straight(Description):
    """No curvature, no cant."""

    kind: Literal["straight"] = "straight"
    length: Length = Field(alias="length_m")

    @property
    def curvature(self):
        return 0.0

    @property
    def signed_cant(self):
        return 0.0


class Curve(Description):
    """Constant curvature and cant."""

    kind: Literal["curve"] = "curve"
    length: Length = Field(alias="length_m")
    radius: Annotated[Real, Field(ge=10.0, le=1e9)] = Field(alias="radius_m")
    hand: Literal["left", "right"]
    cant: Annotated[Real, Field(ge=-0.3, le=0.3)] = Field(0.0, alias="cant_m")  # outer rail over inner rail

    @property
    def curvature(self):
        """Positive to the right [1/m]."""
        return (1.0 if self.hand == "right" else -1.0) / self.radius

    @property
    def signed_cant(self):
        """Height of the left over the right rail [m]."""
        return self.cant if self.hand == "right" else -self.cant


class Transition(Description):
    """Curvature and cant go from those of the section before to those of the section after."""

    kind: Literal["transition"] = "transition"
    length: Length = Field(alias="length_m")
    shape: one_of(TRANSITIONS) = "clothoid"


Section = Annotated[Straight | Curve | Transition, Field(discriminator="kind")]


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

    @model_validator(mode="after")
    def _joins(self):
        if not self.root:
            raise ValueError("has no section; give at least one of kind 'straight', 'transition' or 'curve'")
        kinds = [section.kind for section in self.root]
        if "transition" in (kinds[0], kinds[-1]):
            raise ValueError("begins or ends with a transition; it needs a straight or a curve on either side")
        for number, (one, two) in enumerate(zip(self.root, self.root[1:], strict=False), start=1):
            where = f"sections {number} and {number + 1}"
            if one.kind == two.kind == "transition":
                raise ValueError(f"{where} are both transitions; put a straight or a curve between them")
            if "transition" in (one.kind, two.kind):
                continue
            if one.curvature != two.curvature or one.signed_cant != two.signed_cant:
                raise ValueError(
                    f"curvature or cant jumps between {where} ({one.kind}, {two.kind}); "
                    "put a section of kind 'transition' between them"
                )
        return self


def pack(track, margin=MARGIN):
    """Pieces of the track for the compiled core.

    Parameters
    ----------
    track : Track
    margin : float
        Length by which the first section is continued backwards and the last one forwards [m].

    Returns
    -------
    numpy.ndarray of PIECE
        Read-only, in order of `start`; at arc length 0, where the first section begins, plan position and heading
        are zero.
    """
    rows = []
    for start, length, curvature, cant in _stretches(track, margin):
        rows.extend(_split(start, length, curvature, cant))
    pieces = np.zeros(len(rows), PIECE)
    x = y = heading = 0.0
    origin = (0.0, 0.0, 0.0)
    for piece, (start, length, curvature, cant, path) in zip(pieces, rows, strict=True):
        if start == 0.0:
            origin = (x, y, heading)
        piece["start"], piece["length"] = start, length
        piece["x"], piece["y"], piece["heading"] = x, y, heading
        piece["curvature"], piece["cant"] = curvature, cant
        piece["path_x"], piece["path_y"] = path.real, path.imag
        end = np.exp(1j * heading) * np.sum(path * length ** np.arange(1, PATH_ORDER + 1))
        x, y = x + end.real, y + end.imag
        heading += np.sum(curvature * length ** np.arange(1, 5) / np.arange(1, 5))
    _move_origin(pieces, *origin)
    pieces["cos_heading"], pieces["sin_heading"] = np.cos(pieces["heading"]), np.sin(pieces["heading"])
    pieces.flags.writeable = False
    return pieces


def _stretches(track, margin):
    """Start, length and the polynomials of curvature and cant in u = s - start, margins included."""
    sections = track.sections
    first, last = sections[0], sections[-1]
    yield -margin, margin, _constant(first.curvature), _constant(first.signed_cant)
    start = 0.0
    for i, section in enumerate(sections):
        if section.kind == "transition":
            before, after = sections[i - 1], sections[i + 1]
            shape = np.array(TRANSITIONS[section.shape].value) / section.length ** np.arange(4)
            curvature = _constant(before.curvature) + (after.curvature - before.curvature) * shape
            cant = _constant(before.signed_cant) + (after.signed_cant - before.signed_cant) * shape
        else:
            curvature, cant = _constant(section.curvature), _constant(section.signed_cant)
        yield start, section.length, curvature, cant
        start += section.length
    yield start, margin, _constant(last.curvature), _constant(last.signed_cant)


def _constant(value):
    return np.array([value, 0.0, 0.0, 0.0])


def _split(start, length, curvature, cant):
    """Equal pieces, as many as the bounds on length, turn and remainder need."""
    steepest = np.abs(np.polynomial.polynomial.polyval(np.linspace(0.0, length, 9), curvature)).max()
    count = int(np.ceil(max(length / LONGEST_PIECE, length * steepest / LARGEST_TURN)))
    while True:
        edges = np.linspace(0.0, length, count + 1)
        step = length / count
        rows, remainder = [], 0.0
        for u in edges[:-1]:
            here = _shifted(curvature, u)
            path, neglected = _path(here, step)
            rows.append((start + u, step, here, _shifted(cant, u), path))
            remainder = max(remainder, neglected)
        if remainder <= REMAINDER:
            return rows
        count *= 2


def _shifted(polynomial, u):
    """Coefficients of the same polynomial about u."""
    c0, c1, c2, c3 = polynomial
    return np.array([c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + u * 3.0 * c3), c2 + 3.0 * u * c3, c3])


def _path(curvature, length, terms=10):
    """Plan position along (real) and right of (imaginary) the first tangent as a polynomial of u.

    The Taylor series of the integral of exp(i heading). Returns its coefficients of u^1 ... u^PATH_ORDER and the sum
    of the magnitudes of the terms left out, at the end of the piece [m].
    """
    heading = np.concatenate([[0.0], curvature / np.arange(1, 5)])
    tangent = np.zeros(4 * terms + 1, complex)
    power = np.ones(1)
    for n in range(terms + 1):
        tangent[: power.size] += 1j**n / factorial(n) * power
        power = np.convolve(power, heading)
    exponent = np.arange(1, tangent.size + 1)
    path = tangent / exponent
    neglected = np.abs(path[PATH_ORDER:]) * length ** exponent[PATH_ORDER:]
    return path[:PATH_ORDER], neglected.sum()


def _move_origin(pieces, x, y, heading):
    """Turn and shift the plan so that this pose becomes the origin."""
    plan = (pieces["x"] - x + 1j * (pieces["y"] - y)) * np.exp(-1j * heading)
    pieces["x"], pieces["y"] = plan.real, plan.imag
    pieces["heading"] -= heading


def constant_track(curvature, cant):
    """Track of one curvature [1/m], right-hand positive, and cant [m], left over right rail, however far one goes."""
    if curvature == 0.0 and cant == 0.0:
        return Track((Straight(length=1.0),))
    hand = "left" if curvature < 0.0 else "right"
    return Track((Curve(length=1.0, radius=1.0 / abs(curvature), hand=hand, cant=cant if hand == "right" else -cant),))
