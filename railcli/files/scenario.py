"""Scenario and vehicle files, and the ones that railcli brings along."""

from pathlib import Path

from pydantic import ValidationError

from railcli.errors import InputError
from railcli.model.checks import hint
from railcli.model.scenario import Scenario
from railcli.model.vehicle import Vehicle

from . import irregularity, toml
from .output import file_name
from .resources import resource

CASES = "benchmarks/manchester/cases"
VEHICLES = {"manchester": "benchmarks/manchester/vehicle.toml"}
DEFAULT_SCENARIO = "curve-1200-45"


def builtin_scenarios():
    """Names and titles of the scenarios that railcli brings along.

    Returns
    -------
    dict of str to str
        In alphabetical order.
    """
    return {path.stem: toml.read(path).get("title", "") for path in sorted(resource(CASES).glob("*.toml"))}


def load(scenario=DEFAULT_SCENARIO):
    """Scenario from a file or a built-in name.

    Parameters
    ----------
    scenario : str or path-like
        What ends with ``.toml`` or names a folder is a file, all else a built-in name.

    Raises
    ------
    InputError
        One line: file, key, what was found, what is allowed.
    """
    if _is_path(scenario):
        return _load_file(Path(scenario))
    path = resource(CASES) / f"{scenario}.toml"
    if not path.is_file():
        known = builtin_scenarios()
        raise InputError(scenario, f"no built-in scenario and not a .toml file; {hint(str(scenario), known)}")
    return _load_file(path)


def varied(scenario, group, key, value):
    """The scenario with one value of a group replaced, as an option of a command gives it.

    Parameters
    ----------
    scenario : Scenario
    group, key : str
        Such as ``run`` and ``speed_m_per_s``.
    value : float
        In the unit that the key names.

    Raises
    ------
    InputError
        The value is not allowed, alone or with the others.
    """
    stem, unit = toml.split_unit(key)
    si = value * unit.times / unit.over if unit else value
    name = f"{stem}_{unit.si}" if unit else stem
    fields = type(getattr(scenario, group)).model_fields
    field = next(field for field in fields if name in (field, fields[field].alias))
    try:
        return scenario.varied(**{group: {field: si}})
    except ValidationError as error:
        problem = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
        raise InputError(f"{group}.{key}", f"{problem[0].lower()}{problem[1:]}; got {value:g}") from None


def load_vehicle(vehicle, folder=None):
    """Vehicle from a file or a built-in name.

    Parameters
    ----------
    vehicle : str or path-like
    folder : path-like, optional
        Where a relative path starts.
    """
    if _is_path(vehicle):
        path = Path(folder or "") / vehicle
    elif vehicle in VEHICLES:
        path = resource(VEHICLES[vehicle])
    else:
        raise InputError(vehicle, f"no built-in vehicle and not a .toml file; {hint(vehicle, VEHICLES)}")
    return toml.build(Vehicle, toml.read(path), path)


def _load_file(path):
    table = toml.read(path)
    table.setdefault("name", file_name(path.stem))
    vehicle = table.get("vehicle", "manchester")
    if isinstance(vehicle, str):
        try:
            table["vehicle"] = load_vehicle(vehicle, path.parent)
        except InputError as error:
            raise InputError(f"{path}: vehicle", str(error)) from None
    contact = table.get("contact")
    if isinstance(contact, dict):
        for key in ("wheel_profile", "rail_profile", "table"):
            contact[key] = _beside(contact.get(key), path)
            if contact[key] is None:
                del contact[key]
    for source in table.get("irregularity", []) if isinstance(table.get("irregularity"), list) else []:
        if isinstance(source, dict) and source.get("kind") == "measured" and isinstance(source.get("file"), str):
            samples = irregularity.read(path.parent / source["file"])
            source.update(samples=samples, sha256=samples.sha256)
    return toml.build(Scenario, table, path)


def _is_path(text):
    text = str(text)
    return text.endswith(".toml") or "/" in text or "\\" in text


def _beside(value, path):
    """A file name (it has an ending or a folder) relative to the scenario; a bundled name as it is."""
    if isinstance(value, str) and ("/" in value or "\\" in value or Path(value).suffix):
        return str(path.parent / value)
    return value
