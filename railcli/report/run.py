"""A run for people: the steady values of its end as text, time series as figures."""

import textwrap
from pathlib import Path

import numpy as np
from numpy.polynomial.polynomial import polyval

from railcli.model.track import pack

from .figures import GREY, SERIES, draw, plain
from .text import columns, conditions, conditions_json, facts, speed

LINE = 118  # characters of a description
FIGURES = ("wheelsets", "wheel_loads", "lateral_forces", "accelerations")
PIECE_POINTS = 9  # at which the curvature of a piece of track is drawn
LABELLED = 0.12  # of the width: shorter sections are not named
SHADE = {"transition": 0.08, "measured": 0.08, "curve": 0.16}
OFF_BALANCE = 0.005  # share of a sum of rail forces by which it may differ from its balance without a word
LEAST_OFF = 200.0  # where that sum is small [N]
VIBRATES = 100.0  # peak to peak of a wheel force on smooth track that is worth a warning [N]
DIFFERENCE = 1e-5  # between the end of a run and Newton's steady motion that is worth a warning [m]
ON_IRREGULAR_RAILS = (
    "On irregular rails these are means of a motion that goes on swaying; that of Newton's method runs on ideal ones."
)


def sides_of(stretch):
    """Names of the wheels of a wheelset, in the order of SteadyValues."""
    return ("right", "left") if stretch.curvature == 0.0 else ("outer", "inner")


def steady_text(stretch, mean, swing, newton):
    """Table of the wheelsets: mean and peak-to-peak over the end of the run, and Newton's steady motion.

    Parameters
    ----------
    stretch : Stretch
    mean, swing : SteadyValues
    newton : SteadyValues or None
    """
    one, other = sides_of(stretch)
    forces = [f"{force} {side}" for force in "QY" for side in (one, other)]
    header = ("", "y mean", "p-p", "Newton", "yaw", "p-p", *forces)
    rows = [("", "mm", "mm", "mm", "mrad", "mrad", *["kN"] * 4)]
    for k in range(mean.lateral.size):
        forces = [*mean.q_force[k], *mean.y_force[k]]
        rows.append(
            (
                f"W{k + 1}",
                f"{mean.lateral[k] * 1e3:.3f}",
                f"{swing.lateral[k] * 1e3:.3f}",
                f"{newton.lateral[k] * 1e3:.3f}" if newton else "none",
                f"{mean.yaw[k] * 1e3:.3f}",
                f"{swing.yaw[k] * 1e3:.3f}",
                *(f"{force * 1e-3:.2f}" for force in forces),
            )
        )
    return columns(rows, header)


def steady_motion_text(scenario, stretch, values):
    """Lines of a steady motion alone."""
    one, other = sides_of(stretch)
    rows = [("", "mm", "mrad", *["kN"] * 4)]
    for k in range(values.lateral.size):
        forces = (f"{force * 1e-3:.2f}" for force in (*values.q_force[k], *values.y_force[k]))
        rows.append((f"W{k + 1}", f"{values.lateral[k] * 1e3:.3f}", f"{values.yaw[k] * 1e3:.3f}", *forces))
    place = "to the right" if stretch.curvature == 0.0 else "towards the outer rail"
    dry = ", without dry friction" if scenario.vehicle.is_dry else ""
    title = (
        f"{scenario.name}: steady motion at {speed(scenario.final_speed)}, {stretch.kind}{dry}; lateral values {place}"
    )
    return [title, *columns(rows, ("", "y", "yaw", *(f"{force} {side}" for force in "QY" for side in (one, other))))]


def settled(mean, newton, dry):
    """A warning when the end of the run is not the steady motion; empty when it is.

    dry : the vehicle has dry friction, which holds it anywhere near the steady motion without friction.
    """
    if newton is None:
        return "Newton's method finds no steady motion there: the run may not be steady."
    gap = np.abs(mean.lateral - newton.lateral).max()
    if gap > DIFFERENCE and dry:
        return (
            f"The mean of the run differs by up to {gap * 1e3:.3f} mm from the steady motion that Newton finds without "
            "dry friction: it depends on the way there."
        )
    if gap > DIFFERENCE:
        return (
            f"The mean of the run differs by up to {gap * 1e3:.3f} mm from the steady motion that Newton finds: it has "
            "not settled, or it oscillates."
        )
    return ""


def unbalanced(mean, expected):
    """A warning when sum Y or sum Q is not what the motion asks for; empty when they are.

    expected : lateral and vertical balance [N], as `steady_values.expected_forces` gives it.
    """
    found = mean.y_force.sum(), mean.q_force.sum()
    allowed = max(OFF_BALANCE * abs(expected[0]), LEAST_OFF), OFF_BALANCE * expected[1]
    off = [
        f"sum {name} differs from its balance by {(force - wanted) * 1e-3:+.2f} kN"
        for name, force, wanted, within in zip("YQ", found, expected, allowed, strict=True)
        if abs(force - wanted) > within
    ]
    return f"{' and '.join(off)}: the run is not steady there, or wrong." if off else ""


def vibrates(vibration):
    """A warning when a wheel force vibrates on smooth track; empty when none does by more than VIBRATES."""
    if vibration is None or not vibration.peak_to_peak > VIBRATES or np.isnan(vibration.frequency):
        return ""
    return (
        f"{vibration.force} of wheel {vibration.wheel} vibrates on smooth track: "
        f"{vibration.peak_to_peak * 1e-3:.2f} kN peak to peak (every step, no filter), "
        f"mostly at {vibration.frequency:.3g} Hz."
    )


def _twosides_of(scenario):
    """Facts about profiles and radii of both sides, where these differ."""
    lines = []
    (wheel, rail, _), (left_wheel, left_rail, _) = scenario.contact.sides
    if (wheel, rail) != (left_wheel, left_rail):
        right, left = (
            " on ".join(Path(one).name for one in pair) for pair in ((wheel, rail), (left_wheel, left_rail))
        )
        lines.append(("profiles", f"right {right}; left {left}"))
    radii = scenario.vehicle.wheel_radii
    if any(right != left for right, left in radii):
        words = []
        for right, left in dict.fromkeys(radii):
            names = ", ".join(f"W{k}" for k, pair in enumerate(radii, start=1) if pair == (right, left))
            words.append(f"{names}: right {right * 1e3:.6g}, left {left * 1e3:.6g}")
        lines.append(("wheel radii [mm]", "; ".join(words)))
    return lines


def report(scenario, outcome, stretch, steady, step):
    """Lines for the terminal.

    Parameters
    ----------
    scenario : Scenario
    outcome : Outcome
    stretch : Stretch or None
    steady : steady_values.End or None
    step : list of (str, str)
        The time step in words, as `report.step.words` gives it.
    """
    reached = f"{outcome.distance:.1f} m, {outcome.time:.2f} s"
    if outcome.fault:
        planned = scenario.distance, scenario.duration
        reached = f"{outcome.distance:.1f} of {planned[0]:.1f} m, {outcome.time:.2f} of {planned[1]:.2f} s"
    lines = [f"{scenario.name}: {scenario.title}" if scenario.title else scenario.name]
    lines += textwrap.wrap(scenario.description, LINE, initial_indent="  ", subsequent_indent="  ")
    lines += facts(
        [
            ("reached", reached),
            *conditions(scenario),
            *step,
            *_twosides_of(scenario),
            ("real-time factor", f"{outcome.real_time_factor:.0f} (simulated time over processor time of the steps)"),
        ]
    )
    if outcome.jolt:
        lines += ["", f"  {outcome.jolt}"]
    if outcome.fault:
        return [*lines, "", f"Broken off: {outcome.fault}"]
    if stretch is None:
        end = "at one speed" if scenario.final_speed is None else "in one straight or curve"
        return [*lines, "", f"The run does not end {end}: no steady values."]
    if steady is None:
        return lines
    mean, newton, expected = steady.mean, steady.newton, steady.balance
    place = "to the right" if stretch.curvature == 0.0 else "towards the outer rail"
    title = f"Steady values over the last {scenario.average_over:g} m ({stretch.kind}); lateral values {place}"
    lines += ["", title, *steady_text(stretch, mean, steady.swing, newton)]
    lines.append(
        f"  Forces on the rails: sum Y {mean.y_force.sum() * 1e-3:.2f} kN (balance {expected[0] * 1e-3:.2f}), "
        f"sum Q {mean.q_force.sum() * 1e-3:.2f} kN (balance {expected[1] * 1e-3:.2f})"
    )
    if stretch.gradient:
        lines.append(
            f"  Gradient {1e3 * stretch.gradient:.4g} per mille: traction {steady.traction * 1e-3:.2f} kN "
            f"(weight along the track {steady.weight_along * 1e-3:.2f})"
        )
    warnings = (
        (ON_IRREGULAR_RAILS,) if scenario.irregularity else
        (unbalanced(mean, expected), settled(mean, newton, scenario.vehicle.is_dry), vibrates(steady.vibration))
    )  # fmt: skip
    return [*lines, *(f"  {warning}" for warning in warnings if warning)]


def figures(scenario, main, folder):
    """Draw the time series over the distance; returns the names of the files."""
    painters = {
        "wheelsets": _wheelsets,
        "wheel_loads": lambda axes, main: _forces(axes, main, main.q_force, "Q"),
        "lateral_forces": lambda axes, main: _forces(axes, main, main.y_force, "Y"),
        "accelerations": _accelerations,
    }
    names = []
    for name, painter in painters.items():
        names.append(f"{name}.png")
        draw(lambda figure, painter=painter: _panels(figure, painter, scenario, main), folder / names[-1], (9.0, 5.6))
    return names


def _panels(figure, painter, scenario, main):
    strip, *axes = figure.subplots(3, 1, sharex=True, height_ratios=(0.5, 2.0, 2.0))
    painter(axes, main)
    end = main.distance[-1] if main.distance.size else scenario.distance
    track_strip(strip, axes, scenario, end)
    mean = "" if painter is _wheelsets else f"; means over {1e3 * scenario.run.output_interval:g} ms"
    axes[-1].set_xlabel(f"arc length of the first body [m]{mean}")
    for axis in axes:
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def track_strip(strip, axes, scenario, end):
    """Curvature over the distance with the sections named, and the same sections shaded in the other axes."""
    pieces = pack(scenario.track)
    places = [piece["start"] + np.linspace(0.0, piece["length"], PIECE_POINTS) for piece in pieces]
    bends = [polyval(s - piece["start"], piece["curvature"]) for s, piece in zip(places, pieces, strict=True)]
    strip.fill_between(np.concatenate(places), 1e3 * np.concatenate(bends), color=GREY, alpha=0.5, linewidth=0.0)
    strip.set_ylabel("curvature\n[1/km]")
    strip.set_title(f"{scenario.name}, {speed(scenario.run.speed)}; positive: to the right")
    strip.set_xlim(0.0, end)
    strip.margins(y=0.15)
    start = 0.0
    for section in scenario.track.sections:
        stop = min(start + section.length, end)
        if section.kind != "straight" and start < end:
            for axis in axes:
                axis.axvspan(start, stop, color=GREY, alpha=SHADE[section.kind], linewidth=0.0, zorder=0)
        if stop - start > LABELLED * end:
            strip.text(0.5 * (start + stop), 0.5, _name(section), transform=strip.get_xaxis_transform(), fontsize=8,
                       ha="center", va="center")  # fmt: skip
        start += section.length


def _name(section):
    if section.kind != "curve":
        return section.kind
    return f"R = {section.radius:g} m {section.hand}, cant {1e3 * section.cant:g} mm"


def _wheelsets(axes, main):
    for axis, values in zip(axes, (main.lateral, main.yaw), strict=True):
        _each_wheelset(axis, main, 1e3 * values)
    axes[0].set_ylabel("lateral displacement [mm]")
    axes[1].set_ylabel("yaw [mrad]")


def _forces(axes, main, force, name):
    for side, axis in enumerate(axes):
        _each_wheelset(axis, main, 1e-3 * force[:, side::2])
        axis.set_ylabel(f"{name} {('right', 'left')[side]} [kN]")


def _each_wheelset(axis, main, values):
    """One line for each wheelset; the rear half dashed, because it often covers the front half."""
    count = values.shape[1]
    for k in range(count):
        style = {"color": SERIES[k % len(SERIES)], "linestyle": "--" if 2 * k >= count > 1 else "-"}
        axis.plot(main.distance, values[:, k], label=f"W{k + 1}", **style)


def _accelerations(axes, main):
    for i, body in enumerate(main.sprung):
        for axis, direction in zip(axes, (1, 2), strict=True):
            colour = SERIES[i % len(SERIES)]
            axis.plot(main.distance, main.acceleration[:, i, direction], color=colour, label=plain(body),
                      zorder=3.0 - 0.1 * i)  # fmt: skip
    axes[0].set_ylabel("lateral acceleration,\nto the right [m/s²]")
    axes[1].set_ylabel("vertical acceleration,\ndown [m/s²]")


def summary(scenario, outcome, stretch, steady, provenance, files, step):
    """What summary.json holds; units in the names."""
    record = {
        "scenario": scenario.name,
        "title": scenario.title,
        **conditions_json(scenario),
        "finished": not outcome.fault,
        "fault": outcome.fault,
        "jolt": outcome.jolt,
        "time_s": outcome.time,
        "distance_m": outcome.distance,
        "rows": outcome.rows,
        "step": step,
        "cpu_s": outcome.cpu_s,
        "real_time_factor": outcome.real_time_factor,
        "files": files,
        "provenance": provenance,
    }
    if steady is None:
        return record
    mean, newton, expected = steady.mean, steady.newton, steady.balance
    record["steady"] = {
        "stretch": stretch.kind,
        "averaged_over_m": scenario.average_over,
        "lateral_positive": "to the right" if stretch.curvature == 0.0 else "towards the outer rail",
        "wheels": list(sides_of(stretch)),
        "mean": steady_json(mean),
        "peak_to_peak": steady_json(steady.swing),
        "newton": steady_json(newton) if newton else None,
        "sum_Y_kN": float(mean.y_force.sum() * 1e-3),
        "expected_Y_kN": expected[0] * 1e-3,
        "sum_Q_kN": float(mean.q_force.sum() * 1e-3),
        "expected_Q_kN": expected[1] * 1e-3,
        "gradient_m_per_m": stretch.gradient,
        "traction_kN": steady.traction * 1e-3,
        "weight_along_kN": steady.weight_along * 1e-3,
        "warning": settled(mean, newton, scenario.vehicle.is_dry),
    }
    record["balance"] = {
        "sum_Y_kN": float(mean.y_force.sum() * 1e-3),
        "expected_Y_kN": expected[0] * 1e-3,
        "sum_Q_kN": float(mean.q_force.sum() * 1e-3),
        "expected_Q_kN": expected[1] * 1e-3,
        "warning": unbalanced(mean, expected),
    }
    record["vibration"] = _vibration(steady.vibration)
    return record


def _vibration(found):
    if found is None:
        return None
    return {
        "force": found.force,
        "wheel": found.wheel,
        "peak_to_peak_kN": found.peak_to_peak * 1e-3,
        "frequency_Hz": None if np.isnan(found.frequency) else found.frequency,
        "warning": vibrates(found),
    }


def steady_json(values):
    """SteadyValues for a machine; units in the names."""
    return {
        "lateral_mm": values.lateral * 1e3,
        "yaw_mrad": values.yaw * 1e3,
        "Y_kN": values.y_force * 1e-3,
        "Q_kN": values.q_force * 1e-3,
    }
