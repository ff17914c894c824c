"""Look-up in a table of heights: energy, force and patches of a wheel (theory.md section 6.8).

For every pose (y, roll, yaw^2) the table holds the heights z_l at which the wheel stores the energies U_l = w_l^2.5, as
a spline, cubic over w and quadratic over y, roll and yaw^2, in a grid that is sheared along y so that it follows the
flange. So z = z(w; y, roll, yaw^2) gives w, and

    U = w^2.5,   dU/dz = 2.5 w^1.5 / (dz/dw),   dU/dy = -dU/dz dz/dy,   and so on:

the force is the exact gradient of one energy, whatever the splines leave out.
"""

from math import sqrt

from .jit import kernel, seldom
from .kalker import stiffness
from .layout import LEVELS, MAX_CONTACT, PARTS, ROW, Part
from .rows import mix_two, weave

POWER = 2.5  # of w in the energy
LEVEL_ROWS = (LEVELS + ROW - 1) // ROW
BASIS = LEVEL_ROWS  # rows from the first: of w_l; cubics of its splines; w of parts; parts of the wheel; shears, radius
PART_W = BASIS + 2 * (LEVELS - 1)
REGIONS, SHEAR, CREEP = PART_W + 1, PART_W + 2, PART_W + 3
SLENDER = 0.8  # (a - b) / (a + b) up to which Kalker's coefficients are tabulated, linear in that: 1:9 to 9:1
SHAPES = 128  # intervals
HEAD = CREEP + SHAPES
NEWTON = 8
AT = MAX_CONTACT  # row of a sample from which the heights of the pose at hand stand, and parts of the contact
NEARLY = 1e-5  # step of Newton's method in w over that between two levels after which the next would be 1e-10
STEADY = 1e-3  # distance of loads below which the moment tells little of their shares [m]
LEAST_SHARE = 0.02  # of its tabulated one that a patch keeps
TOUCHING = 0.8  # distance of two patches over their half widths below which they are one
SHARE = Part.SHARE.value
SLOPE = Part.SLOPE.value
LATERAL = Part.LATERAL.value
RADIUS = Part.RADIUS.value
SEMI_X = Part.SEMI_X.value
SEMI_Y = Part.SEMI_Y.value
PRESSURE = Part.PRESSURE.value
UNUSED = Part.UNUSED.value


@kernel
def knot(heights, row, i):
    """Number i of a list that begins in a row."""
    return heights[row + i // ROW, i % ROW]


@kernel
def interval(heights, bins, knots, count, x):
    """Interval of the knots in which x lies; -1 when it lies outside or is not a number.

    The first two numbers of the row `bins` are how many equal bins there are per unit of x and how many in all; each
    holds the interval in which it begins.
    """
    place = (x - heights[knots, 0]) * heights[bins, 0]
    if not (place >= 0.0 and x <= knot(heights, knots, count - 1)):
        return -1
    i = int(knot(heights, bins + 1, min(int(place), int(heights[bins, 1]) - 1)))
    while i < count - 2 and x >= knot(heights, knots, i + 1):
        i += 1
    return i


@kernel
def basis(heights, knots, count, row, i, x):
    """Three B-splines at x in interval i, their derivatives, number of the first, and where x lies in the interval.

    Each is a parabola between the middles of intervals. Two rows for each knot within hold those of the three that do
    not vanish around it, by the distance from it: their values, slopes and curvatures, three and an unused one each.
    """
    low, high = knot(heights, knots, i), knot(heights, knots, i + 1)
    near = i if x < 0.5 * (low + high) else i + 1
    first = min(max(near, 1), count - 2) - 1
    u = x - knot(heights, knots, first + 1)
    c, d = heights[row + 2 * first], heights[row + 2 * first + 1]
    return (
        (c[0] + u * (c[4] + u * d[0]), c[1] + u * (c[5] + u * d[1]), c[2] + u * (c[6] + u * d[2])),
        (c[4] + 2.0 * u * d[0], c[5] + 2.0 * u * d[1], c[6] + 2.0 * u * d[2]),
        first,
        (x - low) / (high - low),
    )


@kernel
def stored(table, cell, branch, heights, y, roll, yaw, z, level, sample):
    """Energy and its gradient when the wheel's reference point is at z, and the patches that share the force.

    level : at which the search for w begins; what comes back does not depend on it.
    sample : rows 0 ... of as many patches, from the flange to the field side, filled as `Part` says with SEMI_X and
        SEMI_Y in [m]; those behind are scratch.

    Returns
    -------
    count : int
        Patches, at most MAX_CONTACT; -1 when the pose is off the table or not a number.
    level : int
        That below w.
    depth : float
        w dz/dw: the depth that a Hertzian contact of this energy and stiffness has [m].
    by_y, by_z, by_roll, by_yaw : float
        [N], [N], [N m], [N m]
    """
    square = yaw * yaw
    head = table["levels"]
    per_roll, per_yaw2 = heights[head + SHEAR, 0], heights[head + SHEAR, 1]
    y -= per_roll * roll + per_yaw2 * square
    iy = interval(heights, table["y_bins"], table["y_knots"], table["y_count"], y)
    ir = interval(heights, table["roll_bins"], table["roll_knots"], table["roll_count"], roll)
    iw = interval(heights, table["yaw2_bins"], table["yaw2_knots"], table["yaw2_count"], square)
    if iy < 0 or ir < 0 or iw < 0:
        return -1, level, 0.0, 0.0, 0.0, 0.0, 0.0
    ny, nw = table["y_count"], table["yaw2_count"]
    by_y, slope_y, ay, ty = basis(heights, table["y_knots"], ny, table["y_basis"], iy, y)
    by_roll, slope_roll, ar, tr = basis(
        heights, table["roll_knots"], table["roll_count"], table["roll_basis"], ir, roll
    )
    by_yaw2, slope_yaw2, aw, tw = basis(heights, table["yaw2_knots"], nw, table["yaw2_basis"], iw, square)
    first = table["coefficients"] * ROW + ((ar * nw + aw) * ny + ay) * LEVELS
    level, way = min(max(level, 0), LEVELS - 2), 0
    while True:
        weave(
            heights, first + first_level(level), nw * ny * LEVELS, ny * LEVELS, LEVELS,
            by_y, slope_y, by_roll, slope_roll, by_yaw2, slope_yaw2, sample, AT,
        )  # fmt: skip
        below, above = ends(heights, head + BASIS + 2 * level, sample)
        if z > above and level < LEVELS - 2 and way >= 0:
            level, way = level + 1, 1
        elif not z > below and level > 0 and way <= 0:
            level, way = level - 1, -1
        else:
            break
    w, rate, along_y, along_roll, along_yaw2 = at_height(heights, head, level, sample, z, below, above)
    if not w > 0.0:
        return 0, level, 0.0, 0.0, 0.0, 0.0, 0.0
    force = POWER * w * sqrt(w) / rate
    place = table["cell_base"] + (ir * (nw - 1) + iw) * (ny - 1) + iy
    count = share_out(table, cell, branch, heights, place, ty, tr, tw, w, sample)
    by_y, by_roll = -force * along_y, -force * (along_roll - per_roll * along_y)
    by_yaw = -2.0 * yaw * force * (along_yaw2 - per_yaw2 * along_y)
    if count > 1:
        tilt(sample, count, roll, yaw, heights[head + SHEAR, 2], by_y, force, by_roll)
    return count, level, w * rate, by_y, force, by_roll, by_yaw


@kernel
def first_level(level):
    """First of the four splines over w that matter above a level: the second and the last but one are no knots."""
    return min(max(level - 1, 0), LEVELS - 4)


@kernel
def ends(heights, row, sample):
    """Heights between which w lies in an interval whose cubics begin in a row."""
    c, d, v = heights[row], heights[row + 1], sample[AT]
    below = (c[0] * v[0] + c[1] * v[1]) + (c[2] * v[2] + c[3] * v[3])
    above = ((c[0] + c[4]) + (d[0] + d[4])) * v[0] + ((c[1] + c[5]) + (d[1] + d[5])) * v[1]
    return below, above + (((c[2] + c[6]) + (d[2] + d[6])) * v[2] + ((c[3] + c[7]) + (d[3] + d[7])) * v[3])


@kernel
def at_height(heights, head, level, sample, z, below, above):
    """w at the height z, dz/dw there, and how z changes with y, roll and yaw^2 at this w.

    Cubic between two levels, at which z is `below` and `above`; straight below the first, where w may be negative: no
    contact, and beyond the last.
    """
    c, d, v = heights[head + BASIS + 2 * level], heights[head + BASIS + 2 * level + 1], sample[AT]
    c1 = (c[4] * v[0] + c[5] * v[1]) + (c[6] * v[2] + c[7] * v[3])
    c2 = (d[0] * v[0] + d[1] * v[1]) + (d[2] * v[2] + d[3] * v[3])
    c3 = (d[4] * v[0] + d[5] * v[1]) + (d[6] * v[2] + d[7] * v[3])
    t, out = 0.0, 0.0
    if not z > below:
        out = (z - below) / c1
    elif not z < above:
        t = 1.0
        out = (z - above) / (c1 + 2.0 * c2 + 3.0 * c3)
    else:
        t = (z - below) / (above - below)
        for _ in range(NEWTON):
            move = (z - below - t * (c1 + t * (c2 + t * c3))) / (c1 + t * (2.0 * c2 + 3.0 * t * c3))
            t += move
            if abs(move) < NEARLY:
                break
    w0, w1, w2, w3 = weight(c, d, 0, t, out), weight(c, d, 1, t, out), weight(c, d, 2, t, out), weight(c, d, 3, t, out)
    span = knot(heights, head, level + 1) - knot(heights, head, level)
    u, p, q = sample[AT + 1], sample[AT + 2], sample[AT + 3]
    return (
        knot(heights, head, level) + (t + out) * span,
        (c1 + t * (2.0 * c2 + 3.0 * t * c3)) / span,
        (w0 * u[0] + w1 * u[1]) + (w2 * u[2] + w3 * u[3]),
        (w0 * p[0] + w1 * p[1]) + (w2 * p[2] + w3 * p[3]),
        (w0 * q[0] + w1 * q[1]) + (w2 * q[2] + w3 * q[3]),
    )


@kernel
def weight(c, d, i, t, out):
    """Spline i of an interval at its place t, continued straight by `out`."""
    return c[i] + t * (c[4 + i] + t * (d[i] + t * d[4 + i])) + out * (c[4 + i] + t * (2.0 * d[i] + 3.0 * t * d[4 + i]))


@kernel
def share_out(table, cell, branch, heights, place, ty, tr, tw, w, sample):
    """Patches of one pose: linear between the corners of its cell and in w. Returns how many.

    Where a part of the contact ends within the cell its share fades with the corners that have it, and the rest is
    taken from them. Parts that the grid could not follow from corner to corner come together where they lie.
    """
    ay, ar, aw = 1.0 - ty, 1.0 - tr, 1.0 - tw
    q0, q1, q2, q3 = ay * ar, ty * ar, ay * tr, ty * tr
    full = (q0 * aw, q1 * aw, q2 * aw, q3 * aw, q0 * tw, q1 * tw, q2 * tw, q3 * tw)
    levels = heights[table["levels"] + PART_W]
    k = 0
    while k < PARTS - 2 and w > levels[k + 1]:
        k += 1
    t = min(max((w - levels[k]) / (levels[k + 1] - levels[k]), 0.0), 1.0)
    root = sqrt(w)
    count = 0
    for b in range(table["branch_base"] + cell[place], table["branch_base"] + cell[place + 1]):
        n, whole = corners(branch, b)
        weights, part = full, 1.0
        if not whole:
            weights, part = reached(branch, b, full)
            if part < 1e-9:
                continue
        at = table["parts"] + k
        rows = (
            at + PARTS * n[0], at + PARTS * n[1], at + PARTS * n[2], at + PARTS * n[3],
            at + PARTS * n[4], at + PARTS * n[5], at + PARTS * n[6], at + PARTS * n[7],
        )  # fmt: skip
        mix_two(heights, rows, weights, sample, AT)
        share = part * between(sample, SHARE, t)
        if share > 0.0:
            count = gather(sample, count, share, t, root)
    return count


@kernel
def gather(sample, count, share, t, root):
    """Add the part of the contact at hand to the patches; one that lies within another is the same.

    t, root : its place between two levels, and w^0.5 [J^0.2].  Returns how many patches there are.
    """
    slope, lateral, radius = between(sample, SLOPE, t), between(sample, LATERAL, t), between(sample, RADIUS, t)
    a, b, pressure = (
        root * between(sample, SEMI_X, t), root * between(sample, SEMI_Y, t), root * between(sample, PRESSURE, t)
    )  # fmt: skip
    at, least = count, TOUCHING
    for k in range(count):
        away = abs(lateral - sample[k, LATERAL]) * sqrt(1.0 + slope * slope) / (b + sample[k, SEMI_Y])
        if away < least or (count == MAX_CONTACT and at == count):
            at, least = k, away
    if at == count:
        sample[at, SHARE], sample[at, SLOPE], sample[at, LATERAL], sample[at, RADIUS] = share, slope, lateral, radius
        sample[at, SEMI_X], sample[at, SEMI_Y], sample[at, PRESSURE] = a, b, pressure
        return count + 1
    new = share / (share + sample[at, SHARE])
    sample[at, SHARE] += share
    sample[at, SLOPE] += new * (slope - sample[at, SLOPE])
    sample[at, LATERAL] += new * (lateral - sample[at, LATERAL])
    sample[at, RADIUS] += new * (radius - sample[at, RADIUS])
    sample[at, SEMI_X] += new * (a - sample[at, SEMI_X])
    sample[at, SEMI_Y] += new * (b - sample[at, SEMI_Y])
    sample[at, PRESSURE] += new * (pressure - sample[at, PRESSURE])
    return count


@kernel
def between(sample, channel, t):
    """A member of `Part` between the two levels at hand."""
    below, above = sample[AT, channel], sample[AT, ROW + channel]
    return below + t * (above - below)


@kernel
def corners(branch, b):
    """Nodes of branch b, any where it does not reach, and whether it reaches all corners."""
    c0, c1, c2, c3 = branch[b, 0], branch[b, 1], branch[b, 2], branch[b, 3]
    c4, c5, c6, c7 = branch[b, 4], branch[b, 5], branch[b, 6], branch[b, 7]
    return (
        max(c0, 0), max(c1, 0), max(c2, 0), max(c3, 0), max(c4, 0), max(c5, 0), max(c6, 0), max(c7, 0)
    ), (c0 | c1 | c2 | c3 | c4 | c5 | c6 | c7) >= 0  # fmt: skip


@kernel
def reached(branch, b, w):
    """Weights of the corners that branch b reaches, scaled to a sum of one, and their sum before."""
    w0, w1 = w[0] if branch[b, 0] >= 0 else 0.0, w[1] if branch[b, 1] >= 0 else 0.0
    w2, w3 = w[2] if branch[b, 2] >= 0 else 0.0, w[3] if branch[b, 3] >= 0 else 0.0
    w4, w5 = w[4] if branch[b, 4] >= 0 else 0.0, w[5] if branch[b, 5] >= 0 else 0.0
    w6, w7 = w[6] if branch[b, 6] >= 0 else 0.0, w[7] if branch[b, 7] >= 0 else 0.0
    part = (w0 + w1 + w2 + w3) + (w4 + w5 + w6 + w7)
    share = 1.0 / max(part, 1e-300)
    return (w0 * share, w1 * share, w2 * share, w3 * share, w4 * share, w5 * share, w6 * share, w7 * share), part


@kernel
def mean_direction(sample, count, by_y, by_z):
    """Sum of the patches' shares; a force along each patch's normal and a rest that add up to (by_y, by_z) by shares.

    Returns total [-], along, rest_y, rest_z [N].
    """
    total, mean_y, mean_z = 0.0, 0.0, 0.0
    for j in range(count):
        slope, share = sample[j, SLOPE], sample[j, SHARE]
        cosine = 1.0 / sqrt(1.0 + slope * slope)
        total += share
        mean_y, mean_z = mean_y - share * cosine * slope, mean_z + share * cosine
    along = (by_y * mean_y + by_z * mean_z) / (mean_y * mean_y + mean_z * mean_z)
    return total, along, (by_y - along * mean_y) / total, (by_z - along * mean_z) / total


@kernel
def tilt(sample, count, roll, yaw, tape, by_y, by_z, by_roll):
    """Shift load between patches, linear in their levers, until their moment about the roll axis is by_roll.

    tape : radius of the tape circle [m].  Patches closer than STEADY are left as they are.
    """
    sr, cr = roll * (1.0 - roll * roll / 6.0), 1.0 - 0.5 * roll * roll
    sy, cy = yaw * (1.0 - yaw * yaw / 6.0), 1.0 - 0.5 * yaw * yaw
    total, along, rest_y, rest_z = mean_direction(sample, count, by_y, by_z)
    moment = 0.0
    for j in range(count):
        slope = sample[j, SLOPE]
        nz = 1.0 / sqrt(1.0 + slope * slope)
        ny = -slope * nz
        lean = ny * cy * cr + nz * sr
        down = sample[j, RADIUS] / sqrt(1.0 - lean * lean)
        out = sample[j, LATERAL] - down * lean
        x, z = -sy * (out * cr + tape * sr), out * sr + down * nz - tape * cr
        y = cy * (out * cr + tape * sr) + down * ny
        sample[j, UNUSED] = (rest_z + along * nz) * (cy * y - sy * x) - (rest_y + along * ny) * cy * z
        moment += sample[j, SHARE] * sample[j, UNUSED]
    mean, spread = moment / total, 0.0
    for j in range(count):
        off = sample[j, UNUSED] - mean
        spread += sample[j, SHARE] * off * off
    pull = (by_roll - moment) / (spread + total * STEADY * STEADY * (by_y * by_y + by_z * by_z))
    after = 0.0
    for j in range(count):
        sample[j, SHARE] *= max(1.0 + pull * (sample[j, UNUSED] - mean), LEAST_SHARE)
        after += sample[j, SHARE]
    for j in range(count):
        sample[j, SHARE] *= total / after


@kernel
def creep_stiffness(heights, row, a, b, shear, poisson):
    """As `kalker.stiffness`, with coefficients from a table that begins in a row, linear in (a - b) / (a + b)."""
    shape = (a - b) / (a + b)
    if not abs(shape) < SLENDER:
        return slender_stiffness(a, b, shear, poisson)
    place = (shape + SLENDER) * (0.5 * SHAPES / SLENDER)
    k = min(int(place), SHAPES - 1)
    t, c = place - k, heights[row + k]
    area = a * b
    length, f = sqrt(area), shear * area
    return f * (c[0] + t * c[4]), f * (c[1] + t * c[5]), f * length * (c[2] + t * c[6]), f * area * (c[3] + t * c[7])


@seldom
def slender_stiffness(a, b, shear, poisson):
    """As `kalker.stiffness`."""
    return stiffness(a, b, shear, poisson)
