"""What scenarios, vehicles and results show of themselves in a notebook: tables and a small figure, as HTML."""

import base64
import html
import tempfile
from pathlib import Path

from railcli.files import results as result_files
from railcli.model.vehicle import static_wheel_loads

from .figures import GREY, draw
from .run import track_strip
from .text import conditions
from .vehicle_facts import axle_rows, body_rows, total_rows
from .vehicle_figure import side

TAPE_CIRCLE, GRAVITY = 0.75, 9.81  # of a vehicle that no scenario has put anywhere yet [m], [m/s^2]
WIDE, DPI = (7.0, 2.2), 90


def vehicle(model):
    """HTML of a Vehicle: bodies, axle loads, a drawing from the side."""
    loads = static_wheel_loads(model, GRAVITY, TAPE_CIRCLE)
    return _page(
        model.name,
        _paragraph(model.description),
        _picture(lambda figure: side(figure.subplots(), model, TAPE_CIRCLE), WIDE),
        _table(total_rows(model, loads, GRAVITY)),
        _table(body_rows(model)),
        _table(axle_rows(model, loads)),
    )


def scenario(model):
    """HTML of a Scenario: its conditions, its track, its vehicle in a line."""
    rows = [
        ("", ""),
        *conditions(model),
        ("wheel on rail", f"{model.contact.wheel_profile} on {model.contact.rail_profile}"),
        ("run", f"{model.distance:.6g} m, {model.duration:.4g} s"),
        ("vehicle", f"{model.vehicle.name}, {sum(body.mass for body in model.vehicle.bodies) / 1e3:.4g} t"),
        ("irregularity", ", ".join(source.kind for source in model.irregularity) or "none"),
    ]

    def strip(figure):
        axis = figure.subplots()
        track_strip(axis, [], model, model.distance)
        axis.set_xlabel("arc length [m]")

    return _page(model.title or model.name, _paragraph(model.description), _picture(strip, (7.0, 1.4)), _table(rows))


def results(folder, summary):
    """HTML of a results folder: conditions, end and steady values, wheelsets over the distance."""
    keys = ("speed_m_per_s", "friction", "creep_law", "normal", "time_s", "distance_m", "rows", "fault")
    rows = [("", ""), *((key, _value(summary[key])) for key in keys if summary.get(key) not in (None, ""))]
    steady = summary.get("steady", {}).get("mean", {})
    columns = [(key, values) for key, values in steady.items() if key.endswith(("_mm", "_mrad"))]
    table = [("", *(key for key, _ in columns))]
    count = len(columns[0][1]) if columns else 0
    table += [(f"W{k + 1}", *(f"{values[k]:.3f}" for _, values in columns)) for k in range(count)]
    main = result_files.envelope(folder / result_files.TIME_SERIES)

    def paint(figure):
        axis = figure.subplots()
        axis.plot(main.distance, 1e3 * main.lateral, label=[f"W{k + 1}" for k in range(main.lateral.shape[1])])
        axis.axhline(0.0, color=GREY, linewidth=0.5)
        axis.set_xlabel("arc length of the first body [m]")
        axis.set_ylabel("y [mm]")
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))

    title = summary.get("title") or summary.get("scenario") or folder.name
    return _page(title, _paragraph(str(folder)), _picture(paint, WIDE), _table(rows), _table(table) if count else "")


def _value(value):
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _page(title, *parts):
    return f"<div><h4>{html.escape(title)}</h4>{''.join(parts)}</div>"


def _paragraph(text):
    return f"<p>{html.escape(text)}</p>" if text else ""


def _table(rows):
    """The first row is the head."""
    lines = []
    for k, row in enumerate(rows):
        tag = "th" if k == 0 else "td"
        lines.append(f"<tr>{''.join(f'<{tag}>{html.escape(str(cell))}</{tag}>' for cell in row)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def _picture(painter, size):
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "figure.png"
        draw(painter, path, size, DPI)
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="" src="data:image/png;base64,{data}">'
