"""Sections of a track as users describe them: straights, transitions, curves, measured tables; gradients.

Curvature is positive in a right-hand curve; cant inside is the height of the left over the right rail, so it is
positive there too. Of curves users give the hand, and cant as the height of the outer over the inner rail. All lengths
count along the track.
"""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from .checks import Description, NotNegative, Real, one_of
from .submodels import TRANSITIONS

SHARPEST = 0.1  # curvature of the tightest curve [1/m]

Length = Annotated[Real, Field(ge=1e-3, le=1e6)]
Cant = Annotated[Real, Field(ge=-0.3, le=0.3)]
Slope = Annotated[Real, Field(ge=-0.15, le=0.15)]
Widening = Annotated[NotNegative, Field(le=0.05)]
Column = Annotated[tuple[Real, ...], Field(min_length=2)]


class Edge(NamedTuple):
    """What holds where a section begins or ends."""

    curvature: float  # positive to the right [1/m]
    cant: float  # left over right rail [m]


class Straight(Description):
    """No curvature, constant cant."""

    kind: Literal["straight"] = "straight"
    length: Length = Field(alias="length_m")
    cant: Cant = Field(0.0, alias="cant_m")  # left over right rail

    @property
    def curvature(self):
        return 0.0

    @property
    def signed_cant(self):
        """Height of the left over the right rail [m]."""
        return self.cant

    @property
    def ends(self):
        """Edge at the beginning and at the end."""
        return (Edge(0.0, self.cant),) * 2

    def shift(self, gauge):
        """Lateral displacement of left and right rail from their nominal places [m], positive to the right."""
        return 0.0, 0.0


class Curve(Description):
    """Constant curvature, cant and gauge."""

    kind: Literal["curve"] = "curve"
    length: Length = Field(alias="length_m")
    radius: Annotated[Real, Field(ge=1.0 / SHARPEST, le=1e9)] = Field(alias="radius_m")
    hand: Literal["left", "right"]
    cant: Cant = Field(0.0, alias="cant_m")  # outer rail over inner rail
    gauge_widening: Widening = Field(0.0, alias="gauge_widening_m")  # the inner rail stands this far further inwards

    @property
    def curvature(self):
        """Positive to the right [1/m]."""
        return (1.0 if self.hand == "right" else -1.0) / self.radius

    @property
    def signed_cant(self):
        """Height of the left over the right rail [m]."""
        return self.cant if self.hand == "right" else -self.cant

    @property
    def ends(self):
        """Edge at the beginning and at the end."""
        return (Edge(self.curvature, self.signed_cant),) * 2

    def shift(self, gauge):
        """Lateral displacement of left and right rail from their nominal places [m], positive to the right."""
        return (0.0, self.gauge_widening) if self.hand == "right" else (-self.gauge_widening, 0.0)


class Transition(Description):
    """Curvature, cant and gauge go from those of the section before to those of the section after."""

    kind: Literal["transition"] = "transition"
    length: Length = Field(alias="length_m")
    shape: one_of(TRANSITIONS) = "clothoid"


class Measured(Description):
    """A table over the position along the track; straight lines between its points."""

    kind: Literal["measured"] = "measured"
    position: Column = Field(alias="position_m")
    curvature: Column = Field(alias="curvature_1_per_m")  # positive to the right
    cant: Column | None = Field(None, alias="cant_m")  # left over right rail
    gradient: Column | None = Field(None, alias="gradient_m_per_m")  # rise over horizontal length
    gauge: Column | None = Field(None, alias="gauge_m")

    @model_validator(mode="after")
    def _is_a_track(self):
        limits = {
            "curvature": (-SHARPEST, SHARPEST, "1/m", 1.0),
            "cant": (-300.0, 300.0, "mm", 1e3),
            "gradient": (-150.0, 150.0, "per mille", 1e3),
            "gauge": (500.0, 2000.0, "mm", 1e3),
        }
        for name, (low, high, unit, factor) in limits.items():
            values = getattr(self, name)
            if values is None:
                continue
            if len(values) != len(self.position):
                raise ValueError(f"{len(self.position)} positions and {len(values)} values of {name}")
            scaled = factor * np.array(values)
            worst = int(np.argmax(np.abs(scaled - 0.5 * (low + high))))
            if not low <= scaled[worst] <= high:
                raise ValueError(
                    f"{name} {scaled[worst]:.6g} {unit} at {self.position[worst]:g} m: must be {low:g} to {high:g} "
                    f"{unit}; check the unit"
                )
        steps = np.diff(self.position)
        if not (steps > 0.0).all():
            k = int(np.argmax(steps <= 0.0))
            word = "repeats" if steps[k] == 0.0 else "falls"
            after, before = self.position[k + 1], self.position[k]
            raise ValueError(f"position {word}: {after:g} m follows {before:g} m; it must rise")
        return self

    @property
    def length(self):
        """From the first to the last position [m]."""
        return self.position[-1] - self.position[0]

    @property
    def ends(self):
        """Edge at the beginning and at the end."""
        cant = self.cant or (0.0, 0.0)
        return Edge(self.curvature[0], cant[0]), Edge(self.curvature[-1], cant[-1])

    def column(self, name):
        """Values of `curvature`, `cant` or `gradient` at the positions, zero where the table has none."""
        values = getattr(self, name)
        return np.zeros(len(self.position)) if values is None else np.array(values)

    def shift(self, gauge):
        """Lateral displacement of left and right rail at the positions [m]: half of what exceeds the nominal gauge."""
        if self.gauge is None:
            return 0.0, 0.0
        half = 0.5 * (np.array(self.gauge) - gauge)
        return -half, half


class Gradient(Description):
    """From `at` on the track rises by `gradient`; a vertical curve around `at` joins it to the gradient before.

    A first entry at 0 gives the gradient with which the track begins; otherwise it begins level.
    """

    at: NotNegative = Field(0.0, alias="at_m")  # middle of the vertical curve
    gradient: Slope = Field(alias="gradient_m_per_m")  # rise over horizontal length
    radius: Annotated[Real, Field(ge=100.0, le=1e9)] | None = Field(None, alias="radius_m")  # of the vertical curve
