"""MiniProf: measured rails (.ban) and wheels (.whl), and reference profiles (.mpt).

Lines `Keyword=value`, an empty line, then rows of numbers in mm; `ColumnDef` names the columns, `XOffset` and `YOffset`
are added. Files of the old kind have free text before the empty line. A line whose first character is one of
``! " % #`` is a comment. In the instrument's picture X points to the right, Y up, and the track centre is on the right;
X = 0 is the flange back of a wheel. An .mpt file holds straight pieces `MPDn=L x1 y1 x2 y2`.
"""

import re

import numpy as np

from railcli.errors import InputError

from ..profiles import FEWEST_POINTS, MOST_POINTS
from ..text_table import number, shown, split_of
from .measured import Measured, points, too_many

COMMENTS = ("!", '"', "%", "#")
CUT_OFF = 0.9  # fewer rows than this share of the promised ones: the file was cut off
PIECE = re.compile(r"MPD(\d+)", re.ASCII)
GAP = 0.01  # between the pieces of a reference profile [mm]
_CONVENTIONS = {"unit_mm": 1.0, "mirrored": True, "from_back": True}


def read(path, text, kind):
    """A measured profile; see `read_points`."""
    lines = text.splitlines()
    first = _first_row(lines)
    if first is None:
        raise InputError(path, "no rows of numbers after the header: not a MiniProf profile, or cut off")
    header = _header(lines[:first])
    names = [name.strip().upper() for name in header.get("columndef", ("X,Y", 0))[0].split(",")]
    if "X" not in names or "Y" not in names:
        where = f"{path}, line {header['columndef'][1]}"
        raise InputError(where, f"ColumnDef is {','.join(names)[:60]!r}; columns X and Y are needed")
    rows, numbers, comments = _rows(path, lines, first, names, text.endswith(("\n", "\r")))
    x, y, numbers = points(path, rows, numbers)
    notes = _check_count(path, header, x.size, comments)
    x, y = x + _offset(path, header, "xoffset"), y + _offset(path, header, "yoffset")
    notes += [f"{key} = {header[key.lower()][0]} in the header" for key in ("Sd", "Sh", "qR") if key.lower() in header]
    return Measured(path, "MiniProf", x, y, numbers, kind, notes=tuple(notes), **_CONVENTIONS)


def read_template(path, text, kind):
    """A reference profile: a polyline; see `read_points`."""
    pieces = {}
    for number_, line in enumerate(text.splitlines(), start=1):
        key, equals, value = line.partition("=")
        match = PIECE.fullmatch(key.strip())
        if equals and match:
            pieces[int(match[1])] = (number_, value)
            if len(pieces) > MOST_POINTS:
                raise too_many(path)
    if not pieces:
        raise InputError(path, "no pieces MPD1=L x1 y1 x2 y2, ...: not a MiniProf reference profile")
    rows, lines = [], []
    for _, (line, value) in sorted(pieces.items()):
        letter, *fields = [item for item in re.split(r"[,;\s]+", value.strip()) if item] or [""]
        ends = [number(item) for item in fields]
        if letter.upper() != "L" or len(ends) != 4 or None in ends:
            raise InputError(f"{path}, line {line}", f"found {shown(value)}; a straight piece L x1 y1 x2 y2 is needed")
        if rows and np.hypot(ends[0] - rows[-1][0], ends[1] - rows[-1][1]) > GAP:
            raise InputError(
                f"{path}, line {line}",
                "this piece does not begin where the one before ends; the pieces must be a chain",
            )
        for end in ([ends[:2]] if not rows else []) + [ends[2:]]:
            rows.append(end)
            lines.append(line)
    count = number(_header(text.splitlines()).get("mpdc", ("", 0))[0])
    if count is not None and len(pieces) < count:
        raise InputError(path, f"MPDC promises {count:g} pieces, the file has {len(pieces)}: it was cut off")
    x, y, lines = points(path, rows, lines)
    notes = ("reference profile: straight pieces, so curvature is only that of their corners",)
    return Measured(path, "MiniProf reference", x, y, lines, kind, notes=notes, **_CONVENTIONS)


def _is_comment(line):
    return line.lstrip().startswith(COMMENTS)


def _fields(line, split=None):
    """Cells of a row, decimal commas as points; however a row is written, blanks may stand beside its separators."""
    split = split or split_of(line)
    return [split.point(part) for cell in split.cells(line) for part in cell.split()]


def _numbers(line):
    """Cells of a line if all of them are numbers, and at least two; else None."""
    fields = _fields(line)
    return fields if len(fields) >= 2 and all(number(item) is not None for item in fields) else None


def _is_row(line):
    fields = _fields(line)
    return len(fields) >= 2 and number(fields[0]) is not None and number(fields[1]) is not None


def _first_row(lines):
    """Index of the first row of data: after the last empty line of the header, else the first line of numbers only.

    Numbers in the header's free text are no data: they are no run of FEWEST_POINTS rows before an empty line.
    """
    after_empty, plain, run = None, None, 0
    empty = False
    for i, line in enumerate(lines):
        if not line.strip():
            empty = True
        elif _is_comment(line):
            continue
        elif empty and run < FEWEST_POINTS and _is_row(line):
            after_empty = i
            break
        else:
            empty = False
            numbers = _numbers(line) is not None
            plain = i if numbers and not run else plain
            run = run + 1 if numbers else 0 if run < FEWEST_POINTS else run
    return plain if after_empty is None or (plain is not None and run >= FEWEST_POINTS) else after_empty


def _header(lines):
    """Values and line numbers by lower-case keyword; of a repeated one, the last."""
    found = {}
    for i, line in enumerate(lines, start=1):
        key, equals, value = line.partition("=")
        if equals and not _is_comment(line):
            found[key.strip().lower()] = (value.strip(), i)
    return found


def _rows(path, lines, first, names, ends_whole):
    ix, iy = names.index("X"), names.index("Y")
    last = max(i for i, line in enumerate(lines) if line.strip())
    rows, numbers, comments = [], [], 0
    split = split_of(lines[first])
    for i in range(first, last + 1):
        line = lines[i]
        if not line.strip():
            continue
        if _is_comment(line):
            comments += 1
            continue
        fields = _fields(line, split)
        x = number(fields[ix]) if ix < len(fields) else None
        y = number(fields[iy]) if iy < len(fields) else None
        cut = i == last and not ends_whole and len(fields) < len(names)
        if x is None or y is None or cut:
            hint = "; the file seems to be cut off here" if i == last else ""
            raise InputError(
                f"{path}, line {i + 1}", f"found {shown(line)}; numbers for {', '.join(names)[:40]} are needed{hint}"
            )
        rows.append((x, y))
        numbers.append(i + 1)
        if len(rows) > MOST_POINTS:
            raise too_many(path)
    return rows, numbers, comments


def _check_count(path, header, count, comments):
    promised = number(header.get("xypoints", ("", 0))[0])
    if promised is None:
        return []
    if count + comments < CUT_OFF * promised:
        raise InputError(
            path,
            f"XYPoints promises {promised:g} points, the file has {count}: it was cut off; if not, correct XYPoints",
        )
    note = f"XYPoints promises {promised:g} points, the file has {count}"
    return [note + (f" and {comments} as comments" if comments else "")] if count != promised else []


def _offset(path, header, key):
    text, line = header.get(key, ("", 0))
    value = number(text) if text else 0.0
    if value is None:
        raise InputError(f"{path}, line {line}", f"found {shown(text)}; the offset must be a number in mm")
    return value
