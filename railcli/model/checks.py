"""Field types shared by the descriptions: what every validated, immutable object of the model is made of.

A field has a plain name in Python and SI units; its alias, which a file uses, ends with its SI unit.
"""

import difflib
from typing import Annotated

from pydantic import AfterValidator, AllowInfNan, BaseModel, ConfigDict, Field, Strict


class Description(BaseModel):
    """Base of all descriptions: frozen, no unknown fields, built by name in Python and by alias from a file."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", validate_by_name=True, validate_by_alias=True, serialize_by_alias=True
    )


Real = Annotated[float, Strict(), AllowInfNan(False)]
Positive = Annotated[Real, Field(gt=0.0)]
NotNegative = Annotated[Real, Field(ge=0.0)]
Coordinate = Annotated[Real, Field(ge=-1000.0, le=1000.0)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Coefficient = Annotated[NotNegative, Field(le=1e15)]  # a stiffness or damping
CoefficientVector = tuple[Coefficient, Coefficient, Coefficient]
NONE = (0.0, 0.0, 0.0)
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
Name = Annotated[str, Strict(), Field(min_length=1, max_length=80)]
Place = Annotated[str, Strict(), Field(min_length=1, max_length=4096)]  # of a file, or a bundled name


def nearest(name, known):
    """The entry of `known` that `name` was probably meant to be, or None."""
    near = difflib.get_close_matches(str(name), list(known), n=1)
    return near[0] if near else None


def hint(name, known):
    """Words that follow an unknown name: the nearest known one, else all of them."""
    near = nearest(name, known)
    return f"did you mean {near!r}?" if near else f"known: {', '.join(repr(entry) for entry in known)}"


def one_of(table):
    """Type of a text field that must be a key of `table`."""

    def check(name):
        if name not in table:
            raise ValueError(f"unknown name {name!r}; {hint(name, table)}")
        return name

    return Annotated[Name, AfterValidator(check)]
