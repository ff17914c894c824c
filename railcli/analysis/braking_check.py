"""The comparison of `railcli validate braking`: closed forms, published tables, and the whole wagon beside them."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from railcli.errors import SimulationError
from railcli.kernels.longitudinal import rolling_force
from railcli.model import braked_weight
from railcli.model.submodels import ADHESION_SETS
from railcli.model.system import assemble

from .conicity_check import Row
from .equilibrium import static
from .ledger import ledger
from .longitudinal import Patch, stop
from .simulate import simulate
from .step_choice import with_step

PATCH = Patch(6e-3, 4.5e-3, 82.03e9, 4.5)  # of the published table
LOAD = 54546.05  # of each wheel: a quarter of the wagon's weight on an axle [N]
STEADY = (15.0, 35.0)  # time of a stop from 160 km/h within which brake and deceleration stand still [s]
DECELERATION = 1.0  # that the brake of the cases gives without slip [m/s^2]
DRY, LOW, IN_CURVE = "brake-dry", "brake-low", "brake-curve"
LOADED = 1e3  # normal force above which a patch counts [N]
RIGID = {"friction": 1.0}  # adhesion at which nothing slips to speak of


class Stopped(NamedTuple):
    """What the published table says of a case; NaN where it says nothing."""

    distance: float  # [m]
    time: float  # [s]
    tolerance: float  # share of the distance
    locks_at: float  # [s]
    locks_speed: float  # [m/s]
    creep: float  # share of the kinetic energy
    brake: float
    vents: float


class References(NamedTuple):
    """Published values."""

    stops: dict  # name of a scenario -> Stopped
    polach: list  # (speed, set, creepages, forces over load, peak, creepage of the peak)
    percentages: list  # (percentage, speed [m/s], distance [m], build-up [m] or NaN)


@dataclass(frozen=True)
class Wagon:
    """The whole three-dimensional wagon in one case."""

    distance: float
    time: float
    ledger: object
    vents: int
    locked: np.ndarray  # (n_axle,) [s]
    slide: np.ndarray  # (n_axle,) largest [-]


@dataclass
class Outcome:
    """Everything that `railcli validate braking` reports."""

    rows: list = field(default_factory=list)
    closed: list = field(default_factory=list)  # (name, found, expected)
    stops: dict = field(default_factory=dict)  # scenario -> (Stopped, longitudinal.Stop, Wagon)
    polach: list = field(default_factory=list)  # (speed, set, creepages, published, found)
    transfer: list = field(default_factory=list)  # (axle, with stiff rods, as it is, expected) [kN per m/s^2]
    deceleration: float = np.nan  # at which that was found [m/s^2]
    circle: tuple = ()  # in a curve: largest creep force over its circle; lateral places rolling, braking [m]
    percentages: list = field(default_factory=list)

    @property
    def accepted(self):
        return all(row.kept for row in self.rows if row.counts)


def compare_braking(references, criteria, scenarios, tables_of, progress=None):
    """Compare.

    Parameters
    ----------
    references : References
    criteria : dict
        Group -> name -> limit.
    scenarios : dict
        Name -> Scenario: those of references.stops, and IN_CURVE.
    tables_of : callable
        Contact tables of a scenario.
    progress : callable, optional
        Called with the share done and what comes.

    Returns
    -------
    Outcome
    """
    tell = progress or (lambda share, text: None)
    result = Outcome()
    tell(0.0, "closed forms")
    _closed_forms(result, criteria, scenarios[DRY])
    _polach(result, references, criteria)
    _braked_weight(result, references, criteria)
    for k, (name, published) in enumerate(references.stops.items()):
        tell(0.1 + 0.7 * k / len(references.stops), name)
        _stop(result, criteria, name, published, scenarios[name], tables_of)
    tell(0.8, "load transfer")
    _load_transfer(result, criteria, scenarios[DRY], tables_of(scenarios[DRY]))
    tell(0.9, "braking in a curve")
    _curve(result, criteria, scenarios[IN_CURVE], tables_of(scenarios[IN_CURVE]))
    tell(1.0, "")
    return result


def share_off(found, expected):
    return abs(found - expected) / abs(expected)


def _closed_forms(result, criteria, case):
    """Stops of constant friction on level track: s = V0 t + ... of each law of the brake's rise."""
    speed, a, limit = case.first_speed, DECELERATION, criteria["closed_form"]["share"]
    ramp = case.brake.apply
    stretch = {"stretches": ({"from_m": 0.0, **RIGID},)}
    wanted = {
        "instant": speed**2 / (2.0 * a),
        "linear": speed * ramp - a * ramp**2 / 6.0 + (speed - a * ramp / 2.0) ** 2 / (2.0 * a),
        "exponential": exponential_stop(speed, a, ramp / np.log(20.0)),
    }
    for name, expected in wanted.items():
        brake = {"apply": 0.0} if name == "instant" else {"rise": name}
        one = case.varied(brake=brake, adhesion=stretch)
        found = stop(one, PATCH, LOAD).distance
        result.closed.append((f"stop from {3.6 * speed:.0f} km/h, {name} rise", found, expected))
    late = case.varied(brake={"delay": 2.0}, adhesion=stretch)
    result.closed.append(
        ("linear rise 2 s late", stop(late, PATCH, LOAD).distance, wanted["linear"] + 2.0 * speed)
    )
    for name, found, expected in result.closed:
        result.rows.append(Row(f"{name}: distance, share off", share_off(found, expected), limit))


def exponential_stop(speed, a, tau):
    """Distance of a stop with a (1 - exp(-t / tau)) [m]."""
    end = brentq(lambda t: speed - a * (t - tau * (1.0 - np.exp(-t / tau))), 0.0, 2.0 * speed / a + 10.0 * tau)
    return speed * end - a * (end**2 / 2.0 - tau * end + tau**2 * (1.0 - np.exp(-end / tau)))


def force_over_load(name, speed, creepage):
    """Creep force over vertical force of the published patch, as the core has it."""
    grip = np.array(ADHESION_SETS[name].value)
    return rolling_force(grip, PATCH.packed(), LOAD, creepage * speed, speed)[0] / LOAD


def _polach(result, references, criteria):
    limit = criteria["polach"]["rounding"]
    for speed, name, creepages, published, peak, at in references.polach:
        found = np.array([force_over_load(name, speed, s) for s in creepages])
        best = minimize_scalar(
            lambda s, name=name, speed=speed: -force_over_load(name, speed, s), bounds=(0.2 * at, 3.0 * at),
            method="bounded", options={"xatol": 1e-7},
        )  # fmt: skip
        result.polach.append((speed, name, creepages, published, found))
        worst = max(np.abs(found - published).max(), abs(-best.fun - peak))
        result.rows.append(Row(f"creep force, {name} at {speed:g} m/s, largest difference", float(worst), limit))


def _braked_weight(result, references, criteria):
    worst = 0.0
    for percentage, speed, distance, build_up in references.percentages:
        found = braked_weight.deceleration(percentage).distance(speed)
        risen = braked_weight.build_up_time("passenger", 400.0) * speed
        result.percentages.append((percentage, speed, distance, found, build_up, risen))
        worst = max(worst, abs(found - distance), 0.0 if np.isnan(build_up) else abs(risen - build_up))
    limit = criteria["braked_weight"]["distance_m"]
    result.rows.append(Row("braked weight to distance [m], largest difference", worst, limit))


def _stop(result, criteria, name, published, case, tables_of):
    reduced = stop(case, PATCH, LOAD)
    whole = wagon(case, tables_of(case))
    result.stops[name] = published, reduced, whole
    rows, limit = result.rows, criteria["energy"]["share"]
    rows.append(Row(f"{name}: distance, share off", share_off(reduced.distance, published.distance),
                    published.tolerance))  # fmt: skip
    rows.append(Row(f"{name}: time, share off", share_off(reduced.time, published.time), published.tolerance))
    if not np.isnan(published.locks_at):
        rows.append(Row(f"{name}: time of locking, share off", share_off(reduced.locked_at, published.locks_at),
                        published.tolerance))  # fmt: skip
    rows.append(Row(f"{name}: energy not accounted for, reduced", abs(reduced.unbooked), limit))
    rows.append(Row(f"{name}: energy not accounted for, wagon", abs(whole.ledger.share), limit))


def wagon(case, tables, sink=None):
    """The whole wagon of a scenario, until it stands."""
    case, system, _ = with_step(case, assemble(case, tables))
    outcome = simulate(case, system, sink or (lambda rows: None))
    if outcome.fault:
        raise SimulationError(f"{case.name}: {outcome.fault}")
    train, port = outcome.last.train[0], outcome.last.port
    return Wagon(
        float(train["stop_place"]), float(train["stop_time"]), ledger(system, outcome.first, outcome.last),
        int(port["vents"].sum()), port["locked"].copy(), port["largest_slide"].copy(),
    )  # fmt: skip


def _load_transfer(result, criteria, case, tables):
    """Axle loads at a steady deceleration less those at rest, with stiff rods as in the closed form, and as it is.

    As it is, the bodies move forward on their rods and springs, and their weight with them; with that the moments of
    the whole vehicle about a point of the rails balance.
    """
    limits = criteria["load_transfer"]
    stiff = case.model_copy(update={"vehicle": with_stiff_rods(case.vehicle)})
    expected = rod_transfer(case.vehicle)
    found, _, _ = transferred(stiff, tables)
    actual, result.deceleration, unbalanced = transferred(case, tables)
    for k, (one, other, wanted) in enumerate(zip(found, actual, expected, strict=True), start=1):
        result.transfer.append((k, 1e-3 * one, 1e-3 * other, 1e-3 * wanted))
        result.rows.append(
            Row(f"load transfer of W{k}, stiff rods, share off", share_off(one, wanted), limits["share"])
        )
    result.rows.append(Row("moment of axle loads and weights, share off", unbalanced, limits["balance"]))


def transferred(case, tables):
    """Change of the axle loads per deceleration [N s^2/m], the deceleration [m/s^2], and what is off in the moments."""
    taken = []

    def sink(rows):
        inside = (rows.time > STEADY[0]) & (rows.time < STEADY[1])
        if inside.any():
            taken.append((rows.rail["q"][inside].copy(), rows.time[inside].copy(), rows.v[inside, 0, 0].copy(),
                          rows.q[inside, :, 0].copy()))  # fmt: skip

    wagon(case, tables, sink)
    q, time, speed, place = (np.concatenate(one) for one in zip(*taken, strict=True))
    slope = -float(np.polyfit(time, speed, 1)[0])
    case, system, _ = with_step(case, assemble(case, tables))
    rest = static(system).data.rail["q"].reshape(-1, 2).sum(axis=1)
    loads = q.mean(axis=0).reshape(-1, 2).sum(axis=1)
    ahead = (place - place[:, :1]).mean(axis=0)
    body, axle = system.model.body, system.model.axle
    spun = (body["inertia"][axle["wheelset"], 1] / axle["radius"]).sum()
    braking = slope * (spun - np.sum(body["mass"] * system.rest[:, 2]))  # z points down
    moment = np.sum(loads * ahead[axle["wheelset"]]) - case.run.gravity * np.sum(body["mass"] * ahead)
    return (loads - rest) / slope, slope, abs(moment / braking - 1.0)


def with_stiff_rods(vehicle):
    """The vehicle with its traction rods STIFFER times as stiff."""
    joints = tuple(
        joint.model_copy(
            update={
                "links": tuple(
                    link.model_copy(update={"stiffness": STIFFER * link.stiffness}) if link.name == "traction rod"
                    else link for link in joint.links
                )
            }
        )
        for joint in vehicle.joints
    )  # fmt: skip
    return vehicle.model_copy(update={"joints": joints})


STIFFER = 20.0
ROD = 0.60  # height of the Manchester wagon's traction rods [m]


def rod_transfer(vehicle):
    """Change of the axle loads per deceleration with all longitudinal force of the body in rods at ROD [N s^2/m].

    Two bogies of two wheelsets: pitch balance of the body about the rods, then of each bogie with its wheelsets, whose
    spin slows by 1/r per deceleration.
    """
    body, bogie, wheelset = vehicle.bodies[0], vehicle.bodies[1], vehicle.bodies[vehicle.wheelsets[0]]
    pivots = vehicle.bodies[1].x - vehicle.bodies[2].x
    base = vehicle.bodies[vehicle.wheelsets[0]].x - vehicle.bodies[vehicle.wheelsets[1]].x
    radius = wheelset.wheel_radius
    to_bogies = body.mass * (body.height - ROD) / pivots
    pitch = 0.5 * body.mass * ROD + bogie.mass * bogie.height
    pitch += 2.0 * (wheelset.mass * radius + wheelset.inertia[1] / radius)
    within = pitch / base
    front, rear = to_bogies / 2.0, -to_bogies / 2.0
    return np.array([front + within, front - within, rear + within, rear - within])


def _curve(result, criteria, case, tables):
    """Each patch of a wagon that brakes in a curve stays on the friction circle of its own slip velocity.

    Beside it where the wheelsets run before the brake acts, and when it is full and the speed still about the same.
    """
    most, taken = 0.0, []

    def sink(rows):
        nonlocal most
        patch, grip = rows.contact, rows.rail["grip"]
        loaded = patch["normal"] > LOADED
        slid = np.hypot(patch["slip_x"], patch["slip_t"])
        mu0, ratio, decay = (grip[:, :, c, None] for c in range(3))
        friction = mu0 * ((1.0 - ratio) * np.exp(-decay * slid) + ratio)
        pull = np.hypot(patch["creep_x"], patch["creep_t"]) / np.where(loaded, friction * patch["normal"], np.inf)
        most = max(most, float(pull.max()))
        taken.append((rows.time.copy(), rows.train["applied"].copy(), rows.q[:, :, 1].copy()))

    wagon(case, tables, sink)
    time, applied, lateral = (np.concatenate(one) for one in zip(*taken, strict=True))
    before = int(np.searchsorted(time, case.driver.time[1]))
    full = int(np.argmax(applied > 0.999))
    outwards = -np.sign(case.pieces()[-1]["curvature"][0]) * lateral[:, list(case.vehicle.wheelsets)]
    result.circle = most, outwards[before], outwards[full]
    limit = 1.0 + criteria["adhesion_circle"]["above_one"]
    result.rows.append(Row("creep force over its friction circle, braking in a curve", most, limit))
