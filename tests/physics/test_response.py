"""Frequency response to displaced rails: invariance, and the vertical motion of the wagon added up by hand."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.linear import linearise
from railcli.analysis.quasi_linear import lines_of, quasi_linear_system
from railcli.analysis.response import inputs, response
from railcli.files.scenario import load

SPEED = 30.0


@pytest.fixture(scope="module")
def linear(profiles):
    case = load("stability").varied(run={"speed": SPEED})
    return linearise(quasi_linear_system(case, lines_of(case, *profiles, [3e-3])[0]), contact=True)


@pytest.mark.parametrize("kind, axis", [("vertical", 2), ("lateral", 1)])
def test_track_and_vehicle_moved_together_notice_nothing(linear, kind, axis):
    """Displaced with its rails, or moving with them, the vehicle feels no force."""
    still, moving = (part.sum(axis=0) for part in inputs(linear, kind))
    n, bodies = 6 * linear.size, np.arange(linear.size)
    full = np.zeros((2, 12 * linear.size + linear.data.damper.size))
    full[0, 6 * bodies + axis] = 1.0
    full[1, n + 6 * bodies + axis] = 1.0
    place, motion = full[:, linear.kept]
    size = np.abs(linear.matrix).max()
    assert_allclose(linear.matrix @ place + still, 0.0, atol=tol.MOVED_TOGETHER * size)
    assert_allclose(linear.matrix @ motion + moving, place, atol=tol.MOVED_TOGETHER * size)


@pytest.mark.parametrize("kind, axis", [("vertical", 1), ("lateral", 0)])
def test_long_waves_carry_the_vehicle_along(linear, kind, axis):
    """Every body follows the rails that it stands on, as much later as it comes there."""
    s = 2j * np.pi * 1e-3
    found = response(linear, kind, [1e-3])
    place = linear.data.q[:, 0]
    assert_allclose(found.acceleration[0, :, axis] / s**2, np.exp(s * (place - place[3]) / SPEED), atol=tol.LONG_WAVE)


def by_hand(frequencies, contact):
    """Vertical accelerations (car body, both bogies) and Q of the first wheel: ten coordinates, no longitudinal motion.

    Bounce and pitch (front up) of car body and bogies, bounce of four wheelsets; z down. A damper c with a series
    spring k is the complex stiffness 1 / (1/k + 1/(s c)). contact : stiffness and damping of one wheel.
    """
    half, base = 9.5, 1.28
    mass = np.diag([32000.0, 1.97e6, 2615.0, 1476.0, 2615.0, 1476.0, *[1813.0] * 4])
    out = []
    for f in frequencies:
        s = 2j * np.pi * f
        secondary = 2 * (430e3 + 1.0 / (1.0 / 6e6 + 1.0 / (s * 20e3)))
        primary = 2 * (1.22e6 + 1.0 / (1.0 / 1e6 + 1.0 / (s * 4e3)))
        wheel = 2 * (contact[0] + s * contact[1])
        k = np.zeros((10, 10), complex)

        def spring(row, value, k=k):
            k += value * np.outer(row, row)

        for b, x in ((2, half), (4, -half)):
            row = np.zeros(10)
            row[[0, 1, b]] = 1.0, -x, -1.0
            spring(row, secondary)
            for n, a in enumerate((base, -base)):
                row = np.zeros(10)
                row[[b, b + 1, 6 + n + (0 if b == 2 else 2)]] = 1.0, -a, -1.0
                spring(row, primary)
        load = np.zeros(10, complex)
        for w, x in enumerate((half + base, half - base, -half + base, -half - base)):
            k[6 + w, 6 + w] += wheel
            load[6 + w] = wheel * np.exp(s * (x - half - base) / SPEED)
        q = np.linalg.solve(s * s * mass + k, load)
        force = 0.5 * wheel * (q[6] - 1.0)
        out.append([*(s * s * q[[0, 2, 4]]), force])
    return np.array(out)


def test_vertical_response_by_hand(linear):
    """Up to 100 Hz, with the contact stiffness 1.5 N/p of Hertz's law and its damping."""
    rail = linear.data.contact[0, 0]
    cosine = 1.0 / np.sqrt(1.0 + rail["slope"] ** 2)
    stiffness = 1.5 * rail["normal"] / rail["depth"]
    damping = linear.system.model.param[0]["damping"] * rail["normal"] * cosine**2
    frequencies = np.geomspace(0.2, 100.0, 40)
    found = response(linear, "vertical", frequencies)
    mine = np.column_stack([found.acceleration[:, :3, 1], found.wheel[:, 0, 1]])
    wanted = by_hand(frequencies, (stiffness, damping))
    for k in range(4):
        assert np.abs(mine[:, k] - wanted[:, k]).max() < tol.RESPONSE * np.abs(wanted[:, k]).max()


def test_cross_level_rolls_and_bounces_nothing(linear):
    found = response(linear, "cross_level", [0.8, 5.0])
    assert np.abs(found.acceleration[:, :, 1]).max() < tol.OTHER_PLANE * np.abs(found.acceleration[:, :, 0]).max()


def test_gauge_leaves_a_symmetric_vehicle_in_the_middle(linear):
    found = response(linear, "gauge", [0.8, 5.0])
    moved = response(linear, "lateral", [0.8, 5.0])
    assert np.abs(found.acceleration[:, :, 0]).max() < tol.OTHER_PLANE * np.abs(moved.acceleration[:, :, 0]).max()
