"""Hertz's solution against tables; origin of the data in tests/data/contact/SOURCE.md."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels import hertz

DATA = Path(__file__).parents[1] / "data/contact"
EXAMPLES = pd.read_csv(DATA / "hertz_examples.csv", comment="#")
COEFFICIENTS = pd.read_csv(DATA / "hertz_mn_table.csv", comment="#")


@pytest.mark.parametrize("row", list(EXAMPLES.itertuples()), ids=lambda row: f"{row.case}-{row.N_N / 1e3:g}kN")
def test_wheel_on_rail(row):
    along = (1 / row.Rwheel_x + 1 / row.Rrail_x) * 1e3 / 2
    across = (1 / row.Rwheel_y + 1 / row.Rrail_y) * 1e3 / 2
    ca, cb, k = hertz.ellipse(along, across, row.E_MPa * 1e6, row.nu)
    a, b = ca * row.N_N ** (1 / 3), cb * row.N_N ** (1 / 3)
    found = (a * 1e3, b * 1e3, hertz.pressure(row.N_N, a, b) / 1e6, (row.N_N / k) ** (2 / 3) * 1e3)
    assert_allclose(found, (row.a_mm, row.b_mm, row.p0_MPa, row.delta_mm), rtol=tol.HERTZ_EXAMPLES)


def test_classical_coefficients():
    """m, n over theta with cos(theta) = (B - A) / (A + B); the long axis lies along x."""
    cosine = np.cos(np.radians(COEFFICIENTS.theta_deg))
    young, poisson = 1.0, 0.3
    unit = (3 / (8 * young / (2 * (1 - poisson**2)))) ** (1 / 3)  # A + B = 2
    found = np.array([hertz.ellipse(1 - c, 1 + c, young, poisson)[:2] for c in cosine]) / unit
    assert_allclose(found, COEFFICIENTS[["m_exact", "n_exact"]], atol=tol.HERTZ_MN_EXACT)
    given = COEFFICIENTS.m_published.notna()
    assert given.sum() == 13
    assert_allclose(found[given], COEFFICIENTS[given][["m_published", "n_published"]], atol=tol.HERTZ_MN_CLASSICAL)
