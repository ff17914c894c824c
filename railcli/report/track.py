"""A track for people: curvature, cant, gradient, gauge and irregularity over s, a table of its sections, warnings."""

from pathlib import Path

import numpy as np

from railcli.analysis.alignment import LIMITS, NOT_CONSULTED, TIMED, course

from .figures import BLUE, GREY, ORANGE, SERIES, VERMILION, draw
from .run import SHADE
from .text import columns, facts
from .text import speed as both_units

WORDS = {  # of a limit: in words, unit, factor from SI
    "cant": ("cant", "mm", 1e3),
    "cant_deficiency": ("cant deficiency", "mm", 1e3),
    "cant_excess": ("cant excess", "mm", 1e3),
    "cant_rate": ("rate of change of cant", "mm/s", 1e3),
    "cant_deficiency_rate": ("rate of change of cant deficiency", "mm/s", 1e3),
    "twist": ("twist", "mm/m", 1e3),
    "vertical_acceleration": ("vertical acceleration", "m/s^2", 1.0),
}
HEADS = {"cant_deficiency": "I", "cant_excess": "E", "twist": "twist", "cant_rate": "dD/dt",
         "cant_deficiency_rate": "dI/dt", "vertical_acceleration": "V^2/Rv"}  # fmt: skip
PANEL_OF = {"twist": "cant", "cant": "cant", "vertical_acceleration": "gradient"}  # where a warning is marked
PIVOT_WORDS = {"centre": "middle of the track", "inner": "inner rail", "outer": "outer rail"}
POINTS, FINE_POINTS = 2000, 20_000  # of a drawn line, at least; of irregularity
NOTHING = 1e-4  # of a printed unit
LABELLED = 0.07  # of the width: shorter sections are not named


def radius_text(curvature):
    """Radius and hand of a curvature [1/m]: ``300 R``; a dash for straight track."""
    if abs(curvature) < 1e-9:
        return "-"
    return f"{1.0 / abs(curvature):.4g} {'R' if curvature > 0.0 else 'L'}"


def _span(span, text):
    """Ends of a section as ``first > last``; extremes as ``low .. high`` where they lie between."""
    one, two = (text(value) for value in ((span.low, span.high) if span.turns else (span.first, span.last)))
    return one if one == two else f"{one} {'..' if span.turns else '>'} {two}"


def _plain(value, form):
    """A number as text; what is nearly nothing as 0."""
    return f"{value:{form}}" if abs(value) > NOTHING else "0"


def sections_text(judged, timed):
    """Table of the sections; timed : whether a speed is known."""
    keys = [key for key in HEADS if timed or key not in TIMED]
    header = ("", "section", "from", "to", "radius", "cant", "gradient", "gauge", *(HEADS[key] for key in keys))
    rows = [("", "", "m", "m", "m", "mm", "1/1000", "mm", *(WORDS[key][1] for key in keys))]
    for one in judged:
        level = _span(one.gradient, lambda angle: _plain(1e3 * np.tan(angle), ".3g"))
        rows.append(
            (
                f"{one.number}",
                one.kind,
                f"{one.start:.6g}",
                f"{one.end:.6g}",
                _span(one.curvature, radius_text),
                _span(one.cant, lambda cant: _plain(1e3 * cant, ".4g")),
                level,
                _span(one.widening, lambda wide: _plain(1e3 * wide, "+.3g")),
                *(_value_text(one, key) for key in keys),
            )
        )
    return columns(rows, header)


def _value_text(one, key):
    mark = "*" if any(found.key == key for found in one.findings) else ""
    return f"{_plain(WORDS[key][2] * one.values[key], '.3g')}{mark}"


def finding_text(found):
    """One sentence on a value beyond its limit."""
    words, unit, factor = WORDS[found.key]
    whose = {
        "own": "of [limits]",
        "normal": "normal limit of EN 13803",
        "exceptional": "exceptional limit of EN 13803",
        "small radius": "(R - 50 m)/1.5 of EN 13803",
    }[found.kind]
    return (
        f"section {found.section}: {words} {factor * found.value:.4g} {unit} at {found.s:.6g} m, beyond "
        f"{factor * found.limit:.4g} {unit}, {whose}"
    )


def report(name, case, judged, speed):
    """Lines for the terminal.

    Parameters
    ----------
    name : str
        Title of the alignment.
    case : AlignmentCase
    judged : list of Judged
    speed : float or None
        [m/s]
    """
    length = judged[-1].end
    end = course(case.pieces, [length])
    count = f"{len(judged)} section{'s' if len(judged) > 1 else ''}"
    pace = f"{speed:g} m/s ({3.6 * speed:.4g} km/h)" if speed else "not known: give --speed for I, E and rates"
    x, y, z = end.place[0]
    heading = np.degrees(end.heading[0])
    lines = [name]
    lines += facts(
        [
            ("length", f"{length:.6g} m, {count}"),
            ("speed", pace),
            ("cant", f"over {1e3 * case.cant_base:g} mm; turns about the {PIVOT_WORDS[case.pivot]}"),
            ("end", f"x {x:.3f} m, y {y:.3f} m to the right, {0.0 - z:+.3f} m up, heading {heading:+.3f} degrees"),
        ]
    )
    lines += ["", *sections_text(judged, speed is not None)]
    lines.append("  R right-hand, L left-hand; cant left over right rail; D cant, I cant deficiency, E cant excess")
    findings = [found for one in judged for found in one.findings]
    if findings:
        lines += ["", f"Warnings (* in the table): {len(findings)}"]
        lines += [f"  {finding_text(found)}" for found in findings]
    else:
        lines += ["", "Nothing beyond the limits."]
    return [*lines, f"  {NOT_CONSULTED}"]


def summary(name, case, judged, speed):
    """The same for a machine; units in the names."""
    return {
        "name": name,
        "length_m": judged[-1].end,
        "speed_m_per_s": speed,
        "cant_base_m": case.cant_base,
        "cant_pivot": case.pivot,
        "sections": [
            {
                "number": one.number,
                "kind": one.kind,
                "from_m": one.start,
                "to_m": one.end,
                "curvature_1_per_m": one.curvature._asdict(),
                "cant_m": one.cant._asdict(),
                "gradient_m_per_m": {key: float(np.tan(angle)) for key, angle in one.gradient._asdict().items()},
                "gauge_over_nominal_m": one.widening._asdict(),
                "largest": {f"{key}_{_si(key)}": value for key, value in one.values.items()},
            }
            for one in judged
        ],
        "warnings": [
            {
                "section": found.section,
                "quantity": found.key,
                "unit": _si(found.key),
                "value": found.value,
                "at_m": found.s,
                "limit": found.limit,
                "kind": found.kind,
                "text": finding_text(found),
            }
            for one in judged
            for found in one.findings
        ],
        "standard": {
            key: {"normal": limit.normal, "exceptional": limit.exceptional, "unit": _si(key), "what": limit.where}
            for key, limit in LIMITS.items()
        },
        "standard_note": NOT_CONSULTED,
    }


def _si(key):
    unit = WORDS[key][1].replace("mm", "m").replace("^", "")
    return unit.replace("/", "_per_")


def plot(name, case, judged, speed, path):
    """Draw the alignment.

    Parameters
    ----------
    name : str
    case : AlignmentCase
    judged : list of Judged
    speed : float or None
        [m/s]
    path : path-like
    """
    height = 11.0 if case.irregularity else 8.0
    draw(lambda figure: _panels(figure, name, case, judged, speed), Path(path), (10.0, height))


def _panels(figure, name, case, judged, speed):
    length = judged[-1].end
    edges = case.pieces["start"]
    s = np.union1d(np.linspace(0.0, length, POINTS), edges[(edges >= 0.0) & (edges <= length)])
    found = course(case.pieces, s)
    painters = {"curvature": _curvature, "cant": _cant, "gradient": _gradient, "gauge": _gauge}
    if case.irregularity:
        painters["vertical"] = _irregularity(1, "irregularity\nup [mm]")
        painters["lateral"] = _irregularity(0, "irregularity\nto the right [mm]")
    panels = figure.subplots(len(painters), 1, sharex=True, height_ratios=(1, 1.4, *[1] * (len(painters) - 2)))
    axes = dict(zip(painters, panels, strict=True))
    for key, paint in painters.items():
        paint(axes[key], case, found, speed)
        _mark_sections(axes[key], judged)
    _warn(axes, judged)
    axes["curvature"].set_title(name)
    _name_sections(axes["curvature"], judged, length)
    panels[-1].set_xlabel("s, along the track [m]")
    panels[-1].set_xlim(0.0, length)
    for key, axis in axes.items():
        if axis.get_legend_handles_labels()[0]:
            aside = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
            axis.legend(**({"loc": "best"} if key == "gradient" else aside))


def _curvature(axis, case, found, speed):
    axis.fill_between(found.s, 1e3 * found.curvature, color=BLUE, alpha=0.25, linewidth=0.0)
    axis.plot(found.s, 1e3 * found.curvature, color=BLUE)
    axis.set_ylabel("curvature [1/km]\nright +")
    axis.margins(y=0.4)
    _open(axis, 0.1)


def _cant(axis, case, found, speed):
    axis.plot(found.s, 1e3 * found.cant, color=BLUE, label="cant D")
    if speed:
        balance = 1e3 * case.cant_base * speed**2 * found.curvature / case.gravity
        axis.plot(found.s, balance, color=GREY, linestyle="--", label=f"in balance at {both_units(speed)}")
        axis.fill_between(found.s, 1e3 * found.cant, balance, color=ORANGE, alpha=0.25, linewidth=0.0,
                          label="deficiency, excess")  # fmt: skip
    axis.set_ylabel("cant [mm]\nleft over right rail")
    _open(axis)


def _gradient(axis, case, found, speed):
    axis.plot(found.s, 1e3 * np.tan(found.gradient), color=BLUE, label="gradient")
    axis.set_ylabel("gradient [per mille]\nrising +")
    _open(axis)
    height = -found.place[:, 2]
    if np.ptp(height) > 0.0:
        other = axis.twinx()
        other.grid(False)
        other.spines["right"].set_visible(True)
        other.plot(found.s, height, color=GREY, linestyle="--")
        other.set_ylabel("height of the middle\n[m] (dashed)", color=GREY)


def _gauge(axis, case, found, speed):
    left, right = 1e3 * case.track.shifts(found.s, case.gauge)
    axis.plot(found.s, right - left, color=BLUE, label=f"gauge less {1e3 * case.gauge:g} mm")
    axis.plot(found.s, left, color=SERIES[2], linestyle="--", label="left rail, to the right")
    axis.plot(found.s, right, color=SERIES[1], linestyle=":", label="right rail, to the right")
    axis.set_ylabel("gauge and rails\n[mm]")
    _open(axis)


def _irregularity(direction, label):
    """Painter of the irregularity of both rails: 0 lateral, to the right; 1 vertical, up."""
    up = -1.0 if direction else 1.0

    def paint(axis, case, found, speed):
        s = np.linspace(0.0, found.s[-1], FINE_POINTS)
        right, left = up * 1e3 * case.irregularity(s)[:, direction]
        axis.plot(s, left, color=SERIES[2], linewidth=0.8, label="left rail")
        axis.plot(s, right, color=SERIES[1], linewidth=0.8, linestyle="--", label="right rail")
        axis.set_ylabel(label)
        _open(axis)

    return paint


def _open(axis, least=1.0):
    """Show at least from -least to least, so that what is nearly nothing does not look like something."""
    low, high = axis.get_ylim()
    if high - low < 2.0 * least:
        axis.set_ylim(min(low, -least), max(high, least))


def _mark_sections(axis, judged):
    for one in judged:
        kind = one.kind if one.kind in ("straight", "curve", "measured") else "transition"
        if kind in SHADE:
            axis.axvspan(one.start, one.end, color=GREY, alpha=SHADE[kind], linewidth=0.0, zorder=0)


def _name_sections(axis, judged, length):
    for one in judged:
        if one.end - one.start > LABELLED * length:
            text = f"{one.number} {one.kind}"
            if one.kind == "curve":
                text += f"\nR {1.0 / abs(one.curvature.first):.4g} m"
            axis.text(0.5 * (one.start + one.end), 0.97, text, transform=axis.get_xaxis_transform(), fontsize=7,
                      ha="center", va="top")  # fmt: skip


def _warn(axes, judged):
    named = set()
    for one in judged:
        for found in one.findings:
            panel = PANEL_OF.get(found.key, "cant")
            axes[panel].axvline(found.s, color=VERMILION, linewidth=1.0, linestyle=":",
                                label=None if panel in named else "beyond a limit")  # fmt: skip
            named.add(panel)
