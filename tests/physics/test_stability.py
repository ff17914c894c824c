"""Hunting of the wagon on its own contact table: limit cycles and where they end."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol

from railcli.analysis import indices
from railcli.analysis.build_table import build_table
from railcli.analysis.linear import linearise, modes, on_straight
from railcli.analysis.mode_shapes import describe
from railcli.analysis.quasi_linear import lines_of, quasi_linear_system
from railcli.analysis.simulate import settled_start
from railcli.analysis.stability import Measures, end_of, ramp
from railcli.errors import SimulationError
from railcli.files.scenario import load
from railcli.kernels.recording import new_rows
from railcli.kernels.step import advance, record

LAWS = {"creep_law": "table", "normal": "hertz"}  # whose cycles settle within the runs below


@pytest.fixture(scope="module")
def hunting(profiles):
    """The wagon on rails at 1:40."""
    table = build_table(*profiles, replace(scenes.SMALL, inclination=40.0))[0]
    return scenes.wagon(table, "stability", contact=LAWS)


MEASURES = Measures(1.5e-3, np.full(4, 8e3))  # cycles of 1.5 mm count; a limit of sum Y below the cycle of 75 m/s


@pytest.fixture(scope="module")
def cycles(hunting):
    return list(ramp(hunting, 75.0, 15.0, 20.0, 5e-3, 2.0, measures=MEASURES))


def test_hunting_shrinks_with_the_speed_and_ends(cycles):
    """Amplitudes fall from segment to segment, and the end is closed in to the resolution asked for."""
    below, above = end_of(cycles)
    assert 0.0 < above - below <= 2.0
    ordered = sorted(cycles, key=lambda cycle: cycle.speed)
    assert [cycle.hunts for cycle in ordered] == [cycle.speed >= above for cycle in ordered]
    sizes = [cycle.largest for cycle in ordered if cycle.hunts]
    assert len(sizes) >= 3 and sizes == sorted(sizes)
    assert all(cycle.settled for cycle in ordered)


def test_speeds_are_closed_in_at_which_cycles_count_and_break_the_limit(cycles):
    for passes, value, bound in (
        (MEASURES.counts, lambda cycle: cycle.largest, MEASURES.counted),
        (MEASURES.breaks, lambda cycle: cycle.sum_y_rms.max(), MEASURES.limit[0]),
    ):
        below, above = end_of(cycles, passes)
        assert 0.0 < above - below <= 2.0
        at = {cycle.speed: value(cycle) for cycle in cycles}
        assert at[below] < bound <= at[above]


def test_rms_of_a_cycle_is_that_of_an_assessment(hunting, cycles):
    """Sum Y of a run of its own, band-pass of 2 Hz on both sides of the dominant frequency, rms over 100 m."""
    cycle = max(cycles, key=lambda cycle: cycle.speed)
    system = on_straight(hunting, 1600.0, speed=cycle.speed)
    data = settled_start(system, 5e-3)
    assert advance(system.model, data, round(12.0 / system.model.param[0]["step"])) == 0
    rows = new_rows(system.model, 6000)
    record(system.model, data, rows, 2)
    place = rows.q[:, 0, 0]
    middles = np.arange(place[0] + 130.0, place[-1] - 130.0, 10.0)
    found = []
    for sum_y in rows.rail["y"].reshape(6000, -1, 2).sum(axis=2).T:
        peak = indices.dominant_frequency(sum_y, 1000.0)
        around = indices.filtered(sum_y, 1000.0, peak - 2.0, peak + 2.0)
        found.append(indices.sliding_rms(place, around, 100.0, middles).max())
    assert cycle.sum_y_rms == pytest.approx(found, rel=tol.CYCLE_RMS)


def swung_out(system, lateral, seconds):
    """Largest lateral displacement of each wheelset in the last second of a run."""
    data = settled_start(system, lateral)
    largest = np.zeros(len(system.wheelsets))
    for _ in range(round(seconds)):
        largest[:] = 0.0
        data.q[:, 0] -= data.q[0, 0]
        for _ in range(400):
            assert advance(system.model, data, 5) == 0
            np.maximum(largest, np.abs(data.q[list(system.wheelsets), 1]), out=largest)
    return largest


def test_limit_cycle_is_reached_from_inside_and_outside(hunting, cycles):
    """The ramp found it from above; a run that begins with half a millimetre grows into the same."""
    cycle = max(cycles, key=lambda cycle: cycle.speed)
    system = on_straight(hunting, 400.0, speed=cycle.speed)
    assert swung_out(system, 0.5e-3, 15.0) == pytest.approx(cycle.amplitude, rel=tol.SAME_CYCLE)


def test_where_hunting_ends_a_run_confirms_it(hunting, cycles):
    below, above = end_of(cycles)
    assert swung_out(on_straight(hunting, 400.0, speed=below - 5.0), 2e-3, 15.0).max() < 0.1e-3
    assert swung_out(on_straight(hunting, 400.0, speed=above + 5.0), 2e-3, 15.0).max() > 0.1e-3


def test_cycle_swings_as_the_mode_of_its_amplitude(cycles, profiles):
    """Frequency of the limit cycle against that of the hunting mode with quasi-linear contact of its mean amplitude."""
    cycle = max(cycles, key=lambda cycle: cycle.speed)
    case = load("stability").varied(contact=LAWS)
    lines = lines_of(case, *profiles, [float(cycle.amplitude.mean())])[0]
    found = modes(linearise(quasi_linear_system(case, lines), cycle.speed))
    k = next(k for k in range(found.value.size) if describe(found, k).words == "bogie hunting, bogies in phase")
    assert cycle.frequency == pytest.approx(found.frequency[k], rel=tol.CYCLE_FREQUENCY)


def test_no_hunting_is_one_row(hunting):
    (cycle,) = ramp(hunting, 30.0, 5.0, 10.0, 5e-3, 1.0)
    assert not cycle.hunts and cycle.settled
    below, above = end_of([cycle])
    assert below == 30.0 and np.isnan(above)


def test_ramp_stops_at_the_lowest_speed(hunting):
    found = list(ramp(hunting, 70.0, 5.0, 65.0, 5e-3, 1.0))
    assert [cycle.speed for cycle in found] == [70.0, 65.0] and all(cycle.hunts for cycle in found)
    below, above = end_of(found)
    assert np.isnan(below) and above == 65.0


def test_derailment_says_when_and_what_to_do(hunting):
    system = scenes.tuned(hunting, derail_lift=0.2e-3)
    with pytest.raises(SimulationError, match=r"at 90 m/s: .*derailed.*lower speed"):
        list(ramp(system, 90.0, 5.0, 80.0, 5e-3, 1.0))
