"""The model put together: loads, accelerations, the integrator, and the door for Python (theory.md section 8)."""

from math import isfinite

from numba import types

from .block import block, raise_diagonal, solve, times
from .body import drift, drift_on, frames, inertia_loads
from .contact import describe_patch, slip, touch
from .jit import entry, kernel
from .layout import DATA_TYPE, MAX_CONTACT, MODEL_TYPE, ROWS_TYPE, Status
from .suspension import suspension
from .vec3 import add, cross, get, scale


@kernel
def hold_speed(model, data):
    """Pull the first body along its track tangent with a force in proportion to its lack of speed; no side force."""
    param = model.param[0]
    force = param["hold"] * (param["speed"] - data.rate[0, 0])
    data.traction[0] = force
    data.load[0, 0] += force


@kernel
def loads(model, data, half_step):
    """Everything from q, v and the dampers to data.load = M dv/dt. Returns a status; half_step as `suspension`."""
    status = frames(model, data)
    if status != 0:
        return status
    suspension(model, data, half_step)
    inertia_loads(model, data)
    status = touch(model, data)
    if status != 0:
        return status
    slip(model, data)
    hold_speed(model, data)
    return 0


@kernel
def accelerate(model, data, half_step):
    """Fill data.dv from data.load; wheelsets with the damping of their creep forces implicit over half_step.

    (M + half_step C) dv = load + half_step C dv_last, C = -dload/dv of the creep forces, load taken at the velocity
    that dv_last predicts: one Newton step of the implicit midpoint rule.
    """
    c, load, dv = data.creep_damping, data.load, data.dv
    for i in range(model.body.size):
        body = model.body[i]
        mass, inertia = body["mass"], get(body["inertia"])
        force, moment = (load[i, 0], load[i, 1], load[i, 2]), (load[i, 3], load[i, 4], load[i, 5])
        if body["spins"] and half_step > 0.0:
            p, q = block(c, i, 0, 0, half_step), block(c, i, 0, 3, half_step)
            r, s = block(c, i, 3, 0, half_step), block(c, i, 3, 3, half_step)
            u, w = (dv[i, 0], dv[i, 1], dv[i, 2]), (dv[i, 3], dv[i, 4], dv[i, 5])
            force = add(force, add(times(p, u), times(q, w)))
            moment = add(moment, add(times(r, u), times(s, w)))
            u, w = solve(raise_diagonal(p, (mass, mass, mass)), q, r, raise_diagonal(s, inertia), force, moment)
        else:
            u = scale(1.0 / mass, force)
            w = (moment[0] / inertia[0], moment[1] / inertia[1], moment[2] / inertia[2])
        for a in range(3):
            dv[i, a] = u[a]
            dv[i, 3 + a] = w[a]


@kernel
def step(model, data):
    """One step of the implicit-explicit midpoint rule, second order, one evaluation of the loads."""
    h = model.param[0]["step"]
    half = 0.5 * h
    n = model.body.size
    status = drift(model, data)
    if status != 0:
        return status
    for i in range(n):
        for k in range(6):
            data.q_start[i, k] = data.q[i, k]
            data.v_start[i, k] = data.v[i, k]
            data.q[i, k] += half * data.rate[i, k]
            data.v[i, k] += half * data.dv[i, k]
    status = loads(model, data, half)
    if status != 0:
        return status
    accelerate(model, data, half)
    for i in range(n):
        for k in range(6):
            data.v[i, k] = data.v_start[i, k] + half * data.dv[i, k]
    drift_on(model, data)
    for i in range(n):
        for k in range(6):
            data.q[i, k] = data.q_start[i, k] + h * data.rate[i, k]
            data.v[i, k] = data.v_start[i, k] + h * data.dv[i, k]
        if not isfinite(data.q[i, 1] + data.q[i, 2] + data.v[i, 4]):
            data.fault[0] = i
            return Status.NOT_FINITE.value
    for k in range(data.damper.size):
        data.damper[k] += h * data.damper_rate[k]
    data.clock[0] += h
    return 0


@kernel
def core(model, data, n_steps):
    """Advance by n_steps; returns the status of the last one. After a fault q and v are those of its midpoint."""
    for _ in range(n_steps):
        status = step(model, data)
        if status != 0:
            return status
    return 0


@entry(types.int64(MODEL_TYPE, DATA_TYPE, types.int64))
def advance(model, data, n_steps):
    """Advance by n_steps; returns a Status."""
    return core(model, data, n_steps)


@entry(types.int64(MODEL_TYPE, DATA_TYPE, types.float64))
def evaluate(model, data, half_step):
    """Loads and accelerations at data.q and data.v, nothing moved; half_step as `loads`. Returns a Status."""
    status = loads(model, data, half_step)
    accelerate(model, data, 0.0)
    return status


@kernel
def write_row(model, data, rows, n):
    """Copy the present instant into row n."""
    gravity = model.param[0]["gravity"]
    rows.time[n] = data.clock[0]
    rows.traction[n] = data.traction[0]
    for i in range(model.body.size):
        for k in range(6):
            rows.q[n, i, k] = data.q[i, k]
            rows.v[n, i, k] = data.v[i, k]
        frame, speed = data.frame[i], data.rate[i, 0]
        carried = cross(scale(speed, get(frame["rate"])), (data.v[i, 0], data.v[i, 1], data.v[i, 2]))
        for a in range(3):
            rows.acceleration[n, i, a] = data.dv[i, a] + carried[a] - gravity * frame["track"][2, a]
        rows.acceleration[n, i, 2] += gravity
    for w in range(model.wheel.size):
        rows.rail[n, w] = data.rail[w]
        for j in range(MAX_CONTACT):
            describe_patch(model.wheel[w], data.contact[w, j])
            rows.contact[n, w, j] = data.contact[w, j]


@entry(types.UniTuple(types.int64, 2)(MODEL_TYPE, DATA_TYPE, ROWS_TYPE, types.int64))
def record(model, data, rows, stride):
    """Advance, writing one row every `stride` steps. Returns the rows written and a Status."""
    for n in range(rows.time.size):
        status = core(model, data, stride)
        if status != 0:
            return n, status
        write_row(model, data, rows, n)
    return rows.time.size, 0
