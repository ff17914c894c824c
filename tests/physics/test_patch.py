"""Non-Hertzian patches: Hertz where curvature is constant, and an elastic half space where it is not."""

from dataclasses import replace

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

from benchmarks.speed import numpy_twin
from railcli.analysis.build_table import build_table, wheel_regions
from railcli.analysis.certify import direct_contacts
from railcli.errors import InputError
from railcli.kernels.contact import look_up
from railcli.kernels.difference import locus, slope_difference, wheel_axes
from railcli.kernels.layout import NODE_CHANNELS, PATCH_PENETRATIONS, SAMPLE_ROWS, Node
from railcli.kernels.patch import integral_difference, patch, strip
from railcli.kernels.step import evaluate
from railcli.kernels.tabulate import describe
from railcli.model.contact_table import TableSettings, mount


@pytest.mark.parametrize("m", [0.0, 1e-9, 0.1, 0.5, 0.9, 0.9999, 1.0 - 1e-9])
def test_elliptic_integrals(m):
    assert_allclose(integral_difference(m), ellipk(m) - ellipe(m), rtol=tol.ELLIPTIC, atol=tol.ELLIPTIC)


@pytest.mark.parametrize("c, offset", [(1.0, 0.1), (2.0, 3.0), (1e-3, 4e-3)])
def test_pull_of_a_strip(c, offset):
    expected, _ = quad(lambda x: np.sqrt(c**2 - x**2) / np.hypot(x, offset), -c, c)
    assert_allclose(strip(c, offset), expected, rtol=tol.STRIP)


def hertz(mounting, settings, pose, s):
    """The node that Hertz's theory gives at the rigid contact."""
    row = np.zeros(NODE_CHANNELS)
    regions = wheel_regions(mounting)
    describe(s, *pose, *mounting.kernel_arguments, settings.young, settings.poisson, regions, row)
    return row


def found_patch(mounting, settings, pose, p):
    """Rigid contact point, its D, and the patch when the wheel is lower by p."""
    low, high = mounting.wheel_start, mounting.wheel_start + mounting.wheel_step * (mounting.wheel.shape[0] - 1)
    contacts = direct_contacts(mounting, pose, np.arange(low, high, 1e-4))
    s, gap = contacts[np.argmin(contacts[:, 1]), :2]
    axes = wheel_axes(*pose[1:])
    return s, gap, patch(s, gap + p, pose[0], *axes, *mounting.kernel_arguments, settings.young, settings.poisson)


@pytest.mark.parametrize("angle", [0.0, 0.05])
@pytest.mark.parametrize("p", [10e-6, 60e-6, 400e-6])
@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (3e-3, 2e-3, 5e-3)])
def test_constant_curvature_is_hertz(angle, p, pose):
    settings = scenes.round_settings()
    mounting = mount(scenes.cone(angle), scenes.round_rail(), settings)
    s, _, (normal, a, b, pressure, at, slope, radius, *_) = found_patch(mounting, settings, pose, p)
    row = hertz(mounting, settings, pose, s)
    d = p / np.hypot(1.0, row[Node.SLOPE])
    expected = row[Node.HERTZ] * d**1.5, row[Node.SEMI_X] * d**0.5, row[Node.SEMI_Y] * d**0.5
    assert_allclose((normal, a, b), expected, rtol=tol.PATCH_HERTZ)
    assert_allclose(pressure, 1.5 * expected[0] / (np.pi * expected[1] * expected[2]), rtol=tol.PATCH_HERTZ)
    assert abs(at - s) < tol.PATCH_SHIFT
    assert abs(slope - row[Node.SLOPE]) < tol.PATCH_SHIFT / scenes.HEAD
    assert abs(radius - row[Node.RADIUS]) < tol.PATCH_SHIFT


def half_space(mounting, settings, pose, s, gap, p, left, right, columns=37, rows=27):
    """Normal force, lateral place of the resultant on the wheel, area by boundary elements on the unrolled patch."""
    axes, arguments = wheel_axes(*pose[1:]), mounting.kernel_arguments
    row = hertz(mounting, settings, pose, s)
    places = np.linspace(left - 0.35 * (right - left), right + 0.35 * (right - left), columns)
    wheel = (mounting.radius, mounting.wheel, mounting.wheel_start, mounting.wheel_step)
    points = np.array([locus(q, *axes, *wheel)[:2] for q in places])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    overlap = []
    for q in places:
        _, value, slope = slope_difference(q, pose[0], *axes, *arguments)
        overlap.append((gap + p - value) / np.hypot(1.0, slope))
    v = np.linspace(0.0, along[-1], columns)
    curvature = 0.5 / (row[Node.RADIUS] * np.hypot(1.0, row[Node.SLOPE]))
    x = np.linspace(-1.0, 1.0, rows) * 1.5 * np.sqrt(0.6 * max(overlap) / curvature)
    grid = np.interp(v, along, overlap)[None, :] - curvature * x[:, None] ** 2
    hx, hy = x[1] - x[0], v[1] - v[0]
    found = naive.pressures(grid, hx, hy, settings.young, settings.poisson)
    place = np.interp((found.sum(axis=0) * v).sum() / found.sum(), v, along)
    return found.sum() * hx * hy, np.interp(place, along, places), (found > 0.0).sum() * hx * hy


@pytest.mark.parametrize("y", [0.0, 4e-3, 5e-3])
@pytest.mark.parametrize("p", [40e-6, 120e-6])
def test_curvature_that_changes_within_the_patch(mounting, y, p):
    """ORES1002 on UIC60: the contact nears the conforming root, where Hertz's force is up to 17 % short."""
    settings, pose = TableSettings(), (y, 0.0, 0.0)
    s, gap, (normal, a, b, _, at, *_, left, right, _, _) = found_patch(mounting, settings, pose, p)
    expected, place, area = half_space(mounting, settings, pose, s, gap, p, left, right)
    row = hertz(mounting, settings, pose, s)
    d = p / np.hypot(1.0, row[Node.SLOPE])
    assert_allclose(normal, expected, rtol=tol.PATCH_FORCE)
    assert_allclose(np.pi * a * b, area, rtol=tol.PATCH_AREA)
    assert abs(at - place) < tol.PATCH_PLACE
    assert abs(normal / expected - 1.0) < abs(row[Node.HERTZ] * d**1.5 / expected - 1.0) + tol.PATCH_GRID
    assert abs(at - place) < abs(s - place)


@pytest.fixture(scope="module")
def mounting(profiles):
    return mount(*profiles, TableSettings())


@pytest.fixture(scope="module")
def pressed_table(profiles):
    return build_table(*profiles, replace(scenes.SMALL, roll_range=2.5e-3, yaw_count=2, normal="kp"))[0]


def test_table_gives_the_patches_of_its_nodes(mounting, pressed_table):
    """At poses and penetrations of the grid, and between penetrations within the error of straight lines in sqrt(p)."""
    table, settings = pressed_table, pressed_table.settings
    sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))
    for y in (-4e-3, 0.0, 2e-3, 4e-3):
        for p, allowed in [(q, tol.PATCH_NODE) for q in PATCH_PENETRATIONS] + [(35e-6, tol.PATCH_BETWEEN)]:
            s, gap, (normal, a, b, _, at, slope, radius, *_) = found_patch(mounting, settings, (y, 0.0, 0.0), p)
            look_up(table.record[0], table.node, table.cell, table.branch, y, 0.0, 0.0, gap + p, sample)
            row = sample[np.argmin(abs(sample[:6, Node.LATERAL] - at))]
            d = p / np.hypot(1.0, row[Node.SLOPE])
            found = row[Node.HERTZ] * d**1.5, row[Node.SEMI_X] * d**0.5, row[Node.SEMI_Y] * d**0.5
            assert_allclose(found, (normal, a, b), rtol=allowed)
            places = row[[Node.LATERAL, Node.SLOPE, Node.RADIUS]]
            assert_allclose(places, (at, slope, radius), rtol=0, atol=allowed * 1e-2)


def test_rigid_record_leaves_the_patches_out(pressed_table, profiles):
    plain = build_table(*profiles, replace(pressed_table.settings, normal="hertz"))[0]
    rigid, sample, other = pressed_table.rigid_record[0], np.zeros((SAMPLE_ROWS, NODE_CHANNELS)), None
    for pose in np.random.default_rng(1).uniform(-1, 1, (200, 3)) * [9e-3, 2e-3, 13e-3]:
        look_up(rigid, pressed_table.node, pressed_table.cell, pressed_table.branch, *pose, 0.01, sample)
        other = sample.copy()
        look_up(plain.record[0], plain.node, plain.cell, plain.branch, *pose, 0.01, sample)
        assert_allclose(other, sample, rtol=0)


def test_right_hand_side_against_twin(pressed_table):
    """A wheelset on patches, with several contacts and fading branches, against the NumPy twin."""
    system = scenes.lone_wheelset(pressed_table, 20.0, normal="kp")
    rng, patches = np.random.default_rng(2), []
    for _ in range(60):
        data = system.start(10.0)
        data.q[0] += rng.uniform(-1, 1, 6) * [0.0, 7e-3, 0.0, 2e-3, 0.0, 8e-3]
        data.q[0, 2] += rng.uniform(0.0, 0.4e-3)
        data.v[0] += rng.uniform(-1, 1, 6) * 0.05
        q, v = data.q.copy(), data.v.copy()
        assert evaluate(system.model, data, 0.0) == 0
        twin = numpy_twin.evaluate(system.model, q, v, data.damper)
        assert_allclose(data.load, twin.load, rtol=0, atol=tol.TWIN * np.abs(twin.load).max())
        patches.extend(data.rail["patches"])
    assert max(patches) >= 2


def test_pressed_contact_points_and_patches_exclude_each_other():
    with pytest.raises(InputError, match="pressed"):
        TableSettings(normal="kp", pressed=1e-4)
