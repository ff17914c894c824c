"""Plain text and CSV: y and z in columns, split as `text_table` says; one line of words may name the columns.

A file of GENSYS (.rail, .wheel) is one in mm with y towards the track centre.
"""

import re

from railcli.errors import InputError

from ..profiles import MOST_POINTS
from ..text_table import content, shown, split_of
from .measured import Measured, points, too_many

UNITS = {"": None, "mm": 1.0, "m": 1000.0, "in": 25.4, "inch": 25.4}
NAME = re.compile(r"([xyz])\W*_?\W*(mm|m|in|inch)?\W*", re.ASCII)


def read(path, text, kind):
    """Two columns or more; see `read_points`."""
    rows, lines, unit, notes = [], [], None, []
    order, split = None, None
    contents = content(text)
    for position, (i, line) in enumerate(contents):
        if split is None:
            one = split_of(line)
            fields = [field for field in one.cells(line) if field]
            if order is None and not any(one.number(field) is not None for field in fields):
                order, unit, notes = _header(path, i, fields)
                continue
            split, order = one, order or (0, 1)
            notes = [*notes, "decimal commas"] if split.comma and "," in line else notes
        fields = split.cells(line)
        found = [split.number(fields[k]) if k < len(fields) else None for k in order]
        if None in found:
            hint = "; the file seems to be cut off here" if position == len(contents) - 1 and rows else ""
            raise InputError(f"{path}, line {i}", f"found {shown(line)}; finite numbers for y and z are needed{hint}")
        rows.append(found)
        lines.append(i)
        if len(rows) > MOST_POINTS:
            raise too_many(path)
    y, z, lines = points(path, rows, lines)
    return Measured(path, "columns", y, z, lines, kind, unit_mm=unit, notes=tuple(notes))


def read_gensys(path, text, kind):
    """Two columns in mm, y towards the track centre; see `read_points`."""
    found = read(path, text, kind)
    return Measured(path, "GENSYS", found.y, found.z, found.lines, kind, 1.0, mirrored=True, notes=found.notes)


def _header(path, line, fields):
    """Columns of y and z, their unit, and notes, from a line of names."""
    names = [NAME.fullmatch(item.strip(" \"'").lower()) for item in fields]
    letters = {match[1]: k for k, match in enumerate(names) if match}
    notes = [f"columns {', '.join(fields)[:60]}"]
    if any("angle" in item for item in fields):
        notes.append("column of angles passed over: tangents are taken from the points")
    if "y" in letters and ("z" in letters or "x" in letters):
        order = (letters["y"], letters["z"]) if "z" in letters else (letters["x"], letters["y"])
        units = {names[k][2] or "" for k in order}
        if len(units) > 1:
            raise InputError(
                f"{path}, line {line}", f"found {', '.join(fields)[:60]!r}; y and z must have the same unit"
            )
        return order, UNITS[units.pop()], notes
    if len(fields) < 2:
        raise InputError(f"{path}, line {line}", f"found {shown(fields[0] if fields else '')}; numbers are needed")
    return (0, 1), None, [*notes, "names not understood: the first column is taken as y, the second as z"]
