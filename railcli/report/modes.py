"""Eigenmodes for readers: table, JSON, CSV, the complex plane and pictures of the mode shapes."""

import math

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from railcli.analysis.linear import STEP
from railcli.files.output import cell

from . import mode_pictures
from .figures import BLUE, GREEN, GREY, ORANGE, VERMILION, draw
from .text import columns, conditions, conditions_json, facts, speed

HIGH = 50.0  # frequencies beyond are printed when asked for only [Hz]
DEAD = 0.95  # damping ratios beyond likewise
AXES = ("s", "y", "z", "roll", "pitch", "yaw")
UNITS = ("m", "m", "m", "rad", "rad", "rad")
RELIABLE = 1e-4  # relative change of an eigenvalue with the difference step that is worth a warning
COLOURS = {"lateral": VERMILION, "vertical": BLUE, "mixed": GREEN}
DRAWN = 12  # mode shapes in the picture
RATIOS = (0.01, 0.05, 0.1, 0.2, 0.5)  # of equal damping in the picture
NEAR = 0.015  # of the picture: eigenvalues that share a label
SPARE = 1e-9  # smaller parts of a mode shape are rounding


def wavelength(speed, frequency):
    """Of an oscillation along the track [m]."""
    return speed / frequency if frequency > 0.0 else math.nan


def contact_facts(lines):
    """Pairs that describe the contact of a linear model."""
    if lines is None:
        return [("contact", "differences of the contact table at y = 0, creep law and friction of the scenario")]
    pairs = []
    for line in lines:
        reach = "; the flank of the flange takes part" if line.flange else ""
        pairs.append(
            (
                "contact" if not pairs else "",
                f"quasi-linear at {line.amplitude * 1e3:g} mm: conicity {line.conicity:.4f}, contact angle "
                f"{line.angle * 1e-3:.4f} per mm, roll {line.roll:.4f} mrad per mm; linear creep{reach}",
            )
        )
    return pairs


def report(scenario, lines, modes, change, shapes, everything):
    """Lines for the terminal.

    Parameters
    ----------
    scenario : Scenario
    lines : sequence of QuasiLinear or None
    modes : Modes
    change : complex array (m,)
        Of the eigenvalues with twice the difference step [1/s].
    shapes : list of Shape
    everything : bool
    """
    linear = modes.linear
    worst = np.abs(change / modes.value).max()
    spins = int(linear.system.model.body["spins"].sum())
    text = [f"{scenario.name}: {scenario.vehicle.name} at {speed(linear.speed)} on straight level track"]
    text += facts(
        [
            *conditions(scenario),
            *contact_facts(lines),
            ("states", f"{linear.matrix.shape[0]}, without the place along the track and the spin angles of wheelsets "
             f"({spins}), on which nothing depends; {_free(modes.free)}"),
            ("differences", f"{STEP[0]:.0e} m and rad, {STEP[6]:.0e} m/s and rad/s; twice that changes an eigenvalue "
             f"by {worst:.1e} at most"),
        ]
    )  # fmt: skip
    if worst > RELIABLE:
        text.append(
            "  Warning: the eigenvalues depend on the difference step: the contact table is not smooth here. Give an "
            "--amplitude."
        )
    value, frequency, damping = modes.value, modes.frequency, modes.damping
    oscillates = modes.oscillates
    shown = np.flatnonzero(oscillates) if everything else usual(modes)
    rows = [
        (
            str(k + 1), f"{frequency[k]:.3f}", f"{100 * damping[k]:.2f}", f"{value[k].real:+.3f}",
            f"{wavelength(linear.speed, frequency[k]):.1f}", _words(shapes[k]),
        )
        for k in shown
    ]  # fmt: skip
    text += ["", *_left_last(rows, ("", "f [Hz]", "damping [%]", "Re [1/s]", "V/f [m]", "mode shape"))]
    hidden = int(oscillates.sum()) - len(shown)
    if hidden:
        text.append(f"  and {hidden} more: damped by more than {DEAD:.0%}, or above {HIGH:g} Hz (--all, modes.csv)")
    real = value[~oscillates].real
    if real.size:
        text.append(f"  {real.size} motions creep without swinging, Re = {real.min():.0f} ... {real.max():.3g} 1/s")
    text.append("")
    k = int(np.argmax(value.real))
    if value[k].real < 0.0:
        text.append(f"Stable: every motion decays; slowest {_words(shapes[k])}, Re = {value[k].real:.3f} 1/s")
    else:
        text.append(f"Unstable: {_words(shapes[k])} grows with Re = {value[k].real:+.3f} 1/s")
    return text


def _free(count):
    if count == 1:
        return "1 neutral motion left out (the running speed)"
    return f"{count} neutral motions left out"


def _words(shape):
    if math.isfinite(shape.pole):
        return f"{shape.words} about {abs(shape.pole):.1f} m {'above' if shape.pole >= 0.0 else 'below'} the rails"
    return shape.words


def _left_last(rows, header):
    """Aligned columns with the last one to the left."""
    heads = columns([row[:-1] for row in rows], header[:-1]) if rows else []
    width = max(map(len, heads), default=0)
    words = [header[-1], *(row[-1] for row in rows)]
    return [f"{line.ljust(width)}  {text}" for line, text in zip(heads, words, strict=False)]


def as_json(scenario, lines, modes, change, shapes, provenance, files):
    """Everything, for a machine; units in the names."""
    linear = modes.linear
    return {
        "scenario": scenario.name,
        "vehicle": scenario.vehicle.name,
        **conditions_json(scenario),
        "contact": None if lines is None else [line.as_dict() for line in lines],
        "states": linear.matrix.shape[0],
        "left_out": modes.free,
        "step_dependence": float(np.abs(change / modes.value).max()),
        "stable": bool(modes.value.real.max() < 0.0),
        "modes": [_mode(modes, shapes[k], k) for k in range(modes.value.size)],
        "files": files,
        "provenance": provenance,
    }


def _mode(modes, shape, k):
    linear, value = modes.linear, modes.value[k]
    q = linear.coordinates(modes.right[k])
    return {
        "frequency_hz": modes.frequency[k],
        "damping_ratio": modes.damping[k],
        "real_per_s": value.real,
        "imaginary_per_s": value.imag,
        "wavelength_m": wavelength(linear.speed, modes.frequency[k]),
        "shape": shape.words,
        "plane": shape.plane,
        "pole_height_m": shape.pole,
        "kinetic_energy": shape.shares,
        "displacement": {
            name: {
                f"{axis}_{unit}": [float(entry.real), float(entry.imag)]
                for axis, unit, entry in zip(AXES, UNITS, row, strict=True)
                if abs(entry) > SPARE
            }
            for name, row in zip(linear.system.bodies, q, strict=True)
        },
    }


def modes_csv(modes, shapes):
    """One row for each mode."""
    groups = list(shapes[0].shares) if shapes else []
    keys = [cell(f"energy_{name.replace(' ', '_')}") for name in groups]
    lines = [",".join(["mode", "frequency_hz", "damping_ratio", "real_per_s", "imaginary_per_s", "wavelength_m",
                       "plane", *keys, "pole_height_m", "shape"])]  # fmt: skip
    for k, (value, shape) in enumerate(zip(modes.value, shapes, strict=True)):
        numbers = [f"{modes.frequency[k]:.6f}", f"{modes.damping[k]:.8f}", f"{value.real:.6f}", f"{value.imag:.6f}"]
        numbers += [f"{wavelength(modes.linear.speed, modes.frequency[k]):.4f}", shape.plane]
        numbers += [f"{shape.shares[name]:.6f}" for name in groups]
        lines.append(",".join([str(k + 1), *numbers, f"{shape.pole:.4f}", cell(shape.words)]))
    return "\n".join(lines) + "\n"


def shapes_csv(modes, shapes):
    """Complex displacements of every body in every mode; the largest of a mode is 1 (m or rad)."""
    lines = ["mode,frequency_hz,body,coordinate,unit,real,imaginary"]
    for k in range(len(shapes)):
        q = modes.linear.coordinates(modes.right[k])
        for name, row in zip(modes.linear.system.bodies, q, strict=True):
            lines += [
                f'{k + 1},{modes.frequency[k]:.6f},{cell(name)},{axis},{unit},{entry.real:.9g},{entry.imag:.9g}'
                for axis, unit, entry in zip(AXES, UNITS, row, strict=True)
                if abs(entry) > SPARE
            ]
    return "\n".join(lines) + "\n"


def figures(scenario, modes, shapes, folder):
    """Draw the complex plane and the mode shapes; returns the names of the files."""
    draw(lambda figure: _plane(figure, scenario, modes, shapes), folder / "eigenvalues.png", (10.5, 5.6))
    drawn = usual(modes)[:DRAWN]
    if not drawn.size:
        return ["eigenvalues.png"]
    rows = -(-len(drawn) // 3)
    draw(
        lambda figure: mode_pictures.draw_shapes(figure, modes, shapes, drawn, COLOURS),
        folder / "mode_shapes.png",
        (11.0, 0.6 + 2.1 * rows),
    )
    return ["eigenvalues.png", "mode_shapes.png"]


def _plane(figure, scenario, modes, shapes):
    """Eigenvalues that oscillate, up to HIGH, with curves of equal damping ratio and a key to their numbers."""
    axis = figure.subplots()
    shown = usual(modes)
    value, frequency = modes.value[shown], modes.frequency[shown]
    low, top = 0.7 * frequency.min(initial=1.0), 1.5 * frequency.max(initial=1.0)
    left, right = 1.6 * min(value.real.min(initial=-1.0), -1.0), max(2.0 * value.real.max(initial=0.0), 0.5)
    axis.set_xscale("symlog", linthresh=1.0)
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.yaxis.set_major_formatter("{x:g}")
    axis.yaxis.set_minor_formatter(NullFormatter())
    grid = np.geomspace(low, top, 200)
    for ratio in RATIOS:
        real = -2.0 * math.pi * grid * ratio / math.sqrt(1.0 - ratio**2)
        axis.plot(real, grid, color=GREY, linewidth=0.6, linestyle=":")
        inside = np.flatnonzero(real > left)
        if inside.size:
            axis.annotate(f"{100 * ratio:g} %", (real[inside[-1]], grid[inside[-1]]), color=GREY, fontsize=7,
                          va="top", ha="center")  # fmt: skip
    axis.axvline(0.0, color=ORANGE, linewidth=1.0)
    for plane, colour in COLOURS.items():
        of = [k for k in shown if shapes[k].plane == plane]
        if of:
            axis.plot(modes.value[of].real, modes.frequency[of], "o", color=colour, markersize=5, label=plane)
    for numbers, (x, y) in _together(axis, shown, value.real, frequency, (left, right), (low, top)):
        axis.annotate(numbers, (x, y), xytext=(5, 3), textcoords="offset points", fontsize=7)
    axis.set_xlim(left, right)
    axis.set_ylim(low, top)
    axis.set_xlabel("real part [1/s]; left of 0: decays")
    axis.set_ylabel("frequency [Hz]")
    axis.set_title(f"{scenario.name}: eigenvalues at {speed(modes.linear.speed)}; dotted: equal damping ratio")
    axis.legend(loc="lower left")
    key = "\n".join(f"{k + 1:3d}  {modes.frequency[k]:6.2f} Hz  {shapes[k].words}" for k in shown)
    axis.annotate(key, (1.02, 1.0), xycoords="axes fraction", fontsize=7, va="top", family="monospace")


def usual(modes):
    """Indices of the modes that are printed unasked."""
    return np.flatnonzero(modes.oscillates & (modes.frequency <= HIGH) & (modes.damping <= DEAD))


def _together(axis, shown, real, frequency, xs, ys):
    """Numbers of eigenvalues that lie on each other in the picture, as one label, and its place."""
    forward = axis.get_xaxis().get_transform().transform
    x = np.interp(forward(real), forward(np.array(xs)), (0.0, 1.0))
    y = np.log(frequency / ys[0]) / np.log(ys[1] / ys[0])
    rest = list(range(len(shown)))
    while rest:
        near = [j for j in rest if abs(x[j] - x[rest[0]]) < NEAR and abs(y[j] - y[rest[0]]) < NEAR]
        first = rest[0]
        rest = [j for j in rest if j not in near]
        yield ", ".join(str(shown[j] + 1) for j in near), (real[first], frequency[first])
