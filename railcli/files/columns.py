"""Results as a flat table: one column for each component of each channel, chosen by glob, with its unit.

A column's name is the path of its channel and its component: ``bodies/car body/position/y``, ``wheels/W1_right/Q``.
"""

from fnmatch import fnmatchcase
from typing import NamedTuple

import numpy as np

from railcli.errors import InputError
from railcli.model.checks import nearest

from .results import CHUNK

VALUES = 2_000_000  # numbers of a piece of the table in memory


class Column(NamedTuple):
    """A column of the flat table; `component` is its place in the channel, None for a channel of single numbers.

    `of_interval` as that of read_results.Channel.
    """

    name: str
    units: str
    description: str
    channel: str
    component: int | None
    of_interval: bool = False

    @property
    def label(self):
        """`wheels/W1_right/Q [N]`."""
        return f"{self.name} [{self.units}]"

    def of(self, values):
        """This column of the channel's values."""
        return values if self.component is None else values[:, self.component]


def columns(results, patterns=()):
    """Columns of a result, time first.

    Parameters
    ----------
    results : Results
    patterns : sequence of str
        Globs of channels or columns (``wheels/*/Q``; ``*`` crosses slashes), of which one must fit; all without any.

    Returns
    -------
    tuple of Column

    Raises
    ------
    InputError
        A pattern fits nothing.
    """
    return columns_of([results], patterns)[0]


def columns_of(several, patterns=()):
    """Columns of each of several results, as `columns`; a pattern need fit one of the results only."""
    every = [[column for channel in one.channels.values() for column in columns_of_channel(channel)] for one in several]
    for pattern in patterns:
        if not any(_fits(column, pattern) for of_one in every for column in of_one):
            near = nearest(pattern, list(several[0].channels))
            hint = f"did you mean {near!r}?" if near else "`railcli export RESULTS --list` names them"
            folders = " and ".join(str(one.folder) for one in several)
            raise InputError(f"channel {pattern!r}", f"no such channel in {folders}; {hint}")
    return [
        tuple(
            column
            for column in of_one
            if not patterns or column.name == "time" or any(_fits(column, pattern) for pattern in patterns)
        )
        for of_one in every
    ]


def pieces(results, chosen):
    """Yield the table in pieces of some rows: lists of arrays, one for each column.

    Parameters
    ----------
    results : Results
    chosen : sequence of Column
    """
    channels = list(dict.fromkeys(column.channel for column in chosen))
    size = max(1, VALUES // len(chosen) // CHUNK) * CHUNK
    for arrays in results.pieces(*channels, size=size):
        values = dict(zip(channels, arrays, strict=True))
        yield [column.of(values[column.channel]) for column in chosen]


def chosen_rows(results, filtered):
    """The rows of a result: those at its output interval, or the low-passed ones.

    Raises
    ------
    InputError
        Low-passed ones are wanted, and there are none.
    """
    if filtered and not results.filtered:
        raise InputError(results.folder, "has no low-passed rows: an earlier version wrote it; run the scenario again")
    return results.filtered if filtered else results


def data_frame(results, chosen):
    """All rows of some columns as a DataFrame; its columns are named by their labels, its index is the time [s]."""
    import pandas

    values, filled = np.empty((results.rows, len(chosen))), 0
    for piece in pieces(results, chosen):
        count = piece[0].size
        np.stack(piece, axis=1, out=values[filled : filled + count])
        filled += count
    time, *others = (column.label for column in chosen)
    return pandas.DataFrame(values[:, 1:], columns=others, index=pandas.Index(values[:, 0], name=time), copy=False)


def columns_of_channel(channel):
    """Columns of a read_results.Channel."""
    if not channel.components:
        return [Column(channel.name, channel.units, channel.description, channel.name, None, channel.of_interval)]
    return [
        Column(f"{channel.name}/{component}", channel.units, channel.description, channel.name, k, channel.of_interval)
        for k, component in enumerate(channel.components)
    ]


def _fits(column, pattern):
    return fnmatchcase(column.name, pattern) or fnmatchcase(column.channel, pattern)
