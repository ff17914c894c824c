"""Which dampers of a packed vehicle act implicitly in their rate (theory.md section 8.7)."""

from typing import NamedTuple

import numpy as np

from railcli.kernels.layout import Kind

ALONE = 0.25  # step times damping over the mass that feels it, beyond which a damper acts implicitly [-]
TOGETHER = 0.5  # the same, summed over all dampers of a body: twice within what an explicit step bears, which is 1
SHARE = 0.025  # dampers below this add nothing to such a sum that matters


class _Damper(NamedTuple):
    element: int
    axis: int  # which of the element's dampers
    lower: int
    upper: int
    own: tuple  # step times damping over the mass that lower and upper body set against it [-]


def mark_stiff(packed, step):
    """Elements of a packed vehicle in which each damper that is too stiff for an explicit step has a place.

    Parameters
    ----------
    packed : PackedVehicle
    step : float
        [s]

    Returns
    -------
    array of ELEMENT
        Dry friction always acts implicitly.
    """
    element = packed.element.copy()
    dampers = list(_dampers(packed, step))
    total = np.zeros(packed.body.size)
    for damper in dampers:
        total[[damper.lower, damper.upper]] += damper.own
    places = 0
    for damper in dampers:
        row, own = element[damper.element], sum(damper.own)
        crowded = own > SHARE and max(total[damper.lower], total[damper.upper]) > TOGETHER
        if own > ALONE or crowded or (row["kind"] == Kind.TORQUE and row["limit"] > 0.0):
            row["stiff"][damper.axis] = places
            row["dampers"] = 1
            places += 1
    element.flags.writeable = False
    return element


def _dampers(packed, step):
    for joint in packed.joint:
        for i in range(joint["first"], joint["first"] + joint["count"]):
            row = packed.element[i]
            for axis, direction in _lines(packed, joint, row):
                damping = steepest(packed, row, axis)
                if damping > 0.0 or (row["kind"] == Kind.TORQUE and row["limit"] > 0.0):
                    ease = [_ease(packed.body[joint[end]], row, end, direction) for end in ("lower", "upper")]
                    yield _Damper(i, axis, joint["lower"], joint["upper"], tuple(step * damping * one for one in ease))


def steepest(packed, row, axis):
    """Damping of an element along one of its axes, of a table that of its steepest segment [N s/m], [N m s/rad]."""
    if row["damper_curve"][axis] < 0:
        return float(row["c"][axis])
    curve = packed.curve[row["damper_curve"][axis]]
    n = curve["count"]
    return float((np.diff(curve["y"][:n]) / np.diff(curve["x"][:n])).max())


def _lines(packed, joint, row):
    """Axes of an element's dampers that have no state, with their directions in the nominal geometry."""
    if row["kind"] == Kind.TORQUE:
        yield 0, row["lower"]
    elif row["kind"] == Kind.LINK:
        if row["state"] < 0:
            ends = [packed.rest[joint[end], :3] + row[end] for end in ("lower", "upper")]
            yield 0, (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    elif row["kind"] in (Kind.BUSHING, Kind.AIR):
        for axis in range(3 if row["kind"] == Kind.BUSHING else 2):
            yield axis, np.eye(3)[axis]
    elif row["kind"] not in (Kind.MATRIX, Kind.DRY, Kind.DRY_LINK, Kind.LEAF):
        raise ValueError(f"element of unknown kind {row['kind']}")


def _ease(body, row, end, direction):
    """Acceleration of the end of an element along its direction per force in it [1/kg], [1/(kg m^2)]."""
    if row["kind"] == Kind.TORQUE:
        return float(np.sum(direction**2 / body["inertia"]))
    return float(1.0 / body["mass"] + np.sum(np.cross(row[end], direction) ** 2 / body["inertia"]))
