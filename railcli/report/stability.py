"""Critical speed for readers: tables, JSON, CSV, root locus and bifurcation diagram."""

import math
from textwrap import wrap

import numpy as np

from railcli.analysis.stability import USUAL, end_of, hunts

from .figures import GREY, SERIES, VERMILION, draw
from .text import columns, speed

TOP = 15.0  # of the root locus [Hz]
SHOWN = (-12.0, 6.0)  # real parts in it [1/s]
WIDTH = 118  # of the text
READING = (
    "Below the first speed every swing dies; a cycle of tenths of a millimetre, as may begin there, does no harm; "
    "running safety after EN 14363 ends where sum Y passes its limit; the linear speed says where a swing of {:g} mm "
    "would begin to grow if creep had no limit."
)


def start_of_ramp(loci, span, above):
    """Speed at which a ramp begins when the user gives none [m/s]."""
    low, high, step = span
    found = [locus.critical for locus in loci if locus is not None and locus.critical > 0.0]
    if not found:
        return high
    return float(min(high, low + step * math.ceil((above * max(found) - low) / step)))


def critical_text(locus):
    """A linear critical speed in words."""
    if locus is None:
        return "-"
    if math.isnan(locus.critical):
        return f"> {locus.speeds[-1]:g}"
    return f"< {locus.speeds[0]:g}" if locus.critical == 0.0 else f"{locus.critical:.1f}"


def report(scenario, lines, loci, cycles, measures, step):
    """Lines for the terminal.

    Parameters
    ----------
    scenario : Scenario
    lines : list of tuples of QuasiLinear
        One tuple for each amplitude, one line in it for each wheel radius.
    loci : list of Locus or None
        None where the swing reaches the flange.
    cycles : list of Cycle
    measures : Measures
    step : float or None
        Of the time runs [s]; None where there were none.
    """
    contact = scenario.contact
    text = [
        f"{scenario.name}: {scenario.vehicle.name} on straight level track, friction {contact.friction:g}, "
        f"creep law {contact.creep_law}"
    ]
    rows = []
    for line, locus in zip(lines, loci, strict=True):
        first = line[0]
        known = locus is not None and locus.critical > 0.0
        rows.append(
            (
                f"{first.amplitude * 1e3:g}", f"{first.conicity:.4f}",
                f"{first.equivalent:.4f}" if math.isfinite(first.equivalent) else "-",
                f"{first.angle * 1e-3:.4f}", f"{-first.roll:.4f}", critical_text(locus),
                f"{3.6 * locus.critical:.0f}" if known else "-",
                f"{locus.frequency:.2f}" if known else "-",
                f"{locus.critical / locus.frequency:.1f}" if known else "-",
                "beyond the flange" if locus is None else locus.mode,
            )
        )  # fmt: skip
    header = ("amplitude", "conicity", "EN 15302", "angle", "roll", "critical", "", "f", "wave", "")
    units = ("mm", "-", "-", "1/mm", "mrad/mm", "m/s", "km/h", "Hz", "m", "mode at its limit")
    text += ["", "Linear, with quasi-linear contact over a swing of one amplitude:", *columns([units, *rows], header)]
    if step is not None:
        text += ["", *cycles_text(cycles, step)]
        if cycles:
            text += ["", *speeds_text(loci, cycles, measures)]
    return text


def cycles_text(cycles, step):
    """Lines of the bifurcation table and where the hunting ends."""
    count = cycles[0].amplitude.size if cycles else 0
    header = ("speed", "", *(f"W{k + 1}" for k in range(count)), "sum Y", "f", "wave", "")
    rows = [("m/s", "km/h", *["mm"] * count, "kN rms", "Hz", "m", "")]
    for cycle in sorted(cycles, key=lambda cycle: -cycle.speed):
        moves = cycle.hunts and math.isfinite(cycle.frequency)
        remark = "" if cycle.settled else f"still changing after {cycle.time:g} s"
        rows.append(
            (
                f"{cycle.speed:.2f}", f"{3.6 * cycle.speed:.1f}", *(f"{value * 1e3:.2f}" for value in cycle.amplitude),
                f"{1e-3 * cycle.sum_y_rms.max():.2f}" if cycle.hunts else "-",
                f"{cycle.frequency:.2f}" if moves else "-", f"{cycle.speed / cycle.frequency:.1f}" if moves else "-",
                "no hunting" if not cycle.hunts else remark,
            )
        )  # fmt: skip
    text = [
        "Non-linear: amplitude of each wheelset (half peak-to-peak) while the speed falls from segment to segment, "
        f"step {1e3 * step:g} ms"
    ]
    text += columns(rows, header) if cycles else []
    return [*text, f"  {verdict(cycles)}"]


def verdict(cycles):
    """Where the hunting ends, in a sentence."""
    below, above = end_of(cycles)
    if not cycles:
        return "No limit cycle was computed."
    if math.isnan(above):
        return f"No hunting: the disturbance dies at {speed(below)} already; begin at a higher speed (--from)."
    if math.isnan(below):
        return f"Hunting lasts down to {speed(above)}, the lowest speed asked for (--speeds)."
    smallest = next(cycle for cycle in cycles if cycle.speed == above)
    return (
        f"Hunting lasts at {speed(above, '.2f')}, by {1e3 * smallest.largest:.2f} mm, and has died "
        f"at {speed(below, '.2f')}."
    )


def linear_speed(loci):
    """Linear critical speed at the USUAL amplitude in words, and the locus; None where a swing reaches the flange."""
    locus = next((one for one in loci if one is not None and math.isclose(one.amplitude, USUAL)), None)
    return critical_text(locus), locus


def speeds_text(loci, cycles, measures):
    """Lines of the critical speeds, each for what is meant by the word."""
    top = max(cycle.speed for cycle in cycles)
    at = {cycle.speed: cycle for cycle in cycles}
    rows, remarks = [], []
    for name, passes in (
        ("smallest limit cycle", hunts),
        (f"limit cycle of {1e3 * measures.counted:g} mm", measures.counts),
        (f"sum Y, rms at its limit of {1e-3 * measures.limit.min():.1f} kN", measures.breaks),
    ):
        below, above = end_of(cycles, passes)
        if math.isnan(above):
            rows.append((name, f"> {top:g}", f"> {3.6 * top:.0f}"))
            remarks.append("not up to the speed from which the ramp fell (--from)")
            continue
        rows.append((name, f"{above:.2f}", f"{3.6 * above:.0f}"))
        lasts = "still there at the lowest speed" if math.isnan(below) else f"no more at {speed(below, '.2f')}"
        cycle = at[above]
        remarks.append(f"{1e3 * cycle.largest:.2f} mm, {1e-3 * cycle.sum_y_rms.max():.1f} kN; {lasts}")
    text, locus = linear_speed(loci)
    known = locus is not None and locus.critical > 0.0
    rows.append((f"linear, swing of {1e3 * USUAL:g} mm", text, f"{3.6 * locus.critical:.0f}" if known else "-"))
    remarks.append(locus.mode if known else "")
    table = columns([("", "m/s", "km/h"), *rows])
    lines = [f"{line}  {remark}".rstrip() for line, remark in zip(table, ["", *remarks], strict=True)]
    reading = wrap(READING.format(1e3 * USUAL), WIDTH, initial_indent="  ", subsequent_indent="  ")
    return ["Critical speed, by what is meant:", *lines, *reading]


def speeds_json(loci, cycles, measures):
    """As `speeds_text`; a speed is null where the ramp did not meet it."""
    at = {cycle.speed: cycle for cycle in cycles}
    found = {}
    for name, passes in (("smallest", hunts), ("counted", measures.counts), ("limit", measures.breaks)):
        below, above = end_of(cycles, passes)
        cycle = at.get(above)
        found[name] = {
            "lives_m_per_s": above,
            "died_m_per_s": below,
            "amplitude_mm": 1e3 * cycle.largest if cycle else None,
            "sum_Y_rms_kN": 1e-3 * cycle.sum_y_rms.max() if cycle else None,
        }
    text, locus = linear_speed(loci)
    known = locus is not None and locus.critical > 0.0
    return {
        "smallest_cycle": found["smallest"],
        "counted_cycle": {**found["counted"], "counted_from_mm": 1e3 * measures.counted},
        "sum_Y_rms": {**found["limit"], "limit_kN": 1e-3 * measures.limit},
        "linear": {
            "amplitude_mm": 1e3 * USUAL, "critical_m_per_s": locus.critical if known else None, "critical": text
        },
        "reading": READING.format(1e3 * USUAL),
    }  # fmt: skip


def as_json(scenario, lines, loci, cycles, threshold, measures, step, provenance, files):
    """Everything, for a machine; units in the names."""
    below, above = end_of(cycles)
    return {
        "scenario": scenario.name,
        "vehicle": scenario.vehicle.name,
        "friction": scenario.contact.friction,
        "creep_law": scenario.contact.creep_law,
        "normal": scenario.contact.normal,
        "changes": list(scenario.changes),
        "linear": [
            {
                "contact": [one.as_dict() for one in line],
                "critical_m_per_s": locus.critical if locus is not None and locus.critical > 0.0 else None,
                "critical": critical_text(locus),
                "frequency_hz": None if locus is None else locus.frequency,
                "mode": "beyond the flange" if locus is None else locus.mode,
                "highest_m_per_s": None if locus is None else float(locus.speeds[-1]),
            }
            for line, locus in zip(lines, loci, strict=True)
        ],
        "limit_cycles": [
            {
                "speed_m_per_s": cycle.speed,
                "amplitude_mm": cycle.amplitude * 1e3,
                "frequency_hz": cycle.frequency,
                "sum_Y_rms_kN": 1e-3 * cycle.sum_y_rms,
                "time_s": cycle.time,
                "settled": cycle.settled,
                "hunts": cycle.hunts,
            }
            for cycle in sorted(cycles, key=lambda cycle: -cycle.speed)
        ],
        "step_ms": None if step is None else 1e3 * step,
        "threshold_mm": threshold * 1e3,
        "hunting_ends": {"lives_m_per_s": above, "died_m_per_s": below},
        "critical_speeds": speeds_json(loci, cycles, measures) if cycles else None,
        "verdict": verdict(cycles) if cycles else "",
        "files": files,
        "provenance": provenance,
    }


def linear_csv(lines, loci):
    """Quasi-linear contact (of the first wheel radius) and critical speed over amplitude."""
    rows = ["amplitude_mm,conicity,equivalent_conicity,angle_per_m,roll_rad_per_m,critical_m_per_s,frequency_hz,mode"]
    for line, locus in zip(lines, loci, strict=True):
        one = line[0]
        found = (math.nan, math.nan, "beyond the flange") if locus is None else (
            locus.critical, locus.frequency, locus.mode
        )  # fmt: skip
        rows.append(
            f"{one.amplitude * 1e3:g},{one.conicity:.6f},{one.equivalent:.6f},{one.angle:.6f},{one.roll:.6f},"
            f'{found[0]:.4f},{found[1]:.5f},"{found[2]}"'
        )
    return "\n".join(rows) + "\n"


def locus_csv(loci):
    """Every oscillating eigenvalue over amplitude and speed."""
    rows = ["amplitude_mm,speed_m_per_s,real_per_s,frequency_hz,damping_ratio"]
    for locus in loci:
        if locus is None:
            continue
        for at, values in zip(locus.speeds, locus.values, strict=True):
            rows += [
                f"{locus.amplitude * 1e3:g},{at:g},{value.real:.6f},{value.imag / (2.0 * math.pi):.6f},"
                f"{-value.real / abs(value):.8f}"
                for value in sorted(values, key=lambda value: value.imag)
            ]
    return "\n".join(rows) + "\n"


def cycles_csv(cycles):
    """Amplitudes over speed."""
    count = cycles[0].amplitude.size
    names = [f"W{k + 1}" for k in range(count)]
    places, forces = [f"{name}_mm" for name in names], [f"{name}_sum_Y_rms_kN" for name in names]
    rows = [",".join(["speed_m_per_s", *places, "frequency_hz", "time_s", "settled", *forces])]
    for cycle in sorted(cycles, key=lambda cycle: -cycle.speed):
        values = [f"{value * 1e3:.5f}" for value in cycle.amplitude]
        ends = [f"{cycle.frequency:.5f}", f"{cycle.time:g}", str(int(cycle.settled))]
        forces = [f"{value * 1e-3:.4f}" for value in cycle.sum_y_rms]
        rows.append(",".join([f"{cycle.speed:g}", *values, *ends, *forces]))
    return "\n".join(rows) + "\n"


def figures(scenario, loci, cycles, measures, folder):
    """Draw root loci and bifurcation diagram; returns the names of the files."""
    found = [locus for locus in loci if locus is not None]
    names = []
    if found:
        draw(lambda figure: _root_locus(figure, scenario, found), folder / "root_locus.png", (10.0, 4.8))
        names.append("root_locus.png")
    if cycles or any(locus.critical > 0.0 for locus in found):
        draw(
            lambda figure: _bifurcation(figure, scenario, found, cycles, measures),
            folder / "bifurcation.png", (9.0, 5.2),
        )  # fmt: skip
        names.append("bifurcation.png")
    return names


def _root_locus(figure, scenario, loci):
    """Roots of the middle amplitude in the complex plane, coloured by speed; largest real part over speed for all."""
    plane, growth = figure.subplots(1, 2)
    middle = loci[len(loci) // 2]
    speed = np.concatenate([np.full(len(v), s) for s, v in zip(middle.speeds, middle.values, strict=True)])
    value = np.concatenate(middle.values)
    frequency = value.imag / (2.0 * math.pi)
    seen = (frequency <= TOP) & (value.real > SHOWN[0]) & (value.real < SHOWN[1])
    points = plane.scatter(value.real[seen], frequency[seen], c=speed[seen], s=9, cmap="viridis")
    figure.colorbar(points, ax=plane, label="speed [m/s]")
    plane.axvline(0.0, color=GREY, linewidth=0.8)
    plane.set_xlabel("real part [1/s]")
    plane.set_ylabel("frequency [Hz]")
    plane.set_title(f"{scenario.name}: roots at {middle.amplitude * 1e3:g} mm")
    for k, locus in enumerate(loci):
        growth.plot(
            locus.speeds, locus.growth, color=SERIES[k % len(SERIES)], linestyle="-" if k < len(SERIES) else "--",
            label=f"{locus.amplitude * 1e3:g} mm",
        )  # fmt: skip
    growth.axhline(0.0, color=GREY, linewidth=0.8)
    growth.set_xlabel("speed [m/s]")
    growth.set_ylabel("largest real part [1/s]")
    growth.set_title("growth of the least stable motion")
    growth.legend(title="amplitude", loc="upper left")


def _bifurcation(figure, scenario, loci, cycles, measures):
    """Amplitude of the limit cycles over speed, with the linear critical speed of each amplitude."""
    axis = figure.subplots()
    linear = [(locus.critical, locus.amplitude * 1e3) for locus in loci if locus.critical > 0.0]
    if linear:
        axis.plot(*np.array(linear).T, "s--", color=GREY, markersize=5, label="linear critical speed at this amplitude")
    alive = sorted((cycle for cycle in cycles if cycle.hunts), key=lambda cycle: cycle.speed)
    dead = [cycle.speed for cycle in cycles if not cycle.hunts]
    if alive:
        speed = [cycle.speed for cycle in alive]
        amplitude = 1e3 * np.array([cycle.amplitude for cycle in alive])
        for k in range(amplitude.shape[1]):
            axis.plot(
                speed, amplitude[:, k], "o-" if 2 * k < amplitude.shape[1] else "o--", color=SERIES[k % len(SERIES)],
                markersize=4, label=f"W{k + 1}, limit cycle", markerfacecolor="none" if k % 2 else None,
            )  # fmt: skip
    if dead:
        axis.plot(dead, [0.0] * len(dead), "x", color=VERMILION, label="no hunting", clip_on=False, zorder=3)
    for words, passes in (
        ("hunting ends", hunts),
        (f"{1e3 * measures.counted:g} mm", measures.counts),
        ("sum Y at its limit", measures.breaks),
    ):
        _, above = end_of(cycles, passes)
        if math.isfinite(above):
            axis.axvline(above, color=VERMILION, linewidth=0.8, linestyle=":")
            axis.annotate(
                f"{words}: {speed(above, '.1f')}", (above, 0.97), xycoords=("data", "axes fraction"), fontsize=8,
                rotation=90, ha="right", va="top", color=VERMILION,
            )  # fmt: skip
    axis.set_ylim(bottom=0.0)
    axis.set_xlabel("speed [m/s]")
    axis.set_ylabel("lateral amplitude of the wheelsets [mm]")
    axis.set_title(f"{scenario.name}: hunting over speed")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
