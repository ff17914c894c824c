"""The track frame at arc length s (theory.md section 2)."""

from math import sqrt

from .jit import kernel
from .layout import PATH_ORDER
from .trig import sine_cosine
from .vec3 import put


@kernel
def find_piece(track, s):
    """Index of the piece that holds arc length s; -1 when s is off the track or not a number."""
    last = track.size - 1
    if not (s >= track[0]["start"] and s <= track[last]["start"] + track[last]["length"]):
        return -1
    low, high = 0, last
    while low < high:
        middle = (low + high + 1) // 2
        if track[middle]["start"] <= s:
            low = middle
        else:
            high = middle - 1
    return low


@kernel
def cubic(c, u):
    """Value and first derivative of c0 + c1 u + c2 u^2 + c3 u^3."""
    return c[0] + u * (c[1] + u * (c[2] + u * c[3])), c[1] + u * (2.0 * c[2] + u * 3.0 * c[3])


@kernel
def turning(track, i, s, cant_base):
    """Rotation and motion of the track frame per metre at arc length s on piece i, in track axes.

    Returns the rotation k [1/m], the motion of its origin [-], and sine and cosine of cant angle and gradient angle.
    """
    piece = track[i]
    u = s - piece["start"]
    curvature, _ = cubic(piece["curvature"], u)
    cant, cant_slope = cubic(piece["cant"], u)
    sc = cant / cant_base
    cc = sqrt(1.0 - sc * sc)
    roll = cant_slope / (cant_base * cc)
    rise = piece["lift"] * cant_slope
    if piece["graded"] == 0:
        return (roll, curvature * sc, curvature * cc), (1.0, -rise * sc, -rise * cc), (sc, cc, 0.0, 1.0)
    bend = piece["gradient"][1]
    sg, cg = sine_cosine(piece["gradient"][0] + u * bend)
    level = curvature * cg
    k = (roll - curvature * sg, level * sc + bend * cc, level * cc - bend * sc)
    return k, (1.0 + rise * sg, -rise * cg * sc, -rise * cg * cc), (sc, cc, sg, cg)


@kernel
def power_series(c, u):
    """c0 u + c1 u^2 + ... of PATH_ORDER coefficients."""
    total = 0.0
    for k in range(PATH_ORDER - 1, -1, -1):
        total = (total + c[k]) * u
    return total


@kernel
def place(track, i, s, cant_base, frame):
    """Fill a FRAME's `track`, `rate`, `advance` and `position` (of the track frame's origin) at s on piece i.

    The track frame is turned by heading (about z), gradient (about y, front up) and cant (about x), with sin cant =
    height of left over right rail over `cant_base`. s is the length of the alignment's line, which has the frame's x
    axis for its tangent; the origin stands vertically over it by `lift` times cant (theory.md, 2.3).
    """
    piece = track[i]
    u = s - piece["start"]
    along, right = power_series(piece["path_x"], u), power_series(piece["path_y"], u)
    k0, h0 = piece["curvature"], piece["cant"]
    turn = u * (k0[0] + u * (k0[1] / 2.0 + u * (k0[2] / 3.0 + u * k0[3] / 4.0)))
    k, advance, (sc, cc, sg, cg) = turning(track, i, s, cant_base)
    c0, s0 = piece["cos_heading"], piece["sin_heading"]
    down = piece["z"]
    if piece["graded"] != 0:
        down += power_series(piece["path_z"], u)
    if piece["lift"] != 0.0:
        down -= piece["lift"] * (h0[0] + u * (h0[1] + u * (h0[2] + u * h0[3])))
    frame["position"][0] = piece["x"] + c0 * along - s0 * right
    frame["position"][1] = piece["y"] + s0 * along + c0 * right
    frame["position"][2] = down
    put(frame["rate"], k)
    put(frame["advance"], advance)
    st, ct = sine_cosine(turn)
    ch, sh = c0 * ct - s0 * st, s0 * ct + c0 * st
    axes = frame["track"]
    axes[0, 0], axes[0, 1], axes[0, 2] = ch * cg, ch * sg * sc - sh * cc, ch * sg * cc + sh * sc
    axes[1, 0], axes[1, 1], axes[1, 2] = sh * cg, sh * sg * sc + ch * cc, sh * sg * cc - ch * sc
    axes[2, 0], axes[2, 1], axes[2, 2] = -sg, cg * sc, cg * cc
