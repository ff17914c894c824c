"""Force elements between bodies (theory.md section 5); all vectors in ground axes unless said otherwise.

Every element derives from a potential (but for dampers and friction), so that force and reaction cancel with their
moments and the springs keep energy at finite rotations.
"""

from math import sqrt

from .curve import read_curve
from .friction import dry_force, dry_link, leaf_force, series_damper
from .implicit import write_line
from .jit import kernel
from .layout import Axes, Kind, Status
from .turning import axis, axle_moment, half_turn, matrix_load, rotate, torque_moment, turn_moment
from .vec3 import accumulate, add, cross, dot, get, inward, outward, scale, sub


@kernel
def joint_elements(model, data, j, half_step, moving):
    """Add the forces and moments of joint j to its two frames. Returns a status.

    half_step : time over which dampers with series stiffness move implicitly (half the integrator's step [s]); 0 for
        their present rate, very large for settled dampers and friction without force.
    moving : whether implicit dampers take their tension from the step, or from their present rate.
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
    conjugate = (-hv[0], -hv[1], -hv[2])
    force_b = (0.0, 0.0, 0.0)
    moment_a = (0.0, 0.0, 0.0)
    moment_b = (0.0, 0.0, 0.0)
    couple = (0.0, 0.0, 0.0)
    for e in range(joint["first"], joint["first"] + joint["count"]):
        element = model.element[e]
        kind = element["kind"]
        if kind == Kind.TORQUE:
            turn_b = torque_moment(model, data, joint, element, qv, q0, hv, h0, moving)
            moment_b = add(moment_b, turn_b)
            moment_a = sub(moment_a, turn_b)
            continue
        arm_a = outward(axes_a, get(element["lower"]))
        arm_b = outward(axes_b, get(element["upper"]))
        gap = sub(add(get(upper["position"]), arm_b), add(get(lower["position"]), arm_a))
        gap_rate = sub(
            add(get(upper["velocity"]), cross(get(upper["omega_frame"]), arm_b)),
            add(get(lower["velocity"]), cross(get(lower["omega_frame"]), arm_a)),
        )
        if kind == Kind.LINK or kind == Kind.DRY_LINK:
            force = link_force(model, data, joint, element, gap, gap_rate, arm_a, arm_b, half_step, moving)
        else:
            gap_rate = sub(gap_rate, cross(omega, gap))
            if mean:
                d = rotate(conjugate, h0, inward(axes_a, gap))
                rate = rotate(conjugate, h0, inward(axes_a, gap_rate))
            else:
                d = inward(axes_b, gap)
                rate = inward(axes_b, gap_rate)
            if kind == Kind.BUSHING or kind == Kind.AIR:
                local = bushing_force(model, data, element, d, rate, half_step, moving)
                data.carried[e] = -local[2]
                if element["dampers"] and moving:
                    for k in range(3):
                        if element["stiff"][k] >= 0:
                            along = outward(axes_a, rotate(hv, h0, unit(k))) if mean else axis(axes_b, k)
                            on_a, on_b = split(cross(along, gap), tilt, mean)
                            on_a, on_b = sub(on_a, cross(arm_a, along)), add(on_b, cross(arm_b, along))
                            write_damper(data, joint, element, k, along, on_b, on_a, rate[k])
            elif kind == Kind.DRY:
                local = dry_force(data, element, d, rate, half_step)
            elif kind == Kind.LEAF:
                local = (0.0, 0.0, -leaf_force(model, data, element, d[2], half_step))
            elif kind == Kind.MATRIX:
                spin = rotate(conjugate, h0, inward(axes_a, relative))
                local, turned = matrix_load(model.matrix[element["matrix"]], d, rate, qv, q0, spin)
                local = add(local, get(element["preload"]))
                turned = outward(axes_a, rotate(hv, h0, turned))
                moment_b = add(moment_b, turned)
                moment_a = sub(moment_a, turned)
            else:
                data.fault[0] = e
                return Status.UNKNOWN_ELEMENT.value
            force = outward(axes_a, rotate(hv, h0, local)) if mean else outward(axes_b, local)
            couple = add(couple, cross(force, gap))
        force_b = add(force_b, force)
        moment_a = sub(moment_a, cross(arm_a, force))
        moment_b = add(moment_b, cross(arm_b, force))
    on_a, on_b = split(couple, tilt, mean)
    moment_a, moment_b = add(moment_a, on_a), add(moment_b, on_b)
    turn = joint["turn"]
    if turn[0] != 0.0 or turn[1] != 0.0 or turn[2] != 0.0:
        if model.body[joint["lower"]]["spins"]:
            stiff = axle_moment(turn, axes_a, axes_b)
        elif model.body[joint["upper"]]["spins"]:
            stiff = scale(-1.0, axle_moment(turn, axes_b, axes_a))
        else:
            stiff = turn_moment(turn, axes_a, qv, q0, hv, h0)
        moment_a = add(moment_a, stiff)
        moment_b = sub(moment_b, stiff)
    accumulate(upper["force"], force_b)
    accumulate(lower["force"], scale(-1.0, force_b))
    accumulate(lower["moment"], moment_a)
    accumulate(upper["moment"], moment_b)
    return 0


@kernel
def split(couple, tilt, mean):
    """Shares of lower and upper body in the couple of a bushing whose ends are apart (5.6)."""
    if mean:
        share = scale(0.5, add(couple, cross(tilt, couple)))
        return sub(couple, share), share
    return (0.0, 0.0, 0.0), couple


@kernel
def unit(k):
    """Axis k."""
    return 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0


@kernel
def bushing_force(model, data, element, d, rate, half_step, moving):
    """Force of a bushing or air spring on the upper body in the joint's axes; d, rate : upper end less lower end."""
    k, c, p, table = element["k"], element["c"], element["preload"], element["spring_curve"]
    if element["dampers"]:
        fx = p[0] - k[0] * d[0] - damping(model, data, element, 0, rate[0], moving)
        fy = p[1] - k[1] * d[1] - damping(model, data, element, 1, rate[1], moving)
        fz = p[2] - k[2] * d[2]
        if element["kind"] == Kind.AIR:
            fz -= series_damper(model, data, element, 2, d[2], half_step)
        else:
            fz -= damping(model, data, element, 2, rate[2], moving)
    else:
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
def damping(model, data, element, k, rate, moving):
    """Tension of damper k of an element: from the step where it acts implicitly, else of its rate."""
    if moving and element["stiff"][k] >= 0:
        return data.tension[element["stiff"][k]]
    if element["damper_curve"][k] >= 0:
        return read_curve(model.curve[element["damper_curve"][k]], rate)[0]
    return element["c"][k] * rate


@kernel
def write_damper(data, joint, element, k, along, upper_moment, lower_moment, rate):
    """Fill the line of an implicit damper k; along : from lower to upper end. As `write_line`."""
    row = element["stiff"][k]
    write_line(data, joint, row, along, upper_moment, lower_moment, rate)
    data.stiff[row]["curve"], data.stiff[row]["damping"] = element["damper_curve"][k], element["c"][k]


@kernel
def link_force(model, data, joint, element, gap, gap_rate, arm_a, arm_b, half_step, moving):
    """Force of a link or of friction along a line on the upper body; gap, gap_rate : upper end less lower end."""
    length = sqrt(dot(gap, gap))
    along = scale(1.0 / length, gap)
    rate = dot(along, gap_rate)
    if element["kind"] == Kind.DRY_LINK:
        return scale(-dry_link(data, element, length, rate, half_step), along)
    stretch = length - element["length"]
    tension = element["preload"][0] + element["k"][0] * stretch
    if element["spring_curve"][0] >= 0:
        tension += read_curve(model.curve[element["spring_curve"][0]], stretch)[0]
    if element["state"] >= 0:
        tension += series_damper(model, data, element, 0, length, half_step)
    else:
        tension += damping(model, data, element, 0, rate, moving)
        if moving and element["stiff"][0] >= 0:
            write_damper(data, joint, element, 0, along, cross(arm_b, along), scale(-1.0, cross(arm_a, along)), rate)
    return scale(-tension, along)


@kernel
def suspension(model, data, half_step, moving):
    """Add the forces of all joints to data.frame; fill data.damper_rate and, when moving, data.stiff. Returns a status.
    """
    for j in range(model.joint.size):
        status = joint_elements(model, data, j, half_step, moving)
        if status != 0:
            return status
    return 0
