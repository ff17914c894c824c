"""`railcli validate braking` as text, JSON, CSV and figures."""

import numpy as np

from railcli.analysis.braking_check import LOAD, PATCH
from railcli.analysis.ledger import LOSSES

from .criteria import criteria_json, criteria_lines, document, verdict, verdict_line
from .figures import BLUE, GREY, SERIES, VERMILION, draw
from .text import columns, sectioned

TITLE = "Brakes, adhesion and slide protection against closed forms and published tables"
FIGURES = ("stops", "creep-force", "load-transfer")
WHY = [
    "  The reduced model has what the table has: one load and one ellipse for all wheels, no suspension. The wagon",
    "  transfers load to its leading axles and bogie, so that the trailing axles slide first and the leading ones use",
    "  more; its ellipses follow load and profiles; its wheels roll on the radius of their contact, not of the tape",
    "  circle. Distance counts to standstill of the car body.",
]


def _cell(value, form):
    return "-" if value is None or np.isnan(value) else form.format(value)


def stops_text(result):
    """Table of the stops: published, reduced model, whole wagon."""
    rows = [("", "m", "m", "%", "m", "%", "s", "s", "s", "s")]
    for name, (published, reduced, whole) in result.stops.items():
        rows.append(
            (
                name, f"{published.distance:.1f}", f"{reduced.distance:.2f}",
                f"{100 * (reduced.distance / published.distance - 1):+.3f}", f"{whole.distance:.1f}",
                f"{100 * (whole.distance / published.distance - 1):+.2f}", f"{published.time:.2f}",
                f"{reduced.time:.2f}", f"{whole.time:.2f}", f"{whole.locked.max():.1f}",
            )
        )  # fmt: skip
    header = ("stop", "table", "reduced", "off", "wagon", "off", "table", "reduced", "wagon", "locked")
    return [*columns(rows, header), *WHY]


def energy_text(result):
    """Shares of the initial kinetic energy."""
    rows = []
    for name, (published, reduced, whole) in result.stops.items():
        start = whole.ledger.start
        rows.append(
            (
                name, _cell(100 * published.creep, "{:.3g}"), f"{100 * reduced.creep_share:.3f}",
                *(f"{100 * whole.ledger.losses[key] / start:.3f}" for key in LOSSES if key != "resistance_loss"),
                f"{100 * whole.ledger.share:+.4f}", _cell(published.vents, "{:.0f}"), f"{reduced.vents}",
                f"{whole.vents}",
            )
        )  # fmt: skip
    header = ("% of kinetic energy", "creep, table", "reduced", "creep, wagon", "brakes", "suspension", "contact",
              "unbooked", "vents, table", "reduced", "wagon")  # fmt: skip
    return columns(rows, header)


def sections_of(result):
    """Titles and lines."""
    closed = [(name, f"{found:.3f}", f"{wanted:.3f}") for name, found, wanted in result.closed]
    spots = [
        (f"{name}, {speed:g} m/s", *(f"{one:.5f}" for one in found)) for speed, name, _, _, found in result.polach
    ]
    creepages = result.polach[0][2]
    weights = [
        (f"{p:g} %", f"{3.6 * v:.0f}", f"{wanted:.1f}", f"{found:.2f}", _cell(up, "{:.1f}"), f"{risen:.1f}")
        for p, v, wanted, found, up, risen in result.percentages
    ]
    transfer = [(f"W{k}", *(f"{one:+.3f}" for one in row)) for k, *row in result.transfer]
    most, before, after = result.circle
    return [
        ("Closed forms [m]", columns(closed, ("reduced model", "found", "closed form"))),
        ("Stops", stops_text(result)),
        ("Energy", energy_text(result)),
        (
            f"Creep force over load of the law (Q {LOAD:.0f} N, ellipse {1e3 * PATCH.semi_x:g} by "
            f"{1e3 * PATCH.semi_y:g} mm)",
            columns(spots, ("creepage", *(f"{100 * one:g} %" for one in creepages))),
        ),
        (
            f"Axle loads under {result.deceleration:.3f} m/s^2 [kN per m/s^2]",
            columns(transfer, ("axle", "stiff rods", "wagon", "closed form")),
        ),
        (
            "Braking in a curve of 500 m",
            [
                f"  largest creep force of a patch over its friction circle: {most:.6f}",
                "  lateral displacement of W1 .. W4 towards the outer rail, rolling and braking, at one place [mm]:",
                *(f"    {word} " + " ".join(f"{1e3 * one:+.2f}" for one in values)
                  for word, values in (("rolling", before), ("braking", after))),  # fmt: skip
            ],
        ),
        ("Braked weight (ETCS conversion model)",
         columns(weights, ("", "km/h", "distance m", "found", "build-up m", "found"))),
        ("Criteria", criteria_lines(result.rows)),
    ]  # fmt: skip


def terminal(sections, result):
    return sectioned(TITLE, sections, verdict_line(result.rows))


def as_json(result, origin):
    """What validation.json holds."""
    return {
        "title": TITLE,
        "verdict": verdict(result.rows),
        "criteria": criteria_json(result.rows),
        "stops": {
            name: {
                "published_m": published.distance,
                "published_s": published.time,
                "reduced_m": reduced.distance,
                "reduced_s": reduced.time,
                "wagon_m": whole.distance,
                "wagon_s": whole.time,
                "wagon_locked_s": whole.locked,
                "wagon_unbooked": whole.ledger.share,
            }
            for name, (published, reduced, whole) in result.stops.items()
        },
        "load_transfer_kN_per_m_per_s2": [
            {"axle": k, "stiff_rods": stiff, "wagon": found, "expected": wanted}
            for k, stiff, found, wanted in result.transfer
        ],
        "provenance": origin,
    }


def csv(result):
    lines = ["scenario,table_m,reduced_m,wagon_m,table_s,reduced_s,wagon_s"]
    for name, (published, reduced, whole) in result.stops.items():
        values = (published.distance, reduced.distance, whole.distance, published.time, reduced.time, whole.time)
        lines.append(",".join([name, *(f"{value:.6g}" for value in values)]))
    return "\n".join(lines) + "\n"


def markdown(sections, result, origin, figures):
    return document(TITLE, verdict_line(result.rows), sections, FIGURES if figures else (), origin)


def figures(result, folder):
    """Draw the stops, the creep force and the load transfer."""
    draw(lambda figure: _stops(figure, result), folder / "stops.png", (9.0, 4.5))
    draw(lambda figure: _creep(figure, result), folder / "creep-force.png", (8.0, 4.5))
    draw(lambda figure: _transfer(figure, result), folder / "load-transfer.png", (6.0, 3.5))


def _stops(figure, result):
    axis, names = figure.subplots(), list(result.stops)
    place = np.arange(len(names))
    table, reduced, whole = (np.array([one[k].distance for one in result.stops.values()]) for k in range(3))
    for shift, values, label, colour in (
        (-0.27, table, "table", GREY), (0.0, reduced, "reduced model", BLUE), (0.27, whole, "whole wagon", VERMILION),
    ):  # fmt: skip
        axis.bar(place + shift, values, width=0.25, label=label, color=colour)
    for k, (one, other) in enumerate(zip(table, whole, strict=True)):
        axis.text(place[k] + 0.27, other, f"{100 * (other / one - 1):+.2f} %", ha="center", va="bottom", fontsize=7)
    axis.set_xticks(place, names, rotation=15, ha="right")
    axis.set_ylabel("distance to standstill [m]")
    axis.legend()
    axis.set_title("Stops")


def _creep(figure, result):
    axis = figure.subplots()
    for k, (speed, name, creepages, published, found) in enumerate(result.polach):
        axis.plot(100 * creepages, found, color=SERIES[k], label=f"{name}, {speed:g} m/s")
        axis.plot(100 * creepages, published, "o", color=SERIES[k], markersize=4)
    axis.set_xscale("log")
    axis.set_xlabel("creepage [%]")
    axis.set_ylabel("creep force over load [-]")
    axis.set_title("Creep force; circles: published table")
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _transfer(figure, result):
    axis = figure.subplots()
    numbers, _, found, wanted = map(np.array, zip(*result.transfer, strict=True))
    axis.bar(numbers - 0.18, wanted, width=0.34, color=GREY, label="closed form, stiff rods")
    axis.bar(numbers + 0.18, found, width=0.34, color=VERMILION, label="wagon")
    axis.set_xticks(numbers, [f"W{k}" for k in numbers])
    axis.set_ylabel("axle load [kN per m/s$^2$]")
    axis.axhline(0.0, color="black", linewidth=0.6)
    axis.set_title("Load transfer under braking")
    axis.legend()
