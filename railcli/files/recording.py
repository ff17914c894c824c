"""Dropouts of recorded channels: found, said, and bridged only where that was asked for."""

import numpy as np

from railcli.errors import InputError

from .decision import WARNING, Decision
from .text_table import SHOWN

MARKS = (-99.0, -99.9, -99.99, -999.0, -999.9, -999.99, -9999.0, -99999.0, 999.0, 999.9, 9999.0, 99999.0)
PLAUSIBLE = 100.0  # a mark up to this may be a value: then it must stand apart from its neighbours
APART = 0.02  # by this [m]


def found_dropouts(values, factor):
    """Which values of a channel are none (bool array): empty ones, and those that recorders write in their place.

    Parameters
    ----------
    values : array (n,)
        [m]
    factor : float
        From the file's numbers to SI.
    """
    missing = ~np.isfinite(values)
    written = np.round(values / factor, 6)
    for mark in MARKS:
        marked = written == mark
        if not marked.any():
            continue
        if abs(mark) <= PLAUSIBLE:
            marked &= _apart(values, marked | missing)
        missing |= marked
    return missing


def _apart(values, marked):
    """Which of the marked values lie far from the nearest ones that are not marked."""
    known = np.flatnonzero(~marked)
    if known.size == 0:
        return np.ones(values.size, dtype=bool)
    after = np.clip(np.searchsorted(known, np.arange(values.size)), 0, known.size - 1)
    before = np.clip(after - 1, 0, None)
    return np.minimum(np.abs(values - values[known[after]]), np.abs(values - values[known[before]])) > APART


def bridged(table, position, values, missing, longest):
    """Channels without dropouts.

    Parameters
    ----------
    table : text_table.Table
    position : array (n,)
        [m]
    values, missing : dict of arrays (n,)
    longest : float
        Stretch between the values beside a dropout that a curve may be drawn over [m]; 0: none.

    Returns
    -------
    position : array (m,)
        Without dropouts at both ends.
    values : dict of arrays (m,)
    keep : array (m,)
        The rows that are left.
    decisions : list of Decision

    Raises
    ------
    InputError
        There are dropouts that are not bridged.
    """
    rows = np.arange(position.size)
    if not any(gone.any() for gone in missing.values()):
        return position, values, rows, []
    if longest <= 0.0:
        raise _refused(table, position, missing, "")
    usable = ~np.any(list(missing.values()), axis=0)
    if not usable.any():
        raise InputError(table.path, "has no row in which all channels were measured")
    first, last = int(np.argmax(usable)), usable.size - int(np.argmax(usable[::-1]))
    keep, decisions = rows[first:last], []
    if keep.size < rows.size:
        reason = f"values are missing at an end; {position[first]:.10g} to {position[last - 1]:.10g} m are left"
        decisions.append(Decision(WARNING, f"{rows.size - keep.size} rows cut", reason))
    position = position[keep]
    result = {}
    for key, value in values.items():
        gone = missing[key][keep]
        result[key] = value[keep]
        if not gone.any():
            continue
        at, length = _longest(position, gone)
        if length > longest * (1.0 + 1e-9):
            raise _refused(table, position, {key: gone}, f"; bridge_m = {longest:g} is too short", first)
        result[key] = _drawn(position, result[key], gone)
        reason = f"{gone.sum()} values in {_count(gone)} place(s), the longest {length:.3g} m at {position[at]:.10g} m"
        decisions.append(Decision(WARNING, f"{table.names[key].written[:SHOWN]} bridged", reason))
    return position, result, keep, decisions


def _drawn(position, values, gone):
    """The values with a curve through the others, that does not swing beyond them, in place of those that are gone."""
    from scipy.interpolate import PchipInterpolator  # takes half a second to load, so only where it is used

    drawn = values.copy()
    drawn[gone] = PchipInterpolator(position[~gone], values[~gone])(position[gone])
    return drawn


def _count(gone):
    return int(np.count_nonzero(np.diff(gone.astype(int)) == 1) + gone[0])


def _longest(position, gone):
    """Row at which the longest dropout begins, and the stretch between the values beside it [m]."""
    edge = np.diff(np.concatenate([[0], gone.astype(int), [0]]))
    starts, stops = np.flatnonzero(edge == 1), np.flatnonzero(edge == -1)
    low, high = np.clip(starts - 1, 0, None), np.clip(stops, None, position.size - 1)
    lengths = position[high] - position[low]
    k = int(np.argmax(lengths))
    return int(starts[k]), float(lengths[k])


def _refused(table, position, missing, more, first=0):
    key = next(key for key, gone in missing.items() if gone.any())
    gone = missing[key]
    at, length = _longest(position, gone)
    row = int(np.argmax(gone)) + first
    others = [other for other, also in missing.items() if also.any() and other != key]
    also = f", and {len(others)} more column(s) have such" if others else ""
    return InputError(
        table.where(row),
        f"{table.names[key].written[:SHOWN]} is {table.cell(row, key)!r}, not measured: {gone.sum()} of {gone.size} "
        f"values in {_count(gone)} place(s), the longest {length:.3g} m at {position[at]:.10g} m{also}; bridge_m = "
        f"{_rounded_up(length):g} draws a curve over them, or cut the file{more}",
    )


def _rounded_up(length):
    """A length with two digits that is not below it."""
    unit = 10.0 ** (np.floor(np.log10(length)) - 1.0)
    return np.ceil(length / unit * (1.0 - 1e-9)) * unit
