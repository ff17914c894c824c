"""The profile as a curve: pieces, arc length, motions, graph, gauge point, tangents from points."""

import dataclasses
import math

import numpy as np
import pytest
import tolerances as tol
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from railcli.errors import InputError
from railcli.files.profiles import BUNDLED, load_profile
from railcli.model.profile import Profile

RADIUS = 0.04


def circle(n=9, start=-1.2, end=1.2, radius=RADIUS, kind="rail"):
    """Arc through the origin, tangent to the y axis there; a rail's head for a positive radius."""
    angle = np.linspace(start, end, n)
    return Profile("circle", kind, radius * np.sin(angle), radius * (1 - np.cos(angle)), angle)


def bundled(name):
    return load_profile(name, BUNDLED[name][0])


PROFILES = [circle(), *map(bundled, BUNDLED)]


@pytest.fixture(params=PROFILES, ids=lambda profile: profile.name)
def profile(request):
    return request.param


def test_arc_is_met_between_its_points():
    for turn in (0.02, 0.1, 0.3):
        arc = circle(start=0.0, end=8 * turn)
        sigma = np.linspace(0.0, arc.arc[-1], 401)
        y, z, angle, curvature = arc.at(sigma)
        off = np.hypot(y, z - RADIUS) - RADIUS
        assert np.abs(off).max() < RADIUS * turn**6 / 55_000 * 1.01 + tol.PROFILE_GRID
        assert_allclose(arc.arc[-1], RADIUS * 8 * turn, rtol=turn**6 / 1e4 + tol.ROUNDING)
        assert_allclose(angle, sigma / RADIUS, atol=turn**4 / 100 + tol.ROUNDING)
        assert_allclose(curvature, 1 / RADIUS, rtol=turn**2 / 10 + tol.ROUNDING)


def test_vertical_line_is_a_line():
    face = Profile("face", "rail", [0.03, 0.03, 0.03], [0.0, 0.002, 0.02], [math.pi / 2] * 3)
    y, z, angle, curvature = face.at([0.0, 0.001, 0.017])
    assert_allclose(y, 0.03)
    assert_allclose(z, [0.0, 0.001, 0.017], atol=tol.PROFILE_GRID)
    assert_allclose(angle, math.pi / 2)
    assert_allclose(curvature, 0.0, atol=tol.PROFILE_CURVE)


def test_arc_length_is_length(profile):
    sigma = np.linspace(0.0, profile.arc[-1], 200_001)
    y, z, _, _ = profile.at(sigma)
    chords = np.hypot(np.diff(y), np.diff(z))
    assert_allclose(chords, sigma[1], rtol=tol.CHORD)
    assert chords.sum() <= profile.arc[-1] * (1 + tol.ROUNDING)


def test_nodes_are_on_the_curve(profile):
    y, z, angle, _ = profile.at(profile.arc)
    assert_allclose(y, profile.y, atol=tol.PROFILE_GRID)
    assert_allclose(z, profile.z, atol=tol.PROFILE_GRID)
    assert_allclose(angle, profile.angle, atol=tol.PROFILE_GRID * 1e3)


def test_position_and_tangent_are_continuous(profile):
    """Both sides of every node, closer to it than any piece is long, where a kink would stand out."""
    tiny = 1e-9
    before, after = profile.at(profile.arc[1:-1] - tiny), profile.at(profile.arc[1:-1] + tiny)
    assert np.hypot(after[0] - before[0], after[1] - before[1]).max() < 2 * tiny * (1 + 1e-6)
    allowed = tiny * (np.abs(before[3]) + np.abs(after[3]))
    assert (np.abs(after[2] - before[2]) - allowed).max() < tol.PROFILE_SLOPE


def test_angle_is_the_direction_and_curvature_its_rate(profile):
    middle = (profile.arc[1:] + profile.arc[:-1]) / 2
    h = np.minimum(1e-6, np.diff(profile.arc) / 4)
    dy, dz, turn, _ = np.subtract(profile.at(middle + h), profile.at(middle - h))
    _, _, angle, curvature = profile.at(middle)
    assert_allclose(np.arctan2(dz, dy), angle, atol=tol.DIFFERENCE_QUOTIENT)
    assert_allclose(turn / (2 * h), curvature, rtol=1e2 * tol.DIFFERENCE_QUOTIENT, atol=1e-4)


def test_beyond_the_ends_stand_the_ends(profile):
    y, z, _, _ = profile.at([-1.0, 1e3])
    assert_allclose(y, profile.y[[0, -1]], atol=tol.PROFILE_GRID)
    assert_allclose(z, profile.z[[0, -1]], atol=tol.PROFILE_GRID)


def test_rotation_turns_y_towards_z():
    """Right-handed about x: a negative angle lowers the gauge side of a right-hand rail and tilts its head inwards."""
    rail = bundled("60E1")
    turned = rail.rotated(-0.05)
    gauge_side, field_side = 0, -1
    assert turned.z[gauge_side] > rail.z[gauge_side] and turned.z[field_side] < rail.z[field_side]
    sigma = np.linspace(0, rail.arc[-1], 999)
    (y, z, angle, curvature), found = rail.at(sigma), turned.at(sigma)
    c, s = math.cos(-0.05), math.sin(-0.05)
    assert_allclose(found[:3], [c * y - s * z, s * y + c * z, angle - 0.05], atol=tol.PROFILE_CURVE)
    assert_allclose(found[3], curvature, atol=0.01)
    assert_allclose(turned.rotated(0.05).y, rail.y, atol=tol.PROFILE_GRID)


def test_translation_and_mirror(profile):
    sigma = np.linspace(0, profile.arc[-1], 999)
    y, z, angle, curvature = profile.at(sigma)
    found = profile.translated(0.3, -0.2).at(sigma)
    assert_allclose(found[:3], [y + 0.3, z - 0.2, angle], atol=1e-8)
    found = profile.mirrored().at(profile.arc[-1] - sigma)
    assert_allclose(found[:3], [-y, z, -angle], atol=tol.PROFILE_CURVE)
    again = profile.mirrored().mirrored()
    assert again.digest() == profile.digest() != profile.mirrored().translated(0, 1e-9).digest()


def test_profile_is_frozen(profile):
    for array in (profile.y, profile.z, profile.angle, profile.arc):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        profile.name = "other"


def test_arrays_given_stay_ones_own():
    y = np.array([0.0, 0.1, 0.2])
    line = Profile("line", "rail", y, np.zeros(3), np.zeros(3))
    y[0] = 5.0
    assert line.y[0] == 0.0


def test_digest_knows_kind_and_nodes_but_not_the_name():
    line = Profile("line", "rail", [0.0, 0.1], [0.0, 0.0], [0.0, 0.0])
    assert line.digest() == Profile("other", "rail", [0.0, 0.1], [0.0, 0.0], [0.0, 0.0]).digest()
    others = [
        Profile("line", "wheel", [0.0, 0.1], [0.0, 0.0], [0.0, 0.0]),
        Profile("line", "rail", [0.0, 0.1], [0.0, 1e-12], [0.0, 0.0]),
        Profile("line", "rail", [0.0, 0.1], [0.0, 0.0], [0.0, 1e-12]),
    ]
    assert len({line.digest(), *(other.digest() for other in others)}) == 4


@pytest.mark.parametrize(
    "kind, y, z, message",
    [
        ("tram", [0, 1], [0, 0], "a rail or a wheel, not 'tram'"),
        ("rail", [0, math.nan], [0, 0], "finite"),
        ("rail", [0], [0], "at least 2 nodes"),
        ("rail", [0, 1, 1], [0, 0, 0], "nodes 2 and the next are the same point"),
    ],
)
def test_impossible_nodes(kind, y, z, message):
    with pytest.raises(InputError, match=message):
        Profile("bad", kind, y, z, np.zeros(len(y)))


# Graph


def slow_graph(profile, y):
    """Where the profile passes y [m], by bisection over its whole length."""
    low, high = np.full(y.shape, 0.0), np.full(y.shape, profile.arc[-1])
    for _ in range(80):
        middle = (low + high) / 2
        left = profile.at(middle)[0] < y
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    return (low + high) / 2


@pytest.mark.parametrize("step", [0.05e-3, 0.2e-3])
@pytest.mark.parametrize("tilt", [0.0, -0.05, 0.03])
def test_graph_is_the_curve(profile, step, tilt):
    profile = profile.rotated(tilt)
    window = 1e-3
    y0, found_step, values = profile.graph(step, window=window)
    y = y0 + step * np.arange(len(values))
    assert found_step == step and values.dtype == np.float64 and values.flags.c_contiguous
    assert_allclose(y / step, np.round(y / step), atol=1e-6)
    sigma = slow_graph(profile, y)
    found, z, angle, _ = profile.at(sigma)
    assert_allclose(found, y, atol=tol.PROFILE_GRID)
    assert_allclose(values[:, 0], z, atol=tol.PROFILE_GRID * 10)
    assert_allclose(np.arctan(values[:, 1]), angle, atol=tol.PROFILE_SLOPE)
    low, high = np.maximum(sigma - window / 2, 0), np.minimum(sigma + window / 2, profile.arc[-1])
    mean = (profile.at(high)[2] - profile.at(low)[2]) / (high - low)
    assert_allclose(values[:, 2], mean, atol=1e-3)


def test_graph_ends_at_the_slope_limit_or_the_profile(profile):
    for limit in (0.5, math.tan(math.radians(80)), 50.0):
        y0, step, values = profile.graph(slope_limit=limit)
        assert np.abs(values[:, 1]).max() <= limit * (1 + 1e-9)
        for end, outwards in ((0, -1), (-1, 1)):
            y = y0 + step * (len(values) - 1 if end else 0) + outwards * step
            inside = profile.y.min() <= y <= profile.y.max()
            if inside:
                assert abs(np.tan(profile.at(slow_graph(profile, np.array([y])))[2][0])) > limit


def test_graph_of_the_wheel_goes_over_the_flange_tip():
    y0, step, values = bundled("ORES1002").graph()
    back, face = values[0, 1], values[-1, 1]
    assert 5.0 < back <= math.tan(math.radians(80)) and y0 < -69.5e-3
    assert_allclose(y0 + step * (len(values) - 1), 65e-3, atol=step)
    assert_allclose(face, -1.0)
    assert_allclose(values[:, 0].max(), 28e-3, atol=step**2 / 0.012)
    steep = bundled("ORES1002").graph(slope_limit=math.tan(math.radians(69)))
    assert_allclose(steep[0], -38.2e-3, atol=0.3e-3)


def test_window_averages_a_jump_of_curvature():
    """Across the join of R300 and R80 the mean curvature is a straight ramp as long as the window."""
    rail, window = bundled("60E1"), 2e-3
    y0, step, values = rail.graph(window=window)
    y = y0 + step * np.arange(len(values))
    join = rail.arc[np.argmin(np.abs(rail.y - 10.228e-3))]
    beyond = np.clip((slow_graph(rail, y) - join) / window + 0.5, 0, 1)
    near = (y > 5e-3) & (y < 15e-3)
    assert_allclose(values[near, 2], (1 / 0.3 + beyond * (1 / 0.08 - 1 / 0.3))[near], rtol=tol.PROFILE_RADIUS)


def test_no_window_is_the_local_curvature():
    rail = bundled("60E1")
    y0, step, values = rail.graph(window=0.0)
    assert_allclose(values[:, 2], rail.at(slow_graph(rail, y0 + step * np.arange(len(values))))[3], rtol=1e-6)


def test_profile_without_running_surface():
    face = Profile("face", "rail", [0.0, 0.0], [0.0, 0.02], [math.pi / 2] * 2)
    with pytest.raises(InputError, match=r"face: .*no running surface z\(y\) at the top of the rail"):
        face.graph()
    with pytest.raises(InputError, match=r"tape circle \(y = 0\)"):
        bundled("ORES1002").translated(0.2, 0.0).graph()
    with pytest.raises(InputError, match="no two grid nodes 500 mm apart"):
        bundled("60E1").graph(step=0.5)


# Gauge point and flange


@given(depth=st.floats(0.002, 0.039), tilt=st.floats(-0.5, 0.5))
def test_gauge_point_of_a_circle(depth, tilt):
    """Its half chord `depth` below the top, or its radius, wherever on the circle the top is."""
    y, z = circle(n=99, start=-2.5, end=2.5).rotated(tilt).gauge_point(depth)
    centre_y, centre_z = -RADIUS * math.sin(tilt), RADIUS * math.cos(tilt)
    assert_allclose(z, centre_z - RADIUS, atol=tol.PROFILE_CURVE)
    assert_allclose(y, centre_y - math.sqrt(RADIUS**2 - (RADIUS - depth) ** 2), atol=tol.PROFILE_CURVE * 10)


def test_gauge_point_is_the_innermost_where_the_face_overhangs():
    deep = circle(n=99, start=-2.5, end=2.5).gauge_point(depth=0.06)
    assert_allclose(deep[0], -RADIUS, atol=tol.PROFILE_CURVE)


def test_gauge_point_needs_the_gauge_face():
    with pytest.raises(InputError, match="ends less than 14 mm below the top"):
        circle(end=1.2, start=-0.5).gauge_point()


def test_flange_dimensions_of_another_wheel():
    """A cone with a flange of straight lines, whose dimensions can be read off its corners."""
    y = np.array([-70, -70, -60, -50, -40, 60, 65.0]) * 1e-3
    z = np.array([0, 20, 30, 30, 0, 0, 0]) * 1e-3
    at = np.concatenate([np.linspace(a, b, 200, endpoint=False) for a, b in zip(range(6), range(1, 7), strict=True)])
    y, z = np.interp(at, range(7), y), np.interp(at, range(7), z)
    found = Profile.from_points("lines", "wheel", y, z).flange_dimensions()
    assert_allclose(found.height, 0.030, atol=tol.ROUNDED_CORNER)
    assert_allclose(found.thickness, 0.070 - 0.040 - 0.010 / 3, atol=tol.ROUNDED_CORNER)
    assert_allclose(found.qr, 0.018 / 3, atol=tol.ROUNDED_CORNER)
    assert_allclose(found.width, y.max() - y.min())


def test_flange_dimensions_need_a_flange():
    with pytest.raises(InputError, match="need a wheel"):
        bundled("60E1").flange_dimensions()
    flat = Profile("flat", "wheel", [-0.07, 0.06], [0.001, 0.0], [0.0, 0.0])
    with pytest.raises(InputError, match="only .* mm high"):
        flat.flange_dimensions()


# Tangents from points


@given(st.lists(st.floats(0.02, 0.6), min_size=3, max_size=20), st.floats(-1.0, 1.0))
def test_tangents_on_a_circle_are_exact(turns, start):
    """Whatever the spacing of the points."""
    angle = start + np.cumsum(turns) - sum(turns) / 2
    y, z = RADIUS * np.sin(angle), -RADIUS * np.cos(angle)
    if np.ptp(angle) < 3.0:
        found = Profile.from_points("circle", "rail", y, z).angle
        assert_allclose(np.remainder(found - angle + 1, 2 * math.pi), 1.0, atol=1e-9)


def test_tangents_do_not_ring():
    """One point displaced moves its own tangent and its neighbours' only."""
    y = np.linspace(-0.03, 0.03, 61)
    z = 2 * y**2
    smooth = Profile.from_points("smooth", "rail", y, z)
    z[30] += 1e-5
    bumped = Profile.from_points("bumped", "rail", y, z)
    assert set(np.flatnonzero(bumped.angle != smooth.angle)) <= {29, 30, 31}
    assert np.abs(bumped.angle - smooth.angle).max() < 0.02


@pytest.mark.parametrize("name", BUNDLED)
def test_tangents_from_points_meet_the_exact_ones(name):
    exact = bundled(name)
    found = Profile.from_points(name, exact.kind, exact.y, exact.z)
    off = np.abs(found.angle - exact.angle)[np.abs(exact.y - 60e-3) > 0.3e-3]  # but for the edge of the chamfer
    assert off.max() < tol.TANGENT_AT_A_JOIN
    assert np.median(off) < tol.PROFILE_SLOPE


def test_given_tangents_are_taken():
    profile = Profile.from_points("line", "rail", [0, 0.1], [0, 0], [0.1, -0.1])
    assert_allclose(profile.angle, [0.1, -0.1])


def test_tangents_need_three_points():
    with pytest.raises(InputError, match="at least 3 points"):
        Profile.from_points("short", "rail", [0, 1], [0, 0])
