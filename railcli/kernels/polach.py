"""Polach's closed form of the creep force; theory.md section 7.5.

Polach (1999), A fast wheel-rail forces calculation computer code, Vehicle System Dynamics 33 (supplement), 728-739;
reduction factors: Polach (2005), Wear 258, 992-1000. Signs such that the force without slip is Kalker's.
"""

import math

from .dual import chain, multiple, plus, product
from .jit import kernel

STANDSTILL = 1e-24  # added to squares of creepages: at 1e-12 the direction of slip loses its meaning


@kernel
def inverse_root(square):
    """1 / sqrt(square + STANDSTILL) with derivatives."""
    root = 1.0 / math.sqrt(square[0] + STANDSTILL)
    return chain(root, -0.5 * root * root * root, square)


@kernel
def spin_moment_share(e):
    """Polach's K_M, the lateral force of spin over (9/16) a mu N (1 + 6.3 (1 - exp(-a/b))), at e >= 0; its slope.

    - 2 e / 3 without slip; never positive.
    """
    square = e * e
    per = 1.0 / (square + 1.0)
    d = (square - 1.0) * per
    bulge = e * per
    part = d * d * (d / 3.0 - 0.5) + 1.0 / 6.0
    value = e * part - 8.0 / 3.0 * bulge * bulge * bulge
    slope = part + 4.0 * bulge * bulge * d * (d - 1.0) - 8.0 * bulge * bulge * per * (1.0 - 2.0 * square * per)
    return value, slope


@kernel
def forces_and_jacobian(adhesion, slip, a, b, f11, f22, f23, f33, limit, xi, eta, phi):
    """Creep force and spin moment on the wheel, with their derivatives by the creepages at constant limit.

    One stress gradient, that of the direction of slip, for the force against the slip, and a lateral force of spin.
    Range: spin small against slip. In full slip spin takes from the force. The moment is our own addition (Polach gives
    none): that of the linear law times the share that is left of the force of spin, so that no power is gained.

    Parameters
    ----------
    adhesion, slip : float
        Reduction factors k_A, k_S of the stress gradient in the areas of adhesion and slip, 0 < k_S <= k_A <= 1 [-].
    a, b : float
        Semi-axes along the rail and across [m].
    f11, f22, f23, f33, limit, xi, eta, phi
        As `creep.tangential`.

    Returns
    -------
    tuple of 12 float
        As `creep.tangential`.
    """
    x, y, spin = (xi, 1.0, 0.0, 0.0), (eta, 0.0, 1.0, 0.0), (phi, 0.0, 0.0, 1.0)
    rim = plus(y, multiple(a, spin))  # slip across at the leading edge
    far = rim if abs(rim[0]) > abs(eta) else y
    xx, yy = product(x, x), product(y, y)
    per = inverse_root(plus(xx, product(far, far)))
    stiff = plus(multiple(f11 * f11, xx), multiple(f22 * f22, yy))
    stiff = (stiff[0] + f11 * f22 * STANDSTILL, stiff[1], stiff[2], stiff[3])
    root = math.sqrt(stiff[0])
    mean = product(chain(root, 0.5 / root, stiff), inverse_root(plus(xx, yy)))
    reach = chain(1.0 / per[0], -1.0 / (per[0] * per[0]), per)
    e = multiple(0.25 * math.pi / limit, product(mean, reach))
    near, beyond = adhesion * e[0], slip * e[0]
    curve = near / (1.0 + near * near) + math.atan(beyond)
    steep = adhesion * (1.0 - near * near) / (1.0 + near * near) ** 2 + slip / (1.0 + beyond * beyond)
    pull = multiple(2.0 / math.pi * limit, product(chain(curve, steep, e), per))
    widen = 1.0 + 6.3 * (1.0 - math.exp(-a / b))
    side = multiple(8.0 / 3.0 * f23 / (a * limit * widen), far)
    share, slope = spin_moment_share(abs(side[0]))
    turn = chain(share, slope if side[0] >= 0.0 else -slope, side)
    turn = multiple(-9.0 / 16.0 * a * limit * widen / f23, product(turn, per))
    tx = multiple(-1.0, product(pull, x))
    ty = multiple(-1.0, plus(product(pull, y), multiple(f23, product(turn, spin))))
    mz = product(turn, plus(multiple(f23, y), multiple(-f33, spin)))
    return tx[0], ty[0], mz[0], tx[1], tx[2], tx[3], ty[1], ty[2], ty[3], mz[1], mz[2], mz[3]
