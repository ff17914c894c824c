"""Measuring the compiled model: wall time of each call, processor time of batches, cost of each stage."""

import math
import os
import statistics
import time
from dataclasses import dataclass

import numpy as np

from railcli.analysis.faults import sentence
from railcli.analysis.simulate import start_of_run
from railcli.analysis.warm import warm
from railcli.errors import InputError, SimulationError
from railcli.kernels import step
from railcli.kernels.layout import Data
from railcli.kernels.stages import Stage, repeat
from railcli.model.system import System

from .pacing import undisturbed

PER_MILLE = {"p50": 500, "p95": 950, "p99": 990, "p999": 999, "max": 1000}
RUN_UP_STEPS = 200  # between two returns to Python
BATCHES = 20
BATCH = 1000  # steps of a batch
TICKS = 20  # of the processor clock that a batch lasts at least
ROUNDS = 25  # of all stages, in turn
PASSES = 20_000_000  # wall time over which a stage is repeated [ns], over ROUNDS
OVERHEAD_CALLS = 500


@dataclass(frozen=True)
class Course:
    """What is timed: calls that lead from a kept state to the end of a stretch, and from there back to it.

    Attributes
    ----------
    name : str
        Of the scenario.
    system : System
    kept, data : Data
        The state to which `rewind` goes back; the one that moves.
    steps : int
        Per call.
    calls : int
        From the kept state to the end of the stretch.
    """

    name: str
    system: System
    kept: Data
    data: Data
    steps: int
    calls: int

    @property
    def step(self):
        """[s]"""
        return float(self.system.model.param[0]["step"])

    @property
    def period(self):
        """Simulated time of a call [s]."""
        return self.steps * self.step

    @property
    def patches(self):
        """Loaded contact patches of each wheel in the kept state."""
        return self.kept.rail["patches"].astype(int)

    def rewind(self):
        """Go back to the kept state, bit for bit."""
        for array, kept in zip(self.data, self.kept, strict=True):
            array[...] = kept

    def check(self, status):
        """Raise a SimulationError when a call of the core did not succeed."""
        if status != 0:
            raise SimulationError(f"{self.name}: {sentence(self.system, self.data, status)}")


@dataclass(frozen=True)
class Calls:
    """Timed calls in their order [ns]: how late each began (zero when back to back), how long it took."""

    wake_up: np.ndarray
    compute: np.ndarray
    paced: bool

    @property
    def response(self):
        """From the beginning of the period to the end of the call."""
        return self.wake_up + self.compute


def prepare(announce=None):
    """Make all that is timed ready, as `warm`; the stages take some two seconds more when the core is compiled."""
    warm(announce)
    repeat.compiled()


def steps_per_call(budget, step_size):
    """How many steps make one budget; both [s]."""
    steps = round(budget / step_size)
    if steps < 1 or not math.isclose(steps * step_size, budget, rel_tol=1e-9):
        raise InputError(
            "--budget",
            f"must be a multiple of the step, got {budget * 1e3:g} ms with a step of {step_size * 1e3:g} ms; "
            "change --budget or --step",
        )
    return steps


def stretch(scenario, rest):
    """Where the timed calls begin and end: arc lengths of the first body [m].

    From where the whole vehicle stands in the longest curve of the run (in the longest section, when it has no curve),
    but at most from its middle, to its end.

    Parameters
    ----------
    scenario : Scenario
    rest : array (n_body, 6)
        Coordinates at rest, s relative to the first body.
    """
    sections, start = [], 0.0
    for section in scenario.track.sections:
        length = min(section.length, scenario.distance - start)
        if length > 0.0:
            sections.append((section.kind == "curve", length, start))
        start += section.length
    _, length, start = max(sections)
    return start + min(-rest[:, 0].min(), 0.5 * length), start + length


def run_up(scenario, system, steps, progress=None):
    """Run from the beginning of a scenario until its stretch begins.

    Parameters
    ----------
    scenario : Scenario
    system : System
    steps : int
        Per timed call.
    progress : callable, optional
        Called with the arc length reached [m].

    Returns
    -------
    Course
    """
    begin, end = stretch(scenario, system.rest)
    data = start_of_run(scenario, system)
    course = Course(scenario.name, system, data, data, steps, 0)
    length = system.speed * course.step
    left = max(1, math.ceil(begin / length))
    while left > 0:
        count = min(left, RUN_UP_STEPS)
        course.check(step.advance(system.model, data, count))
        left -= count
        if progress:
            progress(float(data.q[0, 0]))
    calls = math.floor((end - float(data.q[0, 0])) / (steps * length))
    if calls < 1:
        raise InputError(
            "--budget",
            f"is longer than the part of {scenario.name} that is timed, which lasts "
            f"{(end - begin) / system.speed * 1e3:.4g} ms; give a smaller one or a longer scenario",
        )
    return Course(scenario.name, system, Data(*(array.copy() for array in data)), data, steps, calls)


def time_calls(course, count, metronome=None, progress=None):
    """Wall time of each of `count` calls from the kept state on, with a rewind at each end of the stretch.

    Parameters
    ----------
    course : Course
    count : int
    metronome : Metronome, optional
        Begins each call; without one they follow back to back.
    progress : callable, optional
        Called with the calls made, between two rewinds of calls back to back.

    Returns
    -------
    Calls
    """
    model, data, steps = course.system.model, course.data, course.steps
    advance, clock = step.advance.compiled(), time.perf_counter_ns
    wake_up, compute = np.full(count, 0), np.full(count, 0)
    with undisturbed():
        if metronome:
            metronome.start()
        for first in range(0, count, course.calls):
            course.rewind()
            for i in range(first, min(first + course.calls, count)):
                if metronome:
                    due, began = metronome.wait()
                    wake_up[i] = began - due
                else:
                    began = clock()
                status = advance(model, data, steps)
                compute[i] = clock() - began
                if status != 0:
                    course.check(status)
            if progress and not metronome:
                progress(i + 1)
    return Calls(wake_up, compute, metronome is not None)


def percentiles(nanoseconds):
    """Percentiles [us]: the smallest measured value that so many of the values do not exceed."""
    ordered, n = np.sort(nanoseconds), len(nanoseconds)
    return {name: float(ordered[-(-n * share // 1000) - 1]) / 1e3 for name, share in PER_MILLE.items()}


def real_time_factors(course):
    """Simulated time over processor time of this thread, for each of BATCHES calls of many steps, after one to warm up.

    Returns
    -------
    factors : list of float
    batch : float
        Simulated time of a batch [s].
    """
    steps = min(course.calls * course.steps, BATCH)
    advance, clock = step.advance.compiled(), time.thread_time_ns
    enough = TICKS * tick(clock)
    batch, factors = steps * course.step, []
    with undisturbed():
        for _ in range(1 + BATCHES):
            cpu, simulated = 0, 0.0
            while cpu < enough:
                course.rewind()
                began = clock()
                status = advance(course.system.model, course.data, steps)
                cpu += clock() - began
                course.check(status)
                simulated += batch
            factors.append(simulated / (cpu * 1e-9))
    return factors[1:], batch


def stage_costs(course):
    """Wall time of one pass of each stage, repeated from the kept state.

    Returns
    -------
    dict of Stage to tuple
        Median and minimum over ROUNDS [us].
    """

    def lasts(stage, times):
        course.rewind()
        course.check(run(model, data, stage, 2))
        began = time.perf_counter_ns()
        status = run(model, data, stage, times)
        ended = time.perf_counter_ns()
        course.check(status)
        return ended - began

    model, data, run = course.system.model, course.data, repeat.compiled()
    most = {stage: 10**6 for stage in Stage}
    most[Stage.STEP] = max(1, course.calls * course.steps - 2)
    times, found = {}, {stage: [] for stage in Stage}
    with undisturbed():
        for stage in Stage:
            count = min(64, most[stage])
            count = math.ceil(count * PASSES / ROUNDS / max(1, lasts(stage, count)))
            times[stage] = min(max(count, 1), most[stage])
        for _ in range(ROUNDS):
            for stage in Stage:
                found[stage].append(lasts(stage, times[stage]) / times[stage] / 1e3)
    return {stage: (statistics.median(values), min(values)) for stage, values in found.items()}


def call_overhead(course):
    """Wall time of a call of no steps: from Python into compiled code and back; median [us]."""
    model, data, advance = course.system.model, course.data, step.advance.compiled()
    found = []
    with undisturbed():
        for _ in range(ROUNDS):
            began = time.perf_counter_ns()
            for _ in range(OVERHEAD_CALLS):
                advance(model, data, 0)
            found.append((time.perf_counter_ns() - began) / OVERHEAD_CALLS / 1e3)
    return statistics.median(found)


def describe_calls(calls, period):
    """Percentiles of timed calls [us] and how many took longer than a period [s], ready for JSON."""
    count, limit = calls.compute.size, round(period * 1e9)
    over = int((calls.compute > limit).sum())
    found = {
        "calls": count,
        "step_us": percentiles(calls.compute),
        "over_budget": over,
        "over_budget_share": over / count,
        "paced": None,
    }
    if calls.paced:
        late = int((calls.response > limit).sum())
        found["paced"] = {
            "wake_up_us": percentiles(calls.wake_up),
            "response_us": percentiles(calls.response),
            "late": late,
            "late_share": late / count,
        }
    return found


def describe_cost(course):
    """Real-time factor, cost of the stages and of a call, measured now, ready for JSON."""
    factors, batch = real_time_factors(course)
    costs = stage_costs(course)
    whole = costs.pop(Stage.STEP)
    return {
        "real_time_factor": statistics.median(factors),
        "real_time_factor_range": [min(factors), max(factors)],
        "batches": len(factors),
        "batch_s": batch,
        "stages_us": {stage.name.lower(): median for stage, (median, _) in costs.items()},
        "stages_min_us": {stage.name.lower(): least for stage, (_, least) in costs.items()},
        "whole_step_us": {"median": whole[0], "min": whole[1]},
        "call_overhead_us": call_overhead(course),
    }


def describe_course(course, count):
    """What `count` calls of a course ran over, ready for JSON."""
    return {
        "step_ms": course.step * 1e3,
        "budget_ms": course.period * 1e3,
        "steps_per_call": course.steps,
        "kept_state": {
            "time_s": float(course.kept.clock[0]),
            "distance_m": float(course.kept.q[0, 0]),
            "patches": course.patches.tolist(),
        },
        "lap_s": course.calls * course.period,
        "rewinds": (count - 1) // course.calls,
    }


def tick(clock):
    """Smallest step seen between readings of a clock, in its unit."""

    def change():
        first = clock()
        while (now := clock()) == first:
            pass
        return now - first

    return min(change() for _ in range(TICKS))


def clocks():
    """The clocks in use: name for readers and the smallest step seen [ns]."""
    return {
        name: {
            "clock": time.get_clock_info(name).implementation,
            "resolution_ns": time.get_clock_info(name).resolution * 1e9,
            "smallest_step_seen_ns": tick(function),
        }
        for name, function in (("perf_counter", time.perf_counter_ns), ("thread_time", time.thread_time_ns))
    }


def occupation():
    """Processors that this process may use, and the system's load average where it has one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {"cores": cores, "load_average": list(os.getloadavg()) if hasattr(os, "getloadavg") else None}
