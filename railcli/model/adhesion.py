"""What the line lends and asks: adhesion, running resistance (docs/subsystems.md, 4)."""

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from railcli.kernels.assembly_layout import Grip, Memory

from .checks import Description, NotNegative, Positive, one_of
from .driving import increasing
from .submodels import ADHESION_SETS

MEMORIES = {"none": Memory.NONE, "own": Memory.OWN, "rail": Memory.RAIL}


class Stretch(Description):
    """Adhesion from a place of the line on, of both rails or each: a named set, or its numbers."""

    start: NotNegative = Field(0.0, alias="from_m")
    set: one_of(ADHESION_SETS) | None = None
    left: one_of(ADHESION_SETS) | None = None  # of the left rail where it is not the same
    friction: Annotated[NotNegative, Field(le=1.0)] | None = None  # mu0 in place of that of the set
    ratio: Annotated[Positive, Field(le=1.0)] | None = None
    decay: Annotated[NotNegative, Field(le=1000.0)] | None = Field(None, alias="decay_s_per_m")
    adhesion_reduction: Annotated[Positive, Field(le=1.0)] | None = None
    slip_reduction: Annotated[Positive, Field(le=1.0)] | None = None
    blend: Annotated[Positive, Field(le=1000.0)] = Field(1.0, alias="blend_m")
    clean: one_of(ADHESION_SETS) | None = None  # the set that wheels bring back by their work; None: none do

    @model_validator(mode="after")
    def _says_something(self):
        if self.set is None and self.friction is None:
            raise ValueError("give set (a named one) or friction")
        for side in self.grips():
            if side[Grip.SLIP] > side[Grip.ADHESION]:
                raise ValueError(
                    f"slip_reduction must be at most adhesion_reduction, got {side[Grip.SLIP]:g} and "
                    f"{side[Grip.ADHESION]:g}"
                )
            if (side[Grip.RATIO] < 1.0) != (side[Grip.DECAY] > 0.0):
                raise ValueError(
                    "friction falls to ratio times it as exp(-decay_s_per_m times slip velocity): a ratio below 1 "
                    f"and a decay above 0, or neither; got {side[Grip.RATIO]:g} and {side[Grip.DECAY]:g} s/m"
                )
        return self

    def grips(self):
        """Grip of the right and the left rail, (2, GRIPS)."""
        own = (self.friction, self.ratio, self.decay, self.adhesion_reduction, self.slip_reduction)
        plain = (0.0, 1.0, 0.0, 1.0, 1.0)
        sets = (self.set, self.left or self.set)
        base = [ADHESION_SETS[name].value if name else plain for name in sets]
        return np.array([[b if o is None else o for b, o in zip(one, own, strict=True)] for one in base])

    def cleaned(self):
        """Likewise where the film is gone."""
        return np.array([ADHESION_SETS[self.clean].value] * 2) if self.clean else self.grips()


class Adhesion(Description):
    """What the rails lend along the line."""

    kind: Literal["line"] = "line"
    stretches: Annotated[tuple[Stretch, ...], Field(min_length=1, max_length=1000)] = Field(alias="stretch")
    memory: one_of(MEMORIES) = "none"  # whose work cleans a film: a wheel's own, or that of all that passed
    cleaning: Annotated[NotNegative, Field(le=1.0)] = Field(1.9e-4, alias="cleaning_m_per_J")
    cell: Annotated[Positive, Field(ge=0.05, le=100.0)] = Field(1.0, alias="cell_m")

    @model_validator(mode="after")
    def _in_order(self):
        increasing("stretch: from_m", [one.start for one in self.stretches], 0.0)
        for number, (one, other) in enumerate(pairwise(self.stretches), start=2):
            if number > 2 and one.start + one.blend > other.start:
                raise ValueError(f"stretch[{number}].from_m: lies within the {one.blend:g} m of blend_m before it")
        films = any(one.clean for one in self.stretches)
        if films != (self.memory != "none"):
            raise ValueError(
                "a film is cleaned when a stretch names its clean set and memory says by whom (\"own\" or \"rail\"); "
                "give both or neither"
            )
        return self

    @property
    def reduces(self):
        """Whether some stretch has reductions that only Polach's law knows."""
        grips = np.concatenate([np.concatenate([one.grips(), one.cleaned()]) for one in self.stretches])
        return bool((grips[:, [Grip.ADHESION, Grip.SLIP]] < 1.0).any())


class Resistance(Description):
    """Running resistance A + B V + C V^2 on the first body."""

    a: Annotated[NotNegative, Field(le=1e6)] = Field(0.0, alias="a_N")
    b: Annotated[NotNegative, Field(le=1e6)] = Field(0.0, alias="b_Ns_per_m")
    c: Annotated[NotNegative, Field(le=1e6)] = Field(0.0, alias="c_Ns2_per_m2")
