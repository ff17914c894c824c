"""What a reader found in a profile file, and what all readers share."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from railcli.errors import InputError

from ..profiles import FEWEST_POINTS, MOST_POINTS


@dataclass(frozen=True, eq=False)
class Measured:
    """Points of a profile file as the file means them, before any decision of ours.

    Attributes
    ----------
    path : Path
    source : str
        Name of the format.
    y, z : array (n,)
        In the file's unit, after the operations that the file itself asks for.
    lines : array (n,)
        Line number of each point.
    kind : "rail", "wheel" or None
        As the file or its ending declares it.
    unit_mm : float or None
        The file's unit [mm]; None if it declares none.
    mirrored : bool
        By the format's convention y counts towards the track centre.
    from_back : bool
        By the format's convention y = 0 is a wheel's flange back.
    notes : tuple of str
        What the reader did or noticed.
    """

    path: Path
    source: str
    y: np.ndarray = field(repr=False)
    z: np.ndarray = field(repr=False)
    lines: np.ndarray = field(repr=False)
    kind: str | None = None
    unit_mm: float | None = None
    mirrored: bool = False
    from_back: bool = False
    notes: tuple = ()


def points(path, rows, lines):
    """Columns and line numbers as arrays once there are enough rows of two numbers, and not too many."""
    if not rows:
        raise InputError(path, "there are no points in the file")
    if len(rows) < FEWEST_POINTS:
        raise InputError(path, f"only {len(rows)} points; a profile needs at least {FEWEST_POINTS}")
    y, z = np.array(rows, dtype=float).T
    return y, z, np.array(lines)


def too_many(path):
    """The InputError for a file with more points than any profile has."""
    return InputError(path, f"more than {MOST_POINTS} points; thin them out")
