"""Force elements between bodies (theory.md section 5); all vectors in ground axes unless said otherwise.

Every element derives from a potential (but for dampers and friction), so that force and reaction cancel with their
moments and the springs keep energy at finite rotations.
"""

from math import sqrt

from .curve import read_curve
from .friction import dry_force, dry_link, leaf_force, series_damper
from .jit import kernel
from .layout import Axes, Kind, Status
from .vec3 import accumulate, add, cross, dot, get, inward, outward, scale, sub


@kernel
def half_turn(lower, upper):
    """Relative rotation of two bodies: vector and scalar part of its quaternion, and of half of it.

    lower, upper : (3, 3) axes of the bodies. Valid below 120 degrees, far beyond what bodies of a vehicle do.
    """
    trace = 0.0
    for k in range(3):
        trace += lower[k, 0] * upper[k, 0] + lower[k, 1] * upper[k, 1] + lower[k, 2] * upper[k, 2]
    q0 = 0.5 * sqrt(max(1.0 + trace, 0.01))
    a = inward(lower, (upper[0, 1], upper[1, 1], upper[2, 1]))
    b = inward(lower, (upper[0, 2], upper[1, 2], upper[2, 2]))
    c = inward(lower, (upper[0, 0], upper[1, 0], upper[2, 0]))
    qv = scale(0.25 / q0, (a[2] - b[1], b[0] - c[2], c[1] - a[0]))
    h0 = sqrt(0.5 * (1.0 + q0))
    return qv, q0, scale(0.5 / h0, qv), h0


@kernel
def rotate(h, h0, v):
    """v turned by the unit quaternion (h0, h)."""
    t = scale(2.0, cross(h, v))
    return add(v, add(scale(h0, t), cross(h, t)))


@kernel
def joint_elements(model, data, j, half_step):
    """Add the forces and moments of joint j to its two frames. Returns a status.

    half_step : time over which dampers with series stiffness move implicitly (half the integrator's step [s]); 0 for
        their present rate, very large for settled dampers and friction without force.
    """
    joint = model.joint[j]
    lower, upper = data.frame[joint["lower"]], data.frame[joint["upper"]]
    axes_a, axes_b = lower["axes"], upper["axes"]
    qv, q0, hv, h0 = half_turn(axes_a, axes_b)
    mean = joint["axes"] == Axes.MEAN
    relative = sub(get(upper["omega_frame"]), get(lower["omega_frame"]))
    if mean:
        tilt = outward(axes_a, scale(1.0 / h0, hv))
        omega = add(get(lower["omega_frame"]), scale(0.5, sub(relative, cross(tilt, relative))))
    else:
        tilt = (0.0, 0.0, 0.0)
        omega = get(upper["omega_frame"])
    force_b = (0.0, 0.0, 0.0)
    moment_a = (0.0, 0.0, 0.0)
    moment_b = (0.0, 0.0, 0.0)
    couple = (0.0, 0.0, 0.0)
    for e in range(joint["first"], joint["first"] + joint["count"]):
        element = model.element[e]
        arm_a = outward(axes_a, get(element["lower"]))
        arm_b = outward(axes_b, get(element["upper"]))
        gap = sub(add(get(upper["position"]), arm_b), add(get(lower["position"]), arm_a))
        gap_rate = sub(
            add(get(upper["velocity"]), cross(get(upper["omega_frame"]), arm_b)),
            add(get(lower["velocity"]), cross(get(lower["omega_frame"]), arm_a)),
        )
        kind = element["kind"]
        if kind == Kind.LINK or kind == Kind.DRY_LINK:
            force = link_force(model, data, element, gap, gap_rate, half_step)
        else:
            gap_rate = sub(gap_rate, cross(omega, gap))
            if mean:
                conjugate = (-hv[0], -hv[1], -hv[2])
                d = rotate(conjugate, h0, inward(axes_a, gap))
                rate = rotate(conjugate, h0, inward(axes_a, gap_rate))
            else:
                d = inward(axes_b, gap)
                rate = inward(axes_b, gap_rate)
            if kind == Kind.BUSHING:
                force = bushing_force(model, element, d, rate)
                data.carried[e] = -force[2]
            elif kind == Kind.DRY:
                force = dry_force(data, element, d, rate, half_step)
            elif kind == Kind.LEAF:
                force = (0.0, 0.0, -leaf_force(model, data, element, d[2], half_step))
            else:
                data.fault[0] = e
                return Status.UNKNOWN_ELEMENT.value
            force = outward(axes_a, rotate(hv, h0, force)) if mean else outward(axes_b, force)
            couple = add(couple, cross(force, gap))
        force_b = add(force_b, force)
        moment_a = sub(moment_a, cross(arm_a, force))
        moment_b = add(moment_b, cross(arm_b, force))
    if mean:
        share = scale(0.5, add(couple, cross(tilt, couple)))
        moment_a = add(moment_a, sub(couple, share))
        moment_b = add(moment_b, share)
    else:
        moment_b = add(moment_b, couple)
    turn = joint["turn"]
    if turn[0] != 0.0 or turn[1] != 0.0 or turn[2] != 0.0:
        twist = scale(2.0, qv)
        stiff = (turn[0] * twist[0], turn[1] * twist[1], turn[2] * twist[2])
        stiff = sub(stiff, scale(dot(qv, stiff) / (1.0 + q0), qv))
        stiff = outward(axes_a, rotate(hv, h0, stiff))
        moment_a = add(moment_a, stiff)
        moment_b = sub(moment_b, stiff)
    accumulate(upper["force"], force_b)
    accumulate(lower["force"], scale(-1.0, force_b))
    accumulate(lower["moment"], moment_a)
    accumulate(upper["moment"], moment_b)
    return 0


@kernel
def bushing_force(model, element, d, rate):
    """Force on the upper body in the joint's axes; d, rate : upper end less lower end [m], [m/s]."""
    k, c, p, table = element["k"], element["c"], element["preload"], element["spring_curve"]
    fx = p[0] - k[0] * d[0] - c[0] * rate[0]
    fy = p[1] - k[1] * d[1] - c[1] * rate[1]
    fz = p[2] - k[2] * d[2] - c[2] * rate[2]
    if table[0] >= 0:
        fx -= read_curve(model.curve[table[0]], d[0])[0]
    if table[1] >= 0:
        fy -= read_curve(model.curve[table[1]], d[1])[0]
    if table[2] >= 0:
        fz -= read_curve(model.curve[table[2]], d[2])[0]
    return fx, fy, fz


@kernel
def link_force(model, data, element, gap, gap_rate, half_step):
    """Force of a link or of friction along a line on the upper body; gap, gap_rate : upper end less lower end."""
    length = sqrt(dot(gap, gap))
    along = scale(1.0 / length, gap)
    if element["kind"] == Kind.DRY_LINK:
        return scale(-dry_link(data, element, length, dot(along, gap_rate), half_step), along)
    stretch = length - element["length"]
    tension = element["preload"][0] + element["k"][0] * stretch
    if element["spring_curve"][0] >= 0:
        tension += read_curve(model.curve[element["spring_curve"][0]], stretch)[0]
    table = element["damper_curve"]
    if element["state"] >= 0:
        tension += series_damper(model, data, element, length, half_step)
    elif table >= 0:
        tension += read_curve(model.curve[table], dot(along, gap_rate))[0]
    else:
        tension += element["c"][0] * dot(along, gap_rate)
    return scale(-tension, along)


@kernel
def suspension(model, data, half_step):
    """Add the forces of all joints to data.frame and fill data.damper_rate. Returns a status."""
    for j in range(model.joint.size):
        status = joint_elements(model, data, j, half_step)
        if status != 0:
            return status
    return 0
