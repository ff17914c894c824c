"""Where the files that come with railcli are."""

from pathlib import Path

from railcli.errors import InputError

_PACKAGE = Path(__file__).resolve().parents[1]
_ROOTS = (_PACKAGE / "_data", _PACKAGE.parent)  # in an installed package; beside the package in a checkout


def resource(relative):
    """Path of a bundled file or folder, for example ``profiles/UIC60/UIC60.csv``."""
    for root in _ROOTS:
        if (root / relative).exists():
            return root / relative
    raise InputError(relative, "this file comes with railcli but is missing here; install railcli again")
