"""The little linear algebra and trigonometry of the kernels against NumPy."""

import numpy as np
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels.block import block, solve
from railcli.kernels.trig import SMALL, SMALL_SINE, arc_sine, sine_cosine


def test_sine_and_cosine():
    """Series and library meet at SMALL; both are exact to a unit or two of the last digit."""
    angles = np.concatenate([np.linspace(-1.1 * SMALL, 1.1 * SMALL, 2001), [1e-9, 0.0, 1.0, -7.0, 100.0]])
    found = np.array([sine_cosine(x) for x in angles])
    assert_allclose(found[:, 0], np.sin(angles), rtol=tol.LAST_DIGIT)
    assert_allclose(found[:, 1], np.cos(angles), rtol=tol.LAST_DIGIT)


def test_arc_sine():
    sines = np.concatenate([np.linspace(-1.1 * SMALL_SINE, 1.1 * SMALL_SINE, 2001), [1e-9, 0.0, 0.5, -1.0]])
    assert_allclose([arc_sine(x) for x in sines], np.arcsin(sines), rtol=tol.LAST_DIGIT)


def test_sine_of_what_is_not_a_number():
    assert np.isnan(sine_cosine(np.nan)).all() and np.isnan(sine_cosine(np.inf)).all()


def test_six_equations():
    """Mass plus a damping matrix that is neither symmetric nor small, in blocks of three."""
    rng = np.random.default_rng(1)
    for _ in range(100):
        matrices = rng.normal(size=(2, 6, 6)) * 100.0
        matrices += matrices @ matrices.transpose(0, 2, 1) + 1000.0 * np.eye(6)
        right = rng.normal(size=6)
        blocks = [block(matrices, 1, r, c, 0.5) for r, c in ((0, 0), (0, 3), (3, 0), (3, 3))]
        found = np.concatenate(solve(*blocks, tuple(right[:3]), tuple(right[3:])))
        assert_allclose(found, np.linalg.solve(0.5 * matrices[1], right), rtol=0, atol=tol.SOLVED * np.abs(found).max())
