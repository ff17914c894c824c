"""Profiles of rails and wheels: bundled ones by name, others from text files.

A file has two columns, y and z, or three with the tangent angle atan2(dz, dy) in radian; separated by comma,
semicolon, blanks or tabs. Lines that start with ``#``, ``!`` or ``%`` are comments. One line before the data may name
the columns (`y_mm` or `y_m`, `z_mm` or `z_m`, `angle_rad`); otherwise y and z are in mm. A comment ``# inclination:
included`` or ``# inclination: upright`` says how a rail stands in the file, ``# tape circle: 73.8 mm from the flange
back`` from where y of a wheel counts. Axes as in `railcli.model.profile`: y to the field side, z down. Points may run
either way along the curve. Nothing is repaired: what does not fit is an error, except that a point which repeats the
one before it exactly is passed over.
"""

import difflib
import logging
import math
import os
import re
import shlex
import warnings
from pathlib import Path

import numpy as np

from railcli.errors import InputError, RailcliWarning
from railcli.files.resources import BUNDLED, resource
from railcli.model.polyline import meeting as _meeting
from railcli.model.polyline import turns
from railcli.model.profile import TAPE_LIMITS, Profile

from .text_table import LARGEST_NUMBER, content, shown, split_of
from .user_file import plain_text, title_of

LARGEST_FILE_MB = 10
FEWEST_POINTS, MOST_POINTS = 10, 20_000
MOST_LINES = 100_000
WIDTH_MM = {"rail": (57.0, 87.0), "wheel": (60.0, 200.0)}  # a rail's head: 72 mm +- 15 mm
CURVE_MM = (5.0, 500.0)  # length of the curve
BACK_MM = 0.02  # a step back in y that passes as noise of a measurement
OVERHANG = 3.0  # |dz| / |dy| from which a step back in y passes as a face that overhangs
SHARPEST_TURN = math.radians(120.0)  # between neighbouring chords
FLANGE_MM = (15.0, 45.0)  # flange height
TIP_MM = (-70.0, -35.0)  # y of the flange tip
TAPE_MM = 0.5  # |z| of a wheel at the tape circle
ANGLE_OFF = 0.5  # tangent angle against the chords on both sides [rad]
UNITS = {"mm": 1.0, "inches": 25.4, "metres": 1000.0, "centimetres": 10.0, "micrometres": 0.001}  # in mm
COLUMNS = {"y_mm": ("y", 1.0), "z_mm": ("z", 1.0), "y_m": ("y", 1e3), "z_m": ("z", 1e3), "angle_rad": ("angle", 1.0)}
WITHOUT_HEADER = ("y_mm", "z_mm", "angle_rad")
STANDS = {"included": True, "upright": False}  # what a file may say of a rail's inclination
LEAN = math.radians(0.5)  # of a head, from which it may be inclined already
_TAPE = re.compile(r"[#!%]\s*tape circle\s*:\s*([0-9.]+)\s*mm from the flange back\s*", re.IGNORECASE)
_INCLINATION = re.compile(r"[#!%]\s*inclination\s*:\s*(.*?)\s*", re.IGNORECASE)


def load_profile(name_or_path, kind):
    """The profile of a bundled name (upper or lower case) or of a file, checked.

    A file of a measuring device or of another program is imported with default decisions; that is told
    to the logger `railcli`, which the command shows on stderr.

    Parameters
    ----------
    name_or_path : str or path
        `UIC60`, `60E1`, `ORES1002`, a file as the module describes, or one that `formats` reads.
    kind : "rail" or "wheel"

    Raises
    ------
    InputError
        In one line: file and line, what was found, what is allowed, what to do.
    """
    given = os.fspath(name_or_path)
    name = {bundled.lower(): bundled for bundled in BUNDLED}.get(given.lower())
    if name is None:
        return _of_file(Path(given), kind)
    if BUNDLED[name][0] != kind:
        raise InputError(name, f"this is a {BUNDLED[name][0]} profile, but a {kind} is needed: give {_choices(kind)}")
    return _read(resource(BUNDLED[name][1]), name, kind)


def canonical(path, kind):
    """The profile of a file in the canonical form; errors as `load_profile`."""
    return _read(Path(path), title_of(path), kind)


def _of_file(path, kind):
    """The profile of a file, imported where it is of a known format that is not the canonical one."""
    from . import profile_import  # only now: it builds on this module

    text = _text(path, kind)
    if profile_import.is_foreign(path, text):
        imported = profile_import.import_profile(path, profile_import.ImportSettings(kind=kind))
        logging.getLogger("railcli").info(profile_import.told(imported.account))
        return imported.profile
    try:
        return canonical(path, kind)
    except InputError as error:
        if profile_import.can_import(path, kind):
            command = f"railcli profile import {shlex.quote(str(path))}"
            raise error.and_so(f"; or convert it: `{command}`") from None
        raise


def profile_of(scenario, place, kind):
    """The profile that a scenario calls `place`: as it knows it already, else as `load_profile`."""
    known = scenario.contents.get(place)
    return load_profile(place, kind) if known is None else known


def settings_on(rails, settings, asked=None):
    """Settings for rails, whose inclination is 0 where all of them include it.

    A rail whose head leans by itself and is inclined besides, though its file does not say that it is upright, is told
    by a warning.

    Parameters
    ----------
    rails : sequence of Profile
    settings : TableSettings
    asked : float, optional
        Inclination that the user gave by word: an InputError if no rail takes it.
    """
    if asked and all(rail.inclined for rail in rails):
        raise InputError(
            rails[0].name, f"includes its inclination, as its file says: leave out inclination {asked:g}, or give 0"
        )
    for rail in dict.fromkeys(rails):
        if settings.inclination and rail.inclined is None and rail.lean > LEAN:
            given = math.degrees(math.atan(1.0 / settings.inclination))
            warnings.warn(
                f"rail {rail.name}: its head leans by {math.degrees(rail.lean):.2f} degrees to the gauge side "
                f"in the file and is inclined by 1:{settings.inclination:g} ({given:.2f} degrees) besides; if it "
                "includes its inclination, write '# inclination: included' into the file or give inclination 0, else "
                "'# inclination: upright'",
                RailcliWarning,
                stacklevel=2,
            )
    return settings.on(*rails)


def stated_inclination(text, path):
    """`included` or `upright`, as a comment of a rail's file says; None if none does."""
    for number, line in enumerate(text.splitlines(), start=1):
        if found := _INCLINATION.fullmatch(line.strip()):
            word = found[1].lower()
            if word not in STANDS:
                raise InputError(
                    f"{path}, line {number}",
                    f"says inclination: {word[:40]!r}; allowed: included (the points are those of the inclined rail) "
                    "or upright; correct it or take the line out",
                )
            return word
    return None


def stated_tape(text, path):
    """Distance of a wheel's tape circle from its flange back, as a comment of its file says [m]; None if none does."""
    for number, line in enumerate(text.splitlines(), start=1):
        if found := _TAPE.fullmatch(line.strip()):
            return checked_tape(float(found[1]) / 1e3 if _is_number(found[1]) else 0.0, f"{path}, line {number}")
    return None


def checked_tape(tape, place):
    """A distance of the tape circle from the flange back [m], if it is allowed; else an InputError."""
    low, high = TAPE_LIMITS
    if not low <= tape <= high:
        raise InputError(
            place, f"tape circle {tape * 1e3:g} mm from the flange back; allowed: {low * 1e3:g} to {high * 1e3:g} mm"
        )
    return tape


def check_curve(path, kind, y, z, lines, unit_mm=1.0):
    """Raise an InputError unless the points are those of a rail or wheel in the canonical form.

    Parameters
    ----------
    path : path-like
        Named in the message, with the line of the point at fault.
    kind : "rail" or "wheel"
    y, z : array (n,)
        Points from the gauge side to the field side [mm].
    lines : array (n,)
        Line number of each point.
    unit_mm : float
        Unit of the file's numbers [mm].
    """
    _check_width(path, kind, y, unit_mm)
    _check_course(path, y, z, lines)
    {"rail": _check_rail, "wheel": _check_wheel}[kind](path, y, z)


def _choices(kind):
    return ", ".join(name for name, (of, _) in BUNDLED.items() if of == kind) + " or a file"


def _read(path, name, kind):
    text = _text(path, kind)
    table, lines = _table(text, path)
    y, z = table["y"], table["z"]
    angle = table.get("angle")
    if y[-1] < y[0]:
        y, z, lines = y[::-1], z[::-1], lines[::-1]
        angle = None if angle is None else np.remainder(angle[::-1], 2.0 * math.pi) - math.pi
    check_curve(path, kind, y, z, lines, table["unit_mm"])
    if angle is not None:
        check_angle(path, y, z, angle, lines)
    inclined = STANDS.get(stated_inclination(text, path)) if kind == "rail" else None
    tape = stated_tape(text, path) if kind == "wheel" else None
    return Profile.from_points(name, kind, y / 1e3, z / 1e3, angle, inclined, tape)


def _text(path, kind):
    known = {name.lower(): name for name, (of, _) in BUNDLED.items() if of == kind}
    near = difflib.get_close_matches(path.name.lower(), known, n=1)
    hint = f"did you mean {known[near[0]]}?" if near else f"give {_choices(kind)}"
    return profile_text(path, f"give {_choices(kind)}", f"there is no such file or bundled {kind} profile; {hint}")


def profile_text(path, advice="give a text file", absent="there is no such file"):
    """The text of a profile file."""
    return plain_text(path, "a profile file", LARGEST_FILE_MB, MOST_LINES, absent, advice)[0]


def _table(text, path):
    """Columns of the text in mm and rad, the unit of y in mm, and the line number of each point."""
    columns, rows, lines, split = None, [], [], None
    for number, line in content(text):
        split = split or split_of(line)
        fields = [split.point(field) for field in split.cells(line)]
        if columns is None:
            if not any(_is_number(field) for field in fields):
                columns, split = _header(fields, path, number), None
                continue
            columns = WITHOUT_HEADER[: len(fields)]
            if len(fields) not in (2, 3):
                raise InputError(f"{path}, line {number}", f"{len(fields)} columns; needed: y and z, or y, z and angle")
        if len(fields) != len(columns) or not all(map(_is_number, fields)):
            raise InputError(
                f"{path}, line {number}",
                f"found {shown(line)}; {len(columns)} numbers ({', '.join(columns)}) are needed",
            )
        row = tuple(map(float, fields))
        if not all(abs(value) <= LARGEST_NUMBER for value in row):
            raise InputError(
                f"{path}, line {number}",
                f"found {line[:60]!r}; every number must be finite and at most {LARGEST_NUMBER:g}",
            )
        if rows and row == rows[-1]:
            continue
        rows.append(row)
        lines.append(number)
        if len(rows) > MOST_POINTS:
            raise InputError(path, f"more than {MOST_POINTS} points; thin them out")
    if not rows:
        raise InputError(path, "the file is empty: it has no points")
    if len(rows) < FEWEST_POINTS:
        raise InputError(path, f"only {len(rows)} points; a profile needs at least {FEWEST_POINTS}")
    units = [COLUMNS[column] for column in columns]
    table = {name: values * unit for (name, unit), values in zip(units, np.array(rows).T, strict=True)}
    return table | {"unit_mm": dict(units)["y"]}, np.array(lines)


def _is_number(field):
    try:
        float(field)
    except ValueError:
        return False
    return True


def _header(fields, path, number):
    columns = tuple(field.strip("\"'").lower() for field in fields)
    found = sorted(COLUMNS[column][0] for column in columns if column in COLUMNS)
    if len(found) != len(columns) or found not in (["y", "z"], ["angle", "y", "z"]):
        raise InputError(
            f"{path}, line {number}",
            f"found columns {', '.join(fields)[:60]!r}; allowed: y_mm or y_m, z_mm or z_m, and angle_rad if known",
        )
    return columns


def _check_width(path, kind, y, unit_mm):
    low, high = WIDTH_MM[kind]
    width = np.ptp(y)
    if low <= width <= high:
        return
    raw = width / unit_mm
    hints = [f"the numbers look like {unit}" for unit, mm in UNITS.items() if mm != unit_mm and low <= raw * mm <= high]
    hints += [f"is it a {other}?" for other, (a, b) in WIDTH_MM.items() if other != kind and a <= width <= b]
    hint = f" ({hints[0]})" if hints else ""
    raise InputError(
        path,
        f"y extends over {width:.4g} mm, but a {kind} profile is {low:g} to {high:g} mm wide{hint}; "
        "give mm, or metres in columns named y_m, z_m",
    )


def _check_course(path, y, z, lines):
    """The curve runs from one side to the other without turning back or meeting itself."""
    dy, dz = np.diff(y), np.diff(z)
    same = np.flatnonzero((dy == 0.0) & (dz == 0.0))
    if same.size:
        raise InputError(f"{path}, line {lines[same[0] + 1]}", "the point before is repeated with another angle")
    furthest = np.maximum.accumulate(y)
    at = np.maximum.accumulate(np.where(y == furthest, np.arange(y.size), 0))
    back = furthest - y
    turned = np.flatnonzero((back > BACK_MM) & (np.abs(z - z[at]) < OVERHANG * back))
    if turned.size:
        i = turned[0]
        raise InputError(
            f"{path}, line {lines[i]}",
            f"y goes back from {furthest[i]:.4g} to {y[i]:.4g} mm; points must follow the curve from one side to the "
            "other: sort them, and cut off what lies below the sides",
        )
    turn = np.abs(turns(y, z))
    sharp = np.flatnonzero(turn > SHARPEST_TURN)
    if sharp.size:
        i = sharp[0]
        raise InputError(
            f"{path}, line {lines[i + 1]}",
            f"the curve turns by {math.degrees(turn[i]):.0f} degrees; at most {math.degrees(SHARPEST_TURN):.0f} are "
            "allowed between neighbours: remove the points that go back",
        )
    length = np.hypot(dy, dz).sum()
    if not CURVE_MM[0] <= length <= CURVE_MM[1]:
        raise InputError(path, f"the curve is {length:.4g} mm long; allowed: {CURVE_MM[0]:g} to {CURVE_MM[1]:g} mm")
    if dy.min() <= 0.0 and (pair := _meeting(y, z)) is not None:
        i, j = sorted(pair)
        raise InputError(
            f"{path}, line {lines[j]}",
            f"the curve crosses itself: this part meets the part at line {lines[i]}; points must follow the curve",
        )


def _check_rail(path, y, z):
    middle = z[np.argmin(np.abs(y - (y[0] + y[-1]) / 2.0))] + 0.0  # no -0
    if middle > z[0] and middle > z[-1]:
        raise InputError(
            path,
            f"z at mid-width is {middle:.4g} mm, at the sides {z[0]:.4g} and {z[-1]:.4g} mm: the rail is upside down; "
            "z must point down: multiply z by -1",
        )
    if middle > min(z[0], z[-1]):
        raise InputError(
            path,
            f"z at mid-width is {middle:.4g} mm, at the sides {z[0]:.4g} and {z[-1]:.4g} mm: not a rail's head, whose "
            "sides both lie below its middle; give the head from side to side",
        )


def _check_wheel(path, y, z):
    tread = np.median(np.interp(np.linspace(y[0], y[-1], 1001), np.maximum.accumulate(y), z))
    upside_down = tread - z.min() > z.max() - tread
    tip = np.argmin(z) if upside_down else np.argmax(z)
    height = abs(z[tip] - tread)
    if not FLANGE_MM[0] <= height <= FLANGE_MM[1]:
        raise InputError(
            path,
            f"what reaches furthest from the tread is {height:.4g} mm at y = {y[tip]:.4g} mm; "
            f"a flange of {FLANGE_MM[0]:g} to {FLANGE_MM[1]:g} mm is needed",
        )
    mirrored = y[tip] > (y[0] + y[-1]) / 2.0
    if mirrored or upside_down:
        axes = "y and z" if mirrored and upside_down else "y" if mirrored else "z"
        raise InputError(
            path,
            f"the flange tip is at y = {y[tip]:.4g} mm, z = {z[tip]:.4g} mm; a right-hand wheel is needed, flange at "
            f"negative y and positive z (y to the field side, z down): multiply {axes} by -1",
        )
    if not TIP_MM[0] <= y[tip] <= TIP_MM[1] or y[-1] <= 0.0:
        raise InputError(
            path,
            f"the flange tip is at y = {y[tip]:.4g} mm, allowed: {TIP_MM[0]:g} to {TIP_MM[1]:g} mm; "
            "y must count from the tape circle, usually 70 mm from the flange back",
        )
    tape = np.interp(0.0, np.maximum.accumulate(y), z)
    if abs(tape) > TAPE_MM:
        raise InputError(
            path,
            f"z at the tape circle (y = 0) is {tape:.4g} mm, allowed: {-TAPE_MM:g} to {TAPE_MM:g} mm; "
            f"shift z so that it is 0 there, and y if 0 is not where the tape circle is",
        )


def check_angle(path, y, z, angle, lines):
    """Raise an InputError unless tangent angles [rad] follow the chords to the neighbours."""
    direction = np.arctan2(np.diff(z), np.diff(y))
    off = np.zeros(angle.size)
    for nodes in (slice(None, -1), slice(1, None)):
        turn = np.remainder(angle[nodes] - direction + math.pi, 2.0 * math.pi) - math.pi
        off[nodes] = np.maximum(off[nodes], np.abs(turn))
    if off.max() > ANGLE_OFF:
        i = int(np.argmax(off > ANGLE_OFF))
        raise InputError(
            f"{path}, line {lines[i]}",
            f"angle {angle[i]:.4g} is {off[i]:.2g} rad away from the direction to a neighbour, allowed: {ANGLE_OFF:g}; "
            "the third column must be the tangent angle atan2(dz, dy) in rad",
        )
