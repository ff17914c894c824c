"""Kalker's linear creep coefficients of an elliptic contact of two equal bodies.

Table E.3 of Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), for semi-axes between 1 : 10 and
10 : 1; beyond, his asymptotes for slender ellipses. The semi-axis a lies in the rolling direction.
"""

import math

import numpy as np

from .jit import kernel

SEAM = 0.1  # g = min(a/b, b/a) where the table ends and the asymptotes begin

# [a <= b, a >= b][g = 0.1, 0.2, ... 1.0][C11, C22, C23, C33][nu = 0, 1/4, 1/2]
TABLE = np.array(
    [
        [
            [[2.51, 3.31, 4.85], [2.51, 2.52, 2.53], [0.334, 0.473, 0.731], [6.42, 8.28, 11.7]],
            [[2.59, 3.37, 4.81], [2.59, 2.63, 2.66], [0.483, 0.603, 0.809], [3.46, 4.27, 5.66]],
            [[2.68, 3.44, 4.80], [2.68, 2.75, 2.81], [0.607, 0.715, 0.889], [2.49, 2.96, 3.72]],
            [[2.78, 3.53, 4.82], [2.78, 2.88, 2.98], [0.720, 0.823, 0.977], [2.02, 2.32, 2.77]],
            [[2.88, 3.62, 4.83], [2.88, 3.01, 3.14], [0.827, 0.929, 1.07], [1.74, 1.93, 2.22]],
            [[2.98, 3.72, 4.91], [2.98, 3.14, 3.31], [0.930, 1.03, 1.18], [1.56, 1.68, 1.86]],
            [[3.09, 3.81, 4.97], [3.09, 3.28, 3.48], [1.03, 1.14, 1.29], [1.43, 1.50, 1.60]],
            [[3.19, 3.91, 5.05], [3.19, 3.41, 3.65], [1.13, 1.25, 1.40], [1.34, 1.37, 1.42]],
            [[3.29, 4.01, 5.12], [3.29, 3.54, 3.82], [1.23, 1.36, 1.51], [1.27, 1.27, 1.27]],
            [[3.40, 4.12, 5.20], [3.40, 3.67, 3.98], [1.33, 1.47, 1.63], [1.21, 1.19, 1.16]],
        ],
        [
            [[10.7, 11.7, 12.9], [10.7, 12.8, 16.0], [12.2, 14.6, 18.0], [0.795, 0.526, 0.228]],
            [[6.96, 7.78, 8.82], [6.96, 8.14, 9.79], [5.72, 6.63, 7.89], [0.828, 0.601, 0.341]],
            [[5.57, 6.34, 7.34], [5.57, 6.40, 7.51], [3.79, 4.32, 5.01], [0.868, 0.674, 0.446]],
            [[4.84, 5.57, 6.57], [4.84, 5.48, 6.31], [2.88, 3.24, 3.70], [0.912, 0.747, 0.549]],
            [[4.37, 5.10, 6.11], [4.37, 4.90, 5.56], [2.35, 2.62, 2.96], [0.958, 0.819, 0.650]],
            [[4.06, 4.78, 5.80], [4.06, 4.50, 5.04], [2.01, 2.23, 2.50], [1.01, 0.892, 0.751]],
            [[3.82, 4.54, 5.58], [3.82, 4.21, 4.67], [1.76, 1.95, 2.18], [1.05, 0.965, 0.852]],
            [[3.65, 4.36, 5.42], [3.65, 3.99, 4.39], [1.58, 1.75, 1.94], [1.10, 1.04, 0.954]],
            [[3.51, 4.22, 5.30], [3.51, 3.81, 4.16], [1.44, 1.59, 1.77], [1.16, 1.11, 1.06]],
            [[3.40, 4.12, 5.20], [3.40, 3.67, 3.98], [1.33, 1.47, 1.63], [1.21, 1.19, 1.16]],
        ],
    ]
)


@kernel
def tabulated(side, column, g, poisson):
    """One coefficient from the table: linear in g, then 1/C quadratic in Poisson's ratio.

    side 0: a <= b, 1: a >= b; column 0..3: C11, C22, C23, C33. Below the table the first interval is continued.
    """
    position = g / SEAM - 1.0
    row = 0
    if position > 0.0:
        row = int(min(position, 8.0))
    part = position - row
    low = TABLE[side, row, column]
    high = TABLE[side, row + 1, column]
    none = low[0] + part * (high[0] - low[0])
    quarter = low[1] + part * (high[1] - low[1])
    half = low[2] + part * (high[2] - low[2])
    return 1.0 / (
        (1.0 - 4.0 * poisson) * (1.0 - 2.0 * poisson) / none
        + 8.0 * poisson * (1.0 - 2.0 * poisson) / quarter
        + 2.0 * poisson * (4.0 * poisson - 1.0) / half
    )


@kernel
def short_asymptotes(g, poisson):
    """Coefficients (C11, C22, C23, C33) of an ellipse much shorter than wide, a << b, g = a / b.

    C33 follows from C11 strip by strip: the spin phi is a longitudinal creepage phi y.
    """
    plane = math.pi * math.pi / 4.0
    drift = math.log(16.0 / g) - 5.0
    return (
        plane / (1.0 - poisson),
        plane,
        math.pi * math.sqrt(g) * (1.0 + poisson * drift) / (3.0 * (1.0 - poisson)),
        plane / (4.0 * g * (1.0 - poisson)),
    )


@kernel
def long_asymptotes(g, poisson):
    """Coefficients (C11, C22, C23) of an ellipse much longer than wide, a >> b, g = b / a."""
    slender = math.log(16.0 / (g * g))
    bulge = 3.0 - math.log(4.0)
    strain = 1.0 - poisson
    along = slender - 2.0 * poisson
    across = strain * slender + 2.0 * poisson
    turn = strain * slender - 2.0 + 4.0 * poisson
    return (
        2.0 * math.pi * (1.0 + bulge / along) / (g * along),
        2.0 * math.pi * (1.0 + strain * bulge / across) / (g * across),
        2.0 * math.pi / (3.0 * g * math.sqrt(g) * turn),
    )


@kernel
def _joined(asymptote, at_seam, in_table, g):
    """Asymptote times a factor that leads, linearly in g, from 1 at g = 0 to the table at the seam."""
    return asymptote * (1.0 + (in_table / at_seam - 1.0) * g / SEAM)


@kernel
def coefficients(a_over_b, poisson):
    """Kalker's coefficients of the linear creep law.

    Beyond the table each asymptote takes a factor, linear in g, that meets the table at g = 0.1 and leaves the
    limit g -> 0 exact. C33 of long ellipses (a > 10 b) continues the table's last interval. A numerical solution of
    the linear theory at a : b of 1 : 20 and 20 : 1 agrees within 5 %.

    Parameters
    ----------
    a_over_b : float
        Semi-axis in the rolling direction over the lateral one, > 0 [-].
    poisson : float
        Poisson's ratio of both bodies, 0 to 1/2 [-].

    Returns
    -------
    c11, c22, c23, c33 : float
        Longitudinal, lateral, lateral to spin, spin [-].
    """
    side = 0 if a_over_b <= 1.0 else 1
    g = a_over_b if side == 0 else 1.0 / a_over_b
    c11 = tabulated(side, 0, max(g, SEAM), poisson)
    c22 = tabulated(side, 1, max(g, SEAM), poisson)
    c23 = tabulated(side, 2, max(g, SEAM), poisson)
    if not g < SEAM:
        return c11, c22, c23, tabulated(side, 3, g, poisson)
    if side == 0:
        c33 = tabulated(side, 3, SEAM, poisson)
        far11, far22, far23, far33 = short_asymptotes(g, poisson)
        seam11, seam22, seam23, seam33 = short_asymptotes(SEAM, poisson)
        c33 = _joined(far33, seam33, c33, g)
    else:
        c33 = tabulated(side, 3, g, poisson)
        far11, far22, far23 = long_asymptotes(g, poisson)
        seam11, seam22, seam23 = long_asymptotes(SEAM, poisson)
    return _joined(far11, seam11, c11, g), _joined(far22, seam22, c22, g), _joined(far23, seam23, c23, g), c33


@kernel
def stiffness(a, b, shear_modulus, poisson):
    """Coefficients of the linear creep law for an ellipse of semi-axes a (rolling direction), b > 0 [m].

    shear_modulus [Pa] and Poisson's ratio are those of both bodies. Returns f11 [N], f22 [N], f23 [N m], f33 [N m^2].
    """
    c11, c22, c23, c33 = coefficients(a / b, poisson)
    area = a * b
    length = math.sqrt(area)
    f = shear_modulus * area
    return f * c11, f * c22, f * length * c23, f * area * c33
