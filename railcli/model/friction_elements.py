"""Elements whose force depends on the way they went: dry friction and leaf springs (theory.md, 5.7 and 5.8).

Points: x forward, y to the right, height above the rail tops [m].
"""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from .checks import Coefficient, Description, Name, NotNegative, Point, Positive, Real
from .element_parts import MIRRORS, AtPoint, Mirror, Values, check_knots, mirrored_apart

SERIES_DAMPING = 0.05  # of critical damping of the two bodies against each other on the series spring


class Friction(Description):
    """Dry friction between two bodies: at a point along axes of the joint, or along the line between two points."""

    name: Name
    at: Point | None = Field(None, alias="at_m")
    directions: Literal["x", "y", "z", "xy", "xz", "yz", "xyz"] | None = None  # in two or three: a circular limit
    lower: Point | None = Field(None, alias="lower_m")
    upper: Point | None = Field(None, alias="upper_m")
    mirror: Mirror = "none"
    limit: Annotated[NotNegative, Field(le=1e12)] = Field(0.0, alias="limit_N")
    coefficient: Annotated[NotNegative, Field(le=100.0)] = 0.0  # of the load
    load_of: Name | None = None  # a bushing of the same joint
    series_stiffness: Coefficient = Field(0.0, alias="series_stiffness_N_per_m")
    series_damping: Annotated[NotNegative, Field(le=1.0)] = SERIES_DAMPING

    @property
    def is_link(self):
        return self.at is None

    @property
    def ends(self):
        return (self.lower, self.upper) if self.is_link else (self.at, self.at)

    @property
    def signs(self):
        return MIRRORS[self.mirror]

    @property
    def length(self):
        """Distance of the ends in the nominal geometry [m]."""
        return float(np.linalg.norm(np.subtract(*self.ends)))

    def damping_between(self, *masses):
        """Damping beside the series spring, for two bodies of these masses [kg] [N s/m]."""
        return 2.0 * self.series_damping * float(np.sqrt(self.series_stiffness / np.sum(1.0 / np.array(masses))))

    @model_validator(mode="after")
    def _acts(self):
        line = self.lower is not None, self.upper is not None
        if (self.at is None) != all(line) or (self.at is not None and any(line)):
            raise ValueError("give either at_m with directions, or lower_m and upper_m")
        if self.is_link == (self.directions is not None):
            raise ValueError("directions: goes with at_m, and only with it; 'yz' is the plane across the track")
        if self.is_link and self.length == 0.0:
            raise ValueError("lower_m and upper_m are the same point; give at_m and directions there")
        if self.series_stiffness == 0.0:
            raise ValueError("friction needs series_stiffness_N_per_m > 0: what gives before it slides")
        if (self.coefficient > 0.0) != (self.load_of is not None):
            raise ValueError("coefficient and load_of go together: friction per load of that element")
        if self.limit == 0.0 and self.coefficient == 0.0:
            raise ValueError("does nothing; give limit_N, or coefficient and load_of")
        return mirrored_apart(self)


class Envelope(Description):
    """Force of a leaf spring over its deflection, approached while it moves one way; continued along its last slopes.

    Force is counted from that at rest in the nominal geometry.
    """

    displacement: Values = Field(alias="displacement_m")
    force: Values = Field(alias="force_N")

    @model_validator(mode="after")
    def _is_a_spring(self):
        check_knots("displacement", self.displacement, self.force)
        return self


class LeafSpring(AtPoint):
    """Leaf spring along the joint's z: stiffness and friction between its leaves, or two measured envelopes."""

    stiffness: Coefficient | None = Field(None, alias="stiffness_N_per_m")
    friction: Annotated[Positive, Field(le=1e12)] | None = Field(None, alias="friction_N")  # half the width of the loop
    upper_envelope: Envelope | None = None  # while it is compressed
    lower_envelope: Envelope | None = None  # while it expands
    decay: Annotated[Real, Field(ge=1e-6, le=1.0)] = Field(alias="decay_m")

    @property
    def envelopes(self):
        """Displacements and forces of the upper and of the lower envelope."""
        if self.upper_envelope is None:
            x = np.array([-1.0, 1.0])
            return (x, self.stiffness * x + self.friction), (x, self.stiffness * x - self.friction)
        return tuple(
            (np.array(envelope.displacement), np.array(envelope.force))
            for envelope in (self.upper_envelope, self.lower_envelope)
        )

    @property
    def soft_stiffness(self):
        """Slope of the force for small motions about the middle of the loop, nothing displaced [N/m]."""
        return float(self._width(np.zeros(1))[0] / (2.0 * self.decay))

    @property
    def middle(self):
        """Force between the envelopes, nothing displaced [N]."""
        return 0.5 * sum(float(_line(x, y, np.zeros(1))[0][0]) for x, y in self.envelopes)

    def _width(self, at):
        upper, lower = (_line(x, y, at)[0] for x, y in self.envelopes)
        return upper - lower

    @model_validator(mode="after")
    def _loses_energy(self):
        lines, tables = (self.stiffness, self.friction), (self.upper_envelope, self.lower_envelope)
        given = [all(part is not None for part in pair) for pair in (lines, tables)]
        partly = [any(part is not None for part in pair) for pair in (lines, tables)]
        if given != partly or sum(given) != 1:
            raise ValueError(
                "give either stiffness_N_per_m and friction_N, or upper_envelope and lower_envelope, both of the pair"
            )
        (x, _), (other, _) = self.envelopes
        at = np.union1d(x, other)
        pieces = np.concatenate([[at[0] - 1.0], 0.5 * (at[1:] + at[:-1]), [at[-1] + 1.0]])
        if not self._width(np.zeros(1))[0] > 0.0 or np.any(self._width(at) < 0.0) or np.any(self._width(pieces) < 0.0):
            raise ValueError("the upper envelope must lie above the lower one, beyond their ends too")
        upper, lower = (_line(x, y, np.zeros(1))[0][0] for x, y in self.envelopes)
        if not lower <= 0.0 <= upper:
            raise ValueError("at a deflection of 0, no force must lie between the envelopes: it is the loop at rest")
        slopes = sum(_line(x, y, pieces)[1] for x, y in self.envelopes)
        ends = np.concatenate([at[:1], at, at[-1:]])
        for k, slope in enumerate(slopes):
            width = self._width(ends[k : k + 2]).min()
            if width < self.decay * slope * (1.0 - 1e-9):
                raise ValueError(
                    f"decay_m: {self.decay:g} m is too long at a deflection of {ends[k]:g} m: the force would lag so "
                    f"far behind its envelopes that the spring gave energy; at most {width / slope:.3g} m there"
                )
        return mirrored_apart(self)


def _line(x, y, at):
    """Value and slope at places of a piecewise linear curve, continued along its first and last slopes."""
    piece = np.clip(np.searchsorted(x, at) - 1, 0, x.size - 2)
    slope = np.diff(y)[piece] / np.diff(x)[piece]
    return y[piece] + slope * (at - x[piece]), slope
