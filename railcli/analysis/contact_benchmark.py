"""Case A-2.2 of the Manchester contact benchmark: a yawed wheelset rolls steadily at given lateral positions.

Every position is closed as in the reference states: roll from the rigid contact of both wheels, then the same vertical
force on each wheel, each at its own height, and the spin at which no moment about the axle is left. Contact and creep
are those of the compiled core. All values in railcli's axes and signs (docs/nomenclature.md).
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from railcli.errors import SimulationError
from railcli.kernels.layout import Status, freeze, new_data
from railcli.kernels.step import evaluate
from railcli.model.contact_table import TableSettings
from railcli.model.scenario import Contact, Run, Scenario
from railcli.model.system import assemble
from railcli.model.track import Straight, Track
from railcli.model.vehicle import Body, Vehicle

from .certify import direct_contacts
from .conicity_check import Row
from .rigid_contact import SIDES, contact_at, fine_stations, wheel_pose

SPEED = 2.0  # [m/s]
YAW_PER_METRE = 2.4  # of lateral position: 2.4 mrad per mm [rad/m]
FRICTION = 0.30
VERTICAL = 10e3  # on each wheel [N]
GRAVITY = 9.81  # [m/s^2]
YOUNG = 2.0 * 82e9 * (1.0 + 0.28)  # shear modulus 82 GPa, Poisson's ratio 0.28 [Pa]
# The grid of a usual table over the poses of the benchmark: up to 15 mm, 11.3 mrad of roll and 24 mrad of yaw.
SETTINGS = TableSettings(
    normal="hertz",
    inclination=0.0,
    young=YOUNG,
    y_range=16e-3,
    roll_range=12.5e-3,
    yaw_range=30e-3 * math.sqrt(0.7),
    yaw_count=8,
)
DEEPEST = 1e-3  # within which a wheel bears its load [m]
HEIGHT_ACCURACY = 1e-14  # [m]
SPIN_SHARE = 0.08  # within which the spin is sought, of that of the tape circle
SPIN_ACCURACY = 1e-13  # [rad/s]
UNJUDGED = "unjudged"  # criterion of what is printed for every law, but part of no verdict
PLACE_ACCURACY = 1e-6  # of a jump [m]


@dataclass(frozen=True)
class States:
    """Steady states over the lateral position; last axis of `values`: right, left wheel.

    Attributes
    ----------
    y, yaw, roll, spin : array (n,)
        Of the wheelset [m, rad, rad, rad/s].
    values : dict of str to array (n, 2)
        Of the contact that bears most: on_rail (from the rail's highest point) and on_wheel (from the tape circle),
        both to the field side, z_wheel (of the contact point under the tape circle's bottom, in the wheelset's axes)
        [m]; angle [rad], area [m^2], pressure (greatest) [Pa], approach [m], xi, eta [-], phi [1/m].  Of the whole
        wheel: normal (sum over its contacts), x_force, y_force (on the rail, track axes), creep_x, creep_t (creep
        force on the rail along x and t of its contacts) [N].  Those of railcli also: patches, tangential (sizes of the
        creep forces over friction times normal force), share (of the contact that bears most in the normal force),
        other_on_rail (place of the next one; NaN where there is none), centre (mean place on the rail, by load).
    """

    y: np.ndarray
    yaw: np.ndarray
    roll: np.ndarray
    spin: np.ndarray
    values: dict

    @property
    def delta_r(self):
        """z_wheel of the right less that of the left wheel [m]."""
        return self.values["z_wheel"][:, 0] - self.values["z_wheel"][:, 1]

    def at(self, y):
        """Row of the state at y [m]."""
        return int(np.argmin(np.abs(self.y - y)))


@dataclass(frozen=True)
class Pose:
    """A wheelset above its rails: y [m], yaw, roll [rad] and the heights of its centre at which each wheel touches."""

    y: float
    yaw: float
    roll: float
    touching: tuple


def poses(pair, y):
    """Poses of the benchmark at lateral positions y [m].

    Parameters
    ----------
    pair : Wheelset
        Over its track, both sides alike.
    y : sequence of float

    Returns
    -------
    list of Pose
    """
    station = fine_stations(pair.right)
    found = []
    for at in y:
        yaw = YAW_PER_METRE * at
        roll = contact_at(pair, with_roll=True, yaw=yaw)(at)[-1]
        touching = []
        for k in range(2):
            pose, below = wheel_pose(pair, k, at, roll, yaw)
            touching.append(direct_contacts(pair.right, pose, station)[:, 1].min() - below)
        found.append(Pose(float(at), yaw, roll, tuple(touching)))
    return found


def scenario(settings, **contact):
    """The benchmark's wheelset on straight track, with fields of its contact beside flange-back."""
    body = Body(
        name="wheelset", mass=2.0 * VERTICAL / GRAVITY, inertia=(1000.0, 100.0, 1000.0), x=0.0,
        wheel_radius=settings.radius,
    )  # fmt: skip
    return Scenario(
        name="A-2.2",
        vehicle=Vehicle(name="wheelset", bodies=(body,)),
        run=Run(speed=SPEED, gravity=GRAVITY),
        track=Track((Straight(length=100.0),)),
        contact=Contact(flange_back=settings.flange_back, **{"friction": FRICTION, **contact}),
    )


class Bench:
    """A wheelset whose wheels stand on their own, each in a model of its own.

    Attributes
    ----------
    model : Model
        Of both wheels, packed as for a run.

    Parameters
    ----------
    pair : Wheelset
        Over its track, both sides alike.
    table : ContactTable
        Of its wheels.
    **contact
        Fields of the scenario's contact, such as creep_law.
    """

    def __init__(self, pair, table, **contact):
        self._radius = table.settings.radius
        self._rail_top = pair.lateral - pair.right.seat  # of the rail's highest point from the middle of the track [m]
        self.model = model = assemble(scenario(table.settings, **contact), [table]).model
        self._models = [freeze(model._replace(wheel=model.wheel[k : k + 1].copy())) for k in range(2)]
        self._data = [new_data(model, np.zeros((1, 6)), 0) for model in self._models]

    def evaluated(self, k, pose, height, spin):
        """Data of the core with wheel k (0 right, 1 left) in a pose, the wheelset's centre at z = height [m]."""
        data = self._data[k]
        data.q[0] = 0.0, pose.y, height, pose.roll, 0.0, pose.yaw
        data.v[0] = SPEED, 0.0, 0.0, 0.0, spin, 0.0
        status = evaluate(self._models[k], data, 0.0)
        if status:
            raise SimulationError(f"A-2.2 at y = {pose.y * 1e3:g} mm: {Status(status).name.lower().replace('_', ' ')}")
        return data

    @property
    def free_spin(self):
        """Spin of a wheelset that rolls on its tape circles [rad/s]."""
        return -SPEED / self._radius

    def on_rail(self, k, pose, patches):
        """Places of patches of wheel k from the rail's highest point, to the field side [m]."""
        return SIDES[k] * (pose.y + patches["arm"][..., 1]) - self._rail_top

    def loaded(self, k, pose, spin, load=VERTICAL):
        """Data of the core with wheel k pressed down until it bears a vertical force [N]."""

        def missing(height):
            return self.evaluated(k, pose, height, spin).rail[0]["q"] - load

        low = pose.touching[k]
        step = 1e-5
        while missing(low + step) < 0.0 and step < DEEPEST:
            step *= 2.0
        height = brentq(missing, low - 1e-5, low + step, xtol=HEIGHT_ACCURACY)
        return self.evaluated(k, pose, height, spin)

    def moment(self, pose, spin):
        """Moment of both wheels' forces about the axle [N m]."""
        return sum(float(self.loaded(k, pose, spin).load[0, 4]) for k in range(2))

    def steady_spin(self, pose):
        """Spin at which the moment about the axle vanishes [rad/s]."""
        ends = self.free_spin * (1.0 + SPIN_SHARE), self.free_spin * (1.0 - SPIN_SHARE)
        return brentq(lambda spin: self.moment(pose, spin), *ends, xtol=SPIN_ACCURACY)

    def settle(self, pose):
        """Steady state of one pose.

        Returns
        -------
        spin : float
            [rad/s]
        wheels : list of dict
            Right and left, as `States.values`.
        """
        spin = self.steady_spin(pose)
        return spin, [self._read(k, pose, self.loaded(k, pose, spin)) for k in range(2)]

    def _read(self, k, pose, data):
        rail = data.rail[0]
        patches = data.contact[0][: int(rail["patches"])]
        order = np.argsort(-patches["normal"])
        most, normal = patches[order[0]], float(patches["normal"].sum())
        down = (
            math.sin(pose.yaw) * math.sin(pose.roll), -math.cos(pose.yaw) * math.sin(pose.roll), math.cos(pose.roll)
        )  # fmt: skip
        places = self.on_rail(k, pose, patches[order])
        slope = most["slope"]
        creep = np.hypot(patches["creep_x"], patches["creep_t"])
        return {
            "on_rail": places[0],
            "on_wheel": most["lateral"],
            "z_wheel": float(np.dot(most["arm"], down)) - self._radius,
            "angle": -SIDES[k] * math.atan(slope),
            "area": math.pi * most["semi_x"] * most["semi_y"],
            "pressure": float(most["pressure"]),
            "approach": most["depth"] / math.hypot(1.0, slope),
            "normal": normal,
            "xi": most["xi"],
            "eta": most["eta"],
            "phi": most["phi"],
            "x_force": rail["x"],
            "y_force": rail["y"],
            "patches": patches.size,
            "creep_x": -patches["creep_x"].sum(),
            "creep_t": -patches["creep_t"].sum(),
            "tangential": creep.sum() / (FRICTION * normal),
            "share": most["normal"] / normal,
            "other_on_rail": places[1] if len(places) > 1 else math.nan,
            "centre": float(np.dot(places, patches["normal"][order])) / normal,
        }


def steady_states(bench, at):
    """Steady states at some poses.

    Parameters
    ----------
    bench : Bench
    at : list of Pose

    Returns
    -------
    States
    """
    settled = [bench.settle(pose) for pose in at]
    values = {
        key: np.array([[wheel[key] for wheel in wheels] for _, wheels in settled], dtype=float)
        for key in settled[0][1][0]
    }
    return States(
        np.array([pose.y for pose in at]), np.array([pose.yaw for pose in at]), np.array([pose.roll for pose in at]),
        np.array([spin for spin, _ in settled]), values,
    )  # fmt: skip


def jump(bench, pair, low, high):
    """Lateral position [m] between low and high where the right wheel's contact crosses the middle of its way."""

    def place(y):
        return bench.settle(poses(pair, [y])[0])[1][0]["on_rail"]

    middle = 0.5 * (place(low) + place(high))
    return brentq(lambda y: place(y) - middle, low, high, xtol=PLACE_ACCURACY)


def across(y_force, angle):
    """Force on the rail along t of a wheel with one contact, from its lateral force and VERTICAL [N]; arrays (n, 2)."""
    return y_force * np.cos(angle) - np.array(SIDES) * VERTICAL * np.sin(angle)


def deviations(states, reference):
    """States less reference: value -> array (n, 2).

    Relative for area, pressure, approach and normal; creep_x and creep_t over friction times the reference's normal
    force; all else as in `States`.
    """
    found = {key: states.values[key] - values for key, values in reference.values.items()}
    for key in ("area", "pressure", "approach", "normal"):
        found[key] = found[key] / reference.values[key]
    for key in ("creep_x", "creep_t"):
        found[key] = found[key] / (FRICTION * reference.values["normal"])
    return found


def benchmark_rows(title, states, reference, jumps, limits, shown=()):
    """Criteria of one combination of laws.

    Parameters
    ----------
    title : str
        The combination.
    states, reference : States
    jumps : list of float
        Lateral positions [m].
    limits : dict
        Group "benchmark" of accept.toml.
    shown : sequence of str
        Criteria that do not count for its creep law.

    Returns
    -------
    list of Row
    """
    off = deviations(states, reference)
    position = 1e3 * np.maximum(np.abs(off["on_rail"]), np.abs(off["on_wheel"]))
    delta_r = 1e3 * np.abs(states.delta_r - reference.delta_r)
    normal = np.abs(off["normal"])
    component = np.maximum(np.abs(off["creep_x"]), np.abs(off["creep_t"]))
    slip = np.abs(states.values["tangential"] - 1.0)

    shown = (*shown, UNJUDGED)

    def row(name, values, key, limit, criterion=""):
        chosen = [reference.at(y * 1e-3) for y in limits[key]]
        where = f"{limits[key][0]:g} to {limits[key][-1]:g} mm" if len(chosen) > 1 else f"{limits[key][0]:g} mm"
        return Row(f"{title}: {name}, {where}", float(values[chosen].max()), limits[limit], criterion not in shown)

    rows = [
        row("position [mm]", position, "position_y_mm", "position_mm"),
        row("position [mm]", position, "near_position_y_mm", "near_position_mm"),
        row("position [mm]", position, "shown_position_y_mm", "near_position_mm", UNJUDGED),
        row("delta-r [mm]", delta_r, "delta_r_y_mm", "delta_r_mm"),
        row("delta-r [mm]", delta_r, "flange_y_mm", "flange_delta_r_mm"),
        row("delta-r [mm]", delta_r, "shown_delta_r_y_mm", "delta_r_mm", UNJUDGED),
        row("normal force, relative", normal, "normal_y_mm", "normal_share", "normal"),
        row("normal force, relative", normal, "flange_y_mm", "flange_normal_share", "flange_normal"),
        row("size of the creep force, from mu N", slip, "near_sliding_y_mm", "sliding_share", "near_sliding"),
        row("size of the creep force, from mu N", slip, "sliding_y_mm", "sliding_share", "sliding"),
        row("components of the creep force over mu N", component, "component_y_mm", "component_share", "components"),
    ]
    for place, (low, high) in zip(jumps, limits["jumps_mm"], strict=True):
        outside = max(low - place * 1e3, place * 1e3 - high, 0.0)
        rows.append(Row(f"{title}: jump, from {low:g} to {high:g} mm away [mm]", outside, 0.0))
    return rows


def delta_r_row(title, states, reference, limits, counts):
    """Criterion of delta-r at positions of its own, `delta_r_y_mm` of limits, to `delta_r_mm`."""
    chosen = [reference.at(y * 1e-3) for y in limits["delta_r_y_mm"]]
    found = 1e3 * np.abs(states.delta_r - reference.delta_r)[chosen].max()
    name = f"{title}: delta-r of A-2.2 [mm], {limits['delta_r_y_mm'][0]:g} to {limits['delta_r_y_mm'][-1]:g} mm"
    return Row(name, float(found), limits["delta_r_mm"], counts)


def extremes(states, reference, settings):
    """Lowest and highest of `deviations`, as the group "benchmark.spread" of accept.toml asks: name -> (low, high)."""
    chosen = np.repeat((reference.y > settings["from_mm"] * 1e-3 - 1e-9)[:, None], 2, axis=1)
    for y in settings["merged_right_mm"]:
        chosen[reference.at(y * 1e-3), 0] = False
    off = deviations(states, reference)
    return {key: (float(values[chosen].min()), float(values[chosen].max())) for key, values in off.items()}
