"""What descriptions of force elements share: copies on the other side, and tables of force."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from railcli.kernels.layout import CURVE_KNOTS

from .checks import Description, Name, Point, Real

MIRRORS = {  # signs of x and y of each copy
    "none": ((1, 1),),
    "y": ((1, 1), (1, -1)),
    "x": ((1, 1), (-1, 1)),
    "xy": ((1, 1), (1, -1), (-1, 1), (-1, -1)),
}
Mirror = Literal["none", "x", "y", "xy"]
_Value = Annotated[Real, Field(ge=-1e12, le=1e12)]
Values = Annotated[tuple[_Value, ...], Field(min_length=2, max_length=CURVE_KNOTS)]


class AtPoint(Description):
    """A force element whose ends stand at one point in the nominal geometry."""

    name: Name
    at: Point = Field(alias="at_m")
    mirror: Mirror = "none"

    @property
    def ends(self):
        return self.at, self.at

    @property
    def signs(self):
        return MIRRORS[self.mirror]


def mirrored_apart(element):
    """The same element; refused where a mirrored copy would stand in the same place."""
    for axis, letter in enumerate("xy"):
        if letter in element.mirror and all(end[axis] == 0.0 for end in element.ends):
            raise ValueError(f"mirror = {element.mirror!r}, but its {letter} is 0: it would stand twice in one place")
    return element


def check_knots(name, argument, force, value="force"):
    """Refuse what is no curve: an argument that does not rise, a force that falls; with the names of both."""
    if len(argument) != len(force):
        raise ValueError(f"{name} has {len(argument)} values, {value} has {len(force)}")
    if np.any(np.diff(argument) <= 0.0):
        raise ValueError(f"{name} must increase from each value to the next")
    if np.any(np.diff(force) < 0.0):
        raise ValueError(f"{value} must not decrease")
