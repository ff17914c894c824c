"""Force elements and the joints that hold them: what acts between two bodies.

Points: x forward, y to the right, height above the rail tops [m].
"""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from .air import AirSpring
from .checks import NONE, Coefficient, CoefficientVector, Description, Flag, Name, Point, hint
from .element_parts import MIRRORS, AtPoint, Mirror, mirrored_apart
from .friction_elements import Friction, LeafSpring
from .moments import Matrix, Torque
from .tables import DamperTable, SpringTable


class Bushing(AtPoint):
    """Springs and dampers along the joint's three axes, both ends at one point in the nominal geometry."""

    stiffness: CoefficientVector = Field(NONE, alias="stiffness_N_per_m")
    damping: CoefficientVector = Field(NONE, alias="damping_Ns_per_m")
    turn_stiffness: CoefficientVector = Field(NONE, alias="turn_stiffness_Nm_per_rad")
    spring_table_x: SpringTable | None = None
    spring_table_y: SpringTable | None = None
    spring_table_z: SpringTable | None = None
    damper_table_x: DamperTable | None = None
    damper_table_y: DamperTable | None = None
    damper_table_z: DamperTable | None = None
    carries_weight: Flag = False
    preload: Coefficient = Field(0.0, alias="preload_N")  # vertical load at rest, given instead of its share of weight

    @property
    def spring_tables(self):
        return self.spring_table_x, self.spring_table_y, self.spring_table_z

    @property
    def damper_tables(self):
        return self.damper_table_x, self.damper_table_y, self.damper_table_z

    @model_validator(mode="after")
    def _mirrors(self):
        for letter, damping, table in zip("xyz", self.damping, self.damper_tables, strict=True):
            if damping > 0.0 and table is not None:
                raise ValueError(f"give either damping_Ns_per_m along {letter} or damper_table_{letter}, not both")
        if self.carries_weight and self.preload > 0.0:
            raise ValueError("give either carries_weight = true or preload_N, the load that it carries at rest")
        return mirrored_apart(self)


class Link(Description):
    """A spring, a damper or both along the line between two points."""

    name: Name
    lower: Point = Field(alias="lower_m")
    upper: Point = Field(alias="upper_m")
    mirror: Mirror = "none"
    stiffness: Coefficient = Field(0.0, alias="stiffness_N_per_m")
    damping: Coefficient = Field(0.0, alias="damping_Ns_per_m")
    damper_table: DamperTable | None = None
    series_stiffness: Coefficient = Field(0.0, alias="series_stiffness_N_per_m")  # of the damper; 0: rigid

    @property
    def ends(self):
        return self.lower, self.upper

    @property
    def signs(self):
        return MIRRORS[self.mirror]

    @property
    def length(self):
        """Distance of the ends in the nominal geometry [m]."""
        return float(np.linalg.norm(np.subtract(self.upper, self.lower)))

    @model_validator(mode="after")
    def _acts(self):
        damps = self.damping > 0.0 or self.damper_table is not None
        if self.length == 0.0:
            raise ValueError("lower_m and upper_m are the same point; use a bushing there")
        if self.damping > 0.0 and self.damper_table is not None:
            raise ValueError("give either damping_Ns_per_m or damper_table, not both")
        if not (damps or self.stiffness > 0.0):
            raise ValueError("does nothing; give stiffness_N_per_m, damping_Ns_per_m or damper_table")
        if self.series_stiffness > 0.0 and not damps:
            raise ValueError("series_stiffness_N_per_m needs damping_Ns_per_m or damper_table")
        return mirrored_apart(self)


class Joint(Description):
    """All that acts between two bodies, repeated for every pair.

    Points of its elements count from the lower body of the pair: x from its centre, y from the vehicle's middle,
    height from the rail tops.
    """

    name: Name
    pairs: Annotated[tuple[tuple[Name, Name], ...], Field(min_length=1)]  # (lower, upper)
    axes: Literal["mean", "upper"] = "mean"
    turn_stiffness: CoefficientVector = Field(NONE, alias="turn_stiffness_Nm_per_rad")
    bushings: tuple[Bushing, ...] = Field((), alias="bushing")
    links: tuple[Link, ...] = Field((), alias="link")
    frictions: tuple[Friction, ...] = Field((), alias="friction")
    leaf_springs: tuple[LeafSpring, ...] = Field((), alias="leaf_spring")
    matrices: tuple[Matrix, ...] = Field((), alias="matrix")
    air_springs: tuple[AirSpring, ...] = Field((), alias="air_spring")
    torques: tuple[Torque, ...] = Field((), alias="torque")

    @property
    def lists(self):
        """Its elements by the key of a file; what carries a load stands before the friction that feels it."""
        return {
            "bushing": self.bushings,
            "link": self.links,
            "friction": self.frictions,
            "leaf_spring": self.leaf_springs,
            "matrix": self.matrices,
            "air_spring": self.air_springs,
            "torque": self.torques,
        }

    @property
    def elements(self):
        """All of them."""
        return tuple(element for each in self.lists.values() for element in each)

    @model_validator(mode="after")
    def _friction_feels_its_load(self):
        names = [bushing.name for bushing in self.bushings]
        for f, friction in enumerate(self.frictions, start=1):
            if friction.load_of is None:
                continue
            where = f"friction[{f}].load_of"
            if names.count(friction.load_of) != 1:
                found = "several bushings are" if friction.load_of in names else "no bushing of this joint is"
                raise ValueError(f"{where}: {found} named {friction.load_of!r}; {hint(friction.load_of, names)}")
            source = self.bushings[names.index(friction.load_of)]
            if source.mirror not in ("none", friction.mirror):
                raise ValueError(
                    f"{where}: {source.name!r} has mirror = {source.mirror!r}, {friction.name!r} {friction.mirror!r}; "
                    "each must stand beside the one whose load it feels"
                )
        return self

    @property
    def total_turn_stiffness(self):
        """Of the joint and its bushings about x, y, z [N m/rad]."""
        total = np.array(self.turn_stiffness)
        for bushing in self.bushings:
            total += len(bushing.signs) * np.array(bushing.turn_stiffness)
        return total
