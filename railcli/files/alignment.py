"""From a file's own numbers to right-hand axes in metres: kind, unit, mirror, order, origin, each with its reason.

What a user gives holds. Otherwise the shape decides where it can: the width gives the unit, flange and head say which
way z points, the flange on which side y counts. Only a rail's gauge side cannot be seen; there the format's convention
holds.
"""

from dataclasses import dataclass, field

import numpy as np

from railcli.errors import InputError
from railcli.model.profile import TAPE_TO_BACK

from .decision import WARNING, Decision
from .profiles import FLANGE_MM, TAPE_MM, TIP_MM, WIDTH_MM

UNITS = {"mm": 1.0, "m": 1000.0, "inch": 25.4}  # in mm
CERTAIN_WHEEL_MM = 100.0  # no rail's head is as wide
CLOSED_MM = 2.0  # ends of the curve this close, and the curve far longer: an outline
FACE_MM = (0.5, 4.0)  # a flange back: this far from the outermost point, and at least this high
BACK_AGREES_MM = 2.0  # flange back seen against the one the format promises
BACK_TO_TIP_MM = (5.0, 30.0)
TIP_ASSUMED_MM = 15.0  # of S1002 and most others, from the flange back
LEAN_MM = 0.3  # a head that lies lower on its field side by this: perhaps mirrored
LEAN_AT = 0.3  # of the width, to both sides of the middle
INSIDE = np.linspace(0.01, 0.99, 981)  # of the width, so that faces at its ends do not enter


@dataclass(frozen=True, eq=False)
class Aligned:
    """Points in the axes of `railcli.model.profile`, from the gauge side to the field side.

    Attributes
    ----------
    y, z : array (n,)
        [m]
    lines : array (n,)
        Line number of each point in its file.
    decisions : list of Decision
    """

    kind: str
    y: np.ndarray = field(repr=False)
    z: np.ndarray = field(repr=False)
    lines: np.ndarray = field(repr=False)
    decisions: list


def find_kind(measured, given=None):
    """Decision on rail or wheel; an InputError if nothing tells."""
    if given:
        return Decision("kind", given, "given")
    if measured.kind:
        return Decision("kind", measured.kind, f"declared by the file or its ending ({measured.source})")
    width = _width(measured)
    units = [measured.unit_mm] if measured.unit_mm else UNITS.values()
    for unit in units:
        if WIDTH_MM["rail"][0] <= width * unit <= WIDTH_MM["rail"][1]:
            return Decision("kind", "rail", f"{width * unit:.4g} mm wide")
        if CERTAIN_WHEEL_MM <= width * unit <= WIDTH_MM["wheel"][1]:
            return Decision("kind", "wheel", f"{width * unit:.4g} mm wide")
    raise InputError(
        measured.path, f"y extends over {width:.4g}: neither a rail's nor a wheel's; say which with --kind"
    )


def align(measured, kind, units=None, mirror_y="auto", mirror_z="auto", tape_to_back=TAPE_TO_BACK):
    """Unit, mirrors, order and a first origin.

    Parameters
    ----------
    measured : Measured
    kind : "rail" or "wheel"
    units : str, optional
        One of UNITS.
    mirror_y, mirror_z : "auto", "yes" or "no"
    tape_to_back : float, optional
        Distance of a wheel's tape circle from its flange back [m].

    Returns
    -------
    Aligned

    Raises
    ------
    InputError
        The points are no such profile, whichever way they are turned.
    """
    unit = _unit(measured, kind, units)
    y, z, lines = measured.y * UNITS[unit.choice], measured.z * UNITS[unit.choice], measured.lines
    if y[-1] < y[0]:
        y, z, lines = y[::-1], z[::-1], lines[::-1]
    _refuse_outline(measured.path, y, z)
    decide = _wheel_mirrors if kind == "wheel" else _rail_mirrors
    across, down = decide(measured, y, z, mirror_y, mirror_z)
    if down.choice == "yes":
        z = -z
    if across.choice == "yes":
        y, z, lines = -y[::-1], z[::-1], lines[::-1]
    origin = _wheel_origin(measured, y, z, tape_to_back * 1e3) if kind == "wheel" else _rail_origin(y, z)
    decisions = [unit, across, down, origin[2]]
    if kind == "rail" and (warning := _leaning(y, z)):
        decisions.append(warning)
    return Aligned(kind, (y - origin[0]) / 1e3, (z - origin[1]) / 1e3, lines, decisions)


def _width(measured):
    return float(np.ptp(measured.y))


def _unit(measured, kind, given):
    width = _width(measured)
    low, high = WIDTH_MM[kind]
    fitting = [name for name, mm in UNITS.items() if low <= width * mm <= high]
    declared = {mm: name for name, mm in UNITS.items()}.get(measured.unit_mm)
    if given is None and declared is None and measured.unit_mm:
        raise InputError(
            measured.path,
            f"the file's unit is {measured.unit_mm:g} mm; mm, m or inch is needed: correct it or give --units",
        )
    unit = given or declared or (fitting[0] if fitting else "mm")
    if unit not in fitting:
        hint = f"the numbers look like {fitting[0]}: --units {fitting[0]}" if fitting else "this is no whole profile"
        raise InputError(
            measured.path,
            f"y extends over {width * UNITS[unit]:.4g} mm, but a {kind} profile is {low:g} to {high:g} mm wide; {hint}",
        )
    reason = "given" if given else f"declared ({measured.source})" if declared else f"{width:.4g} {unit} wide"
    return Decision("units", unit, reason)


def _refuse_outline(path, y, z):
    length = np.hypot(np.diff(y), np.diff(z)).sum()
    if np.hypot(y[-1] - y[0], z[-1] - z[0]) < CLOSED_MM and length > 2.0 * np.ptp(y):
        raise InputError(
            path, "the curve closes on itself: an outline; give the running surface from side to side only"
        )


def _heights(y, z):
    """z over the width without its ends, at equal distances [mm]."""
    return np.interp(y[0] + INSIDE * (y[-1] - y[0]), np.maximum.accumulate(y), z)


def _wheel_mirrors(measured, y, z, mirror_y, mirror_z):
    heights = _heights(y, z)
    tread = np.median(heights)
    upward = tread - heights.min() > heights.max() - tread
    height = max(tread - heights.min(), heights.max() - tread)
    if not FLANGE_MM[0] <= height <= FLANGE_MM[1]:
        raise InputError(
            measured.path,
            f"what reaches furthest from the tread is {height:.4g} mm; a flange of {FLANGE_MM[0]:g} to "
            f"{FLANGE_MM[1]:g} mm is needed",
        )
    right = INSIDE[np.argmin(heights) if upward else np.argmax(heights)] > 0.5
    across = f"the flange is at {'larger' if right else 'smaller'} y than the tread"
    down = f"the flange points to {'-' if upward else '+'}z"
    return _seen(measured, "y", right, across, mirror_y), _seen(measured, "z", upward, down, mirror_z)


def _rail_mirrors(measured, y, z, mirror_y, mirror_z):
    middle = float(np.interp((y[0] + y[-1]) / 2.0, np.maximum.accumulate(y), z))
    if not (middle > max(z[0], z[-1]) or middle < min(z[0], z[-1])):
        raise InputError(
            measured.path,
            f"z at mid-width is {middle:.4g} mm, at the sides {z[0]:.4g} and {z[-1]:.4g} mm: not a rail's head, whose "
            "sides both lie below its middle; give the head from side to side",
        )
    upward = middle > z[0]
    down = _seen(measured, "z", upward, f"the top is at {'larger' if upward else 'smaller'} z than the sides", mirror_z)
    if mirror_y != "auto":
        return Decision("mirror y", mirror_y, "given"), down
    if measured.mirrored:
        reason = f"{measured.source} counts y towards the track centre"
    elif measured.source == "SIMPACK":
        reason = "SIMPACK counts y to the field side"
    else:
        reason = "assumed: y counts to the field side; the shape cannot tell, say --mirror-y yes if it does not"
    return Decision("mirror y", _yes(measured.mirrored), reason), down


def _seen(measured, axis, mirror, why, given):
    """Decision on a mirror that the shape shows; an InputError if the user says otherwise."""
    if given not in ("auto", _yes(mirror)):
        raise InputError(
            measured.path,
            f"{why} in the file, so --mirror-{axis} must be {_yes(mirror)} or auto, not {given}: y must count to the "
            "field side and z down",
        )
    return Decision(f"mirror {axis}", _yes(mirror), why if given == "auto" else f"given; {why}")


def _yes(answer):
    return "yes" if answer else "no"


def _leaning(y, z):
    middle, reach = (y[0] + y[-1]) / 2.0, LEAN_AT * (y[-1] - y[0])
    gauge, field_side = np.interp([middle - reach, middle + reach], np.maximum.accumulate(y), z)
    if field_side - gauge < LEAN_MM:
        return None
    return Decision(
        WARNING,
        "mirrored?",
        f"the head lies {field_side - gauge:.2g} mm lower on its field side than on its gauge side; inclination and "
        "side wear do the opposite: check --mirror-y",
    )


def _rail_origin(y, z):
    top = int(np.argmin(z))
    return y[top], z[top], Decision("origin", "highest point", "of the head as it stands in the file")


def _wheel_origin(measured, y, z, tape):
    """y and z of the tape circle in the file's numbers, turned, and why."""
    path, low, high = measured.path, *BACK_TO_TIP_MM
    inside = y[0] + INSIDE * (y[-1] - y[0])
    heights = _heights(y, z)
    tip = inside[np.argmax(heights)]
    back = _flange_back(y, z, tip)
    seen = "" if back is None else f"; the file's flange back is at {back:.4g}"
    elsewhere = tape != TAPE_TO_BACK * 1e3 and back is not None and abs(back + tape) > BACK_AGREES_MM
    at_zero = np.interp(0.0, np.maximum.accumulate(y), z)
    if measured.from_back and (back is None or abs(back) <= BACK_AGREES_MM) and low <= tip <= high:
        y_tape = tape
        reason = f"{measured.source} counts from the flange back{seen or '; the file does not show it'}"
    elif TIP_MM[0] <= tip <= TIP_MM[1] and abs(at_zero) <= TAPE_MM and not measured.from_back and not elsewhere:
        y_tape, reason = 0.0, "as in the file, where z = 0 at y = 0 and the flange is in its place"
    elif back is not None and low <= tip - back <= high:
        y_tape, reason = back + tape, f"{tape:g} mm from the flange back, a face at {back:.4g} in the file"
    elif low <= tip <= high:
        y_tape, reason = tape, "assumed: y = 0 is the flange back, which the file does not show; else use --shift-y"
    else:
        y_tape = tip - TIP_ASSUMED_MM + tape
        reason = (
            f"assumed: flange tip {TIP_ASSUMED_MM:g} mm from a flange back that the file does not show; else --shift-y"
        )
    if not inside[0] < y_tape < inside[-1]:
        where = f"{tape:g} mm from the flange back ({reason})"
        raise InputError(path, f"the profile does not reach the tape circle, {where}")
    z_tape = np.interp(y_tape, np.maximum.accumulate(y), z)
    return y_tape, z_tape, Decision("origin", f"tape circle at {y_tape:.4g} mm of the file", reason)


def _flange_back(y, z, tip):
    """y of the vertical face on the flange's back, or None."""
    before = y < tip
    if not before.any():
        return None
    face = before & (y - y.min() < FACE_MM[0])
    return float(np.median(y[face])) if np.ptp(z[face]) >= FACE_MM[1] else None
