"""A results folder opened for reading: channels with units, the scenario, the provenance.

Values come from the file when they are asked for, whole or piece by piece, so that the length of a run needs no memory.
"""

import json
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import ValidationError

from railcli.errors import InputError
from railcli.model.scenario import Scenario

from . import lock, seal
from .filtered_series import CHUNK, FILTERED, OF_INTERVAL, PARTS
from .growing_hdf5 import CHUNK_CACHE
from .inputs import SCENARIO, restore
from .output import is_changed, parts
from .results import FORMAT, FORMAT_VERSION, TIME_SERIES
from .user_file import read_bytes, regular, unreadable

SUMMARY = "summary.json"
LARGEST_MB = 64  # of scenario and summary
PIECE = 10 * CHUNK  # rows that `pieces` gives at once
COMPONENTS = {"position": ("s", "y", "z"), "rotation": ("roll", "pitch", "yaw"), "T_gamma": PARTS}
READABLE = (1, 2, FORMAT_VERSION)  # rows of version 1 are instants throughout; 2 was not sealed
HDF5 = b"\x89HDF\r\n\x1a\n"  # how a file without a head begins
AXES = ("x", "y", "z")
_ASK_AGAIN = "run the scenario again"


class Channel(NamedTuple):
    """What a dataset of the time series is.

    Attributes
    ----------
    name : str
        Its path in the file, such as ``wheels/W1_right/Q``.
    units, description : str
    components : tuple of str
        Names of its columns; empty when a row is one number.
    of_interval : bool
        Means or extremes of steps: another interval between rows gives other values.
    """

    name: str
    units: str
    description: str
    components: tuple
    of_interval: bool = False


class Rows:
    """Channels of one group of a file of time series, all with the same number of rows.

    Attributes
    ----------
    channels : dict of str to Channel
        In the order of the file; ``time`` is the first.
    rows : int
        Of every channel.
    bodies, wheelsets, wheels : tuple of str
        Names, as they stand in the names of channels.
    """

    def _hold(self, path, group, apart=()):
        """Take over what a group of the file holds, but for groups of these names in it."""
        import h5py

        self._path, self._group = path, group
        self.rows = int(group["time"].size)
        found = {}

        def visit(name, item):
            if isinstance(item, h5py.Dataset) and name.split("/")[0] not in apart:
                about = (item.attrs[key] for key in ("units", "description"))
                of_interval = bool(item.attrs.get(OF_INTERVAL, False))
                found[name] = Channel(name, *about, components_of(item.name, item.shape), of_interval)
                if item.shape[0] != self.rows:
                    raise KeyError(name)
                seal.check_size(item)

        group.visititems(visit)
        rest = sorted(found, key=lambda name: name.split("/")[0] not in ("time", "traction"))
        self.channels = {name: found[name] for name in ["time", *(name for name in rest if name != "time")]}

    @property
    def time(self):
        """Time of every row, the end of a step [s], (n,)."""
        return self.read("time")

    def read(self, name, start=0, stop=None):
        """Rows of a channel.

        Parameters
        ----------
        name : str
        start, stop : int, optional
            First row, and the one behind the last; all rows by default.

        Returns
        -------
        numpy.ndarray
            Shape (n,) or (n, number of components), in the channel's units; as recorded, in track axes.
        """
        if name not in self.channels:
            raise InputError(self._path, f"holds no channel {name!r}")
        try:
            return self._group[name][start:stop]
        except OSError as error:
            raise InputError(self._path, f"channel {name!r} is damaged ({error}); {_ASK_AGAIN}") from None

    def pieces(self, *names, size=PIECE):
        """Yield tuples of arrays, some rows of each channel at a time."""
        for start in range(0, self.rows, size):
            yield tuple(self.read(name, start, start + size) for name in names)


class Filtered(Rows):
    """What every step of a run gave, at a rate of its own, forces and accelerations low-passed: what is assessed."""

    def __init__(self, results, group):
        self._results, self.folder = results, results.folder
        self.bodies, self.wheelsets, self.wheels = results.bodies, results.wheelsets, results.wheels
        self._hold(results._path, group)

    @property
    def provenance(self):
        """That of the results."""
        return self._results.provenance


class Results(Rows):
    """A results folder of `railcli run`; use it as a context manager, or close it.

    Parameters
    ----------
    path : path-like
        The folder, or the file of time series in it.

    Attributes
    ----------
    folder : pathlib.Path
    channels : dict of str to Channel
        In the order of the file; ``time`` is the first.
    rows : int
        Of every channel.
    bodies, wheelsets, wheels : tuple of str
        Names, as they stand in the names of channels: ``bodies/<body>/position``, ``wheels/<wheel>/Y``. The wheels are
        right and left one of each wheelset in turn.
    filtered : Filtered or None
        None in results of versions of railcli that kept rows only.

    Raises
    ------
    InputError
        Nothing is there, it is damaged, of another program or version, or it holds no rows.
    """

    def __init__(self, path):
        path = Path(path)
        self.folder = path.parent if path.suffix == ".h5" else path
        self._path = path if path.suffix == ".h5" else path / TIME_SERIES
        self._left = not self._path.exists() and self._find_left()
        self._file = self._open()
        try:
            self._read_head()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, kind, error, traceback):
        self.close()

    def close(self):
        """Close the file; what was read stays."""
        self._file.close()

    @property
    def s(self):
        """Arc length of the first body at every row [m], (n,)."""
        return np.concatenate([position[:, 0] for (position,) in self.pieces(f"bodies/{self.bodies[0]}/position")])

    @cached_property
    def scenario(self):
        """The Scenario that was run with all that it was made from, as the folder holds them."""
        path = self.folder / SCENARIO
        values = read_json(path)
        contents = restore(values, self.folder)
        return built_scenario(values, path).knowing(contents)

    @cached_property
    def settings(self):
        """The scenario as the file holds it, whatever version of railcli wrote it; empty without the file."""
        path = self.folder / SCENARIO
        return read_json(path) if path.exists() else {}

    @cached_property
    def summary(self):
        """Contents of the summary; empty when the run broke off before it was written."""
        path = self.folder / SUMMARY
        return read_json(path) if path.exists() else {}

    @property
    def fault(self):
        """What broke the run off; empty when it reached its end."""
        if self._left:
            return "it was killed; these are the rows that it had written until then"
        return self.summary.get("fault", "") if self.summary else "it was interrupted before its summary was written"

    @property
    def provenance(self):
        """Versions, digests, machine and date, as the summary records them; empty without a summary."""
        return self.summary.get("provenance", {})

    def _find_left(self):
        """Take the time series that a killed run left behind, if there are any."""
        found = parts(self.folder, TIME_SERIES)
        if any(lock.state(path) == lock.HELD for path in found):
            raise InputError(self.folder, "its run goes on; wait until it has ended, or end it with Ctrl-C")
        if found:
            self._path = max(found, key=lambda path: path.stat().st_mtime)
        return bool(found)

    def _open(self):
        import h5py

        if not self._path.exists():
            what = "no such folder" if not self.folder.exists() else f"no results of a run: no {self._path.name} there"
            raise InputError(self.folder, f"{what}; `railcli run scenario -o FOLDER` writes one")
        regular(self._path, "a file of time series")
        if not (self._left or self._starts_as_hdf5()):
            seal.check(self._path, FORMAT, "a file of time series", _ASK_AGAIN, "there is no such file")
        try:
            try:
                return h5py.File(self._path, "r", locking=False, rdcc_nbytes=CHUNK_CACHE)
            except OSError as error:
                if "locking flag" not in str(error):
                    raise
                return h5py.File(self._path, "r", rdcc_nbytes=CHUNK_CACHE)  # as this process has it open already
        except OSError as error:
            reason = error.strerror or "it is not HDF5, or cut off"
            raise InputError(self._path, f"cannot be read: {reason}; {_ASK_AGAIN}") from None

    def _starts_as_hdf5(self):
        try:
            with open(self._path, "rb") as file:
                return file.read(len(HDF5)) == HDF5
        except OSError as error:
            raise unreadable(self._path, error) from error

    def _read_head(self):
        head = self._file.attrs
        if head.get("format") != FORMAT:
            raise InputError(self._path, "is an HDF5 file, but not of time series that railcli wrote")
        if (version := head.get("version")) not in READABLE:
            raise InputError(self._path, f"has format version {version}, not {FORMAT_VERSION}; {_ASK_AGAIN}")
        if version == FORMAT_VERSION and not self._file.userblock_size:
            raise InputError(self._path, f"is damaged: its head is gone; {_ASK_AGAIN}")
        try:
            self.bodies, self.wheelsets, self.wheels = (
                tuple(str(name) for name in head[key]) for key in ("bodies", "wheelsets", "wheels")
            )
            self._hold(self._path, self._file, apart=(FILTERED,))
            self.filtered = Filtered(self, self._file[FILTERED]) if FILTERED in self._file else None
        except (KeyError, OSError, RuntimeError, ValueError):
            raise InputError(self._path, f"is damaged: channels are missing or cut off; {_ASK_AGAIN}") from None
        if not self.rows:
            raise InputError(self._path, f"holds no rows; {_ASK_AGAIN}")


def built_scenario(values, path):
    """The Scenario of the values in scenario.json; path : for messages."""
    try:
        return Scenario.model_validate(values, by_alias=True, by_name=False)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise InputError(path, f"is no scenario of this version of railcli: {place}: {first['msg']}") from None


def components_of(name, shape):
    """Names of the columns of a channel of this shape; none of one whose rows are numbers."""
    if len(shape) == 1:
        return ()
    count = shape[1]
    given = COMPONENTS.get(name.rsplit("/", 1)[-1], AXES)
    return given if len(given) == count else tuple(str(k + 1) for k in range(count))


def read_json(path):
    """Table of a JSON file that railcli wrote."""
    data = read_bytes(path, "a file of a results folder", LARGEST_MB, f"is missing; {_ASK_AGAIN}")
    if is_changed(path):
        raise InputError(path, f"is damaged, or was changed by hand: its checksum does not fit; {_ASK_AGAIN}")
    try:
        value = json.loads(data.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(path, f"is damaged, no JSON: {error}") from None
    if not isinstance(value, dict):
        raise InputError(path, "is damaged: it holds no table")
    return value
