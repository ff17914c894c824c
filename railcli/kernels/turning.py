"""Moments between two bodies: relative rotation, rotational stiffness, torques, and the matrix of all six motions.

Theory.md sections 5.1, 5.4 and 5.9 to 5.11. The components of the rotation vector q are the same in the axes of both
bodies and in those halfway between them, the mean axes.
"""

from math import sqrt

from .curve import read_curve
from .implicit import slip_torque, write_line
from .jit import kernel, seldom
from .vec3 import add, cross, dot, get, inward, outward, scale, sub


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
def axis(m, k):
    """Column k of a (3, 3) array: an axis in ground axes."""
    return m[0, k], m[1, k], m[2, k]


@kernel
def conjugate(q, q0, v):
    """(1 - q q^T / (1 + q0)) v: from relative angular velocity to d(2 q)/dt, and from a moment on 2 q to the bodies."""
    return sub(v, scale(dot(q, v) / (1.0 + q0), q))


@kernel
def turn_moment(turn, axes_a, q, q0, h, h0):
    """Moment of rotational stiffness on the lower body, ground axes; the opposite acts on the upper one."""
    stiff = (2.0 * turn[0] * q[0], 2.0 * turn[1] * q[1], 2.0 * turn[2] * q[2])
    return outward(axes_a, rotate(h, h0, conjugate(q, q0, stiff)))


@kernel
def axle_moment(turn, wheelset, other):
    """Moment on a wheelset of rotational stiffness that holds its axle in the other body's axes; ground axes.

    wheelset, other : (3, 3) axes. It depends on the direction of the axle alone and has no part about it.
    """
    axle = axis(wheelset, 1)
    ahead, down = axis(other, 0), axis(other, 2)
    slope = add(scale(turn[2] * dot(axle, ahead), ahead), scale(turn[0] * dot(axle, down), down))
    return cross(slope, axle)


@kernel
def matrix_load(matrix, d, rate, q, q0, spin):
    """Force on the upper body in the joint's axes and moment on it in mean axes, of a stiffness and damping matrix.

    d, rate : upper end less lower end in the joint's axes [m], [m/s].  spin : relative angular velocity in mean axes.
    """
    turned, turning = scale(2.0, q), conjugate(q, q0, spin)
    force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(3):
        force = sub(force, scale(d[k], get(matrix[k])))
        moment = sub(moment, scale(d[k], (matrix[k, 3], matrix[k, 4], matrix[k, 5])))
        force = sub(force, scale(turned[k], get(matrix[3 + k])))
        moment = sub(moment, scale(turned[k], (matrix[3 + k, 3], matrix[3 + k, 4], matrix[3 + k, 5])))
        force = sub(force, scale(rate[k], get(matrix[6 + k])))
        moment = sub(moment, scale(rate[k], (matrix[6 + k, 3], matrix[6 + k, 4], matrix[6 + k, 5])))
        force = sub(force, scale(turning[k], get(matrix[9 + k])))
        moment = sub(moment, scale(turning[k], (matrix[9 + k, 3], matrix[9 + k, 4], matrix[9 + k, 5])))
    return force, conjugate(q, q0, moment)


@seldom
def torque_moment(model, data, joint, element, q, q0, h, h0, moving):
    """Moment of a torque element on the upper body, ground axes; the opposite acts on the lower one.

    About the axle of a wheelset it acts on the spin. Else its axis stands in the mean axes; its spring follows the
    component of 2 q along it.
    moving : whether what acts implicitly takes its tension from the step, or its present rate.
    """
    upper, lower = data.frame[joint["upper"]], data.frame[joint["lower"]]
    about = get(element["lower"])
    spring, spring_direction = 0.0, (0.0, 0.0, 0.0)
    if model.body[joint["lower"]]["spins"]:
        direction = scale(about[1], axis(lower["axes"], 1))
        rate = dot(direction, sub(get(upper["omega_frame"]), get(lower["omega"])))
    elif model.body[joint["upper"]]["spins"]:
        direction = scale(about[1], axis(upper["axes"], 1))
        rate = dot(direction, sub(get(upper["omega"]), get(lower["omega_frame"])))
    else:
        direction = outward(lower["axes"], rotate(h, h0, about))
        rate = dot(direction, sub(get(upper["omega"]), get(lower["omega"])))
        angle = 2.0 * dot(q, about)
        spring = element["k"][0] * angle
        if element["spring_curve"][0] >= 0:
            spring += read_curve(model.curve[element["spring_curve"][0]], angle)[0]
        spring_direction = outward(lower["axes"], rotate(h, h0, conjugate(q, q0, about)))
    tension = -element["preload"][0]
    curve, row = element["damper_curve"][0], element["stiff"][0]
    if row >= 0 and moving:
        tension += data.tension[row]
        write_line(data, joint, row, (0.0, 0.0, 0.0), direction, scale(-1.0, direction), rate)
        data.stiff[row]["curve"], data.stiff[row]["damping"] = curve, element["c"][0]
        data.stiff[row]["friction"] = element["limit"]
    else:
        tension += slip_torque(element["limit"], rate)
        if curve >= 0:
            tension += read_curve(model.curve[curve], rate)[0]
        else:
            tension += element["c"][0] * rate
    return sub(scale(-tension, direction), scale(spring, spring_direction))
