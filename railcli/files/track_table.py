"""Measured alignment of a track: a text table over the position, whose names carry their units.

Curvature, radius or a versine; cant, gradient and gauge where they are given. Names: `track_names`, `positions`.
"""

from pathlib import Path

import numpy as np
from pydantic import ValidationError

from railcli.errors import InputError
from railcli.model.sections import SHARPEST, Measured
from railcli.model.track import LONGEST

from . import toml
from .decision import WARNING, Decision, tell
from .positions import is_position, settled
from .text_table import SHOWN
from .text_table import read as read_table
from .track_names import meaning_of

SI = {"position": "m", "curvature": "1_per_m", "radius": "m", "versine": "m", "cant": "m", "gradient": "m_per_m",
      "gauge": "m"}  # fmt: skip
PLAN = ("curvature", "radius", "versine")
GAP = 10.0  # steps without a position
LARGEST_FILE_MB, MOST_ROWS = 20, 100_000
NOMINAL_GAUGE = 1.435  # unless a scenario says another [m]
ABSOLUTE_GAUGE = 0.5  # from which a gauge is absolute [m]


def read_alignment(path, chord=None, gauge=NOMINAL_GAUGE):
    """Section of track from a measured alignment table; it warns of what must be known."""
    section, decisions = alignment(path, chord, gauge)
    tell(path, decisions)
    return section


def alignment(path, chord=None, gauge=NOMINAL_GAUGE):
    """Section of track from a measured alignment table, and the decisions that led to it.

    Parameters
    ----------
    path : path-like
        A line of names such as ``position_m, curvature_1_per_km, cant_mm``; see docs/scenario.md.
    chord : float, optional
        Of its versines [m].
    gauge : float
        From which a gauge that is no absolute one counts [m].

    Returns
    -------
    railcli.model.sections.Measured, list of Decision

    Raises
    ------
    InputError
        One line: file and line, what was found, what is allowed.
    """
    path = Path(path)
    table = read_table(path, _meaning, "an alignment table", LARGEST_FILE_MB, MOST_ROWS)
    if table.lines.size < 2:
        raise InputError(path, f"has {table.lines.size} positions; at least 2 are needed")
    position, decisions = settled(table, GAP)
    decisions = [*table.decisions, *decisions]
    if position[-1] - position[0] > LONGEST:
        length = position[-1] - position[0]
        raise InputError(path, f"is {length:g} m long; at most {LONGEST:g} m: check the unit of position")
    values = {key: _filled(table, key) for key in table.values if key != "position"}
    if "radius" in values:
        values["curvature"] = _curvature(table, values.pop("radius"))
    if "versine" in values:
        values["curvature"] = _of_versine(table, values.pop("versine"), chord, decisions)
    if "gauge" in values and np.abs(values["gauge"]).max() < ABSOLUTE_GAUGE:
        values["gauge"] = values["gauge"] + gauge
        decisions.append(Decision("gauge", f"added to {gauge * 1e3:g} mm", "it is a widening in the file"))
    columns = {"position": position, **values}
    try:
        return Measured(**{key: tuple(column.tolist()) for key, column in columns.items()}), decisions
    except ValidationError as error:
        raise InputError(path, error.errors()[0]["msg"].removeprefix("Value error, ")) from None


def _meaning(path, line, names):
    """Places of what is known of the columns, as text_table.read asks for them."""
    where, found, others = f"{path}, line {line}", {}, []
    for place, name in enumerate(names):
        about = None if is_position(name) else meaning_of(name)
        key = "position" if about is None else {"cross_level": "cant"}.get(about.quantity, about.quantity)
        if key not in SI or (about is not None and (about.side or about.vertical)):
            others.append(name.written)
            continue
        if name.unit is None or name.unit.si != SI[key]:
            stem = name.stem
            known = ", ".join(f"{stem}_{unit}" for unit, one in toml.UNITS.items() if one.si == SI[key])
            raise InputError(
                where, f"column {name.written[:SHOWN]!r} does not end with a unit of {key}; write one of: {known}"
            )
        if key in found:
            raise InputError(where, f"column {name.written[:SHOWN]!r}: {key} is given twice; keep one column")
        found[key] = place
    plan = [key for key in PLAN if key in found]
    if "position" not in found or not plan:
        raise InputError(
            where,
            f"found {', '.join(name.written for name in names)[:SHOWN]!r}; needed are position (position_m) and "
            "curvature (curvature_1_per_km), radius (radius_m) or versine (versine_mm)",
        )
    if len(plan) > 1:
        raise InputError(where, f"{' and '.join(plan)} are both given; keep one of them")
    words = ", ".join(f"{key}: {names[at].written[:SHOWN]}" for key, at in found.items())
    decisions = [Decision("columns", words, "by their names")]
    if others:
        words = ", ".join(other[:SHOWN] for other in others)
        decisions.append(Decision("passed over", words, "nothing that an alignment takes"))
    return found, decisions


def _filled(table, key):
    """Values of a column; a radius that is empty or infinite is straight track, all else must be there."""
    values = table.values[key]
    bad = ~np.isfinite(values)
    if key == "radius":
        empty = np.array([gone and table.cell(k, key) == "" for k, gone in enumerate(bad)])
        straight = bad & (np.isinf(values) | empty)
        values, bad = np.where(straight, 0.0, values), bad & ~straight
    if bad.any():
        row = int(np.argmax(bad))
        cell = table.cell(row, key)
        fault = f"{cell!r} is not a number" if cell else "is empty"
        raise InputError(table.where(row), f"{key} {fault}; fill it in or remove the line")
    return values


def _curvature(table, radius):
    small = (radius != 0.0) & (np.abs(radius) * SHARPEST < 1.0)
    if small.any():
        k = int(np.argmax(small))
        raise InputError(
            table.where(k),
            f"radius of {radius[k]:g} m: must be at least {1.0 / SHARPEST:g} m, or 0 for straight track; check the "
            "unit",
        )
    return np.divide(1.0, radius, out=np.zeros_like(radius), where=radius != 0.0)


def _of_versine(table, versine, chord, decisions):
    """Curvature of versines: 8 v / c^2, the mean over the chord with the weight of a triangle."""
    chord = chord or meaning_of(table.names["versine"]).chord
    if chord is None:
        raise InputError(table.path, "a versine needs the length of its chord: give chord_m")
    reason = f"8 v / c^2 with a chord c of {chord:g} m: a mean over the chord, so corners are rounded over it"
    decisions.append(Decision(WARNING, "curvature from versines", reason))
    return 8.0 * versine / chord**2
