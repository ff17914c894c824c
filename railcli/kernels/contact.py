"""Wheels on rails: table look-up, penetration, normal force (theory.md sections 4 and 6).

Track axes at the wheelset's own s; forces are those on the wheel. A left wheel enters the table of a right one
mirrored: lateral position, roll and yaw change sign, and so does the slope that comes back.
"""

from math import isfinite, sqrt

from .adhesion import plain_grip
from .heights import CREEP, REGIONS, creep_stiffness, mean_direction, stored
from .hertz import pressure
from .jit import kernel
from .layout import (
    MAX_CONTACT,
    Node,
    Part,
    Status,
)
from .patch_force import place_patch, power_1_5, push
from .rows import mix_bent
from .shift import IDEAL, rail_axes, shift_rail, turned
from .trig import arc_sine
from .vec3 import add, cross, dot, scale, sub

GAP_Y = Node.GAP_Y.value
SLOPE_Y = Node.SLOPE_Y.value
LATERAL_Y = Node.LATERAL_Y.value
GAP_ROLL = Node.GAP_ROLL.value
SLOPE_ROLL = Node.SLOPE_ROLL.value
LATERAL_ROLL = Node.LATERAL_ROLL.value
GAP_YAW2 = Node.GAP_YAW2.value
SLOPE_YAW2 = Node.SLOPE_YAW2.value
LATERAL_YAW2 = Node.LATERAL_YAW2.value
GAP = Node.GAP.value
SLOPE = Node.SLOPE.value
LATERAL = Node.LATERAL.value
RADIUS = Node.RADIUS.value
BARRIER_GAUGE = Node.BARRIER_GAUGE.value
BARRIER_FIELD = Node.BARRIER_FIELD.value
HERTZ = Node.HERTZ.value
SEMI_X = Node.SEMI_X.value
SEMI_Y = Node.SEMI_Y.value
F11 = Node.F11.value
F22 = Node.F22.value
F23 = Node.F23.value
F33 = Node.F33.value
REGION = Node.REGION.value
WHEEL_SLOPE = Node.WHEEL_SLOPE.value
SHARE = Part.SHARE.value
SHARED_SLOPE = Part.SLOPE.value
SHARED_LATERAL = Part.LATERAL.value
SHARED_RADIUS = Part.RADIUS.value
SHARED_SEMI_X = Part.SEMI_X.value
SHARED_SEMI_Y = Part.SEMI_Y.value
SHARED_PRESSURE = Part.PRESSURE.value
PART = Node.GAP_Y.value  # of a sample: weight of the corners that have the branch, 1 where it does not end


@kernel
def enter(side, lateral, radius, y, z, sr, cr, cy):
    """Lateral position about nominal and height of a wheel's reference point, the bottom of its tape circle [m].

    side : +1 right, -1 left.  lateral, radius : of the tape circle [m].  y, z : of the wheelset's centre in the
    rail's frame [m].  sr, cr, cy : sine and cosine of its roll, cosine of its yaw; roll = asin(e_z) and
    yaw = atan2(-e_x, e_y) of the axle's direction e. The table takes side * roll and side * yaw beside them.
    """
    return side * y + (lateral * cr - side * radius * sr) * cy - lateral, z + side * lateral * sr + radius * cr


@kernel
def enter_shifted(wheel, rail, axes, y, z, axle):
    """As `enter`, on a displaced rail, with the wheel's roll and yaw: all in the frame of the rail (theory.md 4.3).

    axes : `rail_axes`.  y, z : of the wheelset's centre in the track frame [m].  axle : its direction.
    """
    along, right, down = axes
    side, lateral = wheel["side"], wheel["lateral"]
    nominal = side * lateral
    from_rail = (0.0, y - rail["lateral"] - nominal, z - rail["vertical"])
    ex, ey, ez = dot(along, axle), dot(right, axle), dot(down, axle)
    cr = sqrt(1.0 - ez * ez)
    y, z = enter(side, lateral, wheel["radius"], dot(right, from_rail) + nominal, dot(down, from_rail), ez, cr, ey / cr)
    return y, z, side * arc_sine(ez), side * arc_sine(-ex / cr)


@kernel
def times(w, u, shift, h):
    """h w[c] (u[c] + shift) of every corner."""
    return (
        h * (w[0] * (u[0] + shift)), h * (w[1] * (u[1] + shift)),
        h * (w[2] * (u[2] + shift)), h * (w[3] * (u[3] + shift)),
        h * (w[4] * (u[4] + shift)), h * (w[5] * (u[5] + shift)),
        h * (w[6] * (u[6] + shift)), h * (w[7] * (u[7] + shift)),
    )  # fmt: skip


@kernel
def mean(w, u):
    """Sum of w times u over the corners."""
    return (w[0] * u[0] + w[1] * u[1] + w[2] * u[2] + w[3] * u[3]) + (
        w[4] * u[4] + w[5] * u[5] + w[6] * u[6] + w[7] * u[7]
    )


@kernel
def look_up(table, node, cell, branch, y, roll, yaw, depth, sample):
    """All branches of a contact table that are loaded when the wheel's reference point is at z = depth.

    sample : (SAMPLE_ROWS, NODE_CHANNELS) filled from the flange to the field side, with GAP replaced by the
        penetration depth - D [m] and GAP_Y by the branch's part in the cell (PART).
    Returns the number of loaded branches; -1 when the pose is off the table or not a number; more than MAX_CONTACT
    when sample could not hold them.

    Linear interpolation between the eight corners of a cell; D, contact angle and place add half the slopes of the
    corners, which makes them exact for quadratics, and the radius follows the place. A branch that ends within the cell
    is taken from the corners that have it, and fades with their weight (theory.md section 4.8).
    """
    py = (y - table["y_start"]) / table["y_step"]
    pr = (roll - table["roll_start"]) / table["roll_step"]
    pw = yaw * yaw / table["yaw2_step"]
    ny, nr, nw = table["y_count"], table["roll_count"], table["yaw2_count"]
    if not (py >= 0.0 and py <= ny - 1 and pr >= 0.0 and pr <= nr - 1 and pw <= nw - 1):
        return -1
    iy, ir, iw = min(int(py), ny - 2), min(int(pr), nr - 2), min(int(pw), nw - 2)
    ty, tr, tw = py - iy, pr - ir, pw - iw
    hy, hr, hw = table["y_step"], table["roll_step"], table["yaw2_step"]
    place = table["cell_base"] + (ir * (nw - 1) + iw) * (ny - 1) + iy
    ay, ar, aw = 1.0 - ty, 1.0 - tr, 1.0 - tw
    uy = (ty, -ay, ty, -ay, ty, -ay, ty, -ay)
    ur = (tr, tr, -ar, -ar, tr, tr, -ar, -ar)
    uw = (tw, tw, tw, tw, -aw, -aw, -aw, -aw)
    q0, q1, q2, q3 = ay * ar, ty * ar, ay * tr, ty * tr
    full = (q0 * aw, q1 * aw, q2 * aw, q3 * aw, q0 * tw, q1 * tw, q2 * tw, q3 * tw)
    hy, hr, hw = 0.5 * hy, 0.5 * hr, 0.5 * hw
    full_y, full_r, full_w = times(full, uy, 0.0, hy), times(full, ur, 0.0, hr), times(full, uw, 0.0, hw)
    base = table["node_base"]
    count = 0
    for b in range(table["branch_base"] + cell[place], table["branch_base"] + cell[place + 1]):
        n, whole = corners(branch, b, base)
        out = min(count, MAX_CONTACT - 1)
        if whole:
            mix_bent(node, n, full, full_y, full_r, full_w, sample, out)
            count += penetrated(sample, out, depth, 1.0)
            continue
        w, part = present(branch, b, full)
        if part < 1e-9:
            continue
        wy, wr, ww = times(w, uy, mean(w, uy), hy), times(w, ur, mean(w, ur), hr), times(w, uw, mean(w, uw), hw)
        mix_bent(node, n, w, wy, wr, ww, sample, out)
        count += penetrated(sample, out, depth, part)
    return count


@kernel
def look_up_all(table, node, cell, branch, poses, depth, sample):
    """`look_up` at every row (y, roll, yaw) of poses, to be timed. Returns how many branches were loaded."""
    loaded = 0
    for i in range(poses.shape[0]):
        loaded += look_up(table, node, cell, branch, poses[i, 0], poses[i, 1], poses[i, 2], depth, sample)
    return loaded


@kernel
def penetrated(sample, out, depth, part):
    """Finish a mixed row of `look_up` when its branch is loaded; returns whether it is.

    The radius is that of the wheel profile at the place of contact, by parabolas through the corners.
    """
    p = depth - (sample[out, GAP] + (sample[out, GAP_Y] + sample[out, GAP_ROLL] + sample[out, GAP_YAW2]))
    if not p > 0.0:
        return False
    sample[out, SLOPE] += sample[out, SLOPE_Y] + sample[out, SLOPE_ROLL] + sample[out, SLOPE_YAW2]
    moved = sample[out, LATERAL_Y] + sample[out, LATERAL_ROLL] + sample[out, LATERAL_YAW2]
    sample[out, RADIUS] += sample[out, WHEEL_SLOPE] * (0.5 * sample[out, LATERAL] + moved)
    sample[out, LATERAL] += moved
    sample[out, GAP], sample[out, PART] = p, part
    return True


@kernel
def corners(branch, b, base):
    """Nodes of branch b, any where it does not reach, and whether it reaches all corners."""
    c0, c1, c2, c3 = branch[b, 0], branch[b, 1], branch[b, 2], branch[b, 3]
    c4, c5, c6, c7 = branch[b, 4], branch[b, 5], branch[b, 6], branch[b, 7]
    return (
        base + max(c0, 0), base + max(c1, 0), base + max(c2, 0), base + max(c3, 0),
        base + max(c4, 0), base + max(c5, 0), base + max(c6, 0), base + max(c7, 0),
    ), (c0 | c1 | c2 | c3 | c4 | c5 | c6 | c7) >= 0  # fmt: skip


@kernel
def present(branch, b, w):
    """Weights of the corners that branch b reaches, scaled to a sum of one, and their sum before that."""
    w0, w1 = w[0] if branch[b, 0] >= 0 else 0.0, w[1] if branch[b, 1] >= 0 else 0.0
    w2, w3 = w[2] if branch[b, 2] >= 0 else 0.0, w[3] if branch[b, 3] >= 0 else 0.0
    w4, w5 = w[4] if branch[b, 4] >= 0 else 0.0, w[5] if branch[b, 5] >= 0 else 0.0
    w6, w7 = w[6] if branch[b, 6] >= 0 else 0.0, w[7] if branch[b, 7] >= 0 else 0.0
    part = (w0 + w1 + w2 + w3) + (w4 + w5 + w6 + w7)
    share = 1.0 / max(part, 1e-300)
    return (w0 * share, w1 * share, w2 * share, w3 * share, w4 * share, w5 * share, w6 * share, w7 * share), part


@kernel
def facing_barrier(sample, count, j, way, channel):
    """Barrier towards branch j of its neighbour on one side (way -1 or +1); as that one fades, of the next [m]."""
    barrier, rest = 0.0, 1.0
    k = j + way
    while k >= 0 and k < count and rest > 0.0:
        barrier += rest * sample[k, PART] * sample[k, channel]
        rest *= 1.0 - sample[k, PART]
        k += way
    return barrier


@kernel
def elastic_share(sample, count, j, cosine):
    """Elastic normal force of loaded branch j over its Hertz factor [m^1.5], patches that overlap merged.

    Where the saddle between two minima of D is penetrated too, the patches overlap. The force that both would give at
    the depth of the saddle is then counted once, shared so that a branch that vanishes (its barrier goes to zero)
    loses all its force and its neighbour none: the total is continuous. Our own rule (theory.md section 6).
    """
    p = sample[j, GAP]
    own = power_1_5(p * cosine)
    if j > 0:
        near, far = sample[j, BARRIER_GAUGE], facing_barrier(sample, count, j, -1, BARRIER_FIELD)
        if near < p:
            own -= far / max(near + far, 1e-12) * power_1_5((p - near) * cosine)
    if j < count - 1:
        near, far = sample[j, BARRIER_FIELD], facing_barrier(sample, count, j, 1, BARRIER_GAUGE)
        if near < p:
            own -= far / max(near + far, 1e-12) * power_1_5((p - near) * cosine)
    return sample[j, PART] * max(own, 0.0)


@kernel
def touch(model, data):
    """Normal contact of every wheel on rails that do not give way, as `touch_wheel`. Returns a status."""
    for w in range(model.wheel.size):
        status = touch_wheel(model, data, w, 0.0, 0.0, 0.0, 0.0)
        if status != 0:
            return status
    return Status.OK.value


@kernel
def touch_wheel(model, data, w, give_y, give_z, rate_y, rate_z):
    """Normal contact of wheel w: fill data.contact (normal force and geometry) and data.rail. Returns a status.

    give_y, give_z : how far its rail gives way, to the right and down [m].  rate_y, rate_z : how fast [m/s].
    """
    param = model.param[0]
    shifted = model.shift.shape[0] > 0
    wheel, rail = model.wheel[w], data.rail[w]
    table = model.table[wheel["table"]]
    body, side = wheel["body"], wheel["side"]
    frame = data.frame[body]
    sr, sy, cr, cy = frame["sine"][0], frame["sine"][2], frame["cosine"][0], frame["cosine"][2]
    axle = (-sy * cr, cy * cr, sr)
    axes = IDEAL
    y, z = data.q[body, 1] - give_y, data.q[body, 2] - give_z
    if shifted:
        if not shift_rail(model, side, data.q[body, 0], rail):
            data.fault[0] = w
            return Status.LEFT_SHIFT.value
        axes = rail_axes(rail)
        y, z, roll, yaw = enter_shifted(wheel, rail, axes, y, z, axle)
    else:
        y, z = enter(side, wheel["lateral"], wheel["radius"], y, z, sr, cr, cy)
        roll, yaw = side * data.q[body, 3], side * data.q[body, 5]
    rail["x"], rail["y"], rail["q"], rail["patches"] = 0.0, 0.0, 0.0, 0.0
    rail["couple"][0], rail["couple"][1], rail["couple"][2] = 0.0, 0.0, 0.0
    if model.line.shape[0] == 0:
        plain_grip(model, wheel, rail)
    if table["levels"] >= 0:
        found = touch_stored(model, data, w, axes, axle, y, z, roll, yaw, rate_y, rate_z)
    else:
        found = touch_branches(model, data, w, axes, axle, y, z, roll, yaw, rate_y, rate_z)
    for j in range(max(found, 0), MAX_CONTACT):
        data.contact[w, j]["normal"] = 0.0
        data.contact[w, j]["depth"] = 0.0
    if found < 0 or found > MAX_CONTACT:
        data.fault[0] = w
        if not (isfinite(y) and isfinite(z) and isfinite(roll) and isfinite(yaw)):
            data.fault[0] = body
            return Status.NOT_FINITE.value
        return Status.LEFT_TABLE.value if found < 0 else Status.TOO_MANY_CONTACTS.value
    if z < -param["derail_lift"]:
        data.fault[0] = w
        return Status.DERAILED.value
    rail["patches"] = found
    return Status.OK.value


@kernel
def touch_branches(model, data, w, axes, axle, y, z, roll, yaw, rate_y, rate_z):
    """Patches of wheel w at the minima of the difference surface; returns how many, as `look_up`."""
    param, wheel, sample = model.param[0], model.wheel[w], data.sample
    found = look_up(model.table[wheel["table"]], model.node, model.cell, model.branch, y, roll, yaw, z, sample)
    if found > MAX_CONTACT:
        return found
    for j in range(found):
        slope = wheel["side"] * sample[j, SLOPE]
        cosine = 1.0 / sqrt(1.0 + slope * slope)
        contact = data.contact[w, j]
        approach = place_patch(
            model, data, w, axes, axle, contact, slope, sample[j, LATERAL], sample[j, RADIUS], rate_y, rate_z
        )
        elastic = elastic_share(sample, found, j, cosine)
        depth = sample[j, GAP] * cosine
        if elastic < power_1_5(depth):
            depth = elastic ** (2.0 / 3.0)
        root = sqrt(depth)
        push(param, contact, sample[j, HERTZ], elastic, depth, approach)
        contact["semi_x"], contact["semi_y"] = sample[j, SEMI_X] * root, sample[j, SEMI_Y] * root
        contact["f11"], contact["f22"] = sample[j, F11] * depth, sample[j, F22] * depth
        contact["f23"], contact["f33"] = sample[j, F23] * depth * root, sample[j, F33] * depth * depth
        contact["depth"] = sample[j, GAP]
        contact["pressure"] = pressure(contact["normal"], contact["semi_x"], contact["semi_y"])
        contact["region"] = sample[j, REGION]
    return found


@kernel
def touch_stored(model, data, w, axes, axle, y, z, roll, yaw, rate_y, rate_z):
    """Patches of wheel w that share the force of a table of heights; returns how many, as `heights.stored`.

    The forces add up to the gradient of the energy exactly, and so do the moments: what the places of the patches leave
    of them goes into the couple of data.rail.
    """
    param, wheel, rail, sample = model.param[0], model.wheel[w], data.rail[w], data.sample
    table, side = model.table[wheel["table"]], wheel["side"]
    shifted = model.shift.shape[0] > 0
    found, level, depth, by_y, by_z, by_roll, by_yaw = stored(
        table, model.cell, model.branch, model.heights, y, roll, yaw, z, int(rail["level"]), sample
    )
    rail["level"] = level
    if found <= 0:
        return found
    _, along, rest_y, rest_z = mean_direction(sample, found, by_y, by_z)
    frame = data.frame[wheel["body"]]
    sr, sy, cr, cy = frame["sine"][0], frame["sine"][2], frame["cosine"][0], frame["cosine"][2]
    forward, axle_rail, down = (cy, sy, 0.0), axle, (sy * sr, -cy * sr, cr)
    if shifted:
        forward, axle_rail, down = reference(axes, axle)
    tape = add(scale(side * wheel["lateral"], axle_rail), scale(wheel["radius"], down))
    turn, swing = -side * by_roll, -side * by_yaw
    for j in range(found):
        slope, share = sample[j, SHARED_SLOPE], sample[j, SHARE]
        cosine = 1.0 / sqrt(1.0 + slope * slope)
        force_y, force_z = share * (rest_y - along * cosine * slope), share * (rest_z + along * cosine)
        elastic = sqrt(force_y * force_y + force_z * force_z)
        slope = -side * force_y / force_z
        contact = data.contact[w, j]
        lateral, radius = sample[j, SHARED_LATERAL], sample[j, SHARED_RADIUS]
        approach = place_patch(model, data, w, axes, axle, contact, slope, lateral, radius, rate_y, rate_z)
        near = depth / sqrt(1.0 + slope * slope)
        size = power_1_5(near)
        push(param, contact, elastic / size, size, near, approach)
        a, b = sample[j, SHARED_SEMI_X], sample[j, SHARED_SEMI_Y]
        f11, f22, f23, f33 = creep_stiffness(
            model.heights, table["levels"] + CREEP, a, b, table["shear"], table["poisson"]
        )
        contact["semi_x"], contact["semi_y"] = a, b
        contact["f11"], contact["f22"], contact["f23"], contact["f33"] = f11, f22, f23, f33
        contact["depth"], contact["pressure"] = depth, sample[j, SHARED_PRESSURE]
        contact["region"] = region(model.heights, table["levels"] + REGIONS, lateral)
        normal = (0.0, side * force_y, force_z)
        arm = (contact["arm"][0], contact["arm"][1], contact["arm"][2])
        if shifted:
            arm = lever_arm(axle_rail, side * (wheel["lateral"] + lateral), radius, slope)
        lever = sub(arm, tape)
        turn += dot(normal, cross(forward, lever))
        swing += normal[1] * lever[0]
    couple = add(scale(turn, forward), scale(swing / down[2], down))
    if shifted:
        couple = turned(axes, couple)
    rail["couple"][0], rail["couple"][1], rail["couple"][2] = couple
    return found


@kernel
def reference(axes, axle):
    """In the axes of the rail: forward, axle and down of the wheelset."""
    along, right, below = axes
    axle = (dot(along, axle), dot(right, axle), dot(below, axle))
    cr = sqrt(1.0 - axle[2] * axle[2])
    forward = (axle[1] / cr, -axle[0] / cr, 0.0)
    return forward, axle, cross(forward, axle)


@kernel
def lever_arm(axle, out, radius, slope):
    """From the wheelset's centre to a point of contact: out along the axle, radius from it, its normal by slope."""
    cosine = 1.0 / sqrt(1.0 + slope * slope)
    normal = (0.0, -slope * cosine, cosine)
    lean = dot(normal, axle)
    down = radius / sqrt(1.0 - lean * lean)
    return add(scale(out - down * lean, axle), scale(down, normal))


@kernel
def region(heights, row, lateral):
    """Member of `Region` of a profile coordinate on the wheel."""
    return 0.0 + (lateral < heights[row, 2]) + (lateral < heights[row, 1]) + (lateral < heights[row, 0])
