"""A scenario and its contact tables, packed once into the read-only arrays of the core."""

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from railcli.kernels.creep_table import CHANNELS, tabulate
from railcli.kernels.layout import CURVE, PARAM, Creep, Model, freeze, new_data

from . import rails as rails_model
from . import subsystems
from . import vehicle as vehicle_model
from .contact_table import LIMITS, OF_HEIGHTS, TableSettings
from .stiff import mark_stiff
from .submodels import CREEP_LAWS, choose

HOLD = 1e6  # force per speed error that holds the speed of the first body [N s/m]
HOLD_RATE = 1.0  # at which that force grows while the error lasts [1/s]
HOLD_SHARE = 0.5  # of the body's mass over the step: the holding force acts explicitly and must not overshoot
STIFF_STEP = 1e-3  # dampers too stiff for this step, the longest usual one, act implicitly at every step [s]
DRAFT_STEP = 0.5e-3  # of a system whose scenario leaves the step to be chosen (analysis/step_choice.py) [s]
CREEP_SPEED = 0.1  # below it patches remember how they were strained [m/s]
SETTLED = 1e-4  # change of creepages within which a step takes creep forces as linear in them
NARROW_PLAY = 0.075  # gauge less flange back at which the usual range of a contact table is enough [m]
DERAIL_LIFT = 0.030  # a wheel lifted by more than its flange's height has left the rail [m]


@dataclass(frozen=True)
class System:
    """A packed model, where its bodies stand at rest, and their names."""

    model: Model
    rest: np.ndarray  # (n_body, 6) nominal coordinates, s relative to the first body
    damper: np.ndarray  # (n_state,) lengths of the dampers at rest [m]
    bodies: tuple  # names
    joints: tuple  # what each is, in words
    elements: tuple
    wheelsets: tuple  # indices of the wheelsets, in the order of the wheels
    speed: float  # asked for, or at the beginning of a free run [m/s]
    guest: object = None  # a user's controller whose address is in the model; it lives as long as this

    def start(self, s=0.0, lateral=0.0):
        """Data of the vehicle at its nominal place, rolling at its speed on straight track.

        Parameters
        ----------
        s : float
            Arc length of the first body [m].
        lateral : float or array (n_body,)
            How far bodies stand to the right of their place at rest [m].
        """
        q = self.rest.copy()
        q[:, 0] += s
        q[:, 1] += lateral
        data = new_data(self.model, q, self.damper.size)
        data.damper[:] = self.damper
        data.v[:, 0] = self.speed
        spins = self.model.body["spins"] == 1
        data.v[spins, 4] = -self.speed / self.radii[spins]
        return data

    def stepped(self, step):
        """The same system with this time step [s], and a hold of its speed that suits it."""
        param = self.model.param.copy()
        param["step"] = step
        if param[0]["hold"] > 0.0:
            param["hold"] = hold_gain(self.model.body[0]["mass"], step)
        return replace(self, model=freeze(self.model._replace(param=param)))

    def following(self, times, speeds):
        """The same system, asked for speeds [m/s] at times [s], straight between them; it starts with the first."""
        row = np.zeros(1, CURVE)
        row["count"] = len(times)
        row["x"][0, : len(times)], row["y"][0, : len(times)] = times, speeds
        param = self.model.param.copy()
        param["speed_curve"] = self.model.curve.size
        model = self.model._replace(param=param, curve=np.concatenate([self.model.curve, row]))
        return replace(self, model=freeze(model), speed=float(speeds[0]))

    @property
    def gives_way(self):
        """True when the rails do."""
        return bool(self.model.param[0]["rail_stiffness"].any())

    def on_rigid_track(self):
        """The same system on rails that do not give way."""
        param = self.model.param.copy()
        param["rail_stiffness"] = param["rail_damping"] = 0.0
        return replace(self, model=freeze(self.model._replace(param=param)))

    def passive(self):
        """The same system with subsystems that nobody asks anything of: no demand, no controller, no resistance."""
        if not self.model.axle.size:
            return self
        assembly = self.model.assembly.copy()
        for key in ("brake_curve", "traction_curve"):
            assembly[key] = -1
        for key in ("driver", "period", "memory", "ends", "resistance"):
            assembly[key] = 0
        assembly["end_place"] = np.inf
        return replace(self, model=freeze(self.model._replace(assembly=assembly)))

    @property
    def radii(self):
        """Mean radius of the tape circles of each body [m]; NaN without wheels."""
        found = np.full(self.model.body.size, np.nan)
        for i in set(self.model.wheel["body"].tolist()):
            found[i] = self.model.wheel["radius"][self.model.wheel["body"] == i].mean()
        return found


class Pairing(NamedTuple):
    """A wheel over a rail: what decides which contact table it takes."""

    wheel: str  # profiles, both in the axes of right-hand ones
    rail: str
    file: str | None  # of a table that the user names
    radius: float  # [m]


def pairings(scenario):
    """The Pairing of every wheel, in the order of the core: right and left wheel of each wheelset."""
    sides = scenario.contact.sides
    radii = scenario.vehicle.wheel_radii
    return [Pairing(*side, radius) for pair in radii for side, radius in zip(sides, pair, strict=True)]


def needed(scenario):
    """The different pairings of a scenario, each once: it takes one contact table for each, in this order."""
    return tuple(dict.fromkeys(pairings(scenario)))


def table_settings(scenario, radius):
    """Settings of the contact table that a scenario's wheels of this radius [m] need.

    The table reaches as far beyond flange contact on a wide gauge, everywhere or in curves, as on the usual one.
    """
    contact = scenario.contact
    default = TableSettings()
    aside = 0.5 * (contact.gauge - contact.flange_back - NARROW_PLAY) + scenario.track.widest(contact.gauge)
    wider = max(0, round(aside / default.y_step))
    return TableSettings(
        inclination=contact.inclination,
        gauge=contact.gauge,
        flange_back=contact.flange_back,
        tape_to_back=contact.tape_to_back,
        radius=radius,
        young=contact.young,
        poisson=contact.poisson,
        normal=contact.normal,
        y_range=min(default.y_range + wider * default.y_step, LIMITS["y_range"][1]),
    )


def pool(tables):
    """Several contact tables in the arrays of one pool: table, node, cell, branch, heights."""
    records = np.concatenate([table.record for table in tables])
    node_base = cell_base = branch_base = heights_base = 0
    for record, table in zip(records, tables, strict=True):
        record["node_base"], record["cell_base"], record["branch_base"] = node_base, cell_base, branch_base
        if table.settings.stores_heights:
            for key in ("levels", *OF_HEIGHTS):
                record[key] += heights_base
        node_base += table.node.shape[0]
        cell_base += table.cell.shape[0]
        branch_base += table.branch.shape[0]
        heights_base += table.heights.shape[0]
    arrays = [[getattr(table, key) for table in tables] for key in ("node", "cell", "branch", "heights")]
    return records, *(each[0] if len(tables) == 1 else np.concatenate(each) for each in arrays)


def hold_gain(mass, step):
    """Force per speed error that holds the speed of a body of this mass at this step [N s/m]."""
    return min(HOLD, HOLD_SHARE * mass / step)


def parameters(scenario):
    """The PARAM record of a scenario."""
    param = np.zeros(1, PARAM)
    param["step"] = step = DRAFT_STEP if scenario.run.step is None else scenario.run.step
    param["gravity"] = scenario.run.gravity
    param["cant_base"] = scenario.cant_base
    param["speed"], param["speed_curve"], param["hold_rate"] = scenario.run.speed, -1, HOLD_RATE
    param["hold"] = 0.0 if scenario.is_free else hold_gain(scenario.vehicle.bodies[0].mass, step)
    param["creep_law"] = choose(CREEP_LAWS, "contact.creep_law", scenario.contact.creep_law).value
    param["creep_speed"] = CREEP_SPEED
    param["settled"] = SETTLED
    for key in ("friction_ratio", "friction_decay", "adhesion_reduction", "slip_reduction", "fastsim_grid"):
        param[key] = getattr(scenario.contact, key)
    param["damping"] = scenario.contact.damping
    param["damping_rate_power"] = 1.0
    param["damping_depth_power"] = 1.5
    param["derail_lift"] = DERAIL_LIFT
    param["rail_stiffness"], param["rail_damping"] = scenario.track_support.packed()
    return param


@cache
def creep_table(law):
    """What a creep law needs beside the contact tables; the same for all ellipses, materials and friction."""
    value = CREEP_LAWS[law].value
    return tabulate(int(value)) if value in (Creep.TABLE, Creep.FASTRIP) else np.zeros((0, CHANNELS))


def assemble(scenario, tables):
    """Pack a scenario.

    Parameters
    ----------
    scenario : Scenario
    tables : sequence of ContactTable
        One for each pairing that is `needed`, in that order.

    Returns
    -------
    System
    """
    packed = vehicle_model.pack(
        scenario.vehicle, scenario.run.gravity, scenario.contact.tape_circle, scenario.contact.friction
    )
    joints, elements = vehicle_model.in_words(scenario.vehicle)
    kinds = needed(scenario)
    wheel = packed.wheel.copy()
    wheel["table"] = [kinds.index(pairing) for pairing in pairings(scenario)]
    table, node, cell, branch, heights = pool(tables)
    param = parameters(scenario)
    shift, param["shift_start"], param["shift_step"] = rails_model.pack(scenario)
    element = mark_stiff(packed, max(STIFF_STEP, scenario.run.step or 0.0))
    added = subsystems.pack(scenario, packed, 1 + element["stiff"].max(initial=-1), scenario.distance)
    model = Model(
        param=param,
        track=scenario.pieces(),
        body=added.body,
        joint=packed.joint,
        element=element,
        curve=added.curve,
        wheel=wheel,
        table=table,
        node=node,
        cell=cell,
        branch=branch,
        heights=heights,
        creep=creep_table(scenario.contact.creep_law),
        shift=shift,
        matrix=packed.matrix,
        axle=added.axle,
        assembly=added.assembly,
        plan=added.plan,
        line=added.line,
    )
    return System(
        model=freeze(model),
        rest=packed.rest,
        damper=packed.damper,
        bodies=tuple(body.name for body in scenario.vehicle.bodies),
        joints=joints,
        elements=elements,
        wheelsets=tuple(scenario.vehicle.wheelsets),
        speed=scenario.first_speed if scenario.is_free else scenario.run.speed,
    )
