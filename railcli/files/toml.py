"""TOML files as descriptions: units in the keys become SI, and what is wrong becomes one line.

A key that carries a number ends with its unit (`gauge_mm`); any unit of the same quantity will do. Entries of lists
are counted from 1 in messages.
"""

import math
import re
import tomllib
from pathlib import Path
from typing import NamedTuple, get_args

from pydantic import BaseModel, ValidationError

from railcli.errors import InputError
from railcli.model.checks import hint, nearest

from .user_file import read_bytes

LARGEST_MB = 4
DEEPEST = 50  # parts of a dotted key
_TOO_DEEP = re.compile(rf"(?<![\w-])(?:[\w-]+\s*\.\s*){{{DEEPEST}}}", re.ASCII)


class Unit(NamedTuple):
    """A unit as the end of a key: the SI unit that stands for it, and the factor to it as a fraction."""

    si: str
    times: float = 1.0
    over: float = 1.0
    symbol: str = ""


UNITS = {
    "m": Unit("m", symbol="m"),
    "mm": Unit("m", over=1e3, symbol="mm"),
    "km": Unit("m", times=1e3, symbol="km"),
    "s": Unit("s", symbol="s"),
    "ms": Unit("s", over=1e3, symbol="ms"),
    "rad": Unit("rad", symbol="rad"),
    "deg": Unit("rad", times=math.pi, over=180.0, symbol="deg"),
    "kg": Unit("kg", symbol="kg"),
    "t": Unit("kg", times=1e3, symbol="t"),
    "kg_m2": Unit("kg_m2", symbol="kg m^2"),
    "m_per_s": Unit("m_per_s", symbol="m/s"),
    "kmh": Unit("m_per_s", over=3.6, symbol="km/h"),
    "m_per_s2": Unit("m_per_s2", symbol="m/s^2"),
    "N": Unit("N", symbol="N"),
    "kN": Unit("N", times=1e3, symbol="kN"),
    "N_per_m": Unit("N_per_m", symbol="N/m"),
    "kN_per_m": Unit("N_per_m", times=1e3, symbol="kN/m"),
    "MN_per_m": Unit("N_per_m", times=1e6, symbol="MN/m"),
    "Ns_per_m": Unit("Ns_per_m", symbol="N s/m"),
    "kNs_per_m": Unit("Ns_per_m", times=1e3, symbol="kN s/m"),
    "Nm_per_rad": Unit("Nm_per_rad", symbol="N m/rad"),
    "kNm_per_rad": Unit("Nm_per_rad", times=1e3, symbol="kN m/rad"),
    "Nm": Unit("Nm", symbol="N m"),
    "kNm": Unit("Nm", times=1e3, symbol="kN m"),
    "Nms_per_rad": Unit("Nms_per_rad", symbol="N m s/rad"),
    "kNms_per_rad": Unit("Nms_per_rad", times=1e3, symbol="kN m s/rad"),
    "N_per_rad": Unit("N_per_rad", symbol="N/rad"),
    "kN_per_rad": Unit("N_per_rad", times=1e3, symbol="kN/rad"),
    "Ns_per_rad": Unit("Ns_per_rad", symbol="N s/rad"),
    "kNs_per_rad": Unit("Ns_per_rad", times=1e3, symbol="kN s/rad"),
    "rad_per_s": Unit("rad_per_s", symbol="rad/s"),
    "m2": Unit("m2", symbol="m^2"),
    "m3": Unit("m3", symbol="m^3"),
    "l": Unit("m3", over=1e3, symbol="l"),
    "m2_per_m": Unit("m2_per_m", symbol="m^2/m"),
    "Pa": Unit("Pa", symbol="Pa"),
    "kPa": Unit("Pa", times=1e3, symbol="kPa"),
    "GPa": Unit("Pa", times=1e9, symbol="GPa"),
    "bar": Unit("Pa", times=1e5, symbol="bar"),
    "m_per_J": Unit("m_per_J", symbol="m/J"),
    "Nm_per_s": Unit("Nm_per_s", symbol="N m/s"),
    "kNm_per_s": Unit("Nm_per_s", times=1e3, symbol="kN m/s"),
    "Ns2_per_m2": Unit("Ns2_per_m2", symbol="N s^2/m^2"),
    "s_per_m": Unit("s_per_m", symbol="s/m"),
    "mm_per_s": Unit("m_per_s", over=1e3, symbol="mm/s"),
    "m_per_m": Unit("m_per_m", symbol="m/m"),
    "mm_per_m": Unit("m_per_m", over=1e3, symbol="mm/m"),
    "permille": Unit("m_per_m", over=1e3, symbol="per mille"),
    "percent": Unit("m_per_m", over=1e2, symbol="%"),
    "1_per_s": Unit("1_per_s", symbol="1/s"),
    "1_per_m": Unit("1_per_m", symbol="1/m"),
    "1_per_km": Unit("1_per_m", over=1e3, symbol="1/km"),
}


class _Written(NamedTuple):
    """A key as it stands in the file."""

    key: str
    value: object
    unit: Unit | None


def read(path):
    """Contents of a TOML file as a dictionary.

    Raises
    ------
    InputError
        It is missing, cannot be read or is not TOML.
    """
    path = Path(path)
    data = read_bytes(path, "a TOML file", LARGEST_MB)
    try:
        text = data.decode("utf-8")
        if _TOO_DEEP.search(text):
            raise InputError(path, f"a key has more than {DEEPEST} parts with dots between them; none is so deep")
        return tomllib.loads(text)
    except UnicodeDecodeError:
        raise InputError(path, "is not a text file in UTF-8") from None
    except ValueError as error:
        raise InputError(path, f"is not valid TOML: {error}") from None
    except RecursionError:
        raise InputError(path, "is not valid TOML: nested too deeply") from None


def build(description, table, where):
    """Validated description of a table read from a file.

    Parameters
    ----------
    description : type
        Class derived from `checks.Description`.
    table : dict
        As `read` gives it; a value may also be a description already built.
    where : path-like
        File, for messages.

    Raises
    ------
    InputError
        The first thing that is wrong, as ``file: key: what is allowed, what was found``.
    """
    written = {}
    try:
        values = _to_si(table, (), written, where)
        return description.model_validate(values, by_alias=True, by_name=False)
    except ValidationError as error:
        raise _translated(description, error, values, written, where) from None
    except RecursionError:
        raise InputError(where, "its tables are nested too deeply") from None


def _to_si(value, path, written, where):
    """The same tables with every unit SI, in key and number; notes in `written` what stood where."""
    if isinstance(value, list):
        return [_to_si(item, (*path, i), written, where) for i, item in enumerate(value)]
    if not isinstance(value, dict):
        return value
    result = {}
    for key, item in value.items():
        stem, unit = split_unit(key)
        here = (*path, f"{stem}_{unit.si}" if unit else key)
        if here in written:
            place = _place((*path, key), written)
            raise InputError(where, f"{place}: {written[here].key!r} says the same; keep one of them")
        written[here] = _Written(key, item, unit)
        result[here[-1]] = _scaled(item, unit) if unit else _to_si(item, here, written, where)
    return result


def split_unit(key):
    """Parts of a key: its name and its Unit; None when it ends with no known unit."""
    for cut in (i for i, letter in enumerate(key) if letter == "_"):
        if unit := UNITS.get(key[cut + 1 :]):
            return key[:cut], unit
    return key, None


def _scaled(value, unit):
    if isinstance(value, list):
        return [_scaled(item, unit) for item in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value) * unit.times / unit.over
        except OverflowError:
            return math.inf
    return value


def _translated(description, error, values, written, where):
    problems = error.errors(include_url=False)
    problems.sort(key=lambda problem: problem["type"] != "extra_forbidden")
    first = problems[0]
    path = _without_tags(first["loc"], values)
    place, sentence = _explain(description, first, path, written)
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return InputError(where, f"{place}: {sentence}{more}" if place else f"{sentence}{more}")


def _without_tags(loc, values):
    """Path of an error without the names of the kinds that pydantic puts between."""
    path, node = [], values
    for part in loc:
        if isinstance(node, dict) and part not in node and part == node.get("kind"):
            continue
        path.append(part)
        if isinstance(node, dict):
            node = node.get(part)
        elif isinstance(node, list) and isinstance(part, int) and part < len(node):
            node = node[part]
        else:
            node = None
    return tuple(path)


def _place(path, written):
    """Path as the user wrote it: ``body[2].mass_kg``."""
    text = ""
    for i, part in enumerate(path):
        if isinstance(part, int):
            text += f"[{part + 1}]"
        else:
            entry = written.get(path[: i + 1])
            text += f"{'.' if text else ''}{entry.key if entry else part}"
    return text


def _found(path, written):
    """The value as the user wrote it, and its unit."""
    for cut in range(len(path), 0, -1):
        if entry := written.get(path[:cut]):
            value = entry.value
            for part in path[cut:]:
                value = value[part] if isinstance(value, list) and part < len(value) else None
            return value, entry.unit
    return None, None


_BOUNDS = {
    "greater_than": (">", "gt"),
    "greater_than_equal": (">=", "ge"),
    "less_than": ("<", "lt"),
    "less_than_equal": ("<=", "le"),
}
_WANTED = {
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "a text in quotes",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "dict_type": "a table",
}


def _explain(description, problem, path, written):
    """Place and sentence for one of pydantic's errors."""
    kind, context = problem["type"], problem.get("ctx", {})
    value, unit = _found(path, written)
    place = _place(path, written)
    got = f"got {_shown(value)}"
    if kind == "missing" and isinstance(path[-1], int):
        found = _found(path[:-1], written)[0]
        return _place(path[:-1], written), f"must have more than {len(found)} values, got {_shown(found)}"
    if kind == "missing":
        return _place(path[:-1], written), f"key {path[-1]!r} is missing"
    if kind == "extra_forbidden":
        return place, f"unknown key; {_key_hint(description, path, written)}"
    if kind in _BOUNDS:
        return place, f"{out_of_bounds(problem, unit)}, {got}"
    if kind in _WANTED:
        return place, f"must be {_WANTED[kind]}, {got}"
    if kind in ("too_short", "too_long"):
        least = "at least" if kind == "too_short" else "at most"
        count = context["min_length" if kind == "too_short" else "max_length"]
        return place, f"must have {least} {count} entries, got {context['actual_length']}"
    if kind == "literal_error":
        allowed = [part.strip().strip("'") for part in context["expected"].replace(" or ", ",").split(",")]
        return place, f"must be {context['expected']}, {got}{_meant(value, allowed)}"
    if kind == "union_tag_not_found":
        return place, f"key {context['discriminator'].strip(chr(39))!r} is missing"
    if kind == "union_tag_invalid":
        expected = [part.strip().strip("'") for part in context["expected_tags"].split(",")]
        tag = value["kind"]
        return f"{place}.kind", f"must be one of {context['expected_tags']}, got {_shown(tag)}{_meant(tag, expected)}"
    if kind == "value_error":
        return place, str(context["error"])
    return place, f"{problem['msg']}, {got}"


def out_of_bounds(problem, unit):
    """What is allowed, in the user's unit, for an error of pydantic's about a bound; None for other errors."""
    if problem["type"] not in _BOUNDS:
        return None
    sign, name = _BOUNDS[problem["type"]]
    bound = problem["ctx"][name] * (unit.over / unit.times if unit else 1.0)
    return f"must be {sign} {bound:g}{f' {unit.symbol}' if unit else ''}"


def _meant(value, allowed):
    near = nearest(value, allowed)
    return f"; did you mean {near!r}?" if near else ""


def _shown(value):
    text = repr(value) if not isinstance(value, bool) else str(value).lower()
    if isinstance(value, dict):
        text = "a table"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _key_hint(description, path, written):
    owner = _owner(description, path[:-1], written)
    known = [field.alias or name for name, field in owner.model_fields.items()] if owner else []
    return key_hint(written[path].key, known)


def key_hint(key, known):
    """Words that follow an unknown key: the known one that was probably meant, with the unit given if it fits."""
    stem, given = split_unit(key)
    name = f"{stem}_{given.si}" if given else key
    near = nearest(name, known)
    if near is None:
        near = next((one for one in known if split_unit(one)[0] == stem), None)
    if near is None:
        return hint(name, known) if known else "no keys are allowed here"
    stem, unit = split_unit(near)
    if unit is None:
        return f"did you mean {near!r}?"
    if given and given.si == unit.si:
        return f"did you mean {near.removesuffix(unit.si) + _suffix(given)!r}?"
    choices = " or ".join(repr(f"{stem}_{name}") for name, one in UNITS.items() if one.si == unit.si)
    return f"did you mean {choices}?"


def in_unit(value, unit):
    """An SI value in a unit; as it is without one."""
    return value * unit.over / unit.times if unit else value


def _suffix(unit):
    return next(name for name, one in UNITS.items() if one is unit)


def _owner(description, path, written):
    """The description class to which the table at `path` belongs."""
    owner = description
    for i, part in enumerate(path):
        if isinstance(part, int):
            continue
        field = next((f for name, f in owner.model_fields.items() if (f.alias or name) == part), None)
        candidates = list(_descriptions(field.annotation)) if field else []
        if len(candidates) > 1:
            kind = _found(path[: i + 2], written)[0]["kind"]
            candidates = [one for one in candidates if one.model_fields["kind"].default == kind]
        if not candidates:
            return None
        owner = candidates[0]
    return owner


def _descriptions(annotation):
    """The description classes within a type such as ``tuple[Body, ...]`` or ``Table | None``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        if "root" in annotation.model_fields:
            yield from _descriptions(annotation.model_fields["root"].annotation)
        else:
            yield annotation
    for inner in get_args(annotation):
        yield from _descriptions(inner)
