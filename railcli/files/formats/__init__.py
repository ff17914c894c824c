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

__all__ = ["ENDINGS", "Measured", "read_points", "recognised"]


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
    reader, kind = ENDINGS.get(path.suffix.lower()) or (recognised(text) or columns.read, None)
    return reader(path, text, kind)


def recognised(text):
    """The reader of a format that shows in what its files contain; None if nothing shows."""
    head = text[:5000].lower()
    if "[mdi_header]" in head:
        return _refuse_teimorbit
    if "header.begin" in head or "spline.begin" in head:
        return simpack.read
    if "columndef=" in head or head.lstrip().startswith(("#mini", "miniprof")):
        return miniprof.read
    return None


def _refuse_teimorbit(path, text, kind):
    raise InputError(path, "this is a TeimOrbit file (VI-Rail, ADAMS); export the points as two columns, y and z")
