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
    """Rotation of the track frame per metre at arc length s on piece i, in track axes [1/m]; sine of the cant angle."""
    piece = track[i]
    u = s - piece["start"]
    curvature, _ = cubic(piece["curvature"], u)
    cant, cant_slope = cubic(piece["cant"], u)
    sc = cant / cant_base
    cc = sqrt(1.0 - sc * sc)
    return (cant_slope / (cant_base * cc), curvature * sc, curvature * cc), sc, cc


@kernel
def place(track, i, s, cant_base, frame):
    """Fill a FRAME's `track`, `rate` and `position` (of the track frame's origin) at arc length s on piece i.

    The track frame is heading (about z), then cant (about x); the plan is level. Its rotation per metre, in its own
    axes, is (d cant angle/ds, curvature sin cant, curvature cos cant), with sin cant = height of left over right rail
    over `cant_base`. The centre line is the pivot of cant.
    """
    piece = track[i]
    u = s - piece["start"]
    along, right = 0.0, 0.0
    px, py = piece["path_x"], piece["path_y"]
    for k in range(PATH_ORDER - 1, -1, -1):
        along = (along + px[k]) * u
        right = (right + py[k]) * u
    c0, s0 = piece["cos_heading"], piece["sin_heading"]
    frame["position"][0] = piece["x"] + c0 * along - s0 * right
    frame["position"][1] = piece["y"] + s0 * along + c0 * right
    frame["position"][2] = 0.0
    k0 = piece["curvature"]
    turn = u * (k0[0] + u * (k0[1] / 2.0 + u * (k0[2] / 3.0 + u * k0[3] / 4.0)))
    k, sc, cc = turning(track, i, s, cant_base)
    put(frame["rate"], k)
    st, ct = sine_cosine(turn)
    ch, sh = c0 * ct - s0 * st, s0 * ct + c0 * st
    axes = frame["track"]
    axes[0, 0], axes[0, 1], axes[0, 2] = ch, -sh * cc, sh * sc
    axes[1, 0], axes[1, 1], axes[1, 2] = sh, ch * cc, -ch * sc
    axes[2, 0], axes[2, 1], axes[2, 2] = 0.0, sc, cc
