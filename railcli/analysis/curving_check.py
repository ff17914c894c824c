"""Steady curving of the Manchester wagon at R = 150 m beside two other programs (docs/validation.md)."""

from dataclasses import dataclass

import numpy as np

from railcli.errors import SimulationError
from railcli.model.submodels import CREEP_LAWS, NORMAL_LAWS
from railcli.model.system import assemble

from .conicity_check import Row
from .equilibrium import steady
from .steady_values import expected_forces, final_stretch

NOMINAL = "nominal"
UPPER_END = "secondary springs act at 1.13 m"
KINDS = {"y": "mm", "X": "kN", "Y": "kN", "Q": "kN"}
SIDES = ("outer", "inner")
FRICTIONS = (0.38, 0.39, 0.41, 0.42)
INCLINATIONS = (20.0, 30.0)
GAUGES = (1.435, 1.436, 1.438)  # [m]
UPPER_HEIGHT = 1.13  # upper end of the secondary springs [m]
SPRING = "secondary spring"


@dataclass(frozen=True)
class Codes:
    """What two other programs print.

    Attributes
    ----------
    names : tuple of str
        Of the programs.
    quantity : tuple of str
        Of each value: y towards the outer rail [mm]; on the outer and the inner wheel [kN] X forwards on the wheel,
        Y outwards and Q down on the rail.
    wheelset : tuple of int
        Of each value, from 1.
    values : array (n, 2)
        NaN where there is none.
    """

    names: tuple
    quantity: tuple
    wheelset: tuple
    values: np.ndarray

    def of(self, kind):
        """Mask of the values of one of KINDS."""
        return np.array([name[0] == kind for name in self.quantity])

    def spread(self, kind):
        """Largest difference of the programs in one of KINDS."""
        return float(np.nanmax(np.abs(np.diff(self.values[self.of(kind)], axis=1))))

    def place(self, quantity, wheelset):
        return list(zip(self.quantity, self.wheelset, strict=True)).index((quantity, wheelset))


@dataclass(frozen=True)
class Curve:
    """Steady curving under one set of assumptions.

    Attributes
    ----------
    scenario : Scenario
    values : array (n,)
        As `Codes.values`; NaN where the model has no such motion.
    sum_y, sum_q : pair of float
        Found and expected: outwards, and normal to the track [kN].
    """

    scenario: object
    values: np.ndarray
    sum_y: tuple
    sum_q: tuple

    def deviations(self, codes):
        """Differences from the programs (n, 2)."""
        return self.values[:, None] - codes.values

    def nearest(self, codes, kind):
        """Largest distance of a value from the nearer program; NaN where the model has no such motion."""
        if not self.exists:
            return np.nan
        return float(np.nanmin(np.abs(self.deviations(codes)[codes.of(kind)]), axis=1).max())

    @property
    def exists(self):
        return bool(np.isfinite(self.values).all())

    @property
    def balance_error(self):
        """Larger error of both sums [kN]."""
        return max(abs(found - expected) for found, expected in (self.sum_y, self.sum_q))


def curving(scenario, tables, codes):
    """Steady curving in the scenario's last curve by Newton's method.

    Returns
    -------
    Curve
    """
    stretch, system = final_stretch(scenario), assemble(scenario, tables)
    expected = [1e-3 * force for force in expected_forces(scenario, stretch)]
    try:
        data = steady(system, stretch.curvature, stretch.cant, scenario.run.speed).data
    except SimulationError:
        return Curve(scenario, np.full(len(codes.quantity), np.nan), *((np.nan, force) for force in expected))
    rail = data.rail.reshape(-1, 2)[:, :: int(stretch.outer_side)]
    found = {"y": 1e3 * stretch.outwards * data.q[list(system.wheelsets), 1]}
    for k, side in enumerate(SIDES):
        found[f"X {side}"] = -1e-3 * rail["x"][:, k]
        found[f"Y {side}"] = 1e-3 * stretch.outwards * rail["y"][:, k]
        found[f"Q {side}"] = 1e-3 * rail["q"][:, k]
    values = [found[name][i - 1] for name, i in zip(codes.quantity, codes.wheelset, strict=True)]
    sums = (sum(found[f"{kind} {side}"].sum() for side in SIDES) for kind in "YQ")
    return Curve(scenario, np.array(values), *zip(sums, expected, strict=True))


def variations(scenario):
    """Name -> the scenario with one input changed that the table does not define; `NOMINAL` is the scenario itself.

    Those that share contact tables follow one another.
    """
    own = scenario.contact
    found = {
        NOMINAL: scenario,
        UPPER_END: scenario.varied(vehicle=sprung_at(scenario.vehicle, SPRING, UPPER_HEIGHT)),
    }
    found |= {f"friction {mu:.2f}": scenario.varied(contact={"friction": mu}) for mu in FRICTIONS}
    found |= {f"creep law {law}": scenario.varied(contact={"creep_law": law}) for law in CREEP_LAWS}
    del found[f"creep law {own.creep_law}"]
    others = [("gauge", gauge, f"gauge {gauge * 1e3:g} mm") for gauge in GAUGES]
    others += [("inclination", value, f"inclination 1:{value:g}") for value in INCLINATIONS]
    others += [("normal", law, f"normal law {law}") for law in NORMAL_LAWS]
    found |= {name: scenario.varied(contact={key: value}) for key, value, name in others if getattr(own, key) != value}
    return found


def sprung_at(vehicle, name, height):
    """The vehicle with its bushings of a name acting at another height [m]."""
    joints = [
        joint.model_copy(update={"bushings": tuple(_moved(bushing, name, height) for bushing in joint.bushings)})
        for joint in vehicle.joints
    ]
    return vehicle.model_copy(update={"joints": tuple(joints)})


def _moved(bushing, name, height):
    return bushing.model_copy(update={"at": (*bushing.at[:2], height)}) if bushing.name == name else bushing


def compare_curve(codes, scenario, tables_of, progress):
    """Steady curving under every variation.

    Parameters
    ----------
    codes : Codes
    scenario : Scenario
        The nominal one; it ends in the curve.
    tables_of : callable
        Contact tables of a scenario.
    progress : callable
        Called with the share done and a sentence.

    Returns
    -------
    dict of str to Curve
    """
    cases, found = variations(scenario), {}
    for number, (name, case) in enumerate(cases.items()):
        progress(number / len(cases), f"R = {case.track.sections[-1].radius:g} m, {name}")
        found[name] = curving(case, tables_of(case), codes)
    return found


def judge(criteria, codes, curves):
    """Criteria as `Row`s.

    A value is inside the spread when it lies no further from the nearer program than the programs lie apart at most in
    its kind, by the rounding of the print.
    """
    nominal, rounding = curves[NOMINAL], criteria["rounding"]
    rows = []
    for kind, unit in KINDS.items():
        limit = codes.spread(kind) + rounding
        defined = kind not in criteria["undefined"]
        rows.append(Row(f"R 150 m: {kind} from the nearer code [{unit}]", nominal.nearest(codes, kind), limit, defined))
        if not defined:
            name = f"R 150 m: {kind} from the nearer code, {UPPER_END} [{unit}]"
            rows.append(Row(name, curves[UPPER_END].nearest(codes, kind), limit))
    rows.append(Row("R 150 m: sums of Y and Q from their balance [kN]", nominal.balance_error, criteria["balance_kN"]))
    return rows
