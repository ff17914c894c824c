"""The subsystems on a vehicle that only runs and turns its wheels: one mass, spinning wheelsets.

docs/subsystems.md, 8. It has the ports, the subsystems and the creep law of the whole model, and nothing else: no
load transfer, the same patch all along. It is there to hold the subsystems to closed forms and to independent
programs.
"""

import numpy as np
from numba import types

from .adhesion import ADHESION, DECAY, FRICTION, RATIO, SLIP
from .assembly import act, watch_standing
from .creep import falling_friction
from .jit import constant, entry, kernel
from .layout import DATA_TYPE, MODEL_TYPE
from .polach import forces_and_jacobian

SLOWEST = 0.5  # speed by which slip is divided where the vehicle runs slower [m/s]


@kernel
def rolling_force(grip, patch, load, slip, speed):
    """Creep force against the slip of one wheel, and its slope over the slip velocity [N, N s/m].

    patch : semi-axes [m] and Kalker's f11 [N], f22 [N], f23 [N m], f33 [N m^2].
    """
    friction, fall = grip[FRICTION], 0.0
    if grip[DECAY] > 0.0:
        friction, fall = falling_friction(grip[RATIO], grip[DECAY], friction, abs(slip))
    per = 1.0 / max(speed, SLOWEST)
    limit = friction * load
    found = forces_and_jacobian(
        grip[ADHESION], grip[SLIP], patch[0], patch[1], patch[2], patch[3], patch[4], patch[5], limit, -slip * per,
        0.0, 0.0,
    )  # fmt: skip
    force, by_creepage = found[0], found[3]
    by_limit = (force + by_creepage * slip * per) / limit if limit > 0.0 else 0.0  # homogeneous of degree one
    slope = -by_creepage * per + by_limit * load * fall * (1.0 if slip >= 0.0 else -1.0)
    return force, slope


@kernel
def roll(model, data, patch, load):
    """One step: the spin of each wheelset implicit in its slip at the end of it, the same forces on the vehicle.

    load : vertical force of a wheel [N].
    """
    step, train = model.param[0]["step"], data.train[0]
    status = act(model, data)
    if status != 0:
        return status
    start = data.v[0, 0]
    speed = max(start + step * data.dv[0, 0], 0.0)  # at the end of the step, as the last one lets expect
    total, mass = 0.0, 0.0
    for i in range(model.body.size):
        mass += model.body[i]["mass"]
    lost = braked = 0.0
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        i, radius = axle["wheelset"], axle["radius"]
        inertia = model.body[i]["inertia"][1]
        spin = -data.v[i, 4]
        force = slope = 0.0
        for w in range(axle["first"], axle["first"] + 2):
            slip = speed - radius * spin
            one, rise = rolling_force(data.rail[w]["grip"], patch, load, slip, speed)
            force, slope = force + one, slope + rise
            contact = data.contact[w, 0]
            contact["creep_x"], contact["slip_x"], data.rail[w]["patches"] = -one, slip, 1.0
        most = port["brake_limit"]
        stiff = inertia + step * radius * radius * slope
        free = step * (radius * force + port["traction_torque"]) / stiff
        move = free - step * most / stiff
        if spin + move < 0.0:  # the brake holds what it has stopped
            move = -spin
        torque = stiff * (free - move) / step
        after = spin + move
        force -= slope * radius * move
        data.v[i, 4] = -after
        middle = 0.5 * (spin + after)
        port["brake_torque"], port["slide"] = torque, (speed - radius * after) / max(speed, SLOWEST)
        port["used"] = force / (2.0 * load)
        braked += step * torque * middle
        total += force
        lost -= step * force * radius * middle
        if speed > 5.0 / 3.6 and radius * after < 0.05 * speed:
            port["locked"] += step
    data.dv[0, 0] = -total / mass
    after = start + step * data.dv[0, 0]
    middle = 0.5 * (start + after)
    lost += step * total * middle
    train["creep_loss"] += lost
    train["brake_loss"] += braked
    data.v[0, 0] = after
    data.rate[0, 0] = after
    for i in range(model.body.size):
        data.v[i, 0] = after
        data.q[i, 0] += step * middle
        data.q[i, 4] += step * data.v[i, 4]
    data.clock[0] += step
    watch_standing(data, step)
    return 0


@entry(types.int64(MODEL_TYPE, DATA_TYPE, constant(np.float64), types.float64, types.int64))
def coast(model, data, patch, load, most):
    """Advance until the vehicle stands, at most by so many steps; returns the steps made, -1 after a guest's fault."""
    for n in range(most):
        if roll(model, data, patch, load) != 0:
            return -1
        if data.train[0]["stop_time"] >= 0.0:
            return n + 1
    return most
