"""Subsystems of a vehicle put together: what fits, and the arrays of the compiled core (docs/subsystems.md).

Each is a table of a scenario's file with a `kind`; another assembly is another file. The ports through which they act
on one another are in kernels/assembly_layout.py.
"""

from typing import NamedTuple

import numpy as np

from railcli.kernels.assembly_layout import ASSEMBLY, AXLE, LINE, Driver, Odometry, Pad, Protection
from railcli.kernels.layout import CURVE, NO_ASSEMBLY, NO_AXLE, NO_LINE, NO_PLAN

from .adhesion import MEMORIES
from .controls import REFERENCES, SENSORS, AxleOdometry, SpeedSensor
from .driving import RISES, Demand, FollowLine, HoldSpeed


class Subsystems(NamedTuple):
    """Arrays of the compiled core: what brakes and drives, parameters, line; with what they add to vehicle arrays."""

    axle: np.ndarray
    assembly: np.ndarray
    plan: np.ndarray
    line: np.ndarray
    curve: np.ndarray
    body: np.ndarray


OPTIONAL = (
    "brake", "traction", "speed_sensor", "slide_protection", "anti_slip", "odometry", "adhesion", "resistance",
)  # fmt: skip


OF_CONTACT = ("friction", "friction_ratio", "friction_decay", "adhesion_reduction", "slip_reduction")


def given(scenario):
    """Names of the subsystems that a scenario has."""
    names = [name for name in OPTIONAL if getattr(scenario, name) is not None]
    return (["driver"] if is_free(scenario) else []) + names


def controllers(scenario):
    """Names of those that read the sensors."""
    return [name for name in ("slide_protection", "anti_slip", "odometry") if getattr(scenario, name) is not None]


def period(scenario):
    """Time between two samples of the sensors [s]; None when nobody reads them."""
    if not controllers(scenario):
        return None
    return (scenario.speed_sensor or SpeedSensor()).period


def is_free(scenario):
    """Whether speed is a result."""
    return not isinstance(scenario.driver, HoldSpeed)


def fault(scenario):
    """What does not fit together between the subsystems of a scenario and its vehicle, or None."""
    brake, vehicle = scenario.brake, scenario.vehicle
    if scenario.slide_protection and (brake is None or brake.valves is None):
        return "slide_protection: acts on dump valves; give [brake] with [brake.valves]"
    if scenario.speed_sensor and not controllers(scenario):
        return "speed_sensor: nobody reads it; give [slide_protection], [anti_slip] or [odometry]"
    if scenario.anti_slip and scenario.traction is None:
        return "anti_slip: acts on motors; give [traction]"
    if scenario.traction and scenario.traction.electric is not None and brake is None:
        return "traction.brake_torque_Nm: the electric brake shares a brake's demand; give [brake]"
    every, step = period(scenario), scenario.run.step
    if every is not None and step is not None and not is_multiple(every, step):
        return (
            f"speed_sensor.period_ms: must be a whole number of steps of {step * 1e3:g} ms, got {every * 1e3:g} ms"
        )
    demand = scenario.driver if isinstance(scenario.driver, Demand) else None
    if demand and demand.brake is not None and brake is None:
        return "driver.brake: there is no brake; give [brake]"
    if demand and demand.traction is not None and scenario.traction is None:
        return "driver.traction: there is no traction; give [traction]"
    if is_free(scenario) and scenario.run.course is not None:
        return f"run.speed_course: speed is a result of driver kind {scenario.driver.kind!r}; leave it out"
    if given(scenario) and any(right != left for right, left in vehicle.axle_lines):
        return "vehicle: wheels that turn freely of one another have no brakes, traction, adhesion or resistance yet"
    n = len(vehicle.wheelsets)
    if brake is not None and brake.frames is not None:
        if len(brake.frames) != n:
            return f"brake.frames: must name a body for each of the {n} wheelsets, got {len(brake.frames)}"
        for name in brake.frames:
            if name not in vehicle.names or vehicle.bodies[vehicle.names.index(name)].is_wheelset:
                return f"brake.frames: {name!r} is no body, or a wheelset"
    errors = scenario.speed_sensor.radius_error if scenario.speed_sensor else (0.0,)
    if len(errors) not in (1, n):
        return f"speed_sensor.radius_error: must hold one value or one for each of the {n} axles, got {len(errors)}"
    if scenario.traction and scenario.traction.axles and max(scenario.traction.axles) > n:
        return f"traction.axles: the vehicle has {n} axles, got {max(scenario.traction.axles)}"
    adhesion = scenario.adhesion
    for key in OF_CONTACT:
        if adhesion and key in scenario.contact.model_fields_set:
            return f"contact.{key}: [adhesion] says what the rails lend; leave it out"
    if adhesion and adhesion.reduces and scenario.contact.creep_law != "polach":
        return (
            "adhesion: a set has reductions k_A, k_S, which only Polach's law knows; give creep_law = \"polach\" in "
            "[contact], or adhesion_reduction = 1 and slip_reduction = 1 in the stretch"
        )
    return None


def is_multiple(period, step):
    """Whether a period is a whole number of steps."""
    count = round(period / step)
    return count >= 1 and abs(count * step - period) <= 1e-9 * period


def reacting_body(vehicle, wheelset):
    """Body on which the torques of a wheelset react: what it is joined to, through an axle box if there is one."""
    def joined(i):
        pairs = [tuple(map(vehicle.names.index, pair)) for joint in vehicle.joints for pair in joint.pairs]
        return [a + b - i for a, b in pairs if i in (a, b)]

    def best(candidates):
        return max(candidates, key=lambda k: vehicle.bodies[k].mass)

    near = [k for k in joined(wheelset) if not vehicle.bodies[k].is_wheelset]
    if not near:
        return None
    found = best(near)
    wheelsets = [k for k in joined(found) if vehicle.bodies[k].is_wheelset]
    beyond = [k for k in joined(found) if not vehicle.bodies[k].is_wheelset]
    is_box = set(wheelsets) == {wheelset} and vehicle.bodies[found].mass < vehicle.bodies[wheelset].mass
    return best(beyond) if is_box and beyond else found


def pack(scenario, vehicle, rows, end):
    """The subsystems of a scenario.

    Parameters
    ----------
    scenario : Scenario
    vehicle : PackedVehicle
    rows : int
        Implicit elements of the vehicle itself.
    end : float
        Arc length at which a free run ends [m].

    Returns
    -------
    Subsystems
    """
    if not given(scenario):
        return Subsystems(NO_AXLE, NO_ASSEMBLY, NO_PLAN, NO_LINE, vehicle.curve, vehicle.body)
    curves = _Curves(vehicle.curve)
    assembly = np.zeros(1, ASSEMBLY)
    row = assembly[0]
    for key in ("brake_curve", "traction_curve", "envelope", "electric", "pad_curve"):
        row[key] = -1
    row["end_place"] = np.inf
    plan = NO_PLAN
    if is_free(scenario):
        row["free"], row["end_place"] = 1, end
        for key, knots in zip(("brake_curve", "traction_curve"), scenario.driver.curves(), strict=True):
            row[key] = curves.add(knots)
        row["driver"] = _DRIVERS[scenario.driver.kind]
        row["ends"] = row["brake_curve"] >= 0
        if isinstance(scenario.driver, FollowLine):
            plan = scenario.driver.packed()
            row["planned"], row["eager"] = scenario.driver.deceleration, scenario.driver.eager
    axle = _axles(scenario, rows)
    body = vehicle.body.copy()
    _pack_brake(scenario.brake, row, axle, curves)
    _pack_traction(scenario.traction, row, axle, curves, body)
    row["mass"] = _equivalent_mass(body, axle)
    _pack_sensor(scenario, row, axle)
    _pack_protection(scenario.slide_protection, row)
    _pack_anti_slip(scenario.anti_slip, row)
    _pack_odometry(scenario.odometry, row)
    if scenario.resistance:
        row["resistance"] = scenario.resistance.a, scenario.resistance.b, scenario.resistance.c
    return Subsystems(axle, assembly, plan, _pack_line(scenario, row), curves.array(), body)


_DRIVERS = {"coast": Driver.NOBODY, "demand": Driver.DEMAND, "line": Driver.LINE}


def _equivalent_mass(body, axle):
    """Mass of a vehicle with that of its rotation [kg]."""
    spins = body["inertia"][axle["wheelset"], 1] / axle["radius"] ** 2
    return float(body["mass"].sum() + spins.sum())


def _axles(scenario, rows):
    vehicle = scenario.vehicle
    frames = scenario.brake.frames if scenario.brake else None
    axle = np.zeros(len(vehicle.wheelsets), AXLE)
    for a, (i, radii) in enumerate(zip(vehicle.wheelsets, vehicle.wheel_radii, strict=True)):
        frame = vehicle.names.index(frames[a]) if frames else reacting_body(vehicle, i)
        axle[a]["wheelset"], axle[a]["frame"] = i, i if frame is None else frame
        axle[a]["first"], axle[a]["row"], axle[a]["radius"] = 2 * a, rows + a, np.mean(radii)
    return axle


def _pack_brake(brake, row, axle, curves):
    if brake is None:
        return
    row["rise"], row["apply"], row["release"] = RISES[brake.rise], brake.apply, brake.release
    row["inshot"], row["inshot_time"], row["delay"] = brake.inshot, brake.inshot_time, brake.delay
    row["pressure"], row["volume"] = brake.pressure, brake.volume
    if brake.valves:
        row["fill"], row["vent"], row["dead"] = brake.valves.fill, brake.valves.vent, brake.valves.dead
    if brake.kind == "torque":
        row["pad"], axle["brake_torque"], axle["full_torque"] = Pad.NOMINAL, brake.torque, brake.torque
        return
    count, one = (2 * brake.discs, brake.clamp_force) if brake.kind == "discs" else (brake.blocks, brake.block_force)
    axle["brake_force"], axle["block_force"] = count * one, one
    axle["brake_radius"] = brake.radius if brake.kind == "discs" else axle["radius"]
    axle["full_torque"] = axle["brake_force"] * axle["brake_radius"] * brake.friction_at_rest
    if brake.friction is not None:
        row["pad"], row["pad_friction"] = Pad.CONSTANT, brake.friction
    elif brake.friction_speed is not None:
        speed, values = _flat_ends(brake.friction_speed, brake.friction_values)
        row["pad"], row["pad_curve"] = Pad.TABLE, curves.add((speed, values))
    else:
        row["pad"] = Pad.CAST_IRON


def _flat_ends(x, y):
    """Knots of a table that stays at its last value."""
    return np.array([*x, x[-1] + 1.0]), np.array([*y, y[-1]])


def _pack_traction(traction, row, axle, curves, body):
    if traction is None:
        return
    row["envelope"] = curves.add(_flat_ends(traction.speed, traction.torque))
    if traction.electric is not None:
        row["electric"] = curves.add(_flat_ends(traction.speed, traction.electric))
    row["lag"], row["torque_rate"], row["fade"] = traction.lag, traction.torque_rate, traction.fade
    driven = range(1, axle.size + 1) if traction.axles is None else traction.axles
    for number in driven:
        axle[number - 1]["driven"] = 1
        body[axle[number - 1]["wheelset"]]["inertia"][1] += traction.ratio**2 * traction.rotor_inertia


def _pack_sensor(scenario, row, axle):
    sensor = scenario.speed_sensor or SpeedSensor()
    axle["sensed_radius"] = axle["radius"] * (1.0 + np.array(sensor.radius_error))
    row["sensor"], row["teeth"], row["clock"] = SENSORS[sensor.kind], sensor.teeth, sensor.clock
    row["noise"], row["seed"] = sensor.noise, sensor.seed
    row["period"] = period(scenario) or 0.0


def _pack_anti_slip(control, row):
    if control is not None:
        row["antislip"], row["slip_cut"], row["spin_cut"] = 1, control.slip, control.spin
        row["cut"], row["regrip"] = control.cut, control.regrip


def _pack_odometry(odometry, row):
    if isinstance(odometry, AxleOdometry):
        row["odometry"], row["odometer_fall"], row["odometer_rise"] = Odometry.AXLES, odometry.fall, odometry.rise
    elif odometry is not None:
        row["odometry"], row["bias"] = Odometry.KALMAN, odometry.bias
        row["acceleration_noise"], row["speed_noise"] = odometry.acceleration_noise, odometry.speed_noise


def _pack_protection(protection, row):
    if protection is None:
        return
    row["protection"], row["reference"] = Protection.THRESHOLD, REFERENCES[protection.reference]
    for key in ("active_above", "slide_vent", "slide_hold", "slide_watch", "fall", "regain",
                "reference_fall", "pilot_every"):
        row[key] = getattr(protection, key)


def _pack_line(scenario, row):
    adhesion = scenario.adhesion
    if adhesion is None:
        return NO_LINE
    row["memory"], row["cleaning"], row["cell"] = MEMORIES[adhesion.memory], adhesion.cleaning, adhesion.cell
    row["cell_start"] = scenario.pieces()[0]["start"]
    line = np.zeros(len(adhesion.stretches), LINE)
    for one, stretch in zip(line, adhesion.stretches, strict=True):
        one["start"], one["blend"], one["films"] = stretch.start, stretch.blend, stretch.clean is not None
        one["grip"], one["clean"] = stretch.grips(), stretch.cleaned()
    line[0]["start"] = -np.inf
    return line


class _Curves:
    """Curves behind those of the vehicle."""

    def __init__(self, known):
        self._rows = list(known)

    def add(self, knots):
        """Place of a curve; -1 without knots."""
        if knots is None:
            return -1
        x, y = knots
        row = np.zeros(1, CURVE)[0]
        row["count"], row["x"][: x.size], row["y"][: y.size] = x.size, x, y
        self._rows.append(row)
        return len(self._rows) - 1

    def array(self):
        return np.array(self._rows, CURVE)
