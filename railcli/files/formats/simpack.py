"""SIMPACK: rails (.prr) and wheels (.prw).

Lines `keyword = value` in blocks `name.begin` ... `name.end`; what follows ``!`` or ``%`` is a comment. The block
`spline` holds the points, `y z [weight]`, and says what is done to them, in this order: drop points too close to the
one before, shift, rotate, bound y (removes), bound z (clips), mirror, unit, order.
"""

import math

import numpy as np

from railcli.errors import InputError

from ..profiles import MOST_POINTS
from ..text_table import number, shown
from .measured import Measured, points, too_many

KINDS = {0: "rail", 1: "wheel"}
CLOSEST = (1e-4, 1e-6)  # point.dist.min: default and smallest, in the file's unit
DEFAULTS = {
    "point.dist.min": CLOSEST[0],
    "shift.y": 0.0,
    "shift.z": 0.0,
    "rotate": 0.0,
    "bound.y.min": 1.0,
    "bound.y.max": 0.0,
    "bound.z.min": 1.0,
    "bound.z.max": 0.0,
    "mirror.y": 0.0,
    "mirror.z": 0.0,
    "units.len.f": 1000.0,
    "units.ang.f": 1.0,
    "inversion": 0.0,
}
SWITCHES = ("mirror.y", "mirror.z", "inversion")


def read(path, text, kind):
    """A SIMPACK profile; see `read_points`."""
    header, values, rows, lines = _parse(path, text)
    y, z, lines = points(path, rows, lines)
    kind = header.get("type", kind)
    y, z, lines, notes = _processed(path, values, y, z, lines)
    if y.size < 2:
        raise InputError(path, "point.dist.min and bound.y leave fewer than 2 points")
    unit_mm = 1000.0 / values["units.len.f"]
    return Measured(path, "SIMPACK", y, z, lines, kind, unit_mm=unit_mm, notes=tuple(notes))


def _parse(path, text):
    header, values, rows, lines = {}, dict(DEFAULTS), [], []
    blocks, splines, finished = [], 0, False
    for i, line in enumerate(text.splitlines(), start=1):
        line = _without_comment(line)
        if not line:
            continue
        where = f"{path}, line {i}"
        if line.lower().endswith(".begin") and "=" not in line:
            blocks.append(line[:-6].lower())
            splines += blocks[-1] == "spline"
            if splines > 1:
                raise InputError(where, "a second block spline; give one profile per file")
        elif line.lower().endswith(".end") and "=" not in line:
            name = line[:-4].lower()
            if not blocks or blocks.pop() != name:
                raise InputError(where, f"found {shown(line)}, which ends no open block")
            finished |= name == "point"
        elif blocks[-1:] == ["point"]:
            rows.append(_point(where, line))
            lines.append(i)
            if len(rows) > MOST_POINTS:
                raise too_many(path)
        else:
            _key(where, line, blocks, header, values)
    if not finished:
        found = "the block of points does not end: the file was cut off" if "point" in blocks else "no block of points"
        raise InputError(path, f"{found}; point.begin ... point.end are needed")
    return header, values, rows, lines


def _without_comment(line):
    """The line up to the first comment character outside quotes."""
    quoted = False
    for i, character in enumerate(line):
        if character == "'":
            quoted = not quoted
        elif character in "!%" and not quoted:
            return line[:i].strip()
    return line.strip()


def _point(where, line):
    fields = line.replace(",", " ").split()
    found = [number(item) for item in fields]
    if len(found) not in (2, 3) or None in found:
        raise InputError(where, f"found {shown(line)}; y, z and perhaps a weight are needed")
    return found[:2]


def _key(where, line, blocks, header, values):
    key, equals, value = (item.strip() for item in line.partition("="))
    key = key.lower()
    if not equals:
        raise InputError(where, f"found {shown(line)}; keyword = value, name.begin or name.end is needed")
    found = number(value)
    if blocks[-1:] == ["header"] and key == "type":
        if found not in KINDS:
            raise InputError(where, f"type is {shown(value)}; 0 (rail) or 1 (wheel) is needed")
        header["type"] = KINDS[found]
    elif blocks[-1:] == ["spline"] and key in values:
        if found is None or (key.startswith("units") and found <= 0.0) or (key in SWITCHES and found not in (0, 1)):
            allowed = "0 or 1" if key in SWITCHES else "a positive number" if key.startswith("units") else "a number"
            raise InputError(where, f"{key} is {shown(value)}; {allowed} is needed")
        values[key] = found


def _processed(path, values, y, z, lines):
    notes = []
    closest = max(values["point.dist.min"], CLOSEST[1])
    keep = _far_enough(y, z, closest)
    if not keep.all():
        notes.append(
            f"point.dist.min: {np.count_nonzero(~keep)} points closer than {closest:g} to the one before left out"
        )
    y, z, lines = y[keep], z[keep], lines[keep]
    if values["shift.y"] or values["shift.z"]:
        notes.append(f"shift.y = {values['shift.y']:g}, shift.z = {values['shift.z']:g} added")
    y, z = y + values["shift.y"], z + values["shift.z"]
    if values["rotate"]:
        angle = values["rotate"] / values["units.ang.f"]
        c, s = math.cos(angle), math.sin(angle)
        y, z = c * y - s * z, s * y + c * z
        notes.append(f"rotate = {values['rotate']:g}: turned by {angle:.6g} rad from y towards z; check this sense")
    if values["bound.y.min"] < values["bound.y.max"]:
        keep = (y >= values["bound.y.min"]) & (y <= values["bound.y.max"])
        notes.append(f"bound.y: {np.count_nonzero(~keep)} points outside left out")
        y, z, lines = y[keep], z[keep], lines[keep]
    if values["bound.z.min"] < values["bound.z.max"]:
        clipped = np.clip(z, values["bound.z.min"], values["bound.z.max"])
        notes.append(f"bound.z: {np.count_nonzero(clipped != z)} points clipped")
        z = clipped
    for axis, array in (("y", y), ("z", z)):
        if values[f"mirror.{axis}"]:
            array *= -1.0
            notes.append(f"mirror.{axis} = 1: {axis} multiplied by -1")
    if values["inversion"]:
        y, z, lines = y[::-1], z[::-1], lines[::-1]
        notes.append("inversion = 1: order reversed")
    return y, z, lines, notes


def _far_enough(y, z, closest):
    keep = np.ones(y.size, dtype=bool)
    last = 0
    for i in range(1, y.size):
        if math.hypot(y[i] - y[last], z[i] - z[last]) < closest:
            keep[i] = False
        else:
            last = i
    return keep
