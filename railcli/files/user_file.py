"""Files that users give: regular ones of limited size are read, all else is one line before anything is read."""

import codecs
import os
import stat
from pathlib import Path

from railcli.errors import InputError

LONGEST_LINE = 100_000  # bytes
TEXT_BYTES = set(range(32)) - set(b"\t\n\r\f")  # of which no text has any


def regular(path, what, absent="no such file", most_mb=None):
    """Size of a file in bytes, if it is a regular one of at most `most_mb` MB; else an InputError.

    Parameters
    ----------
    path : path-like
    what : str
        What is needed, with its article: "a TOML file".
    absent : str
        What to say of a file that is not there.
    most_mb : float, optional
        No limit without it.
    """
    try:
        found = os.stat(path)
    except FileNotFoundError:
        raise InputError(path, absent) from None
    except OSError as error:
        raise unreadable(path, error) from error
    except ValueError:
        raise InputError(path, "no file can have this name: it contains a null character") from None
    if stat.S_ISDIR(found.st_mode):
        raise InputError(path, f"is a folder, not {what}")
    if not stat.S_ISREG(found.st_mode):
        raise InputError(path, f"is not a regular file; give {what}")
    if most_mb is not None and found.st_size > most_mb * 1e6:
        raise InputError(path, f"{found.st_size / 1e6:.1f} MB; {what} may have at most {most_mb:g} MB")
    return found.st_size


def read_bytes(path, what, most_mb, absent="no such file"):
    """Contents of a file; parameters and errors as `regular`."""
    regular(path, what, absent, most_mb)
    most = int(most_mb * 1e6)
    try:
        with open(path, "rb", opener=_without_waiting) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise InputError(path, f"is not a regular file; give {what}")
            data = file.read(most + 1)
    except OSError as error:
        raise unreadable(path, error) from error
    if len(data) > most:
        raise InputError(path, f"more than {most_mb:g} MB; {what} may have no more")
    return data


def plain_text(path, what, most_mb, most_lines, absent="no such file", advice="give a text file"):
    """Text of a file without bytes that no text has: UTF-8, with or without its mark, else Latin-1 (Windows).

    Parameters
    ----------
    path : path-like
    what, most_mb, absent
        As `regular`.
    most_lines : int
    advice : str
        What to do about a file that is no text.

    Returns
    -------
    text, encoding : str
    """
    data = read_bytes(path, what, most_mb, absent)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", errors="replace").encode()
    if strange := set(data) & TEXT_BYTES:
        raise InputError(path, f"this is a binary file (it contains byte {min(strange)}); {advice}")
    if (count := max(data.count(b"\n"), data.count(b"\r"))) > most_lines:
        raise InputError(path, f"{count} lines; {what} may have at most {most_lines}: thin the points out")
    for number, line in enumerate(data.replace(b"\r", b"\n").split(b"\n"), start=1):
        if len(line) > LONGEST_LINE:
            raise InputError(f"{path}, line {number}", f"{len(line)} bytes in one line; {advice}")
    try:
        return data.decode("utf-8-sig"), "UTF-8"
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace"), "Latin-1"


def title_of(path):
    """The name of a file without folder and ending, as words: of bytes that are no text signs stand for them."""
    return os.fsencode(Path(path).stem).decode("utf-8", errors="replace")


def is_there(path):
    """True if a name stands for something in the file system."""
    try:
        return Path(path).exists()
    except (OSError, ValueError):
        return False


def unreadable(path, error):
    """The InputError for a file that the system does not let us read."""
    return InputError(path, f"cannot be read: {error.strerror or error}")


def _without_waiting(path, flags):
    """Open, but never wait for a writer: what a name stands for may change after it was looked at."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
