"""The normal law of strips: one energy, whose gradient is the force, directly and from a table of heights."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import build_table
from railcli.analysis.certify import direct_minima
from railcli.analysis.overlap import Law
from railcli.files.profile_import import ImportSettings, import_profile
from railcli.kernels.layout import Part
from railcli.kernels.step import evaluate
from railcli.model.contact_table import mount

LARGE = scenes.STRIPS
SAMPLES = Path(__file__).parents[1] / "data" / "samples"
WORN = replace(LARGE, inclination=0.0, y_range=3.5e-3, roll_range=3e-3, yaw_range=8e-3)
ROOT_POSE = (1.221e-3, 4.663e-3)  # roll, yaw at which a minimum of the gap folds as y grows [rad]
PLACES = (-4e-3, 0.0, 3e-3, 5.2e-3, 6.1e-3, 6.5e-3, 6.9e-3)  # from the tread over the root to the flank [m]


@pytest.fixture(scope="module")
def law(profiles):
    return Law(mount(*profiles, LARGE), LARGE.young, LARGE.poisson)


@pytest.fixture(scope="module")
def worn():
    """Measured wheel and rail, smoothed by 4 mm."""
    smooth, names = ImportSettings(smooth=4e-3), ("whl_left_iter288.whl", "rail_left_iter288.ban")
    return [import_profile(SAMPLES / name, smooth).profile for name in names]


def touch(law, y, roll, yaw):
    """Height of first touch [m]."""
    return direct_minima(law.mounting, (y, roll, abs(yaw)), law.stations)[:, 1].min()


def loop(seed, count, place=5.6e-3, reach=1.2e-3):
    """Poses (count, 4) of a closed path y, depth, roll, yaw, from the tread to the flank and back."""
    random = np.random.default_rng(seed)
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    middle, swing = np.array([place, 0.0, 1e-3, 4e-3]), np.array([reach, 25e-6, 1.5e-3, 2.5e-3])
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
        least = tol.STRIP_SLOPE * found.gradient[1] * 5e-3
        assert_allclose(found.gradient[k], slope, rtol=tol.STRIP_SLOPE, atol=least)


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


def pressed_loop(law, seed, count, *where):
    """A closed path that keeps near to 70 um below first touch."""
    path = loop(seed, count, *where)
    some = np.array([touch(law, y, roll, yaw) for y, _, roll, yaw in path[::40]])
    along = np.arange(count)
    path[:, 1] += np.interp(along, np.arange(count // 40 + 1) * 40.0, np.r_[some, some[0]]) + 70e-6
    return path


def check_closed(table, path):
    """No work around the path, and in each step of it what the energy gains."""
    found = [scenes.stored_at(table, *pose) for pose in path]
    energy, force = np.array([each[0] for each in found]), np.array([each[1] for each in found])
    move = np.roll(path, -1, axis=0) - path
    work = np.sum(0.5 * (force + np.roll(force, -1, axis=0)) * move)
    assert abs(work) < tol.CLOSED_PATH * energy.max()
    rise = np.diff(energy) - np.sum(0.5 * (force[1:] + force[:-1]) * move[:-1], axis=1)
    assert np.abs(rise).max() < tol.CLOSED_PATH * energy.max()
    return max(len(each[2]) for each in found)


@pytest.mark.parametrize("seed", range(8))
def test_no_work_on_closed_paths_of_the_table(heights, law, seed):
    check_closed(heights, pressed_loop(law, seed, 4000))


def test_no_work_on_closed_paths_of_a_worn_pair(worn):
    """Whose wheel bears on up to three patches, from the field side to the flange root."""
    table = build_table(*worn, WORN)[0]
    law = Law(mount(*worn, WORN), WORN.young, WORN.poisson)
    assert max(check_closed(table, pressed_loop(law, seed, 4000, -0.5e-3, 2e-3)) for seed in range(4)) > 2


@pytest.mark.parametrize("pose", [(4.779e-3, 22.5e-3, 30e-3), (3.32e-3, -25e-3, 0.0), (4.881e-3, -25e-3, 27.39e-3)])
def test_force_of_a_worn_pair_begins_with_first_touch_and_grows(worn, pose):
    """Where the outline of a rough wheel folds or runs ahead, and beyond the end of the graph of the rail."""
    y, roll, yaw = pose
    law = Law(mount(*worn, WORN), WORN.young, WORN.poisson)
    z = touch(law, y, roll, yaw)
    depths = np.arange(5e-6, 400e-6, 5e-6)
    energy = np.array([law(y, z + depth, roll, yaw).energy for depth in depths])
    assert energy[1] == 0.0 or energy[1] < 0.1 * energy[10]
    assert (np.diff(energy, 2)[energy[2:] > 0.0] > -tol.CONVEX * energy.max()).all() and (np.diff(energy) >= 0.0).all()
    assert energy[-1] > 0.1


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
    poses = zip(y, floor + 60e-6, strict=True)
    force = np.array([scenes.stored_at(heights, *each, roll, yaw)[1][:2] for each in poses])
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
            total += scenes.stored_at(heights, y, z, side * q[3], side * q[5])[0]
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
    assert_allclose(load[1:3], [-slopes[1], -slopes[2]], rtol=tol.STRIP_SLOPE, atol=1.0)
    assert_allclose([load[3], about_z], [-slopes[3], -slopes[5]], atol=tol.STRIP_SLOPE * abs(load[2]) * 0.05, rtol=0)


def test_shares_of_the_patches_and_places_follow_the_law(heights, law):
    random = np.random.default_rng(3)
    off = []
    for _ in range(60):
        y, roll, yaw = random.uniform(-6e-3, 6.8e-3), random.uniform(-3e-3, 3e-3), random.uniform(-6e-3, 6e-3)
        z = touch(law, y, roll, yaw) + 70e-6
        direct = law(y, z, roll, abs(yaw))
        patches = scenes.stored_at(heights, y, z, roll, yaw)[2]
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
