"""Wheelsets on their rails: in their place, or on springs and dampers that give way (theory.md section 6.6).

Each rail under a wheel is massless and moves to the right and down, u, with the rate w: c w + k u = force of the wheel.
Both follow from that balance within the step, since the contact is far stiffer than the rail's support.
Track axes at the wheelset's own s.
"""

from math import sqrt

from .contact import touch, touch_wheel
from .jit import kernel, seldom
from .shift import rail_axes, turned
from .slip import slip_wheel

TRIES = 60  # of the balance of a rail
LEFT, LEFT_AT_REST = 1e-2, 1e-6  # force that may stay unbalanced within a step, and where none is taken [N]
SINK = 1e-3  # largest move of one try [m]
SHORTEST_MOVE = 1.0 / 8.0  # share of it below which it is halved no more
SINGULAR = 1e-2  # of the determinant that the patches' own slopes give: what is below is not believed
REPEATS = 8  # of normal and creep forces within a step
LAGGING = 20.0  # difference of the creep forces on a rail from those that its normal forces know, not worth one [N]
ROUNDS = 12  # evaluations of the creep forces of one wheel on a rail that moves
SHORTEST = 1.0 / 64.0  # share of a Newton step below which it is halved no more
CREEPING = 1e-3  # speed that counts where a wheelset is slower, in the tolerance of its creep forces [m/s]
AT_REST = 1e-5  # finer tolerance of creepages where no step is taken, over that within a step


@kernel
def press(model, data, reach, lead):
    """Normal contact of every wheel; where rails give way, their place and rate besides. Returns a status.

    reach, lead : a rail's place is u + reach w - lead w_before, both [s].
    """
    if data.yielded.shape[0] == 0:
        return touch(model, data)
    for w in range(model.wheel.size):
        status = yield_rail(model, data, w, reach, lead)
        if status != 0:
            return status
    return 0


@kernel
def solve_pair(yy, yz, zy, zz, y, z):
    """u, w with yy u + yz w = y and zy u + zz w = z."""
    per = 1.0 / (yy * zz - yz * zy)
    return per * (zz * y - yz * z), per * (yy * z - zy * y)


@kernel
def pushed(model, data, w, reach):
    """Normal forces of wheel w on its rail, right and down, and how they fall with the rate of that (yy, yz, zz)."""
    rail = data.rail[w]
    shifted = model.shift.shape[0] > 0
    found = int(rail["patches"])
    y = z = yy = yz = zz = 0.0
    for j in range(found):
        contact = data.contact[w, j]
        n, slope = contact["normal"], contact["slope"]
        if not n > 0.0:
            continue
        cosine = 1.0 / sqrt(1.0 + slope * slope)
        normal = (0.0, -slope * cosine, cosine)
        if shifted:
            normal = turned(rail_axes(rail), normal)
        y, z = y + n * normal[1], z + n * normal[2]
        fall = contact["stiffness"] * reach + contact["viscosity"]
        yy, yz, zz = (
            yy + fall * normal[1] * normal[1],
            yz + fall * normal[1] * normal[2],
            zz + fall * normal[2] * normal[2],
        )
    return y, z, yy, yz, zz


@seldom
def yield_rail(model, data, w, reach, lead):
    """Normal contact of wheel w where its rail bears it: Broyden's method for the rail's rate. Returns a status.

    It begins with the slope of each patch along its own normal and learns what that leaves out, such as patches that
    merge. A move that does not lessen what is left is halved. Creep forces count as in data.dragged; what they change
    is up to `slip_yielding`.
    """
    ky, kz = model.param[0]["rail_stiffness"][0], model.param[0]["rail_stiffness"][1]
    cy, cz = model.param[0]["rail_damping"][0], model.param[0]["rail_damping"][1]
    before = data.yielding[w]
    base_y, base_z = data.yielded[w, 0] - lead * before[0], data.yielded[w, 1] - lead * before[1]
    rate_y, rate_z = (before[0], before[1]) if lead > 0.0 else (0.0, 0.0)
    enough = LEFT if lead > 0.0 else LEFT_AT_REST
    support = data.support[w]
    good_y = good_z = good_rest_y = good_rest_z = move_y = move_z = 0.0
    jyy = jyz = jzy = jzz = 0.0
    least, share = -1.0, 1.0
    for left in range(TRIES, 0, -1):
        at_y, at_z = base_y + reach * rate_y, base_z + reach * rate_z
        status = touch_wheel(model, data, w, at_y, at_z, rate_y, rate_z)
        if status != 0:
            return status
        push_y, push_z, yy, yz, zz = pushed(model, data, w, reach)
        yy, zz = yy + cy + reach * ky, zz + cz + reach * kz
        rest_y = push_y + data.dragged[w, 0] - ky * at_y - cy * rate_y
        rest_z = push_z + data.dragged[w, 1] - kz * at_z - cz * rate_z
        support["push"][0], support["push"][1] = push_y, push_z
        support["first"][0], support["first"][1] = rate_y, rate_z
        support["rate"][0], support["rate"][1] = rate_y, rate_z
        support["impedance"][0], support["impedance"][1], support["impedance"][2] = yy, yz, zz
        if left == 1 or max(abs(rest_y), abs(rest_z)) < enough:
            break
        size = rest_y * rest_y + rest_z * rest_z
        if least < 0.0:
            jyy, jyz, jzy, jzz = yy, yz, yz, zz
        else:
            step_y, step_z = rate_y - good_y, rate_z - good_z
            per = 1.0 / max(step_y * step_y + step_z * step_z, 1e-300)
            miss_y = per * (good_rest_y - rest_y - jyy * step_y - jyz * step_z)
            miss_z = per * (good_rest_z - rest_z - jzy * step_y - jzz * step_z)
            jyy, jyz = jyy + miss_y * step_y, jyz + miss_y * step_z
            jzy, jzz = jzy + miss_z * step_y, jzz + miss_z * step_z
            if not jyy * jzz - jyz * jzy > SINGULAR * yy * zz:
                jyy, jyz, jzy, jzz = yy, yz, yz, zz
        if least >= 0.0 and not size < least and share > SHORTEST_MOVE:
            share *= 0.5
            rate_y, rate_z = good_y + share * move_y, good_z + share * move_z
            continue
        good_y, good_z, good_rest_y, good_rest_z, least, share = rate_y, rate_z, rest_y, rest_z, size, 1.0
        move_y, move_z = solve_pair(jyy, jyz, jzy, jzz, rest_y, rest_z)
        most = min(1.0, SINK / max(reach * max(abs(move_y), abs(move_z)), 1e-300))
        move_y, move_z = most * move_y, most * move_z
        rate_y, rate_z = rate_y + move_y, rate_z + move_z
    return 0


@kernel
def slip(model, data, step):
    """Creep of every loaded patch: complete data.contact and data.rail, add both to data.load.

    step : time since data.lag was remembered [s]; 0 for creep forces that are settled. Fills data.rail_load and
        data.creep_damping on the way.
    """
    for w in range(model.wheel.size):
        if w == 0 or model.wheel[w]["body"] != model.wheel[w - 1]["body"]:
            slip_wheelset(model, data, w, step)


@kernel
def slip_wheelset(model, data, first, step):
    """`slip` of the body whose wheels are first and first + 1 (or first alone, without another), at data.v."""
    block = data.creep_damping
    i = model.wheel[first]["body"]
    for a in range(6):
        data.rail_load[i, a] = 0.0
        for b in range(6):
            block[i, a, b] = 0.0
    for w in range(first, min(first + 2, model.wheel.size)):
        if model.wheel[w]["body"] != i:
            continue
        if data.yielded.shape[0] == 0:
            slip_wheel(model, data, w, step, 0.0, 0.0, block, i)
        else:
            slip_yielding(model, data, w, step)
    for a in range(6):
        data.load[i, a] += data.rail_load[i, a]


@seldom
def slip_yielding(model, data, w, step):
    """`slip_wheel` on a rail that gives way: Newton's method for its rate, damped as that for the wheelset.

    The rate moves from that of `yield_rail` by what the creep forces on the rail have changed since, over its
    impedance. Adds to data.creep_damping what is left of it when the rail follows the wheelset.
    """
    i, support, block = model.wheel[w]["body"], data.support[w], data.wheel_damping
    yy, yz, zz = support["impedance"][0], support["impedance"][1], support["impedance"][2]
    first_y, first_z = support["first"][0], support["first"][1]
    dragged_y, dragged_z = data.dragged[w, 0], data.dragged[w, 1]
    speed = max(abs(data.v[i, 0]), CREEPING)
    enough = model.param[0]["settled"] * speed * (1.0 if step > 0.0 else AT_REST)
    good_y, good_z = support["rate"][0], support["rate"][1]
    at_y, at_z, share, size = good_y, good_z, 1.0, 1e300
    load = data.rail_load
    before = (load[i, 0], load[i, 1], load[i, 2], load[i, 3], load[i, 4], load[i, 5])
    move_y = move_z = 0.0
    for left in range(ROUNDS, 0, -1):
        for a in range(6):
            load[i, a] = before[a]
            for b in range(6):
                block[w, a, b] = 0.0
        slip_wheel(model, data, w, step, at_y, at_z, block, w)
        drag_y = before[1] - load[i, 1] - support["push"][0]
        drag_z = before[2] - load[i, 2] - support["push"][1]
        off_y, off_z = at_y - first_y, at_z - first_z
        rest_y = drag_y - dragged_y - yy * off_y - yz * off_z
        rest_z = drag_z - dragged_z - yz * off_y - zz * off_z
        rest = rest_y * rest_y / yy + rest_z * rest_z / zz
        if left > 1 and not rest < size and share > SHORTEST:
            share *= 0.5
            at_y, at_z = good_y + share * move_y, good_z + share * move_z
            continue
        stiff_y, stiff_z = yy + block[w, 1, 1], zz + block[w, 2, 2]
        stiff_yz, stiff_zy = yz + block[w, 1, 2], yz + block[w, 2, 1]
        move_y, move_z = solve_pair(stiff_y, stiff_yz, stiff_zy, stiff_z, rest_y, rest_z)
        good_y, good_z, size, share = at_y, at_z, rest, 1.0
        if left == 1 or max(abs(move_y), abs(move_z)) <= enough:
            break
        at_y, at_z = good_y + move_y, good_z + move_z
    support["rate"][0], support["rate"][1] = good_y + move_y, good_z + move_z
    for a in range(6):
        load[i, a] += block[w, a, 1] * move_y + block[w, a, 2] * move_z
    support["drag"][0] = before[1] - load[i, 1] - support["push"][0]
    support["drag"][1] = before[2] - load[i, 2] - support["push"][1]
    rail = data.rail[w]
    rail["x"], rail["y"], rail["q"] = before[0] - load[i, 0], before[1] - load[i, 1], before[2] - load[i, 2]
    stiff_y, stiff_z = yy + block[w, 1, 1], zz + block[w, 2, 2]
    stiff_yz, stiff_zy = yz + block[w, 1, 2], yz + block[w, 2, 1]
    for b in range(6):
        y, z = solve_pair(stiff_y, stiff_yz, stiff_zy, stiff_z, block[w, 1, b], block[w, 2, b])
        support["follow"][0, b], support["follow"][1, b] = y, z
    for a in range(6):
        for b in range(6):
            yielded = block[w, a, 1] * support["follow"][0, b] + block[w, a, 2] * support["follow"][1, b]
            data.creep_damping[i, a, b] += block[w, a, b] - yielded


@seldom
def settle_drag(model, data, step, reach, lead):
    """Normal and creep forces on rails once more, until each knows the other; step, reach, lead as above.

    Returns a status.
    """
    for _ in range(REPEATS):
        most = 0.0
        for w in range(data.yielded.shape[0]):
            for c in range(2):
                most = max(most, abs(data.support[w]["drag"][c] - data.dragged[w, c]))
        if most < LAGGING:
            break
        for w in range(data.yielded.shape[0]):
            data.dragged[w, 0], data.dragged[w, 1] = data.support[w]["drag"][0], data.support[w]["drag"][1]
        for w in range(model.wheel.size):
            i = model.wheel[w]["body"]
            if w > 0 and i == model.wheel[w - 1]["body"]:
                continue
            for a in range(6):
                data.load[i, a] -= data.rail_load[i, a]
        status = press(model, data, reach, lead)
        if status != 0:
            return status
        slip(model, data, step)
    return 0


@kernel
def give_way(model, data, step, theta):
    """Move the rails on by a step: their rates as they are at the velocity that the wheelsets take theta of it on."""
    for w in range(data.yielded.shape[0]):
        i, support, rail = model.wheel[w]["body"], data.support[w], data.rail[w]
        more_y = more_z = 0.0
        for a in range(6):
            at = data.v_start[i, a] + step * (theta * data.dv[i, a] - (theta - 0.5) * data.dv_start[i, a])
            more_y += support["follow"][0, a] * (at - data.v[i, a])
            more_z += support["follow"][1, a] * (at - data.v[i, a])
        yy, yz, zz = support["impedance"][0], support["impedance"][1], support["impedance"][2]
        data.dragged[w, 0] = support["drag"][0] + yy * more_y + yz * more_z
        data.dragged[w, 1] = support["drag"][1] + yz * more_y + zz * more_z
        for c in range(2):
            more = more_y if c == 0 else more_z
            rate, before = support["rate"][c] + more, data.yielding[w, c]
            at = data.yielded[w, c] + step * (theta * rate - (theta - 0.5) * before)
            stiffness, damping = model.param[0]["rail_stiffness"][c], model.param[0]["rail_damping"][c]
            data.yielded[w, c] += step * rate
            data.yielding[w, c] = rate
            rail["give"][c], rail["seat"][c] = data.yielded[w, c], stiffness * at + damping * rate


@kernel
def agree(model, data):
    """Take the creep forces on the rails as those that they have borne; returns by how much they differed [N]."""
    most = 0.0
    for w in range(data.yielded.shape[0]):
        support = data.support[w]
        for c in range(2):
            most = max(most, abs(support["drag"][c] - data.dragged[w, c]))
            data.dragged[w, c] = support["drag"][c]
            data.yielding[w, c] = support["rate"][c]
    return most
