"""Slip of wheels over rails: creepages, creep forces and their slopes (theory.md sections 7 and 8.3).

Track axes at the wheelset's own s; forces are those on the wheel.
"""

from math import atan, sqrt

from .adhesion import ADHESION, DECAY, FRICTION, RATIO, SLIP
from .creep import falling_friction, tangential
from .jit import kernel, seldom
from .layout import MAX_CONTACT
from .shift import IDEAL, rail_axes, turned
from .vec3 import add, cross, dot, get, scale, sub

SLIDING = 10.0  # times the creepage of full slip in linear theory: no patch remembers more, once it slides no more
SOFTNESS = 1e-4  # time over which the spring of a patch at rest is damped: 7 % of critical at 220 Hz [s]
SAME_PATCH = 3e-3  # distance on the wheel profile within which patches of two steps are the same [m]


@kernel
def slip_wheel(model, data, w, step, rate_y, rate_z, block, k):
    """Creep of the loaded patches of wheel w: complete data.contact and data.rail, add to data.rail_load, at data.v.

    step : time since data.lag was remembered [s]; 0 for creep forces that are settled.
    rate_y, rate_z : how fast the rail gives way, to the right and down [m/s].
    block : its block k gets -d load / d v of the creep forces added, the rail's rate held.

    The rail's direction at the contact differs from that of the track frame by its own slopes and bend,
    and by the frame's rotation and motion per metre: by curvature ahead of the axle, and on a cant ramp by the slope of
    each rail. Running backwards turns the contact axes x and t with the rolling direction.
    """
    param = model.param[0]
    shifted = model.shift.shape[0] > 0
    wheel, rail = model.wheel[w], data.rail[w]
    i = wheel["body"]
    patches = int(rail["patches"])
    if patches == 0:
        return
    frame = data.frame[i]
    sr, sy, cr, cy = frame["sine"][0], frame["sine"][2], frame["cosine"][0], frame["cosine"][2]
    forward, axle, down = (cy, sy, 0.0), (-sy * cr, cy * cr, sr), (sy * sr, -cy * sr, cr)
    v = (data.v[i, 0], data.v[i, 1], data.v[i, 2])
    over = (v[0], v[1] - rate_y, v[2] - rate_z)
    omega = add(
        add(scale(data.v[i, 3], forward), scale(data.v[i, 4], axle)),
        scale(data.v[i, 5], down),
    )
    way = 1.0 if v[0] >= 0.0 else -1.0
    speed = sqrt(dot(v, v))
    per_speed = 1.0 / max(speed, param["creep_speed"])
    slow = step > 0.0 and speed < param["creep_speed"]
    turn, advance = get(frame["rate"]), get(frame["advance"])
    axes = rail_axes(rail) if shifted else IDEAL
    force, moment = (0.0, 0.0, 0.0), get(rail["couple"])
    grip = rail["grip"]
    for j in range(patches):
        contact = data.contact[w, j]
        slope = contact["slope"]
        cosine = 1.0 / sqrt(1.0 + slope * slope)
        arm = (contact["arm"][0], contact["arm"][1], contact["arm"][2])
        normal = (0.0, -slope * cosine, cosine)
        right, down_rail = data.q[i, 1] + arm[1], data.q[i, 2] + arm[2]
        along = (
            way,
            way * (advance[1] + turn[2] * arm[0] - turn[0] * down_rail),
            way * (advance[2] + turn[0] * right - turn[1] * arm[0]),
        )
        if shifted:
            bent = (0.0, arm[0] * rail["lateral_bend"], arm[0] * rail["vertical_bend"])
            normal = turned(axes, normal)
            normal = sub(normal, scale(dot(normal, bent), axes[0]))
            along = add(add(along, (-way, 0.0, 0.0)), scale(way, add(axes[0], bent)))
        across = cross(normal, along)
        arm_x, arm_t = cross(arm, along), cross(arm, across)
        slip_x, slip_t = dot(along, over) + dot(arm_x, omega), dot(across, over) + dot(arm_t, omega)
        per_x, per_t, xi, eta = per_speed, per_speed, 0.0, 0.0
        if slow:
            per_x, per_t, xi, eta = remembered(model, data, w, j, step, speed, way, slip_x, slip_t)
        xi += per_x * slip_x
        eta += per_t * slip_t
        phi = dot(normal, omega) * per_speed
        n = contact["normal"]
        friction, fall, slid = grip[FRICTION], 0.0, 0.0
        if grip[DECAY] > 0.0:
            slid = sqrt(slip_x * slip_x + slip_t * slip_t)
            friction, fall = falling_friction(grip[RATIO], grip[DECAY], friction, slid)
        limit = friction * n
        tx, tt, mz, xx, xe, xp, ex, ee, ep, px, pe, pp = tangential(
            param, model.creep, grip[ADHESION], grip[SLIP], contact["semi_x"], contact["semi_y"],
            contact["f11"], contact["f22"], contact["f23"], contact["f33"], limit, xi, eta, phi,
        )  # fmt: skip
        if fall < 0.0 and slid > 0.0 and limit > 0.0:
            share = fall * n / (slid * limit)  # of d limit / d slip, over the limit
            rx, rt = tx - xx * xi - xe * eta - xp * phi, tt - ex * xi - ee * eta - ep * phi
            rz = mz - px * xi - pe * eta - pp * phi
            fall_x, fall_t = share * slip_x / per_x, share * slip_t / per_t
            xx, xe = xx + rx * fall_x, xe + rx * fall_t
            ex, ee = ex + rt * fall_x, ee + rt * fall_t
            px, pe = px + rz * fall_x, pe + rz * fall_t
        contact["xi"], contact["eta"], contact["phi"] = xi, eta, phi
        contact["slip_x"], contact["slip_t"] = slip_x, slip_t
        contact["creep_x"], contact["creep_t"], contact["spin_moment"] = tx, tt, mz
        here = add(add(scale(tx, along), scale(tt, across)), scale(-n, normal))
        pull = n * (normal[1] * advance[1] + normal[2] * advance[2])  # of N: it leans with the rise of both rails
        force = add(force, add(here, (pull, 0.0, 0.0)))
        moment = add(moment, add(cross(arm, here), add(scale(mz, normal), (0.0, 0.0, -arm[1] * pull))))
        g0 = (along[0], along[1], along[2], dot(forward, arm_x), dot(axle, arm_x), dot(down, arm_x))
        g1 = (across[0], across[1], across[2], dot(forward, arm_t), dot(axle, arm_t), dot(down, arm_t))
        g2 = (0.0, 0.0, 0.0, dot(forward, normal), dot(axle, normal), dot(down, normal))
        for b in range(6):
            ax, at, an = per_x * g0[b], per_t * g1[b], per_speed * g2[b]
            hx, ht, hn = xx * ax + xe * at + xp * an, ex * ax + ee * at + ep * an, px * ax + pe * at + pp * an
            for a in range(6):
                block[k, a, b] -= g0[a] * hx + g1[a] * ht + g2[a] * hn
    rail["x"], rail["y"], rail["q"] = -force[0], -force[1], -force[2]
    load = data.rail_load
    for a in range(3):
        load[i, a] += force[a]
    load[i, 3] += dot(forward, moment)
    load[i, 4] += dot(axle, moment)
    load[i, 5] += dot(down, moment)


@seldom
def remembered(model, data, w, j, step, speed, way, slip_x, slip_t):
    """Creepages of patch j of a slow wheel w: what they keep of data.lag, and per slip velocity (theory.md 8.3).

    Returns per_x, per_t [s/m] and kept_x, kept_t [-]: creepage = kept + per slip. way : as in `slip_wheel`.
    """
    contact, lag = data.contact[w, j], data.lag[w]
    table = model.table[model.wheel[w]["table"]]
    spring = 4.0 * table["shear"] * sqrt(contact["semi_x"] * contact["semi_y"]) / (2.0 - table["poisson"])
    per_speed = 1.0 / model.param[0]["creep_speed"]
    fade = 1.0 - speed * per_speed
    long_x, long_t = fade * fade * contact["f11"] / spring, fade * fade * contact["f22"] / spring
    pull_x, pull_t, nearest = 0.0, 0.0, SAME_PATCH
    for k in range(MAX_CONTACT):
        away = abs(lag[k, 2] - contact["lateral"])
        if lag[k, 3] > 0.0 and away < nearest:
            pull_x, pull_t, nearest = way * lag[k, 0], way * lag[k, 1], away
    now_x, now_t = contact["f11"] * slip_x, contact["f22"] * slip_t
    sliding = SLIDING * data.rail[w]["grip"][FRICTION] * contact["normal"]
    most = max(sliding, per_speed * sqrt(now_x * now_x + now_t * now_t))
    share = min(most / max(sqrt(pull_x * pull_x + pull_t * pull_t), 1e-300), 1.0)
    last_x, last_t = share * pull_x / contact["f11"], share * pull_t / contact["f22"]
    lag[j, 4], lag[j, 5] = last_x, last_t
    lively = SOFTNESS / step
    rest_x, rest_t = (1.0 + lively) / (long_x + step * speed), (1.0 + lively) / (long_t + step * speed)
    kept_x, kept_t = (long_x * rest_x - lively) * last_x, (long_t * rest_t - lively) * last_t
    return step * rest_x, step * rest_t, kept_x, kept_t


@kernel
def remember(model, data, step):
    """Keep how the patches of slow wheels are strained, as linear creep forces, in data.lag; step : just made [s]."""
    lively, slow = SOFTNESS / step, model.param[0]["creep_speed"]
    for w in range(model.wheel.size):
        i, lag = model.wheel[w]["body"], data.lag[w]
        v = (data.v[i, 0], data.v[i, 1], data.v[i, 2])
        patches = int(data.rail[w]["patches"]) if dot(v, v) < slow * slow else 0
        if patches == 0 and lag[0, 3] == 0.0:
            continue
        way = 1.0 if v[0] >= 0.0 else -1.0
        for j in range(MAX_CONTACT):
            contact = data.contact[w, j]
            lag[j, 0] = way * contact["f11"] * (contact["xi"] + lively * lag[j, 4]) / (1.0 + lively)
            lag[j, 1] = way * contact["f22"] * (contact["eta"] + lively * lag[j, 5]) / (1.0 + lively)
            lag[j, 2], lag[j, 3] = contact["lateral"], 1.0 if j < patches else 0.0


@kernel
def describe_patch(wheel, rail, contact):
    """Complete a CONTACT for a reader: contact angle and how far the linear creep force is over the friction limit."""
    contact["angle"] = -wheel["side"] * atan(contact["slope"])
    tx = contact["f11"] * contact["xi"]
    tt = contact["f22"] * contact["eta"] + contact["f23"] * contact["phi"]
    linear = sqrt(tx * tx + tt * tt)
    limit = rail["grip"][FRICTION] * contact["normal"]
    contact["linear"] = linear / limit if limit > 0.0 else 0.0
