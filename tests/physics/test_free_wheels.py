"""Two wheels that turn freely of one another on one axle line: no couple of creep forces, no guidance by conicity."""

import re

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import steady, touching_depth
from railcli.files.scenario import load
from railcli.model.elements import Bushing, Joint
from railcli.model.system import assemble
from railcli.model.vehicle import Body, Vehicle

SIDES = {"right": 1.0, "left": -1.0}
ANGLE = 0.025
WHEEL_MASS, HALF = 300.0, 0.75
WHEEL = {"mass": WHEEL_MASS, "inertia": (20.0 + WHEEL_MASS * HALF**2, 35.0, 20.0 + WHEEL_MASS * HALF**2)}


def free_wheels(name, x, radius, mass, inertia):
    """An axle that does not turn and its two wheels with their bearings: bodies and joints."""
    bodies = [Body(name=name, mass=mass, inertia=inertia, x=x, height=radius)]
    joints = []
    for wheel, side in SIDES.items():
        bodies.append(Body(name=f"{name} {wheel}", x=x, wheel_radius=radius, wheel=wheel, **WHEEL))
        bearing = Bushing(
            name="bearing", at=(0.0, side * HALF, radius), stiffness=(2e8, 2e8, 2e8), damping=(2e5, 2e5, 2e5),
            turn_stiffness=(2e7, 0.0, 2e7), carries_weight=True,
        )  # fmt: skip
        joints.append(
            Joint(name=f"bearing {wheel}", pairs=[(f"{name} {wheel}", name)], axes="upper", bushings=(bearing,))
        )
    return bodies, joints


def lone_axle(table, speed):
    """`scenes.lone_wheelset` of the same weight on free wheels."""
    radius = table.settings.radius
    bodies, joints = free_wheels("axle", 0.0, radius, 1400.0, (600.0, 50.0, 600.0))
    vehicle = Vehicle(name="axle with free wheels", bodies=bodies, joints=joints)
    return scenes.alone(table, vehicle, speed, 0.2e-3)


def rolling(system, y, yaw):
    """Data of an axle line that rolls from y, yawed, along its own direction."""
    data = system.start(0.0, y)
    data.q[:, 2] += touching_depth(system.model) + 0.06e-3
    data.q[:, 5] = yaw
    data.v[:, 1] = yaw * system.speed
    data = scenes.data_at(system.model, data.q, data.v)
    for w, i in enumerate(system.model.wheel["body"]):
        data.v[i, 4] = -system.speed / data.contact[w, 0]["radius"] if i else data.v[i, 4]
    return scenes.data_at(system.model, data.q, data.v)


def test_conicity_does_not_guide_free_wheels():
    """Yawed and aside, they roll straight on where a wheelset swings, each with the spin of its own radius."""
    table, speed, yaw = scenes.cone_table(ANGLE), 5.0, 1e-3
    free, fixed = lone_axle(table, speed), scenes.lone_wheelset(table, speed, step=0.2e-3)
    data, other = rolling(free, -1e-3, yaw), rolling(fixed, -1e-3, yaw)
    start = data.q[0].copy()
    scenes.run(free, data, 1.2)
    scenes.run(fixed, other, 1.2)
    moved = data.q[0] - start
    assert moved[1] / moved[0] == pytest.approx(np.tan(yaw), rel=tol.FREE_STRAIGHT_ON)
    assert data.q[0, 5] == pytest.approx(yaw, rel=tol.FREE_STRAIGHT_ON)
    assert abs(other.q[0, 5] - yaw) > 0.5 * yaw
    radii, longitudinal = data.contact["radius"][:, 0], data.contact["f11"][:, 0]
    assert radii[1] - radii[0] == pytest.approx(-2.0 * np.tan(ANGLE) * data.q[0, 1], rel=0.05)
    along = data.v[0, 0] - np.array([HALF, -HALF]) * data.v[0, 5]
    assert_allclose(-data.v[1:, 4] * radii, along, rtol=tol.FREE_SPIN)
    of_wheelset = longitudinal * 0.5 * abs(radii[1] - radii[0]) / table.settings.radius
    assert (np.abs(data.rail["x"]) < tol.FREE_COUPLE * of_wheelset).all()


def wagon_on_free_wheels():
    """The Manchester wagon with an axle that does not turn and two free wheels in place of each wheelset."""
    case = load("curve-1200-45")
    bodies, joints = [], list(case.vehicle.joints)
    for body in case.vehicle.bodies:
        if not body.is_wheelset:
            bodies.append(body)
            continue
        inertia = [whole - 2.0 * part for whole, part in zip(body.inertia, WHEEL["inertia"], strict=True)]
        more, bearings = free_wheels(body.name, body.x, body.wheel_radius, body.mass - 2.0 * WHEEL_MASS, inertia)
        bodies += more
        joints += bearings
    on_axles = [pair for joint in joints[:1] for pair in joint.pairs]
    guide = Bushing(name="guide", at=(0.0, 0.0, 0.5), stiffness=(0.0, 0.0, 0.0), turn_stiffness=(0.0, 1e6, 0.0))
    joints.append(Joint(name="guide", pairs=on_axles, axes="mean", bushings=(guide,)))
    return case.varied(
        vehicle=Vehicle(name="wagon on free wheels", bodies=bodies, joints=joints),
        run={"speed": 25.0, "step": 0.25e-3, "output_interval": 0.25e-3},
    )


def test_wagon_on_free_wheels(table):
    """It stands and rolls as on wheelsets; in a curve its leading axles run to their flanges; on the trailing ones
    every wheel turns with its own path, without creep along the rail."""
    system = assemble(wagon_on_free_wheels(), [table])
    straight = steady(system, 0.0, 0.0).data
    assert_allclose(straight.rail["q"], scenes.wagon(table).model.body["mass"].sum() * 9.81 / 8.0, rtol=tol.FREE_LOAD)
    assert np.abs(straight.rail["x"]).max() < 1.0
    data = system.start(0.0)
    data.q[:], data.v[:], data.damper[:] = straight.q, straight.v, straight.damper
    scenes.run(system, data, 16.0)
    for number, first in enumerate(system.wheelsets):
        wheels = slice(2 * number, 2 * number + 2)
        leads = number % 2 == 0
        assert (data.q[first, 1] < -6e-3) == leads
        if not leads:
            rail = data.rail[wheels]
            assert (rail["patches"] == 1).all() and (np.abs(rail["x"]) < tol.FREE_SHARE * 0.3 * rail["q"]).all()
            velocity = data.v[first : first + 2]
            along = velocity[:, 0] - np.array([HALF, -HALF]) * velocity[:, 5]
            turning = -data.contact["radius"][wheels, 0] * velocity[:, 4]
            assert_allclose(turning, along, rtol=tol.FREE_PATH)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wheel": "left"}, "body[1].wheel: two wheels on one axle line follow each other"),
        ({"x": 1.0}, "have the same x_m and radii within 10 mm"),
        ({"wheel_radius": 0.44}, "have the same x_m and radii within 10 mm"),
        ({"wheel_radius": None, "height": 0.46}, "a body that is one wheel has wheel_radius_m"),
    ],
)
def test_two_free_wheels_must_be_a_pair(change, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        right = Body(**{"name": "right", "x": 0.0, "wheel_radius": 0.46, "wheel": "right", **WHEEL, **change})
        left = Body(name="left", x=0.0, wheel_radius=0.46, wheel="left", **WHEEL)
        Vehicle(name="wheels", bodies=(right, left))
