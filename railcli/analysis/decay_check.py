"""Decay and hunting of the Cooperrider wagon beside another program (docs/validation.md)."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from railcli.errors import SimulationError
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.system import assemble

from .conicity_check import Row
from .faults import copied, verdict
from .linear import linearise, modes, on_straight
from .mode_shapes import describe
from .rigid_contact import contact_at
from .simulate import settled_start
from .step_choice import with_step

ASIDE = 5e-3  # lateral displacement of the first wheelset of each bogie [m]
BEGIN, END = 1.0, 3.0  # of the swing that is measured [s]
LATE = 8.0  # end of a run that tells whether hunting persists [s]
SAMPLE = 2.5e-3  # [s]
LOWEST = 2.0  # frequency of bogie hunting; slower ones are motions of the car body [Hz]
ROOM = 200.0  # of straight track beyond a run [m]
HUNTING = (110.0, 120.0, 130.0, 140.0)  # speeds at which it is asked whether hunting persists [m/s]
CRITICAL = (90.0, 145.0)  # between which the linear critical speed is looked for [m/s]
ACCURACY = 0.05  # of it [m/s]
WITHIN = 6.0e-3  # lateral positions at which the contact is compared [m]


@dataclass(frozen=True)
class Decays:
    """What the other program gives.

    Attributes
    ----------
    swing_speed, swing : array (n,)
        [m/s]; half the peak-to-peak of wheelset 1 from BEGIN to END [m].
    speed, rate, frequency : array (m,)
        Of the bogie mode [m/s], [1/s], [Hz].
    y, on_wheel, radius, angle : array (k,)
        Its contact table: position of the wheelset towards the flange [m], contact from the tape circle to the field
        side [m], rolling radius [m], contact angle [rad].
    """

    swing_speed: np.ndarray
    swing: np.ndarray
    speed: np.ndarray
    rate: np.ndarray
    frequency: np.ndarray
    y: np.ndarray
    on_wheel: np.ndarray
    radius: np.ndarray
    angle: np.ndarray


@dataclass(frozen=True)
class Wagon:
    """What railcli gives.

    Attributes
    ----------
    scenario : Scenario
    swing : array (n,)
        Half the peak-to-peak of wheelset 1 from BEGIN to END, at the speeds of the other program [m].
    early, late : array
        The same in the third second and in the last one before LATE, at HUNTING [m].
    rate, frequency, corrected : array (m,)
        Of the least damped bogie hunting, with the gyroscopic moments of the other program [1/s], [Hz]; the rate with
        the right ones [1/s].
    critical : pair of float
        Speed at which it neither grows nor decays, with the other program's and the right moments [m/s]; NaN beyond
        CRITICAL.
    contact : array (k, 3)
        Contact from the tape circle [m], rolling radius [m], contact angle [rad] at the table's positions; NaN beyond
        WITHIN.
    """

    scenario: object
    swing: np.ndarray
    early: np.ndarray
    late: np.ndarray
    rate: np.ndarray
    frequency: np.ndarray
    corrected: np.ndarray
    critical: tuple
    contact: np.ndarray


def conicity(y, radius):
    """Delta-r over 2 y, from the radii of one wheel at y and at -y: both are needed [-]; growing y > 0."""
    away = y[y > 0.0]
    pairs = [(value, np.flatnonzero(np.isclose(y, value))[0], np.flatnonzero(np.isclose(y, -value))) for value in away]
    return np.array([(radius[i] - radius[k[0]]) / (2.0 * value) for value, i, k in pairs if k.size])


def bogie_hunting(linear):
    """Rate [1/s] and frequency [Hz] of the least damped bogie hunting."""
    found = modes(linear)
    ranked = np.argsort(-found.value.real)
    for k in ranked:
        if found.oscillates[k] and found.frequency[k] > LOWEST and "hunting" in describe(found, k).words:
            return float(found.value[k].real), float(found.frequency[k])
    raise SimulationError(f"no bogie hunting found at {linear.speed:g} m/s")


def with_spinning_axes(linear):
    """The linear model with the gyroscopic moments of axes that spin with a wheelset.

    In axes that do not spin, as railcli's are, a wheelset of equal roll and yaw inertia feels
    Ix phi'' = Iy W psi' and Iz psi'' = -Iy W phi', W its spin about y. The other program has Euler's equations for axes
    that spin, Ix phi'' = (Iy - Iz) W psi' and Iz psi'' = (Ix - Iy) W phi', with angles of axes that do not, and its z
    axis upwards: by z down (Iz - Iy) and -(Ix - Iy), with W = V / r.

    Returns
    -------
    Linear
    """
    matrix, n = linear.matrix.copy(), 6 * linear.size
    place = {int(where): k for k, where in enumerate(linear.kept)}
    radii, inertia = linear.system.radii, linear.system.model.body["inertia"]
    for i in linear.system.wheelsets:
        spin, (ix, _, iz) = linear.speed / radii[i], inertia[i]
        roll, yaw = place[n + 6 * i + 3], place[n + 6 * i + 5]
        matrix[roll, yaw] += iz / ix * spin
        matrix[yaw, roll] -= ix / iz * spin
    return replace(linear, matrix=matrix)


def critical_speed(system, change):
    """Speed at which bogie hunting neither grows nor decays [m/s]; NaN beyond CRITICAL. change : of a Linear."""

    def rate(speed):
        return bogie_hunting(change(linearise(system, speed)))[0]

    return float(brentq(rate, *CRITICAL, xtol=ACCURACY)) if rate(CRITICAL[0]) < 0.0 < rate(CRITICAL[1]) else np.nan


def swings(system, speed, windows):
    """Half the peak-to-peak of wheelset 1 in windows of time after the start [m].

    Parameters
    ----------
    system : System
    speed : float
        [m/s]
    windows : sequence of (float, float)
        The last one ends the run [s].
    """
    end = windows[-1][1]
    system = on_straight(system, speed * end + ROOM, speed=speed)
    aside = np.zeros(system.model.body.size)
    aside[list(system.wheelsets[::2])] = ASIDE
    data = settled_start(system, aside)
    stride = max(1, round(SAMPLE / float(system.model.param[0]["step"])))
    rows = new_rows(system.model, round(end / (stride * float(system.model.param[0]["step"]))))
    kept = copied(data)
    _, status = record(system.model, data, rows, stride)
    if status:
        raise SimulationError(f"at {speed:g} m/s: {verdict(system, data, status, kept)}")
    lateral = rows.q[:, system.wheelsets[0], 1]
    return [0.5 * float(np.ptp(lateral[(rows.time >= a) & (rows.time <= b)])) for a, b in windows]


def compare_wagon(decays, scenario, tables, wheelset, progress):
    """Decay, hunting and contact of the wagon.

    Parameters
    ----------
    decays : Decays
    scenario : Scenario
    tables : sequence of ContactTable
    wheelset : Wheelset
        Its wheels on its rails.
    progress : callable
        Called with the share done and a sentence.

    Returns
    -------
    Wagon
    """
    speeds = min(decays.swing_speed.min(), *HUNTING), max(*HUNTING, *CRITICAL)
    _, system, choice = with_step(scenario, assemble(scenario, tables), speeds)
    fine = system.stepped(0.5 * choice.step)  # wheelsets strike their flanges, as in `critical-speed`
    steps = decays.swing_speed.size + len(HUNTING) + decays.speed.size + 2
    done = iter(range(steps))

    def tell(text):
        progress(next(done) / steps, f"{scenario.vehicle.name}, {text}")

    swing, persists = [], []
    for speed in decays.swing_speed:
        tell(f"{speed:g} m/s")
        swing += swings(fine, float(speed), [(BEGIN, END)])
    for speed in HUNTING:
        tell(f"{speed:g} m/s")
        persists.append(swings(fine, speed, [(2.0, 3.0), (LATE - 1.0, LATE)]))
    published, right = [], []
    for speed in decays.speed:
        tell(f"modes at {speed:g} m/s")
        linear = linearise(system, float(speed))
        published.append(bogie_hunting(with_spinning_axes(linear)))
        right.append(bogie_hunting(linear)[0])
    critical = []
    for change in (with_spinning_axes, lambda linear: linear):
        tell("critical speed")
        critical.append(critical_speed(system, change))
    contact = contact_at(wheelset, with_roll=True)
    places = np.full((decays.y.size, 3), np.nan)
    for i in np.flatnonzero(np.abs(decays.y) < WITHIN):
        row = contact(float(decays.y[i]))
        places[i] = row[0], row[6], row[4]
    early, late = np.array(persists).T
    rate, frequency = np.array(published).T
    return Wagon(scenario, np.array(swing), early, late, rate, frequency, np.array(right), tuple(critical), places)


def judge(criteria, decays, wagon):
    """Criteria as `Row`s."""
    theirs, ours = (conicity(decays.y, radius) for radius in (decays.radius, wagon.contact[:, 1]))
    slow = decays.swing_speed <= decays.speed.min()
    ratio = np.log(wagon.swing[slow] / decays.swing[slow])
    return [
        Row("Cooperrider: conicity of the wheels", float(np.nanmax(np.abs(ours / theirs - 1.0))), criteria["conicity"]),
        Row(
            "Cooperrider: decay rate, gyroscopic moments as published [1/s]",
            float(np.abs(wagon.rate - decays.rate).max()), criteria["rate_1_per_s"],
        ),
        Row(
            "Cooperrider: frequency of the bogie mode",
            float(np.abs(wagon.frequency / decays.frequency - 1.0).max()), criteria["frequency"],
        ),
        Row(
            "Cooperrider: swing up to 100 m/s, typical factor",
            float(np.exp(np.abs(ratio).mean())), criteria["swing_factor"], False,
        ),
    ]  # fmt: skip
