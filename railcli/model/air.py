"""Air spring: a bellows and a reservoir joined by an orifice (theory.md section 5.12)."""

from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from .checks import Coefficient, Positive, Real
from .element_parts import AtPoint, mirrored_apart
from .tables import DamperTable

_Pair = tuple[Coefficient, Coefficient]


class Stiffness(NamedTuple):
    """Vertical stiffness of an air spring about its static load [N/m]."""

    area: float  # change of its effective area at constant pressure
    bellows: float  # compression of the air in the bellows
    reservoir: float  # of that in the reservoir, as felt at the bellows


class AirSpring(AtPoint):
    """Carries weight by the pressure of air; along x and y a spring and a damper."""

    area: Annotated[Positive, Field(le=10.0)] = Field(alias="area_m2")  # effective: load over gauge pressure
    area_change: Annotated[Real, Field(ge=-100.0, le=100.0)] = Field(0.0, alias="area_change_m2_per_m")  # per way down
    volume: Annotated[Positive, Field(le=10.0)] = Field(alias="volume_m3")  # of the bellows at nominal height
    reservoir: Annotated[Positive, Field(le=100.0)] = Field(alias="reservoir_volume_m3")
    polytropic: Annotated[Real, Field(ge=1.0, le=1.4)] = 1.4  # exponent n of p V^n: 1 slow, 1.4 fast
    ambient: Annotated[Positive, Field(le=1e7)] = Field(101325.0, alias="ambient_pressure_Pa")
    orifice_damping: Coefficient = Field(0.0, alias="orifice_damping_Ns_per_m")  # (p_b - p_r) area over flow / area
    orifice_table: DamperTable | None = None
    shear_stiffness: _Pair = Field((0.0, 0.0), alias="shear_stiffness_N_per_m")  # x, y
    shear_damping: _Pair = Field((0.0, 0.0), alias="shear_damping_Ns_per_m")
    carries_weight: ClassVar[bool] = True

    def stiffness(self, load):
        """Vertical stiffness under a static load [N], a Stiffness.

        With gauge pressure p_g = load / A and p = p_g + p_a, polytropic change of state and small motion:
        area p_g dA/dz, bellows n p A^2 / V_b, reservoir n p A^2 / V_r.
        """
        gauge = load / self.area
        air = self.polytropic * (gauge + self.ambient) * self.area**2
        return Stiffness(gauge * self.area_change, air / self.volume, air / self.reservoir)

    @model_validator(mode="after")
    def _has_an_orifice(self):
        if (self.orifice_damping > 0.0) == (self.orifice_table is not None):
            raise ValueError("give either orifice_damping_Ns_per_m or orifice_table")
        if self.orifice_table and np.any(np.diff(self.orifice_table.force) <= 0.0):
            raise ValueError("force of orifice_table must increase strictly")
        return mirrored_apart(self)
