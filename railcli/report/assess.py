"""An assessment for people: tables of figures against limits, and the signals along the track."""

import csv
import io
import math

import numpy as np

from railcli.analysis.assessment.wear import ALL
from railcli.model.assessment import FIGURES, GROUPS, NOT_CONSULTED

from .figures import GREY, SERIES, VERMILION, draw
from .run import track_strip
from .text import columns, conditions, facts, speed

SHOWN = {"kN": 1e-3}  # factor from SI to the unit that a figure is shown in
PANELS = (  # figure, label of the axis, both signs of the limit
    ("Y_Q", "Y/Q, larger of\nboth wheels", False),
    ("sum_Y", "sum Y [kN],\n2 m mean", True),
    ("Q_max", "Q [kN],\nboth wheels", False),
    ("ay_max", "lateral acc.\n[m/s²], 0.4-10 Hz", True),
    ("az_max", "vertical acc.\n[m/s²], 0.4-10 Hz", True),
)
MANY = 60  # sections that are not drawn any more
FAR = 0.2  # share of a limit below which the limit is told, not drawn
LEGEND = (
    f"{NOT_CONSULTED}: processing and limit from common knowledge of the field and secondary sources; the standard "
    "itself was not consulted (docs/assessment.md)."
)


def _shown(key, value):
    """Number in the unit that the figure is shown in; None stays None."""
    return None if value is None else value * SHOWN.get(FIGURES[key].unit, 1.0)


def _number(key, value):
    if value is None:
        return "-"
    value = _shown(key, value)
    digits = 3 if value == 0.0 else max(0, min(4, 3 - math.floor(math.log10(abs(value))) - 1))
    return f"{value:.{digits}f}"


def _share(value):
    return f"{100.0 * value.value / value.limit:.0f}%" if value.limit else "-"


def _verdict(value):
    return value.status if value.value is None else f"{value.status} {FIGURES[value.key].mark}".rstrip()


def _tail(value):
    return "; ".join(text for text in (value.place, value.note) if text)


def head(name, scenario, assessment):
    """Lines that say what was evaluated."""
    given = assessment.conditions
    count, angle = len(assessment.sections), math.degrees(given["flange_angle_rad"])
    sections = (
        f"{count} section{'s' * (count != 1)} from {given['from_m']:.0f} to {given['to_m']:.0f} m"
        if count
        else "nothing"
    )
    pairs = [
        ("evaluated", f"{sections}, without the first {given['run_in_s']:g} and the last {given['run_out_s']:g} s"),
        *conditions(scenario),
        ("recorded", f"at {given['recorded_Hz']:g} Hz"),
        ("Nadal", f"flange angle {angle:g} degrees, friction {given['friction']:g}"),
    ]
    if "floor_height_m" in given:
        pairs.append(("floor", f"{given['floor_height_m']:g} m over the rail tops, in the middle of the track"))
    return [f"{name}: {scenario.title}" if scenario.title else name, *facts(pairs)]


def table(assessment):
    """Lines of all figures, group by group."""
    header = ("", "", "value", "limit", "of limit", "verdict")
    rows = []
    for value in assessment.values:
        figure = FIGURES[value.key]
        numbers = _number(value.key, value.value), _number(value.key, value.limit), _share(value)
        rows.append((figure.title, figure.unit, *numbers, _verdict(value)))
    lines = columns(rows, header, "    ")
    found = [lines[0]]
    starts = {first: heading for heading, first in GROUPS.items()}
    for line, value in zip(lines[1:], assessment.values, strict=True):
        if value.key in starts:
            found.append(f"  {starts[value.key]}")
        found.append(f"{line}  {_tail(value)}".rstrip())
    return found


def wear_table(assessment):
    """Lines of T-gamma by wheel and part of the profile: mean over all sections, largest mean of a section."""
    if not assessment.wear:
        return []
    parts = list(next(iter(assessment.wear.values())))
    used = [part for part in parts if part == ALL or any(wheel[part][1] > 0.0 for wheel in assessment.wear.values())]
    header = ("", *(text for part in used for text in (part, "largest")))
    rows = [
        (name.replace("_", " "), *(f"{number:.1f}" for part in used for number in wheel[part]))
        for name, wheel in assessment.wear.items()
    ]
    return [
        "Wear number T-gamma [N = J/m]: mean of what is evaluated, and of the worst section",
        *columns(rows, header),
    ]


def verdict(assessment):
    """One line that counts."""
    counts = [f"{assessment.count(status)} {status}" for status in ("pass", "warn", "fail", "not evaluated")]
    broken = "the run broke off; " if assessment.fault else ""
    return f"{broken}{', '.join(counts)}; {assessment.count('no limit')} without a limit"


def _warnings(assessment):
    if not assessment.fault:
        return assessment.warnings
    text = f"The run broke off: {assessment.fault}. Figures go as far as each wheelset came."
    return [text, *assessment.warnings]


def report(name, scenario, assessment):
    """Lines for the terminal."""
    lines = [*head(name, scenario, assessment), "", *table(assessment)]
    if assessment.wear:
        lines += ["", *wear_table(assessment)]
    lines += ["", *(f"Warning: {text}" for text in _warnings(assessment)), LEGEND, f"Verdict: {verdict(assessment)}"]
    return lines


def side_by_side(names, assessments):
    """Lines that compare several results, one column each."""
    rows = []
    for k, key in enumerate(FIGURES):
        cells = []
        for assessment in assessments:
            value = assessment.values[k]
            sign = {"fail": " F", "warn": " w"}.get(value.status, "")
            cells.append(_number(key, value.value) + sign)
        rows.append((FIGURES[key].title, FIGURES[key].unit, *cells))
    return ["Side by side (F: fail, w: warn)", *columns(rows, ("", "", *names))]


def short(assessment, command):
    """The few lines of a run's summary: counts, the figures nearest to their limits, and what failed."""
    if not assessment.sections:
        return [f"Assessment: nothing formed; {assessment.values[0].note}"]
    limited = sorted(
        (value for value in assessment.values if value.value is not None and value.limit),
        key=lambda value: -value.value / value.limit,
    )
    begin, end = (assessment.conditions[key] for key in ("from_m", "to_m"))
    lines = [f"Assessment from {begin:.0f} to {end:.0f} m: {verdict(assessment)}"]
    worst = [value for value in limited if value.status in ("fail", "warn")]
    for value in worst or limited[:3]:
        figure = FIGURES[value.key]
        number = " ".join(filter(None, (_number(value.key, value.value), figure.unit)))
        lines.append(
            f"  {_verdict(value):7} {figure.title} {number}, {_share(value)} of {_number(value.key, value.limit)}: "
            f"{_tail(value)}"
        )
    return [*lines, f"  All figures: {command}"]


def as_json(assessment):
    """Figures, wear, conditions and warnings, in the units they are shown in."""
    figures = {}
    for value in assessment.values:
        figure = FIGURES[value.key]
        figures[value.key] = {
            "title": figure.title,
            "value": _shown(value.key, value.value),
            "limit": _shown(value.key, value.limit),
            "unit": figure.unit or "-",
            "status": value.status,
            "place": value.place,
            "note": value.note,
            "processing": figure.how,
            "source": figure.source,
            "standard_consulted": not figure.mark,
        }
    return {
        "finished": not assessment.fault,
        "conditions": assessment.conditions,
        "verdict": {
            status: assessment.count(status) for status in ("pass", "warn", "fail", "not evaluated", "no limit")
        },
        "figures": figures,
        "T_gamma_N": {
            wheel: {part: {"mean": mean, "largest_section": largest} for part, (mean, largest) in parts.items()}
            for wheel, parts in assessment.wear.items()
        },
        "warnings": _warnings(assessment),
    }


def for_summary(assessment):
    """What summary.json holds of an assessment: numbers and verdicts."""
    return {
        "from_m": assessment.conditions["from_m"],
        "to_m": assessment.conditions["to_m"],
        "figures": {
            value.key: {
                "value": _shown(value.key, value.value),
                "limit": _shown(value.key, value.limit),
                "unit": FIGURES[value.key].unit or "-",
                "status": value.status,
            }
            for value in assessment.values
        },
        "warnings": _warnings(assessment),
    }


def sections_csv(assessment):
    """Text of a CSV file: a row for each section, a column for each figure that belongs to sections."""
    keys = [key for key, row in assessment.by_section.items() if any(value is not None for value in row)]
    names = {key: f"{key}_{FIGURES[key].unit.replace('/s^2', '_per_s2')}".rstrip("_") for key in keys}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["start_m", "end_m", "kind", "radius_m", *names.values()])
    for k, section in enumerate(assessment.sections):
        radius = "" if math.isinf(section.radius) else f"{math.copysign(section.radius, section.curvature):.6g}"
        values = [_shown(key, assessment.by_section[key][k]) for key in keys]
        cells = ["" if value is None else f"{value:.6g}" for value in values]
        writer.writerow([f"{section.start:.3f}", f"{section.end:.3f}", section.kind, radius, *cells])
    return text.getvalue()


def figure(name, scenario, assessment, path):
    """Draw Y/Q, sum Y, Q and accelerations along the track with their limits; False when there is nothing to draw."""
    panels = [panel for panel in PANELS if assessment.traces.get(panel[0])]
    if panels:
        draw(lambda canvas: _draw(canvas, name, scenario, assessment, panels), path, (9.0, 1.6 + 1.75 * len(panels)))
    return bool(panels)


def _draw(canvas, name, scenario, assessment, panels):
    strip, *axes = canvas.subplots(len(panels) + 1, 1, sharex=True, height_ratios=(0.5, *[2.0] * len(panels)))
    for axis, (key, label, both) in zip(axes, panels, strict=True):
        factor = SHOWN.get(FIGURES[key].unit, 1.0)
        lines = assessment.traces[key]
        for k, (line, trace) in enumerate(lines.items()):
            pair = key == "Q_max"
            style = {"color": SERIES[(k // 2 if pair else k) % len(SERIES)], "linewidth": 0.9}
            title = None if pair and k % 2 else line.split("_")[0]
            there = ~np.isnan(trace.low)
            axis.fill_between(
                trace.places[there],
                factor * trace.low[there],
                factor * trace.high[there],
                label=title,
                alpha=0.8,
                **style,
            )
        if limit := assessment.bounds.get(key):
            largest = max(np.nanmax(np.abs([trace.low, trace.high]), initial=0.0) for trace in lines.values())
            if largest < FAR * limit:
                text = f"limit {factor * limit:.3g}: beyond the axis"
                axis.text(0.99, 0.95, text, transform=axis.transAxes, fontsize=8, color=VERMILION, ha="right", va="top")
            else:
                for sign in (1.0, -1.0) if both else (1.0,):
                    axis.axhline(sign * factor * limit, color=VERMILION, linestyle="--", linewidth=1.0)
        axis.set_ylabel(label)
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    track_strip(strip, axes, scenario, assessment.conditions["to_m"])
    few = len(assessment.sections) <= MANY
    strip.set_title(f"{name}, {speed(scenario.run.speed)}; dashed: limits{', thin: sections' * few}")
    for section in assessment.sections * few:
        for axis in axes:
            axis.axvline(section.start, color=GREY, linewidth=0.4)
    axes[-1].set_xlabel("arc length [m]")
