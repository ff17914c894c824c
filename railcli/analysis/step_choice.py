"""Which time step a run takes: the longest usual one that its model bears, or the given one if the model bears that."""

import math
from typing import NamedTuple

from railcli.errors import InputError
from railcli.model.scenario import divides
from railcli.model.subsystems import is_multiple, period

from .step_limit import CEILING, MARGIN, StepLimit, step_limit

USUAL = 1e-3  # longest step that is chosen; then its halves [s]


class Stepped(NamedTuple):
    """A scenario and its system with the step that the run takes."""

    scenario: object
    system: object
    choice: "StepChoice"


class StepChoice(NamedTuple):
    """The step of a run [s], whether it was chosen or given, and what the model bears."""

    step: float
    chosen: bool
    limit: StepLimit


def with_step(scenario, system, speeds=(), interval=None, limit=None):
    """Settle the time step of a run.

    Parameters
    ----------
    scenario : Scenario
    system : System
        The scenario assembled.
    speeds : sequence of float
        Lowest and highest speed of the run [m/s]; those of the scenario when there are none.
    interval : float, optional
        What has to be a whole number of chosen steps [s]; the output interval when absent.
    limit : StepLimit, optional
        Of the model, where it is known.

    Returns
    -------
    Stepped

    Raises
    ------
    InputError
        The given step is longer than the model bears.
    """
    limit = limit or step_limit(system, speeds or speeds_of(scenario))
    given = scenario.run.step
    if given is not None:
        if given > limit.allowed:
            raise InputError("run.step_ms", _too_long(given, limit))
        return Stepped(scenario, system, StepChoice(given, False, limit))
    interval = scenario.run.output_interval if interval is None else interval
    step = longest_usual(limit.allowed, interval)
    every = period(scenario)
    if every is not None and not is_multiple(every, step):
        raise InputError(
            "speed_sensor.period_ms", f"must be a whole number of steps, which are {step * 1e3:g} ms for this vehicle, "
            f"got {every * 1e3:g} ms"
        )  # fmt: skip
    own = {"step": step} if divides(step, scenario.run.output_interval) else {"step": step, "output_interval": interval}
    return Stepped(scenario.varied(run=own), system.stepped(step), StepChoice(step, True, limit))


def speeds_of(scenario):
    """Lowest and highest speed of a run whose speed changes [m/s]; none of one at a constant speed."""
    if scenario.is_free:
        return 0.0, scenario.run.speed
    course = scenario.run.course
    return () if course is None else (min(course.speed), max(course.speed))


def longest_usual(allowed, interval):
    """The longest of 1, 0.5, 0.25 ... ms within `allowed` that divides an interval; both [s].

    An interval of which neither that nor its half is a whole part is divided into the fewest steps that are allowed.
    """
    step = USUAL * 0.5 ** max(0, math.ceil(math.log2(USUAL / allowed) - 1e-12))
    for usual in (step, 0.5 * step):
        if divides(usual, interval):
            return usual
    return interval / math.ceil(interval / step)


def milliseconds(step):
    """A step limit [s] as a number of ms that may be given back as a step: three digits, rounded down."""
    digits = 2 - math.floor(math.log10(step * 1e3))
    return math.floor(step * 1e3 * 10**digits + 1e-9) / 10**digits


def bound(limit):
    """The longest step that a model bears, in words."""
    stable = f"stable {'at' if limit.stable >= CEILING else 'up to'} {milliseconds(limit.stable):g} ms"
    return f"at most {milliseconds(limit.allowed):g} ms ({stable}, over a margin of {MARGIN:g})"


def _too_long(given, limit):
    usual = longest_usual(limit.allowed, USUAL)
    return (
        f"{given * 1e3:g} ms is too long for this vehicle: {bound(limit)}, limited by {limit.limited_by}; give less, "
        f"or leave step_ms out for {usual * 1e3:.4g} ms"
    )
