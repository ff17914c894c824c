"""Creep laws of one factor on the linear force: their limits, symmetries and derivatives."""

import math

import naive
import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels import creep
from railcli.kernels.layout import Creep

F11, F22, F23, F33 = 8.1e6, 7.3e6, 1.4e4, 31.0  # of a wheel under 80 kN
LINEAR = np.array([[F11, 0, 0], [0, F22, F23], [0, -F23, F33]])
LIMIT = 24e3
LAWS = pytest.mark.parametrize("law", [Creep.HARD, Creep.SMOOTH], ids=lambda law: law.name)
SMALL, TYPICAL, LARGE = 1e-5, 1e-3, 3e-2


def random_creepages(size, count=50):
    rng = np.random.default_rng(7)
    return rng.normal(size=(count, 3)) * size * np.array([1, 1, 100])


def forces(law, creepage, limit=LIMIT):
    return np.array(creep.forces(int(law), F11, F22, F23, F33, limit, *creepage))


def jacobian(law, creepage, limit=LIMIT):
    values = creep.forces_and_jacobian(int(law), F11, F22, F23, F33, limit, *creepage)
    return np.array(values[:3]), np.array(values[3:]).reshape(3, 3)


def ratio(creepage):
    return np.hypot(*(LINEAR @ creepage)[:2]) / LIMIT


@LAWS
@pytest.mark.parametrize("size", [SMALL, TYPICAL, LARGE])
def test_same_as_twin(law, size):
    for creepage in random_creepages(size):
        twin = naive.creep_forces(law == Creep.SMOOTH, LINEAR, LIMIT, creepage)
        assert_allclose(forces(law, creepage), twin, rtol=tol.ROUNDING, atol=tol.ROUNDING * LIMIT)


@LAWS
def test_small_creepage_is_linear(law):
    """The smooth cubic leaves the line by a third of the share of the limit that is used; the hard law not at all."""
    for creepage in random_creepages(SMALL):
        allowed = ratio(creepage) / 3 if law == Creep.SMOOTH else 0
        assert_allclose(forces(law, creepage), -LINEAR @ creepage, rtol=allowed + tol.ROUNDING)


@LAWS
def test_large_creepage_gives_the_friction_limit(law):
    for creepage in random_creepages(10.0):
        assert_allclose(np.hypot(*forces(law, creepage)[:2]), LIMIT, rtol=tol.ROUNDING)


@LAWS
def test_full_slip_is_opposed_where_both_directions_are_equally_stiff(law):
    slip = np.array([0.3, -0.4])
    tx, ty, _ = creep.forces(int(law), F11, F11, 0.0, F33, LIMIT, *slip, 0.0)
    assert_allclose((tx, ty), -LIMIT * slip / 0.5, rtol=tol.ROUNDING)


@LAWS
def test_pure_spin(law):
    phi = 0.2
    tx, ty, mz = forces(law, (0.0, 0.0, phi))
    assert tx == 0
    assert -LIMIT < ty < 0
    assert_allclose(mz / ty, F33 / F23, rtol=tol.ROUNDING)


@LAWS
@pytest.mark.parametrize("limit", [0.0, -1.0])
@pytest.mark.parametrize("creepage", [(1e-3, 2e-3, 0.1), (0.0, 0.0, 0.0)])
def test_no_force_without_normal_force(law, limit, creepage):
    assert not forces(law, creepage, limit).any()
    assert not np.concatenate([part.ravel() for part in jacobian(law, creepage, limit)]).any()


@LAWS
def test_no_force_without_creepage(law):
    force, tangent = jacobian(law, (0.0, 0.0, 0.0))
    assert not force.any()
    assert_allclose(tangent, -LINEAR)


@LAWS
def test_not_a_number_stays_visible(law):
    assert np.isnan(forces(law, (math.nan, 0.0, 0.0))).any()
    assert np.isnan(forces(law, (1e-3, 0.0, 0.0), math.nan)).any()


@LAWS
def test_factor_slope_and_bounds(law):
    ratios = np.linspace(1e-3, 8, 4001)
    factor, slope = np.array([creep.saturation(int(law), r) for r in ratios]).T
    assert (factor > 0).all() and (factor <= 1).all()
    assert (factor * ratios <= 1 + tol.ROUNDING).all()
    assert (np.diff(factor * ratios) > -tol.ROUNDING).all()
    ahead, behind = (np.array([creep.saturation(int(law), r + h)[0] for r in ratios]) for h in (1e-6, -1e-6))
    smooth = abs(ratios - 1) > 2e-6 if law == Creep.HARD else np.ones(len(ratios), bool)
    assert_allclose(((ahead - behind) / 2e-6)[smooth], slope[smooth], atol=tol.DIFFERENCE_QUOTIENT)


@LAWS
def test_factor_is_continuous_where_pieces_meet(law):
    for corner in (1.0, 3.0):
        below, above = (creep.saturation(int(law), corner * (1 + h))[0] for h in (-1e-12, 1e-12))
        assert_allclose(below, above, rtol=1e-11)


def test_corner_of_the_hard_law_counts_as_saturated():
    assert creep.saturation(int(Creep.HARD), 1.0) == (1.0, -1.0)


def test_smooth_law_has_no_corner():
    below, above = (creep.saturation(int(Creep.SMOOTH), 3.0 + h)[1] for h in (-1e-9, 1e-9))
    assert_allclose((below, above), -1 / 9, rtol=1e-8)


@LAWS
@pytest.mark.parametrize("size", [SMALL, TYPICAL, LARGE])
def test_tangent_is_the_derivative(law, size):
    for creepage in random_creepages(size):
        if law == Creep.HARD and abs(ratio(creepage) - 1) < 1e-3:
            continue
        force, tangent = jacobian(law, creepage)
        assert_allclose(force, forces(law, creepage), rtol=tol.ROUNDING)
        for column, scale in enumerate((1, 1, 100)):
            step = np.zeros(3)
            step[column] = 1e-5 * size * scale
            quotient = (forces(law, creepage + step) - forces(law, creepage - step)) / (2 * step[column])
            assert_allclose(quotient, tangent[:, column], atol=tol.DIFFERENCE_QUOTIENT * abs(LINEAR[:, column]).max())


@LAWS
@pytest.mark.parametrize("size", [SMALL, TYPICAL, LARGE])
def test_creep_only_dissipates(law, size):
    """With one factor on forces and moment the spin terms cancel: no condition but f11, f22, f33 >= 0."""
    for creepage in random_creepages(size):
        power = forces(law, creepage) @ creepage
        factor = creep.saturation(int(law), ratio(creepage))[0]
        assert power < 0
        assert_allclose(power, -factor * (np.array([F11, F22, F33]) @ creepage**2), rtol=tol.ROUNDING)


@LAWS
def test_rotation_about_the_normal(law):
    """A round patch of a material without Poisson effect knows no direction: f11 = f22 and no coupling to spin."""
    for xi, eta, phi in random_creepages(TYPICAL):
        c, s = math.cos(0.7), math.sin(0.7)
        tx, ty, mz = creep.forces(int(law), F11, F11, 0.0, F33, LIMIT, xi, eta, phi)
        turned = creep.forces(int(law), F11, F11, 0.0, F33, LIMIT, c * xi - s * eta, s * xi + c * eta, phi)
        assert_allclose(turned, (c * tx - s * ty, s * tx + c * ty, mz), rtol=tol.ROUNDING, atol=tol.ROUNDING * LIMIT)


@LAWS
def test_mirror_image(law):
    """Seen in a mirror along the rail, lateral slip and spin change sign, and so do lateral force and moment."""
    for creepage in random_creepages(TYPICAL):
        assert_allclose(forces(law, creepage * (1, -1, -1)), forces(law, creepage) * (1, -1, -1), rtol=tol.ROUNDING)
