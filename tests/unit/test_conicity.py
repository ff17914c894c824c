"""Rolling radius difference and equivalent conicity against closed forms and an independent integration."""

import math
from dataclasses import replace
from functools import cache

import naive
import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from railcli.analysis.conicity import conicity, rolling, steering, swing
from railcli.analysis.conicity_check import cone
from railcli.analysis.rigid_contact import Wheelset, contact_at, wheelset_on
from railcli.files.profiles import load_profile
from railcli.model.contact_table import TableSettings
from railcli.model.profile import Profile

BASE, RADIUS = 1.5, 0.46
SETTINGS = TableSettings(inclination=40.0)


@cache
def bundled(name, kind):
    return load_profile(name, kind)


@cache
def s1002(with_roll=False):
    pair = wheelset_on(SETTINGS, bundled("ORES1002", "wheel"), bundled("UIC60", "rail"))
    return rolling(pair, 8e-3, with_roll)


def arc(kind, centre_y, radius, half_width, count=801):
    """A profile that is an arc: hollow for a wheel, round for a rail; its lowest or highest point at y = 0."""
    sine = np.linspace(-half_width, half_width, count) / radius
    turn = np.arcsin(sine)
    return Profile(kind, kind, centre_y + radius * np.sin(turn), radius * (1.0 - np.cos(turn)), turn)


@pytest.mark.parametrize("slope", [1 / 40, 1 / 20, 1 / 10])
def test_a_cone_has_its_own_angle(slope):
    contact = rolling(wheelset_on(SETTINGS, cone(slope), bundled("UIC60", "rail")), 5e-3)
    found = np.array([(m.conicity, m.linearised) for m in conicity(contact, [1e-3, 2.5e-3, 5e-3])])
    assert_allclose(found, slope, atol=tol.CONE, rtol=0.0)
    assert contact.jumps.size == 0
    assert_allclose(contact.radius_difference, 2.0 * slope * contact.y, atol=tol.CONE)
    assert_allclose(np.tan(contact.values["angle_right"]), slope, atol=tol.CONE)


@pytest.mark.parametrize("slope, rail_radius", [(1 / 40, 0.300), (1 / 20, 0.300), (1 / 10, 0.080)])
def test_a_cone_that_rolls(slope, rail_radius):
    """Wickens (1965): slope (l + R_r slope)/(l - r slope), l and r where the centred wheel touches."""
    contact = rolling(wheelset_on(SETTINGS, cone(slope), bundled("UIC60", "rail")), 2e-3, with_roll=True)
    middle = int(np.argmin(np.abs(contact.y)))
    half = contact.wheelset.lateral + contact.values["s_right"][middle]
    wanted = slope * (half + rail_radius * slope) / (half - contact.values["r_right"][middle] * slope)
    assert_allclose([m.conicity for m in conicity(contact, [0.5e-3, 2e-3])], wanted, rtol=tol.CONE_ROLLED)


def test_hollow_wheel_on_a_round_rail():
    """Circles of radii R_w > R_r touch where the line of their centres runs: sin(angle) = (y + offset)/(R_w - R_r)."""
    hollow, round_, offset = 0.150, 0.100, 4e-3
    wheel = arc("wheel", offset, hollow, 0.05)
    pair = wheelset_on(SETTINGS, cone(0.05), bundled("UIC60", "rail"))
    rail = arc("rail", 0.0, round_, 0.03)
    step = 0.05e-3
    mounting = replace(
        pair.right, seat=0.0,
        **{f"{key}{part}": value
           for key, profile in (("wheel", wheel), ("rail", rail))
           for part, value in zip(("_start", "_step", ""), profile.graph(step, window=1e-3), strict=True)},
    )  # fmt: skip
    contact = rolling(Wheelset(mounting, mounting, 0.75), 3e-3)
    for side, sign in (("right", 1.0), ("left", -1.0)):
        sine = (-sign * contact.y - offset) / (hollow - round_)
        s = offset + hollow * sine
        assert_allclose(contact.values[f"s_{side}"], s, atol=tol.CIRCLE_PLACE)
        radius = mounting.radius + hollow * (1.0 - np.sqrt(1.0 - sine**2))
        assert_allclose(contact.values[f"r_{side}"], radius, atol=tol.CIRCLE_RADIUS)
        assert_allclose(contact.values[f"angle_{side}"], -np.arcsin(sine), atol=tol.CIRCLE_ANGLE)
    sine = (contact.y[:, None] * [-1.0, 1.0] - offset) / (hollow - round_)
    assert_allclose(
        contact.radius_difference, hollow * np.diff(np.sqrt(1.0 - sine**2), axis=1)[:, 0], atol=2 * tol.CIRCLE_RADIUS
    )


def test_sides_exchanged_give_the_mirror_image():
    wheel, rail, other = bundled("ORES1002", "wheel"), bundled("UIC60", "rail"), bundled("60E1", "rail")
    one = rolling(wheelset_on(SETTINGS, wheel, rail, left_rail=other, left_radius=0.459), 4e-3)
    pair = one.wheelset
    two = rolling(Wheelset(pair.left, pair.right, pair.lateral), 4e-3)
    assert_allclose(two.y, -one.y[::-1], atol=1e-15)
    assert_allclose(two.radius_difference, -one.radius_difference[::-1], atol=tol.MIRROR_RADIUS)
    first, second = (conicity(contact, [1e-3, 2e-3])[1] for contact in (one, two))
    assert_allclose(second.conicity, first.conicity, rtol=tol.MIRROR_CONICITY)
    assert_allclose(second.centre, -first.centre, atol=tol.MIRROR_CENTRE)


def test_like_sides_computed_twice_are_like():
    """The short way for like sides gives what both sides computed apart give."""
    short = s1002()
    pair = short.wheelset
    full = rolling(Wheelset(pair.right, replace(pair.right), pair.lateral), 8e-3)
    expected = np.interp(full.y, short.y, short.radius_difference)
    smooth = np.abs(np.abs(full.y)[:, None] - np.abs(short.y[short.jumps])).min(axis=1) > 1e-6
    assert_allclose(full.radius_difference[smooth], expected[smooth], atol=tol.DELTA_R_CHORD)
    assert_allclose(full.y[full.jumps], short.y[short.jumps], atol=2e-9)


@pytest.mark.parametrize("with_roll", [False, True])
def test_jumps_lie_where_two_contacts_touch(with_roll):
    contact = s1002(with_roll)
    assert contact.jumps.size >= 4
    assert np.diff(contact.y)[contact.jumps].max() <= 1e-9
    for i in contact.jumps:
        assert abs(np.diff(contact.radius_difference[[i, i + 1]])[0]) > 0.1e-3


@pytest.mark.parametrize("y, yaw", [(-5.5e-3, 0.0), (2e-3, 0.012), (6.5e-3, -0.02)])
def test_both_wheels_touch_where_a_brute_search_finds_it(y, yaw):
    """The naive search finds the same contacts, and both wheels hold the centre at the same height."""
    contact = contact_at(s1002().wheelset, with_roll=True, yaw=yaw)(y)
    roll, half, heights = contact[8], SETTINGS.lateral, []
    for k, side in enumerate((1.0, -1.0)):
        across = side * y + (half * math.cos(roll) - side * SETTINGS.radius * math.sin(roll)) * math.cos(yaw) - half
        pose = (across, side * roll, abs(yaw))
        minima = naive.difference_minima(bundled("ORES1002", "wheel"), bundled("UIC60", "rail"), SETTINGS, pose)
        s, gap = minima[np.argmin(minima[:, 1])]
        assert_allclose(contact[k], s, atol=tol.GRID_PLACE)
        heights.append(gap - side * half * math.sin(roll) - SETTINGS.radius * math.cos(roll))
    assert_allclose(heights[0], heights[1], atol=2 * tol.GRID_GAP)


def integrated(y, difference, amplitude):
    """Wavelength by an ordinary solver of y'' = -delta_r/(e r0), events at the two turning points."""

    def turns(x, state):
        return state[1]

    turns.terminal, turns.direction = True, 1.0
    found = solve_ivp(
        lambda x, state: (state[1], -np.interp(state[0], y, difference) / (BASE * RADIUS)),
        (0.0, 1000.0), (amplitude, -1e-15), events=turns, rtol=1e-10, atol=1e-14, max_step=0.02,
    )  # fmt: skip
    return 2.0 * found.t_events[0][0], found.y_events[0][0][0]


@pytest.mark.parametrize("amplitude", [0.1e-3, 1e-3, 3e-3, 5.5e-3])
def test_wavelength_against_an_ordinary_solver(amplitude):
    contact = s1002()
    wavelength, other_end = integrated(contact.y, contact.radius_difference, amplitude)
    motion = conicity(contact, [amplitude])[0]
    assert_allclose(motion.wavelength, wavelength, rtol=tol.WAVELENGTH)
    assert_allclose(other_end, -amplitude, atol=tol.TURNING_POINT)
    assert_allclose(motion.conicity, (2 * math.pi / wavelength) ** 2 * BASE * RADIUS / 2, rtol=2 * tol.WAVELENGTH)


def test_uneven_function_against_an_ordinary_solver():
    y = np.linspace(-10e-3, 10e-3, 4001)
    difference = 0.2 * y + 0.3e-3 + 20.0 * y**2
    motion = swing(y, difference, BASE, RADIUS, 2e-3)
    wavelength, other_end = integrated(y, difference, motion.centre + motion.amplitude)
    assert_allclose(other_end, motion.centre - motion.amplitude, atol=tol.TURNING_POINT)
    assert_allclose(motion.wavelength, wavelength, rtol=tol.WAVELENGTH)


def test_cubic_and_step_functions():
    """delta_r = c y^3: lambda = 4 sqrt(e r0 / c) K(1/2) / A; a step from -h to h: lambda = 4 sqrt(2 e r0 A / h)."""
    y = np.linspace(-8e-3, 8e-3, 16001)
    c, amplitude = 5e3, 3e-3
    motion = swing(y, c * y**3, BASE, RADIUS, amplitude)
    assert_allclose(motion.wavelength, 4 * math.sqrt(BASE * RADIUS / c) * 1.8540746773013719 / amplitude, rtol=1e-5)
    assert_allclose(motion.linearised, 0.375 * c * amplitude**2, rtol=1e-6)
    step, tiny = 1e-3, 1e-12
    motion = swing(np.array([-1.0, -tiny, tiny, 1.0]), np.array([-step, -step, step, step]), BASE, RADIUS, amplitude)
    assert_allclose(motion.wavelength, 4 * math.sqrt(2 * BASE * RADIUS * amplitude / step), rtol=1e-5)
    assert_allclose(motion.linearised, 2 * step / (math.pi * amplitude), rtol=1e-6)


def test_conicity_grows_with_a_function_that_stiffens():
    y = np.linspace(-8e-3, 8e-3, 3201)
    found = [swing(y, 0.1 * y + 3e3 * y**3, BASE, RADIUS, a).conicity for a in np.linspace(0.1e-3, 8e-3, 80)]
    assert np.all(np.diff(found) > 0.0)
    assert_allclose(found[0], 0.05, rtol=1e-3)


def test_what_does_not_swing_is_said():
    y = np.linspace(-5e-3, 5e-3, 1001)
    free = swing(y, 0.0 * y, BASE, RADIUS, 3e-3)
    assert free.wavelength == math.inf and free.conicity == 0.0
    for amplitude, difference in ((3e-3, -0.1 * y), (0.5e-3, -0.1 * y + 2e4 * y**3), (6e-3, 0.1 * y)):
        assert math.isnan(swing(y, difference, BASE, RADIUS, amplitude).conicity)


def test_steering_of_a_cone():
    pair = wheelset_on(SETTINGS, cone(0.05), bundled("UIC60", "rail"))
    rows = steering(rolling(pair, 8e-3), [2000.0, 800.0])
    for row in rows:
        assert_allclose(row.needed, BASE * RADIUS / row.curve)
        assert_allclose(row.index, row.needed / (2 * 0.05 * 8e-3), rtol=1e-6)
    assert_allclose(rows[0].outwards, rows[0].needed / 0.1, atol=0.05e-3)
    assert math.isnan(rows[1].outwards) and rows[1].index > 1.0


def test_flank_of_each_side():
    """The flank begins where the wheel is 60 degrees steep; a swing that stays inside does not reach it."""
    left, right = s1002().clearance
    assert left == -right and 6e-3 < right < 7e-3
    i = int(np.argmin(np.abs(s1002().y - right)))
    steep = np.array([0.0, -1e-6]) + s1002().y[i]
    angles = np.interp(steep, s1002().y, s1002().values["angle_right"])
    assert angles[0] >= math.radians(60.0) > angles[1]
    swings = conicity(s1002(), [right - 1e-6, right + 1e-6])
    assert [s1002().reaches_flank(motion) for motion in swings] == [False, True]
