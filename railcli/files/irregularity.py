"""Measured and generated irregularity as text tables.

Columns: the position, and channels with their unit: `vertical`, `alignment`, `cross_level`, `gauge`, or for one rail
`right_vertical`, `left_vertical`, `right_alignment`, `left_alignment`; further names are those of `track_names`. Cross-
level and gauge may be absolute. A versine becomes the alignment or the height that its chord shows.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from railcli.analysis import chord
from railcli.analysis.irregularity_spectrum import Record, check_band, evenly, target_of
from railcli.errors import InputError
from railcli.model.checks import nearest
from railcli.model.irregularity import LARGEST, Samples, channels, rails
from railcli.model.spectra import CHANNELS

from .decision import WARNING, Decision, tell
from .output import whole_file
from .positions import FEWEST, is_position, settled
from .recording import bridged, found_dropouts
from .text_table import SHOWN
from .text_table import read as read_table
from .track_names import BANDS, meaning_of

PER_RAIL = ("right_vertical", "left_vertical", "right_alignment", "left_alignment")
NAMES = CHANNELS + PER_RAIL
GAP = 2.5  # distance of samples over the usual one that counts as a gap
LARGEST_FILE_MB, MOST_ROWS = 100, 1_000_000
WRITTEN = ("right_alignment", "left_alignment", "right_vertical", "left_vertical")
NOMINAL_GAUGE = 1.435  # unless a scenario says another [m]
ABSOLUTE_GAUGE = 0.5  # from which a gauge is absolute [m]
ABSOLUTE_LEVEL = 0.015  # mean over LEVEL_OVER of a cross-level from which it holds the cant [m]
LEVEL_OVER = 100.0  # [m]
LARGEST_LEVEL = 0.25  # of an absolute cross-level [m]
OFF_CANT = 0.025  # such a mean, once the cant is taken off, from which the track is another one [m]
_ABSENT = "there is no such file; give a CSV with position_m and channels such as vertical_mm"


class Asked(NamedTuple):
    """What a user says about a recording.

    Attributes
    ----------
    chord : tuple of float or None
        Parts of the chord of its versines, before and after the point [m].
    bridge : float
        Longest stretch without values that is bridged [m].
    gauge : float
        That an absolute gauge is counted from [m].
    cross_level : "found", "absolute" or "relative"
        Whether it holds the cant.
    """

    chord: tuple | None = None
    bridge: float = 0.0
    gauge: float = NOMINAL_GAUGE
    cross_level: str = "found"


NOTHING = Asked()


class Recording(NamedTuple):
    """Samples, the decisions that led to them, and whether their cross-level still holds the cant."""

    samples: Samples
    decisions: list
    absolute: bool = False


def read(path):
    """Samples of a file as `recording`; it warns of what must be known."""
    found = recording(path)
    tell(path, found.decisions)
    return found.samples


def recording(path, asked=NOTHING):
    """The Recording of a file.

    Raises
    ------
    InputError
        In one line: file and line, what was found, what is allowed, what to do.
    """
    path = Path(path)
    table = read_table(path, _meaning, "a measured track", LARGEST_FILE_MB, MOST_ROWS, _ABSENT)
    if table.lines.size < FEWEST:
        raise InputError(path, f"{table.lines.size} samples; a track needs at least {FEWEST}")
    position, decisions = settled(table, GAP)
    decisions = [*table.decisions, *decisions]
    values = {key: table.values[key] for key in table.values if key != "position"}
    missing = {key: found_dropouts(values[key], table.names[key].factor) for key in values}
    position, values, keep, told = bridged(table, position, values, missing, asked.bridge)
    decisions += told
    values = _from_versines(table, position, values, asked.chord, decisions)
    if "gauge" in values and np.median(values["gauge"]) > ABSOLUTE_GAUGE:
        values["gauge"] = values["gauge"] - asked.gauge
        decisions.append(Decision("gauge", f"counted from {asked.gauge * 1e3:g} mm", "it is absolute in the file"))
    absolute = "cross_level" in values and _holds_cant(position, values["cross_level"], asked, decisions)
    for key, value in values.items():
        _check_size(table, key, value, keep, LARGEST_LEVEL if absolute and key == "cross_level" else LARGEST)
    return Recording(Samples(position, values), decisions, absolute)


def without_cant(path, samples, cant, s, on_track):
    """Samples whose absolute cross-level is counted from the cant of their track.

    Parameters
    ----------
    path : path-like
    samples : Samples
    cant : array (n,)
        Cant of the track at the samples, left over right rail [m].
    s : array (n,)
        Arc lengths of the samples [m].
    on_track : bool array (n,)
        Which of them lie on the track; beyond it nobody knows the cant, and no sample is used.

    Raises
    ------
    InputError
        What is left is no irregularity: the cross-level belongs to another track.
    """
    rest = samples.channels["cross_level"] - cant
    mean = np.where(on_track, _long_mean(samples.position, np.where(on_track, rest, 0.0)), 0.0)
    worst = int(np.argmax(np.abs(mean)))
    if abs(mean[worst]) > OFF_CANT:
        raise InputError(
            path,
            f"its cross-level is absolute, but does not follow the cant of the track: on the mean of {LEVEL_OVER:g} m "
            f"around {samples.position[worst]:.6g} m (s = {s[worst]:.6g} m) they differ by {mean[worst] * 1e3:.3g} mm; "
            "check offset_m and the sign, or say cross_level = 'relative'",
        )
    return Samples(samples.position, {**samples.channels, "cross_level": rest})


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
    again = channels(rails(recording(path).samples.channels, 1.0), 1.0)
    return float(max(np.abs(again[name] - record.channels[name]).max() for name in CHANNELS))


def _meaning(path, line, names):
    """Places of the position and the channels, as text_table.read asks for them."""
    where, found, decisions, others = f"{path}, line {line}", {}, [], []
    for place, name in enumerate(names):
        if is_position(name):
            key, about = "position", None
        else:
            about = meaning_of(name)
            key = _channel(about)
        if key is None:
            _check_unknown(where, name, about)
            others.append(name.written)
            continue
        _check_unit(where, name, key)
        if key in found:
            both = f"{names[found[key]].written[:SHOWN]!r} and {name.written[:SHOWN]!r}"
            raise InputError(where, f"{key} is given twice, by {both}; keep one")
        found[key] = place
        if about and about.band:
            reason = f"{name.written[:SHOWN]} holds {BANDS[about.band]} only, by its name"
            decisions.append(Decision(WARNING, f"filtered {key}", reason))
    if "position" not in found:
        raise InputError(where, f"no column is the position; name one position_m, s_m or km ({_list(names)})")
    others += [names[found.pop(key)].written for key in _doubled(where, found)]
    if len(found) < 2:
        raise InputError(where, f"no column is a channel such as vertical_mm or level_left [mm] ({_list(names)})")
    words = ", ".join(f"{key}: {names[at].written[:SHOWN]}" for key, at in found.items())
    decisions.insert(0, Decision("columns", words, "by their names"))
    if others:
        words = ", ".join(other[:SHOWN] for other in others)
        decisions.append(Decision("passed over", words, "nothing that a run takes"))
    return found, decisions


def _list(names):
    return "found " + ", ".join(name.written for name in names)[:200]


def _channel(about):
    """Key of a channel; a versine's begins with ``versine:``."""
    if about.quantity == "versine":
        channel = "vertical" if about.vertical else "alignment"
        return f"versine:{about.side}_{channel}" if about.side else f"versine:{channel}"
    if about.quantity in ("vertical", "alignment"):
        return f"{about.side}_{about.quantity}" if about.side else about.quantity
    return about.quantity if about.quantity in CHANNELS else None


def _check_unknown(where, name, about):
    """Raise an InputError for a name that seems to be a known one misspelt."""
    if about.quantity is None and not about.known:
        near = nearest(name.stem, [*NAMES, "level", "level_left", "level_right", "alignment_left", "alignment_right"])
        if near:
            unit = f"_{name.unit_written}" if name.unit else "_mm"
            raise InputError(where, f"unknown column {name.written[:SHOWN]!r}; did you mean {near + unit!r}?")


def _check_unit(where, name, key):
    if name.unit is None or name.unit.si != "m":
        stem = name.stem if name.unit_written else name.written
        found = f"says {name.unit_written[:20]!r}, no unit of length" if name.unit_written else "does not say its unit"
        raise InputError(
            where, f"column {name.written[:SHOWN]!r} {found}; write {key}_mm, {stem[:SHOWN]} [mm] or the like"
        )


def _doubled(where, found):
    """Channels that say what columns of both rails say already; an InputError where only one rail does."""
    twice = []
    for channel, of in (("vertical", "vertical"), ("cross_level", "vertical"), ("alignment", "alignment"),
                        ("gauge", "alignment")):  # fmt: skip
        rails_given = {f"left_{of}", f"right_{of}"} & set(found)
        if channel in found and len(rails_given) == 1:
            rail = rails_given.pop()
            raise InputError(where, f"{rail} and {channel} say the same of one rail; keep the rails or the channels")
        if channel in found and rails_given:
            twice.append(channel)
    return twice


def _from_versines(table, position, values, chord_parts, decisions):
    """The same values with every versine as the line that its chord shows."""
    result = {}
    for key, value in values.items():
        if not key.startswith("versine:"):
            result[key] = value
            continue
        name, channel = table.names[key], key.removeprefix("versine:")
        told = meaning_of(name).chord
        parts = chord_parts or ((told / 2.0, told / 2.0) if told else None)
        if parts is None:
            raise InputError(
                table.path, f"column {name.written[:SHOWN]!r} is a versine and needs its chord: give chord_m"
            )
        if channel in values:
            raise InputError(table.path, f"{channel} is given by its versine and by itself; keep one")
        step = float(position[-1] - position[0]) / (position.size - 1)
        if not np.allclose(np.diff(position), step, rtol=1e-3):
            raise InputError(table.path, "versines need positions at equal distances")
        if sum(parts) < 4.0 * step or sum(parts) > 0.5 * (position[-1] - position[0]):
            raise InputError(table.path, f"a chord of {sum(parts):g} m does not fit samples every {step:.3g} m on "
                             f"{position[-1] - position[0]:.6g} m")  # fmt: skip
        result[channel] = chord.restored(value, step, *parts)
        bands = ", ".join(f"{low:.3g} to {high:.3g} m" for low, high in chord.lost(*parts, step)[:4])
        reason = f"from a versine over {parts[0]:g} + {parts[1]:g} m, which hardly shows waves of {bands}"
        decisions.append(Decision(WARNING, f"{channel} without some waves", reason))
    return result


def _holds_cant(position, level, asked, decisions):
    if asked.cross_level != "found":
        decisions.append(Decision("cross-level", asked.cross_level, "given"))
        return asked.cross_level == "absolute"
    mean = np.abs(_long_mean(position, level)).max()
    absolute = mean > ABSOLUTE_LEVEL
    word = "absolute: it holds the cant" if absolute else "relative"
    decisions.append(Decision("cross-level", word, f"its mean over {LEVEL_OVER:g} m reaches {mean * 1e3:.3g} mm"))
    return bool(absolute)


def _long_mean(position, values):
    """Mean over LEVEL_OVER around every sample, of what there is at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    low = np.searchsorted(position, position - 0.5 * LEVEL_OVER)
    high = np.searchsorted(position, position + 0.5 * LEVEL_OVER, side="right")
    return (total[high] - total[low]) / (high - low)


def _check_size(table, key, value, keep, largest):
    worst = int(np.abs(value).argmax())
    if abs(value[worst]) > largest:
        column = table.names.get(key, table.names.get(f"versine:{key}"))
        raise InputError(
            table.where(keep[worst]),
            f"{column.written[:SHOWN]} is {table.cell(keep[worst], key if key in table.names else f'versine:{key}')}, "
            f"which is {abs(value[worst]):g} m; at most {largest:g} m can be meant: check the unit in the name",
        )
