"""The results of a run: time series as HDF5, written as the run goes, and the main channels as CSV.

Rows hold coordinates as instants, forces and accelerations as means over all steps since the row before, with the
extremes of these steps. Below FILTERED is what every step gave, low-passed, at a rate of its own: what is assessed.
Track axes: x forward, y to the right, z down; angles turn right-handed about them. Forces of a wheel act on its rail.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from typing import NamedTuple

import numpy as np

from railcli.errors import InputError
from railcli.kernels.layout import MAX_CONTACT
from railcli.kernels.recording import averaged, new_rows

from .filtered_series import CHUNK, FELT, FilteredSeries, grown, wheel_group
from .growing_hdf5 import GrowingHdf5
from .output import cell, is_refusal, refusal, refused, whole_file

TIME_SERIES = "timeseries.h5"
MAIN_CHANNELS = "main.csv"
PIECE, ENVELOPE = 20_000, 8000  # rows of a long run read at a time; rows of it that a picture needs
NOTHING = "none"  # in the place of globs
FORMAT = "railcli time series"
FORMAT_VERSION = 3  # sealed; 2 was not

BODY_CHANNELS = {  # name: how to read it from the rows of body i, units, description
    "position": (lambda rows, i: rows.q[:, i, :3], "m", "arc length s, lateral y, vertical z in the track frame at s"),
    "rotation": (lambda rows, i: rows.q[:, i, 3:], "rad", "roll, pitch, yaw against the track frame at s"),
    "velocity": (lambda rows, i: rows.v[:, i, :3], "m/s", "of the centre of mass, x, y, z of the track frame at s"),
    "angular_velocity": (lambda rows, i: rows.v[:, i, 3:], "rad/s", "about the body's own axes x, y, z"),
}
ACCELERATIONS = {  # name: array of the rows, description
    "acceleration": ("mean", f"mean over the interval of {FELT}"),
    "acceleration_least": ("least", f"least value of a step in the interval of {FELT}; no filter"),
    "acceleration_greatest": ("greatest", f"greatest value of a step in the interval of {FELT}; no filter"),
}
FORCES = {  # name: array of the rows, member of kernels.recording.Averaged, description
    "X": ("mean", "x", "force of the wheel on the rail, forward; mean over the interval"),
    "Y": ("mean", "y", "force of the wheel on the rail, to the right; mean over the interval"),
    "Y_least": ("least", "y", "Y, least value of a step in the interval; no filter"),
    "Y_greatest": ("greatest", "y", "Y, greatest value of a step in the interval; no filter"),
    "Q": ("mean", "q", "force of the wheel on the rail, down; mean over the interval"),
    "Q_least": ("least", "q", "Q, least value of a step in the interval; no filter"),
    "Q_greatest": ("greatest", "q", "Q, greatest value of a step in the interval; no filter"),
}
RAIL_CHANNELS = {
    "rail_y": ("lateral", "m", "displacement of the rail at the wheelset's place, to the right"),
    "rail_z": ("vertical", "m", "displacement of the rail at the wheelset's place, down"),
    "patches": ("patches", "-", "number of loaded contact patches"),
}
SUPPORT_CHANNELS = {  # of rails that give way: array of the rows' rails, its component, units, description
    "give_y": ("give", 0, "m", "how far the rail gives way under the wheel, to the right; beside rail_y"),
    "give_z": ("give", 1, "m", "how far the rail gives way under the wheel, down; beside rail_z"),
    "seat_Y": ("seat", 0, "N", "force of the rail on its springs and dampers, to the right"),
    "seat_Q": ("seat", 1, "N", "force of the rail on its springs and dampers, down"),
}
PATCH_CHANNELS = {  # forces are zero, all else is not a number, where there is no patch
    "normal": ("normal", "N", "normal force"),
    "creep_x": ("creep_x", "N", "creep force on the wheel along the rail"),
    "creep_t": ("creep_t", "N", "creep force on the wheel across the rail, in the contact plane"),
    "spin_moment": ("spin_moment", "N m", "creep moment on the wheel about the contact normal"),
    "xi": ("xi", "-", "longitudinal creepage, slip of wheel over rail"),
    "eta": ("eta", "-", "lateral creepage"),
    "phi": ("phi", "1/m", "spin creepage"),
    "depth": ("depth", "m", "penetration along z"),
    "angle": ("angle", "rad", "contact angle, positive when the normal leans to the flange"),
    "on_wheel": ("lateral", "m", "profile coordinate on the wheel, from the tape circle to the field side"),
    "radius": ("radius", "m", "rolling radius"),
    "semi_x": ("semi_x", "m", "half axis of the contact ellipse along the rail"),
    "semi_y": ("semi_y", "m", "half axis of the contact ellipse across"),
    "linear": ("linear", "-", "creep force of linear theory over the friction limit; above 1: full slip somewhere"),
    "region": ("region", "-", "part of the wheel profile: 0 tread, 1 flange root, 2 flange flank, 3 flange tip"),
}
AXLE_CHANNELS = {  # of a vehicle with subsystems: field of the rows' ports, units, description
    "speed": ("speed", "m/s", "of the tread, as the sensor has it"),
    "slide": ("slide", "-", "speed of the vehicle less that of the tread, over the former"),
    "adhesion_used": ("used", "-", "longitudinal over vertical force of the axle on the rails"),
    "adhesion_offered": ("offered", "-", "friction at the slip velocity of its wheels"),
    "brake_pressure": ("pressure", "Pa", "of its cylinders"),
    "brake_torque": ("brake_torque", "N m", "of the brake, against running forward"),
    "pad_friction": ("pad_friction", "-", "of pads or blocks; 0 where the brake's torque is given"),
    "valve": ("valve_now", "-", "dump valve: 0 fills, 1 holds, 2 vents"),
    "traction_torque": ("traction_torque", "N m", "of the motors at the axle, forward"),
    "air": ("air", "m^3", "used so far, at 1.013 bar"),
}
TRAIN_CHANNELS = {
    "brake_demand": ("brake_demand", "-", "of the driver, 0 to 1"),
    "traction_demand": ("traction_demand", "-", "of the driver, 0 to 1"),
    "brake_applied": ("applied", "-", "pressure of the distributor over that at full demand"),
    "reference_speed": ("reference", "m/s", "of the slide protection"),
    "resistance": ("resistance", "N", "running resistance, against running forward"),
    "target_speed": ("target_speed", "m/s", "of a driver who follows a line"),
    "odometer_speed": ("odometer_speed", "m/s", "as the odometry tells it"),
    "odometer": ("odometer", "m", "distance since the beginning, as the odometry tells it"),
}
ENERGY_CHANNELS = {
    "creep": ("creep_loss", "J", "taken by creep forces, spin included"),
    "contact": ("normal_loss", "J", "taken by normal forces: stored, or lost in contact and track"),
    "suspension": ("suspension_loss", "J", "taken by the suspension: stored, or lost"),
    "brake": ("brake_loss", "J", "taken by brakes"),
    "resistance": ("resistance_loss", "J", "taken by running resistance"),
    "traction": ("traction_work", "J", "given by traction"),
    "holding": ("holding_work", "J", "given by the force that holds the speed"),
    "gravity": ("gravity_work", "J", "given by weights"),
}
GRIP_CHANNELS = {"friction": (0, "-", "coefficient of friction without slip")}
FORCES_OF_A_PATCH = ("normal", "creep_x", "creep_t", "spin_moment")


class TimeSeries:
    """The sink of a run: call it with blocks of rows; used as a context manager.

    However the run ends, the rows that came until then are in the file, which appears under its name when the context
    is left. Without any row there is no file.

    Parameters
    ----------
    path : path-like
    system : System
    contact_channels : sequence of str, optional
        Globs of the channels of contact patches to keep, such as ``wheels/W1_*/contact/normal``; all when absent, none
        for ``none``. What belongs to bodies and wheels is always kept.

    Attributes
    ----------
    rows : int
        In the file.
    time : float
        Of the last one [s].
    """

    def __init__(self, path, system, contact_channels=("*",)):
        self._path, self._system, self._kept_contact = path, system, contact_channels
        wheels = [wheel_group(system, w) for w in range(system.model.wheel.size)]
        names = [f"wheels/{wheel}/contact/{channel}" for wheel in wheels for channel in PATCH_CHANNELS]
        for pattern in contact_channels:
            if pattern != NOTHING and not any(fnmatchcase(name, pattern) for name in names):
                raise InputError(
                    "contact channels",
                    f"{pattern!r} fits none; give a glob such as '*/normal' or 'wheels/W1_*/contact/*', or "
                    f"{NOTHING!r}; known: {', '.join(PATCH_CHANNELS)}",
                )
        self._held = new_rows(system.model, CHUNK)
        self._filtered = None
        self._count = self.rows = 0
        self.time = 0.0

    def __enter__(self):
        self._growing = GrowingHdf5(self._path, FORMAT)
        try:
            with refused(self._path), self._growing.growing(0):
                self._begin(self._growing.file)
        except BaseException:
            self._growing.drop()
            raise
        return self

    def __call__(self, rows):
        start = 0
        while start < rows.time.size:
            count = min(CHUNK - self._count, rows.time.size - start)
            for held, new in zip(self._held, rows, strict=True):
                held[self._count : self._count + count] = new[start : start + count]
            self._count += count
            start += count
            if self._count == CHUNK:
                self._write()

    def filtered(self, block):
        """Take in a block that was low-passed (analysis.simulate.Filtered)."""
        if self._filtered is None:
            self._filtered = FilteredSeries(self._system, self._growing.file)
        for size, write in self._filtered.take(block):
            self._append(size, write)

    def kept(self):
        """A sentence that says what the file holds; empty when there is none."""
        return f"What was computed until t = {self.time:.2f} s is kept in {self._path}." if self.rows else ""

    def __exit__(self, kind, error, traceback):
        try:
            if self._count:
                self._write()
            if self._filtered is not None:
                for size, write in self._filtered.rest():
                    self._append(size, write)
        finally:
            if self.rows:
                self._growing.close()
            else:
                self._growing.drop()

    def _write(self):
        """Append the rows at hand. When the disk is full they are given up, those before stay in the file."""
        count, self._count = self._count, 0
        rows = type(self._held)(*(array[:count] for array in self._held))

        def write():
            for dataset, source in self._sources.items():
                dataset.resize(self.rows + count, axis=0)
                dataset[self.rows :] = source(rows)
            self.rows += count
            self.time = float(rows.time[-1])

        self._append(sum(array.nbytes for array in rows), write)

    def _append(self, size, write):
        """Call `write`, which makes the file grow by no more than `size` bytes."""
        try:
            with self._growing.growing(size):
                write()
        except OSError as error:
            if is_refusal(error):
                raise refusal(self._path, error, self.kept()) from error
            raise

    def _begin(self, file):
        system = self._system
        file.attrs.update(
            {
                "format": FORMAT,
                "version": FORMAT_VERSION,
                "axes": "track axes: x forward, y to the right, z down; angles right-handed about them",
                "bodies": list(system.bodies),
                "wheelsets": [system.bodies[i] for i in system.wheelsets],
                "wheels": [wheel_group(system, w) for w in range(system.model.wheel.size)],
            }
        )
        self._sources = dict(self._create(file))

    def _create(self, file):
        """Make every dataset; yields each with the function that reads its values from rows."""
        for channel in recorded(self._system):
            if "/contact/" in channel.name and not any(fnmatchcase(channel.name, glob) for glob in self._kept_contact):
                continue
            dataset = grown(
                file, channel.name, channel.shape, channel.units, channel.description, of_interval=channel.of_interval
            )
            yield dataset, channel.source


class Recorded(NamedTuple):
    """A channel of a run: its name, shape of a row, units, description, whether it tells of an interval, its source."""

    name: str
    shape: tuple
    units: str
    description: str
    of_interval: bool
    source: Callable  # of kernels.recording.Rows: its values, a row each


def recorded(system):
    """Every channel that a run of a system records, in the order of the file."""
    yield Recorded("time", (), "s", "simulated time", False, lambda rows: rows.time)
    spans = averaged(system.model.wheel.size, system.model.body.size)
    about = "force that holds the speed; mean over the interval"
    yield Recorded("traction", (), "N", about, True, lambda rows: rows.mean[:, spans.traction.start])
    for i, name in enumerate(system.bodies):
        yield from _of_body(f"bodies/{name}", i, spans.acceleration.start + 3 * i)
    for w in range(system.model.wheel.size):
        yield from _of_wheel(f"wheels/{wheel_group(system, w)}", w, spans, system.gives_way)
    if system.model.axle.size:
        yield from _of_subsystems(system)


def _of_subsystems(system):
    for a in range(system.model.axle.size):
        for channel, (key, units, about) in AXLE_CHANNELS.items():
            source = lambda rows, key=key, a=a: rows.port[key][:, a]  # noqa: E731
            yield Recorded(f"axles/W{a + 1}/{channel}", (), units, about, False, source)
    for group, channels in (("train", TRAIN_CHANNELS), ("energy", ENERGY_CHANNELS)):
        for channel, (key, units, about) in channels.items():
            source = lambda rows, key=key: rows.train[key]  # noqa: E731
            yield Recorded(f"{group}/{channel}", (), units, about, False, source)
    if system.model.line.size:
        for w in range(system.model.wheel.size):
            for channel, (c, units, about) in GRIP_CHANNELS.items():
                source = lambda rows, w=w, c=c: rows.rail["grip"][:, w, c]  # noqa: E731
                yield Recorded(f"wheels/{wheel_group(system, w)}/{channel}", (), units, about, False, source)


def _of_body(group, i, start):
    for channel, (source, units, about) in BODY_CHANNELS.items():
        yield Recorded(f"{group}/{channel}", (3,), units, about, False, lambda rows, source=source: source(rows, i))
    for channel, (key, about) in ACCELERATIONS.items():
        source = partial(_columns_of, key=key, at=slice(start, start + 3))
        yield Recorded(f"{group}/{channel}", (3,), "m/s^2", about, True, source)


def _of_wheel(group, w, spans, gives_way):
    for channel, (key, force, about) in FORCES.items():
        source = partial(_columns_of, key=key, at=getattr(spans, force).start + w)
        yield Recorded(f"{group}/{channel}", (), "N", about, True, source)
    for channel, (key, units, about) in RAIL_CHANNELS.items():
        yield Recorded(f"{group}/{channel}", (), units, about, False, lambda rows, key=key: rows.rail[key][:, w])
    for channel, (key, c, units, about) in SUPPORT_CHANNELS.items() if gives_way else ():
        source = lambda rows, key=key, c=c: rows.rail[key][:, w, c]  # noqa: E731
        yield Recorded(f"{group}/{channel}", (), units, about, False, source)
    for channel, (key, units, about) in PATCH_CHANNELS.items():
        source = partial(_patches, w=w, key=key, absent=0.0 if key in FORCES_OF_A_PATCH else np.nan)
        yield Recorded(f"{group}/contact/{channel}", (MAX_CONTACT,), units, about, False, source)


def _columns_of(rows, key, at):
    return getattr(rows, key)[:, at]


def _patches(rows, w, key, absent):
    return np.where(rows.contact["depth"][:, w] > 0.0, rows.contact[key][:, w], absent)


@dataclass(frozen=True)
class MainChannels:
    """What most readers want of a run; track axes, SI.

    Attributes
    ----------
    time, distance : array (n,)
        [s], arc length of the first body [m].
    lateral, yaw : array (n, n_wheelset)
        [m], [rad]
    y_force, q_force : array (n, n_wheel)
        Forces on the rails, to the right and down; right and left wheel of each wheelset in turn [N].
    acceleration : array (n, n_sprung, 3)
        Of the bodies that are no wheelsets [m/s^2].
    wheels, sprung : tuple of str
        Their names.
    """

    time: np.ndarray
    distance: np.ndarray
    lateral: np.ndarray
    yaw: np.ndarray
    y_force: np.ndarray
    q_force: np.ndarray
    acceleration: np.ndarray
    wheels: tuple
    sprung: tuple


def main_channels(path, rows=slice(None)):
    """Main channels of a file of time series; some of its rows when a slice is given."""
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        bodies, wheelsets, wheels = (list(file.attrs[key]) for key in ("bodies", "wheelsets", "wheels"))
        sprung = [name for name in bodies if name not in wheelsets]
        read = {name: file[f"bodies/{name}/position"][rows] for name in [bodies[0], *wheelsets]}
        time = file["time"][rows]
        count = time.size
        return MainChannels(
            time=time,
            distance=read[bodies[0]][:, 0],
            lateral=_side_by_side([read[name][:, 1] for name in wheelsets], count),
            yaw=_side_by_side([file[f"bodies/{name}/rotation"][rows, 2] for name in wheelsets], count),
            y_force=_side_by_side([file[f"wheels/{name}/Y"][rows] for name in wheels], count),
            q_force=_side_by_side([file[f"wheels/{name}/Q"][rows] for name in wheels], count),
            acceleration=_side_by_side([file[f"bodies/{name}/acceleration"][rows] for name in sprung], count, 3),
            wheels=tuple(wheels),
            sprung=tuple(sprung),
        )


def _side_by_side(columns, count, *shape):
    return np.stack(columns, axis=1) if columns else np.empty((count, 0, *shape))


def pieces(path, size=PIECE):
    """The main channels of a file of time series in pieces of `size` rows, one at a time in memory."""
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        count = file["time"].size
    for start in range(0, max(count, 1), size):
        yield main_channels(path, slice(start, min(start + size, count)))


def envelope(path, most=ENVELOPE):
    """Main channels of a long run for a picture: of every bucket of rows its lowest and highest values.

    Rows come in pairs then: a bucket's first and last time, lowest and highest value. Runs of at most `most` rows are
    given as they are.
    """
    import h5py

    with h5py.File(path, "r", locking=False) as file:
        count = file["time"].size
    if count <= most:
        return main_channels(path)
    bucket = -(-2 * count // most)
    found = [_extremes(piece, bucket) for piece in pieces(path, max(1, PIECE // bucket) * bucket)]
    arrays = (np.concatenate(values) for values in zip(*(one[:-2] for one in found), strict=True))
    return MainChannels(*arrays, *found[0][-2:])


def _extremes(piece, bucket):
    """Values of MainChannels, in order, reduced to two rows for every bucket of rows."""
    starts = np.arange(0, piece.time.size, bucket)
    last = np.minimum(starts + bucket, piece.time.size) - 1

    def pairs(low, high):
        return np.stack([low, high], axis=1).reshape(-1, *low.shape[1:])

    order = [pairs(values[starts], values[last]) for values in (piece.time, piece.distance)]
    for values in (piece.lateral, piece.yaw, piece.y_force, piece.q_force, piece.acceleration):
        order.append(pairs(np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)))
    return (*order, piece.wheels, piece.sprung)


def write_main_channels(mains, path):
    """Write main channels as a CSV file; its header names units.

    mains : iterable of MainChannels, the pieces of one run in order.
    """
    with whole_file(path) as temporary, open(temporary, "w", encoding="utf-8", newline="\n") as file:
        for number, main in enumerate(mains):
            columns = _columns(main)
            header = ",".join(columns) if number == 0 else ""
            np.savetxt(file, np.column_stack(list(columns.values())), "%.9g", ",", header=header, comments="")


def _columns(main):
    """Columns of the CSV file: name with unit -> values."""
    columns = {"time_s": main.time, "s_m": main.distance}
    for i in range(main.lateral.shape[1]):
        columns[f"W{i + 1}_y_mm"] = 1e3 * main.lateral[:, i]
        columns[f"W{i + 1}_yaw_mrad"] = 1e3 * main.yaw[:, i]
    for w, name in enumerate(main.wheels):
        columns[f"{name}_Y_kN"] = 1e-3 * main.y_force[:, w]
        columns[f"{name}_Q_kN"] = 1e-3 * main.q_force[:, w]
    for i, name in enumerate(_distinct(main.sprung)):
        for axis, letter in enumerate("xyz"):
            columns[cell(f"{name}_a{letter}_m_per_s2")] = main.acceleration[:, i, axis]
    return columns


def _distinct(names):
    """Names of bodies with underscores for spaces; a number where two become the same."""
    found = []
    for name in names:
        word = once = re.sub(r"\s+", "_", name.strip())
        number = 2
        while word in found:
            word, number = f"{once}_{number}", number + 1
        found.append(word)
    return found
