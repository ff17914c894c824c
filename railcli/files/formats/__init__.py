"""Readers of the profile files that users have; each gives a `Measured`, in the file's own numbers.

The reader is chosen by the file's ending and, where that says nothing, by what the file contains. Only `InputError`
leaves a reader.
"""

from pathlib import Path

from railcli.errors import InputError

from ..profiles import profile_text
from . import columns, miniprof, simpack
from .measured import Measured

ENDINGS = {
    ".ban": (miniprof.read, "rail"),
    ".whl": (miniprof.read, "wheel"),
    ".mpt": (miniprof.read_template, None),
    ".prr": (simpack.read, "rail"),
    ".prw": (simpack.read, "wheel"),
    ".rail": (columns.read_gensys, "rail"),
    ".wheel": (columns.read_gensys, "wheel"),
}

__all__ = ["Measured", "read_points"]


def read_points(path):
    """Points and declared conventions of a profile file.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Measured

    Raises
    ------
    InputError
        In one line: file and line, what was found, what is needed.
    """
    path = Path(path)
    text = profile_text(path)
    reader, kind = ENDINGS.get(path.suffix.lower()) or (_recognise(text, path), None)
    return reader(path, text, kind)


def _recognise(text, path):
    head = text[:5000].lower()
    if "[mdi_header]" in head:
        raise InputError(path, "this is a TeimOrbit file (VI-Rail, ADAMS); export the points as two columns, y and z")
    if "header.begin" in head or "spline.begin" in head:
        return simpack.read
    if "columndef=" in head or head.lstrip().startswith(("#mini", "miniprof")):
        return miniprof.read
    return columns.read
