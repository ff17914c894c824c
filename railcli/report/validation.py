"""The comparison with the published curve as text, JSON, CSV and figures."""

import numpy as np

from railcli.analysis.validate import READINGS, SUPPORTED, balance_error, deviations

from .criteria import document
from .figures import BLUE, GREEN, GREY, ORANGE, VERMILION, draw
from .text import columns, facts, sectioned
from .text import speed as in_words

READING_TEXT = {
    "as_printed": "as printed, all outwards",
    "exchanged": "rows 45 and 15 m/s exchanged, all outwards",
    "trailing_inside": "as printed, W2 and W4 towards the inner rail",
}
FIGURES = ("displacements", "friction", "forces")
SEMI_WHEELBASE = 1.28  # of the Manchester bogies, for the geometry of the readings [m]
SHOWN_FRICTION = (0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)


def assumptions(scenario, result):
    """What is given, what is assumed, what is fitted: list of (what, value)."""
    contact = scenario.contact
    curve = scenario.track.sections[-1]
    best, low, high, at_bound = result.friction
    bound = ", at the end of the searched range" if at_bound else ""
    speeds = ", ".join(in_words(value) for value in result.reference.speeds)
    return [
        ("given", f"R = {curve.radius:g} m, cant {curve.cant * 1e3:g} mm, {speeds}, UIC60, ORES1002 "
                  f"(gauge {contact.gauge * 1e3:g} mm, flange-back {contact.flange_back * 1e3:g} mm)"),
        ("assumed", f"rail inclination 1:{contact.inclination:g}, friction {contact.friction:.2f}, creep law "
                    f"{contact.creep_law}, normal law {contact.normal}, "
                    f"clothoid of {scenario.track.sections[1].length:g} m, constant speed"),
        ("identified", f"friction {best:.3f} ({low:.3f} to {high:.3f}, twice the jackknife error{bound}): absorbs "
                       "unknown differences, not a measurement of friction"),
    ]  # fmt: skip


def cells(result):
    """Twelve records: what is printed at a speed beside railcli's values at that true speed."""
    nominal, identified = result.displacements(), result.displacements(result.identified)
    records = []
    for i, speed in enumerate(result.reference.speeds):
        for k in range(nominal.shape[1]):
            records.append(
                {
                    "speed_ms": speed,
                    "wheelset": k + 1,
                    "simulink_mm": float(result.reference.simulink[i, k]),
                    "adams_mm": float(result.reference.adams[i, k]),
                    "railcli_mm": float(nominal[i, k]),
                    "railcli_identified_mm": float(identified[i, k]),
                    "railcli_peak_to_peak_mm": float(result.nominal[i].peak_to_peak_mm[k]),
                }
            )
    return records


def balances(runs):
    """One record per run: sums of rail forces on the vehicle against mass times acceleration."""
    return [
        {
            "speed_ms": run.speed,
            "sum_Y_kN": run.sum_y * 1e-3,
            "expected_Y_kN": run.expected_y * 1e-3,
            "sum_Q_kN": run.sum_q * 1e-3,
            "expected_Q_kN": run.expected_q * 1e-3,
            "Q_outer_kN": (run.q_outer * 1e-3).tolist(),
            "Q_inner_kN": (run.q_inner * 1e-3).tolist(),
            "Y_wheelsets_kN": (run.y_outwards * 1e-3).tolist(),
            "attack_mrad": (run.yaw * 1e3).tolist(),
            "holding_force_N": run.hold,
        }
        for run in runs
    ]


def as_json(scenario, result, provenance):
    """The whole comparison as one object."""
    best, low, high, at_bound = result.friction
    supported = result.reference.read(SUPPORTED)
    return {
        "cells": cells(result),
        "readings": result.readings(),
        "readings_identified": result.readings(result.identified),
        "supported_reading": SUPPORTED,
        "balance": balances(result.nominal),
        "balance_identified": balances(result.identified),
        "assumptions": {what: value for what, value in assumptions(scenario, result)},
        "identified_friction": {"value": best, "low": low, "high": high, "at_bound": at_bound},
        "variants": {
            name: {
                "outwards_mm": moved.tolist(),
                **deviations(moved, *supported),
            }
            for name, moved in result.variants.items()
        },
        "sensitivity": [
            {"friction": float(mu), "outwards_mm": moved.tolist(), **deviations(moved, *supported)}
            for mu, moved in zip(result.scan.friction, result.scan.outwards_mm, strict=True)
        ],
        "holding_kN": {
            reading: {"nominal": (nominal * 1e-3).tolist(), "identified": (identified * 1e-3).tolist()}
            for reading, (nominal, identified) in result.holding.items()
        },
        "static": {"wheel_loads_kN": (result.static_q * 1e-3).tolist(), "weight_kN": result.weight * 1e-3},
        "provenance": provenance,
    }


def cells_text(result):
    """The twelve cells under the supported reading."""
    simulink, adams = result.reference.read(SUPPORTED)
    nominal, identified = result.displacements(), result.displacements(result.identified)
    rows = []
    for i, speed in enumerate(result.reference.speeds):
        for k in range(nominal.shape[1]):
            rows.append(
                (
                    f"{speed:g}", f"W{k + 1}", f"{simulink[i, k]:.1f}", f"{adams[i, k]:.1f}", f"{nominal[i, k]:.2f}",
                    f"{nominal[i, k] - simulink[i, k]:+.2f}", f"{nominal[i, k] - adams[i, k]:+.2f}",
                    f"{identified[i, k]:.2f}", f"{identified[i, k] - simulink[i, k]:+.2f}",
                    f"{identified[i, k] - adams[i, k]:+.2f}", f"{result.nominal[i].peak_to_peak_mm[k]:.3f}",
                )
            )  # fmt: skip
    header = (
        "true m/s", "", "Simulink", "ADAMS", "railcli", "- Sim.", "- ADAMS", "identified", "- Sim.", "- ADAMS",
        "peak-peak",
    )  # fmt: skip
    return columns(rows, header)


def readings_text(result):
    """Deviations under the three readings, nominal and identified."""
    rows = []
    nominal, identified = result.readings(), result.readings(result.identified)
    for reading in READINGS:
        for name, values in (("nominal", nominal[reading]), ("identified", identified[reading])):
            rows.append(
                (
                    READING_TEXT[reading] if name == "nominal" else "",
                    name,
                    f"{values['rms_simulink_mm']:.2f}",
                    f"{values['rms_adams_mm']:.2f}",
                    f"{values['max_mm']:.2f}",
                )
            )
    return columns(rows, ("reading", "", "rms Simulink", "rms ADAMS", "largest"))


def balance_text(result):
    """Sums of rail forces on the vehicle, and what each bogie's wheelsets give."""
    rows = []
    for run in result.nominal:
        rows.append(
            (
                f"{run.speed:g} m/s", f"{run.sum_y * 1e-3:+.2f}", f"{run.expected_y * 1e-3:+.2f}",
                f"{run.sum_q * 1e-3:.2f}", f"{run.expected_q * 1e-3:.2f}",
                *(f"{value * 1e-3:+.1f}" for value in run.y_outwards), f"{run.hold:.0f} N",
            )
        )  # fmt: skip
    header = ("kN, outwards +", "sum Y", "m a_y", "sum Q", "m a_z", "Y W1", "Y W2", "Y W3", "Y W4", "holds speed")
    return columns(rows, header)


def wheel_loads_text(result):
    """Q of every wheel in the runs, and at rest."""
    rows = [
        (f"{run.speed:g} m/s, {side}", *(f"{value * 1e-3:.2f}" for value in values))
        for run in result.nominal
        for side, values in (("outer", run.q_outer), ("inner", run.q_inner))
    ]
    rows.append(("at rest, right", *(f"{value * 1e-3:.2f}" for value in result.static_q[0::2])))
    rows.append(("at rest, left", *(f"{value * 1e-3:.2f}" for value in result.static_q[1::2])))
    return columns(rows, ("Q [kN]", "W1", "W2", "W3", "W4"))


def why(result, radius):
    """Why the verdict rests on one reading: sentences with the runs' own forces."""
    fast, slow = result.nominal[0], result.nominal[-1]
    need_fast, need_slow = 0.5e-3 * fast.expected_y, 0.5e-3 * slow.expected_y
    y, along = result.displacements(), attack_along_tangent(radius)
    lines = [
        f"The rails must push each bogie by {need_fast:+.1f} kN at {fast.speed:g} m/s and by {need_slow:+.1f} kN at "
        f"{slow.speed:g} m/s (outwards positive): at {slow.speed:g} m/s the wagon leans on the inner rail.",
        f"W1 and W3 stay on the outer flange at every speed ({y[:, ::2].min():.2f} to {y[:, ::2].max():.2f} mm). What "
        f"changes with speed is the trailing wheelsets: W2 goes from {y[0, 1]:.2f} mm at {fast.speed:g} m/s to "
        f"{y[-1, 1]:.2f} mm at {slow.speed:g} m/s, inwards, because there is less to push back from the outer rail "
        f"(bogie 1: W1 {fast.y_outwards[0] * 1e-3:+.1f} and W2 {fast.y_outwards[1] * 1e-3:+.1f} kN against "
        f"{slow.y_outwards[0] * 1e-3:+.1f} and {slow.y_outwards[1] * 1e-3:+.1f} kN).",
        f"Attack angles of W1 and W2 at {slow.speed:g} m/s are {slow.yaw[0] * 1e3:+.2f} and {slow.yaw[1] * 1e3:+.2f} "
        f"mrad. With y1 = y2, as the row for {slow.speed:g} m/s prints, the bogie would lie along the tangent and they "
        f"would be {along:+.2f} and {-along:+.2f} mrad: the wheelsets' creep forces cancel, "
        "flange and gravity push inwards, and nothing gives the outward force.",
        "Force that would have to hold W2 and W4 where a reading puts them (mean of both codes), outwards positive:",
    ]
    rows = []
    for reading in READINGS:
        for name, force in zip(("nominal", "identified"), result.holding[reading], strict=True):
            cell = [_kilonewtons(row) for row in force]
            rows.append((READING_TEXT[reading] if name == "nominal" else "", name, *cell))
    header = ("kN on W2, W4 (none: no such motion)", "", *(f"{run.speed:g} m/s" for run in result.nominal))
    lines += columns(rows, header)
    printed, exchanged = result.holding["as_printed"], result.holding["exchanged"]
    lines.append(
        f"{fast.speed:g} m/s alone does not decide (nominal {_kilonewtons(printed[0][0])} kN as printed, "
        f"{_kilonewtons(exchanged[0][0])} kN exchanged); {slow.speed:g} m/s does (identified "
        f"{_kilonewtons(printed[1][-1])} kN against {_kilonewtons(exchanged[1][-1])} kN)."
    )
    best = result.readings()
    lines.append(
        f"With the labels of the rows for {fast.speed:g} and {slow.speed:g} m/s exchanged the trend with speed is that "
        f"of the balances; the root mean square falls from {best['as_printed']['rms_simulink_mm']:.2f} mm (as printed) "
        f"and {best['trailing_inside']['rms_simulink_mm']:.2f} mm (trailing inside) to "
        f"{best['exchanged']['rms_simulink_mm']:.2f} mm. The verdict rests on that reading; the reference file keeps "
        "the values as printed."
    )
    return lines


def _kilonewtons(forces):
    """Forces [N] as signed kN; "none" where there is no such motion."""
    return ", ".join(f"{1e-3 * value:+.1f}" for value in forces) if np.isfinite(forces).all() else "none"


def attack_along_tangent(radius):
    """Attack angle of a leading wheelset whose bogie lies along the tangent at its centre [mrad]."""
    return 1e3 * SEMI_WHEELBASE / radius


def variants_text(result):
    """Other assumptions, under the supported reading."""
    reference = result.reference.read(SUPPORTED)
    shown = {"nominal": result.displacements(), **result.variants}
    return columns([_moved(name, moved, reference) for name, moved in shown.items()], _moved_header(result))


def sensitivity_text(result):
    """Displacements and deviations over friction."""
    reference = result.reference.read(SUPPORTED)
    rows = []
    for mu, moved in zip(result.scan.friction, result.scan.outwards_mm, strict=True):
        if np.isclose(mu, SHOWN_FRICTION).any():
            rows.append(_moved(f"friction {mu:.2f}", moved, reference))
    return columns(rows, _moved_header(result))


def _moved_header(result):
    return ("assumption", *(f"W1-4 at {speed:g} m/s" for speed in result.reference.speeds), "rms S", "rms A", "largest")


def _moved(name, moved, reference):
    scores = deviations(moved, *reference)
    places = (" ".join(f"{value:.2f}" for value in row) for row in moved)
    return (name, *places, *(f"{scores[key]:.2f}" for key in ("rms_simulink_mm", "rms_adams_mm", "max_mm")))


def criteria_text(rows):
    """Every criterion with what was found."""
    rows = [
        (name, f"{found:.3f}", f"{limit:g} {unit}", "met" if met else "NOT MET", "verdict" if counts else "shown")
        for name, found, limit, unit, met, counts in rows
    ]
    return columns(rows, ("criterion", "found", "limit", "", ""))


def report(scenario, result, sensitivity):
    """Titles and lines of the whole report, for the terminal and for validation.md."""
    sections = [
        ("Assumptions", facts(assumptions(scenario, result))),
        ("Lateral displacement towards the outer rail [mm], rows of 45 and 15 m/s exchanged", cells_text(result)),
        ("The three readings of the printed table [mm]", readings_text(result)),
        ("Why one reading", why(result, scenario.track.sections[-1].radius)),
        ("Force balances of the runs", balance_text(result)),
        (f"Wheel loads; weight {result.weight * 1e-3:.2f} kN, largest balance error "
         f"{balance_error(result.nominal) * 1e-3:.3f} kN", wheel_loads_text(result)),
        ("Other assumptions (quasi-static)", variants_text(result)),
    ]  # fmt: skip
    if sensitivity:
        sections.append(("Sensitivity to friction (quasi-static)", sensitivity_text(result)))
    sections.append(("Criteria", []))
    return sections


def judged(record, sections, rows):
    """Write criteria and verdict into the record and the last section."""
    keys = ("name", "found", "limit", "unit", "met", "counts")
    record["criteria"] = [dict(zip(keys, row, strict=True)) for row in rows]
    record["verdict"] = "accepted" if all(row[4] for row in rows if row[5]) else "rejected"
    sections[-1] = ("Criteria", criteria_text(rows))


def figures(result, folder):
    """Draw displacements.png, friction.png and forces.png."""
    draw(lambda figure: _displacements(figure, result), folder / "displacements.png", (11.0, 8.0))
    draw(lambda figure: _friction(figure, result), folder / "friction.png", (7.5, 4.2))
    draw(lambda figure: _forces(figure, result), folder / "forces.png", (9.0, 4.4))


def _displacements(figure, result):
    speeds = np.array(result.reference.speeds)
    nominal, identified = result.displacements(), result.displacements(result.identified)
    scores = result.readings()
    for part, reading in zip(figure.subfigures(3, 1, hspace=0.04), READINGS, strict=True):
        rms = f"{scores[reading]['rms_simulink_mm']:.2f} / {scores[reading]['rms_adams_mm']:.2f}"
        part.suptitle(f"{READING_TEXT[reading]}: rms {rms} mm (nominal)", x=0.01, ha="left", fontweight="bold", size=10)
        axes = part.subplots(1, 4, sharex=True, sharey=True)
        simulink, adams = result.reference.read(reading)
        for k, axis in enumerate(axes):
            axis.plot(speeds, simulink[:, k], "s", color=ORANGE, label="Simulink")
            axis.plot(speeds, adams[:, k], "^", color=GREEN, label="ADAMS")
            axis.plot(speeds, nominal[:, k], "o-", color=BLUE, markersize=4, label="railcli nominal")
            axis.plot(speeds, identified[:, k], "o--", color=VERMILION, markersize=3, label="railcli identified")
            axis.axhline(0.0, color=GREY, linewidth=0.6)
            axis.set_title(f"W{k + 1}", fontweight="normal")
            axis.set_xlabel("true speed [m/s]")
            axis.set_xticks(sorted(speeds))
        axes[0].set_ylabel("outwards [mm]")
        axes[3].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _friction(figure, result):
    axis = figure.subplots()
    codes = zip(result.reference.read(SUPPORTED), (ORANGE, GREEN), ("Simulink", "ADAMS"), strict=True)
    for code, colour, name in codes:
        rms = np.sqrt(np.mean((result.scan.outwards_mm - code) ** 2, axis=(1, 2)))
        axis.plot(result.scan.friction, rms, ".-", color=colour, label=f"rms from {name}")
    best, low, high, _ = result.friction
    axis.axvspan(low, high, color=VERMILION, alpha=0.15, linewidth=0)
    axis.axvline(best, color=VERMILION, label=f"identified {best:.3f}")
    axis.axvline(0.3, color=BLUE, label="nominal 0.30")
    axis.set_xlabel("friction [-]")
    axis.set_ylabel("rms over 12 cells [mm]")
    axis.set_ylim(0.0, None)
    axis.set_title("Deviation over friction, rows of 45 and 15 m/s exchanged")
    axis.legend()


def _forces(figure, result):
    left, right = figure.subplots(1, 2)
    places = np.arange(4)
    for n, (run, colour) in enumerate(zip(result.nominal, (BLUE, ORANGE, GREEN), strict=True)):
        left.bar(places + 0.25 * (n - 1), run.y_outwards * 1e-3, 0.23, color=colour, label=f"{run.speed:g} m/s")
        right.bar(places + 0.25 * (n - 1), run.q_outer * 1e-3, 0.23, color=colour, label=f"{run.speed:g} m/s")
        right.plot(places + 0.25 * (n - 1), run.q_inner * 1e-3, "_", color="black", markersize=12,
                   label="inner wheel" if n == 0 else None)  # fmt: skip
    left.set_title("Lateral force of the rails, outwards +")
    right.set_title("Wheel loads Q: outer wheel (bars), inner")
    for axis in (left, right):
        axis.set_xticks(places, [f"W{k + 1}" for k in places])
        axis.set_ylabel("[kN]")
        axis.axhline(0.0, color=GREY, linewidth=0.6)
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=4)


def csv(result):
    """The twelve cells as CSV; columns as `cells`."""
    records = cells(result)
    lines = [",".join(records[0])]
    lines += [",".join(f"{value:.6g}" for value in record.values()) for record in records]
    return "\n".join(lines) + "\n"


def verdict_line(record):
    """One line: the verdict and what it rests on."""
    counted = [row for row in record["criteria"] if row["counts"]]
    met = sum(row["met"] for row in counted)
    return f"Verdict: {record['verdict']} ({met} of {len(counted)} criteria that count are met)"


def terminal(sections, record):
    """The report for a terminal."""
    return sectioned("Manchester passenger wagon, published curve", sections, verdict_line(record))


def markdown(sections, record, figures=FIGURES):
    """The report as validation.md; figures : names of those that stand beside it."""
    title = "Manchester passenger wagon: the published curve"
    return document(title, verdict_line(record), sections, figures, record["provenance"])
