"""Look-up in a table of heights: energy, force and patches of a wheel (theory.md section 6.8).

For every pose (y, roll, yaw^2) the table holds the heights z_l at which the wheel stores the energies U_l = w_l^2.5, as
cubic splines over all three, in a grid that is sheared along y so that it follows the flange. Between them z is a cubic
of w, so that z = z(w; y, roll, yaw^2) gives w, and

    U = w^2.5,   dU/dz = 2.5 w^1.5 / (dz/dw),   dU/dy = -dU/dz dz/dy,   and so on:

the force is the exact gradient of one energy, whatever the splines leave out.
"""

from math import sqrt

from .jit import kernel
from .layout import HEIGHTS, MAX_CONTACT, Part
from .rows import mix_two, weave

POWER = 2.5  # of w in the energy
WEIGHTS, REGIONS, SHEAR, HEAD = 1, 4, 5, 6  # rows after that of w_l: weights of slopes, parts of the wheel, shears
NEWTON = 8
AT = MAX_CONTACT  # row of a sample from which the heights of the pose at hand stand, and parts of the contact
NEARLY = 1e-6  # step of Newton's method in w over two heights after which the next would be rounding
TOUCHING = 0.8  # distance of two patches over their half widths below which they are one
SHARE = Part.SHARE.value
SLOPE = Part.SLOPE.value
LATERAL = Part.LATERAL.value
RADIUS = Part.RADIUS.value
SEMI_X = Part.SEMI_X.value
SEMI_Y = Part.SEMI_Y.value
PRESSURE = Part.PRESSURE.value


@kernel
def knot(heights, row, i):
    """Number i of a list that begins in a row."""
    return heights[row + i // HEIGHTS, i % HEIGHTS]


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
def basis(heights, knots, row, i, x):
    """Four B-splines on interval i and their derivatives, and where x lies in it (0 ... 1).

    Two rows of each interval hold their cubics in that place.
    """
    start = knot(heights, knots, i)
    per = 1.0 / (knot(heights, knots, i + 1) - start)
    t = (x - start) * per
    c = heights[row + 2 * i]
    d = heights[row + 2 * i + 1]
    return (
        (
            c[0] + t * (c[1] + t * (c[2] + t * c[3])), c[4] + t * (c[5] + t * (c[6] + t * c[7])),
            d[0] + t * (d[1] + t * (d[2] + t * d[3])), d[4] + t * (d[5] + t * (d[6] + t * d[7])),
        ),
        (
            per * (c[1] + t * (2.0 * c[2] + 3.0 * t * c[3])), per * (c[5] + t * (2.0 * c[6] + 3.0 * t * c[7])),
            per * (d[1] + t * (2.0 * d[2] + 3.0 * t * d[3])), per * (d[5] + t * (2.0 * d[6] + 3.0 * t * d[7])),
        ),
        t,
    )  # fmt: skip


@kernel
def stored(table, cell, branch, heights, y, roll, yaw, z, sample):
    """Energy and its gradient when the wheel's reference point is at z, and the patches that share the force.

    sample : rows 0 ... of as many patches, from the flange to the field side, filled as `Part` says with SEMI_X and
        SEMI_Y in [m]; those behind are scratch.

    Returns
    -------
    count : int
        Patches, at most MAX_CONTACT; -1 when the pose is off the table or not a number.
    depth : float
        w dz/dw: the depth that a Hertzian contact of this energy and stiffness has [m].
    by_y, by_z, by_roll, by_yaw : float
        [N], [N], [N m], [N m]
    """
    square = yaw * yaw
    per_roll, per_yaw2 = heights[table["levels"] + SHEAR, 0], heights[table["levels"] + SHEAR, 1]
    y -= per_roll * roll + per_yaw2 * square
    iy = interval(heights, table["y_bins"], table["y_knots"], table["y_count"], y)
    ir = interval(heights, table["roll_bins"], table["roll_knots"], table["roll_count"], roll)
    iw = interval(heights, table["yaw2_bins"], table["yaw2_knots"], table["yaw2_count"], square)
    if iy < 0 or ir < 0 or iw < 0:
        return -1, 0.0, 0.0, 0.0, 0.0, 0.0
    ny, nw = table["y_count"], table["yaw2_count"]
    by_y, slope_y, ty = basis(heights, table["y_knots"], table["y_basis"], iy, y)
    by_roll, slope_roll, tr = basis(heights, table["roll_knots"], table["roll_basis"], ir, roll)
    by_yaw2, slope_yaw2, tw = basis(heights, table["yaw2_knots"], table["yaw2_basis"], iw, square)
    first = (
        table["coefficients"]
        + (first_spline(ir, table["roll_count"]) * nw + first_spline(iw, nw)) * ny
        + first_spline(iy, ny)
    )
    weave(
        heights, first, nw * ny, ny, by_y, slope_y, by_roll, slope_roll, by_yaw2, slope_yaw2, sample, AT
    )
    w, rate, along_y, along_roll, along_yaw2 = at_height(heights, table["levels"], sample, z)
    if not w > 0.0:
        return 0, 0.0, 0.0, 0.0, 0.0, 0.0
    force = POWER * w * sqrt(w) / rate
    place = table["cell_base"] + (ir * (nw - 1) + iw) * (ny - 1) + iy
    count = share_out(table, cell, branch, heights, place, ty, tr, tw, w, sample)
    along_roll, along_yaw2 = along_roll - per_roll * along_y, along_yaw2 - per_yaw2 * along_y
    return count, w * rate, -force * along_y, force, -force * along_roll, -2.0 * yaw * force * along_yaw2


@kernel
def first_spline(i, count):
    """First of the four splines that matter on interval i: the second and the last but one knot are none of theirs."""
    return min(max(i - 1, 0), count - 4)


@kernel
def height(sample, k):
    """Height k of the pose at hand, and its derivatives by y, roll and yaw^2."""
    return sample[AT, k], sample[AT + 1, k], sample[AT + 2, k], sample[AT + 3, k]


@kernel
def slopes(heights, head, sample, k):
    """dz/dw at height k, by the parabola through it and its neighbours, and its derivatives by y, roll and yaw^2."""
    i = min(max(k - 1, 0), HEIGHTS - 3)
    a, b, c = heights[head + WEIGHTS, k], heights[head + WEIGHTS + 1, k], heights[head + WEIGHTS + 2, k]
    return (
        a * sample[AT, i] + b * sample[AT, i + 1] + c * sample[AT, i + 2],
        a * sample[AT + 1, i] + b * sample[AT + 1, i + 1] + c * sample[AT + 1, i + 2],
        a * sample[AT + 2, i] + b * sample[AT + 2, i + 1] + c * sample[AT + 2, i + 2],
        a * sample[AT + 3, i] + b * sample[AT + 3, i + 1] + c * sample[AT + 3, i + 2],
    )


@kernel
def at_height(heights, head, sample, z):
    """w at the height z, dz/dw there, and how z changes with y, roll and yaw^2 at this w.

    Cubic between two heights; straight below the first, where w may be negative: no contact, and beyond the last.
    """
    top = HEIGHTS - 1
    if not z > sample[AT, 0] or not z < sample[AT, top]:
        k = 0 if not z > sample[AT, 0] else top
        here, slope = height(sample, k), slopes(heights, head, sample, k)
        out = (z - here[0]) / slope[0]
        return (
            heights[head, k] + out, slope[0],
            here[1] + out * slope[1], here[2] + out * slope[2], here[3] + out * slope[3],
        )  # fmt: skip
    k = 0
    while z > sample[AT, k + 1]:
        k += 1
    span = heights[head, k + 1] - heights[head, k]
    low, high = height(sample, k), height(sample, k + 1)
    left, right = slopes(heights, head, sample, k), slopes(heights, head, sample, k + 1)
    rise, m0, m1 = high[0] - low[0], span * left[0], span * right[0]
    c2, c3 = 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise
    t = (z - low[0]) / rise
    for _ in range(NEWTON):
        move = (z - low[0] - t * (m0 + t * (c2 + t * c3))) / (m0 + t * (2.0 * c2 + 3.0 * t * c3))
        t += move
        if abs(move) < NEARLY:
            break
    late = t * t * (3.0 - 2.0 * t)
    left_part, right_part = span * t * (1.0 - t) * (1.0 - t), span * t * t * (t - 1.0)
    return (
        heights[head, k] + t * span,
        (m0 + t * (2.0 * c2 + 3.0 * t * c3)) / span,
        low[1] + late * (high[1] - low[1]) + left_part * left[1] + right_part * right[1],
        low[2] + late * (high[2] - low[2]) + left_part * left[2] + right_part * right[2],
        low[3] + late * (high[3] - low[3]) + left_part * left[3] + right_part * right[3],
    )


@kernel
def share_out(table, cell, branch, heights, place, ty, tr, tw, w, sample):
    """Patches of one pose: linear between the corners of its cell and in w. Returns how many.

    Where a part of the contact ends within the cell its share fades with the corners that have it, and the rest is
    taken from them. Parts that the grid could not follow from corner to corner come together where they lie.
    """
    ay, ar, aw = 1.0 - ty, 1.0 - tr, 1.0 - tw
    q0, q1, q2, q3 = ay * ar, ty * ar, ay * tr, ty * tr
    full = (q0 * aw, q1 * aw, q2 * aw, q3 * aw, q0 * tw, q1 * tw, q2 * tw, q3 * tw)
    head = table["levels"]
    k = 0
    while k < HEIGHTS - 2 and w > heights[head, k + 1]:
        k += 1
    t = (w - heights[head, k]) / (heights[head, k + 1] - heights[head, k])
    t = min(max(t, 0.0), 1.0)
    root = sqrt(w)
    count = 0
    for b in range(table["branch_base"] + cell[place], table["branch_base"] + cell[place + 1]):
        n, weights, part = reached(branch, b, full)
        if part < 1e-9:
            continue
        at = table["parts"] + k
        rows = (
            at + HEIGHTS * n[0], at + HEIGHTS * n[1], at + HEIGHTS * n[2], at + HEIGHTS * n[3],
            at + HEIGHTS * n[4], at + HEIGHTS * n[5], at + HEIGHTS * n[6], at + HEIGHTS * n[7],
        )  # fmt: skip
        mix_two(heights, rows, weights, sample, AT)
        share = part * between(sample, SHARE, t)
        if share > 0.0:
            count = gather(sample, count, share, t, root)
    return count


@kernel
def gather(sample, count, share, t, root):
    """Add the part of the contact at hand to the patches; one that lies within another is the same.

    t, root : its place between two heights, and w^0.5 [J^0.2].  Returns how many patches there are.
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
    """A member of `Part` between the two heights at hand."""
    below, above = sample[AT, channel], sample[AT, HEIGHTS + channel]
    return below + t * (above - below)


@kernel
def reached(branch, b, w):
    """Nodes of branch b, any where it does not reach, weights of the corners that it reaches, and their sum before.

    The weights are scaled to a sum of one.
    """
    c0, c1, c2, c3 = branch[b, 0], branch[b, 1], branch[b, 2], branch[b, 3]
    c4, c5, c6, c7 = branch[b, 4], branch[b, 5], branch[b, 6], branch[b, 7]
    n = max(c0, 0), max(c1, 0), max(c2, 0), max(c3, 0), max(c4, 0), max(c5, 0), max(c6, 0), max(c7, 0)
    w0, w1 = w[0] if c0 >= 0 else 0.0, w[1] if c1 >= 0 else 0.0
    w2, w3 = w[2] if c2 >= 0 else 0.0, w[3] if c3 >= 0 else 0.0
    w4, w5 = w[4] if c4 >= 0 else 0.0, w[5] if c5 >= 0 else 0.0
    w6, w7 = w[6] if c6 >= 0 else 0.0, w[7] if c7 >= 0 else 0.0
    part = (w0 + w1 + w2 + w3) + (w4 + w5 + w6 + w7)
    share = 1.0 / max(part, 1e-300)
    return n, (w0 * share, w1 * share, w2 * share, w3 * share, w4 * share, w5 * share, w6 * share, w7 * share), part
