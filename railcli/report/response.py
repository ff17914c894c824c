"""Frequency response to displaced rails: CSV and picture."""

import numpy as np

from railcli.analysis.faults import wheel_name
from railcli.analysis.mode_shapes import groups
from railcli.analysis.response import carried

from .figures import SERIES, draw
from .text import speed

DIRECTIONS = (("lateral", "y"), ("vertical", "z"))


def channels(linear, answer):
    """Complex gain over frequency by name: what a column of the CSV holds."""
    system = linear.system
    found = {}
    for axis, (direction, _) in enumerate(DIRECTIONS):
        for i, name in enumerate(system.bodies):
            found[f"{name} {direction} acceleration [1/s^2]"] = answer.acceleration[:, i, axis]
        for k, (body, below) in enumerate(carried(system.model)):
            name = f"{system.bodies[body]} over {system.bodies[below]}"
            found[f"{name} {direction} acceleration [1/s^2]"] = answer.over_bogies[:, k, axis]
    for w in range(system.model.wheel.size):
        for axis, force in enumerate("YQ"):
            found[f"{wheel_name(system, w)} {force} [N/m]"] = answer.wheel[:, w, axis]
    return found


def response_csv(linear, answers):
    """Gain and phase of every channel for every input, one row for each."""
    rows = ["input,frequency_hz,channel,gain,phase_deg"]
    for kind, answer in answers.items():
        for name, gain in channels(linear, answer).items():
            rows += [
                f'{kind},{frequency:.6g},"{name}",{abs(value):.6g},{np.degrees(np.angle(value)):.4f}'
                for frequency, value in zip(answer.frequency, gain, strict=True)
            ]
    return "\n".join(rows) + "\n"


def figures(scenario, linear, answers, folder):
    """Draw accelerations of the first car body and bogie, and forces of the first wheel; returns names of files."""
    draw(lambda figure: _panels(figure, scenario, linear, answers), folder / "response.png", (10.0, 6.4))
    return ["response.png"]


def _panels(figure, scenario, linear, answers):
    axes = figure.subplots(2, 2, sharex=True)
    for column, (kind, axis, force) in enumerate((("vertical", 1, "Q"), ("lateral", 0, "Y"))):
        answer = answers[kind]
        top, bottom = axes[:, column]
        for color, (label, gain) in zip(SERIES, _accelerations(linear, answer, axis).items(), strict=False):
            top.loglog(answer.frequency, 1e-3 * np.abs(gain), color=color, label=label)
        top.set_title(f"{kind} displacement of both rails, {speed(linear.speed)}")
        top.set_ylabel(f"{kind} acceleration\n[m/s² per mm]")
        top.legend()
        w = 0
        bottom.loglog(answer.frequency, 1e-6 * np.abs(answer.wheel[:, w, axis]), color=SERIES[0],
                      label=f"{force} of {wheel_name(linear.system, w)}")  # fmt: skip
        bottom.set_ylabel(f"{force} [kN per mm]")
        bottom.set_xlabel("frequency [Hz]")
        bottom.legend()
    figure.suptitle(f"{scenario.name}: response of the linear model to its rails", fontsize=10)


def _accelerations(linear, answer, axis):
    """Accelerations worth a line: the car body's centre, over what carries it, and the first bogie or else wheelset."""
    system = linear.system
    of = groups(system.model)
    found = {}
    for i, name in enumerate(system.bodies):
        if of[i] == "car body":
            found[f"{name}, centre"] = answer.acceleration[:, i, axis]
    for k, (body, below) in enumerate(carried(system.model)):
        found[f"{system.bodies[body]} over {system.bodies[below]}"] = answer.over_bogies[:, k, axis]
    for i in [*np.flatnonzero(of == "bogie"), *system.wheelsets][:1]:
        found[system.bodies[i]] = answer.acceleration[:, i, axis]
    return found
