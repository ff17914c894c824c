"""One contact patch: where it is, how fast it is approached, its normal force (theory.md sections 6.1 to 6.3).

Track axes at the wheelset's own s; forces are those on the wheel.
"""

from math import sqrt

from .jit import kernel
from .shift import along_bent, course, turned
from .vec3 import add, cross, dot, scale, sub


@kernel
def power_1_5(x):
    """x^1.5."""
    return x * sqrt(x)


@kernel
def normal_force(param, hertz, elastic, approach):
    """N = k1 (d^1.5 + damping sign(d') |d'|^g2 d^g3), never pulling; d, d' = approach and its rate along the normal.

    elastic : d^1.5, less what merging took [m^1.5].  Hunt and Crossley (1975) with g2 = 1, g3 = 1.5.
    """
    if param["damping_rate_power"] == 1.0 and param["damping_depth_power"] == 1.5:
        damped = elastic * approach
    else:
        depth = elastic ** (2.0 / 3.0 * param["damping_depth_power"])
        damped = depth * abs(approach) ** param["damping_rate_power"]
        damped = damped if approach > 0.0 else -damped
    return max(hertz * (elastic + param["damping"] * damped), 0.0)


@kernel
def place_patch(model, data, w, axes, axle, contact, slope, lateral, radius, rate_y, rate_z):
    """Fill the place of a patch; returns the rate of approach there [m/s].

    slope : of the rail, track axes.  lateral, radius : on the wheel [m].  Others: as `touch_wheel`.
    """
    shifted = model.shift.shape[0] > 0
    wheel, rail = model.wheel[w], data.rail[w]
    body = wheel["body"]
    frame = data.frame[body]
    turn = (data.rate[body, 3] * frame["cosine"][2], data.rate[body, 3] * frame["sine"][2], data.rate[body, 5])
    cosine = 1.0 / sqrt(1.0 + slope * slope)
    normal = (0.0, -slope * cosine, cosine)
    if shifted:
        normal = turned(axes, normal)
    lean = dot(normal, axle)
    down = radius / sqrt(1.0 - lean * lean)
    along = wheel["side"] * (wheel["lateral"] + lateral) - down * lean
    arm = add(scale(along, axle), scale(down, normal))
    if shifted:
        arm = along_bent(rail, axes, normal, arm, down)
    moved = add(cross(turn, arm), (0.0, data.rate[body, 1] - rate_y, data.rate[body, 2] - rate_z))
    if shifted:
        moved = sub(moved, scale(data.rate[body, 0], course(rail, arm[0])))
    contact["slope"] = slope
    contact["lateral"] = lateral
    contact["radius"] = radius
    contact["arm"][0], contact["arm"][1], contact["arm"][2] = arm
    return dot(normal, moved)


@kernel
def push(param, contact, hertz, elastic, depth, approach):
    """Fill the normal force of a patch and its slopes by depth and rate of approach."""
    normal = normal_force(param, hertz, elastic, approach)
    contact["normal"] = normal
    contact["stiffness"] = 1.5 * normal / depth
    contact["viscosity"] = hertz * elastic * param["damping"]
