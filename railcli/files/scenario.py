"""Scenario and vehicle files, and the ones that railcli brings along."""

import copy
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from railcli.analysis.alignment import course
from railcli.errors import InputError
from railcli.model import rails
from railcli.model.checks import hint
from railcli.model.irregularity import Measured as Recorded
from railcli.model.limits import Limits
from railcli.model.scenario import PROFILES, TABLES, Contact, Run, Scenario
from railcli.model.track import Track, pack
from railcli.model.vehicle import Vehicle

from . import irregularity, toml
from .decision import tell
from .output import file_name
from .profiles import load_profile
from .resources import VEHICLES, resource, scenario_files
from .tables import identity
from .track_table import read_alignment

ASKED = ("kind", "file", "chord", "bridge", "cross_level")  # keys of a measured track that its reader must know
DEFAULT_SCENARIO = "curve-1200-45"


def builtin_scenarios():
    """Names and titles of the scenarios that railcli brings along.

    Returns
    -------
    dict of str to str
        In alphabetical order.
    """
    return {name: toml.read(path).get("title", "") for name, path in sorted(scenario_files().items())}


def load(scenario=DEFAULT_SCENARIO):
    """Scenario from a file, a built-in name, or a dictionary.

    Parameters
    ----------
    scenario : str, path-like or dict
        What ends with ``.toml`` or names a folder is a file, any other text a built-in name; a dictionary is what a
        file would hold, with relative paths from the working directory.

    Raises
    ------
    InputError
        One line: file, key, what was found, what is allowed.
    """
    if isinstance(scenario, dict):
        table = {"name": "scenario", "vehicle": "manchester", **copy.deepcopy(scenario)}
        return built(table, Path(), table["name"])
    if _is_path(scenario):
        return _load_file(Path(scenario))
    cases = scenario_files()
    if scenario not in cases:
        raise InputError(scenario, f"no built-in scenario and not a .toml file; {hint(str(scenario), cases)}")
    return _load_file(cases[scenario])


@dataclass(frozen=True, eq=False)
class AlignmentCase:
    """A track with what is needed to draw and to judge it; SI units.

    Attributes
    ----------
    name, title : str
    track : Track
    pieces : array of PIECE
    limits : Limits
    cant_base, gauge : float
    pivot : str
    gravity : float
    speed : float or None
    irregularity : callable or None
        Displacement of the rails over s, as `model.rails.irregularity`; None where the rails lie ideally.
    """

    name: str
    title: str
    track: Track
    pieces: np.ndarray
    limits: Limits
    cant_base: float
    gauge: float
    pivot: str
    gravity: float
    speed: float | None
    irregularity: Callable | None = None


def load_alignment(source):
    """Alignment of a scenario (file or built-in name) or of a measured table (``.csv``), as an AlignmentCase."""
    if str(source).lower().endswith(".csv"):
        track = Track((read_alignment(source),))
        fields = Scenario.model_fields
        return AlignmentCase(
            name=file_name(Path(source).stem),
            title=Path(source).name,
            track=track,
            pieces=pack(track),
            limits=Limits(),
            cant_base=fields["cant_base"].default,
            gauge=fields["contact"].default.gauge,
            pivot=fields["cant_pivot"].default,
            gravity=Run.model_fields["gravity"].default,
            speed=None,
        )
    case = load(source)
    return AlignmentCase(
        name=case.name,
        title=f"{case.name}: {case.title}" if case.title else case.name,
        track=case.track,
        pieces=case.pieces(),
        limits=case.limits,
        cant_base=case.cant_base,
        gauge=case.contact.gauge,
        pivot=case.cant_pivot,
        gravity=case.run.gravity,
        speed=case.run.speed,
        irregularity=partial(rails.irregularity, case) if case.irregularity else None,
    )


def load_vehicle(vehicle, folder=None):
    """Vehicle from a file, a built-in name, or a dictionary as a file would hold it.

    Parameters
    ----------
    vehicle : str, path-like or dict
    folder : path-like, optional
        Where a relative path starts.
    """
    if isinstance(vehicle, dict):
        return toml.build(Vehicle, vehicle, vehicle.get("name", "vehicle"))
    if _is_path(vehicle):
        path = Path(folder or "") / vehicle
    elif vehicle in VEHICLES:
        path = resource(VEHICLES[vehicle])
    else:
        raise InputError(vehicle, f"no built-in vehicle and not a .toml file; {hint(vehicle, VEHICLES)}")
    return toml.build(Vehicle, toml.read(path), path)


def builtin_text(kind, name):
    """The TOML file of a built-in vehicle or scenario, which kind says, as text."""
    places = {one: resource(path) for one, path in VEHICLES.items()} if kind == "vehicle" else scenario_files()
    if name not in places:
        raise InputError(name, f"no built-in {kind}; {hint(name, places)}")
    return places[name].read_text(encoding="utf-8")


def _load_file(path):
    table = toml.read(path)
    table.setdefault("name", file_name(path.stem))
    table.setdefault("vehicle", "manchester")
    return built(table, path.parent, path)


def built(table, folder, where, known=None):
    """Scenario of the table of a file, with what it names read.

    Parameters
    ----------
    table : dict
        As toml.build takes it.
    folder : pathlib.Path
        Where relative paths in it start.
    where : path-like
        For messages.
    known : dict, optional
        What names stand for already, as Scenario.contents.
    """
    if isinstance(table.get("vehicle"), str):
        try:
            table["vehicle"] = load_vehicle(table["vehicle"], folder)
        except InputError as error:
            raise InputError(f"{where}: vehicle", str(error)) from None
    sections, gauge = table.get("track"), _gauge(table)
    if isinstance(sections, list):
        table["track"] = [_with_table(section, i, folder, where, gauge) for i, section in enumerate(sections, start=1)]
    contact = table.get("contact")
    if isinstance(contact, dict):
        names = "wheel_profile", "rail_profile", "table"
        for key in (*names, *(f"left_{name}" for name in names)):
            contact[key] = _beside(contact.get(key), folder)
            if contact[key] is None:
                del contact[key]
    found = _recordings(table.get("irregularity"), folder, where, gauge)
    scenario = _beside_cant(toml.build(Scenario, table, where), found, folder)
    places = {getattr(scenario.contact, key) for key in (*PROFILES, *TABLES)}
    known = {place: content for place, content in (known or {}).items() if place in places}
    return scenario.knowing({**_contents(scenario.contact, known), **known})


def _gauge(table):
    """Nominal gauge of a scenario that is not yet checked [m]."""
    contact = table.get("contact")
    if isinstance(contact, Contact):
        return contact.gauge
    for key, value in (contact.items() if isinstance(contact, dict) else ()):
        stem, unit = toml.split_unit(key)
        if stem == "gauge" and unit and unit.si == "m" and isinstance(value, int | float):
            return value * unit.times / unit.over
    return Contact.model_fields["gauge"].default


def _recordings(sources, folder, where, gauge):
    """Recordings of the measured tracks that a scenario names, by their place; their samples go into its table."""
    found = {}
    for number, source in enumerate(sources if isinstance(sources, list) else []):
        if not (isinstance(source, dict) and source.get("kind") == "measured" and isinstance(source.get("file"), str)):
            continue
        if "samples" in source:
            continue
        place = folder / source["file"]
        asked = {key: value for key, value in source.items() if toml.split_unit(key)[0] in ASKED}
        about = toml.build(Recorded, asked, f"{where}: irregularity[{number + 1}]")
        asked = irregularity.Asked(about.chord, about.bridge, gauge, about.cross_level)
        found[number] = irregularity.recording(place, asked)
        tell(place, found[number].decisions)
        source["samples"] = found[number].samples
    return found


def _beside_cant(scenario, found, folder):
    """The scenario with absolute cross-levels counted from the cant of its track."""
    sources = list(scenario.irregularity)
    for number, one in found.items():
        if one.absolute:
            source = sources[number]
            s = one.samples.position - source.position_at_start(rails.course(scenario))
            cant = course(scenario.pieces(), np.clip(s, 0.0, scenario.track.length)).cant
            on_track = (s >= 0.0) & (s <= scenario.track.length)
            samples = irregularity.without_cant(folder / source.file, one.samples, cant, s, on_track)
            sources[number] = source.model_copy(update={"samples": samples})
    return scenario.varied(irregularity=tuple(sources)) if any(one.absolute for one in found.values()) else scenario


def _contents(contact, known):
    """What the names in a contact stand for but for those that are `known`.

    What cannot be read is left out; whoever needs it complains.
    """
    found = {}
    for key, kind in PROFILES.items():
        if (place := getattr(contact, key)) and place not in known:
            with suppress(InputError):
                found[place] = load_profile(place, kind)
    for key in TABLES:
        if (place := getattr(contact, key)) and place not in known and (digest := identity(place)):
            found[place] = digest
    return found


def _with_table(section, number, folder, where, gauge):
    """The same section; a measured one that names a file as what is in that file."""
    if not (isinstance(section, dict) and section.get("kind") == "measured" and "file" in section):
        return section
    where = f"{where}: track[{number}]"
    chord = None
    for key in sorted(set(section) - {"kind", "file"}):
        stem, unit = toml.split_unit(key)
        if stem != "chord" or unit is None or unit.si != "m":
            raise InputError(where, f"{key!r} beside 'file'; all columns come from the file")
        if not isinstance(section[key], int | float) or not 1.0 <= section[key] * unit.times / unit.over <= 200.0:
            raise InputError(f"{where}.{key}", f"must be a number from 1 to 200 m, got {section[key]!r}")
        chord = section[key] * unit.times / unit.over
    if not isinstance(section["file"], str):
        raise InputError(f"{where}.file", f"must be a text in quotes, got {section['file']!r}")
    return read_alignment(folder / section["file"], chord, gauge)


def _is_path(text):
    text = str(text)
    return text.endswith(".toml") or "/" in text or "\\" in text


def _beside(value, folder):
    """A file name (it has an ending or a folder) relative to the scenario; a bundled name as it is."""
    if isinstance(value, str) and ("/" in value or "\\" in value or Path(value).suffix):
        return str(folder / value)
    return value
