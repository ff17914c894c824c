"""Braking of a vehicle that only runs and turns its wheels: the subsystems alone, held to closed forms and tables.

The patch is the same all along and no load is transferred; docs/subsystems.md, 8.
"""

from typing import NamedTuple

import numpy as np

from railcli.errors import SimulationError
from railcli.kernels.layout import (
    CURVE,
    ELEMENT,
    JOINT,
    NO_HEIGHTS,
    NO_MATRIX,
    NO_SHIFT,
    NODE_CHANNELS,
    TABLE,
    Model,
    freeze,
    new_data,
)
from railcli.kernels.longitudinal import coast
from railcli.model import subsystems
from railcli.model.system import parameters
from railcli.model.vehicle import pack as pack_vehicle

from .faults import guest_fault
from .ledger import kinetic_energy


class Patch(NamedTuple):
    """A contact patch that stays as it is."""

    semi_x: float  # [m]
    semi_y: float
    shear: float  # shear modulus [Pa]
    c11: float  # Kalker's coefficient [-]

    def packed(self):
        """What the core wants of it: semi-axes, f11, f22, f23, f33; slip across and spin do not occur."""
        f11 = self.shear * self.semi_x * self.semi_y * self.c11
        return np.array([self.semi_x, self.semi_y, f11, f11, 1e-3 * f11, 1e-6 * f11])


class Stop(NamedTuple):
    """How a vehicle came to stand."""

    distance: float  # [m]
    time: float  # [s]
    locked_at: float  # time at which an axle locked first; NaN: none did [s]
    locked_speed: float  # speed of the vehicle then [m/s]
    slide: float  # largest while it ran above SLIDE_ABOVE [-]
    creep_share: float  # of the initial kinetic energy
    brake_share: float
    unbooked: float  # share of the initial kinetic energy that neither creep nor brake took
    vents: int  # of all valves
    air: float  # used by all cylinders, at 1.013 bar [m^3]


SLIDE_ABOVE = 5.0  # [m/s]
BLOCK = 5  # steps between two looks at slide and locking


def model_of(scenario):
    """The subsystems of a scenario on a vehicle without suspension, track and contact tables; and Data at its start."""
    contact = scenario.contact
    packed = pack_vehicle(scenario.vehicle, scenario.run.gravity, contact.tape_circle, contact.friction)
    added = subsystems.pack(scenario, packed, 0, scenario.distance)
    if not added.axle.size:
        raise SimulationError("the scenario has no subsystems")
    empty = np.zeros
    model = Model(
        param=parameters(scenario),
        track=scenario.pieces(),
        body=added.body,
        joint=empty(0, JOINT),
        element=empty(0, ELEMENT),
        curve=added.curve if added.curve.size else empty(1, CURVE),
        wheel=packed.wheel.copy(),
        table=empty(0, TABLE),
        node=empty((0, NODE_CHANNELS)),
        cell=empty(1, np.int32),
        branch=empty((0, 8), np.int32),
        heights=NO_HEIGHTS.copy(),
        creep=empty((0, 4)),
        shift=NO_SHIFT.copy(),
        matrix=NO_MATRIX.copy(),
        axle=added.axle,
        assembly=added.assembly,
        plan=added.plan,
        line=added.line,
    )
    data = new_data(freeze(model), packed.rest, 0)
    data.v[:, 0] = data.rate[0, 0] = scenario.first_speed
    for axle in added.axle:
        data.v[axle["wheelset"], 4] = -scenario.first_speed / axle["radius"]
    return model, data


def stop(scenario, patch, load):
    """Run the subsystems of a scenario until the vehicle stands.

    Parameters
    ----------
    scenario : Scenario
        With a step, adhesion and a brake demand.
    patch : Patch
    load : float
        Vertical force of each wheel [N].

    Returns
    -------
    Stop

    Raises
    ------
    SimulationError
        It does not come to stand within scenario.duration.
    """
    model, data = model_of(scenario)
    start, packed = kinetic_energy(model, data), patch.packed()
    steps = round(scenario.duration / scenario.run.step)
    locked_at = locked_speed = np.nan
    slide, done = 0.0, 0
    while data.train[0]["stop_time"] < 0.0:
        if done >= steps:
            raise SimulationError(f"the vehicle still runs at {data.v[0, 0]:.3g} m/s after {scenario.duration:g} s")
        made = coast(model, data, packed, load, BLOCK)
        if made < 0:
            raise SimulationError(guest_fault(data))
        done += made
        speed = data.v[0, 0]
        if speed > SLIDE_ABOVE:
            slide = max(slide, float(data.port["slide"].max()))
        if np.isnan(locked_at) and (data.v[model.axle["wheelset"], 4] == 0.0).any():
            locked_at, locked_speed = float(data.clock[0]), float(speed)
    train = data.train[0]
    creep, brake = train["creep_loss"] / start, train["brake_loss"] / start
    left = kinetic_energy(model, data) / start
    return Stop(
        float(train["stop_place"]), float(train["stop_time"]), locked_at, locked_speed, slide, float(creep),
        float(brake), float(1.0 - creep - brake - left), int(data.port["vents"].sum()), float(data.port["air"].sum()),
    )  # fmt: skip
