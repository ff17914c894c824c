"""The comparison of the contact with closed forms, with CONTACT and with the Manchester contact benchmark."""

import math
from dataclasses import dataclass

import numpy as np

from railcli.kernels import hertz, kalker
from railcli.kernels.layout import new_data
from railcli.kernels.stages import Stage, repeat
from railcli.model.submodels import CREEP_LAWS

from .conicity_check import Row
from .contact_benchmark import Bench, States, benchmark_rows, delta_r_row, extremes, jump, poses, steady_states
from .normal_check import NormalStates, normal_rows, normal_states

POISSON = (0.0, 0.25, 0.5)  # columns of table E.3
STEEL = 0.28
SLENDER = 1e-7  # ratio of semi-axes at which the asymptotes must hold
TABLE_END = 0.1
COEFFICIENTS = ("C11", "C22", "C23", "C33")
LIMIT, SHEAR = 0.3 * 82e3, 82e9  # of the creep states [N, Pa]
PUBLISHED = ("CONTACT", "converged FASTSIM")  # full solution; independent of railcli's FASTSIM
NO_SLIP, FULL_SLIP = 1e-3, 200.0  # creepage over that at which the linear force reaches the friction limit
SATURATED = 0.99  # of the friction limit, from which a reference state counts as full slip
FINE_Y = np.arange(0, 101) * 0.1e-3  # of the benchmark, between the reference states [m]
DIRECTIONS = np.radians(np.arange(0.0, 360.0, 30.0))


@dataclass(frozen=True)
class HertzCases:
    """Contacts of two bodies with closed solutions; arrays (n,).

    Attributes
    ----------
    names : list of str
    along, across : arrays
        Curvatures A, B of the gap A x^2 + B y^2 [1/m].
    normal, young, poisson : arrays
        [N], [Pa], [-]
    expected : array (n, 4)
        Semi-axes along and across [m], greatest pressure [Pa], approach [m].
    """

    names: list
    along: np.ndarray
    across: np.ndarray
    normal: np.ndarray
    young: np.ndarray
    poisson: np.ndarray
    expected: np.ndarray


@dataclass(frozen=True)
class CreepStates:
    """Steady rolling of an ellipse: slip of rail over wheel and force on the rail, for which the laws read the same.

    Attributes
    ----------
    a, b : array (n,)
        Semi-axes [m].
    slip : array (n, 3)
        xi, eta [-], phi [1/m].
    contact, fastsim : array (n, 3)
        Full solution and converged FASTSIM: forces over the friction limit, moment over that and sqrt(a b).
    """

    a: np.ndarray
    b: np.ndarray
    slip: np.ndarray
    contact: np.ndarray
    fastsim: np.ndarray

    @property
    def ellipses(self):
        """Semi-axes of the ellipses that occur, each once."""
        return sorted(set(zip(self.a.tolist(), self.b.tolist(), strict=True)))

    @property
    def groups(self):
        """Name -> bool array (n,): by spin, spin alone, full slip, all."""
        spin = np.abs(self.slip[:, 2])
        names = ("no spin", "light spin", "medium spin", "heavy spin")
        found = {name: spin == value for name, value in zip(names, np.unique(spin), strict=True)}
        found["spin alone"] = (spin > 0.0) & ~self.slip[:, :2].any(axis=1)
        found["full slip"] = np.hypot(*self.contact[:, :2].T) > SATURATED
        found["all"] = np.ones(spin.size, dtype=bool)
        return found


@dataclass(frozen=True)
class LawFound:
    """What one creep law gives on the creep states.

    Attributes
    ----------
    forces : array (n, 3)
        As `CreepStates.contact`.
    distances : dict
        (group, one of PUBLISHED) -> mean and largest distance of the force vectors over the friction limit.
    limits : dict
        "no slip", "full slip", "direction", "pure spin", "bound" -> largest error over the friction limit; of "no slip"
        over the linear force.
    """

    forces: np.ndarray
    distances: dict
    limits: dict


@dataclass(frozen=True)
class Outcome:
    """Everything that `railcli validate contact` reports.

    Attributes
    ----------
    rows : list of Row
        Every criterion.
    hertz : array (n, 4)
        Relative errors, as `HertzCases.expected`.
    kalker : dict
        Name of a comparison -> largest relative deviation of each coefficient.
    creep_states : CreepStates
    laws : dict
        Creep law -> LawFound.
    reference : States
    states : dict
        (normal law, creep law) -> States at the reference's positions.
    fine : dict
        Normal law -> States at FINE_Y, with the first creep law.
    jumps : dict
        (normal law, creep law) -> lateral positions [m].
    extremes : dict
        (normal law, creep law) -> quantity -> lowest and highest deviation, as `contact_benchmark.extremes`.
    known : dict
        Quantity -> the same of other fast methods.
    normal_reference : NormalStates
        By elements.
    normal : dict
        Normal law -> its `NormalStates.values`.
    held : list of str
        Normal laws for which the criteria of these states count.
    """

    rows: list
    hertz: np.ndarray
    kalker: dict
    creep_states: CreepStates
    laws: dict
    reference: States
    states: dict
    fine: dict
    jumps: dict
    extremes: dict
    known: dict
    normal_reference: NormalStates
    normal: dict
    held: list

    @property
    def accepted(self):
        return all(row.kept for row in self.rows if row.counts)


def hertz_errors(cases):
    """Relative errors (n, 4) of the kernel against closed forms."""
    found = []
    for along, across, normal, young, poisson in zip(
        cases.along, cases.across, cases.normal, cases.young, cases.poisson, strict=True
    ):
        ca, cb, k = hertz.ellipse(along, across, young, poisson)
        a, b = ca * math.cbrt(normal), cb * math.cbrt(normal)
        found.append((a, b, hertz.pressure(normal, a, b), (normal / k) ** (2.0 / 3.0)))
    return np.array(found) / cases.expected - 1.0


def asymptotes(g, long, poisson):
    """Kalker's (1990) C11, C22, C23 of slender ellipses of axes ratio g < 1; `long` in the rolling direction."""
    slender = math.log(16.0 / g**2)
    if not long:
        spin = 1.0 + poisson * (0.5 * slender + math.log(4.0) - 5.0)
        return (
            math.pi**2 / (4.0 * (1.0 - poisson)), math.pi**2 / 4.0,
            math.pi * math.sqrt(g) / (3.0 * (1.0 - poisson)) * spin,
        )  # fmt: skip
    bulge, along = 3.0 - math.log(4.0), slender - 2.0 * poisson
    across = (1.0 - poisson) * slender + 2.0 * poisson
    return (
        2.0 * math.pi / (g * along) * (1.0 + bulge / along),
        2.0 * math.pi / (g * across) * (1.0 + (1.0 - poisson) * bulge / across),
        2.0 * math.pi / (3.0 * g**1.5) / ((1.0 - poisson) * slender - 2.0 + 4.0 * poisson),
    )


def kalker_errors(table):
    """Largest relative deviations of the coefficients.

    Parameters
    ----------
    table : array (n, 13)
        a / b, then C11, C22, C23, C33, each for POISSON.

    Returns
    -------
    dict
        Name of the comparison -> one number per coefficient.
    """
    found = {}
    nodes = np.array([[kalker.coefficients(row[0], poisson) for poisson in POISSON] for row in table])
    printed = table[:, 1:].reshape(-1, 4, 3).transpose(0, 2, 1)
    found["table E.3"] = np.abs(nodes / printed - 1.0).max(axis=(0, 1))
    for name, g in (("slender limits", SLENDER), ("asymptotes at the table's ends", TABLE_END)):
        errors = []
        for poisson in (*POISSON, STEEL):
            for long in (False, True):
                ours = kalker.coefficients(1.0 / g if long else g, poisson)[:3]
                errors.append(np.array(ours) / asymptotes(g, long, poisson) - 1.0)
        found[name] = np.abs(errors).max(axis=0)
    return found


class Patch:
    """One level contact patch under the compiled creep stage of a model: whatever law the model has.

    Parameters
    ----------
    model : Model
    a, b : float
        Semi-axes along the rail and across [m].
    """

    def __init__(self, model, a, b):
        self._model, self._data = model, new_data(model, np.zeros((1, 6)), 0)
        self._scale = LIMIT * np.array([1.0, 1.0, math.sqrt(a * b)])
        self._data.frame["cosine"] = 1.0
        self._data.rail[0]["patches"] = 1
        self._contact = contact = self._data.contact[0, 0]
        contact["normal"], contact["semi_x"], contact["semi_y"] = LIMIT / model.wheel[0]["friction"], a, b
        contact["f11"], contact["f22"], contact["f23"], contact["f33"] = kalker.stiffness(a, b, SHEAR, STEEL)

    def force(self, slip):
        """Creep force along x and across over LIMIT, spin moment over LIMIT sqrt(a b), for xi, eta [-] and phi [1/m].

        The wheelset moves at 1 m/s; what it does not move along the rail or across, it moves along the normal.
        """
        xi, eta, phi = slip
        self._data.v[0] = xi, eta, math.sqrt(1.0 - xi * xi - eta * eta), 0.0, 0.0, phi
        repeat(self._model, self._data, Stage.CREEP.value, 1)
        way = 1.0 if xi >= 0.0 else -1.0  # x and t turn with the direction of running
        found = way * self._contact["creep_x"], way * self._contact["creep_t"], self._contact["spin_moment"]
        return np.array(found) / self._scale


def examine(model, states):
    """One creep law on the creep states and in its limits.

    Parameters
    ----------
    model : Model
        With this law.
    states : CreepStates

    Returns
    -------
    LawFound
    """
    patches = {axes: Patch(model, *axes) for axes in states.ellipses}
    rows = zip(states.a, states.b, states.slip, strict=True)
    forces = np.array([patches[a, b].force(slip) for a, b, slip in rows])
    distances = {}
    for name, chosen in states.groups.items():
        for other, expected in zip(PUBLISHED, (states.contact, states.fastsim), strict=True):
            apart = np.hypot(*(forces - expected)[chosen, :2].T)
            distances[name, other] = float(apart.mean()), float(apart.max())
    limits = [patch_limits(patch, *axes) for axes, patch in patches.items()]
    limits = {key: max(item[key] for item in limits) for key in limits[0]}
    limits["pure spin"] = float(np.abs(forces[states.groups["spin alone"], 0]).max())
    limits["bound"] = max(float(np.hypot(*forces[:, :2].T).max()) - 1.0, limits["bound"])
    return LawFound(forces, distances, limits)


def patch_limits(patch, a, b):
    """Errors in the limits of vanishing and of full slip on the ellipse of a Patch."""
    f11, f22, f23, _ = kalker.stiffness(a, b, SHEAR, STEEL)
    unit = np.array([LIMIT / f11, LIMIT / f22])
    small, large, turned = [], [], []
    for way in DIRECTIONS:
        way = np.array([math.cos(way), math.sin(way)])
        force = patch.force((*(NO_SLIP * unit * way), 0.0))[:2]
        small.append(np.hypot(*(force / NO_SLIP + way)))
        force = patch.force((*(FULL_SLIP * unit.mean() * way), 0.0))[:2]
        large.append(np.hypot(*force))
        turned.append(np.hypot(*(force + way)))
    force = patch.force((0.0, 0.0, NO_SLIP * LIMIT / f23))
    small.append(abs(force[1] / NO_SLIP + 1.0))
    return {
        "no slip": float(max(small)),
        "full slip": float(np.abs(np.array(large) - 1.0).max()),
        "direction": float(max(turned)),
        "bound": float(max(large)) - 1.0,
    }


def law_settings(criteria):
    """Every creep law of the registry, and variants that the criteria name: name -> fields of a scenario's contact."""
    found = {law: {"creep_law": law} for law in CREEP_LAWS}
    variants = criteria.get("variants", {})
    return found | {name: contact for name, contact in variants.items() if contact["creep_law"] in CREEP_LAWS}


def creep_rows(name, laws, criteria, shown=()):
    """Criteria of one creep law among all that were examined.

    Parameters
    ----------
    name : str
    laws : dict
        Name -> LawFound.
    criteria : dict
        Group "creep" of accept.toml.
    shown : sequence of str
        Criteria that do not count for this law.

    Returns
    -------
    list of Row
    """
    found = laws[name]
    texts = {
        "no_slip": "force without slip, from the linear one",
        "full_slip": "force in full slip without spin, from mu N",
        "bound": "largest force over mu N, less 1",
        "pure_spin": "longitudinal force under spin alone",
    }
    rows = [
        Row(f"{name}: {text}", found.limits[key.replace("_", " ")], criteria[key], key not in shown)
        for key, text in texts.items()
    ]
    for own in criteria["distances"]:
        if own["law"] == name:
            other = own["from"]
            distance = found.distances["all", other] if other in PUBLISHED else _apart(found, laws[other])
            for value, size in zip(distance, ("mean", "max"), strict=True):
                if size in own:
                    rows.append(Row(f"{name}: distance from {other}, {size}", value, own[size]))
    return rows


def _apart(found, other):
    """Mean and largest distance of the force vectors of two laws over the friction limit."""
    apart = np.hypot(*(found.forces - other.forces)[:, :2].T)
    return float(apart.mean()), float(apart.max())


@dataclass(frozen=True)
class Published:
    """What is compared with.

    Attributes
    ----------
    hertz : HertzCases
    kalker : array (n, 13)
        Table E.3: a / b, then C11, C22, C23, C33, each for POISSON.
    creep : CreepStates
    benchmark : States
    normal : NormalStates
    """

    hertz: HertzCases
    kalker: np.ndarray
    creep: CreepStates
    benchmark: States
    normal: NormalStates


def compare_contact(published, criteria, pair, tables, progress=None):
    """Compare Hertz, Kalker, every creep law, every combination of laws on the benchmark, and every normal law.

    Parameters
    ----------
    published : Published
    criteria : dict
        Groups of accept.toml.
    pair : Wheelset
        Of the benchmark.
    tables : dict
        Normal law -> ContactTable of the benchmark's wheels.
    progress : callable, optional
        Called with the share done, 0 ... 1, and a sentence.

    Returns
    -------
    Outcome
    """
    progress = progress or (lambda share, text: None)
    errors, coefficients = hertz_errors(published.hertz), kalker_errors(published.kalker)
    rows = [Row("Hertz: ellipse, pressure and approach", float(np.abs(errors).max()), criteria["hertz"]["relative"])]
    rows += [
        Row(f"Kalker: {name}", float(coefficients[name].max()), criteria["kalker"][key])
        for name, key in zip(coefficients, ("table", "limits", "ends"), strict=True)
    ]
    laws, any_table = {}, next(iter(tables.values()))
    chosen = law_settings(criteria["creep"])
    for number, (name, contact) in enumerate(chosen.items()):
        progress(0.4 * number / len(chosen), f"creep law {name}")
        laws[name] = examine(Bench(pair, any_table, **contact).model, published.creep)
    for name in laws:
        rows += creep_rows(name, laws, criteria["creep"], criteria["shown"].get(name, ()))
    reference, limits = published.benchmark, criteria["benchmark"]
    at, between = poses(pair, reference.y), poses(pair, FINE_Y)
    states, fine, jumps = {}, {}, {}
    combinations = [(normal, law) for normal in tables for law in CREEP_LAWS]
    for number, (normal, law) in enumerate(combinations):
        progress(0.4 + 0.5 * number / len(combinations), f"benchmark, {normal} and {law}")
        bench = Bench(pair, tables[normal], creep_law=law)
        found = states[normal, law] = steady_states(bench, at)
        places = jumps[normal, law] = [jump(bench, pair, *sought) for sought in 1e-3 * np.array(limits["sought_mm"])]
        if normal not in fine:
            fine[normal] = steady_states(bench, between)
        shown = criteria["shown"].get(law, ())
        rows += benchmark_rows(f"A-2.2, {normal} and {law}", found, reference, places, limits, shown)
    normal = {}
    for law, table in tables.items():
        progress(0.9, f"normal law {law} against elements")
        normal[law] = normal_states(pair, table, published.normal)
        rows += normal_rows(law, normal[law], published.normal, criteria["normal"])
        first = next(found for key, found in states.items() if key[0] == law)
        held = law in criteria["normal"]["held"]
        rows.append(delta_r_row(f"normal law {law}", first, reference, criteria["normal"], held))
    progress(1.0, "")
    ends = {key: extremes(found, reference, limits["spread"]) for key, found in states.items()}
    return Outcome(
        rows, errors, coefficients, published.creep, laws, reference, states, fine, jumps, ends,
        limits["spread"]["known"], published.normal, normal, criteria["normal"]["held"],
    )  # fmt: skip
