"""Positions along a line as recordings give them: rising, without gaps; rounded and jittering ones are set right."""

from typing import NamedTuple

import numpy as np

from railcli.errors import InputError

from .decision import WARNING, Decision

NAMES = {
    "position", "s", "km", "m", "chainage", "station", "distance", "kilometre", "kilometer", "kilometrage", "location",
    "mileage", "stationierung", "streckenkilometer", "weg", "pk",
}  # fmt: skip
FEWEST = 8  # positions from which a rule can be seen
EVEN = 1e-6  # share of a step by which steps of an even table may differ
HARMLESS = 0.02  # share of a step by which rounding does not matter
ROUNDED = 0.75  # of the last decimal: what rounding moves a position at most, with some room for the fit
JITTER = 4.0  # steps by which jittering positions may lie off their line
COMMON = 0.01  # share of the steps that must repeat or fall before that is a jitter and no fault of its own
SLIPPED = 0.5  # steps off the line, on the mean of many, from which a position has slipped
MANY = 50  # positions
REGULAR = 0.9  # of the steps within half of their median: the table has a regular step


class Settled(NamedTuple):
    """Rising positions [m] and the decisions about them."""

    position: np.ndarray
    decisions: list


def settled(table, gap, key="position"):
    """Positions of a Table, rising and without gaps.

    Parameters
    ----------
    table : text_table.Table
    gap : float
        Steps without a position that count as a gap, in a table with a regular step.

    Raises
    ------
    InputError
        A position is missing, repeats, falls, or leaves a gap.
    """
    position = table.values[key]
    bad = ~np.isfinite(position)
    if bad.any():
        row = int(np.argmax(bad))
        raise InputError(table.where(row), f"position is {table.cell(row, key)!r}; fill it in or remove the line")
    if position.size > 2 and (np.diff(position) < 0.0).mean() > REGULAR:
        raise InputError(
            table.where(1),
            f"positions fall from {position[0]:.10g} to {position[-1]:.10g} m: recorded against the way they count, "
            "and the file does not say whose left and right it means: count positions along the way of travel",
        )
    about = f"column {table.names[key].written}"
    decisions = [Decision("position", f"{position[0]:.10g} to {position[-1]:.10g} m", about)]
    if position.size >= FEWEST:
        position, repair = _evened(position, table.decimals[key])
        decisions += repair
    step = np.diff(position)
    if (step <= 0.0).any():
        k = int(np.argmax(step <= 0.0))
        word = "repeats the one" if step[k] == 0.0 else f"falls below {position[k]:.10g} m"
        raise InputError(table.where(k + 1), f"position {position[k + 1]:.10g} m {word} before; positions must rise")
    usual = np.median(step)
    regular = np.mean(np.abs(step - usual) <= 0.5 * usual) >= REGULAR
    if regular and step.max() > gap * usual:
        k = int(np.argmax(step > gap * usual))
        raise InputError(
            table.where(k + 1),
            f"a gap from {position[k]:.10g} to {position[k + 1]:.10g} m in a table with a step of {usual:.4g} m: fill "
            "it, or use one side of it",
        )
    return Settled(position, decisions)


def _evened(position, decimal):
    """The positions, at equal distances where rounding or jitter alone hid that, and what was done about them."""
    step = np.diff(position)
    count = np.arange(position.size, dtype=float)
    middle = count.mean()
    mean = np.dot(count - middle, position) / np.dot(count - middle, count - middle)
    if mean <= 0.0 or np.abs(step - mean).max() <= EVEN * mean + 4.0 * np.spacing(np.abs(position).max()):
        return position, []
    even = position.mean() + mean * (count - middle)
    off = np.abs(position - even)
    if decimal > HARMLESS * mean and off.max() <= ROUNDED * decimal:
        reason = f"they are rounded to {decimal:.4g} m, and at equal distances they lie within {off.max():.2g} m"
        return even, [Decision(WARNING, f"positions taken every {mean:.5g} m", reason)]
    if (step <= 0.0).mean() >= COMMON and off.max() <= JITTER * mean:
        width = min(MANY, position.size)
        slip = np.convolve(position - even, np.full(width, 1.0 / width), "valid")
        if np.abs(slip).max() <= SLIPPED * mean:
            reason = f"they jitter by up to {off.max():.2g} m about equal distances, and fall or repeat"
            return even, [Decision(WARNING, f"positions taken every {mean:.5g} m", reason)]
    return position, []


def is_position(name):
    """True if a column of this Name holds positions."""
    return name.stem in NAMES
