"""Normal laws against a solution on elements as text, records and a figure."""

import numpy as np

from railcli.analysis.normal_check import QUANTITIES, RANKS, normal_deviations, ranks

from .figures import GREY, SERIES
from .text import columns

SHOWN = {  # of `normal_deviations`: name for readers, unit, units per SI unit, decimals
    "sink": ("approach", "%", 100.0, 2),
    "pressure": ("largest pressure", "%", 100.0, 1),
    "area": ("area", "%", 100.0, 1),
    "place": ("place", "mm", 1e3, 2),
}
RECORDED = {  # of `NormalStates.values`: name with its unit, units per SI unit
    "sink": ("approach_um", 1e6),
    "normal": ("normal_N", 1.0),
    "pressure": ("pressure_MPa", 1e-6),
    "area": ("area_mm2", 1e6),
    "rail": ("rail_mm", 1e3),
    "wheel": ("wheel_mm", 1e3),
    "patches": ("patches", 1.0),
    "share": ("greatest_share", 1.0),
}
LINES = ("-", ":", "--", "-.")
AXES = {"sink": (-12.0, 12.0), "pressure": (-45.0, 35.0), "area": (-55.0, 30.0), "place": (-3.0, 3.0)}  # shown


def sections(result):
    """Titles and lines: how far every law is off by load, and the states where it is furthest off."""
    reference, rows, worst = result.normal_reference, [], []
    for load in reference.loads:
        chosen = reference.load == load
        for law, values in result.normal.items():
            off = {key: found[chosen] for key, found in normal_deviations(values, reference).items()}
            name = f"{load * 1e-3:g} kN, {law}"
            aims = "held" if law in result.held else "shown"
            rows.append((name, *(_three(key, off[key]) for key in QUANTITIES), aims))
            worst.append((name, *(_worst(key, off[key], np.flatnonzero(chosen), reference) for key in QUANTITIES)))
    header = [f"{SHOWN[key][0]} [{SHOWN[key][1]}]" for key in QUANTITIES]
    title = f"Normal laws against half spaces on elements, {np.count_nonzero(chosen)} states per load"
    return [
        (f"{title}: {' / '.join(RANKS)}", columns(rows, ("", *header, "aims"))),
        ("Normal laws: where each is furthest off", columns(worst, ("", *header))),
    ]


def _three(key, off):
    _, _, factor, digits = SHOWN[key]
    return " / ".join(f"{factor * value:.{digits}f}" for value in ranks(off).values())


def _worst(key, off, rows, reference):
    _, _, factor, digits = SHOWN[key]
    k = int(np.abs(off).argmax())
    i = rows[k]
    return f"{factor * off[k]:+.{digits}f} at {reference.y[i] * 1e3:g} mm, {reference.yaw[i] * 1e3:g} mrad"


def records(result):
    """One record for each state and law, and for the reference ("elements")."""
    reference, found = result.normal_reference, []
    for law, values in {"elements": reference.values, **result.normal}.items():
        for i in range(reference.y.size):
            entry = {
                "normal_law": law, "y_mm": round(reference.y[i] * 1e3, 6), "yaw_mrad": round(reference.yaw[i] * 1e3, 6),
                "load_kN": round(reference.load[i] * 1e-3, 6),
            }  # fmt: skip
            found.append(
                entry | {name: float(factor * values[key][i]) for key, (name, factor) in RECORDED.items()}
            )
    return found


def paint(figure, result):
    """Deviations over y: a column for each load, a row for each quantity, a colour for each law."""
    reference = result.normal_reference
    axes = figure.subplots(len(QUANTITIES), reference.loads.size, sharex=True, sharey="row")
    for row, key in zip(axes, QUANTITIES, strict=True):
        name, unit, factor, _ = SHOWN[key]
        for axis, load in zip(row, reference.loads, strict=True):
            axis.axhline(0.0, color=GREY, linewidth=0.6)
            for colour, (law, values) in zip(SERIES, result.normal.items(), strict=False):
                off = normal_deviations(values, reference)[key]
                for line, yaw in zip(LINES, np.unique(reference.yaw), strict=False):
                    chosen = (reference.load == load) & (reference.yaw == yaw)
                    axis.plot(reference.y[chosen] * 1e3, factor * off[chosen], color=colour, linestyle=line,
                              marker=".", markersize=3.5, label=f"{law}, yaw {yaw * 1e3:g} mrad")  # fmt: skip
            axis.set_ylim(*AXES[key])
        row[0].set_ylabel(f"{name} [{unit}]")
    for top, bottom, load in zip(axes[0], axes[-1], reference.loads, strict=True):
        top.set_title(f"{load * 1e-3:g} kN vertical")
        bottom.set_xlabel("lateral position y of the wheelset [mm]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=6)
