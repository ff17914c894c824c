"""The difference surface and its minima: simplex, closed-form locus, brute force and closed forms of cone on circle."""

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import METHODS, solve_orientation, stations, wheel_regions
from railcli.analysis.certify import LOADED, direct_contacts
from railcli.kernels.difference import polish, slope_difference, wheel_axes
from railcli.kernels.layout import NODE_CHANNELS, Node
from railcli.kernels.tabulate import describe
from railcli.model.contact_table import TableSettings, mount

INCLINED = TableSettings()
LATERAL = 0.1e-3 * np.arange(-100, 101)


@pytest.fixture(scope="module")
def mounting(profiles):
    return mount(*profiles, INCLINED)


def solved(mounting, method, roll, yaw):
    """Minima of a row of lateral positions: (y, k, 6), infinite beyond their counts; which of them bear load."""
    found, counts = np.zeros((LATERAL.size, 4, 6)), np.zeros(LATERAL.size, np.int64)
    solve_orientation(
        METHODS.index(method), roll, yaw, LATERAL,
        *mounting.kernel_arguments, stations(mounting), found, counts,
    )  # fmt: skip
    found[np.arange(4) >= counts[:, None]] = np.inf
    near = found[..., 1] < found[..., 1].min(axis=1, keepdims=True) + LOADED
    return found, near & (found[..., 2:4].min(axis=2) > tol.SCAN_BARRIER)


@pytest.mark.parametrize("yaw", [0.0, 5e-3, -13e-3, 30e-3])
@pytest.mark.parametrize("roll", [-20e-3, -5e-3, 0.0, 5e-3, 25e-3])
def test_simplex_against_locus(mounting, roll, yaw):
    """Nelder and Mead on the surface and the closed-form locus find the same contact points, from tread to flange."""
    twins = [solved(mounting, method, roll, yaw) for method in METHODS]
    for (found, loaded), (other, _) in (twins, twins[::-1]):
        for i, j in np.argwhere(loaded):
            nearest = np.argmin(np.abs(other[i, :, 0] - found[i, j, 0]))
            assert abs(other[i, nearest, 0] - found[i, j, 0]) < tol.SIMPLEX_PLACE, LATERAL[i]
            assert abs(other[i, nearest, 1] - found[i, j, 1]) < tol.SIMPLEX_GAP, LATERAL[i]


def test_no_minimum_twice(mounting):
    """A simplex that leaves its basin is not counted a second time where it ends."""
    for roll in np.linspace(-25e-3, 25e-3, 21):
        found, _ = solved(mounting, "simplex", roll, 30e-3)
        places = np.where(np.isfinite(found[..., 0]), found[..., 0], np.arange(1.0, 5.0))
        assert (np.diff(places) > tol.SIMPLEX_PLACE).all(), roll


@pytest.mark.parametrize("yaw", [0.0, 13e-3])
def test_every_minimum_lies_in_its_basin(mounting, yaw):
    """Between its own two saddles; what lies outside would be joined with none of its neighbours in the table."""
    for roll in np.linspace(-25e-3, 25e-3, 21):
        found, _ = solved(mounting, "simplex", roll, yaw)
        s, low, high = np.moveaxis(found[np.isfinite(found[..., 0])][:, [0, 4, 5]], -1, 0)
        assert (low < s).all() and (s < high).all(), roll


@pytest.mark.parametrize("angle", [0.0, 0.01, 0.025, 0.1])
def test_stations_of_the_scan_lie_apart(mounting, angle):
    """Two that differ by rounding would be a saddle or a minimum between them."""
    for one in (mounting, mount(scenes.cone(angle), scenes.round_rail(), scenes.round_settings())):
        assert np.diff(stations(one)).min() > tol.STATION


def direct(mounting, pose):
    """s, D, contact angle, radius, barrier of every contact point of one pose."""
    low, high = mounting.wheel_start, mounting.wheel_start + mounting.wheel_step * (mounting.wheel.shape[0] - 1)
    return direct_contacts(mounting, pose, np.arange(low, high, 0.1e-3))


@pytest.mark.parametrize(
    "pose",
    [(6.1e-3, 0.0, 0.0), (0.0, 0.0, 0.0), (-4e-3, 3e-3, 5e-3), (6.3e-3, -2e-3, 8e-3), (7.5e-3, 5e-3, 13e-3)],
    ids=["three minima", "centred", "field side", "root", "flange"],
)
def test_minima_against_a_dense_grid(profiles, mounting, pose):
    """D on a grid in x and y, the wheel as an implicit surface of revolution, both profiles read from their curves."""
    expected = naive.difference_minima(*profiles, INCLINED, pose)
    found = direct(mounting, pose)
    found = found[(found[:, 4] > tol.GRID_BARRIER) & (found[:, 1] < found[:, 1].min() + 0.5e-3)]
    assert found.shape[0] == expected.shape[0]
    assert_allclose(found[:, 0], expected[:, 0], rtol=0, atol=tol.GRID_PLACE)
    assert_allclose(found[:, 1], expected[:, 1], rtol=0, atol=tol.GRID_GAP)


def test_three_loaded_minima(mounting):
    """S1002 on UIC60 at 1:20, 6.1 mm aside: root, tread and between them a third, all within 30 micrometres."""
    found = direct(mounting, (6.1e-3, 0.0, 0.0))
    assert found.shape[0] == 3
    assert np.ptp(found[:, 1]) < 30e-6


@pytest.mark.parametrize("angle", [0.0, 0.025, 0.1])
@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (5e-3, 0.0, 0.0), (3e-3, -8e-3, 0.0), (-4e-3, 6e-3, 25e-3)])
def test_cone_on_a_circle(pose, angle):
    """Place, D, angle and radius of a cylinder and of cones on a round rail, rolled and yawed, in closed form."""
    settings = scenes.round_settings()
    mounting = mount(scenes.cone(angle), scenes.round_rail(), settings)
    (found,) = direct(mounting, pose)
    s, gap, contact_angle, radius = naive.cone_on_circle(pose, angle, settings.radius, scenes.HEAD)
    assert_allclose(found[0], s, rtol=0, atol=tol.CIRCLE_PLACE)
    assert_allclose(found[1], gap, rtol=0, atol=tol.CIRCLE_GAP)
    assert_allclose(found[2], contact_angle, rtol=0, atol=tol.CIRCLE_ANGLE)
    assert_allclose(found[3], radius, rtol=0, atol=tol.CIRCLE_RADIUS + angle * tol.CIRCLE_PLACE)


@pytest.mark.parametrize("y", [1e-3, 4e-3])
def test_rolling_radius_difference_of_cones(y):
    """2 y tan(angle) without roll: right wheel at y, left wheel at -y of its own mirrored table."""
    angle = 0.05
    mounting = mount(scenes.cone(angle), scenes.round_rail(), scenes.round_settings())
    (right,), (left,) = direct(mounting, (y, 0.0, 0.0)), direct(mounting, (-y, 0.0, 0.0))
    assert right[3] - left[3] == pytest.approx(2 * y * np.tan(angle), abs=angle * tol.CIRCLE_PLACE)


@pytest.mark.parametrize("pose", [(0.0, 4e-3, 11e-3), (6.4e-3, -3e-3, 6e-3), (7e-3, 10e-3, 29e-3)])
def test_yaw_to_either_side(mounting, pose):
    """Yawed to the left the wheel touches where it touches yawed to the right, mirrored along the rail."""
    y, roll, yaw = pose
    assert_allclose(direct(mounting, pose), direct(mounting, (y, roll, -yaw)), rtol=0, atol=tol.SIMPLEX_GAP)


@pytest.mark.parametrize("pose", [(-3e-3, 2e-3, 4e-3), (1e-3, 0.0, 12e-3), (6.5e-3, -4e-3, 9e-3), (7e-3, 8e-3, 20e-3)])
def test_slopes_of_the_gap(mounting, pose):
    """dD/dy, dD/d roll and dD/d yaw^2 of a node are those of D minimised anew, by central differences."""
    arguments = mounting.kernel_arguments

    def gap(s, y, roll, square):
        axes = wheel_axes(roll, np.sqrt(square))
        s = polish(s, np.inf, y, *axes, *arguments)
        return slope_difference(s, y, *axes, *arguments)[1]

    y, roll, yaw = pose
    row = np.empty(NODE_CHANNELS)
    for s, *_ in direct(mounting, pose):
        describe(s, y, roll, yaw, *arguments, INCLINED.young, INCLINED.poisson, wheel_regions(mounting), row)
        at, steps = np.array([y, roll, yaw**2]), np.diag([1e-6, 1e-6, 1e-8])
        slopes = [(gap(s, *(at + h)) - gap(s, *(at - h))) / (2 * h.sum()) for h in steps]
        assert_allclose(row[[Node.SLOPE, Node.GAP_ROLL, Node.GAP_YAW2]], slopes, rtol=tol.GAP_SLOPE, atol=tol.GAP_SLOPE)
