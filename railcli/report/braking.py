"""A run with subsystems for people: how it stopped, what each axle did, where the energy went."""

import h5py
import numpy as np

from railcli.analysis.ledger import GAINS, LOSSES, ledger
from railcli.files.results import AXLE_CHANNELS, TIME_SERIES

from .figures import GREY, SERIES, draw
from .text import columns, speed

FIGURES = ("braking", "energy")
UNBOOKED = 1e-3  # share of the energy that may be unbooked without a warning


def lines(scenario, system, outcome):
    """Lines for the terminal, of a run that has subsystems."""
    found = ledger(system, outcome.first, outcome.last)
    port, train = outcome.last.port, outcome.last.train[0]
    text = [""]
    if scenario.is_free:
        text.append(_end(scenario, outcome, train))
    text += columns(
        [("", "%", "s", "kJ", "", "l", "bar"), *_axle_rows(port)],
        ("axle", "largest slide", "locked", "flat-spot work", "vents", "air used", "pressure left"),
    )
    if scenario.odometry:
        off = float(train["odometer"]) - float(outcome.last.q[0, 0] - outcome.first.q[0, 0])
        text.append(
            f"  Odometry ({scenario.odometry.kind}): {off:+.2f} m off at the end; at most "
            f"{100 * train['odometer_cone']:.0f} % of 5 m + 5 % on the way"
        )
    text += ["", "Energy", *_energy_lines(found)]
    if abs(found.share) > UNBOOKED:
        text.append(
            f"  Warning: {100 * abs(found.share):.2g} % of the energy is not accounted for: a shorter step_ms books it "
            "more closely."
        )
    return text


def _end(scenario, outcome, train):
    start = speed(scenario.first_speed)
    if train["stop_time"] >= 0.0:
        where = f"{train['stop_place']:.1f} m, {train['stop_time']:.2f} s"
        if scenario.driver.kind == "line":
            return f"Stands at the end of the line, at {where}"
        mean = scenario.first_speed**2 / (2.0 * train["stop_place"])
        return f"Stopped from {start} after {where} (mean deceleration {mean:.3f} m/s^2)"
    return f"Ran from {start} to {speed(float(outcome.last.v[0, 0]))} over {outcome.distance:.1f} m"


def _axle_rows(port):
    for a, one in enumerate(port, start=1):
        yield (
            f"W{a}", f"{100 * one['largest_slide']:.2f}", f"{one['locked']:.2f}", f"{1e-3 * one['flat_work']:.1f}",
            f"{one['vents']}", f"{1e3 * one['air']:.0f}", f"{1e-5 * one['pressure']:.2f}",
        )  # fmt: skip


def _energy_lines(found):
    rows = [("kinetic at the start", found.start), *((GAINS[key], value) for key, value in found.gains.items())]
    rows += [(words, -found.losses[key]) for key, words in LOSSES.items()]
    rows += [("kinetic at the end", -found.end), ("not accounted for", found.unbooked)]
    shown = [(name, f"{1e-6 * value:+.4f}", f"{100 * value / found.whole:+.3f}") for name, value in rows if value]
    return columns([("", "MJ", "%"), *shown], ("", "energy", "share"))


def as_json(scenario, system, outcome):
    """What summary.json holds of it."""
    found = ledger(system, outcome.first, outcome.last)
    port, train = outcome.last.port, outcome.last.train[0]
    stopped = train["stop_time"] >= 0.0
    return {
        "stopped": bool(stopped),
        "stop_distance_m": float(train["stop_place"]) if stopped else None,
        "stop_time_s": float(train["stop_time"]) if stopped else None,
        "final_speed_m_per_s": float(outcome.last.v[0, 0]),
        "odometer_off_m": float(train["odometer"] - (outcome.last.q[0, 0] - outcome.first.q[0, 0]))
        if scenario.odometry else None,
        "odometer_largest_share_of_cone": float(train["odometer_cone"]) if scenario.odometry else None,
        "axles": [
            {
                "largest_slide": float(one["largest_slide"]),
                "locked_s": float(one["locked"]),
                "flat_spot_work_J": float(one["flat_work"]),
                "vents": int(one["vents"]),
                "air_m3": float(one["air"]),
                "pressure_Pa": float(one["pressure"]),
            }
            for one in port
        ],
        "energy_J": {
            "kinetic_start": found.start,
            **found.gains,
            **{key: -value for key, value in found.losses.items()},
            "kinetic_end": -found.end,
            "unbooked": found.unbooked,
        },
        "unbooked_share": found.share,
    }  # fmt: skip


def figures(scenario, outcome, system, folder):
    """Draw speeds, slide, pressures and adhesion over time, and the energies; names of the files."""
    first = ledger(system, outcome.first, outcome.last).start
    with h5py.File(folder / TIME_SERIES, "r", locking=False) as file:
        over_time(scenario, lambda channel: file[channel][:], folder / "braking.png")
        time, energy = file["time"][:], {key: file[f"energy/{key}"][:] for key in file["energy"]}
    draw(lambda figure: _energies(figure, scenario, time, energy, first), folder / "energy.png", (9.0, 4.5))
    return [f"{name}.png" for name in FIGURES]


def over_time(scenario, read, path):
    """Draw speeds, slide, pressures, valves and adhesion of a run with subsystems.

    read : gives the values of a channel.
    """
    vehicle = scenario.vehicle
    time, speeds = read("time"), read(f"bodies/{vehicle.names[0]}/velocity")[:, 0]
    numbers = range(1, len(vehicle.wheelsets) + 1)
    axles = {key: np.column_stack([read(f"axles/W{k}/{key}") for k in numbers]) for key in AXLE_CHANNELS}
    spins = [read(f"bodies/{vehicle.names[i]}/angular_velocity")[:, 1] for i in vehicle.wheelsets]
    tread = -np.column_stack(spins) * np.mean(vehicle.wheel_radii, axis=1)
    draw(lambda figure: _over_time(figure, scenario, time, speeds, tread, axles), path, (9.0, 9.0))


def _over_time(figure, scenario, time, vehicle, tread, axles):
    panels = figure.subplots(5, 1, sharex=True, height_ratios=(2.0, 1.2, 1.2, 0.8, 1.2))
    panels[0].plot(time, 3.6 * vehicle, color="black", linewidth=1.6, label="vehicle", zorder=3)
    for a in range(tread.shape[1]):
        style = {"color": SERIES[a % len(SERIES)], "linewidth": 0.9, "label": f"W{a + 1}"}
        panels[0].plot(time, 3.6 * tread[:, a], **style)
        panels[1].plot(time, 100.0 * axles["slide"][:, a], **style)
        panels[2].plot(time, 1e-5 * axles["brake_pressure"][:, a], **style)
        panels[3].step(time, axles["valve"][:, a] + 0.05 * a, where="post", **style)
        panels[4].plot(time, axles["adhesion_used"][:, a], **style)
    panels[4].plot(time, axles["adhesion_offered"].mean(axis=1), color=GREY, linestyle="--", label="offered")
    for panel, label in zip(panels, ("speed [km/h]", "slide [%]", "pressure [bar]", "valve", "adhesion used [-]"),
                            strict=True):  # fmt: skip
        panel.set_ylabel(label)
    panels[1].set_ylim(-5.0, min(100.0 * axles["slide"].max() + 5.0, 105.0))
    panels[3].set_yticks([0, 1, 2], ["fill", "hold", "vent"])
    panels[0].set_title(scenario.title or scenario.name)
    panels[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    panels[4].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    panels[4].set_xlabel("time [s]")


def _energies(figure, scenario, time, energy, first):
    axis = figure.subplots()
    names = [key for key in ("brake", "creep", "suspension", "contact", "resistance") if np.any(energy[key])]
    axis.stackplot(time, *(1e-6 * np.maximum(energy[key], 0.0) for key in names), labels=names, colors=SERIES,
                   alpha=0.8)  # fmt: skip
    gained = first + energy["gravity"] + energy["traction"] + energy["holding"]
    axis.plot(time, 1e-6 * gained, color="black", linestyle="--", label="kinetic at start\nand gains")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("energy taken [MJ]")
    axis.set_title(f"{scenario.title or scenario.name}: where the energy went")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
