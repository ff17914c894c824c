"""Quasi-linear contact of a wheelset that swings with one amplitude (docs/stability.md, section 2).

Differences at y = 0 know nothing of what happens a tenth of a millimetre away, and straddle every jump that lies there.
So each contact function is replaced by the straight line with the same first harmonic over a sine of the amplitude
(Mauer 1988; harmonic linearisation), and the result is packed as a contact table of its own: the same compiled model
runs on it, and now it is smooth.
"""

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from railcli.errors import InputError
from railcli.kernels.layout import NO_LINE, NODE_CHANNELS, Creep, Node, freeze
from railcli.kernels.tabulate import describe
from railcli.model.contact_table import ContactTable, TableSettings
from railcli.model.system import assemble, needed, table_settings

from .build_table import wheel_regions
from .conicity import rolling, sweep, swing
from .rigid_contact import wheel_pose, wheelset_on

GRID = {"y_range": 0.040, "y_step": 1e-3, "roll_range": 0.05, "roll_step": 0.01, "yaw_range": 0.05, "yaw_count": 2}
PATCH = ("HERTZ", "SEMI_X", "SEMI_Y", "F11", "F22", "F23", "F33")


@dataclass(frozen=True)
class QuasiLinear:
    """Straight lines that stand for the contact functions of a wheelset at one amplitude; SI, y to the right.

    Attributes
    ----------
    amplitude : float
        Of the lateral motion [m].
    conicity : float
        Half the slope of delta-r over y [-].
    equivalent : float
        tan gamma_e after EN 15302 of the same delta-r, from the wavelength [-]; NaN if there is none.
    angle : float
        Half the slope of tan gamma_R - tan gamma_L over y: contact angle parameter [1/m].
    roll : float
        Slope of the wheelset's roll over y; negative [rad/m].
    travel : float
        Half the slope of the difference of both contact places on their wheels, to the field side, over y [-].
    lateral, radius : float
        Place of the centred contact on the wheel, from the tape circle to the field side, and its radius [m].
    height : float
        D of the centred wheelset [m].
    patch : tuple
        Mean of the patch constants PATCH, as channels of a table node.
    flange : bool
        The swing reaches the flank of a flange.
    """

    amplitude: float
    conicity: float
    equivalent: float
    angle: float
    roll: float
    travel: float
    lateral: float
    radius: float
    height: float
    patch: tuple
    flange: bool

    def as_dict(self):
        """Attributes by name, units in the names."""
        units = {
            "amplitude": "_m", "angle": "_per_m", "roll": "_rad_per_m", "lateral": "_m", "radius": "_m", "height": "_m",
        }  # fmt: skip
        values = {field.name + units.get(field.name, ""): getattr(self, field.name) for field in fields(self)}
        return {**values, "patch": dict(zip(PATCH, self.patch, strict=True))}


def quasi_linear(wheelset, amplitudes, settings, progress=None):
    """Quasi-linear contact of a wheelset with like sides, for each amplitude.

    Parameters
    ----------
    wheelset : Wheelset
    amplitudes : sequence of float
        [m]
    settings : TableSettings
        Elastic constants of wheel and rail.
    progress : callable, optional
        Called with the share done, 0 ... 1.

    Returns
    -------
    list of QuasiLinear
    """
    contact = rolling(wheelset, max(amplitudes), with_roll=True, progress=progress)
    channels = _node_channels(contact, settings)
    return [_at_amplitude(contact, channels, amplitude) for amplitude in amplitudes]


def _node_channels(contact, settings):
    """Node of the right wheel's contact at each position of a Rolling."""
    mounting = contact.wheelset.right
    regions = wheel_regions(mounting)
    rows = np.zeros((contact.y.size, NODE_CHANNELS))
    for row, y, roll, s in zip(rows, contact.y, contact.values["roll"], contact.values["s_right"], strict=True):
        pose, _ = wheel_pose(contact.wheelset, 0, y, roll, 0.0)
        describe(s, *pose, *mounting.kernel_arguments, settings.young, settings.poisson, regions, row)
    return rows


def harmonics(y, values, amplitude):
    """The straight line that stands for a function over a sine: zeroth and first harmonic.

    Parameters
    ----------
    y, values : array (n,)
        Place, growing, and function, straight between places.
    amplitude : float
        Of the sine about y = 0.

    Returns
    -------
    mean, slope : float
    """
    angle, weight = sweep(y, 0.0, amplitude)
    found = weight * np.interp(amplitude * np.sin(angle), y, values)
    return float(found.sum() / math.pi), float(2.0 * (found * np.sin(angle)).sum() / (math.pi * amplitude))


def _at_amplitude(contact, channels, amplitude):
    wheelset, found = contact.wheelset, contact.values

    def mean(values):
        return harmonics(contact.y, values, amplitude)[0]

    def slope(values):
        return harmonics(contact.y, values, amplitude)[1]

    motion = swing(contact.y, contact.radius_difference, wheelset.base, wheelset.radius, amplitude)
    return QuasiLinear(
        amplitude=amplitude,
        conicity=0.5 * slope(contact.radius_difference),
        equivalent=motion.conicity,
        angle=0.5 * slope(contact.angle_difference),
        roll=slope(found["roll"]),
        travel=0.5 * slope(found["s_right"] - found["s_left"]),
        lateral=mean(found["s_right"]),
        radius=mean(found["r_right"]),
        height=mean(channels[:, Node.GAP]),
        patch=tuple(mean(channels[:, Node[name]]) for name in PATCH),
        flange=contact.reaches_flank(motion),
    )


def linear_table(line, settings, wheel_name="", rail_name=""):
    """Contact table whose functions are straight: one contact point, distance D quadratic in lateral position and roll.

    The lines of a QuasiLinear hold along the path on which both wheels touch. A table asks for the lateral position u
    of the reference point and the roll apart: u = (1 - r0 roll') y along that path. Contact place and radius are taken
    over u alone, as the roll follows y; the slope of D then is

        dD/du = t0 + tu u + tr roll,    tr = d(dD/droll)/du,

    with tr from the geometry, tu so that the slope along the path is minus the contact angle parameter, and t0 so that
    the path has the roll parameter.

    Parameters
    ----------
    line : QuasiLinear
    settings : TableSettings
        Of the scenario's table: track gauge, radius, material.

    Returns
    -------
    ContactTable
    """
    settings = TableSettings(**{**settings.as_dict(), **GRID, "normal": "hertz"})
    r0, half = settings.radius, settings.lateral
    path = 1.0 - r0 * line.roll  # du/dy
    deep = line.radius - r0
    place_u = line.travel / path
    radius_u = line.conicity / path
    t0 = line.roll * (half + line.lateral) / (path - line.roll * deep)

    def bent(slope_u):
        """d(dD/droll)/du for a slope of D that grows by slope_u."""
        return -slope_u * deep - t0 * radius_u - place_u

    tu = (-line.angle - line.roll * bent(0.0)) / (path - line.roll * deep)
    tr = bent(tu)
    rr = deep - t0 * line.lateral - tr * deep
    ny, nr, nw = settings.y_count, settings.roll_count, settings.yaw_count
    u = settings.y_step * (np.arange(ny) - ny // 2)
    roll = settings.roll_step * (np.arange(nr) - nr // 2)[:, None, None]
    yaw2 = settings.yaw_range**2 * np.linspace(0.0, 1.0, nw)[:, None]
    shape = np.zeros((nr, nw, ny))
    node = np.zeros((nr, nw, ny, NODE_CHANNELS))
    lean = line.lateral + line.radius * t0
    g0 = -line.lateral - t0 * deep
    node[..., Node.GAP_YAW2] = -0.5 * t0 * lean
    node[..., Node.GAP_Y] = node[..., Node.SLOPE] = shape + t0 + tu * u + tr * roll
    node[..., Node.SLOPE_Y], node[..., Node.SLOPE_ROLL], node[..., Node.LATERAL_Y] = tu, tr, place_u
    node[..., Node.GAP_ROLL] = shape + g0 + tr * u + rr * roll
    node[..., Node.GAP] = (
        shape + line.height + t0 * u + 0.5 * tu * u**2 + g0 * roll + tr * u * roll + 0.5 * rr * roll**2
        - 0.5 * t0 * lean * yaw2
    )  # fmt: skip
    node[..., Node.LATERAL] = shape + line.lateral + place_u * u
    node[..., Node.RADIUS] = shape + line.radius + radius_u * u
    for name, value in zip(PATCH, line.patch, strict=True):
        node[..., Node[name]] = value
    index = np.arange(nr * nw * ny, dtype=np.int32).reshape(nr, nw, ny)
    corners = [
        index[r : nr - 1 + r, w : nw - 1 + w, k : ny - 1 + k].ravel() for w in (0, 1) for r in (0, 1) for k in (0, 1)
    ]
    branch = np.ascontiguousarray(np.stack(corners, axis=1))
    return ContactTable(
        settings=settings,
        wheel_name=wheel_name,
        rail_name=rail_name,
        wheel_digest="",
        rail_digest="",
        method="quasi-linear",
        node=node.reshape(-1, NODE_CHANNELS),
        cell=np.arange(branch.shape[0] + 1, dtype=np.int32),
        branch=branch,
    )


def _radii(scenario):
    """Wheel radii of the contact tables that a scenario needs, in their order [m]."""
    right, left = scenario.contact.sides
    radii = scenario.vehicle.wheel_radii
    if right != left or any(one != other for one, other in radii):
        raise InputError(
            "quasi-linear contact",
            "the left and the right side differ in profiles or wheel radii; this linearisation needs equal sides",
        )
    return [pairing.radius for pairing in needed(scenario)]


def lines_of(scenario, wheel, rail, amplitudes, progress=None):
    """Quasi-linear contact of a scenario's wheelsets.

    Parameters
    ----------
    scenario : Scenario
    wheel, rail : Profile
        Those that it names.
    amplitudes : sequence of float
        [m]
    progress : callable, optional
        Called with the share done, 0 ... 1.

    Returns
    -------
    list of tuple of QuasiLinear
        For each amplitude one for each of the vehicle's wheel radii, in their order.

    Raises
    ------
    InputError
        Left and right side differ.
    """
    radii = _radii(scenario)
    found = []
    for k, radius in enumerate(radii):
        settings = table_settings(scenario, radius)
        report = progress and (lambda share, k=k: progress((k + share) / len(radii)))
        found.append(quasi_linear(wheelset_on(settings, wheel, rail), amplitudes, settings, report))
    return list(zip(*found, strict=True))


def quasi_linear_system(scenario, lines):
    """A scenario's system with quasi-linear contact and Kalker's linear creep forces.

    Parameters
    ----------
    scenario : Scenario
    lines : sequence of QuasiLinear
        One for each of the vehicle's wheel radii.

    Returns
    -------
    System
    """
    settings = [table_settings(scenario, radius) for radius in _radii(scenario)]
    system = assemble(scenario, [linear_table(line, one) for line, one in zip(lines, settings, strict=True)])
    param, wheel = system.model.param.copy(), system.model.wheel.copy()
    param["creep_law"], param["friction_ratio"], param["friction_decay"] = Creep.HARD, 1.0, 0.0
    wheel["friction"] = np.where(wheel["friction"] > 0.0, 1.0, 0.0)  # only limits the creep force
    return replace(system, model=freeze(system.model._replace(param=param, wheel=wheel, line=NO_LINE)))
