"""The published values that `railcli validate` compares with, and the criteria of the comparison."""

import tomllib

import numpy as np

from railcli.analysis.validate import Reference
from railcli.errors import InputError

from .resources import resource


def manchester_reference():
    """Lateral displacements of the published curve, as printed.

    Returns
    -------
    Reference
    """
    path = resource("benchmarks/manchester/reference/lateral_displacement.csv")
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    try:
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        speeds = tuple(dict.fromkeys(rows[:, 0].tolist()))
        shape = (len(speeds), 4)
        return Reference(speeds, rows[:, 2].reshape(shape), rows[:, 3].reshape(shape))
    except (ValueError, IndexError) as error:
        raise _not_ours(path, error) from None


def manchester_criteria():
    """Criteria of the comparison: group -> name -> limit, units in the names."""
    path = resource("benchmarks/manchester/accept.toml")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise _not_ours(path, error) from None


def _not_ours(path, error):
    return InputError(path, f"is not the file that came with railcli ({error}); install railcli again")
