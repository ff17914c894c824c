"""The model put together: loads, accelerations, the integrator, and the door for Python (theory.md section 8)."""

from math import isfinite

from numba import types

from .adhesion import lend
from .assembly import act, over, resist, torques, watch_standing
from .body import drift, drift_on, frames, inertia_loads
from .curve import read_curve
from .implicit import answer, settle_tensions
from .jit import entry, kernel, seldom
from .layout import DATA_TYPE, MAX_CONTACT, MODEL_TYPE, Status
from .ledger import book
from .recording import BATCH, ROWS_TYPE, STREAM_TYPE, felt, flush, new_stream, note, open_row, take
from .slip import describe_patch, remember
from .support import CREEPING, agree, give_way, press, settle_drag, slip, slip_wheelset
from .suspension import suspension
from .vec3 import add, dot, get, scale, sub

THETA = 9.0 / 16.0  # place within the step at which creep forces are taken
ROUNDS = 12  # evaluations of the creep forces of a wheelset beyond the first
SHORTEST = 1.0 / 64.0  # share of a Newton step below which it is halved no more
SPIN_ARM = 0.5  # at which the spin of a wheelset counts as slip [m]
AGREED = 1e-6  # difference of the creep forces on a rail at rest from those that it bears [N]
AGREEMENTS = 40  # evaluations until then


@kernel
def speed_lack(model, data):
    """Speed asked for at this time less that of the first body along its track [m/s]."""
    curve = model.param[0]["speed_curve"]
    if curve >= 0:
        return read_curve(model.curve[curve], data.clock[0])[0] - data.rate[0, 0]
    return model.param[0]["speed"] - data.rate[0, 0]


@kernel
def hold_speed(model, data):
    """Pull the first body along its track tangent for its lack of speed (theory.md, 8.6); no side force."""
    force = model.param[0]["hold"] * speed_lack(model, data) + data.held[0]
    data.traction[0] = force
    data.load[0, 0] += force


@kernel
def loads(model, data, half_step, moving):
    """Everything from q, v and the dampers to data.load = M dv/dt. Returns a status.

    half_step, moving : as `suspension`.
    """
    status = frames(model, data)
    if status != 0:
        return status
    status = suspension(model, data, half_step, moving)
    if status != 0:
        return status
    if model.axle.size > 0:
        torques(model, data, THETA * model.param[0]["step"], moving)
    inertia_loads(model, data)
    step = model.param[0]["step"]
    if moving:
        status = press(model, data, THETA * step, (THETA - 0.5) * step)
    else:
        status = press(model, data, half_step, 0.0)
    if status != 0:
        return status
    slip(model, data, step if moving else 0.0)
    if moving and data.yielded.shape[0] > 0:
        status = settle_drag(model, data, step, THETA * step, (THETA - 0.5) * step)
        if status != 0:
            return status
    hold_speed(model, data)
    if model.axle.size > 0:
        resist(model, data)
    return 0


@kernel
def excess(model, data, i, dv, turn):
    """What the loads of wheelset i leave over M times its acceleration (dv, turn): force, moment, size.

    The size is the square of both, each over the inertia that it moves.
    """
    body, load = model.body[i], data.load
    mass, inertia = body["mass"], get(body["inertia"])
    force = (
        load[i, 0] - mass * dv[0],
        load[i, 1] - mass * dv[1],
        load[i, 2] - mass * dv[2],
    )
    moment = (
        load[i, 3] - inertia[0] * turn[0],
        load[i, 4] - inertia[1] * turn[1],
        load[i, 5] - inertia[2] * turn[2],
    )
    size = dot(force, force) / mass + (
        moment[0] * moment[0] / inertia[0] + moment[1] * moment[1] / inertia[1] + moment[2] * moment[2] / inertia[2]
    )
    return force, moment, size


@kernel
def unsettled(model, data, i, move, turn):
    """Whether a change of the velocity of wheelset i is too large for its creep forces to be taken as linear in it."""
    largest = max(max(abs(move[0]), abs(move[1])), max(abs(move[2]), abs(turn[0])))
    largest = max(largest, max(SPIN_ARM * abs(turn[1]), abs(turn[2])))
    return largest > model.param[0]["settled"] * max(abs(data.v[i, 0]), CREEPING)


@kernel
def accelerate(model, data, reach):
    """Fill data.dv from data.load; reach : theta h [s], 0 for the accelerations of this instant.

    Wheelsets take their creep forces at v0 + h (theta dv - (theta - 1/2) dv_start) by Newton's method. data.v holds
    that velocity for dv = dv_start, where the creep forces at hand were taken; one step of the method is enough unless
    it changes creepages noticeably.
    """
    load, dv = data.load, data.dv
    for i in range(model.body.size):
        body = model.body[i]
        mass, inertia = body["mass"], get(body["inertia"])
        if body["spins"] and reach > 0.0:
            u, w = (dv[i, 0], dv[i, 1], dv[i, 2]), (dv[i, 3], dv[i, 4], dv[i, 5])
            force, moment, size = excess(model, data, i, u, w)
            force, moment = answer(model, data, i, reach, force, moment)
            move, turn = scale(reach, force), scale(reach, moment)
            if unsettled(model, data, i, move, turn):
                first = first_wheel(model, i)
                if first >= 0:
                    settle(model, data, i, first, reach, size, move, turn)
                    continue
            u, w = add(u, force), add(w, moment)
        else:
            u = scale(1.0 / mass, (load[i, 0], load[i, 1], load[i, 2]))
            w = (load[i, 3] / inertia[0], load[i, 4] / inertia[1], load[i, 5] / inertia[2])
        for a in range(3):
            dv[i, a] = u[a]
            dv[i, 3 + a] = w[a]


@seldom
def settle(model, data, i, first, reach, size, move, turn):
    """Newton's method, damped, for the creep forces of wheelset i: fill its data.dv (theory.md section 8.3).

    first : its first wheel.  size : of the `excess` at data.v.  move, turn : the first change of that velocity.

    A step of the method that does not lessen the excess is halved, at most SHORTEST-fold; then the method goes on from
    where it stands. The best velocity so far counts when ROUNDS are over.
    """
    v, load = data.v, data.load
    rest = (load[i, 0], load[i, 1], load[i, 2]), (load[i, 3], load[i, 4], load[i, 5])
    rail = data.rail_load
    rest = sub(rest[0], (rail[i, 0], rail[i, 1], rail[i, 2])), sub(rest[1], (rail[i, 3], rail[i, 4], rail[i, 5]))
    start = (v[i, 0], v[i, 1], v[i, 2]), (v[i, 3], v[i, 4], v[i, 5])
    before = (data.dv[i, 0], data.dv[i, 1], data.dv[i, 2]), (data.dv[i, 3], data.dv[i, 4], data.dv[i, 5])
    good, good_turn = start
    best, best_turn, least = good, good_turn, size
    per_reach, share = 1.0 / reach, 1.0
    for _ in range(ROUNDS):
        at, at_turn = add(good, scale(share, move)), add(good_turn, scale(share, turn))
        for a in range(3):
            v[i, a], v[i, 3 + a] = at[a], at_turn[a]
            load[i, a], load[i, 3 + a] = rest[0][a], rest[1][a]
        slip_wheelset(model, data, first, reach / THETA)
        u = add(before[0], scale(per_reach, sub(at, start[0])))
        w = add(before[1], scale(per_reach, sub(at_turn, start[1])))
        force, moment, left = excess(model, data, i, u, w)
        if not left < size and share > SHORTEST:
            share *= 0.5
            continue
        force, moment = answer(model, data, i, reach, force, moment)
        good, good_turn, size, share = at, at_turn, left, 1.0
        move, turn = scale(reach, force), scale(reach, moment)
        if left < least:
            best, best_turn, least = at, at_turn, left
        if not unsettled(model, data, i, move, turn):
            best, best_turn = add(at, move), add(at_turn, turn)
            break
    u = add(before[0], scale(per_reach, sub(best, start[0])))
    w = add(before[1], scale(per_reach, sub(best_turn, start[1])))
    for a in range(3):
        data.dv[i, a], data.dv[i, 3 + a] = u[a], w[a]


@kernel
def first_wheel(model, i):
    """Number of the first of the wheels of wheelset i; -1 when it has none."""
    for w in range(model.wheel.size):
        if model.wheel[w]["body"] == i:
            return w
    return -1


@kernel
def step(model, data):
    """One step: midpoint rule, but for creep forces, which are implicit at THETA; one evaluation of the other loads."""
    h = model.param[0]["step"]
    half = 0.5 * h
    n = model.body.size
    if model.axle.size > 0:
        status = act(model, data)
        if status != 0:
            return status
    status = drift(model, data)
    if status != 0:
        return status
    for i in range(n):
        for k in range(6):
            data.q_start[i, k] = data.q[i, k]
            data.v_start[i, k] = data.v[i, k]
            data.dv_start[i, k] = data.dv[i, k]
            data.q[i, k] += half * data.rate[i, k]
            data.v[i, k] += half * data.dv[i, k]
    status = loads(model, data, half, True)
    if status != 0:
        return status
    accelerate(model, data, THETA * h)
    remember(model, data, h)
    if data.stiff.size > 0:
        settle_tensions(model, data, THETA * h)
    give_way(model, data, h, THETA)
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
    if model.axle.size > 0:
        book(model, data, h)
        watch_standing(data, h)
    data.held[0] += h * model.param[0]["hold"] * model.param[0]["hold_rate"] * speed_lack(model, data)
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
    """Loads and accelerations at data.q and data.v, nothing moved; half_step as `loads`. Returns a Status.

    Rails that give way have the rates data.yielding, after which their places are half_step on; creep forces on them
    are those that they bear.
    """
    if model.line.shape[0] > 0:
        lend(model, data, 0.0)
    status = loads(model, data, half_step, False)
    for _ in range(AGREEMENTS if data.yielded.shape[0] > 0 else 0):
        if status != 0 or agree(model, data) < AGREED:
            break
        status = loads(model, data, half_step, False)
    accelerate(model, data, 0.0)
    return status


@kernel
def write_row(model, data, rows, n):
    """Copy the present instant into row n; of a patch that is not there only the depth, zero."""
    rows.time[n] = data.clock[0]
    rows.traction[n] = data.traction[0]
    rows.train[n] = data.train[0]
    for a in range(model.axle.size):
        rows.port[n, a] = data.port[a]
    for i in range(model.body.size):
        for k in range(6):
            rows.q[n, i, k] = data.q[i, k]
            rows.v[n, i, k] = data.v[i, k]
        rows.acceleration[n, i, 0], rows.acceleration[n, i, 1], rows.acceleration[n, i, 2] = felt(model, data, i)
    for w in range(model.wheel.size):
        rows.rail[n, w] = data.rail[w]
        count = min(int(data.rail[w]["patches"]), MAX_CONTACT)
        for j in range(count):
            describe_patch(model.wheel[w], data.rail[w], data.contact[w, j])
            rows.contact[n, w, j] = data.contact[w, j]
        for j in range(count, MAX_CONTACT):
            rows.contact[n, w, j]["depth"] = 0.0


@entry(types.UniTuple(types.int64, 2)(MODEL_TYPE, DATA_TYPE, ROWS_TYPE, STREAM_TYPE, types.int64))
def record_rows(model, data, rows, stream, stride):
    """Advance, writing one row every `stride` steps; every step goes into it and into the stream.

    Returns the rows written and a Status.
    """
    share = 1.0 / stride
    for n in range(rows.time.size):
        open_row(rows, n)
        left = stride
        while left > 0:
            count = min(left, BATCH)
            for b in range(count):
                status = step(model, data)
                if status != 0:
                    if b > 0:
                        note(rows, n, stream, b, share)
                    return n, status
                take(model, data, stream, b)
            note(rows, n, stream, count, share)
            left -= count
        write_row(model, data, rows, n)
        if model.axle.size > 0 and over(model, data):
            return n + 1, 0
    return rows.time.size, 0


@entry(types.void(STREAM_TYPE))
def finish(stream):
    """Complete the stream of a run that is over."""
    flush(stream)


def record(model, data, rows, stride):
    """As `record_rows`, without a stream."""
    return record_rows(model, data, rows, new_stream(model), stride)
