"""Creep forces: the switch between the laws; Kalker's linear law, saturated by one factor; falling friction.

Contact axes: x along the rail in the rolling direction, n the rail's normal pointing into the rail, t = n x x; the
same right-handed axes on both wheels. Creepages xi, eta are the slip of the wheel over the rail along x and t,
divided by the speed [-], phi its angular velocity about n divided by the speed [1/m]; forces and moment act on the
wheel. The law reads the same for slip of rail over wheel with the forces on the rail.

Known limits of one factor on linear forces: at full slip the force keeps the direction of the linear force, not of
the slip, and a spin moment remains where the true one vanishes.
"""

import math

from . import creep_table, fastrip, fastsim, polach
from .jit import kernel
from .layout import Creep

_SHEN_END = 3.0  # linear force over limit where Shen's cubic reaches the limit


@kernel
def saturation(law, ratio):
    """Factor that limits the linear creep force, and its slope over ratio.

    HARD: the linear force, cut off at the friction limit. SMOOTH: the cubic of Shen, Hedrick and Elkins (1983,
    8th IAVSD Symposium). At the corner of HARD the slope is that of the saturated side.

    Parameters
    ----------
    law : int
        A member of `Creep`.
    ratio : float
        Linear force over friction limit, >= 0 [-].

    Returns
    -------
    factor, slope : float
        Force over linear force, in (0, 1], and its derivative with respect to ratio [-].
    """
    if law == Creep.SMOOTH and ratio < _SHEN_END:
        return 1.0 - ratio * (1.0 / 3.0 - ratio / 27.0), 2.0 * ratio / 27.0 - 1.0 / 3.0
    if law == Creep.HARD and ratio < 1.0:
        return 1.0, 0.0
    factor = 1.0 / ratio
    return factor, -factor * factor


@kernel
def linear_forces(f11, f22, f23, f33, xi, eta, phi):
    """Kalker's linear law: force on the wheel along x and t [N], spin moment about n [N m]."""
    return -f11 * xi, -f22 * eta - f23 * phi, f23 * eta - f33 * phi


@kernel
def forces(law, f11, f22, f23, f33, limit, xi, eta, phi):
    """Creep force and spin moment on the wheel in the contact axes.

    One factor saturates force and spin moment, and spin takes part in it through f23 phi. The power
    Tx xi + Ty eta + Mz phi = -factor (f11 xi^2 + f22 eta^2 + f33 phi^2) is never positive.

    Parameters
    ----------
    law : int
        HARD or SMOOTH of `Creep`.
    f11, f22, f23, f33, limit, xi, eta, phi : float
        As `tangential`.

    Returns
    -------
    tx, ty, mz : float
        [N, N, N m]
    """
    if limit <= 0.0:
        return 0.0, 0.0, 0.0
    x, y, m = linear_forces(f11, f22, f23, f33, xi, eta, phi)
    factor, _ = saturation(law, math.sqrt(x * x + y * y) / limit)
    return factor * x, factor * y, factor * m


@kernel
def forces_and_jacobian(law, f11, f22, f23, f33, limit, xi, eta, phi):
    """Creep force and spin moment as `forces`, with their derivatives by the creepages at constant limit.

    Returns
    -------
    tx, ty, mz : float
        [N, N, N m]
    tx_xi, tx_eta, tx_phi, ty_xi, ty_eta, ty_phi, mz_xi, mz_eta, mz_phi : float
        Rows tx, ty, mz; columns xi, eta, phi.
    """
    if limit <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, m = linear_forces(f11, f22, f23, f33, xi, eta, phi)
    size = math.sqrt(x * x + y * y)
    factor, slope = saturation(law, size / limit)
    pull = slope / (limit * size) if size > 0.0 else 0.0
    factor_xi = -pull * x * f11
    factor_eta = -pull * y * f22
    factor_phi = -pull * y * f23
    return (
        factor * x,
        factor * y,
        factor * m,
        factor_xi * x - factor * f11,
        factor_eta * x,
        factor_phi * x,
        factor_xi * y,
        factor_eta * y - factor * f22,
        factor_phi * y - factor * f23,
        factor_xi * m,
        factor_eta * m + factor * f23,
        factor_phi * m - factor * f33,
    )


@kernel
def tangential(param, table, adhesion, reduced_slip, a, b, f11, f22, f23, f33, limit, xi, eta, phi):
    """Creep force and spin moment on the wheel by the law of `param`, with their derivatives at constant limit.

    Every law is homogeneous: creepages and limit times c give c times force and moment.

    Parameters
    ----------
    param : PARAM
        Its `creep_law` and the settings of the laws.
    table : array (n, 4)
        `creep_table.tabulate` of this law; empty for those without.
    adhesion, reduced_slip : float
        Polach's reduction factors k_A, k_S; no other law knows them [-].
    a, b : float
        Semi-axes along the rail and across [m].
    f11, f22, f23, f33 : float
        Linear coefficients [N, N, N m, N m^2].
    limit : float
        Friction times normal force [N]; no force unless positive.
    xi, eta, phi : float
        Longitudinal, lateral [-] and spin [1/m] creepage.

    Returns
    -------
    tuple of 12 float
        tx, ty [N], mz [N m]; then the rows of their derivatives, columns xi, eta, phi.
    """
    law = param["creep_law"]
    if law == Creep.HARD or law == Creep.SMOOTH or limit <= 0.0:
        return forces_and_jacobian(law, f11, f22, f23, f33, limit, xi, eta, phi)
    if law == Creep.POLACH:
        return polach.forces_and_jacobian(
            adhesion, reduced_slip, a, b, f11, f22, f23, f33, limit, xi, eta, phi
        )
    ux, uy, wa = fastsim.scaled_creepages(f11, f22, f23, limit, xi, eta, phi)
    if law == Creep.FASTSIM:
        found = fastsim.rolling(ux, uy, wa, b / a, param["fastsim_grid"])
    else:
        levers = fastrip.levers(a, b, f22, f23, f33) if law == Creep.FASTRIP else creep_table.LEVERS
        found = creep_table.integrals(table, ux, uy, wa, b / a, levers)
    return fastsim.on_ellipse(found, a, b, f11, f22, f23, limit)


@kernel
def falling_friction(ratio, decay, friction, speed):
    """Coefficient of friction at a slip velocity, and its slope.

    mu = mu0 ((1 - A) exp(-B w) + A), Polach (2005), Wear 258, 992-1000. A large B gives two levels: mu0 in adhesion,
    A mu0 in slip.

    Parameters
    ----------
    ratio, decay : float
        A = friction at infinite over that at zero slip velocity [-], B [s/m].
    friction : float
        mu0 [-]
    speed : float
        Magnitude w of the slip velocity at the middle of the patch, without spin [m/s].

    Returns
    -------
    mu, slope : float
        [-], [s/m]
    """
    fallen = friction * (1.0 - ratio) * math.exp(-decay * speed)
    return friction * ratio + fallen, -decay * fallen
