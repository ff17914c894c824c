"""The steady states of the contact benchmark: balances, symmetry, a closed form; and what its criteria catch."""

import math
from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.contact_benchmark import (
    FRICTION,
    SPEED,
    VERTICAL,
    Bench,
    Pose,
    across,
    benchmark_rows,
    deviations,
    extremes,
    poses,
    steady_states,
)
from railcli.analysis.rigid_contact import wheelset_on
from railcli.errors import SimulationError
from railcli.files.contact_reference import contact_criteria, published
from railcli.model.submodels import CREEP_LAWS

LATERAL = (0.0, 0.4e-3, 2e-3, 4.5e-3)
MIRRORED = {"y_force": -1.0, "creep_t": -1.0, "eta": -1.0, "phi": -1.0}


@pytest.fixture(scope="module")
def pair(profiles, table):
    return wheelset_on(table.settings, *profiles)


@pytest.fixture(scope="module")
def at(pair):
    return poses(pair, LATERAL)


@pytest.fixture(scope="module")
def criteria():
    return contact_criteria()["benchmark"]


@pytest.fixture(scope="module")
def reference():
    """CONTACT's states with what only railcli's have."""
    states = published().benchmark
    return replace(states, values={**states.values, "tangential": np.ones_like(states.values["normal"])})


@pytest.mark.parametrize("law", CREEP_LAWS)
def test_each_wheel_bears_its_load_and_no_moment_about_the_axle_is_left(pair, table, at, law):
    """Forces and moments summed over the patches by hand."""
    bench = Bench(pair, table, creep_law=law)
    for pose in at:
        spin = bench.steady_spin(pose)
        axle = np.array(
            [-math.sin(pose.yaw) * math.cos(pose.roll), math.cos(pose.yaw) * math.cos(pose.roll), math.sin(pose.roll)]
        )
        moment, size = 0.0, 0.0
        for k in range(2):
            data = bench.loaded(k, pose, spin)
            total = np.zeros(3)
            for patch in data.contact[0][: int(data.rail[0]["patches"])]:
                n = np.array([0.0, -patch["slope"], 1.0]) / math.hypot(1.0, patch["slope"])
                t = np.cross(n, [1.0, 0.0, 0.0])
                force = patch["creep_x"] * np.array([1.0, 0.0, 0.0]) + patch["creep_t"] * t - patch["normal"] * n
                total -= force
                turn = axle @ (np.cross(patch["arm"], force) + patch["spin_moment"] * n)
                moment, size = moment + turn, size + abs(turn)
            assert_allclose(total[2], VERTICAL, rtol=tol.BENCH_LOAD)
        assert abs(moment) < tol.BENCH_MOMENT


def test_mirrored_wheelset_is_the_mirror_image(pair, table):
    bench = Bench(pair, table, creep_law="smooth")
    right, left = (steady_states(bench, poses(pair, sign * np.array(LATERAL[1:]))) for sign in (1.0, -1.0))
    assert_allclose(left.roll, -right.roll, atol=tol.BENCH_ROLL)
    assert_allclose(left.spin, right.spin, rtol=tol.BENCH_MIRROR)
    assert_allclose(left.delta_r, -right.delta_r, atol=tol.BENCH_MIRROR)
    for key, values in right.values.items():
        assert_allclose(left.values[key][:, ::-1] * MIRRORED.get(key, 1.0), values, rtol=tol.BENCH_MIRROR,
                        atol=tol.BENCH_MIRROR * np.nanmax(np.abs(values), initial=0.0), err_msg=key)  # fmt: skip


def test_cone_without_yaw_rolls_on_its_radius():
    """A centred cone of slope 1:20 touches where the rail is as steep; nothing slips but by spin."""
    slope = 0.05
    table = scenes.cone_table(math.atan(slope))
    pair = wheelset_on(table.settings, scenes.cone(math.atan(slope)), scenes.round_rail())
    states = steady_states(Bench(pair, table, creep_law="hard"), poses(pair, [0.0]))
    place = scenes.HEAD * slope / math.hypot(1.0, slope)
    assert_allclose(states.values["on_rail"], -place, atol=tol.BENCH_PLACE)
    assert_allclose(states.values["on_wheel"], -place, atol=tol.BENCH_PLACE)
    assert_allclose(states.values["z_wheel"], slope * place, atol=tol.BENCH_PLACE)
    assert_allclose(np.tan(states.values["angle"]), slope, atol=tol.BENCH_PLACE)
    radius = table.settings.radius + slope * place
    assert_allclose(states.values["xi"], 1.0 + states.spin[0] * radius / SPEED, atol=tol.BENCH_PLACE)
    assert_allclose(states.values["phi"] * [-1.0, 1.0], -states.spin[0] * math.sin(math.atan(slope)) / SPEED,
                    rtol=tol.BENCH_MIRROR)  # fmt: skip
    assert np.all(states.values["patches"] == 1) and np.all(np.isnan(states.values["other_on_rail"]))
    assert_allclose(states.values["x_force"], 0.0, atol=FRICTION * VERTICAL * tol.BENCH_SPIN_PULL)


def test_pose_off_the_table_is_one_sentence(pair, table, at):
    with pytest.raises(SimulationError, match="y = 15 mm: left table"):
        Bench(pair, table, creep_law="hard").settle(Pose(15e-3, 0.0, 0.0, at[0].touching))


def test_reference_itself_meets_every_criterion(reference, criteria):
    jumps = [np.mean(bracket) * 1e-3 for bracket in criteria["jumps_mm"]]
    rows = benchmark_rows("it", reference, reference, jumps, criteria)
    assert all(row.found == 0.0 and row.kept for row in rows)
    assert all(values == (0.0, 0.0) for values in extremes(reference, reference, criteria["spread"]).values())


@pytest.mark.parametrize(
    "key, y_mm, wheel, change, name",
    [
        ("on_rail", 3, 0, 0.21e-3, "position [mm], 2"),
        ("on_wheel", 10, 1, -0.21e-3, "position [mm], 2"),
        ("on_rail", 1, 1, 0.51e-3, "position [mm], 1 mm"),
        ("z_wheel", 6, 0, 0.051e-3, "delta-r [mm], 1"),
        ("z_wheel", 8, 1, 0.101e-3, "delta-r [mm], 7"),
        ("normal", 0.5, 0, 101.0, "normal force, relative, 0"),
        ("normal", 9, 0, 361.0, "normal force, relative, 7"),
        ("tangential", 1, 0, -0.011, "size of the creep force, from mu N, 1 mm"),
        ("tangential", 8, 1, 0.011, "size of the creep force, from mu N, 2 to"),
        ("creep_x", 7, 1, 151.0, "components"),
        ("creep_t", 2, 0, -151.0, "components"),
    ],
)
def test_each_criterion_catches_its_deviation(reference, criteria, key, y_mm, wheel, change, name):
    values = {**reference.values, key: reference.values[key].copy()}
    values[key][reference.at(y_mm * 1e-3), wheel] += change
    rows = benchmark_rows("it", replace(reference, values=values), reference, [4.8e-3, 6.2e-3], criteria)
    missed = [row.name for row in rows if row.counts and not row.kept]
    assert len(missed) == 1 and missed[0].startswith(f"it: {name}")


@pytest.mark.parametrize("jumps, count", [([4.49e-3, 6.2e-3], 1), ([5.01e-3, 6.51e-3], 2), ([4.5e-3, 6.5e-3], 0)])
def test_jump_outside_its_bracket_is_caught(reference, criteria, jumps, count):
    rows = benchmark_rows("it", reference, reference, jumps, criteria)
    assert sum(not row.kept for row in rows) == count


@pytest.mark.parametrize(
    "criterion, name", [("components", "components"), ("flange_normal", "normal force, relative, 7")]
)
def test_criterion_that_a_law_cannot_keep_is_shown_only(reference, criteria, criterion, name):
    for shown in ((), (criterion,)):
        rows = benchmark_rows("it", reference, reference, [4.8e-3, 6.2e-3], criteria, shown)
        assert [row.counts for row in rows if row.name.startswith(f"it: {name}")] == [not shown]
    assert sum(not row.counts for row in rows) == 3


def test_force_across_of_the_reference_states(reference):
    """In full slip printed forces lie on the friction circle, but where two patches of other angles are merged."""
    values = reference.values
    assert_allclose(values["creep_t"], across(values["y_force"], values["angle"]))
    sliding = np.repeat((reference.y > 0.9e-3)[:, None], 2, axis=1)
    sliding[reference.at(5e-3), 0] = False
    size = np.hypot(values["creep_x"], values["creep_t"])[sliding]
    assert_allclose(size, FRICTION * values["normal"][sliding], rtol=tol.PRINTED_FORCES)


def test_deviations_are_relative_where_they_say_so(reference):
    values = {key: 1.1 * item for key, item in reference.values.items()}
    off = deviations(replace(reference, values=values), reference)
    assert_allclose(off["area"], 0.1)
    assert_allclose(off["on_rail"], 0.1 * reference.values["on_rail"])
    assert_allclose(off["creep_x"], 0.1 * reference.values["creep_x"] / (FRICTION * reference.values["normal"]))
