"""Hertz's ellipse against elasticity itself, closed forms and an independent solution."""

import math

import naive
import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels import hertz

YOUNG, POISSON = 210e9, 0.28
MODULUS = YOUNG / (2 * (1 - POISSON**2))
CURVATURES = [(1.09, across) for across in (1.09e-4, 0.015, 0.3, 1.0, 1.2, 6.25, 77.0, 1.09e4)]


def loaded(along, across, normal):
    """Semi-axes, approach [m] and greatest pressure [Pa]."""
    ca, cb, k = hertz.ellipse(along, across, YOUNG, POISSON)
    a, b = ca * normal ** (1 / 3), cb * normal ** (1 / 3)
    return a, b, (normal / k) ** (2 / 3), hertz.pressure(normal, a, b)


@pytest.mark.parametrize("along, across", CURVATURES[1:-1])
def test_pressure_closes_the_gap_over_the_whole_ellipse(along, across):
    a, b, approach, peak = loaded(along, across, 1e5)
    for x, y in [(0, 0), (0.9 * a, 0), (0, 0.9 * b), (0.5 * a, -0.6 * b), (a, 0), (0, b)]:
        gap = along * x**2 + across * y**2 - approach
        assert_allclose(
            naive.hertz_displacement(a, b, peak, MODULUS, x, y) + gap, 0, atol=tol.HERTZ_QUADRATURE * approach
        )


@pytest.mark.parametrize("along, across", CURVATURES)
def test_same_as_twin(along, across):
    a, b, approach, _ = loaded(along, across, 1e5)
    assert_allclose((a, b, approach), naive.hertz_ellipse(along, across, YOUNG, POISSON, 1e5), rtol=tol.HERTZ)


def test_sphere_on_plane():
    radius, normal = 0.3, 1e5
    a, b, approach, peak = loaded(1 / (2 * radius), 1 / (2 * radius), normal)
    exact = (3 * normal * radius / (4 * MODULUS)) ** (1 / 3)
    assert_allclose((a, b, approach), (exact, exact, exact**2 / radius), rtol=tol.HERTZ)
    assert_allclose(peak, 1.5 * normal / (np.pi * exact**2), rtol=tol.HERTZ)


def test_nearly_round_is_continuous():
    round_, oval = (np.array(hertz.ellipse(1.0, across, YOUNG, POISSON)) for across in (1.0, 1.0 + 1e-9))
    assert_allclose(oval, round_, rtol=2e-9)


@pytest.mark.parametrize("along, across", CURVATURES)
def test_exchanging_the_directions_exchanges_the_axes(along, across):
    ca, cb, k = hertz.ellipse(along, across, YOUNG, POISSON)
    assert hertz.ellipse(across, along, YOUNG, POISSON) == (cb, ca, k)
    assert (ca < cb) == (along > across)


def test_scaling():
    """Lengths scale with lengths, forces with the modulus."""
    ca, cb, k = hertz.ellipse(1.1, 6.3, YOUNG, POISSON)
    assert_allclose(
        hertz.ellipse(0.55, 3.15, 3 * YOUNG, POISSON),
        (ca * (2 / 3) ** (1 / 3), cb * (2 / 3) ** (1 / 3), 3 * np.sqrt(2) * k),
        rtol=tol.HERTZ,
    )


@pytest.mark.parametrize("along, across", [(0.0, 1.0), (1.0, -0.2), (math.nan, 1.0), (1.0, math.nan)])
def test_no_ellipse_without_two_positive_curvatures(along, across):
    assert np.isnan(hertz.ellipse(along, across, YOUNG, POISSON)).all()


def test_newton_contracts_from_any_start():
    """The slope that the docstring promises, which makes Newton's method safe without brackets."""
    for kappa in np.geomspace(1e-6, 1.0, 200):
        _, b, d, c = hertz.elliptic(kappa)
        assert 1.5 - tol.ROUNDING < 1 + c * (1 / d + kappa**2 / b) < 2
