"""What a status number of the core means, in words; and whether it is the vehicle's or the time step's doing."""

import math

import numpy as np

from railcli.kernels.assembly_layout import Valve
from railcli.kernels.layout import Data, Status
from railcli.kernels.step import advance

FINER = 4  # a fault is followed once more at the step over this
BEYOND = 0.5  # time for which it must stay away beyond the moment at which it came [s]

_WHEEL_FAULTS = (Status.LEFT_TABLE, Status.DERAILED, Status.TOO_MANY_CONTACTS, Status.LEFT_SHIFT)
_ENDS = (Status.OK, Status.LEFT_TRACK, Status.LEFT_SHIFT, Status.GUEST)  # the way may end; the motion does not fail


def wheel_name(system, wheel):
    """`W2 left` for the left wheel of the second wheelset."""
    side = "right" if system.model.wheel[wheel]["side"] > 0 else "left"
    return f"W{wheel // 2 + 1} {side}"


def sentence(system, data, status):
    """When, where, which wheel or body, what happened, what to do."""
    culprit = int(data.fault[0])
    when = _when(data)
    if status in _WHEEL_FAULTS:
        body = system.model.wheel[culprit]["body"]
        _, y, z, roll, _, yaw = data.q[body]
        pose = f"y = {y * 1e3:.1f} mm, roll = {roll * 1e3:.1f} mrad, yaw = {yaw * 1e3:.1f} mrad"
        wheel = system.model.wheel[culprit]
        z = z - data.rail[culprit]["vertical"]
        lift = -(z + wheel["side"] * wheel["lateral"] * np.sin(roll) + wheel["radius"] * np.cos(roll))
        what = {
            Status.LEFT_TABLE: f"left the contact table ({pose})",
            Status.DERAILED: f"derailed: its tape circle stands {1e3 * lift:.1f} mm over the rail ({pose})",
            Status.TOO_MANY_CONTACTS: f"has more contact patches at once than the core keeps ({pose})",
            Status.LEFT_SHIFT: "ran beyond the stretch on which the displacement of its rail is given",
        }[status]
        return f"{when}: wheel {wheel_name(system, culprit)} {what}"
    if status == Status.UNKNOWN_ELEMENT:
        kind = system.model.element[culprit]["kind"]
        return f"{when}: force element {culprit + 1} is of kind {kind}, which the core does not know"
    if status == Status.GUEST:
        return f"{when}: {guest_fault(data)}"
    name = system.bodies[culprit]
    if status == Status.LEFT_TRACK:
        return f"{when}: {name} ran off the end of the track"
    return f"{when}: the motion of {name} is no longer finite; try a smaller step or check the vehicle's stiffnesses"


def guest_fault(data):
    """Sentence of a guest that did what it may not."""
    fault = int(data.fault[0])
    if fault == 0:
        return "the guest went beyond its arrays"
    known = ", ".join(f"{valve.value} {valve.name.lower()}" for valve in Valve)
    return f"the guest gave axle {fault} a command that is none: a valve is {known}, a torque share 0 to 1"


def copied(data):
    """A copy of Data, to go back to."""
    return Data(*(array.copy() for array in data))


def verdict(system, data, status, kept):
    """The sentence of a fault; of one that a finer step does not know, only that the step is too long.

    Parameters
    ----------
    system : System
    data : Data
        As the fault left it.
    status : int
        Not OK.
    kept : Data
        A state from before the fault; it moves.
    """
    since, step = float(kept.clock[0]), float(system.model.param[0]["step"])
    finer = step / FINER
    time = float(data.clock[0]) - since + BEYOND
    again = advance(system.stepped(finer).model, kept, math.ceil(time / finer))
    if again == status or again not in _ENDS:
        return sentence(system, data, status)
    return (
        f"{_when(data)}: numerically unstable, use step_ms <= {finer * 1e3:.4g}; at {step * 1e3:.4g} ms the motion "
        f"fails here, followed once more from t = {since:.3f} s at {finer * 1e3:.4g} ms it does not"
    )


def _when(data):
    return f"t = {data.clock[0]:.3f} s, s = {data.q[0, 0]:.2f} m"
