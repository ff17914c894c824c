"""What `railcli validate braking` compares with, its criteria, and the scenarios it runs."""

import csv
import tomllib

import numpy as np

from railcli.analysis.braking_check import IN_CURVE, References, Stopped
from railcli.errors import InputError

from .resources import resource
from .scenario import load

FOLDER = "benchmarks/braking"


def braking_criteria():
    """Criteria of the comparison: group -> name -> limit, units in the names."""
    path = resource(f"{FOLDER}/accept.toml")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise _not_ours(path, error) from None


def braking_reference():
    """All reference values, as References.

    Raises
    ------
    InputError
        A file is not the one that came with railcli.
    """
    stops = {row[0]: Stopped(*map(_number, row[1:6]), *(_number(one) / 100.0 for one in row[6:8]), _number(row[8]))
             for row in _rows("set_m")}  # fmt: skip
    header, *rows = _rows("polach", header=True)
    creepages = np.array(header[2:-2], float)
    polach = [
        (float(row[0]), row[1], creepages, np.array(row[2:-2], float), float(row[-2]), float(row[-1])) for row in rows
    ]
    percentages = [
        (float(row[0]), float(row[1]) / 3.6, float(row[2]), _number(row[3])) for row in _rows("braked_weight")
    ]
    return References(stops, polach, percentages)


def braking_scenarios(references):
    """The scenarios of the comparison by their names."""
    return {name: load(name) for name in (*references.stops, IN_CURVE)}


def _rows(name, header=False):
    path = resource(f"{FOLDER}/reference/{name}.csv")
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.reader(lines))
    if len(rows) < 2 or any(len(row) != len(rows[0]) for row in rows):
        raise _not_ours(path, "rows differ in length")
    return rows if header else rows[1:]


def _number(text):
    return float(text) if text else np.nan


def _not_ours(path, error):
    return InputError(path, f"is not the file that came with railcli ({error}); install railcli again")
