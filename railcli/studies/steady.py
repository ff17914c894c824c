"""The steady motion in which a run ends, by Newton's method, without the run."""

from railcli.analysis import steady_values
from railcli.analysis.step_choice import with_step
from railcli.analysis.warm import warm
from railcli.errors import InputError, SimulationError
from railcli.model.system import assemble
from railcli.report.run import sides_of, steady_json, steady_motion_text

from .answer import Answer
from .tables import tables_for
from .voice import SILENT


def steady(scenario, voice=SILENT):
    """The steady motion of a scenario in the straight or curve in which its run ends.

    Parameters
    ----------
    scenario : Scenario
    voice : Voice

    Returns
    -------
    Answer
        Values as ``steady.newton`` of a run's summary: lateral places count towards the outer rail.

    Raises
    ------
    InputError
        The run does not end in one straight or curve at one speed, or the vehicle stands there.
    SimulationError
        Newton's method finds no steady motion.
    """
    stretch = steady_values.final_stretch(scenario)
    if stretch is None or scenario.final_speed == 0.0:
        raise InputError(
            scenario.name,
            f"the last {scenario.average_over:g} m (run.average_over_m) are not one straight or curve at one speed, "
            "where a motion could be steady",
        )
    warm(voice.announce)
    values = motion_of(scenario, assemble(scenario, tables_for(scenario, voice)), stretch)
    lateral, vertical = steady_values.expected_forces(scenario, stretch)
    record = {
        "scenario": scenario.name,
        "speed_m_per_s": scenario.final_speed,
        "stretch": stretch.kind,
        "wheels": list(sides_of(stretch)),
        **steady_json(values),
        "expected_Y_kN": lateral * 1e-3,
        "expected_Q_kN": vertical * 1e-3,
        "without_dry_friction": scenario.vehicle.is_dry,
    }
    return Answer(record, steady_motion_text(scenario, stretch, values))


def motion_of(scenario, system, stretch):
    """The steady motion of a scenario that is assembled; SteadyValues.

    Newton's method needs no time step: one is settled only where a short run has to find its first guess.
    """
    try:
        return steady_values.motion(system, stretch, scenario.final_speed)
    except SimulationError:
        return steady_values.motion(with_step(scenario, system).system, stretch, scenario.final_speed)
