"""Where results go, and how a file appears there: whole, under its name, or not at all.

A results folder holds a small text file that lists what railcli wrote into it, with checksums. That list is what
`--overwrite` may replace; anything else in the folder, and what was changed since, belongs to the user and stays.
A file that is being written has a name of its own, which no file of a user has, and a lock: what a killed process left
behind is known by both.
"""

import errno
import hashlib
import json
import math
import os
import re
import secrets
import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

from railcli.errors import InputError

from . import lock

DEFAULT_PARENT = "railcli-out"
LIST = ".railcli"
LIST_TITLE = "# Files that railcli wrote here; --overwrite may replace these and no others.\n"
LONGEST_NAME = 80
PART = ".railcli-part-"  # how the name of a file begins that is being written
OF_A_PART = 40  # letters of the name to come, in it

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
def results_folder(command, name, output=None, overwrite=False, reads=()):
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
    reads : iterable of path-like
        Results that the command reads: they are not to be overwritten by it.

    Yields
    ------
    pathlib.Path

    Raises
    ------
    InputError
        The folder exists, holds only files of others or files that were changed since, is written by another
        command, is what this one reads, or cannot be written.
    """
    if output is None:
        parent, title = Path(DEFAULT_PARENT), file_name(f"{command}-{name}")
        with refused(parent / title):
            folder = _next_folder(parent, title)
    else:
        folder = Path(output)
        for place in map(Path, reads):
            if place.exists() and folder.resolve() in (place.resolve(), place.resolve().parent):
                raise InputError(folder, f"holds what this command reads ({place}); choose another place (-o/--output)")
        with refused(folder):
            _take_folder(folder, overwrite)
    try:
        with refused(folder / LIST):
            if not (folder / LIST).exists():
                (folder / LIST).write_text(LIST_TITLE, encoding="utf-8")
        with lock.busy(folder / LIST) as free:
            if not free:
                raise InputError(folder, "another railcli command writes there; wait for it or choose another place")
            with refused(folder):
                _delete_listed(folder)
            yield folder
    finally:
        with suppress(OSError):
            _drop_if_unused(folder)


def output_file(path, overwrite=False):
    """Return `path` as a Path once it is clear that a file may be written there, before any work is done for it.

    Raises
    ------
    InputError
        The file exists and `overwrite` is not set, something that is not a file stands there, or the system lets no
        file be made in its folder, or in the nearest one that exists.
    """
    path = Path(path)
    with refused(path):
        if path.is_dir():
            raise InputError(path, "is a folder; -o/--output names a file here")
        if path.exists() and not path.is_file():
            raise InputError(path, "is a device, not a file; choose another place with -o/--output")
        if path.exists() and not overwrite:
            raise InputError(path, "exists already; choose another place with -o/--output or add --overwrite")
        parent = next(folder for folder in path.parents if folder.exists())
        try:
            tempfile.TemporaryFile(dir=parent).close()
        except OSError as error:
            raise refusal(path, error) from error
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
    temporary = descriptor = None
    try:
        with refused(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            forget_parts(path.parent)
            while temporary is None:
                temporary = path.with_name(f"{PART}{secrets.token_hex(4)}-{path.stem[:OF_A_PART]}{path.suffix}")
                descriptor = lock.new(temporary)
                if not temporary.exists():  # another process took it for a leftover
                    os.close(descriptor)
                    temporary = descriptor = None
        with refused(path):
            yield temporary
            with open(temporary, "r+b") as file:
                os.fsync(file.fileno())
                digest = hashlib.file_digest(file, "sha256").hexdigest() if _list_above(path) else ""
            _enlist(path, digest)
            os.replace(temporary, path)
    finally:
        with suppress(OSError, AttributeError):
            temporary.unlink()
        if descriptor is not None:
            os.close(descriptor)


def parts(folder, name=""):
    """Files in a folder that are being written, or were when a process was killed; those that were to get a name."""
    end = f"-{Path(name).stem[:OF_A_PART]}{Path(name).suffix}" if name else ""
    with suppress(OSError):
        return [Path(folder, each) for each in os.listdir(folder) if each.startswith(PART) and each.endswith(end)]
    return []


def forget_parts(folder, spare=True):
    """Delete what killed processes left in a folder; time series, which can be read, only when asked to."""
    for path in parts(folder):
        if not (spare and path.name.endswith("-timeseries.h5")):
            lock.delete_if_free(path)


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
    """Write a whole UTF-8 text file with Unix line ends; bytes of a file's name that are no text become escapes."""
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n", errors="backslashreplace")


def write_json(path, value):
    """Write a whole JSON file; see `json_text`."""
    write_text(path, json_text(value) + "\n")


def json_text(value):
    """Return strict JSON: NumPy scalars and arrays as numbers and lists, NaN and infinity as null, paths as text."""
    text = json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False)
    return "".join(letter if letter.isprintable() or letter == "\n" else json.dumps(letter)[1:-1] for letter in text)


def cell(text):
    """A user's words as a cell of a CSV file: quoted where it is needed, and no formula to a spreadsheet."""
    text = "".join(letter if letter.isprintable() else " " for letter in text)
    text = f"'{text}" if text.startswith(("=", "+", "-", "@")) else text
    return '"' + text.replace('"', '""') + '"' if any(sign in text for sign in ',;"') else text


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
        named = str(error.filename)
        if error.filename is None and is_refusal(error) or named in ours or os.path.basename(named).startswith(PART):
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
    elif not (folder / LIST).is_file() and any(folder.iterdir()):
        raise InputError(folder, "holds files that railcli did not write, --overwrite spares them; give a new folder")


def is_changed(path):
    """True when a file is not what railcli wrote, by the list of its folder; False when it is, or no list tells."""
    path = Path(path)
    folder = _list_above(path)
    digest = folder and _listed(folder).get(path.relative_to(folder).as_posix())
    return bool(digest) and _digest(path) != digest


def _digest(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _listed(folder):
    """Names of files in the list of a folder, and the SHA-256 of each; empty where an earlier version wrote none."""
    lines = (folder / LIST).read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    found = (re.fullmatch(r"(?:([0-9a-f]{64})  )?(.+)", line) for line in lines if not line.startswith("#"))
    return {match[2]: match[1] or "" for match in found if match}


def _delete_listed(folder):
    """Delete what the list names, if nothing was changed since, and only inside the folder, whatever the list says."""
    home = folder.resolve()
    listed = {folder / name: digest for name, digest in _listed(folder).items()}
    inside = {path: digest for path, digest in listed.items() if path.parent.resolve().is_relative_to(home)}
    inside = {path: digest for path, digest in inside.items() if path.is_file()}
    for path, digest in inside.items():
        if digest and _digest(path) != digest:
            raise InputError(
                path, "was changed since railcli wrote it, --overwrite spares it; move it away or give a new folder"
            )
    for path in inside:
        path.unlink()
    forget_parts(folder, spare=False)
    (folder / LIST).write_text(LIST_TITLE, encoding="utf-8")


def _list_above(path):
    """The results folder that a file lies in; None without one."""
    return next((folder for folder in path.parents if (folder / LIST).is_file()), None)


def _enlist(path, digest):
    if folder := _list_above(path):
        name = path.relative_to(folder).as_posix()
        if _listed(folder).get(name) != digest:
            with open(folder / LIST, "a", encoding="utf-8", errors="surrogateescape") as file:
                file.write(f"{digest}  {name}\n")


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
