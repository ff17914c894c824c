"""The driver: demands over time, or a plan of permitted speeds and stops along the line (docs/subsystems.md, 1)."""

from math import sqrt

from .assembly_layout import Driver
from .curve import read_curve
from .jit import kernel, seldom

NEAR = 2.0  # distance from a stop within which standing counts as being there [m]
CREEPS = 0.3  # distance before a stop over which the brake is no longer eased [m]
STANDS = 0.01  # speed below which a vehicle stands [m/s]
SLOW_TRIM = 0.1  # share of `eager` with which the trim learns [-]
MOST_TRIM = 0.3  # [m/s^2]


@kernel
def ask(model, data, step):
    """Fill the demands of this step."""
    assembly, train, time = model.assembly[0], data.train[0], data.clock[0]
    if assembly["driver"] == Driver.LINE:
        follow(model, data, step)
        return
    if assembly["brake_curve"] >= 0:
        train["brake_demand"] = min(max(read_curve(model.curve[assembly["brake_curve"]], time)[0], 0.0), 1.0)
    if assembly["traction_curve"] >= 0:
        train["traction_demand"] = min(max(read_curve(model.curve[assembly["traction_curve"]], time)[0], 0.0), 1.0)


@kernel
def permitted(model, data, s, v):
    """Speed to run at and whether a braking curve sets it: the limit here, and curves to what lies ahead."""
    plan, train, brake = model.plan, data.train[0], model.assembly[0]["planned"]
    target, curve = 1e300, False
    for k in range(plan.shape[0]):
        place = plan[k]["place"]
        if place <= s:
            target, curve = plan[k]["speed"], False
    for k in range(plan.shape[0]):
        ahead = plan[k]["place"] - s
        stops = plan[k]["dwell"] > 0.0 and k >= train["next"]
        if ahead <= 0.0 and not stops:
            continue
        end = 0.0 if stops else plan[k]["speed"]
        most = sqrt(end * end + 2.0 * brake * max(ahead, 0.0))
        if most < target:
            target, curve = most, True
    return target, curve


@seldom
def follow(model, data, step):
    """Run after the permitted speed: acceleration in proportion to what lacks, and a slow trim; stop and dwell."""
    assembly, train, plan = model.assembly[0], data.train[0], model.plan
    s, v = data.q[0, 0], data.rate[0, 0]
    while train["next"] < plan.shape[0] and plan[train["next"]]["dwell"] <= 0.0:
        train["next"] += 1
    stop = train["next"]
    target, curve = permitted(model, data, s, v)
    train["target_speed"] = target
    if stop < plan.shape[0] and plan[stop]["place"] - s < NEAR and v < STANDS:
        train["dwelt"] += step
        train["brake_demand"], train["traction_demand"], train["trim"] = 1.0, 0.0, 0.0
        if train["dwelt"] >= plan[stop]["dwell"]:
            train["next"], train["dwelt"] = stop + 1, 0.0
        return
    if stop < plan.shape[0] and plan[stop]["place"] - s < CREEPS:
        train["brake_demand"] = max(train["brake_demand"], 0.3)
        train["traction_demand"] = 0.0
        return
    lack = target - v
    if abs(lack) < 1.0:
        trim = train["trim"] + step * SLOW_TRIM * assembly["eager"] * lack
        train["trim"] = min(max(trim, -MOST_TRIM), MOST_TRIM)
    asked = assembly["eager"] * lack + train["trim"]
    if curve and lack < 1.0:
        asked -= assembly["planned"]
    braking, driving = forces(model, data)
    force = asked * assembly["mass"]
    train["brake_demand"] = min(max(-force / braking, 0.0), 1.0) if braking > 0.0 else 0.0
    train["traction_demand"] = min(max(force / driving, 0.0), 1.0) if driving > 0.0 else 0.0


@kernel
def forces(model, data):
    """What full demand of brake and traction gives at this speed [N]."""
    assembly = model.assembly[0]
    braking = driving = 0.0
    v = abs(data.rate[0, 0])
    for a in range(model.axle.size):
        axle = model.axle[a]
        braking += axle["full_torque"] / axle["radius"]
        if axle["driven"] and assembly["envelope"] >= 0:
            driving += max(read_curve(model.curve[assembly["envelope"]], v)[0], 0.0) / axle["radius"]
    return braking, driving
