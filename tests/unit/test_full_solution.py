"""The solution on elements that normal laws are compared with: Hertz, superposition, geometry, stored states."""

import math
import runpy
from types import SimpleNamespace

import naive
import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.integrate import dblquad
from scipy.optimize import brentq

from railcli.analysis.certify import direct_contacts
from railcli.analysis.rigid_contact import fine_stations
from railcli.files.contact_reference import published
from railcli.files.resources import resource

YOUNG, POISSON = 210e9, 0.28
MODULUS = YOUNG / (2 * (1 - POISSON**2))
LOAD = 50e3


@pytest.fixture(scope="module")
def full():
    return SimpleNamespace(**runpy.run_path(str(resource("benchmarks/contact/full_solution.py"))))


@pytest.fixture(scope="module")
def wheel(full):
    """Wheelset of the benchmark, its right wheel's profiles, modulus."""
    return full.benchmark()


def parabola(full, along, across, strips):
    """Elements over Hertz's ellipse, its overlap, and what Hertz gives; strips: their edges over b, -1.2 ... 1.2."""
    a, b, approach = naive.hertz_ellipse(along, across, YOUNG, POISSON, LOAD)
    dx, edges = 2 * a / 60, b * strips
    x, u = np.arange(-34, 35) * dx, 0.5 * (edges[1:] + edges[:-1])
    spaces = full.HalfSpaces(x.size, dx, u, np.diff(edges), MODULUS)
    return spaces, approach - along * x[:, None] ** 2 - across * u**2, (a, b)


@pytest.mark.parametrize("along, across", [(1.0, 1.2), (1.0, 100.0), (0.1, 10.0), (2.0, 0.2)])
@pytest.mark.parametrize("even", [True, False], ids=["even strips", "uneven strips"])
def test_hertz(full, along, across, even):
    strips = np.linspace(-1.2, 1.2, 49)
    if not even:
        strips = strips + 0.04 * np.sin(2.0 * math.pi * strips)
    spaces, overlap, (a, b) = parabola(full, along, across, strips)
    p = spaces.solve(overlap)
    force = np.sum(p * spaces.du) * spaces.dx
    assert_allclose(force, LOAD, rtol=tol.ELEMENT_FORCE)
    assert_allclose(p.max(), 1.5 * LOAD / (math.pi * a * b), rtol=tol.ELEMENT_PRESSURE)
    assert_allclose(full.area(p, spaces.dx, spaces.du), math.pi * a * b, rtol=tol.ELEMENT_AREA)


def test_pressures_leave_no_overlap_and_do_not_pull(full):
    spaces, overlap, _ = parabola(full, 1.0, 10.0, np.linspace(-1.2, 1.2, 49))
    p = spaces.solve(overlap)
    gap = spaces.give(p) - overlap
    assert np.all(p >= 0.0)
    assert_allclose(gap[p > 0.0], 0.0, atol=tol.ELEMENT_GAP * overlap.max())
    assert gap[p == 0.0].min() > -tol.ELEMENT_GAP * overlap.max()


@pytest.mark.parametrize("x, u", [(2.0, 0.0), (0.7, 1.3), (-3.0, 2.0)])
def test_pull_of_a_rectangle(full, x, u):
    found = dblquad(lambda v, w: 1.0 / math.hypot(x - w, u - v), -0.5, 0.5, -0.2, 0.2)[0]
    assert_allclose(full.love(np.array([x]), np.array([u]), 1.0, 0.4), found, rtol=tol.RECTANGLE)


def test_strips_that_lean_feel_each_other_less(full):
    """Two patches 15 mm apart: each sinks by the other's N / (pi E* r), times the cosine between their normals."""
    a, _, approach = naive.hertz_ellipse(1.0, 1.2, YOUNG, POISSON, LOAD)
    dx, apart = a / 15, 15e-3
    u = np.concatenate([middle + np.arange(-17, 18) * dx for middle in (0.0, apart)])
    x = np.arange(-17, 18) * dx
    from_middle = np.where(u < 0.5 * apart, u, u - apart)
    overlap = approach - x[:, None] ** 2 - 1.2 * from_middle**2
    for angle in (0.0, 1.0):
        lean = np.where((u < 0.5 * apart)[:, None], [0.0, 1.0], [-math.sin(angle), math.cos(angle)])
        spaces = full.HalfSpaces(x.size, dx, u, np.full(u.size, dx), MODULUS, lean)
        pull = LOAD * math.cos(angle) / (math.pi * MODULUS * apart)
        force = np.sum(spaces.solve(overlap + pull)[:, : u.size // 2]) * dx * dx
        assert_allclose(force, LOAD, rtol=tol.FAR_PATCH)


def conforming(full, half, leaning):
    """Half angle of the patch of a cylinder in a groove, found where theory says `half`; long strips on an arc.

    Equal bodies of radius R and R + gap under the line load P, patch of half angle e, b = tan(e/2) (Persson 1964;
    Ciavarella and Decuzzi 2001): E / (1 - nu^2) gap / P = (2 - ln(1 + b^2) - 2 b^4) / (pi b^2 (1 + b^2)).
    """
    radius, gap = 13e-3, 0.5e-3
    b = math.tan(0.5 * half)
    load = 2.0 * MODULUS * gap * math.pi * b**2 * (1 + b**2) / (2 - math.log1p(b**2) - 2 * b**4)
    width = 3.0 * half / 301
    angle = width * np.arange(-150, 151)
    lean = np.stack([-np.sin(angle), np.cos(angle)], axis=-1) if leaning else None
    spaces = full.HalfSpaces(1, 1.0, radius * angle, np.full(angle.size, radius * width), MODULUS, lean)
    push = np.cos(angle) if leaning else np.ones_like(angle)
    bent = gap * (1.0 - np.cos(angle) if leaning else 0.5 * angle**2)

    def missing(depth):
        return np.sum(spaces.solve((depth * push - bent)[None])[0] * push * spaces.du) - load

    p = spaces.solve((brentq(missing, 1e-5, 1e-3, rtol=1e-6) * push - bent)[None])
    return 0.5 * full.area(p.T, width, np.ones(1))


@pytest.mark.parametrize("half", [0.2, 0.4])
def test_strips_along_a_groove_are_conforming_cylinders(full, half):
    """Only with each strip on its own normal: without, the patch is 4.6 % too wide at 0.4 rad."""
    assert_allclose(conforming(full, half, True), half, rtol=tol.CONFORMING * half**2)
    assert conforming(full, half, False) > (1.0 + 0.25 * half**2) * half


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (6.5e-3, -4e-3, 2e-3), (-3e-3, 1e-3, 24e-3)])
def test_first_touch_is_that_of_the_contact_search(full, wheel, pose):
    """Distance of the true surfaces along the rail's normal against minima along the contact locus."""
    pair, profiles, modulus = wheel
    found = direct_contacts(pair.right, pose, fine_stations(pair.right))[:, 1].min()
    assert_allclose(full.Contact(profiles, modulus, pose).touch, found, atol=tol.TOUCH)


@pytest.mark.parametrize("i", [1, 64, 82, 133, 171])
def test_stored_states_come_again_on_coarser_elements(full, wheel, i):
    reference = published().normal
    pair, profiles, modulus = wheel
    (state, pose), = full.own_poses(pair, reference.y[i : i + 1], reference.yaw[i : i + 1])
    assert_allclose(state[2], reference.roll[i], atol=tol.STORED_ROLL)
    contact = full.Contact(profiles, modulus, pose, fine=0.6)
    found = contact.bear(reference.load[i])
    expected = {key: values[i] for key, values in reference.values.items()}
    assert_allclose(contact.touch, reference.touch[i], atol=tol.STORED_TOUCH)
    assert_allclose(found.height - contact.touch, expected["sink"], rtol=tol.COARSE_SINK)
    assert_allclose(found.normal, expected["normal"], rtol=tol.COARSE_SINK)
    assert_allclose(found.pressure, expected["pressure"], rtol=tol.COARSE_PRESSURE)
    assert_allclose(found.area, expected["area"], rtol=tol.COARSE_AREA)
    assert_allclose([found.rail, found.wheel], [expected["rail"], expected["wheel"]], atol=tol.COARSE_PLACE)
    assert found.patches == expected["patches"]
