"""Kalker's linear coefficients against table E.3 of his book, its asymptotes, and the linear theory solved anew."""

from pathlib import Path

import naive
import numpy as np
import pandas as pd
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels import kalker

TABLE = pd.read_csv(Path(__file__).parents[1] / "data/contact/kalker_coefficients.csv", comment="#")
TABLE["a_over_b"] = np.where(TABLE.a_over_b > 1, 1 / TABLE.g, TABLE.g)  # beyond the printed digits
ROWS = TABLE.drop(columns="g").to_numpy()
POISSON = (0.0, 0.25, 0.5)
STEEL = 0.28


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]:.3g}")
@pytest.mark.parametrize("column, poisson", list(enumerate(POISSON)))
def test_nodes(row, column, poisson):
    assert_allclose(kalker.coefficients(row[0], poisson), row[1 + column :: 3], rtol=tol.KALKER_NODE)


@pytest.mark.parametrize("poisson", [0.0, 0.1, STEEL, 0.4, 0.5])
def test_between_the_nodes(poisson):
    for a_over_b in np.geomspace(0.1001, 9.99, 61):
        twin = naive.kalker_coefficients(ROWS, a_over_b, poisson)
        assert_allclose(kalker.coefficients(a_over_b, poisson), twin, rtol=tol.KALKER_NODE)


@pytest.mark.parametrize("a_over_b", [0.1, 10.0])
@pytest.mark.parametrize("poisson", POISSON)
def test_table_ends_near_the_asymptotes(a_over_b, poisson):
    for published, asymptote in zip(
        kalker.coefficients(a_over_b, poisson), naive.kalker_asymptotes(a_over_b, poisson), strict=True
    ):
        if asymptote is not None:
            assert_allclose(published, asymptote, rtol=tol.KALKER_ASYMPTOTE)


@pytest.mark.parametrize("a_over_b", [1e-7, 1e-6, 1e6, 1e7])
@pytest.mark.parametrize("poisson", [*POISSON, STEEL])
def test_slender_limits(a_over_b, poisson):
    found, limit = kalker.coefficients(a_over_b, poisson), naive.kalker_asymptotes(a_over_b, poisson)
    for value, asymptote in zip(found, limit, strict=True):
        if asymptote is not None:
            assert_allclose(value, asymptote, rtol=tol.KALKER_LIMIT)


def test_spin_coefficient_of_a_long_narrow_ellipse_without_poisson_effect():
    """For nu = 0 the table tends to pi/4 with the square of g: 0.795, 0.828, 0.868."""
    assert_allclose(kalker.coefficients(1e6, 0.0)[3], np.pi / 4, rtol=tol.KALKER_C33_LONG)


@pytest.mark.parametrize("poisson", [*POISSON, STEEL])
@pytest.mark.parametrize("seam", [*np.arange(1, 11) / 10, *(10 / np.arange(1, 10))])
def test_continuous(seam, poisson):
    below, above = (kalker.coefficients(seam * (1 + h), poisson) for h in (-1e-9, 1e-9))
    assert_allclose(below, above, rtol=1e-7)


def test_without_poisson_effect_both_directions_are_equally_stiff():
    for a_over_b in np.geomspace(1e-3, 1e3, 61):
        c11, c22, _, _ = kalker.coefficients(a_over_b, 0.0)
        assert_allclose(c11, c22, rtol=tol.KALKER_NODE)


def test_positive_and_finite_everywhere():
    values = np.array([kalker.coefficients(r, nu) for r in np.geomspace(1e-4, 1e4, 401) for nu in (*POISSON, STEEL)])
    assert (values > 0).all() and np.isfinite(values).all()


def test_not_a_number_stays_visible():
    assert np.isnan(kalker.coefficients(np.nan, STEEL)).all()


@pytest.mark.parametrize("a_over_b, cuts", [(0.1, (54, 21)), (0.5, (40, 20)), (1.0, (40, 20)), (2.0, (40, 20))])
@pytest.mark.parametrize("poisson", [0.0, STEEL, 0.5])
def test_table_solves_the_linear_theory(a_over_b, cuts, poisson):
    numerical = naive.linear_rolling(a_over_b, poisson, *cuts)
    assert_allclose(kalker.coefficients(a_over_b, poisson), numerical, rtol=tol.BOUNDARY_ELEMENTS)


@pytest.mark.parametrize("a_over_b, cuts", [(0.02, (54, 21)), (0.05, (54, 21)), (20.0, (100, 19))])
@pytest.mark.parametrize("poisson", [STEEL, 0.5])
def test_beyond_the_table(a_over_b, cuts, poisson):
    numerical = naive.linear_rolling(a_over_b, poisson, *cuts)
    assert_allclose(kalker.coefficients(a_over_b, poisson), numerical, rtol=tol.BOUNDARY_ELEMENTS_SLENDER)


def test_stiffness_is_in_si_units():
    """A round patch of 5 mm radius: f11 = G a b C11 and so on."""
    a, shear = 5e-3, 82e9
    c11, c22, c23, c33 = kalker.coefficients(1.0, STEEL)
    expected = (shear * a**2 * c11, shear * a**2 * c22, shear * a**3 * c23, shear * a**4 * c33)
    assert_allclose(kalker.stiffness(a, a, shear, STEEL), expected, rtol=tol.ROUNDING)
    a, b = 4e-3, 7e-3
    c11, c22, c23, c33 = kalker.coefficients(a / b, STEEL)
    expected = (shear * a * b * c11, shear * a * b * c22, shear * (a * b) ** 1.5 * c23, shear * (a * b) ** 2 * c33)
    assert_allclose(kalker.stiffness(a, b, shear, STEEL), expected, rtol=tol.ROUNDING)
