"""What a run was made from and its scenario only names, kept with the results: profiles and measured samples.

A sealed HDF5 file (see `seal`). Group ``profiles``: of each profile y, z [m] and angle [rad] of its nodes; group
``irregularity``: of each measured track its positions and channels [m], in the signs of its file. Groups are named by
the digests with which the scenario asks for them.
"""

from functools import partial

import numpy as np

from railcli.errors import InputError
from railcli.model.irregularity import Samples
from railcli.model.profile import Profile
from railcli.model.scenario import PROFILES, TABLES, digest_of

from . import seal
from .output import whole_hdf5
from .profiles import BUNDLED, load_profile
from .user_file import title_of

SCENARIO, INPUTS = "scenario.json", "inputs.h5"
TITLE = "railcli inputs of a run"
COMPRESSION = {"compression": "gzip", "compression_opts": 4, "shuffle": True, "fletcher32": True}
_AGAIN = "run the scenario again"


def save(scenario, path):
    """Write the profiles and measured tracks of a scenario to a file."""
    profiles = [content for content in scenario.contents.values() if isinstance(content, Profile)]
    tracks = [source for source in scenario.irregularity if source.kind == "measured"]
    with whole_hdf5(path, partial(seal.head, TITLE)) as file:
        for profile in profiles:
            group = file.require_group(f"profiles/{digest_of(profile)}")
            group.attrs.update({"name": profile.name, "kind": profile.kind})
            if profile.inclined is not None:
                group.attrs["inclined"] = profile.inclined
            for key in ("y", "z", "angle"):
                _put(group, key, getattr(profile, key), "rad" if key == "angle" else "m")
        for source in tracks:
            group = file.require_group(f"irregularity/{source.digest}")
            group.attrs["file"] = title_of(source.file)
            for key, values in {"position": source.samples.position, **source.samples.channels}.items():
                _put(group, key, values, "m")


def restore(values, folder):
    """Put what a scenario names back into its values, as scenario.json of a results folder holds them.

    Parameters
    ----------
    values : dict
        Digests are taken out of it, samples of measured tracks put in.
    folder : pathlib.Path

    Returns
    -------
    dict
        As `Scenario.contents`. Empty for results of versions that kept no inputs; their measured tracks have no
        samples.

    Raises
    ------
    InputError
        The file of inputs is missing, damaged, or of another run.
    """
    try:
        contact = values["contact"]
        digests = contact.pop("digests", None)
        sources = [source for source in values.get("irregularity", []) if source["kind"] == "measured"]
        wanted = [source.pop("sha256" if digests is None else "digest", "") for source in sources]
        if digests is None:
            return {}
        contents = {contact[key]: digests[key] for key in TABLES if key in digests}
        profiles = {contact[key]: (PROFILES[key], digests[key]) for key in PROFILES if key in digests}
    except (AttributeError, KeyError, TypeError) as error:
        raise InputError(folder / SCENARIO, f"is damaged: {error}; {_AGAIN}") from None
    path = folder / INPUTS
    if not path.exists() and not sources and (bundled := _bundled(profiles)) is not None:
        return contents | bundled
    absent = f"is missing: it holds the profiles and measured tracks of the run; {_AGAIN}"
    seal.check(path, TITLE, "a file of inputs", _AGAIN, absent)
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            for place, (kind, digest) in profiles.items():
                contents[place] = _profile(file[f"profiles/{digest}"], kind)
            for source, digest in zip(sources, wanted, strict=True):
                source["samples"] = _samples(file[f"irregularity/{digest}"])
    except KeyError:
        raise InputError(path, f"belongs to another run than the scenario beside it; {_AGAIN}") from None
    except seal.UNREADABLE as error:
        raise InputError(path, f"does not hold inputs of a run ({' '.join(str(error).split())}); {_AGAIN}") from None
    return contents


def profiles_of(scenario):
    """Kind and digest of every profile that a scenario knows, by its place."""
    return {
        place: [content.kind, digest_of(content)]
        for place, content in scenario.contents.items()
        if isinstance(content, Profile)
    }


def profiles(path, wanted):
    """Profiles of a file of inputs by their places; wanted : as `profiles_of`."""
    seal.check(path, TITLE, "a file of inputs", _AGAIN, f"is missing; {_AGAIN}")
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        return {place: _profile(file[f"profiles/{digest}"], kind) for place, (kind, digest) in wanted.items()}


def _put(group, key, values, unit):
    if key not in group:
        group.create_dataset(key, data=np.asarray(values, float), **COMPRESSION)
        group[key].attrs["units"] = unit


def _profile(group, kind):
    inclined = group.attrs.get("inclined")
    nodes = (seal.whole(group[key]) for key in ("y", "z", "angle"))
    return Profile(str(group.attrs["name"]), kind, *nodes, None if inclined is None else bool(inclined))


def _samples(group):
    channels = {key: seal.whole(group[key]) for key in group if key != "position"}
    return Samples(seal.whole(group["position"]), channels)


def _bundled(profiles):
    """The profiles if all are those that railcli brings along; else None."""
    found = {}
    for place, (kind, digest) in profiles.items():
        found[place] = load_profile(place, kind) if place in BUNDLED else None
        if found[place] is None or digest_of(found[place]) != digest:
            return None
    return found
