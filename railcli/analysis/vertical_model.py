"""The linear model of a vehicle in its vertical plane: an independent reference for small vertical disturbances.

Written from the vehicle's description, not from the packed model: bodies move along x and z and pitch, wheelsets along
x and z and spin; springs and dampers as they stand, dampers with series stiffness with their state, dry friction by its
series spring, contact by its stiffness about rest, 1.5 N / p along z, and its damping (docs/disturbance.md). Rails may
stand on a spring and a damper each, without mass. Signs of the track frame: z down, pitch front up. All quantities are
departures from rest on straight level track at constant speed.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import StateSpace, lsim

from railcli.errors import InputError
from railcli.model.air import AirSpring
from railcli.model.elements import Bushing, Link
from railcli.model.friction_elements import Friction, LeafSpring
from railcli.model.moments import Matrix, Torque
from railcli.model.vehicle import carried, placed

X, Z, PITCH = 0, 1, 2


@dataclass(frozen=True)
class Contact:
    """Of one wheel at rest.

    Attributes
    ----------
    force, depth : float
        Normal force [N], penetration along z [m].
    cosine : float
        Of the contact angle.
    creep : float
        f11 [N].
    damping : float
        D of N = k d^1.5 (1 + D d') [s/m].
    rail : pair of float, optional
        Stiffness [N/m] and damping [N s/m] of what bears its rail; None: the rail does not give way.
    """

    force: float
    depth: float
    cosine: float
    creep: float
    damping: float
    rail: tuple | None = None

    @property
    def stiffness(self):
        """Of the vertical force over the vertical approach [N/m]: 1.5 N / p on a level tread."""
        return 1.5 * self.force / self.depth * self.cosine

    @property
    def resistance(self):
        """Of the vertical force over the vertical rate [N s/m]."""
        return self.damping * self.force * self.cosine**2

    @property
    def share(self):
        """What a sudden approach leaves of its force when the rail's damper and the contact's stand in series."""
        return 1.0 if self.rail is None else self.rail[1] / (self.rail[1] + self.resistance)

    @property
    def held(self):
        """Force per deflection of the rail, the wheel held: what its spring gives less what the contact loses [N/m]."""
        if self.rail is None:
            return 0.0
        stiffness, damping = self.rail
        return (stiffness * self.resistance - damping * self.stiffness) / (damping + self.resistance)


@dataclass(frozen=True)
class VerticalModel:
    """State space of the vehicle over its vertical track input.

    Inputs: height of the rails under each wheelset (down, both rails alike) [m], then their rates [m/s]. Outputs:
    change of the vertical force of one wheel of each wheelset [N], then vertical acceleration of every body [m/s^2].
    """

    space: StateSpace
    places: np.ndarray  # (n_wheelset,) ahead of the first body [m]
    speed: float

    def response(self, time, rail):
        """Outputs (n, n_output) at equal distances of time over rail(s) = (height, slope), from rest at time 0."""
        s = self.speed * time[:, None] + self.places
        height, slope = rail(s)
        _, output, _ = lsim(self.space, np.hstack([height, self.speed * slope]), time)
        return output

    def transfer(self, frequency):
        """Outputs per metre of a wave of rail height, complex (n, n_output); phase against that at the first body."""
        a, b, c, d = self.space.A, self.space.B, self.space.C, self.space.D
        rows = []
        for f in np.atleast_1d(frequency):
            jw = 2j * np.pi * f
            delay = np.exp(jw * self.places / self.speed)
            wave = np.concatenate([delay, jw * delay])
            rows.append(c @ np.linalg.solve(jw * np.eye(a.shape[0]) - a, b @ wave) + d @ wave)
        return np.array(rows)


def vertical_model(vehicle, contacts, speed, hold, gravity):
    """The linear model.

    Parameters
    ----------
    vehicle : Vehicle
    contacts : sequence of Contact
        One wheel of each wheelset, in their order.
    speed : float
        [m/s]
    hold : float
        Force per speed error on the first body [N s/m].
    gravity : float
        [m/s^2]

    Returns
    -------
    VerticalModel
    """
    if any(body.wheel for body in vehicle.bodies):
        raise InputError(vehicle.name, "the linear vertical model takes wheelsets only, no wheels that turn freely")
    n = 3 * len(vehicle.bodies)
    mass = np.zeros(n)
    for i, body in enumerate(vehicle.bodies):
        mass[3 * i : 3 * i + 3] = body.mass, body.mass, body.inertia[1]
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    states = []  # of dampers: direction, series stiffness, damping, stiffness beside it
    loads = {_key(place): load for place, load in carried(vehicle, gravity)}
    for joint, lower, upper, places in placed(vehicle):
        turn = np.zeros(n)
        turn[3 * upper + PITCH], turn[3 * lower + PITCH] = 1.0, -1.0
        stiffness += joint.total_turn_stiffness[1] * np.outer(turn, turn)
        for place in places:
            def stretch(direction, place=place, lower=lower, upper=upper):
                row = _motion(vehicle, n, upper, place.upper_arm, direction)
                return row - _motion(vehicle, n, lower, place.lower_arm, direction)

            if isinstance(place.element, Matrix):
                three = np.array([stretch((1.0, 0.0)), stretch((0.0, 1.0)), turn])
                k, c = (half[[0, 2, 4]][:, [0, 2, 4]] for half in np.split(place.element.packed(place.sign), 2))
                stiffness += three.T @ k @ three
                damping += three.T @ c @ three
                continue
            if isinstance(place.element, Torque):
                k, c = _torque(place.element)
                stiffness += k * np.outer(turn, turn)
                damping += c * np.outer(turn, turn)
                continue
            load = loads.get(_key(place), 0.0)
            for direction, k, c, series, beside in _springs(vehicle, place, load):
                row = stretch(direction)
                stiffness += k * np.outer(row, row)
                if series and row.any():
                    states.append((row, series, c, beside))
                else:
                    damping += c * np.outer(row, row)
    axes = {_key(place): joint.axes for joint, _, _, places in placed(vehicle) for place in places}
    for place, load in carried(vehicle, gravity):
        stiffness += load * _tilt(vehicle, n, place, axes[_key(place)])
    damping[X, X] += hold
    at_rail, from_height, from_rate = [], [], []
    for i, contact in zip(vehicle.wheelsets, contacts, strict=True):
        sink, slide = np.zeros(n), np.zeros(n)
        sink[3 * i + Z] = 1.0
        slide[3 * i + X], slide[3 * i + PITCH] = 1.0, vehicle.bodies[i].wheel_radius
        stiffness += 2.0 * contact.share * contact.stiffness * np.outer(sink, sink)
        damping += 2.0 * contact.share * contact.resistance * np.outer(sink, sink)
        damping += 2.0 * contact.creep / speed * np.outer(slide, slide)
        downhill = np.zeros(n)
        downhill[3 * i + X] = 2.0 * contact.force / speed
        from_height.append(2.0 * contact.share * contact.stiffness * sink)
        from_rate.append(2.0 * contact.share * contact.resistance * sink + downhill)
        at_rail.append((sink, contact))
    space = _space(mass, stiffness, damping, states, np.array(from_height), np.array(from_rate), at_rail)
    first = vehicle.bodies[0].x
    return VerticalModel(space, np.array([vehicle.bodies[i].x - first for i in vehicle.wheelsets]), speed)


def _key(place):
    """What tells one place of an element from all others."""
    return id(place.element), place.lower, place.upper, place.sign


def _springs(vehicle, place, load):
    """Direction (x, z), stiffness, damping, series stiffness and that beside the damper of each spring of an element.

    Friction sticks. load : that it carries at rest [N].
    """
    element = place.element
    if isinstance(element, Bushing):
        for axis, direction in ((0, (1.0, 0.0)), (2, (0.0, 1.0))):
            damping = element.damping[axis] + _slope(element.damper_tables[axis])
            yield direction, element.stiffness[axis] + _slope(element.spring_tables[axis]), damping, 0.0, 0.0
    elif isinstance(element, AirSpring):
        air = element.stiffness(load)
        yield (1.0, 0.0), element.shear_stiffness[0], element.shear_damping[0], 0.0, 0.0
        yield (0.0, 1.0), air.area, element.orifice_damping + _slope(element.orifice_table), air.bellows, air.reservoir
    elif isinstance(element, Link):
        damping = element.damping + _slope(element.damper_table)
        yield _line(place), element.stiffness, damping, element.series_stiffness, 0.0
    elif isinstance(element, Friction):
        damping = element.damping_between(*(vehicle.bodies[i].mass for i in (place.lower, place.upper)))
        along = {"x": (1.0, 0.0), "z": (0.0, 1.0)}
        lines = [_line(place)] if element.is_link else [along[axis] for axis in element.directions if axis in along]
        for direction in lines:
            yield direction, element.series_stiffness, damping, 0.0, 0.0
    elif isinstance(element, LeafSpring):
        yield (0.0, 1.0), element.soft_stiffness, 0.0, 0.0, 0.0
    else:
        raise TypeError(f"no springs known of {type(element).__name__}")


def _line(place):
    """Direction (x, z) from the lower to the upper end of an element."""
    element = place.element
    along = np.subtract(element.upper, element.lower) / element.length
    return place.sign[0] * along[0], -along[2]


def _torque(element):
    """Stiffness and damping of a torque about y: the share of its axis along it; dry friction does not count."""
    share = element.direction[1] ** 2
    stiffness = element.turn_stiffness + _slope(element.turn_table)
    return share * stiffness, share * (element.turn_damping + _slope(element.turn_damper_table))


def _slope(table):
    """Slope of a table through (0, 0) at 0: the mean of both sides."""
    if table is None:
        return 0.0
    x, y = table.knots()
    tiny = 1e-6 * np.abs(x).max()
    return float((np.interp(tiny, x, y) - np.interp(-tiny, x, y)) / (2.0 * tiny))


def _motion(vehicle, n, body, arm, direction):
    """Motion of a point of a body along a direction, as a row over the coordinates; an axle box does not pitch."""
    row = np.zeros(n)
    row[3 * body + X], row[3 * body + Z] = direction
    if not vehicle.bodies[body].is_wheelset:
        row[3 * body + PITCH] = arm[2] * direction[0] - arm[0] * direction[1]
    return row


def _tilt(vehicle, n, place, axes):
    """Stiffness per newton carried, from the turning of the spring's axes and ends (docs/disturbance.md)."""
    ahead = _motion(vehicle, n, place.upper, place.upper_arm, (1.0, 0.0))
    ahead -= _motion(vehicle, n, place.lower, place.lower_arm, (1.0, 0.0))
    upper, lower = np.zeros(n), np.zeros(n)
    upper[3 * place.upper + PITCH] = 1.0
    if not vehicle.bodies[place.lower].is_wheelset:
        lower[3 * place.lower + PITCH] = 1.0
    mean = upper if axes == "upper" else 0.5 * (upper + lower)
    turned = place.lower_arm[2] * np.outer(lower, lower) - place.upper_arm[2] * np.outer(upper, upper)
    return turned + np.outer(mean, ahead) + np.outer(ahead, mean)


def _space(mass, stiffness, damping, states, from_height, from_rate, at_rail):
    """State space over places, rates, dampers and rails u that give way: c u' + k u = contact's force on the rail.

    The contact's force is share (k_c (z - u - h) + c_c (z' - h')) + ... u, once u' is put into c_c (z' - u' - h').
    """
    n, m, wheelsets = mass.size, len(states), len(at_rail)
    giving = [k for k, (_, contact) in enumerate(at_rail) if contact.rail is not None]
    first, size = 2 * n + m, 2 * n + m + len(giving)
    direction = np.array([row for row, *_ in states]).reshape(m, n)
    series, damper, beside = (np.array([state[k] for state in states]) for k in (1, 2, 3))
    rate = series / damper
    stiffness = stiffness + direction.T @ (series[:, None] * direction)
    a = np.zeros((size, size))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -stiffness / mass[:, None]
    a[n : 2 * n, n : 2 * n] = -damping / mass[:, None]
    a[n : 2 * n, 2 * n : first] = direction.T * series / mass[:, None]
    a[2 * n : first, :n] = rate[:, None] * direction
    a[2 * n : first, 2 * n : first] = -np.diag(rate + beside / damper)
    b = np.zeros((size, 2 * wheelsets))
    b[n : 2 * n] = np.hstack([from_height.T, from_rate.T]) / mass[:, None]
    wheel = np.zeros((wheelsets, size))
    through = np.zeros((wheelsets, 2 * wheelsets))
    for k, (sink, contact) in enumerate(at_rail):
        over_place, over_rate = contact.share * contact.stiffness, contact.share * contact.resistance
        wheel[k, :n], wheel[k, n : 2 * n] = over_place * sink, over_rate * sink
        through[k, k], through[k, wheelsets + k] = -over_place, -over_rate
    for row, k in enumerate(giving, start=first):
        sink, contact = at_rail[k]
        wheel[k, row] = contact.held
        a[n : 2 * n, row] = -2.0 * contact.held * sink / mass
        a[row], b[row] = wheel[k] / contact.rail[1], through[k] / contact.rail[1]
        a[row, row] -= contact.rail[0] / contact.rail[1]
    vertical = n + np.arange(n)[Z::3]
    return StateSpace(a, b, np.vstack([wheel, a[vertical]]), np.vstack([through, b[vertical]]))
