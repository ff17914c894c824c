"""Limits and conditions of an assessment from a TOML file."""

from railcli.model.assessment import Limits

from . import toml


def load_limits(path):
    """Limits of a file; what it leaves out keeps its default.

    Raises
    ------
    InputError
        One line: file, key, what was found, what is allowed.
    """
    return toml.build(Limits, toml.read(path), path)
