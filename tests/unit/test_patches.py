"""Patches of a loaded wheelset against closed forms, the mirror, the rigid limit and the compiled step."""

import math
from functools import cache

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from railcli.analysis.patches import ellipse_outline, standing
from railcli.analysis.rigid_contact import Wheelset, contact_at, wheelset_on
from railcli.errors import InputError
from railcli.files.profiles import load_profile
from railcli.kernels.layout import new_data
from railcli.kernels.step import evaluate
from railcli.model.contact_table import TableSettings

LOAD, YOUNG, POISSON = 55e3, 210e9, 0.28
CONE = 0.05  # angle [rad]


@cache
def s1002(inclination=20.0):
    settings = TableSettings(inclination=inclination)
    return wheelset_on(settings, load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail"))


def stand(pair, load=LOAD, **options):
    return standing(pair, load, YOUNG, POISSON, **options)


def vertical(patches):
    return sum(patch.normal * math.cos(patch.angle) for patch in patches)


@pytest.mark.parametrize("y", [-4e-3, 0.0, 3e-3])
def test_strips_under_a_cone_on_a_round_rail(y):
    """The law of strips gives Hertz's force, area and pressure where the gap has one curvature each way."""
    settings = scenes.round_settings()
    pair = wheelset_on(settings, scenes.cone(CONE), scenes.round_rail())
    found = stand(pair, normal="overlap")(y)
    assert [patch.side for patch in found.patches] == ["right", "left"]
    for patch, side in zip(found.patches, (1.0, -1.0), strict=True):
        s, _, angle, radius = naive.cone_on_circle((side * y, 0.0, 0.0), CONE, settings.radius, scenes.HEAD)
        assert_allclose([patch.on_wheel, patch.radius], [s, radius], atol=tol.STRIP_PLACE)
        assert_allclose([patch.angle, patch.normal], [angle, LOAD / math.cos(CONE)], rtol=tol.STRIP_WIDTH)
        a, b, approach = naive.hertz_ellipse(
            0.5 * math.cos(CONE) / radius, 0.5 / scenes.HEAD, YOUNG, POISSON, patch.normal
        )
        assert_allclose(patch.approach, approach, rtol=tol.STRIP_WIDTH)
        assert_allclose(patch.area, math.pi * a * b, rtol=tol.STRIP_EDGE)
        assert_allclose(patch.pressure, 1.5 * patch.normal / (math.pi * a * b), rtol=tol.STRIP_EDGE)


@pytest.mark.parametrize("y", [-4e-3, 0.0, 3e-3])
def test_cone_on_a_round_rail(y):
    """One ellipse on each wheel: Hertz's closed form at load / cos(angle), where a cone and a circle touch."""
    settings = scenes.round_settings()
    pair = wheelset_on(settings, scenes.cone(CONE), scenes.round_rail())
    found = stand(pair)(y)
    assert [patch.side for patch in found.patches] == ["right", "left"] and found.roll == 0.0
    for patch, side in zip(found.patches, (1.0, -1.0), strict=True):
        s, _, angle, radius = naive.cone_on_circle((side * y, 0.0, 0.0), CONE, settings.radius, scenes.HEAD)
        assert_allclose([patch.on_wheel, patch.radius], [s, radius], atol=tol.SIMPLEX_PLACE)
        assert_allclose([patch.angle, patch.normal], [angle, LOAD / math.cos(CONE)], rtol=tol.LONE_PATCH)
        along, across = 0.5 * math.cos(CONE) / radius, 0.5 / scenes.HEAD
        a, b, approach = naive.hertz_ellipse(along, across, YOUNG, POISSON, patch.normal)
        assert_allclose(
            [patch.half_length, patch.half_width, patch.approach], [a, b, approach], rtol=tol.LONE_PATCH
        )
        assert_allclose(patch.area, math.pi * a * b, rtol=tol.LONE_PATCH)
        assert_allclose(patch.pressure, 1.5 * patch.normal / (math.pi * a * b), rtol=tol.LONE_PATCH)
    assert_allclose(np.subtract(*(patch.radius for patch in found.patches)), 2.0 * y * math.tan(CONE), atol=tol.CONE)


def test_outline_of_an_ellipse():
    a, b = 6e-3, 2.5e-3
    outline = ellipse_outline(a, b)
    assert_allclose((outline[:, 0] / a) ** 2 + (outline[:, 1] / b) ** 2, 1.0, rtol=tol.ROUNDING)
    assert_allclose(0.5 * np.ptp(outline, axis=0), [a, b], rtol=tol.ROUNDING)
    x, t = outline.T
    enclosed = 0.5 * abs(np.dot(x, np.roll(t, -1)) - np.dot(t, np.roll(x, -1)))
    assert_allclose(enclosed, math.pi * a * b, rtol=tol.POLYGON)


@pytest.mark.parametrize("with_roll, yaw", [(False, 0.0), (True, 0.0), (True, 0.02)])
def test_each_wheel_bears_its_load(with_roll, yaw):
    """Also where it stands on several patches, and on the flank."""
    at, most = stand(s1002(), with_roll=with_roll, yaw=yaw), 0
    for y in np.array([-8.0, -6.0, -2.0, 0.0, 5.0, 6.0, 6.3, 7.0]) * 1e-3:
        found = at(y)
        for side in ("right", "left"):
            assert_allclose(vertical(found.of(side)), LOAD, rtol=tol.LOAD_BORNE)
            most = max(most, len(found.of(side)))
    assert most >= 2


@pytest.mark.parametrize("with_roll, yaw", [(False, 0.01), (True, -0.01)])
def test_mirror(with_roll, yaw):
    """To the left with the opposite yaw a wheelset with like sides stands as the mirror image."""
    one, other = (stand(s1002(40.0), with_roll=with_roll, yaw=sign * yaw)(sign * 5.2e-3) for sign in (1.0, -1.0))
    assert_allclose(other.roll, -one.roll, atol=tol.ROLL)
    for side, opposite in (("right", "left"), ("left", "right")):
        pairs = list(zip(one.of(side), other.of(opposite), strict=True))
        assert pairs
        for a, b in pairs:
            assert a.region == b.region
            assert_allclose(b.on_wheel, a.on_wheel, atol=tol.SIMPLEX_PLACE)
            assert_allclose([b.normal, b.pressure], [a.normal, a.pressure], rtol=tol.MIRROR)


def test_unlike_sides_exchanged():
    wheel, rail = load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail")
    pair = wheelset_on(TableSettings(), wheel, rail, left_rail=load_profile("60E1", "rail"), left_radius=0.455)
    one = stand(pair, with_roll=True)(3e-3)
    two = stand(Wheelset(pair.left, pair.right, pair.lateral), with_roll=True)(-3e-3)
    assert one.roll < -1e-3  # the smaller left wheel goes down
    assert_allclose(two.roll, -one.roll, atol=tol.ROLL)
    assert_allclose(two.of("right")[0].pressure, one.of("left")[0].pressure, rtol=tol.MIRROR)


@pytest.mark.parametrize("y", [-6.5e-3, 2e-3, 6.2e-3])
def test_unloaded_limit_is_the_rigid_wheelset(y):
    """As the load vanishes, roll and contact points become those of rigid bodies."""
    rigid = contact_at(s1002(), with_roll=True)(y)
    found = stand(s1002(), load=1e-3, with_roll=True)(y)
    assert_allclose(found.roll, rigid[8], atol=tol.ROLL)
    for k, side in enumerate(("right", "left")):
        (patch,) = found.of(side)
        assert_allclose(patch.on_wheel, rigid[k], atol=tol.UNLOADED_PLACE)
        assert_allclose(patch.angle, rigid[4 + k], atol=tol.UNLOADED_PLACE)


@pytest.mark.parametrize("y", [1e-3, 4.5e-3, 5.98e-3])
def test_the_step_sees_the_same_patches(table, y):
    """A wheelset of the compiled core in this pose, its height found by its weight, has the same forces."""
    found = stand(s1002(), with_roll=True)(y)
    system = scenes.lone_wheelset(table, 10.0)

    def contacts(z):
        q = system.rest.copy()
        q[0, 1:4] = y, z, found.roll
        data = new_data(system.model, q, 0)
        data.v[0, 0] = 10.0
        assert evaluate(system.model, data, 0.0) == 0
        return data.contact

    def weight(z):
        contact = contacts(z)
        return np.sum(contact["normal"] / np.sqrt(1.0 + contact["slope"] ** 2)) - 2.0 * LOAD

    level = -table.settings.radius
    core = contacts(brentq(weight, level - 3e-3, level + 3e-3, xtol=1e-12))
    for w in range(2):
        side = "right" if system.model.wheel[w]["side"] > 0.0 else "left"
        here = core[w][core[w]["normal"] > 0.0]
        patches = found.of(side)
        assert len(patches) == here.size
        assert_allclose([patch.normal for patch in patches], here["normal"], atol=tol.TABLE_FORCE * LOAD)
        assert_allclose([patch.on_wheel for patch in patches], here["lateral"], atol=tol.TABLE_PLACE)


def test_a_load_that_cannot_be_borne():
    with pytest.raises(InputError, match="smaller load"):
        stand(s1002(), load=1e8)(0.0)
