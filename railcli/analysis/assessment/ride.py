"""Accelerations of the bodies above the bogies: ride characteristics section by section, comfort in windows of time."""

from typing import NamedTuple

import numpy as np

from .. import indices
from .values import Trace

LOW, HIGH = 0.4, 10.0  # of ride characteristics [Hz]
QUASI_STATIC = 20.0  # [Hz]
LEAST_WINDOWS = 20  # below this the 95th percentile lies beyond the second largest value
FULL_WINDOWS = 60  # 5 minutes
COMFORT_RATE = 200.0  # W_b ends at 100 Hz [Hz]
WINDOWS_AT_ONCE = 40
CHANNELS = ("rotation", "angular_velocity", "acceleration")
COMFORT = ("N_MV", "C_y", "C_z", "Wz_y", "Wz_z")
KEYS = ("ay_max", "az_max", "ay_rms", "az_rms", "ay_qst", "ay_centre", "az_centre", *COMFORT)


class Point(NamedTuple):
    """Where an accelerometer stands.

    Attributes
    ----------
    name : str
    kind : {"centre", "middle", "support"}
        Centre of mass, middle of the floor, floor above a body that carries this one.
    arm : tuple
        From the centre of mass, body axes [m].
    """

    name: str
    kind: str
    arm: tuple


def bodies_with_points(vehicle, floor_height):
    """Bodies that carry no other and are no wheelsets: name and list of Point.

    The floor is level and lies `floor_height` [m] over the rail tops at rest.
    """
    pairs = [pair for joint in vehicle.joints for pair in joint.pairs]
    found = {}
    for body in vehicle.bodies:
        if body.is_wheelset or any(lower == body.name for lower, _ in pairs):
            continue
        down = body.height - floor_height
        carriers = dict.fromkeys(lower for lower, upper in pairs if upper == body.name)
        along = {name: vehicle.bodies[vehicle.names.index(name)].x - body.x for name in carriers}
        found[body.name] = [
            Point("centre", "centre", (0.0, 0.0, 0.0)),
            Point("middle of the floor", "middle", (0.0, 0.0, down)),
            *(Point(f"floor above {name}", "support", (x, 0.0, down)) for name, x in along.items()),
        ]
    return found


def assess_ride(run, outcome, tally):
    """Offer accelerations and comfort of every body that has a floor."""
    bodies = bodies_with_points(run.scenario.vehicle, run.limits.floor_height)
    if not bodies:
        tally.missing(KEYS, "the vehicle has no body above its wheelsets")
        return
    if name := run.absent(f"bodies/{body}/{channel}" for body in bodies for channel in CHANNELS):
        tally.missing(KEYS, f"channel {name} was not recorded")
        return
    if run.rate < indices.lowest_rate(QUASI_STATIC):
        tally.missing(KEYS, f"recorded at {run.rate:g} Hz, too slow; set output_interval_ms = 10 or less")
        return
    if not any(section.kind == "curve" for section in outcome.sections):
        tally.missing(("ay_qst",), "no full curve in what is evaluated")
    outcome.conditions["floor_height_m"] = run.limits.floor_height
    outcome.bounds |= {"ay_max": run.limits.ay_max, "az_max": run.limits.az_max}
    for body, points in bodies.items():
        _assess_sections(run, outcome, tally, body, points)
        _assess_comfort(run, outcome, tally, body, [point for point in points if point.kind != "centre"])


def _accelerations(run, body, points, rows):
    """Arc length of the body's centre (n,), and accelerations at its points, body axes (m, n, 3)."""
    rotation, omega, acceleration = (run.source.read(f"bodies/{body}/{channel}", *rows) for channel in CHANNELS)
    if run.filtered:
        turning = run.source.read(f"bodies/{body}/angular_acceleration", *rows)
    else:
        turning = indices.derivative(omega, run.rate)
    arms, gravity = np.array([point.arm for point in points]), run.scenario.run.gravity
    values = indices.floor_acceleration(acceleration, rotation, omega, turning, arms, gravity)
    return run.places(body, *rows), values


def _assess_sections(run, outcome, tally, body, points):
    sections = outcome.sections
    points = [point for point in points if point.kind != "middle"]
    traces = {axis: outcome.traces.setdefault(f"a{axis}_max", {}) for axis in "yz"}
    for point in points:
        for axis in "yz" if point.kind == "support" else "":
            traces[axis][f"{body},\n{point.name}"] = Trace(sections, run.speed * run.interval)
    for group in run.blocks(sections):
        start, end = sections[group[0]].start, sections[group[-1]].end
        s, values = _accelerations(run, body, points, run.rows(start, end, indices.SETTLED * run.speed))
        for point, value in zip(points, values, strict=True):
            ride = indices.filtered(value[:, 1:], run.rate, LOW, HIGH)
            slow = indices.filtered(value[:, 1], run.rate, high=QUASI_STATIC)
            place = s + point.arm[0]
            inside = slice(*np.searchsorted(place, [start, end]))
            for axis, column in zip("yz", ride.T, strict=True):
                if point.kind == "support":
                    traces[axis][f"{body},\n{point.name}"].add(place[inside], column[inside])
            for number in group:
                rows = slice(*np.searchsorted(place, [sections[number].start, sections[number].end]))
                _judge(
                    tally, run.limits, point, f"{body}, {point.name}", sections[number], number, ride[rows], slow[rows]
                )


def _judge(tally, limits, point, where, section, number, ride, slow):
    if not ride.size:
        return  # this point did not come so far
    where = f"{where}, {section.place}"
    for axis, signal in zip("yz", ride.T, strict=True):
        largest = np.abs(indices.extremes(signal)).max()
        if point.kind == "centre":
            tally.offer(f"a{axis}_centre", largest, None, where, section=number)
            continue
        for key, value in ((f"a{axis}_max", largest), (f"a{axis}_rms", indices.root_mean_square(signal))):
            tally.offer(key, value, getattr(limits, key), where, section=number)
    if section.kind == "curve" and point.kind == "support":
        tally.offer("ay_qst", abs(np.median(slow)), limits.ay_qst, where, section=number)


def _assess_comfort(run, outcome, tally, body, points):
    """Weighted accelerations in windows of 5 s that follow each other, from the end of the run-in to the run-out."""
    window, limits = indices.COMFORT_WINDOW, run.limits
    rows, size, pad = run.source.rows, round(window * run.rate), round(indices.SETTLED * run.rate)
    count = max(0, (run.last_row - run.first_row) // size)
    if count < LEAST_WINDOWS:
        tally.missing(("N_MV",), f"{count} windows of {window:g} s from run-in to run-out, {LEAST_WINDOWS} are needed")
    if count < 1:
        tally.missing(COMFORT, f"no window of {window:g} s from run-in to run-out")
        return
    gathered = {point.name: [] for point in points}
    for begin in range(0, count, WINDOWS_AT_ONCE):
        start, stop = (run.first_row + size * k for k in (begin, min(count, begin + WINDOWS_AT_ONCE)))
        first, last = max(0, start - pad), min(rows, stop + pad)
        _, values = _accelerations(run, body, points, (first, last))
        for point, value in zip(points, values, strict=True):
            signals = (indices.weighted(value[:, axis], run.rate, response) for axis, response in RESPONSES)
            rms = [indices.window_rms(signal[start - first : stop - first], run.rate) for signal in signals]
            gathered[point.name].append(np.stack(rms))
    for name, blocks in gathered.items():
        x, y, z, sperling_y, sperling_z = np.concatenate(blocks, axis=1)
        place = f"{body}, {name}"
        if count >= LEAST_WINDOWS:
            note = "" if count >= FULL_WINDOWS else f"{count} windows, 5 minutes have {FULL_WINDOWS}"
            tally.offer("N_MV", indices.mean_comfort(x, y, z), limits.n_mv, place, note)
        tally.offer("C_y", y.max(), None, place)
        tally.offer("C_z", z.max(), None, place)
        for key, rms in (("Wz_y", sperling_y), ("Wz_z", sperling_z)):
            weighted = indices.root_mean_square(rms)
            tally.offer(key, indices.sperling(weighted), limits.wz, place, f"over {count * window:g} s")
    if run.rate < COMFORT_RATE:
        outcome.warnings.append(
            f"Comfort: recorded at {run.rate:g} Hz. W_b and W_d reach to 100 Hz; what is above {run.rate / 2.0:g} Hz "
            f"folds below it. Set output_interval_ms = {1e3 / COMFORT_RATE:g} or less."
        )


def _comfort_filter(name):
    return lambda frequency: indices.weighting(name, frequency)


RESPONSES = (  # axis, filter
    (0, _comfort_filter("W_d")),
    (1, _comfort_filter("W_d")),
    (2, _comfort_filter("W_b")),
    (1, lambda frequency: indices.sperling_weighting(frequency, lateral=True)),
    (2, indices.sperling_weighting),
)
