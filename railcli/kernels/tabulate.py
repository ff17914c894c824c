"""From wheel poses to the nodes of a contact table (theory.md section 4)."""

from math import cos, isfinite, sin, sqrt

import numpy as np

from .branches import PER_CORNER
from .difference import (
    BARRIER_CAP,
    height,
    locus,
    mean_curvature,
    minima,
    prepare_scan,
    slope_difference,
    wheel_axes,
)
from .hertz import ellipse
from .jit import builder, kernel
from .kalker import stiffness
from .layout import Node, Region

MIN_CURVATURE = 0.2  # smallest relative lateral curvature; conformal contacts are held there [1/m]


@builder
def solve_orientation(
    method, roll, yaw, y, r0, seat, wheel, w0, wh, rail, g0, gh, station, found, counts
):
    """Minima for every lateral position y (n_y,) [m] of one orientation.

    found : (n_y, PER_CORNER, 6), counts : (n_y,) filled as `minima` says.
    Returns the number of evaluations of D and of poses with more than PER_CORNER minima.
    """
    e, f, d = wheel_axes(roll, yaw)
    n = station.size
    scan_y, scan_z, lowest = np.empty(n), np.empty(n), np.empty(n)
    prepare_scan(station, e, f, d, r0, wheel, w0, wh, scan_y, scan_z)
    evaluations, crowded = 0, 0
    for i in range(counts.size):
        total, used = minima(
            method, 0.0, y[i], e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh, station,
            scan_y, scan_z, lowest, found[i],
        )
        evaluations += used
        if total > PER_CORNER:
            crowded += 1
        counts[i] = keep_near(found[i], min(total, PER_CORNER))
    return evaluations, crowded


@kernel
def keep_near(found, count):
    """Move the minima within BARRIER_CAP of the deepest to the front; returns how many they are."""
    best = np.inf
    for j in range(count):
        best = min(best, found[j, 1])
    kept = 0
    for j in range(count):
        if found[j, 1] <= best + BARRIER_CAP:
            for k in range(6):
                found[kept, k] = found[j, k]
            kept += 1
    return kept


@kernel
def describe(s, y, roll, yaw, r0, seat, wheel, w0, wh, rail, g0, gh, young, poisson, regions, row):
    """Fill one node from a minimum at profile coordinate s, barriers apart.

    Slopes of D by the envelope theorem: the contact point may be held while the pose changes. Curvatures: wheel
    cos(contact angle)/radius along the rail (Meusnier) and the profiles' mean curvatures across.
    regions : (3,) profile coordinates that part tip | flank | root | tread [m].
    """
    e, f, d = wheel_axes(roll, yaw)
    py, pz, _, radius = locus(s, e, f, d, r0, wheel, w0, wh)
    _, gap, slope = slope_difference(s, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    _, wheel_slope = height(wheel, w0, wh, s)
    lean = (s + radius * wheel_slope) * cos(roll) + r0 * sin(roll)
    px = -sin(yaw) * lean
    row[Node.GAP] = gap
    row[Node.SLOPE], row[Node.GAP_Y] = slope, slope
    row[Node.GAP_ROLL] = -slope * cos(yaw) * pz - (cos(yaw) * py - sin(yaw) * px)
    row[Node.GAP_YAW2] = -0.5 * slope * lean * (sin(yaw) / yaw if yaw != 0.0 else 1.0)
    row[Node.LATERAL] = s
    row[Node.RADIUS], row[Node.WHEEL_SLOPE] = radius, wheel_slope
    cosine = 1.0 / sqrt(1.0 + slope * slope)
    across = mean_curvature(rail, g0, gh, y + seat + py) - mean_curvature(wheel, w0, wh, s)
    ca, cb, k = ellipse(0.5 * cosine / radius, 0.5 * max(across, MIN_CURVATURE), young, poisson)
    root = k ** (1.0 / 3.0)
    a, b = ca * root, cb * root
    f11, f22, f23, f33 = stiffness(a, b, 0.5 * young / (1.0 + poisson), poisson)
    row[Node.HERTZ] = k
    row[Node.SEMI_X], row[Node.SEMI_Y] = a, b
    row[Node.F11], row[Node.F22], row[Node.F23], row[Node.F33] = f11, f22, f23, f33
    if s < regions[0]:
        row[Node.REGION] = Region.TIP.value
    elif s < regions[1]:
        row[Node.REGION] = Region.FLANK.value
    elif s < regions[2]:
        row[Node.REGION] = Region.ROOT.value
    else:
        row[Node.REGION] = Region.TREAD.value


@kernel
def fill_nodes(
    roll, yaw, y_start, y_step, r0, seat, wheel, w0, wh, rail, g0, gh, young, poisson, regions,
    found, counts, node, basin,
):
    """Nodes of one orientation in the order of `found`; slopes of contact angle and place are left out.

    basin : (n, 2) filled with the ends of each minimum's basin [m].
    """
    n = 0
    for i in range(counts.size):
        for j in range(counts[i]):
            m = found[i, j]
            row = node[n]
            y = y_start + i * y_step
            describe(m[0], y, roll, yaw, r0, seat, wheel, w0, wh, rail, g0, gh, young, poisson, regions, row)
            row[Node.RADIUS] -= 0.5 * row[Node.WHEEL_SLOPE] * row[Node.LATERAL]
            row[Node.BARRIER_GAUGE] = min(m[2], BARRIER_CAP)
            row[Node.BARRIER_FIELD] = min(m[3], BARRIER_CAP)
            basin[n, 0] = m[4] if isfinite(m[4]) else -np.inf
            basin[n, 1] = m[5] if isfinite(m[5]) else np.inf
            n += 1
    return n
