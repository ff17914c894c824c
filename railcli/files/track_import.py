"""Recordings of track geometry to the canonical tables, with an account of all that was decided."""

import hashlib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from railcli import __version__
from railcli.analysis.alignment import course
from railcli.analysis.irregularity_spectrum import evenly
from railcli.analysis.parts import parts
from railcli.analysis.track_quality import LARGEST_STEP, judged
from railcli.errors import InputError
from railcli.model.irregularity import Samples
from railcli.model.sections import Measured
from railcli.model.track import Track, pack

from . import irregularity, track_table
from .decision import WARNING, Decision
from .output import write_text
from .text_table import header_of
from .track_names import meaning_of
from .user_file import read_bytes

ALIGNMENT, IRREGULARITY = "alignment.csv", "irregularity.csv"
COLUMNS = {  # of the canonical alignment: name, and factor from SI
    "position": ("position_m", 1.0), "curvature": ("curvature_1_per_km", 1e3), "cant": ("cant_mm", 1e3),
    "gradient": ("gradient_permille", 1e3), "gauge": ("gauge_mm", 1e3),
}  # fmt: skip


class Imported(NamedTuple):
    """What files hold, together; None where nothing does.

    Attributes
    ----------
    alignment : Measured or None
    samples : Samples or None
    quality : list of Quality
    account : dict
        Files, decisions, sections, verdicts; for machines.
    """

    alignment: Measured | None
    samples: Samples | None
    quality: list
    account: dict


def import_track(paths, asked, chord=None):
    """Alignment and irregularity of one or several files; a file may hold both.

    Parameters
    ----------
    paths : sequence of path-like
    asked : irregularity.Asked
    chord : float, optional
        Of versines of the alignment [m].

    Raises
    ------
    InputError
        In one line: file and line, what was found, what is allowed; or two files say the same, or none anything.
    """
    line, recording, decisions, source = None, None, {}, {}
    for path in map(Path, paths):
        plan, channels = _holds(path)
        found = []
        for key, holds in (("alignment", plan), ("irregularity", channels)):
            if holds and key in source:
                raise InputError(path, f"holds {key}, as {source[key].name} does; give one file of it")
            if holds:
                source[key] = path
        if plan:
            line, told = track_table.alignment(path, chord, asked.gauge)
            found += told
        if channels:
            recording = irregularity.recording(path, asked)
            found += recording.decisions
        decisions[str(path)] = list(dict.fromkeys(found))
    samples, quality = None, []
    if recording:
        samples, more = _relative(source["irregularity"], recording, line)
        decisions[str(source["irregularity"])] += more
        quality = judged(*evenly(samples.position, samples.channels))
        decisions[str(source["irregularity"])] += _doubts(samples, line)
    return Imported(line, samples, quality, _account(paths, decisions, line, samples, quality))


def write(imported, folder):
    """Write the canonical tables into a folder; gives their paths."""
    written = []
    note = f"# written by railcli {__version__} track import from {', '.join(imported.account['files'])}\n"
    note = "".join(letter if letter.isprintable() or letter == "\n" else "?" for letter in note)
    if imported.alignment:
        values = {key: getattr(imported.alignment, key) for key in COLUMNS}
        columns = {COLUMNS[key][0]: np.array(one) * COLUMNS[key][1] for key, one in values.items() if one is not None}
        written.append(_write(folder / ALIGNMENT, note, columns))
    if imported.samples:
        channels = {f"{key}_mm": 1e3 * values for key, values in imported.samples.channels.items()}
        written.append(_write(folder / IRREGULARITY, note, {"position_m": imported.samples.position, **channels}))
    return written


def _write(path, note, columns):
    rows = (",".join(f"{value:.12g}" for value in row) for row in zip(*columns.values(), strict=True))
    write_text(path, "\n".join([f"{note}{','.join(columns)}", *rows]) + "\n")
    return path


def _holds(path):
    """Whether a file holds an alignment, and whether it holds channels of irregularity, by the names of its columns."""
    about = [meaning_of(name) for name in header_of(path, "a table of track geometry", irregularity.LARGEST_FILE_MB)]
    sided = any(one.side for one in about)
    plan = any(one.quantity in ("curvature", "radius") or (one.quantity == "versine" and not one.side and not sided)
               for one in about)  # fmt: skip
    geometry = {"vertical", "alignment"}
    channels = any(one.quantity in geometry or (one.quantity == "versine" and one.side) for one in about)
    only = not plan and any(one.quantity in ("cross_level", "gauge") for one in about)
    if not (plan or channels or only):
        raise InputError(path, "no column is curvature, radius, versine, level, alignment, gauge or cross-level")
    return plan, channels or only


def _relative(path, recording, line):
    """Samples whose cross-level is counted from the cant of the alignment, if it holds that; and what was done."""
    samples = recording.samples
    if not recording.absolute:
        return samples, []
    if line is None:
        reason = "no alignment was given; a run takes off the cant of its track"
        return samples, [Decision(WARNING, "cross-level holds the cant", reason)]
    s = samples.position - line.position[0]
    on_track = (s >= 0.0) & (s <= line.length)
    cant = course(pack(Track((line,))), np.clip(s, 0.0, line.length)).cant
    done = Decision("cross-level", "counted from the cant", "of the alignment, by position")
    return irregularity.without_cant(path, samples, cant, s, on_track), [done]


def _doubts(samples, line):
    """Warnings about how a recording was made, and whether it fits its alignment."""
    found = []
    step = float(np.median(np.diff(samples.position)))
    if step > LARGEST_STEP * (1.0 + 1e-6):
        reason = f"waves below {2.0 * step:.3g} m are not in it; EN 13848-1 is quoted with {LARGEST_STEP:g} m"
        found.append(Decision(WARNING, f"samples every {step:.4g} m", reason))
    if line is not None:
        low, high = max(samples.position[0], line.position[0]), min(samples.position[-1], line.position[-1])
        if low >= high:
            reason = (
                f"alignment {line.position[0]:.10g} to {line.position[-1]:.10g} m, irregularity "
                f"{samples.position[0]:.10g} to {samples.position[-1]:.10g} m"
            )
            found.append(Decision(WARNING, "the files have no position in common", reason))
        else:
            found.append(Decision("together", f"{low:.10g} to {high:.10g} m", "by their own positions"))
    return found


def _digest(path):
    return hashlib.sha256(read_bytes(path, "a table", irregularity.LARGEST_FILE_MB)).hexdigest()


def _account(paths, decisions, line, samples, quality):
    account = {
        "files": [Path(path).name for path in paths],
        "sha256": [_digest(path) for path in paths],
        "decisions": {path: [one._asdict() for one in told] for path, told in decisions.items()},
        "railcli": __version__,
    }
    if line is not None:
        account["alignment"] = {
            "from_m": line.position[0],
            "to_m": line.position[-1],
            "positions": len(line.position),
            "sections": [
                {"kind": part.kind, "from_m": part.start, "to_m": part.end, "curvature_1_per_m": part.curvature}
                for part in parts(line, line.position[0])
            ],
        }
    if samples is not None:
        account["irregularity"] = {
            "from_m": float(samples.position[0]),
            "to_m": float(samples.position[-1]),
            "samples": int(samples.position.size),
            "channels": list(samples.channels),
            "quality": [row._asdict() for row in quality],
        }
    return account
