"""The reference profiles and tables of EN 15302 that `railcli validate conicity` compares with, and its criteria."""

import tomllib

import numpy as np

from railcli.analysis.conicity_check import COMBINATIONS, Tables
from railcli.errors import InputError

from .profiles import load_profile
from .resources import resource

FOLDER = "benchmarks/conicity"


def reference_profiles(digitised=False):
    """Wheels and rail of the standard: name -> Profile; from its sections, or the digitised points of 2008."""
    folder = f"{FOLDER}/digitised" if digitised else FOLDER
    kinds = {"wheel_a": "wheel", "wheel_h": "wheel", "rail_a": "rail"}
    return {name: load_profile(resource(f"{folder}/{name}.csv"), kind) for name, kind in kinds.items()}


def reference_tables():
    """Published delta-r and conicity: (edition, combination) -> Tables."""
    found = {}
    for edition in ("2021", "2008"):
        for combination in COMBINATIONS:
            delta_r = _rows("delta_r", edition, combination)
            conicity = _rows("conicity", edition, combination)
            found[edition, combination] = Tables(*delta_r.T * 1e-3, conicity[:, 0] * 1e-3, conicity[:, 1])
    return found


def conicity_criteria():
    """Criteria of the comparison: group -> name -> limit, units in the names."""
    path = resource(f"{FOLDER}/accept.toml")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise _not_ours(path, error) from None


def _rows(name, edition, combination):
    path = resource(f"{FOLDER}/reference/{name}.csv")
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    try:
        return np.array([[float(cell) for cell in row[2:]] for row in rows[1:] if row[:2] == [edition, combination]])
    except ValueError as error:
        raise _not_ours(path, error) from None


def _not_ours(path, error):
    return InputError(path, f"is not the file that came with railcli ({error}); install railcli again")
