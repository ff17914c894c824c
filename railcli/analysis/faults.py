"""What a status number of the core means, in words."""

import numpy as np

from railcli.kernels.layout import Status

_WHEEL_FAULTS = (Status.LEFT_TABLE, Status.DERAILED, Status.TOO_MANY_CONTACTS, Status.LEFT_SHIFT)


def wheel_name(system, wheel):
    """`W2 left` for the left wheel of the second wheelset."""
    side = "right" if system.model.wheel[wheel]["side"] > 0 else "left"
    return f"W{wheel // 2 + 1} {side}"


def sentence(system, data, status):
    """When, where, which wheel or body, what happened, what to do."""
    culprit = int(data.fault[0])
    when = f"t = {data.clock[0]:.3f} s, s = {data.q[0, 0]:.2f} m"
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
    name = system.bodies[culprit]
    if status == Status.LEFT_TRACK:
        return f"{when}: {name} ran off the end of the track"
    return f"{when}: the motion of {name} is no longer finite; try a smaller step or check the vehicle's stiffnesses"
