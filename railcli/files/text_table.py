"""The one reader of columns of text: separators, decimal commas, comments, names with units, dropouts.

A line that begins with ``#``, ``!`` or ``%`` is a comment. Semicolons, tabs, commas or blanks separate cells; decimal
commas are understood where another character separates. The first line of words names the columns, each with its unit
in brackets, behind ``in`` or as its ending (``level left [mm]``, ``km``, ``cant_mm``), or the units stand in a line of
their own below. What a name means is known by the caller.
"""

import math
import re
import unicodedata
from dataclasses import dataclass, field
from itertools import repeat
from typing import NamedTuple

import numpy as np

from railcli.errors import InputError

from . import toml
from .decision import Decision
from .user_file import plain_text

COMMENTS = ("#", "!", "%")
LARGEST_NUMBER = 1e9  # in any unit; nothing measured has one, and its square is still a number
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?", re.ASCII)
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eEdD][-+]?\d+)?", re.ASCII)
MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--", "---", "#n/a", "#nv", "#nan", "?"}
INFINITE = {"inf": math.inf, "+inf": math.inf, "-inf": -math.inf, "infinity": math.inf, "\u221e": math.inf}
PLAIN = set("0123456789+-.eE \t")  # of cells that are numbers beyond doubt
MOST_COLUMNS = 1000
MOST_LINES = 2_000_000
CHUNK = 20_000  # rows that are split at once
SAMPLED = 200  # of them, from which the written decimals are seen
SHOWN = 60  # characters of a name or cell in a message
UNIT_WORDS = {  # as people write units; else as keys of toml.UNITS
    "1/m": "1_per_m", "1/km": "1_per_km", "m-1": "1_per_m", "km-1": "1_per_km", "m^-1": "1_per_m", "km^-1": "1_per_km",
    "\u2030": "permille", "per mille": "permille", "o/oo": "permille", "0/00": "permille", "%": "percent",
    "mm/m": "mm_per_m", "m/m": "m_per_m", "m/s": "m_per_s", "km/h": "kmh", "metre": "m", "meter": "m",
    "millimetre": "mm", "millimeter": "mm", "kilometre": "km", "kilometer": "km",
}  # fmt: skip
_BRACKETS = re.compile(r"(.*?)[\s_]*[\[({]\s*([^\[\](){}]*?)\s*[\])}]\s*")
_BEHIND = re.compile(r"(.*\S)(?:\s+in\s+|\s*/\s*|\s*,\s*)(\S+)", re.IGNORECASE)
_NO_UNIT = toml.Unit("")


class Split(NamedTuple):
    """How the lines of a file are split; commas mark decimals where they do not separate."""

    separator: str | None  # None: blanks

    @property
    def comma(self):
        """True where a comma marks decimals, as a point does too."""
        return self.separator != ","

    def cells(self, line):
        """Cells of a line, without the blanks around them."""
        if self.separator is None:
            return line.split()
        return [cell.strip() for cell in line.split(self.separator)]

    def point(self, cell):
        """A cell with its decimals behind a point."""
        return cell.replace(",", ".") if self.comma else cell

    def number(self, cell):
        """Number written in a cell; None if there is none."""
        return number(self.point(cell))

    @property
    def words(self):
        return {None: "blanks", ";": "semicolons", "\t": "tabs", ",": "commas"}[self.separator]


def number(text):
    """Number of at most LARGEST_NUMBER written out in `text` (a Fortran exponent D is one too), else None."""
    text = text.strip()
    if not NUMBER.fullmatch(text):
        return None
    value = float(text.replace("D", "E").replace("d", "e"))
    return value if abs(value) <= LARGEST_NUMBER else None


def shown(text):
    """A line, name or cell as an error message shows it."""
    text = text.strip()
    return repr(text if len(text) <= SHOWN else f"{text[:SHOWN]}...")


def content(text):
    """Numbers and texts of all lines but empty ones and comments."""
    lines = ((n, line.strip()) for n, line in enumerate(text.splitlines(), start=1))
    return [(n, line) for n, line in lines if line and not line.startswith(COMMENTS)]


def split_of(row, names=None):
    """The Split of a file from its first line of numbers and its line of names, where it has one."""
    for separator in (";", "\t"):
        if separator in row:
            return Split(separator)
    if "," not in row and (names is None or "," not in names or len(names.split()) == len(row.split())):
        return Split(None)
    cells = row.split()
    decimal = [bool(DECIMAL_COMMA.fullmatch(cell)) for cell in cells]
    plain = all(comma or number(cell) is not None for comma, cell in zip(decimal, cells, strict=True))
    fits = names is None or "," not in names or len(names.split()) == len(cells)
    return Split(None) if len(cells) > 1 and any(decimal) and plain and fits else Split(",")


class Name(NamedTuple):
    """Name of a column."""

    written: str
    words: tuple  # in lower case, without accents and unit
    unit: toml.Unit | None  # None: none that is known
    unit_written: str

    @property
    def stem(self):
        return "_".join(self.words)

    @property
    def factor(self):
        """From the file's numbers to SI."""
        return self.unit.times / self.unit.over


def name_of(text):
    """The Name that a header's cell stands for."""
    written = text.strip().strip("\"'").strip()
    stem, unit = written, ""
    if match := _BRACKETS.fullmatch(written):
        stem, unit = match[1], match[2]
    elif (match := _BEHIND.fullmatch(written)) and unit_of(match[2]):
        stem, unit = match[1], match[2]
    if not unit:
        key = "_".join(_words(written))
        stem, found = toml.split_unit(key)
        if found is None and key in toml.UNITS and key in ("km", "m", "mm"):
            found = toml.UNITS[key]
        return Name(written, tuple(stem.split("_")), found, "" if found is None else key[len(stem) + 1 :] or key)
    return Name(written, tuple(_words(stem)), unit_of(unit), unit)


def unit_of(text):
    """The Unit that a text names, or None."""
    text = text.strip().strip("[](){}").strip()
    key = UNIT_WORDS.get(text.lower(), text)
    return toml.UNITS.get(key) or toml.UNITS.get(key.lower())


def _words(text):
    plain = unicodedata.normalize("NFKD", text.lower().replace("\u00df", "ss"))
    return re.findall(r"[a-z0-9]+", "".join(letter for letter in plain if not unicodedata.combining(letter)))


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of a file that somebody wants.

    Attributes
    ----------
    path : path-like
    names : dict of str to Name
        What each column is -> its name in the file.
    values : dict of str to array (n,)
        SI; NaN where a cell is empty or says so, infinite where it says so.
    lines : array (n,)
        Number of each row's line.
    split : Split
    decimals : dict of str to float
        Value of the last decimal that is written in a column, SI; 0 where numbers have exponents.
    decisions : list of Decision
    """

    path: object
    names: dict
    values: dict = field(repr=False)
    lines: np.ndarray = field(repr=False)
    split: Split
    decimals: dict
    decisions: list
    _texts: list = field(repr=False)
    _places: dict = field(repr=False)

    def where(self, row):
        """File and line of a row, for a message."""
        return f"{self.path}, line {self.lines[row]}"

    def cell(self, row, key):
        """A cell as it is written."""
        cells = self.split.cells(self._texts[row])
        return cells[self._places[key]] if self._places[key] < len(cells) else ""


def read(path, meaning, what, most_mb, most_rows, absent="no such file"):
    """Columns of a file.

    Parameters
    ----------
    path : path-like
    meaning : callable
        Called with the file, the number of the line of names, and the list of Name; gives a dict of what is wanted ->
        place of its column, and decisions on the others. Raises an InputError where names do not do.
    what : str
        What the file should be, with its article.
    most_mb, most_rows : float, int
    absent : str
        What to say of a file that is not there.

    Returns
    -------
    Table

    Raises
    ------
    InputError
        One line: file and line, what was found, what is allowed, what to do.
    """
    text, encoding = plain_text(path, what, most_mb, 2 * most_rows, absent, f"give {what} as text")
    lines = content(text)
    del text
    if not lines:
        raise InputError(path, "is empty; a line of names and one line for each position are needed")
    names, split, skip, by_line = _header(path, lines)
    wanted, decisions = meaning(path, lines[0][0], names)
    if len(lines) - skip > most_rows:
        raise InputError(path, f"{len(lines) - skip} rows; {what} may have at most {most_rows}: thin it out, or cut it")
    decisions = [Decision("separator", split.words, "as the lines are written"), *decisions]
    if encoding != "UTF-8":
        decisions.insert(0, Decision("encoding", encoding, "its bytes are no UTF-8"))
    if by_line:
        decisions.append(Decision("units", "from their own line", f"line {lines[1][0]}"))
    numbers = np.array([n for n, _ in lines[skip:]], dtype=np.int64)
    texts = [line for _, line in lines[skip:]]
    values, decimals, commas = _values(path, names, split, wanted, texts, numbers)
    if commas:
        decisions.insert(1, Decision("decimals", "behind commas", "as the numbers are written"))
    chosen = {key: names[place] for key, place in wanted.items()}
    for key, name in chosen.items():
        values[key] *= name.factor
        decimals[key] *= name.factor
    return Table(path, chosen, values, numbers, split, decimals, decisions, texts, wanted)


def header_of(path, what, most_mb):
    """The Names of a file's columns; errors as `read`."""
    text, _ = plain_text(path, what, most_mb, MOST_LINES, advice=f"give {what} as text")
    lines = content(text)
    if not lines:
        raise InputError(path, "is empty; a line of names and one line for each position are needed")
    return _header(path, lines)[0]


def _header(path, lines):
    """Names, Split, number of lines before the first row, and whether units stand in a line of their own."""
    first = lines[0][1]
    rows = [line for _, line in lines[1:4]]
    split = split_of(rows[0], first) if rows else split_of(first)
    units = None
    if rows and (words := [unit_of(cell) for cell in split_of(first).cells(rows[0]) if cell]) and all(words):
        split = split_of(rows[1], first) if len(rows) > 1 else split
        units = split.cells(rows[0])
    cells = split.cells(first)
    if split.separator is None and any(sign in first for sign in ";\t,"):
        cells = split_of(first).cells(first)
    if len(cells) > MOST_COLUMNS:
        raise InputError(f"{path}, line {lines[0][0]}", f"{len(cells)} columns; at most {MOST_COLUMNS} are allowed")
    if any(split.number(cell) is not None for cell in cells):
        raise InputError(
            f"{path}, line {lines[0][0]}",
            f"found {shown(first)}; the first line must name the columns with their units, as in position_m,cant_mm",
        )
    names = [name_of(cell) for cell in cells]
    if units:
        own = [unit_of(unit) for unit in units] + [None] * len(names)
        names = [name if unit is None else name._replace(unit=unit, unit_written=text)
                 for name, unit, text in zip(names, own, [*units, *repeat("", len(names))], strict=False)]  # fmt: skip
    return names, split, 2 if units else 1, bool(units)


def _values(path, names, split, wanted, texts, numbers):
    """Columns in the file's numbers, the value of the last decimal of each, and whether commas mark decimals."""
    found = {key: np.empty(len(texts)) for key in wanted}
    digits, signs = dict.fromkeys(wanted, 0), {}
    for start in range(0, len(texts), CHUNK):
        lines, where = texts[start : start + CHUNK], slice(start, min(start + CHUNK, len(texts)))
        quick = _all_numbers(lines, split, len(names))
        rows = [split.cells(line) for line in (lines if quick is None else lines[:SAMPLED])]
        if quick is None:
            _check_widths(path, rows, names, split, numbers[where])
        for key, place in wanted.items():
            column = [row[place] for row in rows]
            for sign in ",.":
                if any(sign in cell for cell in column):
                    signs.setdefault(sign, names[place].written[:SHOWN])
            column = [cell.replace(",", ".") for cell in column] if split.comma else column
            digits[key] = max(digits[key], _decimals(column))
            if quick is None:
                found[key][where] = _numbers(path, names[place].written, column, numbers[where])
            else:
                found[key][where] = quick[:, place]
    if split.comma and len(signs) > 1:
        raise InputError(
            path,
            f"has decimal points ({signs['.']}) and commas ({signs[',']}) in its numbers; write one of them, and none "
            "between thousands",
        )
    return found, {key: 10.0**-count if count < 16 else 0.0 for key, count in digits.items()}, "," in signs


def _all_numbers(lines, split, width):
    """Array (rows, columns) of lines in which every cell is a number beyond doubt; None for others."""
    joined = "\n".join(lines)
    if split.comma and "," in joined:
        if "." in joined:
            return None
        joined = joined.replace(",", ".")
    if not set(joined) <= PLAIN | {split.separator, "\n"}:
        return None
    try:
        values = np.loadtxt(joined.split("\n"), delimiter=split.separator, comments=None, ndmin=2)
    except ValueError:
        return None
    plain = values.shape == (len(lines), width) and (np.abs(values) <= LARGEST_NUMBER).all()
    return values if plain else None


def _check_widths(path, rows, names, split, numbers):
    """Make every row as wide as the names are; raises an InputError where that would guess."""
    width = len(names)
    for row, line in zip(rows, numbers, strict=False):
        if len(row) == width:
            continue
        if len(row) < width and split.separator == "\t":  # empty ones at the end were stripped
            row += [""] * (width - len(row))
        elif len(row) > width and not any(row[width:]):
            del row[width:]
        else:
            hint = "; decimal commas need another separator" if split.separator == "," and len(row) > width else ""
            raise InputError(f"{path}, line {line}", f"{len(row)} values, but {width} columns are named{hint}")


def _numbers(path, name, column, lines):
    """Numbers of cells, looked at one by one."""
    values = np.empty(len(column))
    for k, cell in enumerate(column):
        value = number(cell)
        if value is None:
            word = cell.strip("\"'").strip().lower()
            value = math.nan if word in MISSING else INFINITE.get(word)
        if value is None:
            where = f"{path}, line {lines[k]}"
            raise InputError(where, f"{name[:SHOWN]}: {shown(cell)} is not a number; write one, or nothing")
        values[k] = value
    return values


def _decimals(column):
    most = 0
    for cell in column:
        if "e" in cell or "E" in cell:
            return 99
        point = cell.find(".")
        if point >= 0 and len(cell) - point - 1 > most:
            most = len(cell) - point - 1
    return most
