"""Measured alignment of a track: a CSV file whose column names carry their units."""

from pathlib import Path

import numpy as np
from pydantic import ValidationError

from railcli.errors import InputError
from railcli.model.sections import SHARPEST, Measured

from . import toml
from .formats.measured import number, shown

COLUMNS = {  # stem of a column's name: what it is, and its SI unit
    "position": ("position", "m"),
    "s": ("position", "m"),
    "curvature": ("curvature", "1_per_m"),
    "radius": ("radius", "m"),
    "cant": ("cant", "m"),
    "gradient": ("gradient", "m_per_m"),
    "gauge": ("gauge", "m"),
}
REGULAR = 0.9  # of the steps within half of their median: the table has a regular step
GAP = 10.0  # such steps without a position


def read_alignment(path):
    """Section of track from a measured alignment table.

    Parameters
    ----------
    path : path-like
        CSV with a line of names such as ``position_m, curvature_1_per_km, cant_mm``; see docs/scenario.md.

    Returns
    -------
    railcli.model.sections.Measured

    Raises
    ------
    InputError
        One line: file and line, what was found, what is allowed.
    """
    path = Path(path)
    lines = _lines(path)
    if not lines:
        raise InputError(path, "is empty; a line of names and one line for each position are needed")
    (header, names), *body = lines
    separator = next((one for one in (";", "\t") if one in names), ",")
    columns = _columns(f"{path}, line {header}", [name.strip(" \"'") for name in names.split(separator)])
    if len(body) < 2:
        raise InputError(path, f"has {len(body)} positions; at least 2 are needed")
    places = {quantity: place for quantity, place, _ in columns}
    table = {quantity: np.empty(len(body)) for quantity in places}
    for row, (line, text) in enumerate(body):
        fields = text.split(separator)
        for quantity, place, unit in columns:
            field = fields[place].strip() if place < len(fields) else ""
            value = _value(f"{path}, line {line}", quantity, field, separator)
            table[quantity][row] = value * unit.times / unit.over
    _rising(path, table["position"], [line for line, _ in body])
    if "radius" in table:
        table["curvature"] = _curvature(path, table.pop("radius"), [line for line, _ in body])
    try:
        return Measured(**{quantity: tuple(values.tolist()) for quantity, values in table.items()})
    except ValidationError as error:
        raise InputError(path, error.errors()[0]["msg"].removeprefix("Value error, ")) from None


def _lines(path):
    """Numbers and texts of all lines but empty ones and comments."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(path, "no such file") from None
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise InputError(path, "is not a text file in UTF-8") from None
    lines = ((n, line.strip()) for n, line in enumerate(text.splitlines(), start=1))
    return [(n, line) for n, line in lines if line and not line.startswith("#")]


def _columns(where, names):
    """What is known of the columns: quantity, place and unit."""
    found = {}
    for place, name in enumerate(names):
        stem, unit = toml.split_unit(name.lower())
        if stem not in COLUMNS:
            continue
        quantity, si = COLUMNS[stem]
        if unit is None or unit.si != si:
            known = ", ".join(f"{stem}_{key}" for key, one in toml.UNITS.items() if one.si == si)
            raise InputError(where, f"column {name!r} does not end with a unit of {quantity}; write one of: {known}")
        if quantity in found:
            raise InputError(where, f"column {name!r}: {quantity} is given twice; keep one column")
        found[quantity] = (quantity, place, unit)
    if "position" not in found or not {"curvature", "radius"} & set(found):
        raise InputError(
            where,
            f"found {shown(', '.join(names))}; needed are position (position_m) and curvature (curvature_1_per_km) or "
            "radius (radius_m)",
        )
    if {"curvature", "radius"} <= set(found):
        raise InputError(where, "curvature and radius are both given; keep one of them")
    return list(found.values())


def _value(where, quantity, field, separator):
    if quantity == "radius" and field.lower() in ("", "inf", "-inf"):
        return 0.0
    value = number(field.replace(",", ".") if separator != "," else field)
    if value is None:
        fault = "is empty" if not field else f"{shown(field)} is not a number"
        raise InputError(where, f"{quantity} {fault}; fill it in or remove the line")
    return value


def _rising(path, position, lines):
    step = np.diff(position)
    if (step <= 0.0).any():
        k = int(np.argmax(step <= 0.0))
        word = "repeats" if step[k] == 0.0 else "falls"
        raise InputError(
            f"{path}, line {lines[k + 1]}",
            f"position {word}: {position[k + 1]:.10g} m follows {position[k]:.10g} m; positions must rise",
        )
    usual = np.median(step)
    regular = np.mean(np.abs(step - usual) <= 0.5 * usual) >= REGULAR
    if regular and step.max() > GAP * usual:
        k = int(np.argmax(step))
        raise InputError(
            f"{path}, line {lines[k + 1]}",
            f"gap of {step[k]:.6g} m after {position[k]:.10g} m in a table with a step of {usual:.4g} m; fill it, or "
            "make two tables with a transition between them",
        )


def _curvature(path, radius, lines):
    small = (radius != 0.0) & (np.abs(radius) * SHARPEST < 1.0)
    if small.any():
        k = int(np.argmax(small))
        raise InputError(
            f"{path}, line {lines[k]}",
            f"radius of {radius[k]:g} m: must be at least {1.0 / SHARPEST:g} m, or 0 for straight track; check the "
            "unit",
        )
    return np.divide(1.0, radius, out=np.zeros_like(radius), where=radius != 0.0)
