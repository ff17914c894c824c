"""Figures of the comparison of the contact with published references."""

import numpy as np

from railcli.analysis.contact_benchmark import FRICTION

from . import normal_validation
from .contact_validation import QUANTITIES
from .figures import GREY, SERIES, draw

LINES = ("-", "--", "-.", ":")
MARKS = (("right", "o"), ("left", "s"))
SHOWN_CREEPAGE = 7.0  # beyond, all are in full slip [1e-3]
CURVES = (  # of the creep laws: title, creepage that varies, force, rank of the spin
    ("Longitudinal, no spin", 0, 0, 0),
    ("Lateral, no spin", 1, 1, 0),
    ("Lateral, light spin", 1, 1, 1),
    ("Lateral, heavy spin", 1, 1, 3),
)


def figures(result, folder):
    """Draw benchmark.png, forces.png, creep.png and normal.png."""
    draw(lambda figure: _benchmark(figure, result), folder / "benchmark.png", (12.0, 10.5))
    draw(lambda figure: _forces(figure, result), folder / "forces.png", (11.0, 7.5))
    draw(lambda figure: _creep(figure, result), folder / "creep.png", (13.0, 6.4))
    draw(lambda figure: normal_validation.paint(figure, result), folder / "normal.png", (12.0, 11.0))


def _benchmark(figure, result):
    """Contact over y, a colour for each normal law, by the two wheels; dots are CONTACT's."""
    axes = figure.subplots(3, 2)
    for axis, key in zip(axes.flat, ("on_rail", "delta_r", "angle", "normal", "area", "pressure"), strict=True):
        if key == "delta_r":
            _delta_r(axis, result)
            continue
        name, unit, factor, _ = QUANTITIES[key]
        reference = factor * result.reference.values[key]
        for k, (side, mark) in enumerate(MARKS):
            axis.plot(result.reference.y * 1e3, reference[:, k], mark, color="black", markersize=4, zorder=3,
                      markerfacecolor="black" if k == 0 else "white", label=f"CONTACT, {side} wheel")  # fmt: skip
            for colour, (normal, states) in zip(SERIES, result.fine.items(), strict=False):
                _over_y(axis, states, factor * states.values[key][:, k], colour, LINES[k],
                        f"{normal}, {side} wheel")  # fmt: skip
        axis.set_title(name[0].upper() + name[1:])
        axis.set_ylabel(f"[{unit.replace('2', '$^2$')}]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=6)
    for axis in axes.flat:
        axis.set_xlim(-0.2, 10.2)
        axis.set_xlabel("lateral position y, yaw 2.4 mrad per mm [mm]")


def _over_y(axis, states, values, colour, line, label):
    """A line that breaks where the contact of the right wheel jumps."""
    y = states.y * 1e3
    after = np.flatnonzero(np.abs(np.diff(states.values["on_rail"][:, 0])) > 3e-3) + 1
    axis.plot(np.insert(y, after, np.nan), np.insert(values, after, np.nan), color=colour, linestyle=line, label=label)


def _delta_r(axis, result):
    axis.plot(result.reference.y * 1e3, result.reference.delta_r * 1e3, "o", color="black", markersize=4, zorder=3)
    for colour, states in zip(SERIES, result.fine.values(), strict=False):
        _over_y(axis, states, states.delta_r * 1e3, colour, "-", None)
    axis.set_yscale("symlog", linthresh=1.0)
    axis.set_yticks([0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0], ["0", "0.5", "1", "2", "5", "10", "20"])
    axis.set_ylim(-0.05, 30.0)
    axis.set_title("Δr from the height on the wheel (linear to 1 mm)")
    axis.set_ylabel("[mm]")


def _forces(figure, result):
    """Creep forces in the contact plane over mu N at the reference's positions."""
    axes = figure.subplots(2, 2, sharex=True)
    y = result.reference.y * 1e3
    normals = list(dict.fromkeys(key[0] for key in result.states))
    laws = list(result.laws)
    limit = FRICTION * result.reference.values["normal"]
    for row, (key, name) in enumerate((("creep_x", "along x"), ("creep_t", "across"))):
        for k, (side, _) in enumerate(MARKS):
            axis = axes[row, 1 - k]
            for (normal, law), states in result.states.items():
                colour, line = SERIES[laws.index(law) % len(SERIES)], LINES[normals.index(normal) % len(LINES)]
                share = states.values[key][:, k] / limit[:, k]
                axis.plot(y, share, color=colour, linestyle=line, label=f"{normal}, {law}")
            share = result.reference.values[key][:, k] / limit[:, k]
            axis.plot(y, share, "o", color="black", markersize=4.5, zorder=3, label="CONTACT")
            axis.axhline(0.0, color=GREY, linewidth=0.6)
            axis.set_title(f"{side.capitalize()} wheel, {name}")
            axis.set_ylabel("creep force on the rail over μN")
    for axis in axes[1]:
        axis.set_xlabel("lateral position y, yaw 2.4 mrad per mm [mm]")
    axes[0, 1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _creep(figure, result):
    """Creep curves of every law against the full solution: rows are ellipses, columns creepages."""
    states = result.creep_states
    spins = np.unique(np.abs(states.slip[:, 2]))
    axes = figure.subplots(len(states.ellipses), len(CURVES), sharey=True)
    for row, (a, b) in enumerate(states.ellipses):
        for axis, (title, slip, force, rank) in zip(axes[row], CURVES, strict=True):
            still = states.slip[:, 1 - slip] == 0.0
            chosen = np.flatnonzero((states.a == a) & (states.b == b) & (states.slip[:, 2] == spins[rank]) & still)
            chosen = chosen[np.argsort(states.slip[chosen, slip])]
            x = states.slip[chosen, slip] * 1e3
            axis.plot(x, states.contact[chosen, force], "o", color="black", markersize=3.5, zorder=1, label="CONTACT")
            axis.plot(x, states.fastsim[chosen, force], "x", color=GREY, markersize=4, zorder=1,
                      label="FASTSIM, converged")  # fmt: skip
            for colour, (law, found) in zip(SERIES, result.laws.items(), strict=False):
                axis.plot(x, found.forces[chosen, force], color=colour, label=law)
            axis.set_title(f"{title}, a : b = {a / b:g} : 1" if a > b else f"{title}, a : b = 1 : {b / a:g}")
            axis.set_xlim(-SHOWN_CREEPAGE if x[0] < 0.0 else -0.1, SHOWN_CREEPAGE)
            axis.set_xlabel("creepage [1e-3]")
        axes[row, 0].set_ylabel("force over μN")
    axes[0, 0].legend(loc="upper right")
