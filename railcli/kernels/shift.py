"""Rails beside their ideal place: the displacement at an arc length, and the axes of a displaced rail (theory.md 4.12).

Each rail moves as a rigid body: to the right and down by its displacement, and its direction with the slopes of it.
"""

from math import sqrt

from .jit import kernel
from .vec3 import add, scale, sub

IDEAL = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))  # axes of a rail in its place


@kernel
def hermite(node, i, t, h, k):
    """Value, slope and second derivative of the cubic between rows i and i + 1, t of the way, from channels k, k + 1.

    node : (n, ...) values in channel k and their slopes in channel k + 1 at distances h.
    """
    a, b = node[i, k], node[i + 1, k]
    da, db = h * node[i, k + 1], h * node[i + 1, k + 1]
    c2, c3 = 3.0 * (b - a) - 2.0 * da - db, 2.0 * (a - b) + da + db
    return (
        a + t * (da + t * (c2 + t * c3)),
        (da + t * (2.0 * c2 + t * 3.0 * c3)) / h,
        (2.0 * c2 + t * 6.0 * c3) / (h * h),
    )


@kernel
def shift_rail(model, side, s, rail):
    """Fill a RAIL with the displacement of its rail at arc length s; False when it is not given there."""
    param = model.param[0]
    place = (s - param["shift_start"]) / param["shift_step"]
    last = model.shift.shape[0] - 1
    if not (place >= 0.0 and place <= last):
        return False
    i = min(int(place), last - 1)
    first = 0 if side > 0.0 else 4
    y, dy, ddy = hermite(model.shift, i, place - i, param["shift_step"], first)
    z, dz, ddz = hermite(model.shift, i, place - i, param["shift_step"], first + 2)
    rail["lateral"], rail["lateral_slope"], rail["lateral_bend"] = y, dy, ddy
    rail["vertical"], rail["vertical_slope"], rail["vertical_bend"] = z, dz, ddz
    return True


@kernel
def rail_axes(rail):
    """Axes of a displaced rail in track axes: along it, right of it, down; it yaws and pitches with its slopes."""
    a, b = rail["lateral_slope"], rail["vertical_slope"]
    cy = 1.0 / sqrt(1.0 + a * a)
    sy = a * cy
    rise = b * cy
    cp = 1.0 / sqrt(1.0 + rise * rise)
    sp = rise * cp
    return (cy * cp, sy * cp, sp), (-sy, cy, 0.0), (-cy * sp, -sy * sp, cp)


@kernel
def turned(axes, v):
    """A vector of the rail's frame in track axes."""
    return add(scale(v[0], axes[0]), add(scale(v[1], axes[1]), scale(v[2], axes[2])))


@kernel
def course(rail, ahead):
    """Slopes of the displaced rail at a distance ahead of the wheelset, with a zero in front."""
    return (
        0.0,
        rail["lateral_slope"] + ahead * rail["lateral_bend"],
        rail["vertical_slope"] + ahead * rail["vertical_bend"],
    )


@kernel
def along_bent(rail, axes, normal, arm, down):
    """Arm from the wheelset's centre to the contact where the rail bends: the normal there leans with the slope there.

    normal, arm : of the rail taken as straight.  down : length of the arm's part along the normal [m].
    """
    bend = normal[1] * rail["lateral_bend"] + normal[2] * rail["vertical_bend"]
    return sub(arm, scale(down * bend * arm[0] / (1.0 + bend * down * axes[0][0]), axes[0]))
