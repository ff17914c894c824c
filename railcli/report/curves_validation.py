"""`railcli validate curves` as text, JSON, CSV and figures."""

import numpy as np

from railcli.analysis.curving_check import KINDS, NOMINAL
from railcli.analysis.decay_check import HUNTING

from .criteria import criteria_json, criteria_lines, document, verdict, verdict_line
from .figures import BLUE, GREEN, GREY, ORANGE, VERMILION, draw
from .text import columns, facts, sectioned

TITLE = "Tight curve and hunting against other programs"
FIGURES = ("curve-150", "cooperrider")
LEADING = (("Y outer", 1), ("Y inner", 1))


def _laws(scenario):
    return f"creep {scenario.contact.creep_law}, normal {scenario.contact.normal}"


def assumptions(result):
    """What is given, inferred and assumed."""
    curve, wagon = result.curves[NOMINAL].scenario, result.wagon.scenario
    bend, contact = curve.track.sections[-1], curve.contact
    return [
        ("R 150 m, inferred", f"R = {bend.radius:g} m, cant {bend.cant * 1e3:g} mm, {curve.run.speed:g} m/s: from the "
                              "balances of the printed forces"),
        ("R 150 m, assumed", f"friction {contact.friction:.2f} and 1:{contact.inclination:g} (the benchmark's), gauge "
                             f"{contact.gauge * 1e3:g} mm, {_laws(curve)}"),
        ("Cooperrider, given", f"vehicle, friction {wagon.contact.friction:g}, creep law; rail and wheel follow from "
                               "its contact table"),
        ("Cooperrider, assumed", _laws(wagon)),
    ]  # fmt: skip


def curve_text(result):
    """The printed values beside railcli's nominal ones."""
    codes, curve = result.references.codes, result.curves[NOMINAL]
    rows = []
    for quantity, wheelset, (first, second), ours in zip(
        codes.quantity, codes.wheelset, codes.values, curve.values, strict=True
    ):
        cells = (f"{value:.1f}" if np.isfinite(value) else "-" for value in (first, second))
        away = (f"{ours - value:+.2f}" if np.isfinite(value) else "" for value in (first, second))
        rows.append((quantity, f"W{wheelset}", *cells, f"{ours:.2f}", *away))
    header = ("mm, kN", "", *codes.names, "railcli", *(f"- {name}" for name in codes.names))
    lines = columns(rows, header)
    for name, (found, expected) in (("sum Y", curve.sum_y), ("sum Q", curve.sum_q)):
        printed = [_sum_of(codes, k, name[-1]) for k in (0, 1)]
        lines.append(
            f"  {name} {found:.2f} kN, balance {expected:.2f}; "
            + ", ".join(f"{code} {value:.1f}" for code, value in zip(codes.names, printed, strict=True))
        )
    return lines


def _sum_of(codes, k, kind):
    return float(codes.values[codes.of(kind), k].sum())


def variations_text(result):
    """Largest distance from the nearer code by kind, and Y of W1, over what the table leaves open."""
    codes = result.references.codes
    printed = (" / ".join(f"{value:.1f}" for value in codes.values[codes.place(*key)]) for key in LEADING)
    rows = [("spread of the codes", *(f"{codes.spread(kind):.2f}" for kind in KINDS), *printed)]
    for name, curve in result.curves.items():
        if curve.exists:
            away = (f"{curve.nearest(codes, kind):.2f}" for kind in KINDS)
            rows.append((name, *away, *(f"{curve.values[codes.place(*key)]:.2f}" for key in LEADING)))
        else:
            rows.append((name, *("none" for _ in KINDS), *("" for _ in LEADING)))
    header = ("from the nearer code, largest", *(f"{kind} {unit}" for kind, unit in KINDS.items()),
              *(f"W1 {quantity}" for quantity, _ in LEADING))  # fmt: skip
    return columns(rows, header)


def contact_text(result):
    """Contact of the wheel that was found, beside the published table."""
    decays, found = result.references.decays, result.wagon.contact
    rows = []
    for y in (-4.5, -2.5, 0.0, 1.1, 2.2, 3.0, 4.2, 4.88, 5.8):
        i = int(np.argmin(np.abs(decays.y - y * 1e-3)))
        rows.append((
            f"{decays.y[i] * 1e3:.2f}", f"{decays.on_wheel[i] * 1e3:.2f}", f"{found[i, 0] * 1e3:.2f}",
            f"{decays.radius[i] * 1e3:.3f}", f"{found[i, 1] * 1e3:.3f}", f"{decays.angle[i]:.4f}", f"{found[i, 2]:.4f}",
        ))  # fmt: skip
    return columns(rows, ("y [mm]", "place", "railcli", "radius", "railcli", "angle", "railcli"))


def decay_text(result):
    """Rates and frequencies of the bogie mode, swings, and where hunting persists."""
    decays, wagon = result.references.decays, result.wagon
    rows = []
    for k, speed in enumerate(decays.speed):
        rows.append((
            f"{speed:g}", f"{decays.rate[k]:.2f}", f"{wagon.rate[k]:.2f}", f"{wagon.corrected[k]:.2f}",
            f"{decays.frequency[k]:.2f}", f"{wagon.frequency[k]:.2f}",
        ))  # fmt: skip
    header = ("m/s", "rate 1/s", "railcli, its moments", "right moments", "f Hz", "railcli")
    lines = columns(rows, header)
    its, right = (f"{value:.1f} m/s" if np.isfinite(value) else "none" for value in wagon.critical)
    lines += [
        "  its moments: the gyroscopic moments of the published program (SOURCES.md, [D]), in the linear model",
        f"  linear critical speed: {its} with its moments, {right} with the right ones",
    ]
    rows = [(f"{speed:g}", f"{1e3 * theirs:.2f}", f"{1e3 * ours:.2f}")
            for speed, theirs, ours in zip(decays.swing_speed, decays.swing, wagon.swing, strict=True)]  # fmt: skip
    lines += columns(rows, ("m/s", "half swing 1 to 3 s [mm]", "railcli, time runs"))
    rows = [(f"{speed:g}", f"{1e3 * early:.2f}", f"{1e3 * late:.2f}")
            for speed, early, late in zip(HUNTING, wagon.early, wagon.late, strict=True)]  # fmt: skip
    return lines + columns(rows, ("m/s", "half swing in the 3rd second [mm]", "in the 8th"))


def wide_text(result):
    """R = 1200 m beside it."""
    rows = [(name, *(f"{found[key]:.2f}" for key in ("rms_simulink_mm", "rms_adams_mm", "max_mm")))
            for name, found in result.wide.items()]  # fmt: skip
    return columns(rows, ("R = 1200 m, 1:20, displacements [mm]", "rms Simulink", "rms ADAMS", "largest"))


def report(result):
    """Titles and lines of the whole report, for the terminal and for validation.md."""
    return [
        ("Assumptions", facts(assumptions(result))),
        ("R = 150 m: displacements outwards [mm] and forces [kN], steady motion", curve_text(result)),
        ("R = 150 m: what the published table leaves open", variations_text(result)),
        ("Cooperrider wagon: contact [mm, rad]", contact_text(result)),
        ("Cooperrider wagon: decay and hunting", decay_text(result)),
        ("The curve of 1200 m (validate manchester) by the same laws", wide_text(result)),
        ("Criteria", criteria_lines(result.rows)),
    ]


def as_json(result, provenance):
    """The whole comparison as one object."""
    codes, decays, wagon = result.references.codes, result.references.decays, result.wagon
    return {
        "verdict": verdict(result.rows),
        "criteria": criteria_json(result.rows),
        "assumptions": dict(assumptions(result)),
        "curve_150": records(result),
        "variations": {
            name: {
                **{f"{kind}_from_nearer_{unit}": curve.nearest(codes, kind) for kind, unit in KINDS.items()},
                "values": curve.values.tolist(),
            }
            for name, curve in result.curves.items()
        },
        "cooperrider": {
            "swing": [
                {"speed_m_per_s": speed, "published_mm": theirs, "railcli_mm": ours}
                for speed, theirs, ours in np.transpose(
                    [decays.swing_speed, 1e3 * decays.swing, 1e3 * wagon.swing]
                ).tolist()
            ],
            "decay": [
                dict(zip(("speed_m_per_s", "published_1_per_s", "published_Hz", "railcli_1_per_s", "railcli_Hz",
                          "right_moments_1_per_s"), row, strict=True))
                for row in np.transpose([decays.speed, decays.rate, decays.frequency, wagon.rate, wagon.frequency,
                                         wagon.corrected]).tolist()
            ],
            "hunting": [
                {"speed_m_per_s": speed, "third_second_mm": 1e3 * early, "eighth_second_mm": 1e3 * late}
                for speed, early, late in zip(HUNTING, wagon.early.tolist(), wagon.late.tolist(), strict=True)
            ],
            "critical_m_per_s": dict(zip(("its_moments", "right_moments"), wagon.critical, strict=True)),
        },
        "curve_1200": result.wide,
        "provenance": provenance,
    }  # fmt: skip


def records(result):
    """One record for each printed value of the curve of 150 m."""
    codes, curve = result.references.codes, result.curves[NOMINAL]
    return [
        {"quantity": quantity, "wheelset": wheelset, "unit": KINDS[quantity[0]],
         **dict(zip((name.lower() for name in codes.names), row, strict=True)), "railcli": ours}
        for quantity, wheelset, row, ours in zip(
            codes.quantity, codes.wheelset, codes.values.tolist(), curve.values.tolist(), strict=True
        )
    ]  # fmt: skip


def csv(result):
    """The curve of 150 m as CSV; columns as `records`, a value that does not exist left empty."""
    rows = records(result)
    lines = [",".join(rows[0])]
    for row in rows:
        cells = (f"{value:.6g}" if isinstance(value, float) else str(value) for value in row.values())
        lines.append(",".join("" if cell == "nan" else cell for cell in cells))
    return "\n".join(lines) + "\n"


def terminal(sections, result):
    """The report for a terminal."""
    return sectioned(TITLE, sections, verdict_line(result.rows))


def markdown(sections, result, origin, figures=True):
    """The report as validation.md."""
    return document(TITLE, verdict_line(result.rows), sections, FIGURES if figures else (), origin)


def figures(result, folder):
    """Draw curve-150.png and cooperrider.png."""
    draw(lambda figure: _curve(figure, result), folder / "curve-150.png", (11.0, 6.5))
    draw(lambda figure: _wagon(figure, result), folder / "cooperrider.png", (11.0, 4.0))


def _curve(figure, result):
    codes = result.references.codes
    found = np.array([curve.values for curve in result.curves.values()])
    panels = list(dict.fromkeys(codes.quantity))
    axes = figure.subplots(2, 4)
    axes[1, 0].remove()
    places = dict(zip(panels, [axes[0, 0], *axes[0, 1:], *axes[1, 1:]], strict=True))
    order = [panels[0], *(f"{kind} outer" for kind in "XYQ"), *(f"{kind} inner" for kind in "XYQ")]
    for quantity, axis in zip(order, places.values(), strict=True):
        rows = [i for i, name in enumerate(codes.quantity) if name == quantity]
        at = np.array([codes.wheelset[i] for i in rows])
        low, high = np.nanmin(found[:, rows], axis=0), np.nanmax(found[:, rows], axis=0)
        axis.vlines(at, low, high, color=BLUE, alpha=0.3, linewidth=9.0, label="railcli, variations")
        axis.plot(at, result.curves[NOMINAL].values[rows], "o", color=BLUE, markersize=4, label="railcli, nominal")
        for k, (colour, marker) in enumerate(((ORANGE, "s"), (GREEN, "^"))):
            axis.plot(at, codes.values[rows, k], marker, color=colour, markersize=5, fillstyle="none",
                      label=codes.names[k])  # fmt: skip
        if quantity[0] != "Q":
            axis.axhline(0.0, color=GREY, linewidth=0.6)
        axis.set_title(f"{quantity} [{KINDS[quantity[0]]}]")
        axis.set_xticks(at, [f"W{i}" for i in at])
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.02, 0.15))


def _wagon(figure, result):
    decays, wagon = result.references.decays, result.wagon
    left, middle, right = figure.subplots(1, 3)
    near = np.isfinite(wagon.contact[:, 1])
    y = 1e3 * decays.y[near]
    left.plot(y, 1e3 * decays.radius[near], "o", color=VERMILION, markersize=3, label="published table")
    left.plot(y, 1e3 * wagon.contact[near, 1], color=BLUE, label="railcli")
    left.set_title("Rolling radius of one wheel")
    left.set_xlabel("y [mm]")
    left.set_ylabel("[mm]")
    middle.semilogy(decays.swing_speed, 1e3 * decays.swing, "o", color=VERMILION, label="published program")
    middle.semilogy(decays.swing_speed, 1e3 * wagon.swing, ".-", color=BLUE, label="railcli, time runs")
    middle.set_title("Half swing of W1, 1 to 3 s")
    middle.set_xlabel("speed [m/s]")
    middle.set_ylabel("[mm]")
    right.plot(decays.speed, decays.rate, "o", color=VERMILION, label="published program")
    right.plot(decays.speed, wagon.rate, ".-", color=BLUE, label="railcli, its gyroscopic moments")
    right.plot(decays.speed, wagon.corrected, ".--", color=GREEN, label="railcli, the right ones")
    right.axhline(0.0, color=GREY, linewidth=0.6)
    right.set_title("Rate of the bogie mode")
    right.set_xlabel("speed [m/s]")
    right.set_ylabel("[1/s]")
    for axis in (left, middle, right):
        axis.legend()
