"""Normal overlap of a wheel with the strips of a rail, and how it changes with the pose (theory.md section 6.7).

Right-hand wheel, poses and profile graphs as in `difference`. The overlap of a strip is the distance from its middle,
against the rail's normal there, to the outline of the wheel as seen along the rail.
"""

from math import sqrt

import numpy as np

from .difference import ahead, height
from .jit import kernel

NEAR = 2e-7  # distance from a strip's normal that the outline's tangent bridges: 2e-12 of the overlap [m]
STEPS = 12
PACES = 0.2, 5.0  # limits of the pace that two steps show over that of the outline's direction
LOST = 2e-6  # distance from a strip's normal after as many steps: the search went astray [m]
SCANNED, PITCH = 60, 25e-6  # stations to each side in the search that is done then, and their distance [m]
LEAST_MOVE = 0.05e-3  # between strips from which the pace along the wheel is taken [m]
LEAST_LEAN = 0.3  # cosine between the normals of wheel and rail below which a strip does not count
LEAST_FALL = 0.1  # downward component of the wheel's normal from which the pace of the search is taken

OVERLAP = np.dtype(
    [
        ("h", "f8"),  # normal overlap; not positive: none [m]
        ("by_y", "f8"),  # its derivatives by the pose: lateral position, height [-], roll, yaw [m/rad]
        ("by_z", "f8"),
        ("by_roll", "f8"),
        ("by_yaw", "f8"),
        ("lateral", "f8"),  # profile coordinate on the wheel [m]
        ("radius", "f8"),  # distance from the axle [m]
        ("ahead", "f8"),  # of the bottom, along the rail [m]
        ("half", "f8"),  # half length of its pressure along the rail, where it bears [m]
    ],
    align=True,
)


@kernel
def outline(s, e, f, d, r0, wheel, w0, wh):
    """Point of the wheel's outline against T (x, y, z), its normal there (y, z; into the rail) and its radius.

    The outline is the contact locus of `difference.locus`: its normal has no component along the rail.
    """
    value, slope = height(wheel, w0, wh, s)
    radius = r0 + value
    sine, cosine = ahead(slope, e, f, d)
    down = radius * cosine - r0
    ny = cosine * d[1] + sine * f[1] - slope * e[1]
    nz = cosine * d[2] - slope * e[2]
    size = 1.0 / sqrt(ny * ny + nz * nz)
    return (
        s * e[0] + radius * sine * f[0] + down * d[0],
        s * e[1] + radius * sine * f[1] + down * d[1],
        s * e[2] + down * d[2],
        ny * size,
        nz * size,
        radius,
    )


@kernel
def deepest(s, ny, nz, out_y, out_z, e, f, d, r0, wheel, w0, wh):
    """Where the outline around s crosses a strip's normal, the deepest of several; s itself where it does not [m].

    A rough wheel at a large yaw has an outline that folds, or runs several times as far as its profile coordinate.
    """
    best, depth, old = s, -np.inf, 0.0
    for k in range(-SCANNED, SCANNED + 1):
        at = s + k * PITCH
        _, py, pz, _, _, _ = outline(at, e, f, d, r0, wheel, w0, wh)
        off = (py - out_y) * nz - (pz - out_z) * ny
        h = (py - out_y) * ny + (pz - out_z) * nz
        if k > -SCANNED and old < 0.0 <= off and h > depth:
            best, depth = at - PITCH * off / (off - old), h
        old = off
    return best


@kernel
def overlap(row, strip, s, y, z, e, f, d, r0, wheel, w0, wh):
    """Fill the OVERLAP of one strip; returns the profile coordinate of the wheel on its normal [m].

    s : where to begin.  y, z : of T in the axes of the rail.
    """
    ny, nz = strip["normal_y"], strip["normal_z"]
    out_y, out_z = strip["y"] - y, strip["z"] - z
    x, py, pz, wy, wz, radius, off, lean = 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0
    for attempt in range(2):
        before, move = 0.0, 0.0
        for _ in range(STEPS):
            x, py, pz, wy, wz, radius = outline(s, e, f, d, r0, wheel, w0, wh)
            off = (py - out_y) * nz - (pz - out_z) * ny
            lean = wy * ny + wz * nz
            pace = max(wz, LEAST_FALL) / max(lean, LEAST_LEAN)
            turn = pace * (before - off)
            if move * turn > 0.0 and PACES[0] < move / turn < PACES[1]:
                pace *= move / turn
            before, move = off, pace * off
            s -= move
            if abs(off) < NEAR:
                break
        if abs(off) < LOST or attempt == 1:
            break
        s = deepest(s + move, ny, nz, out_y, out_z, e, f, d, r0, wheel, w0, wh)
    across = (wz * ny - wy * nz) / max(lean, LEAST_LEAN)
    met = lean > LEAST_LEAN and abs(off) < LOST
    row["h"] = (py - out_y) * ny + (pz - out_z) * nz - off * across if met else 0.0
    share = 1.0 / max(lean, LEAST_LEAN)
    row["by_y"], row["by_z"] = share * wy, share * wz
    row["by_roll"] = share * (wz * (f[0] * py - f[1] * x) - wy * f[0] * pz)
    row["by_yaw"] = share * wy * x
    row["lateral"], row["radius"], row["ahead"] = s, radius, x
    return s


@kernel
def spread(start, y, z, e, f, d, r0, seat, wheel, w0, wh, strip, row, h):
    """Overlaps of all strips that hang together around a place of the wheel; those of other places may be filled.

    start : profile coordinate of a minimum of the difference surface [m].  y : of T about nominal [m].
    row : OVERLAP (n,), h : (n,) filled where the bodies overlap; h is to be 0 elsewhere before.
    Returns the range of strips, empty where the wheel does not reach the rail or the place was filled before.
    """
    _, py, _, _, _, _ = outline(start, e, f, d, r0, wheel, w0, wh)
    at = np.searchsorted(strip["y"], y + seat + py)
    first, last = at, at
    if at < strip.size and h[at] > 0.0:
        return first, last
    for way in range(2):
        s, pace, place = start, 1.0, y + seat + py
        i = at - way
        while 0 <= i and i < strip.size:
            move = strip[i]["y"] - place
            guess = s + pace * move
            after = overlap(row[i], strip[i], guess, y + seat, z, e, f, d, r0, wheel, w0, wh)
            if not row[i]["h"] > 0.0:
                break
            h[i] = row[i]["h"]
            first, last = min(first, i), max(last, i + 1)
            if abs(move) > LEAST_MOVE:
                pace = min(max((after - s) / move, 0.5), 2.0)
            s, place = after, strip[i]["y"]
            i += 1 - 2 * way
    return first, last
