"""The steady motion in which a run ends, by Newton's method, without the run."""

from railcli.analysis import steady_values
from railcli.errors import InputError
from railcli.report.run import sides_of, steady_json, steady_motion_text

from .answer import Answer
from .run import prepare
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
    prepared = prepare(scenario, voice)
    values = steady_values.motion(prepared.system, stretch, scenario.final_speed)
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
