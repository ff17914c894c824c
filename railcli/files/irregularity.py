"""Measured and generated irregularity as CSV.

The first line that is no comment names the columns: `position_m` (or `s_m`), and channels with their unit, `_mm` or
`_m`: `vertical`, `alignment`, `cross_level`, `gauge`, or for one rail `right_vertical`, `left_vertical`,
`right_alignment`, `left_alignment`. Separated by commas, semicolons, blanks or tabs; lines with ``#`` are comments.
"""

import re
from pathlib import Path

import numpy as np

from railcli.analysis.irregularity_spectrum import Record, check_band, evenly, target_of
from railcli.errors import InputError
from railcli.model.checks import hint
from railcli.model.irregularity import LARGEST, Samples, channels, rails
from railcli.model.spectra import CHANNELS

from .output import whole_file
from .profiles import plain_text

POSITIONS = ("position_m", "s_m")
PER_RAIL = ("right_vertical", "left_vertical", "right_alignment", "left_alignment")
NAMES = CHANNELS + PER_RAIL
UNITS = {"mm": 1e-3, "m": 1.0}
GAP = 2.5  # distance of samples over the usual one that counts as a gap
FEWEST = 8
LARGEST_FILE_MB, MOST_LINES = 200, 4_000_000
WRITTEN = ("right_alignment", "left_alignment", "right_vertical", "left_vertical")


def read(path):
    """Samples of a file.

    Raises
    ------
    InputError
        In one line: file and line, what was found, what is allowed, what to do.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(path, "there is no such file; give a CSV with position_m and channels such as vertical_mm")
    text = plain_text(
        path, "give a CSV with position_m and channels", "measured track", LARGEST_FILE_MB, MOST_LINES
    )
    names, rows, lines = _table(path, text)
    position = rows[:, 0]
    _check_positions(path, position, lines)
    found = {}
    for k, name in enumerate(names[1:], start=1):
        channel, _, unit = name.rpartition("_")
        values = rows[:, k] * UNITS[unit]
        worst = int(np.abs(values).argmax())
        if abs(values[worst]) > LARGEST:
            raise InputError(
                path,
                f"line {lines[worst]}: {name} is {rows[worst, k]:g}, which is {abs(values[worst]):g} m; at most "
                f"{LARGEST:g} m can be meant: check the unit in the column's name",
            )
        found[channel] = values
    return Samples(position, found)


def write(path, position, moved, comments=()):
    """Write displacements (rail, direction, n), inside signs [m], at positions (n,) [m]: heights up, in mm."""
    right, left = moved
    columns = 1e3 * np.stack([right[0], left[0], -right[1], -left[1]])
    with whole_file(path) as temporary, open(temporary, "w", encoding="utf-8") as file:
        for comment in comments:
            file.write(f"# {comment}\n")
        file.write(",".join(["position_m", *(f"{name}_mm" for name in WRITTEN)]) + "\n")
        np.savetxt(file, np.column_stack([position, columns.T]), fmt=["%.6f", *["%.7f"] * 4], delimiter=",")


def measured(path, target=None):
    """Record of a measured file, beside a Spectrum if one is given as its target."""
    samples = read(path)
    position, found = evenly(samples.position, channels(rails(samples.channels, 1.0), 1.0))
    if target is not None:
        spacing, length = float(np.diff(position).mean()), float(position[-1] - position[0])
        check_band(path, target.shortest, target.longest, spacing, length)
    targets = [] if target is None else [target_of(target)]
    return Record(Path(path).name, position, found, targets, float(position[0]))


def write_and_compare(path, record):
    """Write a Record, read it back; returns the largest difference of a channel [m]."""
    write(path, record.position, rails(record.channels, 1.0), [record.title, "heights up, lateral to the right"])
    again = channels(rails(read(path).channels, 1.0), 1.0)
    return float(max(np.abs(again[name] - record.channels[name]).max() for name in CHANNELS))


def _table(path, text):
    names, rows, lines = None, [], []
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.strip()
        if not line or line[0] in "#!%":
            continue
        cells = [cell.strip() for cell in (re.split(r"[;\t]", line) if re.search(r"[;\t]", line) else
                                           line.split(",") if "," in line else line.split())]  # fmt: skip
        if names is None:
            names = _names(path, number, cells)
            continue
        if len(cells) != len(names):
            raise InputError(path, f"line {number}: {len(cells)} values, but {len(names)} columns are named")
        try:
            values = [float(cell) for cell in cells]
        except ValueError:
            bad = next(cell for cell in cells if not _is_number(cell))
            raise InputError(path, f"line {number}: {bad!r} is not a number") from None
        rows.append(values)
        lines.append(number)
    if names is None:
        raise InputError(path, "is empty; the first line must name the columns, as in position_m,vertical_mm")
    if len(rows) < FEWEST:
        raise InputError(path, f"{len(rows)} samples; a track needs at least {FEWEST}")
    table = np.array(rows)
    if not np.isfinite(table).all():
        row, column = np.argwhere(~np.isfinite(table))[0]
        raise InputError(
            path, f"line {lines[row]}: {names[column]} is {table[row, column]:g}; fill or cut what was not measured"
        )
    return names, table, lines


def _names(path, number, cells):
    if cells[0] not in POSITIONS:
        raise InputError(path, f"line {number}: the first column must be position_m, got {cells[0]!r}")
    known = [f"{name}_{unit}" for name in NAMES for unit in UNITS]
    for cell in cells[1:]:
        if cell not in known:
            raise InputError(path, f"line {number}: unknown column {cell!r}; {hint(cell, known)}")
    stems = [cell.rpartition("_")[0] for cell in cells[1:]]
    if not stems or len(set(stems)) < len(stems):
        raise InputError(path, f"line {number}: give each channel once, and at least one")
    for stem in stems:
        family = stem.rpartition("_")[2] if stem in PER_RAIL else None
        both = {"vertical": ("vertical", "cross_level"), "alignment": ("alignment", "gauge")}.get(family, ())
        if twice := set(both) & set(stems):
            raise InputError(
                path, f"line {number}: {stem} and {twice.pop()} say the same; keep the rails or the channels"
            )
    return cells


def _is_number(cell):
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _check_positions(path, position, lines):
    step = np.diff(position)
    if (step <= 0.0).any():
        k = int(np.argmax(step <= 0.0))
        word = "repeats" if step[k] == 0.0 else "falls below"
        raise InputError(
            path, f"line {lines[k + 1]}: position {position[k + 1]:g} m {word} the one before; positions must rise"
        )
    usual = float(np.median(step))
    if (step > GAP * usual).any():
        k = int(np.argmax(step > GAP * usual))
        raise InputError(
            path,
            f"line {lines[k + 1]}: a gap from {position[k]:g} to {position[k + 1]:g} m; samples lie {usual:.3g} m "
            "apart: fill it or use one side of it",
        )
