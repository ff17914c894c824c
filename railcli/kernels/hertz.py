"""Hertz's contact of two equal elastic bodies: ellipse, approach and pressure (Johnson, Contact Mechanics, chapter 4).

With a the longer semi-axis, b the shorter, kappa = b / a and the complete elliptic integrals of m = 1 - kappa^2,
D = (K - E) / m and B = K - D, the gap's curvatures along and across the long axis stand as
across / along = B / (kappa^2 D), and

    a^3 = 3 N D / (2 pi M along),   approach = 3 N K / (2 pi M a),   M = E / (2 (1 - nu^2)).
"""

import math

from .jit import kernel

_STEPS = 20  # bound of both iterations; three or four are used
_PRECISION = 1e-13  # of the logarithm of kappa
_MEAN_SPREAD = 1e-8  # arithmetic and geometric mean this close agree to rounding after one more step


@kernel
def elliptic(kappa):
    """Complete elliptic integrals (K, B, D, C) of the complementary modulus kappa > 0.

    D = (K - E) / m, B = K - D, C = (D - B) / m with m = 1 - kappa^2, by the arithmetic-geometric mean without
    a difference of near numbers at kappa = 1 (Abramowitz and Stegun 17.6).
    """
    m = 1.0 - kappa * kappa
    a = 0.5 * (1.0 + kappa)
    b = math.sqrt(kappa)
    spread = 0.5 * (1.0 - kappa)
    part = 0.25 / ((1.0 + kappa) * (1.0 + kappa))  # (spread / m)^2
    total = part
    weight = 1.0
    for _ in range(_STEPS):
        if not abs(spread) > _MEAN_SPREAD * a:
            break
        a, b, last = 0.5 * (a + b), math.sqrt(a * b), spread
        spread = last * last / (4.0 * a)
        part *= last * last / (16.0 * a * a)
        weight *= 2.0
        total += weight * part
    k = math.pi / (a + b)
    return k, k * (0.5 - m * total), k * (0.5 + m * total), 2.0 * k * total


@kernel
def axis_ratio(ratio):
    """Ratio kappa of the semi-axes (short / long), with its integrals K and D, for the ratio >= 1 of the curvatures.

    Newton on log(B / D) - 2 log(kappa) = log(ratio), whose slope in log(kappa) stays between -2 and -3/2, so that
    each step at least thirds the error from any start.
    """
    log_ratio = math.log(ratio)
    square = log_ratio * log_ratio
    # odd in log_ratio with the exact slope -2/3 at 0; the rest fitted to 1.3e-4 for ratios up to 1e4
    log_kappa = -log_ratio * (2.0 / 3.0 + square * (3.234e-2 + 1.923e-4 * square))
    log_kappa /= 1.0 + square * (5.310e-2 + 3.526e-4 * square)
    kappa, k, d = 1.0, 0.0, 0.0
    for _ in range(_STEPS):
        kappa = math.exp(log_kappa)
        k, b, d, c = elliptic(kappa)
        step = (math.log(b / d) - 2.0 * log_kappa - log_ratio) / (1.0 + c * (1.0 / d + kappa * kappa / b))
        log_kappa += step
        if not abs(step) > _PRECISION:
            break
    return kappa, k, d


@kernel
def ellipse(along, across, young, poisson):
    """Contact ellipse and stiffness of two equal bodies with the gap A x^2 + B y^2, for any normal force N.

    Parameters
    ----------
    along, across : float
        A (x, rolling direction) and B (y, lateral), both > 0 [1/m].
    young, poisson : float
        Young's modulus [Pa] and Poisson's ratio [-] of both bodies.

    Returns
    -------
    ca, cb : float
        Semi-axes a = ca N^(1/3) along x, b = cb N^(1/3) along y [m/N^(1/3)].
    k : float
        N = k delta^1.5 for the approach delta of the two bodies [N/m^1.5].
        All three are NaN where there is no ellipse: A or B not positive.
    """
    if not (along > 0.0 and across > 0.0):
        return math.nan, math.nan, math.nan
    low = min(along, across)
    kappa, k, d = axis_ratio(max(along, across) / low)
    flexibility = 3.0 * (1.0 - poisson * poisson) / (math.pi * young)
    long = (flexibility * d / low) ** (1.0 / 3.0)
    stiffness = long / (flexibility * k)
    stiffness *= math.sqrt(stiffness)
    if along <= across:
        return long, kappa * long, stiffness
    return kappa * long, long, stiffness


@kernel
def pressure(normal, a, b):
    """Greatest pressure [Pa] under the normal force [N] on an ellipse of semi-axes a, b [m]."""
    return 1.5 * normal / (math.pi * a * b)
