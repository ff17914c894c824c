"""What `railcli validate curves` compares with, its criteria, and the scenarios it runs."""

import csv
import tomllib

import numpy as np

from railcli.analysis.curves_check import References
from railcli.analysis.curving_check import Codes
from railcli.analysis.decay_check import Decays
from railcli.analysis.rigid_contact import wheelset_on
from railcli.errors import InputError
from railcli.model.system import table_settings

from .benchmark import manchester_reference
from .profiles import profile_of
from .resources import resource
from .scenario import load

FOLDER = "benchmarks/curves"
PROGRAMS = {"um": "UM", "adams": "ADAMS"}


def curves_criteria():
    """Criteria of the comparison: group -> name -> limit, units in the names."""
    path = resource(f"{FOLDER}/accept.toml")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise _not_ours(path, error) from None


def curves_reference():
    """All reference values.

    Returns
    -------
    References

    Raises
    ------
    InputError
        A file is not the one that came with railcli.
    """
    return References(_read(("curve_150",), _codes), _read(("swing", "decay", "contact_table"), _decays),
                      manchester_reference())  # fmt: skip


def curves_scenarios(laws=None):
    """The curve of 150 m, the Cooperrider wagon and the curve of 1200 m.

    Parameters
    ----------
    laws : dict, optional
        ``creep_law`` and ``normal`` that replace those of the first two.
    """
    first, second = (load(resource(f"{FOLDER}/cases/{name}.toml")) for name in ("curve-150", "cooperrider"))
    return first.varied(contact=laws or {}), second.varied(contact=laws or {}), load("curve-1200-45")


def wheelset_of(scenario):
    """Rigid wheelset of a scenario whose wheels are alike, over its track."""
    contact = scenario.contact
    profiles = (profile_of(scenario, place, kind) for place, kind in
                ((contact.wheel_profile, "wheel"), (contact.rail_profile, "rail")))  # fmt: skip
    return wheelset_on(table_settings(scenario, scenario.vehicle.wheel_radii[0][0]), *profiles)


def _read(names, read):
    """What `read` makes of the rows of reference files: for each file a list of dict of str."""
    paths = [resource(f"{FOLDER}/reference/{name}.csv") for name in names]
    tables = []
    for path in paths:
        lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        tables.append(list(csv.DictReader(lines)))
    try:
        return read(*tables)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise _not_ours(paths[0].parent, error) from None


def _codes(rows):
    values = np.array([[float(row[code] or "nan") for code in PROGRAMS] for row in rows])
    quantity, wheelset = (tuple(kind(row[key]) for row in rows) for key, kind in (("quantity", str), ("wheelset", int)))
    return Codes(tuple(PROGRAMS.values()), quantity, wheelset, values)


def _decays(swing, decay, contact):
    def column(rows, key, factor=1.0):
        return factor * np.array([float(row[key]) for row in rows])

    return Decays(
        column(swing, "speed_m_per_s"), column(swing, "half_swing_mm", 1e-3), column(decay, "speed_m_per_s"),
        column(decay, "rate_1_per_s"), column(decay, "frequency_Hz"), column(contact, "y_mm", 1e-3),
        column(contact, "on_wheel_mm", 1e-3), column(contact, "radius_mm", 1e-3), column(contact, "angle_rad"),
    )  # fmt: skip


def _not_ours(path, error):
    return InputError(path, f"is not the file that came with railcli ({error}); install railcli again")
