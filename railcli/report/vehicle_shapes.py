"""Outlines of a vehicle for a moving picture: who stands on whom, and how large each body is drawn.

Files give no outlines. Bodies are drawn as boxes over what they stand on; only wheels, axles and the places of the
bodies are true to scale.
"""

from dataclasses import dataclass

import numpy as np

WHEEL_INSIDE, WHEEL_OUTSIDE = -0.070, 0.065  # width of a wheel about its tape circle [m]
FLANGE = 0.030  # height and thickness of a flange [m]
OVERHANG, BOGIE_OVERHANG = 3.0, 0.5  # of a box over the outermost body that it stands on [m]
HALF_WIDTH, BOGIE_HALF_WIDTH = 1.45, 1.15  # [m]
BOGIE_HALF_HEIGHT = 0.18  # [m]
ROOF, FLOOR = 3.7, 1.1  # of a box that carries no other, above the rails [m]
ALONE = 1.0  # half length of a box that stands on nothing [m]
PART = 0.35, 0.45, 0.25  # half length, width and height of what belongs to one wheelset: motors, axle boxes [m]


@dataclass(frozen=True)
class Shape:
    """A body as it is drawn.

    Attributes
    ----------
    kind : {"wheelset", "bogie", "body"}
        A bogie stands on something and carries something.
    above : array (n, 2)
        Outline seen from above, in the axes of the body: forward, right [m].
    behind : array (n, 2)
        Outline seen from behind: right, down [m].
    """

    kind: str
    above: np.ndarray
    behind: np.ndarray


def shapes(vehicle, tape_circle):
    """Shape of every body, by name.

    Parameters
    ----------
    vehicle : Vehicle
    tape_circle : float
        Distance of the tape circles from the middle of a wheelset [m].
    """
    parents = carriers_of(vehicle)
    found = {}
    for body in vehicle.bodies:
        if body.is_wheelset:
            found[body.name] = Shape("wheelset", *_wheelset(body.wheel_radius, tape_circle))
            continue
        below = [other for other in vehicle.bodies if parents.get(other.name) == body.name]
        carried = body.name in parents
        if carried and (not below or body.y != 0.0):
            length, width, height = PART
            found[body.name] = Shape("bogie", _box(-length, length, width), _box_behind(width, -height, height))
            continue
        overhang = BOGIE_OVERHANG if carried else OVERHANG
        length = max((abs(other.x - body.x) for other in below), default=ALONE - overhang) + overhang
        width = BOGIE_HALF_WIDTH if carried else HALF_WIDTH
        top, bottom = -BOGIE_HALF_HEIGHT, BOGIE_HALF_HEIGHT
        if not carried:
            top, bottom = min(top, body.height - ROOF), max(bottom, body.height - FLOOR)
        found[body.name] = Shape(
            "bogie" if carried else "body", _box(-length, length, width), _box_behind(width, top, bottom)
        )
    return found


def carriers_of(vehicle):
    """Name of each body that stands under another -> that other one; the first joint that says so counts."""
    parents = {}
    for joint in vehicle.joints:
        for lower, upper in joint.pairs:
            parents.setdefault(lower, upper)
    return parents


def chain(vehicle, name):
    """A body, what stands on it, what stands on that, and so on."""
    parents, found = carriers_of(vehicle), [name]
    while parents.get(found[-1]) not in (None, *found):
        found.append(parents[found[-1]])
    return found


def _box(start, end, width):
    return np.array([(start, -width), (end, -width), (end, width), (start, width), (start, -width)])


def _box_behind(width, top, bottom):
    return np.array([(-width, top), (width, top), (width, bottom), (-width, bottom), (-width, top)])


def _wheelset(radius, tape_circle):
    """An axle with two wheels; gaps (NaN) part its three outlines."""
    gap = np.full((1, 2), np.nan)
    inside, outside = tape_circle + WHEEL_INSIDE, tape_circle + WHEEL_OUTSIDE
    above, behind = [], []
    for side in (1.0, -1.0):
        wheel = _box(-radius, radius, 1.0)
        wheel[:, 1] = side * np.where(wheel[:, 1] < 0.0, inside, outside)
        half = [(inside, radius + FLANGE), (inside + 0.6 * FLANGE, radius + FLANGE), (inside + FLANGE, radius),
                (outside, radius)]  # fmt: skip
        rim = np.array([*half, *((y, -z) for y, z in half[::-1]), half[0]])
        above += [wheel, gap]
        behind += [rim * (side, 1.0), gap]
    axle = np.array([(0.0, -inside), (0.0, inside)])
    return np.concatenate([*above, axle]), np.concatenate([*behind, axle[:, ::-1]])
