"""Contact tables on disk: whole, sealed, checked, for the right profiles; and their places in the user's cache."""

import hashlib
import json
import math
import shlex
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from railcli import __version__
from railcli.errors import InputError
from railcli.kernels import jit
from railcli.kernels.layout import NODE_CHANNELS, PARTS, ROW, Node, Part
from railcli.kernels.place import cache_root
from railcli.model.contact_table import ContactTable, TableSettings, table_key, version
from railcli.model.heights import LEAST, knots_of, places

from . import seal
from .output import whole_hdf5
from .profiles import BUNDLED, load_profile
from .user_file import regular

HEAD_SIZE = seal.HEAD_SIZE
TITLE = "railcli contact table"
_head, _head_of = partial(seal.head, TITLE), partial(seal.head_of, TITLE)
SAME = 1e-12  # settings that differ by rounding of their units only
CACHE = "tables"
ARRAYS = {
    "node": "contact points at grid poses, one row each; columns: attribute 'channels'",
    "cell": "first branch of each cell; cells ordered roll, yaw^2, y (fastest)",
    "branch": "rows of node at the corners of a cell (bit 0: y, 1: roll, 2: yaw^2); -1: the branch ends before it",
    "heights": "of normal 'overlap' alone: rows of w = U^0.4 [J^0.4], weights of slopes, parts of the wheel [m], "
    "shears of the grid; then bins, knots of sheared y [m], roll [rad] and yaw^2 [rad^2], attribute 'knots' of them, "
    "each followed by the cubics of its splines; then their coefficients [m], ordered roll, yaw^2, y; for each part of "
    "the contact and every w the values of attribute 'part'; corners of branches count these parts",
}
UNITS = (
    "-, 1/m, -, m/rad, 1/rad, m/rad, m/rad^2, 1/rad^2, m/rad^2, "
    "m, -, m, m, -, m, m, N/m^1.5, m^0.5, m^0.5, N/m, N/m, N/m^0.5, N, -"
)
OPTIONS = {  # option of `railcli build-lut` for each setting: its name, unit, and units per SI unit
    "inclination": ("--inclination", "", 1.0),
    "gauge": ("--gauge", "mm", 1e3),
    "flange_back": ("--flange-back", "mm", 1e3),
    "tape_to_back": ("--tape-to-back", "mm", 1e3),
    "radius": ("--radius", "mm", 1e3),
    "y_range": ("--y-range", "mm", 1e3),
    "y_step": ("--y-step", "mm", 1e3),
    "roll_range": ("--roll-range", "mrad", 1e3),
    "roll_step": ("--roll-step", "mrad", 1e3),
    "yaw_range": ("--yaw-range", "mrad", 1e3),
    "yaw_count": ("--yaw-count", "", 1),
    "young": ("--young", "GPa", 1e-9),
    "poisson": ("--poisson", "", 1.0),
    "curvature_window": ("--curvature-window", "mm", 1e3),
    "normal": ("--normal", "", None),
    "fineness": ("--fineness", "", 1.0),
}
OF_A_SCENARIO = (
    "inclination", "gauge", "flange_back", "tape_to_back", "radius", "young", "poisson", "normal"
)  # fmt: skip


def in_units(key, value):
    """A setting as an option of `railcli build-lut` takes it."""
    factor = OPTIONS[key][2]
    return value if factor is None else f"{value * factor:.10g}"


@dataclass(frozen=True)
class Expected:
    """What a table must have been built for.

    Attributes
    ----------
    wheel, rail : Profile
    settings : TableSettings
    matters : tuple of str
        The settings that must agree; the grid of a table that the user names is the user's choice.
    wheel_given, rail_given : str
        Name or file by which the user knows the profiles.
    """

    wheel: object
    rail: object
    settings: TableSettings
    matters: tuple = tuple(OPTIONS)
    wheel_given: str = ""
    rail_given: str = ""

    def rebuild(self, path):
        """The command that builds this table into `path`."""
        words = ["railcli", "build-lut"]
        default = TableSettings()
        for option, name, profile in (("--wheel", "ORES1002", "wheel"), ("--rail", "UIC60", "rail")):
            given = getattr(self, f"{profile}_given") or getattr(self, profile).name
            if given != name:
                words += [option, given]
        for key in OPTIONS:
            if getattr(self.settings, key) != getattr(default, key):
                words += [OPTIONS[key][0], in_units(key, getattr(self.settings, key))]
        return shlex.join([*words, "-o", str(path), "--overwrite"])


@dataclass(frozen=True)
class Stored:
    """A table as a file holds it.

    Attributes
    ----------
    table : ContactTable
    certificate : dict
        As `measure` gives it; empty when it was built without.
    kernels : str
        Digest of the compiled sources that built it.
    """

    table: ContactTable
    certificate: dict
    kernels: str


def save(table, path, certificate=None):
    """Write a contact table to a file, whole or not at all."""
    with whole_hdf5(path, _head) as file:
        file.attrs.update(
            {
                "format": TITLE,
                "version": version(table.settings.stores_heights),
                "settings": json.dumps(table.settings.as_dict()),
                "wheel_name": table.wheel_name,
                "rail_name": table.rail_name,
                "wheel_sha256": table.wheel_digest,
                "rail_sha256": table.rail_digest,
                "method": table.method,
                "certificate": json.dumps(certificate or {}),
                "railcli": __version__,
                "kernels": jit.source_digest(),
            }
        )
        for name, description in ARRAYS.items():
            if name == "heights" and not table.settings.stores_heights:
                continue
            file[name] = getattr(table, name)
            file[name].attrs["description"] = description
        file["node"].attrs["channels"] = ", ".join(channel.name.lower() for channel in Node)
        file["node"].attrs["units"] = UNITS
        if table.settings.stores_heights:
            file["heights"].attrs["knots"] = table.counts
            file["heights"].attrs["part"] = ", ".join(channel.name.lower() for channel in Part)


def load(path, expect=None):
    """Contact table from a file.

    Parameters
    ----------
    path : path-like
    expect : Expected, optional
        What the table must have been built for.

    Raises
    ------
    InputError
        It is missing, no contact table, truncated, changed, of another version, or for something else.
    """
    table = read(path).table
    if expect is not None:
        check_expected(table, path, expect)
    return table


def read(path):
    """Table, certificate and provenance from a file; errors as `load`."""
    import h5py

    path = Path(path)
    absent = f"there is no such file; build it: {_command(path)}"
    seal.check(path, TITLE, "a contact table", _build_again(path), absent)
    try:
        with h5py.File(path, "r", locking=False) as file:
            attributes = {key: value for key, value in file.attrs.items()}
            found, wanted = attributes.get("version"), version("heights" in file)
            if found != wanted:
                raise InputError(
                    path, f"is of version {found}; this railcli reads version {wanted}; {_build_again(path)}"
                )
            arrays = {name: seal.whole(file[name]) for name in ARRAYS if name in file}
            if "heights" in file:
                arrays["counts"] = tuple(int(count) for count in file["heights"].attrs["knots"])
        settings = TableSettings(**json.loads(attributes["settings"]))
        certificate = json.loads(attributes["certificate"])
        table = ContactTable(
            settings=settings,
            wheel_name=str(attributes["wheel_name"]),
            rail_name=str(attributes["rail_name"]),
            wheel_digest=str(attributes["wheel_sha256"]),
            rail_digest=str(attributes["rail_sha256"]),
            method=str(attributes["method"]),
            **arrays,
        )
        problem = _inconsistency(table)
    except seal.UNREADABLE as error:
        text = " ".join(str(error).split())
        raise InputError(path, f"does not hold a contact table ({text}); {_build_again(path)}") from error
    if problem:
        raise InputError(path, f"does not hold a contact table ({problem}); {_build_again(path)}")
    return Stored(table, certificate, str(attributes.get("kernels", "")))


def identity(path):
    """Digest of what the contact table in a file is: profiles, settings, method and the kernels that built it.

    16 digits; the table itself is not looked at. None: it cannot be read.
    """
    import h5py

    try:
        regular(path, "a contact table")
        with h5py.File(path, "r", locking=False) as file:
            keys = ("version", "settings", "wheel_sha256", "rail_sha256", "method", "kernels")
            return hashlib.sha256(json.dumps([str(file.attrs[key]) for key in keys]).encode()).hexdigest()[:16]
    except (InputError, *seal.UNREADABLE):
        return None


def _command(path):
    return f"railcli build-lut -o {shlex.quote(str(path))}"


def _build_again(path):
    return f"build it again: {_command(path)} --overwrite"


def _inconsistency(table):
    """What is wrong with the arrays of a table, in words; empty when the core can read nothing outside them."""
    s, node, cell, branch = table.settings, table.node, table.cell, table.branch
    if len(table.counts) != 3 or min(table.counts) < (LEAST if s.stores_heights else 2):
        return f"{table.counts} are no counts of knots"
    cells = math.prod(count - 1 for count in table.counts)
    rows = places(table.counts)[-1] + PARTS * max(table.points, 1) if s.stores_heights else 0
    layout = {
        "node": (np.float64, (node.shape[0], NODE_CHANNELS)),
        "cell": (np.int32, (cells + 1,)),
        "branch": (np.int32, (branch.shape[0], 8)),
        "heights": (np.float64, (rows, ROW)),
    }
    for name, (dtype, shape) in layout.items():
        array = getattr(table, name)
        if array.dtype != dtype or array.shape != shape:
            return f"{name} is {array.dtype} of shape {array.shape}, not {np.dtype(dtype)} of shape {shape}"
    if cell[0] != 0 or cell[-1] != branch.shape[0] or (np.diff(cell) < 0).any():
        return f"cell does not count the {branch.shape[0]} branches"
    if branch.size == 0 or branch.min() < -1 or branch.max() >= table.points:
        return f"branch points outside the {table.points} nodes"
    if not (np.isfinite(node).all() and np.isfinite(table.heights).all()):
        return "a node is not a finite number"
    if s.stores_heights and not all((np.diff(knots) > 0.0).all() for knots in knots_of(table.heights, table.counts)):
        return "knots do not rise"
    return ""


def check_expected(table, path, expect):
    """Raise an InputError that says what else the table in `path` was built for."""
    for key in expect.matters:
        found, wanted = getattr(table.settings, key), getattr(expect.settings, key)
        option, unit, factor = OPTIONS[key]
        if found != wanted and (factor is None or not math.isclose(found, wanted, rel_tol=SAME)):
            law = f'; give contact.normal = "{found}" to run with it as it is' if key == "normal" else ""
            raise InputError(
                path,
                f"was built for {option[2:]} {in_units(key, found)} {unit}".rstrip()
                + f", needed: {in_units(key, wanted)} {unit}".rstrip()
                + f"; build it again: {expect.rebuild(path)}{law}",
            )
    for kind in ("wheel", "rail"):
        profile = getattr(expect, kind)
        if getattr(table, f"{kind}_digest") != profile.digest():
            name = getattr(table, f"{kind}_name")
            other = "another one of this name" if name == profile.name else name
            raise InputError(
                path, f"was built for {kind} profile {other}, needed: {profile.name}; "
                f"build it again: {expect.rebuild(path)}"
            )  # fmt: skip


def profiles_of(table, path, wheel=None, rail=None):
    """The profiles from which a table was built: bundled ones by their name, others as the user gives them.

    Parameters
    ----------
    table : ContactTable
    path : path-like
        Its file, for messages.
    wheel, rail : str, optional
        Names or files.

    Returns
    -------
    wheel, rail : Profile
    """
    profiles = []
    for kind, given in (("wheel", wheel), ("rail", rail)):
        name = getattr(table, f"{kind}_name")
        if given is None and name not in BUNDLED:
            raise InputError(path, f"was built from the {kind} profile {name}: give its file with --{kind}")
        profile = load_profile(given or name, kind)
        if profile.digest() != getattr(table, f"{kind}_digest"):
            raise InputError(
                path, f"was built from another {kind} profile ({name}) than {given or name}; "
                f"give the one it was built from with --{kind}, or build it again"
            )  # fmt: skip
        profiles.append(profile)
    return profiles


def cached_path(settings, wheel, rail, method="simplex"):
    """Where the cache keeps the table of these settings and profiles."""
    return cache_root() / CACHE / f"{table_key(settings, wheel.digest(), rail.digest(), method)[:32]}.h5"
