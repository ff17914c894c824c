"""Vehicle: bodies, the joints between them and their elements, and the arrays of these for the compiled core.

Places are given as a builder sees the vehicle: x forward, y to the right, height above the rail tops; `pack` turns
them into arms from the centres of mass (x forward, y right, z down).
"""

from collections.abc import Iterator
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from railcli.kernels.layout import BODY, CURVE, ELEMENT, JOINT, WHEEL, Axes, Kind

from .air import AirSpring
from .axle import fault_on_wheelset, on_axle
from .checks import Coordinate, Description, Name, Positive, Real, Text, hint
from .elements import Bushing, Joint, Link
from .friction_elements import Friction, LeafSpring
from .moments import Matrix, Torque

LARGEST_DIFFERENCE = 0.010  # of the wheel radii of one wheelset [m]
STANDARD_GRAVITY = 9.81  # for the checks of a vehicle that no scenario has put anywhere yet [m/s^2]
STATIC_RESIDUAL = 1e-6  # share of the vehicle's weight that the preloads may leave unbalanced
_Inertia = Annotated[Positive, Field(le=1e12)]
_Radius = Annotated[Real, Field(ge=0.05, le=2.0)]
_AXES = {"mean": Axes.MEAN, "upper": Axes.UPPER}


class Body(Description):
    """A rigid body; one with a wheel radius is a wheelset, whose centre of mass lies on its axle, or one of two wheels
    that turn freely of one another on an axle line."""

    name: Name
    mass: Annotated[Positive, Field(le=1e7)] = Field(alias="mass_kg")
    inertia: tuple[_Inertia, _Inertia, _Inertia] = Field(alias="inertia_kg_m2")  # about x, y, z through its centre
    x: Coordinate = Field(alias="x_m")
    y: Coordinate = Field(0.0, alias="y_m")  # of its centre of mass, to the right
    height: Annotated[Positive, Field(le=20.0)] | None = Field(None, alias="height_m")  # of its centre of mass
    wheel_radius: _Radius | None = Field(None, alias="wheel_radius_m")  # at the tape circle
    left_wheel_radius: _Radius | None = Field(None, alias="left_wheel_radius_m")  # where it is not the same

    wheel: Literal["right", "left"] | None = None  # the only one that it has

    @model_validator(mode="after")
    def _has_one_height(self):
        if (self.height is None) == (self.wheel_radius is None):
            raise ValueError("give either height_m (of the centre of mass) or, for a wheelset, wheel_radius_m")
        if self.is_wheelset and self.y != 0.0:
            raise ValueError(f"y_m: a wheelset stands in the middle of the track, got {self.y:g} m")
        if self.wheel and (self.wheel_radius is None or self.left_wheel_radius is not None):
            raise ValueError("wheel: a body that is one wheel has wheel_radius_m and no left_wheel_radius_m")
        if self.left_wheel_radius is not None:
            if self.wheel_radius is None:
                raise ValueError("left_wheel_radius_m: only beside wheel_radius_m, the radius of the right wheel")
            if abs(self.wheel_radius - self.left_wheel_radius) > LARGEST_DIFFERENCE:
                raise ValueError(
                    f"left_wheel_radius_m: must be within {LARGEST_DIFFERENCE * 1e3:g} mm of wheel_radius_m, "
                    f"got {self.left_wheel_radius:g} m and {self.wheel_radius:g} m"
                )
        return self

    @property
    def is_wheelset(self):
        return self.wheel_radius is not None

    @property
    def wheel_radii(self):
        """Radii of the right and the left wheel of a wheelset [m]."""
        left = self.wheel_radius if self.left_wheel_radius is None else self.left_wheel_radius
        return self.wheel_radius, left

    @property
    def centre(self):
        """Centre of mass: x, y, height [m]; that of a wheelset when it stands level on both tape circles on average."""
        return (self.x, self.y, 0.5 * sum(self.wheel_radii) if self.is_wheelset else self.height)


class Vehicle(Description):
    """Bodies and joints; the first body is the one whose speed is held."""

    name: Name
    description: Text = ""
    bodies: Annotated[tuple[Body, ...], Field(min_length=1)] = Field(alias="body")
    joints: tuple[Joint, ...] = Field((), alias="joint")

    @model_validator(mode="after")
    def _stands(self):
        names = self.names
        for i, name in enumerate(names):
            if name in names[:i]:
                raise ValueError(f"body[{i + 1}].name: {name!r} is taken by body[{names.index(name) + 1}]")
        self._check_wheels()
        if not self.wheelsets:
            raise ValueError("no body is a wheelset; give wheel_radius_m to those that are")
        for j, joint in enumerate(self.joints, start=1):
            self._check_pairs(f"joint[{j}].pairs", joint)
        self._check_statics()
        return self

    def _check_wheels(self):
        for i, body in enumerate(self.bodies):
            if not body.wheel:
                continue
            right, left = (i, i + 1) if body.wheel == "right" else (i - 1, i)
            pair = self.bodies[max(right, 0) : left + 1]
            if [one.wheel for one in pair] != ["right", "left"]:
                raise ValueError(
                    f"body[{i + 1}].wheel: two wheels on one axle line follow each other, wheel = \"right\" and then "
                    f"wheel = \"left\"; {body.name!r} has no such neighbour"
                )
            if pair[0].x != pair[1].x or abs(pair[0].wheel_radius - pair[1].wheel_radius) > LARGEST_DIFFERENCE:
                raise ValueError(
                    f"body[{i + 1}]: two wheels on one axle line have the same x_m and radii within "
                    f"{LARGEST_DIFFERENCE * 1e3:g} mm; {pair[0].name!r} and {pair[1].name!r} do not"
                )

    def _check_pairs(self, where, joint):
        for p, pair in enumerate(joint.pairs, start=1):
            for name in pair:
                if name not in self.names:
                    raise ValueError(f"{where}[{p}]: no body is named {name!r}; {hint(name, self.names)}")
            lower, upper = (self.bodies[self.names.index(name)] for name in pair)
            if lower is upper:
                raise ValueError(f"{where}[{p}]: joins {pair[0]!r} with itself")
            if set(pair) in map(set, joint.pairs[: p - 1]):
                raise ValueError(f"{where}[{p}]: {pair[0]!r} and {pair[1]!r} are joined by this joint already")
            if lower.is_wheelset or upper.is_wheelset:
                fault = fault_on_wheelset(joint, lower, upper)
                if fault:
                    raise ValueError(f"{where}[{p}]: {fault}")

    def _check_statics(self):
        _, residual = _statics(self)
        worst = int(np.argmax(np.abs(residual).max(axis=1)))
        if np.abs(residual[worst]).max() > STATIC_RESIDUAL * STANDARD_GRAVITY * sum(body.mass for body in self.bodies):
            raise ValueError(
                f"nothing carries {self.names[worst]!r} at rest; give it bushings with carries_weight = true, "
                "placed so that they balance its weight without tilting it or turning an axle box"
            )
        carried = _on_wheelsets(self)[:, 0]
        if carried.min() <= 0.0:
            name = self.names[self.wheelsets[int(carried.argmin())]]
            raise ValueError(f"{name!r} would lift off at rest; check where the bodies and springs are")

    @property
    def names(self):
        return tuple(body.name for body in self.bodies)

    @property
    def axle_lines(self):
        """Indices of the bodies of the right and the left wheel of each axle line, the same one for a wheelset."""
        right = (i for i, body in enumerate(self.bodies) if body.is_wheelset and body.wheel != "left")
        return tuple((i, i + 1 if self.bodies[i].wheel else i) for i in right)

    @property
    def wheelsets(self):
        """Indices of the bodies that are wheelsets, or right wheels of axle lines, in the order of the file."""
        return tuple(right for right, _ in self.axle_lines)

    @property
    def wheel_radii(self):
        """Radii of the right and the left wheel of each axle line [m]."""
        return tuple((self.bodies[i].wheel_radii[0], self.bodies[k].wheel_radii[1]) for i, k in self.axle_lines)

    @property
    def is_dry(self):
        """True when elements have dry friction, which steady motions leave out."""
        return any(joint.frictions or joint.leaf_springs for joint in self.joints)

    @property
    def reach(self):
        """Largest distance of a body's centre from that of the first body [m]."""
        return max(abs(body.x - self.bodies[0].x) for body in self.bodies)


class Place(NamedTuple):
    """One element of one pair, as it stands in the vehicle."""

    element: Bushing | Link | Friction | LeafSpring | Matrix | AirSpring | Torque
    sign: tuple[int, int]  # -1: mirrored in x, in y
    lower: int
    upper: int
    lower_arm: np.ndarray  # from the body's centre, z down [m]
    upper_arm: np.ndarray


def placed(vehicle) -> Iterator[tuple[Joint, int, int, list[Place]]]:
    """Each pair of each joint: the joint, lower and upper body, and its elements (mirrored ones one by one)."""
    for joint in vehicle.joints:
        for pair in joint.pairs:
            lower, upper = (vehicle.names.index(name) for name in pair)
            bodies = vehicle.bodies[lower], vehicle.bodies[upper]
            places = []
            for element in joint.elements:
                ends = on_axle(element.ends, bodies)
                for sign in element.signs:
                    arms = (_arm(bodies[0].x, end, sign, body) for end, body in zip(ends, bodies, strict=True))
                    places.append(Place(element, sign, lower, upper, *arms))
            yield joint, lower, upper, places


def in_words(vehicle):
    """What the joints and the elements of the compiled core are, in its order: two tuples of texts."""
    joints, elements = [], []
    for joint, lower, upper, places in placed(vehicle):
        between = f"between {vehicle.names[lower]} and {vehicle.names[upper]}"
        joints.append(f"{joint.name} {between}")
        elements += [f"{place.element.name} {between}" for place in places]
    return tuple(joints), tuple(elements)


def _arm(origin, point, sign, body):
    x, y, height = body.centre
    return np.array([origin + sign[0] * point[0] - x, sign[1] * point[1] - y, height - point[2]])


def _carriers(vehicle):
    for _, _, _, places in placed(vehicle):
        for place in places:
            if _carries(place.element):
                yield place


def _carries(element):
    return getattr(element, "carries_weight", False) or getattr(element, "preload", 0.0) > 0.0


def _statics(vehicle, gravity=STANDARD_GRAVITY):
    """Loads on the carrying bushings at rest [N], and what stays unbalanced (n_body, 3) [N, N m].

    Vertical force, roll and pitch moment of every body balance, but the rails carry a wheelset's force and roll
    moment: of a wheelset only the pitch moment is asked for, which no axle bearing carries. Given preloads are what
    they are; of all solutions for the others the one with the least sum of squared loads, which shares a load equally
    among equal springs.
    """
    carriers = list(_carriers(vehicle))
    matrix = np.zeros((len(vehicle.bodies), 3, len(carriers)))
    weight = np.zeros((len(vehicle.bodies), 3))
    weight[:, 0] = [gravity * body.mass for body in vehicle.bodies]
    for column, place in enumerate(carriers):
        for i, arm, down in ((place.lower, place.lower_arm, 1.0), (place.upper, place.upper_arm, -1.0)):
            matrix[i, :, column] += down, down * arm[1], -down * arm[0]
    on_rails = [i for i, body in enumerate(vehicle.bodies) if body.is_wheelset]
    weight[on_rails] = 0.0
    matrix[on_rails, :2] = 0.0
    rows = matrix.reshape(weight.size, len(carriers))
    loads = np.array([getattr(place.element, "preload", 0.0) for place in carriers])
    shares = np.array([place.element.carries_weight for place in carriers], bool)
    if shares.any():
        rest = weight.ravel() + rows @ loads
        loads[shares] = np.linalg.lstsq(rows[:, shares], -rest, rcond=None)[0]
    return loads, weight + (rows @ loads).reshape(weight.shape)


def carried(vehicle, gravity):
    """Bushings that carry weight at rest with the force that each carries: list of (Place, force down [N])."""
    loads, _ = _statics(vehicle, gravity)
    return list(zip(_carriers(vehicle), loads, strict=True))


def _on_wheelsets(vehicle, gravity=STANDARD_GRAVITY):
    """Vertical force and its roll moment on each axle line at rest, (n_wheelset, 2) [N, N m]."""
    total = np.array([(gravity * body.mass, 0.0) for body in vehicle.bodies])
    for place, load in carried(vehicle, gravity):
        total[place.lower] += load, load * place.lower_arm[1]
        total[place.upper] -= load, load * place.upper_arm[1]
    return np.array([total[right] + (total[left] if left != right else 0.0) for right, left in vehicle.axle_lines])


def static_wheel_loads(vehicle, gravity, tape_circle):
    """Vertical forces of the wheels on the rails at rest on straight level track.

    Parameters
    ----------
    vehicle : Vehicle
    gravity : float
        [m/s^2]
    tape_circle : float
        Distance of the tape circles from the middle of a wheelset [m].

    Returns
    -------
    numpy.ndarray, shape (n_wheelset, 2)
        Right and left wheel, down positive [N].
    """
    force, moment = _on_wheelsets(vehicle, gravity).T
    return np.stack([force + moment / tape_circle, force - moment / tape_circle], axis=1) / 2.0


class PackedVehicle(NamedTuple):
    """Arrays of the compiled core (kernels/layout.py) that describe a vehicle; all read-only."""

    body: np.ndarray
    joint: np.ndarray
    element: np.ndarray
    curve: np.ndarray
    wheel: np.ndarray
    rest: np.ndarray  # (n_body, 6) coordinates in the nominal geometry, s relative to the first body [m, rad]
    damper: np.ndarray  # (n_state,) states of the elements, nothing displaced and no friction [m, N]
    matrix: np.ndarray  # (n_matrix, 12, 6)


def pack(vehicle, gravity, tape_circle, friction):
    """Arrays of a vehicle for the compiled core.

    Parameters
    ----------
    vehicle : Vehicle
    gravity : float
        [m/s^2]
    tape_circle : float
        Distance of the tape circles from the middle of a wheelset [m].
    friction : float
        Coefficient of friction of every wheel.

    Returns
    -------
    PackedVehicle
        Frame x forward, y right, z down. Both wheels of a wheelset adjoin, the right one first; which contact table a
        wheel takes is left to the assembler. A bushing's preload is the force on the upper body, so one that carries
        weight is negative along z.
    """
    loads = iter(_statics(vehicle, gravity)[0])
    joints, elements = [], []
    parts = _Parts(vehicle)
    for joint, lower, upper, places in placed(vehicle):
        record = np.zeros(1, JOINT)[0]
        record["lower"], record["upper"] = lower, upper
        record["first"], record["count"] = len(elements), len(places)
        record["axes"], record["turn"] = _AXES[joint.axes], joint.total_turn_stiffness
        joints.append(record)
        for place in places:
            row = np.zeros(1, ELEMENT)[0]
            row["lower"], row["upper"] = place.lower_arm, place.upper_arm
            for key in ("spring_curve", "damper_curve", "stiff", "state", "source", "matrix"):
                row[key] = -1
            if _carries(place.element):
                row["preload"][2] = -next(loads)
            _FILL[type(place.element)](row, place, parts)
            if getattr(place.element, "load_of", None) is not None:
                row["source"] = record["first"] + _source(place, places)
            elements.append(row)
    rest = np.zeros((len(vehicle.bodies), 6))
    rest[:, 0] = [body.x - vehicle.bodies[0].x for body in vehicle.bodies]
    rest[:, 1] = [body.y for body in vehicle.bodies]
    rest[:, 2] = [-body.centre[2] for body in vehicle.bodies]
    packed = PackedVehicle(
        body=_bodies(vehicle),
        joint=np.array(joints, JOINT),
        element=np.array(elements, ELEMENT),
        curve=np.array(parts.curves, CURVE),
        wheel=_wheels(vehicle, tape_circle, friction),
        rest=rest,
        damper=np.array(parts.states, np.float64),
        matrix=np.array(parts.matrices).reshape(-1, 12, 6),
    )
    for array in packed:
        array.flags.writeable = False
    return packed


def _fill_bushing(row, place, parts):
    bushing = place.element
    row["kind"] = Kind.BUSHING
    row["k"], row["c"] = bushing.stiffness, bushing.damping
    for key, tables in (("spring_curve", bushing.spring_tables), ("damper_curve", bushing.damper_tables)):
        for axis, (table, side) in enumerate(zip(tables, (*place.sign, 1), strict=True)):
            if table is not None:
                x, y = table.knots()
                row[key][axis] = parts.curve(side * x[::side], side * y[::side])
    row["dampers"] = any(table is not None for table in bushing.damper_tables)


def _fill_link(row, place, parts):
    link = place.element
    row["kind"] = Kind.LINK
    row["k"][0], row["c"][0] = link.stiffness, link.damping
    row["length"], row["series"] = link.length, link.series_stiffness
    if link.damper_table is not None:
        rate, force = link.damper_table.knots()
        row["damper_curve"][0] = parts.curve(rate, force)
        row["dry"] = link.series_stiffness > 0.0 and np.any(np.diff(force) == 0.0)
    if link.series_stiffness:
        row["state"] = parts.state(link.length)


def _fill_friction(row, place, parts):
    friction = place.element
    row["kind"] = Kind.DRY_LINK if friction.is_link else Kind.DRY
    row["limit"], row["coefficient"], row["series"] = friction.limit, friction.coefficient, friction.series_stiffness
    row["c"][0] = friction.damping_between(*(parts.vehicle.bodies[i].mass for i in (place.lower, place.upper)))
    if friction.is_link:
        row["length"] = friction.length
        row["state"] = parts.state(friction.length)
    else:
        row["k"] = [friction.series_stiffness * (axis in friction.directions) for axis in "xyz"]
        row["state"] = parts.state(*(0.0 for _ in friction.directions))


def _source(friction, places):
    """Place in its joint of the bushing whose load a friction element feels: the copy on the same side, or the one."""
    known = [k for k, place in enumerate(places) if place.element.name == friction.element.load_of]
    known = [k for k in known if isinstance(places[k].element, Bushing)]
    return next((k for k in known if places[k].sign == friction.sign), known[0])


def _fill_leaf_spring(row, place, parts):
    spring = place.element
    row["kind"], row["decay"] = Kind.LEAF, spring.decay
    row["spring_curve"][:2] = [parts.curve(x, force) for x, force in spring.envelopes]
    row["state"] = parts.state(0.0, spring.middle)


def _fill_matrix(row, place, parts):
    row["kind"], row["matrix"] = Kind.MATRIX, len(parts.matrices)
    parts.matrices.append(place.element.packed(place.sign))


def _fill_air(row, place, parts):
    air = place.element
    row["kind"], row["dampers"] = Kind.AIR, 1
    vertical = air.stiffness(-row["preload"][2])
    row["k"], row["c"] = (*air.shear_stiffness, vertical.area), (*air.shear_damping, air.orifice_damping)
    row["series"], row["reservoir"], row["state"] = vertical.bellows, vertical.reservoir, parts.state(0.0)
    if air.orifice_table is not None:
        row["damper_curve"][2] = parts.curve(*air.orifice_table.knots())


def _fill_torque(row, place, parts):
    torque = place.element
    row["kind"], row["lower"] = Kind.TORQUE, torque.direction
    row["k"][0], row["c"][0], row["limit"] = torque.turn_stiffness, torque.turn_damping, torque.friction
    row["preload"][0] = torque.torque
    for key, table in (("spring_curve", torque.turn_table), ("damper_curve", torque.turn_damper_table)):
        if table is not None:
            row[key][0] = parts.curve(*table.knots())


_FILL = {
    Bushing: _fill_bushing,
    Link: _fill_link,
    Friction: _fill_friction,
    LeafSpring: _fill_leaf_spring,
    Matrix: _fill_matrix,
    AirSpring: _fill_air,
    Torque: _fill_torque,
}


class _Parts:
    """What elements share or have a place in: curves (equal ones once), states and matrices."""

    def __init__(self, vehicle):
        self.vehicle = vehicle
        self.curves, self.states, self.matrices = [], [], []
        self._known = {}

    def curve(self, x, y):
        """Place of a curve."""
        key = (tuple(x), tuple(y))
        if key not in self._known:
            row = np.zeros(1, CURVE)[0]
            row["count"], row["x"][: x.size], row["y"][: y.size] = x.size, x, y
            self._known[key] = len(self.curves)
            self.curves.append(row)
        return self._known[key]

    def state(self, *values):
        """First place of states that have these values at rest."""
        self.states.extend(values)
        return len(self.states) - len(values)


def _bodies(vehicle):
    array = np.zeros(len(vehicle.bodies), BODY)
    for row, body in zip(array, vehicle.bodies, strict=True):
        row["mass"], row["inertia"], row["spins"] = body.mass, body.inertia, body.is_wheelset
    return array


def _wheels(vehicle, tape_circle, friction):
    array = np.zeros(2 * len(vehicle.axle_lines), WHEEL)
    for n, (line, radii) in enumerate(zip(vehicle.axle_lines, vehicle.wheel_radii, strict=True)):
        for row, body, side, radius in zip(array[2 * n : 2 * n + 2], line, (1.0, -1.0), radii, strict=True):
            row["body"], row["side"] = body, side
            row["lateral"], row["radius"], row["friction"] = tape_circle, radius, friction
    return array
