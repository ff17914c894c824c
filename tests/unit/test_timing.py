"""What is timed, and how times are summed up."""

from dataclasses import replace

import numpy as np
import pytest
import scenes

from railcli.analysis.simulate import settled_start
from railcli.errors import InputError
from railcli.files.scenario import load
from railcli.kernels.stages import Stage
from railcli.kernels.step import advance
from railcli.model.track import Curve, Straight, Track, Transition, pack
from railcli.report.timing import histogram, histogram_csv
from railcli.runtime import timing
from railcli.runtime.pacing import Metronome
from railcli.runtime.timing import Calls, describe_calls, percentiles, steps_per_call, stretch

SHORT = Track(
    (
        Straight(length=20.0),
        Transition(length=60.0),
        Curve(length=100.0, radius=1200.0, hand="right", cant=0.09),
    )
)


@pytest.fixture(scope="module")
def scenario():
    return load("curve-1200-45").varied(track=SHORT)


@pytest.fixture(scope="module")
def course(scenario, wagon):
    """Two steps a call in the short curve."""
    return timing.run_up(scenario, scenes.replaced(wagon, track=pack(SHORT)), steps=2)


def bits(data):
    return [array.tobytes() for array in data]


# Numbers


def test_percentiles_of_known_data():
    values = np.random.default_rng(1).permutation(np.arange(1, 10_001)) * 1000
    assert percentiles(values) == {"p50": 5000.0, "p95": 9500.0, "p99": 9900.0, "p999": 9990.0, "max": 10_000.0}


@pytest.mark.parametrize("count", [1, 2, 7, 999, 1000, 1001])
def test_percentile_is_the_smallest_value_that_enough_do_not_exceed(count):
    values = np.random.default_rng(count).integers(1, 50, count) * 1000
    found = percentiles(values)
    for name, share in timing.PER_MILLE.items():
        reaches = [value for value in sorted(values) if 1000 * (values <= value).sum() >= share * count]
        assert found[name] == reaches[0] / 1000


def test_calls_over_the_budget_are_counted():
    compute = np.array([10, 1000, 1001, 5000]) * 1000
    wake_up = np.array([989, 1, 0, 0]) * 1000
    found = describe_calls(Calls(np.zeros(4, int), compute, paced=False), 1e-3)
    assert (found["over_budget"], found["over_budget_share"], found["paced"]) == (2, 0.5, None)
    found = describe_calls(Calls(wake_up, compute, paced=True), 1e-3)
    assert found["over_budget"] == 2
    assert (found["paced"]["late"], found["paced"]["late_share"]) == (3, 0.75)


@pytest.mark.parametrize("budget, step, steps", [(1e-3, 0.5e-3, 2), (0.3e-3, 0.1e-3, 3), (2e-3, 2e-3, 1)])
def test_budget_in_steps(budget, step, steps):
    assert steps_per_call(budget, step) == steps


@pytest.mark.parametrize("budget, step", [(1e-3, 0.3e-3), (1e-3, 2e-3), (1e-3, 0.999e-3)])
def test_budget_that_is_no_multiple_of_the_step(budget, step):
    with pytest.raises(InputError, match="--budget: must be a multiple of the step"):
        steps_per_call(budget, step)


SAMPLES = [
    [np.array([5.0])],
    [np.array([0.0, 0.0, 1e-9, 3e6])],
    [np.array([10.0, 100.0, 1000.0]), np.array([0.04, 1e5, 100.0])],
    [np.random.default_rng(2).lognormal(3.0, 2.0, 5000)],
]


@pytest.mark.parametrize("samples", SAMPLES, ids=range(len(SAMPLES)))
def test_histogram_counts_every_value_once(samples):
    edges, counts = histogram(*samples)
    assert (np.diff(edges) > 0.0).all()
    for values, count in zip(samples, counts, strict=True):
        assert count.sum() == values.size
        k = edges.size // 2
        assert count[:k].sum() == (values < edges[k]).sum()


def test_histogram_as_csv():
    lines = histogram_csv({"call": np.array([1.0, 1.0, 20.0]), "wake_up": np.array([3.0, 3.0, 3.0])}).splitlines()
    assert lines[0] == "from_us,to_us,call,wake_up"
    table = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    assert table[:, 2:].sum(axis=0).tolist() == [3.0, 3.0]
    assert np.array_equal(table[1:, 0], table[:-1, 1])
    filled = table[table[:, 2] == 2.0][0]
    assert filled[0] <= 1.0 < filled[1]


# What is timed


def test_stretch_begins_where_the_last_body_enters_the_curve(scenario):
    rest = np.zeros((3, 6))
    rest[:, 0] = 0.0, 8.0, -9.0
    assert stretch(scenario, rest) == (80.0 + 9.0, 180.0)
    rest[:, 0] *= 10.0
    assert stretch(scenario, rest) == (80.0 + 50.0, 180.0)  # vehicle longer than half the curve


def test_stretch_ends_with_the_run(scenario):
    rest = np.zeros((1, 6))
    assert stretch(scenario.varied(run={"distance": 150.0}), rest) == (80.0, 150.0)
    assert stretch(scenario.varied(run={"distance": 70.0}), rest) == (20.0, 70.0)  # the curve is not reached
    assert stretch(load("straight-60"), rest) == (0.0, 600.0)


def test_stretch_is_the_longest_curve():
    curve = {"radius": 800.0, "hand": "left"}
    track = Track(
        (
            Straight(length=500.0),
            Transition(length=50.0),
            Curve(length=80.0, **curve),
            Transition(length=50.0),
            Straight(length=100.0),
            Transition(length=50.0),
            Curve(length=60.0, **curve),
        )
    )
    assert stretch(load("straight-60").varied(track=track), np.zeros((1, 6))) == (550.0, 630.0)


def test_every_wheel_is_loaded_in_the_curve_where_timing_begins(course):
    assert course.kept.q[:, 0].min() >= 80.0 - 1e-3
    assert (course.patches >= 1).all()
    assert course.patches.sum() > course.patches.size  # some wheel has two contacts


def test_run_up_is_the_run_itself(course):
    data = settled_start(course.system)
    steps = round(course.kept.clock[0] / course.step)
    assert advance(course.system.model, data, steps) == 0
    assert bits(data) == bits(course.kept)


def test_stretch_shorter_than_a_call(scenario, wagon):
    with pytest.raises(InputError, match="--budget: is longer than the part of curve-1200-45 that is timed"):
        timing.run_up(scenario, wagon, steps=4000)


@pytest.mark.parametrize("metronome", [None, Metronome(1)], ids=["back to back", "paced"])
def test_going_back_gives_the_same_states_bit_for_bit(course, metronome):
    lap = replace(course, calls=40)
    kept = bits(lap.kept)
    timing.time_calls(lap, 40, metronome)
    once = bits(lap.data)
    calls = timing.time_calls(lap, 120, metronome)
    assert bits(lap.data) == once != kept
    timing.time_calls(lap, 15, metronome)
    assert bits(lap.data) != once
    assert bits(lap.kept) == kept
    lap.rewind()
    assert advance(lap.system.model, lap.data, 80) == 0
    assert bits(lap.data) == once
    assert calls.compute.size == 120 and (calls.compute > 0).all()
    assert (calls.wake_up > 0).all() == calls.paced


def test_every_measurement_begins_from_the_kept_state(course):
    kept = bits(course.kept)
    timing.describe_cost(course)
    assert bits(course.kept) == kept
    course.rewind()
    assert bits(course.data) == kept


def test_cost_of_every_stage_is_found(course):
    found = timing.describe_cost(course)
    assert list(found["stages_us"]) == [stage.name.lower() for stage in Stage if stage != Stage.STEP]
    for key, median in found["stages_us"].items():
        assert 0.0 < found["stages_min_us"][key] <= median
    low, high = found["real_time_factor_range"]
    assert low <= found["real_time_factor"] <= high


def test_batches_grow_until_a_coarse_clock_sees_them(course, monkeypatch):
    batches, clock = [], {"now": 0}

    def coarse():
        return clock["now"] // 16 * 16

    def counted(model, data, steps):
        batches.append(steps)
        clock["now"] += 5
        return 0

    monkeypatch.setattr(timing.time, "thread_time_ns", coarse)
    monkeypatch.setattr(timing, "tick", lambda clock: 16)
    monkeypatch.setattr(timing.step.advance, "_compiled", counted)
    factors, batch = timing.real_time_factors(course)
    assert len(factors) == timing.BATCHES
    truth = batch / 5e-9
    assert np.mean(factors) == pytest.approx(truth, rel=1.0 / timing.TICKS)
