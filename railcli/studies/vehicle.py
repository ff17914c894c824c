"""A vehicle before it runs: what it weighs, what its springs carry, how it swings, how it stands."""

from pathlib import Path

import numpy as np

from railcli.analysis.linear import linearise
from railcli.analysis.linear import modes as modes_of
from railcli.analysis.mode_shapes import describe
from railcli.analysis.quasi_linear import quasi_linear_system
from railcli.analysis.warm import warm
from railcli.errors import InputError, RailcliError
from railcli.files.scenario import load
from railcli.model.vehicle import STANDARD_GRAVITY, carried, static_wheel_loads

from .answer import Answer
from .modes import quasi_linear_contact
from .voice import SILENT

UNDER = "straight-60"  # scenario whose track and profiles it is shown on
SPEED, AMPLITUDE_MM = 20.0, 3.0  # at which it swings there [m/s], [mm]


def show(vehicle, picture=None, swings=True, voice=SILENT):
    """Masses, axle loads, centre of gravity, preloads, suspension frequencies, and a drawing.

    Parameters
    ----------
    vehicle : Vehicle
    picture : pathlib.Path, optional
        Where to draw it from the side, above and behind.
    swings : bool
        Find its eigenmodes, by the compiled model on the track of UNDER.
    voice : Voice

    Returns
    -------
    Answer
    """
    from railcli.report import vehicle_facts as report

    scenario = load(UNDER)
    tape_circle = scenario.contact.tape_circle
    loads = static_wheel_loads(vehicle, STANDARD_GRAVITY, tape_circle)
    preloads = carried(vehicle, STANDARD_GRAVITY)
    modes, absent = _modes(scenario, vehicle, voice) if swings else ([], "not asked for")
    record = {**report.as_json(vehicle, loads, preloads, STANDARD_GRAVITY), "modes": modes}
    record["conditions"] = {"speed_m_per_s": SPEED, "amplitude_mm": AMPLITUDE_MM, "no_modes": absent}
    lines = report.lines(vehicle, loads, preloads, STANDARD_GRAVITY) + report.mode_lines(modes, absent, SPEED)
    if picture:
        _draw(vehicle, tape_circle, picture)
        record["figure"] = picture
        lines.append(f"Figure: {picture}")
    return Answer(record, lines)


def _modes(scenario, vehicle, voice):
    """Modes that swing by less than 50 Hz and are not dead, by frequency; and why there are none."""
    from railcli.report.modes import usual

    try:
        case = scenario.varied(vehicle=vehicle, run={"speed": SPEED})
        warm(voice.announce)
        system = quasi_linear_system(case, quasi_linear_contact(case, [AMPLITUDE_MM], voice)[0])
        found = modes_of(linearise(system))
    except (RailcliError, ValueError) as error:
        return [], str(error)
    shown = sorted(usual(found), key=lambda k: found.frequency[k])
    return [
        {
            "frequency_hz": float(found.frequency[k]),
            "damping_ratio": float(found.damping[k]),
            "shape": describe(found, k).words,
        }
        for k in np.asarray(shown, int)
    ], ""


def _draw(vehicle, tape_circle, picture):
    from railcli.report.figures import draw
    from railcli.report.vehicle_figure import figure

    draw(lambda canvas: figure(canvas, vehicle, tape_circle), picture, (10.0, 5.6))


def copied(kind, name, path):
    """Write the file of a built-in vehicle or scenario to a place of the user's.

    Parameters
    ----------
    kind : {"vehicle", "scenario"}
    name : str
    path : pathlib.Path
        That files.output.output_file allowed.

    Raises
    ------
    InputError
        There is none of this name, or the place is no TOML file.
    """
    from railcli.files.output import write_text
    from railcli.files.scenario import builtin_text

    if Path(path).suffix.lower() != ".toml":
        raise InputError(path, "scenarios and vehicles are TOML files; end its name with .toml")
    write_text(path, builtin_text(kind, name))
