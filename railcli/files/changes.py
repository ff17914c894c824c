"""Descriptions with other values, given as in their files: dotted keys that carry their units.

``contact.friction``, ``run.speed_kmh``, ``track[2].radius_m``, ``vehicle.body[car body].mass_t``: entries of lists are
counted from 1 or, where they have names, called by them.
"""

import re
from pathlib import Path

from pydantic import RootModel

from railcli.errors import InputError
from railcli.model.checks import Description, hint
from railcli.model.scenario import Scenario

from . import toml
from .scenario import ASKED, built

GROUPS = ("run", "contact", "start", "limits", "track_support")  # whose keys a scenario takes without their name
INSTEAD = {  # what a value takes the place of, unless that is given too
    "run.speed_course": ("run.speed_m_per_s",),
    "run.distance_m": ("run.duration_s",),
    "run.duration_s": ("run.distance_m",),
}
NAMES = ("name", "title", "description")  # which change no result
_PART = re.compile(r"(\w+)((?:\[[^\[\]]+\])*)(?:\.|$)")


def changed(description, changes):
    """The same scenario or vehicle with other values, validated; a scenario tells them in its title.

    Parameters
    ----------
    description : Scenario or Vehicle
    changes : dict
        Value by dotted key, in the unit that the key names. None: the default again. A scenario takes keys of GROUPS
        without the group's name, and files beside the working directory.

    Raises
    ------
    InputError
        The first thing that is wrong: scenario or vehicle, key, what is allowed, what was found.
    """
    where = description.name
    changes = {_full(description, key, where): _plain(value) for key, value in changes.items()}
    table = _opened(description)
    si = {_si(key) for key in changes}
    for key in changes:
        for other in INSTEAD.get(_si(key), ()) if isinstance(description, Scenario) else ():
            if other not in si:
                _place(table, other, None, where)
    for key, value in changes.items():
        if re.match(r"irregularity\[[^\]]+\]\.", key) and toml.split_unit(key.rpartition(".")[2])[0] in ASKED:
            raise InputError(where, f"{key}: goes with the file that is read; give all of {key.rpartition('.')[0]}")
        _place(table, key, value, where)
    if not isinstance(description, Scenario):
        return toml.build(type(description), table, where)
    told = (_in_words(description, key, value) for key, value in changes.items() if key not in NAMES)
    table["changes"] = (*description.changes, *told)
    title = table.get("title", "")
    if isinstance(title, str):
        table["title"] = title.removesuffix(_told(description.changes)) + _told(table["changes"])
    return built(table, Path(), where, description.contents)


def value_of(description, key):
    """The value under a dotted key of a scenario or vehicle, a number in the unit that the key names."""
    where = description.name
    key = _full(description, key, where)
    *path, last = _parts(key, where)
    table = _inside(_opened(description, True), path, key, where, True)
    stem, unit = toml.split_unit(last) if isinstance(last, str) else (last, None)
    name = f"{stem}_{unit.si}" if unit else last
    if not isinstance(table, dict):
        return table[_entry(table, last, key, where)]
    if name not in table:
        raise InputError(where, f"{key}: unknown key; {toml.key_hint(str(last), list(table))}")
    value = table[name]
    return toml.in_unit(value, unit) if isinstance(value, float) else value


def _full(description, key, where):
    """The key with the name of its group."""
    if not isinstance(description, Scenario) or re.search(r"[.\[]", key):
        return key
    fields = Scenario.model_fields
    known = {"": _aliases(Scenario)} | {group: _aliases(fields[group].annotation) for group in GROUPS}
    name = _si(key)
    found = [f"{group}.{key}" if group else key for group, aliases in known.items() if name in aliases]
    if not found:
        every = [alias for aliases in known.values() for alias in aliases]
        raise InputError(where, f"{key}: unknown key; {toml.key_hint(key, every)}")
    if len(found) > 1:
        raise InputError(where, f"{key}: stands in several places; give one of {', '.join(map(repr, found))}")
    return found[0]


def _aliases(kind):
    return [field.alias or name for name, field in kind.model_fields.items()]


def _si(key):
    """The key with its SI unit."""
    head, dot, last = key.rpartition(".")
    stem, unit = toml.split_unit(last)
    return f"{head}{dot}{stem}_{unit.si}" if unit else key


def _plain(value):
    """The value as a TOML file would hold it."""
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _opened(value, every=False):
    """A description as the table of a file: what it was given, or every value; those inside stay closed."""
    if isinstance(value, RootModel):
        value = value.root
    if isinstance(value, tuple):
        return list(value)
    if not isinstance(value, Description):
        return value
    given = {*value.model_fields_set, *({"kind"} & set(type(value).model_fields))}
    fields = type(value).model_fields
    return {field.alias or name: getattr(value, name) for name, field in fields.items() if every or name in given}


def _parts(key, where):
    """Names and entries that a dotted key leads through."""
    found, at = [], 0
    while match := _PART.match(key, at):
        found += [match[1], *([entry] for entry in re.findall(r"\[([^\[\]]+)\]", match[2]))]
        at = match.end()
        if at == len(key) and not key.endswith("."):
            return [part if isinstance(part, str) else tuple(part) for part in found]
    raise InputError(where, f"{key!r}: no key; keys look like contact.friction or track[2].radius_m")


def _inside(table, path, key, where, every=False):
    """What the path leads to, everything on it opened in place as `_opened` does."""
    for part in path:
        if isinstance(part, tuple):
            part = _entry(table, part, key, where)
        elif not isinstance(table, dict):
            raise InputError(where, f"{key}: there is no {part!r}, for what holds it is no table")
        elif part not in table:
            table[part] = {}
        table[part] = _opened(table[part], every)
        table = table[part]
    return table


def _entry(table, part, key, where):
    """Place of an entry of a list, which a number from 1 or a name says."""
    name = part[0] if isinstance(part, tuple) else part
    if isinstance(table, list):
        names = [str(getattr(item, "name", k)) for k, item in enumerate(table, start=1)]
        if name.isdecimal() and 1 <= int(name) <= len(table):
            return int(name) - 1
        if name in names:
            return names.index(name)
        allowed = hint(name, names) if table else "it is empty"
        raise InputError(where, f"{key}: there is no entry [{name}]; {allowed}")
    raise InputError(where, f"{key}: [{name}] asks for an entry of a list, and there is none")


def _place(table, key, value, where):
    """Put a value into a table, or take it out."""
    *path, last = _parts(key, where)
    table = _inside(table, path, key, where)
    if isinstance(last, tuple):
        table[_entry(table, last, key, where)] = value
        return
    if not isinstance(table, dict):
        raise InputError(where, f"{key}: there is no {last!r}, for what holds it is no table")
    for other in [other for other in table if _si(other) == _si(last)]:
        del table[other]
    if value is not None:
        table[last] = value


def _in_words(scenario, key, value):
    """What a change says in the title of a scenario."""
    last = key.rpartition(".")[2]
    stem, unit = toml.split_unit(last)
    name, symbol = key.removesuffix(last) + stem, f" {unit.symbol}" if unit else ""
    group, _, rest = name.partition(".")
    name = rest if group in GROUPS and rest else name
    if not _is_told(value):
        return f"{name} as usual" if value is None else f"another {name}"
    try:
        before = value_of(scenario, key)
    except InputError:
        before = None
    instead = f", not {_shown(before)}{symbol}" if _is_told(before) else ""
    return f"{name} {_shown(value)}{symbol}{instead}"


def _is_told(value):
    return isinstance(value, int | float | str) and not isinstance(value, bool)


def _shown(value):
    return value if isinstance(value, str) else f"{value:.6g}"


def _told(changes):
    return f" [{'; '.join(changes)}]" if changes else ""
