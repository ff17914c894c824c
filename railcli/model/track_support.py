"""What bears the rails: nothing that gives way, or springs and dampers under each wheel (docs/theory.md 6.6)."""

from typing import Annotated, NamedTuple

from pydantic import Field, model_validator

from .checks import Description, Real, one_of

RAIL_BENDING = 6.42e6, 1.08e6  # E I of 60E1 against vertical and lateral bending, E = 210 GPa (EN 13674-1) [N m^2]
SEAT_SPACING = 0.6  # [m]
RIGID, OWN = "rigid", "own"


class Seat(NamedTuple):
    """Support of one rail at one seat, all layers in series: stiffness [N/m] and damping [N s/m], vertical, lateral."""

    vertical: tuple
    lateral: tuple
    what: str


SETS = {  # assumed: seats of usual size, not those of a measured track
    "ballasted-stiff": Seat((60e6, 50e3), (20e6, 30e3), "hard pads, firm ballast and ground"),
    "ballasted-soft": Seat((15e6, 30e3), (10e6, 20e3), "soft pads, loose ballast or weak ground"),
    "slab": Seat((22.5e6, 10e3), (15e6, 10e3), "elastic fastenings on concrete"),
}
KINDS = {RIGID: None, **SETS, OWN: None}

_Stiffness = Annotated[Real, Field(ge=1e6, le=1e10)]
_Damping = Annotated[Real, Field(ge=1e3, le=1e8)]


def under_a_wheel(bending, stiffness, damping):
    """Stiffness [N/m] and damping [N s/m] of a rail under a load that travels slowly.

    An endless beam on a bed of k = stiffness / SEAT_SPACING gives way by F / K, K = 2 sqrt(2) (E I)^(1/4) k^(3/4)
    (Winkler, Zimmermann; Hetenyi 1946). With k + i w c in the place of k it is damped by 3 K c / (4 k) at low
    frequencies w.
    """
    found = 2.0 * 2.0**0.5 * bending**0.25 * (stiffness / SEAT_SPACING) ** 0.75
    return found, 0.75 * found * damping / stiffness


class TrackSupport(Description):
    """Springs and dampers under each rail where a wheel stands; values that are not given are those of the kind."""

    kind: one_of(KINDS) = RIGID
    vertical_stiffness: _Stiffness | None = Field(None, alias="vertical_stiffness_N_per_m")
    vertical_damping: _Damping | None = Field(None, alias="vertical_damping_Ns_per_m")
    lateral_stiffness: _Stiffness | None = Field(None, alias="lateral_stiffness_N_per_m")
    lateral_damping: _Damping | None = Field(None, alias="lateral_damping_Ns_per_m")

    @model_validator(mode="after")
    def _fits_together(self):
        given = [name for name in OF_A_RAIL if getattr(self, name) is not None]
        if self.kind == RIGID and given:
            known = " or ".join(map(repr, (OWN, *SETS)))
            raise ValueError(f"{given[0]} belongs to a track that gives way; give kind = {known}")
        if self.kind == OWN and len(given) < len(OF_A_RAIL):
            missing = [name for name in OF_A_RAIL if name not in given]
            raise ValueError(f"kind {OWN!r} needs {' and '.join(missing)} as well")
        return self

    @property
    def gives_way(self):
        return self.kind != RIGID

    def packed(self):
        """Stiffness [N/m] and damping [N s/m] of a rail, each lateral and vertical; zeros when it is rigid."""
        if not self.gives_way:
            return (0.0, 0.0), (0.0, 0.0)
        own = {name: getattr(self, name) for name in OF_A_RAIL}
        if self.kind in SETS:
            for direction, bending in zip(("vertical", "lateral"), RAIL_BENDING, strict=True):
                found = under_a_wheel(bending, *getattr(SETS[self.kind], direction))
                for name, value in zip((f"{direction}_stiffness", f"{direction}_damping"), found, strict=True):
                    own[name] = value if own[name] is None else own[name]
        return (
            (own["lateral_stiffness"], own["vertical_stiffness"]),
            (own["lateral_damping"], own["vertical_damping"]),
        )


OF_A_RAIL = ("vertical_stiffness", "vertical_damping", "lateral_stiffness", "lateral_damping")
