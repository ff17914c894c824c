"""The normal law of strips: one energy, whose gradient is the force, directly and from a table of heights."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import build_table
from railcli.analysis.certify import direct_minima
from railcli.analysis.overlap import Law
from railcli.kernels.heights import POWER, stored
from railcli.kernels.layout import NODE_CHANNELS, SAMPLE_ROWS, Part
from railcli.kernels.step import evaluate
from railcli.model.contact_table import TableSettings, mount

LARGE = TableSettings(normal="overlap", y_range=8e-3, roll_range=6e-3, yaw_range=10e-3)
ROOT_POSE = (1.221e-3, 4.663e-3)  # roll, yaw at which a minimum of the gap folds as y grows [rad]
PLACES = (-4e-3, 0.0, 3e-3, 5.2e-3, 6.1e-3, 6.5e-3, 6.9e-3)  # from the tread over the root to the flank [m]


@pytest.fixture(scope="module")
def law(profiles):
    return Law(mount(*profiles, LARGE), LARGE.young, LARGE.poisson)


@pytest.fixture(scope="session")
def heights(profiles):
    """Table of heights of S1002 on UIC60 over a small range."""
    return build_table(*profiles, LARGE)[0]


def touch(law, y, roll, yaw):
    """Height of first touch [m]."""
    return direct_minima(law.mounting, (y, roll, abs(yaw)), law.stations)[:, 1].min()


def look_up(table, y, z, roll, yaw):
    """Energy and gradient of a table, its patches."""
    sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))
    count, _, depth, *gradient = stored(
        table.record[0], table.cell, table.branch, table.heights, y, roll, yaw, z, 0, sample
    )
    assert count >= 0
    return depth * gradient[1] / POWER, np.array(gradient), sample[:count]


def loop(seed, count):
    """Poses (count, 4) of a closed path y, depth, roll, yaw, from the tread to the flank and back."""
    random = np.random.default_rng(seed)
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    middle, swing = np.array([5.6e-3, 0.0, 1e-3, 4e-3]), np.array([1.2e-3, 25e-6, 1.5e-3, 2.5e-3])
    waves = sum(
        random.normal(size=4) / k * np.sin(k * turn[:, None] + random.uniform(0.0, 2.0 * np.pi, 4)) for k in (1, 2, 3)
    )
    return middle + swing * waves / np.abs(waves).max(axis=0)


@pytest.mark.parametrize("y", PLACES)
def test_the_force_is_the_gradient_of_the_energy(law, y):
    roll, yaw = ROOT_POSE
    pose = np.array([y, touch(law, y, roll, yaw) + 70e-6, roll, yaw])
    found = law(*pose)
    for k, step in enumerate((2e-7, 2e-7, 2e-6, 2e-5)):
        ahead, behind = pose.copy(), pose.copy()
        ahead[k] += step
        behind[k] -= step
        slope = (law(*ahead).energy - law(*behind).energy) / (2.0 * step)
        least = tol.ENERGY_SLOPE * found.gradient[1] * 5e-3
        assert_allclose(found.gradient[k], slope, rtol=tol.ENERGY_SLOPE, atol=least)


@pytest.mark.parametrize("seed", range(3))
def test_no_work_on_closed_paths_of_the_law(law, seed):
    path = loop(seed, 1000)
    heights = np.array([touch(law, y, roll, yaw) for y, _, roll, yaw in path])
    path[:, 1] += np.convolve(np.r_[heights[-10:], heights, heights[:10]], np.ones(21) / 21.0, "valid") + 70e-6
    found = [law(*pose) for pose in path]
    energy, force = np.array([each.energy for each in found]), np.array([each.gradient for each in found])
    move = np.roll(path, -1, axis=0) - path
    work = np.sum(0.5 * (force + np.roll(force, -1, axis=0)) * move)
    assert abs(work) < tol.CLOSED_PATH * energy.max()


@pytest.mark.parametrize("seed", range(8))
def test_no_work_on_closed_paths_of_the_table(heights, law, seed):
    path = loop(seed, 4000)
    some = np.array([touch(law, y, roll, yaw) for y, _, roll, yaw in path[::40]])
    along = np.arange(-40, 4040)
    path[:, 1] += np.interp(along, np.arange(-1, 101) * 40.0, np.r_[some[-1], some, some[0]])[40:4040] + 70e-6
    found = [look_up(heights, *pose)[:2] for pose in path]
    energy, force = np.array([each[0] for each in found]), np.array([each[1] for each in found])
    move = np.roll(path, -1, axis=0) - path
    work = np.sum(0.5 * (force + np.roll(force, -1, axis=0)) * move)
    assert abs(work) < tol.CLOSED_PATH * energy.max()
    rise = np.diff(energy) - np.sum(0.5 * (force[1:] + force[:-1]) * move[:-1], axis=1)
    assert np.abs(rise).max() < tol.CLOSED_PATH * energy.max()


def test_vertical_force_grows_through_root_and_flank_at_a_fixed_height(law):
    roll, yaw = ROOT_POSE
    z = touch(law, 6.5e-3, roll, yaw) + 80e-6
    y = np.arange(6.40e-3, 6.56e-3, 0.01e-3)
    vertical = np.array([law(each, z, roll, yaw).gradient[1] for each in y])
    assert (np.diff(vertical) > 0.0).all()


@pytest.mark.parametrize(("roll", "yaw"), [ROOT_POSE, (0.0, 0.0), (-3e-3, 8e-3), (3e-3, 2e-3)])
def test_no_force_jumps_along_fine_sweeps(heights, law, roll, yaw):
    y = np.arange(5.0e-3, 7.2e-3, 50e-9)
    floor = np.interp(y, y[::800], [touch(law, each, roll, yaw) for each in y[::800]])
    force = np.array([look_up(heights, each, z + 60e-6, roll, yaw)[1][:2] for each, z in zip(y, floor, strict=True)])
    assert np.abs(np.diff(force, axis=0)).max() < tol.FINE_SWEEP


def test_patches_join_and_part_with_a_smooth_energy(law):
    roll, yaw = 0.0, 0.0
    y = np.arange(5.6e-3, 6.7e-3, 0.01e-3)
    z = touch(law, 6.1e-3, roll, yaw) + 90e-6
    found = [law(each, z, roll, yaw) for each in y]
    counts = {np.count_nonzero(np.diff((each.line_load > 0.0).astype(int)) == 1) for each in found}
    assert len(counts) > 1
    lateral = np.array([each.gradient[0] for each in found])
    assert np.abs(np.diff(lateral, 2)).max() < tol.JOINING * np.abs(lateral).max()


def test_the_wheels_of_a_wheelset_are_mirror_images(heights):
    system = scenes.lone_wheelset(heights, 10.0, friction=0.3, damping=0.0)
    forces = []
    for side in (1.0, -1.0):
        data = system.start()
        data.q[0, 1], data.q[0, 2], data.q[0, 3], data.q[0, 5] = side * 5.9e-3, 80e-6, side * 1e-3, side * 3e-3
        assert evaluate(system.model, data, 0.0) == 0
        forces.append(data.rail_load[0].copy())
    assert np.abs(forces[0]).max() > 1e4
    assert_allclose(forces[0] * [1, -1, 1, -1, 1, -1], forces[1], rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("lateral", [0.5e-3, 5.3e-3, 6.2e-3, -6.4e-3])
def test_loads_on_a_wheelset_are_the_gradient_of_the_energies_of_its_wheels(heights, lateral):
    """Force and moment of the step, patches and couple, on a wheelset without friction."""
    system = scenes.lone_wheelset(heights, 10.0, friction=0.0, damping=0.0)
    settings = heights.settings

    def energy(q):
        total = 0.0
        for side in (1.0, -1.0):
            cr, sr, cy = math.cos(q[3]), math.sin(q[3]), math.cos(q[5])
            y = side * q[1] + (settings.lateral * cr - side * settings.radius * sr) * cy - settings.lateral
            z = q[2] + side * settings.lateral * sr + settings.radius * cr
            total += look_up(heights, y, z, side * q[3], side * q[5])[0]
        return total

    data = system.start()
    data.q[0, 1:] += [lateral, 60e-6, 0.8e-3, 0.0, 2.5e-3]
    assert evaluate(system.model, data, 0.0) == 0
    slopes = {}
    for k, step in ((1, 1e-8), (2, 1e-8), (3, 1e-7), (5, 1e-6)):
        ahead, behind = data.q[0].copy(), data.q[0].copy()
        ahead[k] += step
        behind[k] -= step
        slopes[k] = (energy(ahead) - energy(behind)) / (2.0 * step)
    load = data.rail_load[0]
    about_z = math.cos(data.q[0, 3]) * load[5]  # the moment about the wheelset's own down axis, turned to that of yaw
    assert_allclose(load[1:3], [-slopes[1], -slopes[2]], rtol=tol.ENERGY_SLOPE, atol=1.0)
    assert_allclose([load[3], about_z], [-slopes[3], -slopes[5]], atol=tol.ENERGY_SLOPE * abs(load[2]) * 0.05, rtol=0)


def test_shares_of_the_patches_and_places_follow_the_law(heights, law):
    random = np.random.default_rng(3)
    off = []
    for _ in range(60):
        y, roll, yaw = random.uniform(-6e-3, 6.8e-3), random.uniform(-3e-3, 3e-3), random.uniform(-6e-3, 6e-3)
        z = touch(law, y, roll, yaw) + 70e-6
        direct = law(y, z, roll, abs(yaw))
        patches = look_up(heights, y, z, roll, yaw)[2]
        share = patches[:, Part.SHARE] / patches[:, Part.SHARE].sum()
        mean = direct.patches[:, Part.SHARE] @ direct.patches[:, Part.LATERAL]
        off.append(abs(share @ patches[:, Part.LATERAL] - mean))
        assert_allclose(patches[:, Part.SHARE].sum(), 1.0, atol=1e-9)
    assert np.median(off) < tol.STORED_PLACE


def test_settings_do_not_matter_to_the_law(profiles, law):
    finer = Law(mount(*profiles, LARGE), LARGE.young, LARGE.poisson, fineness=2.0)
    for y in PLACES:
        z = touch(law, y, *ROOT_POSE) + 80e-6
        assert_allclose(law(y, z, *ROOT_POSE).energy, finer(y, z, *ROOT_POSE).energy, rtol=tol.STRIP_WIDTH)


def test_a_stiffer_material_scales_the_force(profiles, law):
    soft = replace(LARGE, young=0.5 * LARGE.young)
    other = Law(mount(*profiles, soft), soft.young, soft.poisson)
    z = touch(law, 2e-3, 0.0, 0.0) + 80e-6
    assert_allclose(2.0 * other(2e-3, z, 0.0, 0.0).gradient[:2], law(2e-3, z, 0.0, 0.0).gradient[:2], rtol=1e-5)
