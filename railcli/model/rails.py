"""Displacement of the rails: everything that moves them from their ideal place, summed and packed for the core."""

import math

import numpy as np

from railcli.errors import InputError
from railcli.kernels.layout import NO_SHIFT, SHIFT_CHANNELS

from .irregularity import Course
from .track import MARGIN

MOST_NODES = 4_000_000  # 256 MB
FAR = 1e7  # beyond any track [m]
LEAST_SPACING = 1e-3  # [m]
WIDENING_SPACING = 1.0  # of nodes for gauge that is wider in curves [m]
TIGHTEST = {"lateral": 0.125, "vertical": 0.5}  # bend times radius that a wheel can follow (theory 4.12)


def course(scenario):
    """What sources of irregularity must know of a run."""
    bodies = scenario.vehicle.bodies
    front = max(bodies[i].x for i in scenario.vehicle.wheelsets) - bodies[0].x
    return Course(
        front=front,
        end=scenario.distance + front,
        track_end=scenario.track.length + MARGIN,
        level=2.0 * scenario.contact.tape_circle / scenario.cant_base,
        origin=scenario.track.origin,
    )


def contributions(scenario):
    """Everything that displaces the rails: pairs of the distance of nodes it needs [m] and a function of s.

    The function takes arc lengths (n,) and gives values and slopes, each (rail, direction, n): right and left rail; to
    the right and down [m], [-]. What else moves the rails belongs here.
    """
    yield from irregularities(scenario)
    if scenario.track.widest(scenario.contact.gauge) > 0.0:
        yield WIDENING_SPACING, lambda s: widening(scenario, s)


def irregularities(scenario):
    """What of `contributions` is irregularity."""
    about = course(scenario)
    for source in scenario.irregularity:
        yield source.spacing, lambda s, source=source: source.displacement(s, about)


def irregularity(scenario, s):
    """Displacement of both rails at arc lengths s (n,) by irregularity alone: (rail, direction, n)."""
    return sum(moved(s)[0] for _, moved in irregularities(scenario))


def widening(scenario, s):
    """Displacement of the rails where the gauge of the alignment is not the nominal one, as a contribution."""
    value, slope = np.zeros((2, 2, s.size)), np.zeros((2, 2, s.size))
    half = 0.5 * WIDENING_SPACING
    behind, here, ahead = (scenario.track.shifts(s + d, scenario.contact.gauge) for d in (-half, 0.0, half))
    value[:, 0] = here[::-1]
    slope[:, 0] = (ahead - behind)[::-1] / WIDENING_SPACING
    return value, slope


def displacement(scenario, s):
    """Displacement of both rails at arc lengths s (n,): values and slopes, each (rail, direction, n)."""
    value, slope = np.zeros((2, 2, s.size)), np.zeros((2, 2, s.size))
    for _, moved in contributions(scenario):
        more, steeper = moved(s)
        value += more
        slope += steeper
    return value, slope


def grid(scenario):
    """Arc lengths of the nodes over the whole track, (n,) [m]."""
    spacing = max(min(spacing for spacing, _ in contributions(scenario)), LEAST_SPACING)
    start, end = -MARGIN, scenario.track.length + MARGIN
    count = math.ceil((end - start) / spacing) + 1
    if count > MOST_NODES:
        raise InputError(
            f"{scenario.name}: irregularity",
            f"needs a value every {spacing * 1e3:.3g} mm on {end - start:g} m of track, {count:,} of at most "
            f"{MOST_NODES:,}; shorten the track or lengthen the shortest wave or defect",
        )
    return np.linspace(start, end, count)


def constant(left, right):
    """As `pack`, of rails that stand aside by constant distances [m], positive to the right."""
    if left == 0.0 and right == 0.0:
        return NO_SHIFT, 0.0, 1.0
    rows = np.zeros((2, SHIFT_CHANNELS))
    rows[:, 0], rows[:, 4] = right, left
    return rows, -FAR, 2.0 * FAR


def pack(scenario):
    """Model.shift and the start and step of its rows [m].

    Raises
    ------
    InputError
        A rail bends more than a wheel can follow, or has too many nodes.
    """
    if not any(True for _ in contributions(scenario)):
        return NO_SHIFT, 0.0, 1.0
    s = grid(scenario)
    value, slope = displacement(scenario, s)
    _check_bend(scenario, s, slope)
    step = (s[-1] - s[0]) / (s.size - 1)
    rows = np.stack([value, slope], axis=2).reshape(SHIFT_CHANNELS, s.size).T
    return np.ascontiguousarray(rows), float(s[0]), float(step)


def _check_bend(scenario, s, slope):
    radius = max(max(scenario.vehicle.bodies[i].wheel_radii) for i in scenario.vehicle.wheelsets)
    bend = np.abs(np.diff(slope, axis=2)) / np.diff(s)
    for direction, name in enumerate(("lateral", "vertical")):
        rail, place = np.unravel_index(bend[:, direction].argmax(), bend[:, direction].shape)
        tightest, allowed = bend[rail, direction, place], TIGHTEST[name] / radius
        if tightest > allowed:
            raise InputError(
                f"{scenario.name}: irregularity",
                f"the {('right', 'left')[rail]} rail bends {name}ly with a radius of {1.0 / tightest:.3g} m at s = "
                f"{s[place]:.6g} m; a wheel of radius {radius:g} m follows down to {1.0 / allowed:.3g} m: lengthen the "
                "defect or its rounding, or lower it",
            )
