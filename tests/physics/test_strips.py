"""The law of strips by itself: influence of one strip on another, and Hertz's contact out of strips."""

import math

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.integrate import simpson
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk, j1, k0, k1

from railcli.kernels.columns import scratch
from railcli.kernels.jit import builder
from railcli.kernels.strips import CHI, STRIP, influence, press
from railcli.model.strips import HAT, _apart

ELASTIC = 210e9 / (2.0 * (1.0 - 0.28**2))  # [Pa]
DEEP = 60e-6  # approach [m]
AROUND_WHEEL = 1.0 / (2.0 * 0.46)  # half the curvature of a wheel along the track [1/m]


def mean_inverse_distance(t):
    """Gamma(t) and t Gamma'(t) from Fourier transforms: 2 J1(k) / k of a semi-ellipse, 2 K0(k t) of 1 / distance."""
    logarithm = np.linspace(math.log(1e-9), math.log(4e3), 400001)
    k = np.exp(logarithm)
    weight = (2.0 * j1(k) / k) ** 2 * k * 2.0 / math.pi
    return simpson(weight * k0(k * t), x=logarithm), simpson(-weight * k * t * k1(k * t), x=logarithm)


def hertz(a_over_b, bend):
    """Force [N] and semi-axis along x [m] of half spaces whose gap is bend (x^2 + y^2 / a_over_b), at approach DEEP."""

    def curvatures(ratio):  # ratio: of the minor to the major semi-axis; A along the major, B along the minor
        m = 1.0 - ratio * ratio
        return (ellipk(m) - ellipe(m)) / m, (ellipe(m) / ratio**2 - ellipk(m)) / m

    slender = min(a_over_b, 1.0 / a_over_b)
    ratio = 1.0 - 1e-9
    if slender < 1.0:
        ratio = brentq(lambda r: curvatures(r)[0] / curvatures(r)[1] - slender, 1e-4, 1.0 - 1e-6)
    along = bend if a_over_b <= 1.0 else bend / a_over_b
    if slender == 1.0:
        share, depth = 0.25 * math.pi, 0.5 * math.pi
    else:
        share, depth = curvatures(ratio)[0], ellipk(1.0 - ratio * ratio)
    # with p the greatest pressure: along = p ratio share / (E* major) and DEEP = p ratio major depth / E*
    major = math.sqrt(DEEP * share / (along * depth))
    force = 2.0 / 3.0 * math.pi * ELASTIC * DEEP * major / depth
    return force, major if a_over_b <= 1.0 else ratio * major, ratio * major if a_over_b <= 1.0 else major


@builder
def solve(strip, apart, h, elastic, tolerance, most, q, chi):
    work, lanes, matrix = scratch(strip.size)
    return press(strip, apart, h, 0, strip.size, elastic, tolerance, most, q, chi, work, lanes, matrix)


def flat_strips(width, count, bend):
    """Strips of a plane, and their distances."""
    strip = np.zeros(count, STRIP)
    strip["width"], strip["normal_z"], strip["bend"] = width, 1.0, bend
    strip["y"] = strip["arc"] = width * (np.arange(count) + 0.5)
    strip["hat"], strip["share"] = np.divmod(strip["arc"] / HAT, 1.0)
    return strip, _apart(strip["arc"], strip["width"])


@pytest.mark.parametrize("t", [2e-3, 0.01, 0.1, 0.5, 1.0, 3.0, 10.0, 50.0])
def test_influence_is_that_of_semi_ellipses(t):
    gamma, slope = mean_inverse_distance(t)
    value, bent = influence(np.float32(t), np.float32(1.0))
    assert_allclose(value, gamma, rtol=tol.INFLUENCE)
    assert_allclose(bent, gamma + slope, rtol=tol.INFLUENCE_SLOPE, atol=tol.INFLUENCE * gamma)


def test_influence_has_its_dimension():
    value, bent = influence(np.float32(0.5e-3), np.float32(4e-6))
    unit, unit_bent = influence(np.float32(0.25), np.float32(1.0))
    assert_allclose([value * 2e-3, bent * 8e-9], [unit, unit_bent], rtol=tol.SINGLE)


@pytest.mark.parametrize("a_over_b", [0.05, 0.2, 0.5, 1.0, 2.0, 6.0, 20.0])
def test_strips_are_hertz_for_constant_curvatures(a_over_b):
    force, along, across = hertz(a_over_b, AROUND_WHEEL)
    width = min(along / 4.0, across / 8.0)
    strip, apart = flat_strips(width, 2 * math.ceil(1.3 * across / width) + 1, AROUND_WHEEL)
    place = strip["arc"] - strip["arc"].mean()
    h = np.maximum(DEEP - AROUND_WHEEL / a_over_b * place**2, 0.0)
    q, chi = np.full(strip.size, ELASTIC * DEEP), np.full(int(strip["hat"].max()) + 2, CHI)
    energy, count, _ = solve(strip, apart, h, ELASTIC, 1e-8, 300, q, chi)
    assert_allclose(q.sum() * width, force, rtol=tol.HERTZ_STRIPS)
    assert_allclose(energy, 0.4 * force * DEEP, rtol=tol.HERTZ_STRIPS)
    assert_allclose(0.5 * np.count_nonzero(q) * width, across, atol=width)


def test_the_energy_is_that_of_any_start():
    strip, apart = flat_strips(0.4e-3, 40, AROUND_WHEEL)
    place = strip["arc"] - strip["arc"].mean()
    h = np.maximum(DEEP * np.cos(place / 1.5e-3), 0.0) * (1.0 + 60.0 * place)
    energies = []
    for start, slender in ((0.0, 1.5), (0.2, 0.6), (3.0, 4.0)):
        q, chi = np.full(strip.size, start * ELASTIC * DEEP), np.full(int(strip["hat"].max()) + 2, slender)
        energies.append(solve(strip, apart, h, ELASTIC, 1e-8, 300, q, chi)[0])
    assert_allclose(energies, energies[0], rtol=tol.ENERGY_START)
