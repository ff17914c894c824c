"""Normal contact of every law against a solution on elements: one wheel without friction over y, yaw and load.

Every law is asked the same through the compiled step and its contact table: a pose and a vertical force give patches
that bear it. All places are those of a right wheel, to the field side.
"""

import math
from dataclasses import dataclass

import numpy as np

from railcli.model.submodels import CREEP_LAWS

from .conicity_check import Row
from .contact_benchmark import Bench, Pose
from .rigid_contact import wheel_pose

QUANTITIES = ("sink", "pressure", "area", "place")  # of `deviations`: the first three relative, place [m]
RANKS = {"median": 0.5, "p95": 0.95, "largest": 1.0}


@dataclass(frozen=True)
class NormalStates:
    """States of a right wheel that bears a vertical force without friction; arrays (n,).

    Attributes
    ----------
    y, yaw, roll : arrays
        Of the wheelset [m, rad, rad].
    load : array
        Vertical [N].
    touch : array
        Height of the tape circle's bottom at first touch, in the axes of the rail, down [m].
    values : dict of str to array
        sink (how far below `touch` the load is borne) [m], normal (sum of normal forces) [N], pressure (largest) [Pa],
        area (sum) [m^2], rail, wheel (centre of the load, from the rail's highest point and the tape circle) [m],
        patches, share (of the heaviest patch in `normal`).
    """

    y: np.ndarray
    yaw: np.ndarray
    roll: np.ndarray
    load: np.ndarray
    touch: np.ndarray
    values: dict

    @property
    def loads(self):
        """The vertical forces that occur [N]."""
        return np.unique(self.load)

    def sentence(self, i):
        """State i in words."""
        return f"y {self.y[i] * 1e3:g} mm, yaw {self.yaw[i] * 1e3:g} mrad"


def borne(bench, pose, below, touch, load):
    """What one law gives when the right wheel bears a load in a pose.

    Parameters
    ----------
    bench : Bench
        Of the law, without friction.
    pose : Pose
    below : float
        How far the tape circle's bottom lies under the wheelset's centre [m].
    touch, load : float
        As `NormalStates`.

    Returns
    -------
    dict
        As `NormalStates.values`.
    """
    data = bench.loaded(0, pose, bench.free_spin, load)
    patches = data.contact[0][: int(data.rail[0]["patches"])]
    normal = patches["normal"]
    patches, normal = patches[normal > 0.0], normal[normal > 0.0]
    share = normal / normal.sum()
    rail = bench.on_rail(0, pose, patches)
    return {
        "sink": float(data.q[0, 2]) + below - touch,
        "normal": float(normal.sum()),
        "pressure": float(patches["pressure"].max()),
        "area": float(np.sum(math.pi * patches["semi_x"] * patches["semi_y"])),
        "rail": float(share @ rail),
        "wheel": float(share @ patches["lateral"]),
        "patches": patches.size,
        "share": float(share.max()),
    }


def normal_states(pair, table, reference):
    """The states of a reference by the law of a contact table.

    Parameters
    ----------
    pair : Wheelset
        Of the benchmark.
    table : ContactTable
    reference : NormalStates

    Returns
    -------
    dict
        As `NormalStates.values`.
    """
    bench = Bench(pair, table, creep_law=next(iter(CREEP_LAWS)), friction=0.0)
    found = []
    for y, yaw, roll, load, touch in zip(
        reference.y, reference.yaw, reference.roll, reference.load, reference.touch, strict=True
    ):
        _, below = wheel_pose(pair, 0, y, roll, yaw)
        pose = Pose(float(y), float(yaw), float(roll), (touch - below, math.nan))
        found.append(borne(bench, pose, below, touch, load))
    return {key: np.array([values[key] for values in found], dtype=float) for key in found[0]}


def normal_deviations(values, reference):
    """QUANTITIES of a law against the reference's: array (n,) each; place: the greater of rail and wheel."""
    other = reference.values
    found = {key: values[key] / other[key] - 1.0 for key in ("sink", "pressure", "area")}
    off = np.stack([values[key] - other[key] for key in ("rail", "wheel")])
    found["place"] = np.take_along_axis(off, np.abs(off).argmax(axis=0)[None], axis=0)[0]
    return found


def ranks(off):
    """RANKS of the sizes of deviations."""
    return {name: float(np.quantile(np.abs(off), rank)) for name, rank in RANKS.items()}


def normal_rows(law, values, reference, criteria):
    """Criteria of one normal law.

    Parameters
    ----------
    law : str
    values : dict
        As `NormalStates.values`.
    reference : NormalStates
    criteria : dict
        Group "normal" of accept.toml; they count for the laws that it names in `held`.

    Returns
    -------
    list of Row
    """
    off = normal_deviations(values, reference)
    words = {"sink": "approach", "pressure": "largest pressure", "area": "area", "place": "place [mm]"}
    limits = {key: criteria[f"{key}_mm" if key == "place" else f"{key}_share"] for key in QUANTITIES}
    rows = []
    for load in reference.loads:
        chosen = reference.load == load
        for key in QUANTITIES:
            found = float(np.quantile(np.abs(off[key][chosen]), criteria["of_states"]))
            name = f"normal law {law}, {load * 1e-3:g} kN: {words[key]} in {criteria['of_states']:.0%} of states"
            rows.append(Row(name, 1e3 * found if key == "place" else found, limits[key], law in criteria["held"]))
    return rows
