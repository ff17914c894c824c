"""Kalker's simplified theory on an ellipse (FASTSIM), with its derivatives; theory.md section 7.6.

Stretched coordinates: x over the semi-axis a, y over b, traction over p0 = 2 mu N / (pi a b), so that the ellipse is
the unit circle and the traction bound 1 - x^2 - y^2. Then

    dpx/dx = ux - wb y,    dpy/dx = uy + wa x,    p = 0 at the leading edge,

marching from there (x > 0) to the trailing edge, with p cut back to the bound wherever it is larger. ux, uy and wa, wb
are the creepages in the scale of the bound (`scaled_creepages`); wa : wb = a : b. Forces are those on the wheel for
slip of the wheel over the rail.

Kalker (1982), Vehicle System Dynamics 11, 1-13. Range: steady rolling of an ellipse of Hertz, like materials, one
coefficient of friction in the patch; any creepage and spin. Against the full solution 0.03 mu N in the mean, 0.16 at
most; full slip is reached later, because the true pressure bounds traction by an ellipsoid.
"""

import math

from .jit import kernel

PER_FORCE = 3.0 * math.pi / 16.0  # ux, uy per linear force over friction limit
PER_SPIN = 2.0  # wa per linear lateral force of spin over friction limit


@kernel
def scaled_creepages(f11, f22, f23, limit, xi, eta, phi):
    """Creepages in the scale of the traction bound: ux, uy, wa [-].

    One flexibility for each direction and one for spin, L1 = 8 a / (3 G C11), L2 = 8 a / (3 G C22),
    L3 = pi a sqrt(a/b) / (4 G C23), with which the unsaturated forces are Kalker's.
    """
    per = 1.0 / limit
    return PER_FORCE * f11 * xi * per, PER_FORCE * f22 * eta * per, PER_SPIN * f23 * phi * per


@kernel
def rolling(ux, uy, wa, narrow, n):
    """Integrals of the traction over the unit circle, and their derivatives.

    n strips of equal width with n elements each. Tractions are those at the middle of an element, where the bound is
    the mean over the element, so that full slip gives its integral along a strip exactly.

    Parameters
    ----------
    ux, uy, wa : float
        Scaled creepages [-].
    narrow : float
        b / a, so that wb = narrow wa [-].
    n : int
        Strips, and elements of a strip.

    Returns
    -------
    tuple of 16 float
        Integrals of px, py, y px, x py times 2 / pi (forces over the friction limit, and the parts of the moment over
        limit times b and a); then their derivatives by ux, by uy, by wa, four each [-].
    """
    fx, fy, mx, my = 0.0, 0.0, 0.0, 0.0
    fx_u, fy_u, mx_u, my_u = 0.0, 0.0, 0.0, 0.0
    fx_v, fy_v, mx_v, my_v = 0.0, 0.0, 0.0, 0.0
    fx_w, fy_w, mx_w, my_w = 0.0, 0.0, 0.0, 0.0
    wide = 2.0 / n
    for i in range(n):
        y = (i + 0.5) * wide - 1.0
        half = math.sqrt(1.0 - y * y)
        h = 2.0 * half / n
        area = h * wide * 2.0 / math.pi
        mean = half * half - h * h / 12.0
        slip_x, turn_x = ux - narrow * wa * y, -narrow * y
        px, py = 0.0, 0.0
        px_u, py_u, px_v, py_v, px_w, py_w = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        x, way = half, 0.5 * h
        for _ in range(n):
            middle = x - 0.5 * way
            x -= way
            px -= slip_x * way
            py -= (uy + wa * middle) * way
            px_u -= way
            py_v -= way
            px_w -= turn_x * way
            py_w -= middle * way
            way = h
            bound = mean - x * x
            square = px * px + py * py
            if square > bound * bound:
                size = math.sqrt(square)
                factor, cx, cy = bound / size, px / size, py / size
                px, py = bound * cx, bound * cy
                along = cx * px_u + cy * py_u
                px_u, py_u = factor * (px_u - cx * along), factor * (py_u - cy * along)
                along = cx * px_v + cy * py_v
                px_v, py_v = factor * (px_v - cx * along), factor * (py_v - cy * along)
                along = cx * px_w + cy * py_w
                px_w, py_w = factor * (px_w - cx * along), factor * (py_w - cy * along)
            sx, sy = area * y, area * x
            fx, fy, mx, my = fx + area * px, fy + area * py, mx + sx * px, my + sy * py
            fx_u, fy_u, mx_u, my_u = fx_u + area * px_u, fy_u + area * py_u, mx_u + sx * px_u, my_u + sy * py_u
            fx_v, fy_v, mx_v, my_v = fx_v + area * px_v, fy_v + area * py_v, mx_v + sx * px_v, my_v + sy * py_v
            fx_w, fy_w, mx_w, my_w = fx_w + area * px_w, fy_w + area * py_w, mx_w + sx * px_w, my_w + sy * py_w
    return (
        fx, fy, mx, my, fx_u, fy_u, mx_u, my_u, fx_v, fy_v, mx_v, my_v, fx_w, fy_w, mx_w, my_w,
    )  # fmt: skip


@kernel
def on_ellipse(integrals, a, b, f11, f22, f23, limit):
    """Creep force, moment and their derivatives by the creepages from the integrals of `rolling`.

    Returns
    -------
    tuple of 12 float
        As `creep.tangential`.
    """
    fx, fy, mx, my, fx_u, fy_u, mx_u, my_u, fx_v, fy_v, mx_v, my_v, fx_w, fy_w, mx_w, my_w = integrals
    u, v, w = PER_FORCE * f11, PER_FORCE * f22, PER_SPIN * f23  # times limit: scaled creepages per creepage
    return (
        limit * fx, limit * fy, limit * (a * my - b * mx),
        u * fx_u, v * fx_v, w * fx_w,
        u * fy_u, v * fy_v, w * fy_w,
        u * (a * my_u - b * mx_u), v * (a * my_v - b * mx_v), w * (a * my_w - b * mx_w),
    )  # fmt: skip
