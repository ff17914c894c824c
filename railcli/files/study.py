"""Study files, the ones that railcli brings along, and parameters as options of a command write them."""

import math
import re
import tomllib
from pathlib import Path
from typing import NamedTuple

from railcli.errors import InputError
from railcli.model.checks import hint
from railcli.model.scenario import PROFILES, Scenario
from railcli.model.study import DISTRIBUTIONS, Study

from . import toml
from .output import file_name
from .profiles import load_profile
from .resources import resource
from .scenario import VEHICLES, builtin_scenarios, load

FOLDERS = ("benchmarks/manchester/studies",)
DEFAULT_STUDY = "curve-300-friction"
OF_A_STUDY = {"vary", "sample", "seeds", "outputs", "channel", "scenario", "figures"}  # keys that no scenario has
ORDER = {  # of the numbers of a distribution as an option writes it
    "uniform": ("min", "max"),
    "loguniform": ("min", "max"),
    "triangular": ("min", "mode", "max"),
    "normal": ("mean", "sd", "min", "max"),
    "lognormal": ("median", "factor", "min", "max"),
}


class Planned(NamedTuple):
    """A study and the scenario that it varies."""

    study: Study
    scenario: Scenario


def builtin_studies():
    """Names and titles of the studies that railcli brings along."""
    return {name: toml.read(path).get("title", "") for name, path in sorted(_studies().items())}


def _studies():
    return {path.stem: path for folder in FOLDERS for path in resource(folder).glob("*.toml")}


def load_study(source=DEFAULT_STUDY, more=None, scenario=None):
    """A study and its scenario from a study file, a scenario, or the name of either.

    Parameters
    ----------
    source : str, path-like or dict
        A file with ``vary`` or ``scenario`` is a study, any other one a scenario; a dictionary is a study.
    more : dict, optional
        Keys of a study that replace those of the file; entries of ``vary`` replace those of the same key.
    scenario : Scenario, optional
        To vary in place of the one that the study names.

    Raises
    ------
    InputError
    """
    table, folder, where = _opened(source)
    for key, value in (more or {}).items():
        if key == "vary":
            new = {str(one["key"]) for one in value}
            value = [one for one in table.get("vary", ()) if str(one.get("key")) not in new] + value
        table[key] = value
    study = toml.build(Study, table, where)
    study = study.model_copy(update={"limits": study.limits and str(folder / study.limits)})
    if scenario is None:
        if study.scenario is None:
            raise InputError(where, "key 'scenario' is missing: the name or file of the scenario to vary")
        scenario = load(_placed(study.scenario, folder))
    study = study.model_copy(update={"parameters": tuple(_beside(one, folder) for one in study.parameters)})
    return Planned(study, scenario.knowing({**_profiles(study), **scenario.contents}))


def _opened(source):
    """Table of a study, the folder where its files lie, and what messages call it."""
    if isinstance(source, dict):
        return {"name": "study", **source}, Path(), source.get("name", "study")
    if source in (studies := _studies()):
        path = studies[source]
    elif str(source).endswith(".toml"):
        path = Path(source)
    elif source in (known := builtin_scenarios()) or "/" in str(source) or "\\" in str(source):
        return {"name": file_name(Path(source).stem), "scenario": str(source)}, Path(), source
    else:
        known = [*studies, *known]
        raise InputError(source, f"no study, scenario or .toml file of this name; {hint(str(source), known)}")
    table = toml.read(path)
    if "run" in table or not OF_A_STUDY & set(table):
        return {"name": file_name(path.stem), "scenario": str(path)}, Path(), path
    return {"name": file_name(path.stem), **table}, path.parent, path


def _placed(name, folder):
    """The name of a built-in scenario, or its file beside the study."""
    return str(folder / name) if str(name).endswith(".toml") or "/" in name or "\\" in name else name


def _beside(parameter, folder):
    """The same parameter, files among its values beside the study."""
    if parameter.values is None or folder == Path():
        return parameter
    values = tuple(
        str(folder / value) if isinstance(value, str) and _is_file(value) else value for value in parameter.values
    )
    return parameter.model_copy(update={"values": values})


def _is_file(text):
    return "/" in text or "\\" in text or bool(re.search(r"\.\w+$", text) and not re.search(r"\.\d+$", text))


def _profiles(study):
    """Profiles that are files among the values, read once: whoever makes a run needs none of the files."""
    found = {}
    for one in study.parameters:
        for kind in {PROFILES[key.rpartition(".")[2]] for key in one.keys if key.rpartition(".")[2] in PROFILES}:
            for value in one.values or ():
                if isinstance(value, str):
                    found[value] = load_profile(value, kind)
    return found


def vehicles(study):
    """What the files of vehicles among the values hold, by their places: read once, as profiles are."""
    return {
        value: toml.read(value)
        for one in study.parameters
        for value in one.values or ()
        if "vehicle" in one.keys and isinstance(value, str) and value not in VEHICLES
    }


def vary(text):
    """An entry of ``vary`` from an option: ``run.speed_kmh=60,70`` or ``=60:100:5`` or ``=uniform(60, 100)``."""
    key, equals, rest = text.partition("=")
    where = f"--vary {text!r}"
    if not equals or not key.strip() or not rest.strip():
        raise InputError(where, "give KEY=VALUES, such as contact.friction=0.1,0.2 or =0.1:0.5:9 or =uniform(0.1,0.5)")
    entry = {"key": key.strip()}
    if match := re.fullmatch(r"\s*([a-z]+)\s*\((.*)\)\s*", rest):
        kind, numbers = match[1], [_number(part, where) for part in match[2].split(",") if part.strip()]
        if kind not in DISTRIBUTIONS:
            raise InputError(where, f"no such distribution; {hint(kind, DISTRIBUTIONS)}")
        order = ORDER[kind]
        if len(numbers) != len(order):
            raise InputError(where, f"a distribution needs its bounds too: {kind}({', '.join(order)})")
        return {**entry, "distribution": kind, **dict(zip(order, numbers, strict=True))}
    parts = rest.split(":")
    if len(parts) == 3 and all(map(_is_number, parts)):
        first, last, count = (_number(part, where) for part in parts)
        if count != int(count):
            raise InputError(where, f"FROM:TO:COUNT ends with a whole number of values, got {parts[2]}")
        return {**entry, "from": first, "to": last, "count": int(count)}
    return {**entry, "values": [_value(part) for part in _list(rest)]}


def _list(text):
    """Parts between commas that stand in no brackets."""
    return [part for part in re.split(r",(?![^\[{]*[\]}])", text) if part.strip()]


def _value(text):
    """A value as TOML has it; what is none is a text."""
    try:
        return tomllib.loads(f"value = {text.strip()}")["value"]
    except ValueError:
        return text.strip()


def _is_number(text):
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _number(text, where):
    if not _is_number(text):
        raise InputError(where, f"{text.strip()!r} is no number")
    return float(text)
