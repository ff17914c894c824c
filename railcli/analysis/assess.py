"""Assessment of a run: every figure that its recorded channels give, against its limit.

The forces of a wheelset belong to its own place on the track. Signals are read, filtered and judged block by block, so
that the length of a run needs no memory.
"""

from railcli.errors import InputError
from railcli.model.assessment import FIGURES, Limits
from railcli.model.vehicle import static_wheel_loads

from . import indices
from .assessment.forces import assess_forces
from .assessment.ride import assess_ride
from .assessment.run import Run
from .assessment.sections import SHORTEST, sections
from .assessment.values import Assessment, Tally
from .assessment.wear import assess_wear


def assess(results, limits=None, fault=None, progress=None):
    """Form every figure that a run gives, and judge it.

    Parameters
    ----------
    results : files.read_results.Results
    limits : Limits, optional
    fault : str, optional
        What broke the run off, empty when it reached its end; by default what the results say.
    progress : callable, optional
        Called with the share that is done.

    Returns
    -------
    Assessment

    Raises
    ------
    InputError
        The speed of the run changes: every figure and limit belongs to one speed.
    """
    course = results.scenario.run.course
    if course is not None and len(set(course.speed)) > 1:
        raise InputError(
            "assessment", "the speed of the run changes, and figures and limits belong to one speed: run at each "
            "speed, or read the channels themselves (`railcli export`, `railcli report`)"
        )  # fmt: skip
    limits = limits or Limits()
    fault = results.fault if fault is None else fault
    run = Run(results, limits, broken=bool(fault))
    start, end = run.stretch()
    contact, vehicle = run.scenario.contact, run.scenario.vehicle
    static = static_wheel_loads(vehicle, run.scenario.run.gravity, contact.tape_circle)
    friction = contact.friction if limits.friction is None else limits.friction
    outcome = Assessment(fault=fault)
    outcome.sections = sections(run.scenario.track, start, end, run.speed, limits.section_length)
    outcome.conditions = {
        "from_m": start,
        "to_m": end,
        "run_in_s": limits.run_in,
        "run_out_s": 0.0 if fault else limits.run_out,
        "speed_m_per_s": run.speed,
        "recorded_Hz": run.rate,
        "flange_angle_rad": limits.flange_angle,
        "friction": friction,
    }
    if not run.filtered:
        outcome.warnings.append(
            f"These results hold rows only, {run.rate:g} in a second: what is faster folds into the figures. Run again "
            "for figures that do not depend on the output interval."
        )
    tally = Tally(len(outcome.sections), limits.warn_share)
    if outcome.sections:
        nadal = indices.nadal(limits.flange_angle, friction)
        assess_forces(run, outcome, tally, static, nadal, progress)
        assess_ride(run, outcome, tally)
        assess_wear(run, outcome, tally)
        short = sum(section.short for section in outcome.sections)
        if short:
            outcome.warnings.append(
                f"{short} of {len(outcome.sections)} sections are shorter than EN 14363 asks for (k)."
            )
    else:
        tally.missing(
            FIGURES,
            f"less than {SHORTEST:g} m of one straight, curve or transition that every wheelset ran over between the "
            f"first {limits.run_in:g} and the last {limits.run_out:g} s",
        )
    outcome.values, outcome.by_section = tally.values(), tally.by_section
    return outcome
