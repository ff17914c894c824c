"""Non-Hertzian contact patches by virtual penetration (theory.md section 6.5).

Kik and Piotrowski (2008, Vehicle System Dynamics 46, 27-48), with two corrections of our own: the virtual penetration
and the stretching of its outline are chosen so that a gap of constant curvature gives Hertz's ellipse, pressure and
force exactly; and the gap is that of the pressed profiles, so that the patch of conforming arcs may be centred beside
the rigid contact.

Right-hand wheel, poses and profile graphs as in `difference`. s is the profile coordinate of the wheel.
"""

from math import pi, sqrt

import numpy as np

from .difference import GOLDEN, locus, slope_difference, wheel_axes
from .hertz import ellipse
from .jit import builder, kernel
from .layout import NODE_CHANNELS, PATCH_PENETRATIONS, PATCH_ROWS, PRESS_CHANNELS, Node

CLIMB = 0.1e-3  # step towards the place of greatest approach [m]
CLIMB_STEPS = 60
STRIDE = 0.15e-3  # first step towards an edge of the patch [m]
STRIDE_GROWTH = 1.15
REACH = 15e-3  # no patch extends farther from its centre [m]
SOFTEST = 0.1  # smallest lateral curvature of the gap, half of tabulate.MIN_CURVATURE [1/m]
FIRST_SHARE = 0.5  # virtual penetration over approach of a circular contact, to begin with

# Gauss points and weights on 0 ... 1, and the place on a half patch that each stands for: t^2 (3 - 2 t), which flattens
# the logarithm at the centre and the root at the edge.
_X, _W = np.polynomial.legendre.leggauss(10)
_T = 0.5 * (_X + 1.0)
PLACE = _T * _T * (3.0 - 2.0 * _T)
WEIGHT = 0.5 * _W * 6.0 * _T * (1.0 - _T)


@kernel
def approach(s, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Interpenetration of the undeformed profiles along the rail's normal, T standing at z = depth; and rail slope."""
    _, gap, slope = slope_difference(s, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    return (depth - gap) / sqrt(1.0 + slope * slope), slope


@kernel
def summit(s, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Place of greatest approach, climbing from s [m]."""
    here, _ = approach(s, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    step = CLIMB
    after, _ = approach(s + step, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    if after <= here:
        step = -CLIMB
        after, _ = approach(s + step, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    for _ in range(CLIMB_STEPS):
        if after <= here:
            break
        s, here = s + step, after
        after, _ = approach(s + step, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    low, high = s - CLIMB, s + CLIMB
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, _ = approach(left, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    at_right, _ = approach(right, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    for _ in range(11):
        if at_left < at_right:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right, _ = approach(right, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        else:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left, _ = approach(left, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    return 0.5 * (low + high)


@kernel
def edge(s, way, stride, level, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Where the approach falls to `level` on one side (way -1 or +1) of s [m]; at most REACH away.

    Growing strides, then false position with halved ends (the Illinois rule).
    """
    stop = max(min(REACH, (w0 + wh * (wheel.shape[0] - 1) - s) if way > 0.0 else s - w0), CLIMB)
    near, far = 0.0, min(stride, stop)
    above, _ = approach(s, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    below, _ = approach(s + way * far, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    above, below = above - level, below - level
    while below > 0.0:
        if far >= stop:
            return s + way * stop
        near, above, far = far, below, min(far + stride, stop)
        stride *= STRIDE_GROWTH
        below, _ = approach(s + way * far, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        below -= level
    for _ in range(5):
        middle = near + (far - near) * above / (above - below)
        value, _ = approach(s + way * middle, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        value -= level
        if value > 0.0:
            near, above, below = middle, value, 0.5 * below
        else:
            far, below, above = middle, value, 0.5 * above
    return s + way * (near + (far - near) * above / (above - below))


@kernel
def integral_difference(m):
    """K(m) - E(m), complete elliptic integrals of parameter m in [0, 1), by the arithmetic-geometric mean."""
    a, b, c, power, total = 1.0, sqrt(1.0 - m), sqrt(m), 0.5, 0.5 * m
    for _ in range(12):
        if abs(c) < 1e-12:
            break
        a, b, c = 0.5 * (a + b), sqrt(a * b), 0.5 * (a - b)
        power *= 2.0
        total += power * c * c
    return total * pi / (2.0 * a)


@kernel
def strip(c, offset):
    """Integral of sqrt(c^2 - x^2) / sqrt(x^2 + offset^2) over a strip of half length c: its pull at the centre [m]."""
    square = c * c + offset * offset
    return 2.0 * sqrt(square) * integral_difference(c * c / square)


@kernel
def virtual_share(along, across, young, poisson):
    """Hertz's a / d^0.5 and b / d^0.5, and the virtual penetration over d that has the area of his ellipse."""
    ca, cb, k = ellipse(along, across, young, poisson)
    root = k ** (1.0 / 3.0)
    a, b = ca * root, cb * root
    return a, b, a * b * sqrt(along * across)


@kernel
def patch(s, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh, young, poisson):
    """The patch around a contact point.

    Parameters
    ----------
    s : float
        Profile coordinate of the rigid contact point [m].
    depth : float
        Height z of the wheel's reference point, beyond D at s [m].
    y ... gh
        Lateral position, axes and profile graphs as in `difference`.
    young, poisson : float
        Of both bodies [Pa], [-].

    Returns
    -------
    normal : float
        Elastic force [N].
    semi_x, semi_y : float
        Semi-axes of the ellipse of the same area and of the ratio that Hertz gives for the patch's mean curvature [m].
    pressure : float
        Greatest [Pa].
    at, slope, radius : float
        Means weighted by the load: profile coordinate [m], slope of the resultant's normal (tangent of the contact
        angle) [-], distance from the axle [m].
    centre, left, right : float
        Profile coordinates of the greatest approach and of the edges [m].
    level : float
        Approach at the edges [m].
    stretch : float
        Of the outline across; along it is the inverse [-].
    """
    centre = summit(s, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    deepest, slope = approach(centre, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    _, _, _, radius = locus(centre, e, f, d, r0, wheel, w0, wh)
    along = 0.5 / (radius * sqrt(1.0 + slope * slope))
    share = FIRST_SHARE
    level = (1.0 - share) * deepest
    left = edge(centre, -1.0, STRIDE, level, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    right = edge(centre, 1.0, STRIDE, level, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    width = (right - left) * sqrt(1.0 + slope * slope)
    _, _, share = virtual_share(along, max(4.0 * share * deepest / (width * width), SOFTEST), young, poisson)
    level = (1.0 - share) * deepest
    to_left, to_right = centre - left, right - centre
    left = edge(centre, -1.0, to_left, level, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    right = edge(centre, 1.0, to_right, level, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)

    py0, pz0, _, _ = locus(centre, e, f, d, r0, wheel, w0, wh)
    load, across = 0.0, 0.0
    for way in range(2):
        span = left - centre if way == 0 else right - centre
        lowest = deepest
        for i in range(PLACE.size):
            h, lean = approach(
                centre + span * PLACE[i], depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh
            )
            lowest = min(lowest, h)
            load += max(lowest - level, 0.0) * WEIGHT[i] * abs(span) * sqrt(1.0 + lean * lean)
    virtual = deepest - level
    across = max((4.0 / 3.0) ** 2 * virtual**3 / (load * load), SOFTEST)
    a, b, _ = virtual_share(along, across, young, poisson)
    a, b = a * sqrt(deepest), b * sqrt(deepest)
    stretch = b / sqrt(virtual / across)

    load, pull, area, at, sideways, upright, mean_radius = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for way in range(2):
        span = left - centre if way == 0 else right - centre
        lowest = deepest
        for i in range(PLACE.size):
            here = centre + span * PLACE[i]
            h, lean = approach(here, depth, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
            py, pz, _, r = locus(here, e, f, d, r0, wheel, w0, wh)
            lowest = min(lowest, h)
            square = a * a * max(lowest - level, 0.0) / virtual
            c = sqrt(square)
            tall = sqrt(1.0 + lean * lean)
            breadth = WEIGHT[i] * abs(span) * tall * stretch
            offset = stretch * sqrt((py - py0) ** 2 + (pz - pz0) ** 2)
            weight = 0.5 * pi * square * breadth
            load += weight
            pull += strip(c, offset) * breadth if c > 0.0 else 0.0
            area += 2.0 * c * breadth
            at += weight * here
            sideways += weight * lean / tall
            upright += weight / tall
            mean_radius += weight * r
    normal = pi * young * deepest / (2.0 * (1.0 - poisson * poisson)) * load / pull
    same_area = sqrt(area / (pi * a * b))
    return (
        normal, a * same_area, b * same_area, normal * a / load,
        at / load, sideways / upright, mean_radius / load,
        centre, left, right, level, stretch,
    )  # fmt: skip


@builder
def fill_patches(
    roll, yaw, y_start, y_step, r0, seat, wheel, w0, wh, rail, g0, gh, young, poisson, counts, node, patches
):
    """Patch rows of the nodes of one orientation, PATCH_ROWS for each, at the penetrations PATCH_PENETRATIONS.

    counts : (n_y,) nodes per lateral position.  node : (n, NODE_CHANNELS).  patches : (n * PATCH_ROWS, NODE_CHANNELS)
    filled: for every penetration the members of `Press`.
    """
    e, f, d = wheel_axes(roll, yaw)
    n = 0
    for i in range(counts.size):
        y = y_start + i * y_step
        for _ in range(counts[i]):
            s, gap = node[n, Node.LATERAL], node[n, Node.GAP]
            for k in range(len(PATCH_PENETRATIONS)):
                p = PATCH_PENETRATIONS[k]
                normal, a, b, _, at, slope, radius, _, _, _, _, _ = patch(
                    s, gap + p, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh, young, poisson
                )
                depth = p / sqrt(1.0 + slope * slope)
                values = (normal / (depth * sqrt(depth)), a / sqrt(depth), b / sqrt(depth), at, slope, radius)
                for q in range(PRESS_CHANNELS):
                    place = k * PRESS_CHANNELS + q
                    patches[n * PATCH_ROWS + place // NODE_CHANNELS, place % NODE_CHANNELS] = values[q]
            n += 1
