"""Traction and electric brake: the torque of the motors at each driven axle (docs/subsystems.md, 3)."""

from math import exp

from .assembly_layout import Valve
from .curve import read_curve
from .jit import kernel, seldom

FILL = Valve.FILL.value


@kernel
def wanted_torque(model, data, a, speed):
    """Torque asked of the motors of an axle at the speed of its tread; negative: the electric brake's [N m].

    The electric brake takes all it can of the brake's demand, fades out towards standstill, and lets an axle go whose
    slide protection acts.
    """
    assembly, train, axle, port = model.assembly[0], data.train[0], model.axle[a], data.port[a]
    wanted = 0.0
    if train["traction_demand"] > 0.0:
        share = train["traction_demand"] * port["torque_share"]
        wanted = share * max(read_curve(model.curve[assembly["envelope"]], speed)[0], 0.0)
    if assembly["electric"] >= 0 and train["brake_demand"] > 0.0 and port["valve"] == FILL:
        low, high = assembly["fade"][0], assembly["fade"][1]
        most = max(read_curve(model.curve[assembly["electric"]], speed)[0], 0.0)
        most *= min(max((speed - low) / (high - low), 0.0), 1.0)
        wanted -= min(most, train["brake_demand"] * axle["full_torque"])
    return wanted


@seldom
def drive(model, data, step):
    """Move the torques on by a step, behind a lag and a limit of their rate."""
    assembly = model.assembly[0]
    if assembly["envelope"] < 0:
        return
    share = 1.0 - exp(-step / assembly["lag"]) if assembly["lag"] > 0.0 else 1.0
    most = assembly["torque_rate"] * step
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        if not axle["driven"]:
            continue
        speed = abs(axle["radius"] * data.v[axle["wheelset"], 4])
        move = share * (wanted_torque(model, data, a, speed) - port["traction_torque"])
        port["traction_torque"] += min(max(move, -most), most) if most > 0.0 else move


@kernel
def electric_share(model, data):
    """Share of the full brake that the motors give at this instant [-]."""
    given = whole = 0.0
    for a in range(model.axle.size):
        given += max(-data.port[a]["traction_torque"], 0.0)
        whole += model.axle[a]["full_torque"]
    return given / whole if whole > 0.0 else 0.0


@seldom
def regulate(model, data):
    """Anti-slip: cut the torque of axles that turn faster than the slowest one, or speed up faster than it could be.
    """
    assembly = model.assembly[0]
    slowest = 1e300
    for a in range(model.axle.size):
        slowest = min(slowest, data.port[a]["speed"])
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        if not axle["driven"]:
            continue
        spins = port["speed"] - slowest > assembly["slip_cut"] or port["acceleration"] > assembly["spin_cut"]
        if spins:
            port["torque_share"] *= assembly["cut"]
        else:
            port["torque_share"] = min(port["torque_share"] + assembly["regrip"] * assembly["period"], 1.0)
