"""Where results go, and how a file appears there: whole, under its name, or not at all.

A results folder holds a small text file that lists what railcli wrote into it. That list is what `--overwrite`
may replace; anything else in the folder belongs to the user and stays.
"""

import errno
import json
import math
import os
import re
import secrets
from contextlib import contextmanager, suppress
from pathlib import Path

from railcli.errors import InputError
from railcli.kernels.place import cache_root

DEFAULT_PARENT = "railcli-out"
LIST = ".railcli"
LIST_TITLE = "# Files that railcli wrote here; --overwrite may replace these and no others.\n"
LONGEST_NAME = 80

_ELSEWHERE = "choose another place (-o/--output, or RAILCLI_CACHE_DIR for the cache)"
_FULL = f"the disk is full; free some space or {_ELSEWHERE}"
_FORBIDDEN = f"no permission to write there; {_ELSEWHERE}"
_IN_THE_WAY = f"a file stands where a folder is needed; {_ELSEWHERE}"
_REASONS = {
    errno.ENOSPC: _FULL,
    getattr(errno, "EDQUOT", errno.ENOSPC): _FULL,
    errno.EFBIG: f"the file grows larger than the system allows; {_ELSEWHERE}",
    errno.EACCES: _FORBIDDEN,
    errno.EPERM: _FORBIDDEN,
    errno.EROFS: f"the file system is read-only; {_ELSEWHERE}",
    errno.ENOTDIR: _IN_THE_WAY,
    errno.EEXIST: _IN_THE_WAY,
    errno.EISDIR: f"a folder stands where a file is needed; {_ELSEWHERE}",
    errno.ENAMETOOLONG: f"the name is too long; {_ELSEWHERE}",
}


def is_refusal(error):
    """True when an OSError says that the system does not let us write."""
    return error.errno in _REASONS


def refusal(path, error, kept=""):
    """Return the InputError that tells the user why `path` cannot be written, and what of it is `kept` (a sentence)."""
    reason = f"cannot be written: {_REASONS.get(error.errno) or error.strerror or error}"
    return InputError(path, f"{reason}. {kept}" if kept else reason)


@contextmanager
def results_folder(command, name, output=None, overwrite=False):
    """Folder for the results of one run; it is left only if a file was written into it.

    Parameters
    ----------
    command, name : str
        Command and scenario (or case); they name the default folder ``railcli-out/<command>-<name>-<number>``.
    output : path-like, optional
        Folder that the user gave. It must not exist, unless `overwrite` is set.
    overwrite : bool
        Take a folder that exists if it is empty or a results folder. The files that railcli wrote into it are
        deleted now, those of the user stay.

    Yields
    ------
    pathlib.Path

    Raises
    ------
    InputError
        The folder exists, holds only files of others, or cannot be written.
    """
    if output is None:
        parent, title = Path(DEFAULT_PARENT), file_name(f"{command}-{name}")
        with refused(parent / title):
            folder = _next_folder(parent, title)
    else:
        folder = Path(output)
        with refused(folder):
            _take_folder(folder, overwrite)
    try:
        with refused(folder / LIST):
            if not (folder / LIST).exists():
                (folder / LIST).write_text(LIST_TITLE, encoding="utf-8")
        yield folder
    finally:
        with suppress(OSError):
            _drop_if_unused(folder)


def output_file(path, overwrite=False):
    """Return `path` as a Path once it is clear that a file may be written there.

    Raises
    ------
    InputError
        The file exists and `overwrite` is not set, or something that is not a file stands there.
    """
    path = Path(path)
    with refused(path):
        if path.is_dir():
            raise InputError(path, "is a folder; -o/--output names a file here")
        if path.exists() and not path.is_file():
            raise InputError(path, "is a device, not a file; choose another place with -o/--output")
        if path.exists() and not overwrite:
            raise InputError(path, "exists already; choose another place with -o/--output or add --overwrite")
    return path


@contextmanager
def whole_file(path):
    """Give a temporary path beside `path`; when the block succeeds, flush it to disk and rename it.

    After any exception, Ctrl-C too, `path` is as it was before and the temporary file is gone.

    Parameters
    ----------
    path : path-like
        The file to appear or to be replaced; its folder is made if it is missing.

    Yields
    ------
    pathlib.Path
        An empty file with the same ending, to be filled (and closed) by the block.
    """
    path = output_file(path, overwrite=True)
    temporary = path.with_name(f".{path.stem[:LONGEST_NAME]}-{secrets.token_hex(4)}{path.suffix}")
    try:
        with refused(path, temporary):
            path.parent.mkdir(parents=True, exist_ok=True)
            temporary.touch(exist_ok=False)
            yield temporary
            with open(temporary, "r+b") as file:
                os.fsync(file.fileno())
            _enlist(path)
            os.replace(temporary, path)
    finally:
        with suppress(OSError):
            temporary.unlink()


@contextmanager
def whole_hdf5(path, head=None):
    """Give a new HDF5 file that exists in memory only; when the block succeeds, write it as a `whole_file`.

    The HDF5 library itself never writes to the disk: on a full one it cannot close its file and takes the whole
    process down at its end (seen with h5py 3.16).

    Parameters
    ----------
    path : path-like
    head : callable, optional
        Gives, for the bytes of the HDF5 file, the 512 bytes to put before them, which HDF5 readers skip.

    Yields
    ------
    h5py.File
    """
    import h5py

    with whole_file(path) as temporary:
        with h5py.File(temporary.name, "w", driver="core", backing_store=False) as file:
            yield file
            file.flush()
            image = file.id.get_file_image()
        with open(temporary, "wb") as target:
            if head is not None:
                target.write(head(image))
            target.write(image)


def write_text(path, text):
    """Write a whole UTF-8 text file with Unix line ends."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_json(path, value):
    """Write a whole JSON file; see `json_text`."""
    write_text(path, json_text(value) + "\n")


def json_text(value):
    """Return strict JSON: NumPy scalars and arrays as numbers and lists, NaN and infinity as null, paths as text."""
    return json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def cache_folder(kind):
    """Folder in the user's cache, made if missing.

    ``RAILCLI_CACHE_DIR`` names the cache; else it lies where the platform keeps caches (``XDG_CACHE_HOME``,
    ``LOCALAPPDATA``, ``~/Library/Caches``).

    Parameters
    ----------
    kind : str
        Name of the sub-folder, such as ``tables``.
    """
    folder = cache_root() / kind
    with refused(folder):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def file_name(text):
    """Return `text` as a name that every file system takes: letters, digits, dot, dash, underscore."""
    return re.sub(r"[^\w.-]+", "_", text, flags=re.ASCII)[:LONGEST_NAME].strip("._") or "unnamed"


@contextmanager
def refused(*paths):
    """Turn the system's refusal to write the first of `paths` into an InputError; errors of other files pass."""
    try:
        yield
    except OSError as error:
        ours = {str(place) for path in paths for place in (path, *path.parents)}
        if error.filename is None and is_refusal(error) or str(error.filename) in ours:
            raise refusal(paths[0], error) from error
        raise


def _next_folder(parent, title):
    parent.mkdir(parents=True, exist_ok=True)
    numbers = [path.name[len(title) + 1 :] for path in parent.glob(f"{title}-*")]
    number = 1 + max((int(text) for text in numbers if text.isdecimal()), default=0)
    while True:
        folder = parent / f"{title}-{number}"
        try:
            folder.mkdir()
        except FileExistsError:
            number += 1
        else:
            return folder


def _take_folder(folder, overwrite):
    if not (folder.exists() or folder.is_symlink()):
        folder.mkdir(parents=True)
    elif not folder.is_dir():
        raise InputError(folder, "is a file; -o/--output names a folder here")
    elif not overwrite:
        raise InputError(folder, "exists already; choose another place with -o/--output or add --overwrite")
    elif (folder / LIST).is_file():
        _delete_listed(folder)
    elif any(folder.iterdir()):
        raise InputError(folder, "holds files that railcli did not write, --overwrite spares them; give a new folder")


def _listed(folder):
    lines = (folder / LIST).read_text(encoding="utf-8", errors="replace").splitlines()
    return {line for line in lines if line and not line.startswith("#")}


def _delete_listed(folder):
    """Delete what the list names, and only inside the folder, whatever the list says."""
    home = folder.resolve()
    for name in _listed(folder):
        path = folder / name
        if path.parent.resolve().is_relative_to(home) and path.is_file():
            path.unlink()
    (folder / LIST).write_text(LIST_TITLE, encoding="utf-8")


def _enlist(path):
    for folder in path.parents:
        if (folder / LIST).is_file():
            name = path.relative_to(folder).as_posix()
            if name not in _listed(folder):
                with open(folder / LIST, "a", encoding="utf-8") as file:
                    file.write(name + "\n")
            return


def _drop_if_unused(folder):
    if [path.name for path in folder.iterdir()] == [LIST]:
        (folder / LIST).unlink()
        folder.rmdir()


def _plain(value):
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
