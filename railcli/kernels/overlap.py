"""Normal overlap of a wheel with the strips of a rail, and how it changes with the pose (theory.md section 6.7).

Right-hand wheel, poses and profile graphs as in `difference`. The overlap of a strip is the distance from its middle,
against the rail's normal there, to the outline of the wheel as seen along the rail.
"""

from math import sqrt

import numpy as np

from .difference import ahead, height
from .jit import kernel

SOLVED = 1e-10  # [m]
STEPS = 12
LEAST_LEAN = 0.3  # cosine between the normals of wheel and rail below which a strip does not count

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
def overlap(row, strip, s, y, z, e, f, d, r0, wheel, w0, wh):
    """Fill the OVERLAP of one strip; returns the profile coordinate of the wheel on its normal [m].

    s : where to begin.  y, z : of T in the axes of the rail.
    """
    ny, nz = strip["normal_y"], strip["normal_z"]
    out_y, out_z = strip["y"] - y, strip["z"] - z
    x, py, pz, wy, wz, radius = outline(s, e, f, d, r0, wheel, w0, wh)
    off = (py - out_y) * nz - (pz - out_z) * ny
    rate = 1.0
    for _ in range(STEPS):
        if abs(off) < SOLVED:
            break
        move = -off / rate
        s += move
        x, py, pz, wy, wz, radius = outline(s, e, f, d, r0, wheel, w0, wh)
        after = (py - out_y) * nz - (pz - out_z) * ny
        slope = (after - off) / move
        if 0.2 < slope and slope < 5.0:
            rate = slope
        off = after
    lean = wy * ny + wz * nz
    row["h"] = (py - out_y) * ny + (pz - out_z) * nz if lean > LEAST_LEAN else 0.0
    share = 1.0 / max(lean, LEAST_LEAN)
    row["by_y"], row["by_z"] = share * wy, share * wz
    row["by_roll"] = share * (wz * (f[0] * py - f[1] * x) - wy * f[0] * pz)
    row["by_yaw"] = share * wy * x
    row["lateral"], row["radius"], row["ahead"] = s, radius, x
    return s


@kernel
def spread(start, y, z, e, f, d, r0, seat, wheel, w0, wh, strip, row, h):
    """Overlaps of all strips that hang together around a place of the wheel; those after it may be filled already.

    start : profile coordinate of a minimum of the difference surface [m].  y : of T about nominal [m].
    row : OVERLAP (n,), h : (n,) filled where the bodies overlap; h is to be 0 elsewhere before.
    Returns the range of strips, empty where the wheel does not reach the rail.
    """
    _, py, _, _, _, _ = outline(start, e, f, d, r0, wheel, w0, wh)
    at = np.searchsorted(strip["y"], y + seat + py)
    first, last = at, at
    s = start
    i = at
    while i < strip.size:
        s = overlap(row[i], strip[i], s, y + seat, z, e, f, d, r0, wheel, w0, wh)
        if not row[i]["h"] > 0.0:
            break
        h[i] = row[i]["h"]
        i += 1
        last = i
        if i < strip.size:
            s += strip[i]["y"] - strip[i - 1]["y"]
    s = start
    i = at - 1
    while i >= 0:
        s = overlap(row[i], strip[i], s, y + seat, z, e, f, d, r0, wheel, w0, wh)
        if not row[i]["h"] > 0.0:
            break
        h[i] = row[i]["h"]
        first = i
        if i > 0:
            s += strip[i - 1]["y"] - strip[i]["y"]
        i -= 1
    return first, last
