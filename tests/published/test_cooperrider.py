"""The Cooperrider wagon beside the program it comes from (benchmarks/curves/SOURCES.md, [D])."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol

from railcli.analysis.build_table import build_table
from railcli.analysis.decay_check import (
    ASIDE,
    bogie_hunting,
    conicity,
    critical_speed,
    swings,
    with_spinning_axes,
)
from railcli.analysis.linear import linearise
from railcli.analysis.rigid_contact import contact_at
from railcli.analysis.simulate import settled_start
from railcli.files.curves_reference import curves_reference, curves_scenarios, wheelset_of
from railcli.files.profiles import profile_of
from railcli.model.system import assemble, table_settings

SPEED = 100.0


@pytest.fixture(scope="module")
def decays():
    return curves_reference().decays


@pytest.fixture(scope="module")
def scenario():
    return curves_scenarios()[1]


@pytest.fixture(scope="module")
def system(scenario):
    """With Hertz's patches, whose table takes less time to build than any other."""
    case = scenario.varied(contact={"normal": "hertz"})
    profiles = (profile_of(case, place, kind) for place, kind in
                ((case.contact.wheel_profile, "wheel"), (case.contact.rail_profile, "rail")))  # fmt: skip
    own = table_settings(case, 0.425)
    small = {key: getattr(scenes.SMALL, key) for key in ("y_range", "roll_range", "yaw_count")}
    return assemble(case, [build_table(*profiles, replace(own, yaw_range=5e-3, **small))[0]])


def test_the_wheel_has_the_conicity_and_the_places_of_the_published_table(decays, scenario):
    contact = contact_at(wheelset_of(scenario), with_roll=True)
    near = np.abs(decays.y) < 5e-3
    rows = np.array([contact(float(y)) for y in decays.y[near]])
    ours, theirs = conicity(decays.y[near], rows[:, 6]), conicity(decays.y, decays.radius)
    assert ours == pytest.approx(theirs, rel=tol.COOPERRIDER_CONICITY)
    assert rows[:, 0] == pytest.approx(decays.on_wheel[near], abs=tol.COOPERRIDER_PLACE)
    assert rows[:, 4] == pytest.approx(decays.angle[near], abs=tol.COOPERRIDER_ANGLE)


def test_conicity_of_cones():
    y = np.array([-2e-3, -1e-3, 0.0, 1e-3, 2e-3, 3e-3])
    assert conicity(y, 0.425 + 0.05 * y) == pytest.approx([0.05, 0.05], rel=tol.ROUNDING)


def test_only_the_first_wheelsets_start_aside(system):
    aside = np.zeros(system.model.body.size)
    aside[list(system.wheelsets[::2])] = ASIDE
    rest, data = settled_start(system), settled_start(system, aside)
    assert data.q[:, 1] - rest.q[:, 1] == pytest.approx(aside, abs=tol.PLACE)
    moved = (data.q[:, 2:4] != rest.q[:, 2:4]).any(axis=1)
    assert list(np.flatnonzero(moved)) == list(system.wheelsets[::2])


def test_gyroscopic_moments_of_spinning_axes(system):
    """The model has those of axes that do not spin, Iy W; the change puts Euler's in their place, here -(Ix - Iy) W."""
    linear = linearise(system, SPEED)
    changed = with_spinning_axes(linear)
    i, n = system.wheelsets[0], 6 * linear.size
    roll, yaw = (int(np.flatnonzero(linear.kept == n + 6 * i + k)[0]) for k in (3, 5))
    ix, iy, _ = system.model.body["inertia"][i]
    spin = SPEED / system.radii[i]
    creep = linear.matrix[yaw, roll] - iy / ix * spin
    assert abs(creep) < tol.GYROSCOPIC * spin
    assert changed.matrix[yaw, roll] - creep == pytest.approx((iy - ix) / ix * spin, rel=tol.CREEP_TWIN)
    assert changed.matrix[roll, yaw] - linear.matrix[roll, yaw] == pytest.approx(spin, rel=tol.CREEP_TWIN)
    differs = np.argwhere(changed.matrix != linear.matrix)
    assert len(differs) == 2 * len(system.wheelsets)


def test_frequency_of_the_bogie_mode(system, decays):
    for speed, frequency in zip(decays.speed, decays.frequency, strict=True):
        assert bogie_hunting(linearise(system, float(speed)))[1] == pytest.approx(frequency, rel=tol.COOPERRIDER_HZ)


def test_critical_speed_is_where_the_mode_begins_to_grow(system):
    found = critical_speed(system, lambda linear: linear)
    below, above = (bogie_hunting(linearise(system, found + step))[0] for step in (-2.0, 2.0))
    assert below < 0.0 < above
    assert critical_speed(system, with_spinning_axes) < found - 2.0


def test_no_critical_speed_where_all_decays(system):
    def damped(linear):
        return replace(linear, matrix=linear.matrix - 5.0 * np.eye(linear.matrix.shape[0]))

    assert np.isnan(critical_speed(system, damped))


def test_the_swing_dies_faster_the_faster_it_runs(system, decays):
    """As in the published runs, at speeds far enough apart."""
    fine = system.stepped(0.25e-3)
    ours = [swings(fine, speed, [(1.0, 2.0)])[0] for speed in (25.0, 50.0, 80.0)]
    assert ours == sorted(ours, reverse=True)
    assert ours[0] < ASIDE
