"""Contact tables that the cache keeps: those that were used last, up to a bound."""

import json
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from railcli.errors import InputError
from railcli.kernels.place import cache_root

from . import lock, seal
from .output import forget_parts
from .tables import CACHE

VARIABLE = "RAILCLI_CACHE_GB"
MOST_GB = 4.0  # some 50 tables
NAME = re.compile(r"[0-9a-f]{32}\.h5")


class Kept(NamedTuple):
    """A table of the cache: its file, size [bytes], when it was used [s since 1970], and what it is of."""

    file: Path
    size: int
    used: float
    about: str


def most_bytes():
    """What the tables together may take."""
    text = os.environ.get(VARIABLE) or MOST_GB
    try:
        most = float(text)
    except ValueError:
        most = -1.0
    if not 0.0 <= most < 1e9:
        raise InputError(VARIABLE, f"is {text!r}; give a number of GB, such as {MOST_GB:g}")
    return most * 1e9


def kept():
    """Tables in the cache, the one that was used last first."""
    return [Kept(path, size, used, _about(path)) for used, size, path in _files()]


def used(path):
    """Note that a table was used now."""
    with suppress(OSError):
        os.utime(path)


def make_room(spared):
    """Delete what killed processes left, and beyond the bound what was used longest ago, but not the file `spared`."""
    forget_parts(_folder(), spare=False)
    left = most_bytes()
    for _, size, path in _files():
        left -= size
        if left < 0.0 and path != spared:
            with suppress(OSError):
                path.unlink()


def forget_all():
    """Delete every table, and what killed processes left; locks that are held stay."""
    forget_parts(_folder(), spare=False)
    for _, _, path in _files():
        with suppress(OSError):
            path.unlink()
    with suppress(OSError):
        for path in _folder().glob(".*.lock"):
            lock.delete_if_free(path)


def _folder():
    return cache_root() / CACHE


def _files():
    """When it was used, size and path of every table, the one that was used last first."""
    found = []
    with suppress(OSError):
        for path in _folder().iterdir():
            if NAME.fullmatch(path.name):
                with suppress(OSError):
                    state = path.stat()
                    found.append((state.st_mtime, state.st_size, path))
    return sorted(found, reverse=True)


def _about(path):
    """Profiles and normal law, by the head alone."""
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            normal = json.loads(file.attrs["settings"])["normal"]
            return f"{file.attrs['wheel_name']} on {file.attrs['rail_name']}, {normal}"
    except seal.UNREADABLE:
        return "a damaged file"
