"""Small systems made of the product's own parts, for the tests of the physics."""

from dataclasses import replace

import naive
import numpy as np

from benchmarks.speed import numpy_twin
from railcli.analysis.build_table import build_table
from railcli.files.scenario import load
from railcli.kernels.heights import POWER, stored
from railcli.kernels.layout import (
    BODY,
    ELEMENT,
    JOINT,
    NODE_CHANNELS,
    SAMPLE_ROWS,
    SHIFT_CHANNELS,
    WHEEL,
    freeze,
    new_data,
)
from railcli.kernels.step import advance, evaluate
from railcli.model.contact_table import TableSettings
from railcli.model.profile import Profile
from railcli.model.scenario import Contact, Run, Scenario
from railcli.model.sections import Gradient
from railcli.model.system import assemble
from railcli.model.track import Curve, Straight, Track, Transition, pack
from railcli.model.vehicle import Body, Vehicle

SMALL = TableSettings(normal="hertz", y_range=10e-3, roll_range=7.5e-3, yaw_range=30e-3 * 0.2**0.5, yaw_count=3)
STRIPS = TableSettings(y_range=8e-3, roll_range=6e-3, yaw_range=10e-3)
HEAD = 0.3  # radius of the round rail [m]
WINDING = Track(  # something of everything
    (
        Straight(length=20.0),
        Transition(length=40.0, shape="clothoid"),
        Curve(length=30.0, radius=250.0, hand="right", cant=0.15),
        Transition(length=70.0, shape="bloss"),
        Curve(length=30.0, radius=300.0, hand="left", cant=0.10),
        Transition(length=40.0, shape="clothoid"),
        Straight(length=50.0),
    )
)
HILLS = (  # for WINDING: down, a sag in its first curve and a crest in its reversing transition
    Gradient(at=0.0, gradient=-0.02),
    Gradient(at=70.0, gradient=0.03, radius=800.0),
    Gradient(at=140.0, gradient=-0.015, radius=1000.0),
)
SMOOTH = Track(  # without the kinks that the ends of a linear cant ramp make
    (
        Straight(length=30.0),
        Transition(length=80.0, shape="bloss"),
        Curve(length=150.0, radius=250.0, hand="right", cant=0.15),
    )
)

SHORT_CURVE = """
title = "A short <curve> & its end"
[run]
speed_m_per_s = 20
average_over_m = 20
output_interval_ms = {interval}
[contact]
table = "{table}"
normal = "hertz"
creep_law = "table"
friction = {friction}
[[track]]
kind = "straight"
length_m = 10
[[track]]
kind = "transition"
length_m = 40
[[track]]
kind = "curve"
length_m = 40
radius_m = 600
hand = "left"
cant_mm = 60
"""


def wagon(table, case="curve-1200-45", **groups):
    """The Manchester wagon in one of its cases on a given table; groups as `Scenario.varied`."""
    return assemble(load(case).varied(**groups), [table])


def tuned(system, **values):
    """The same system with other values in PARAM."""
    param = system.model.param.copy()
    for key, value in values.items():
        param[key] = value
    return replaced(system, param=param)


def replaced(system, **arrays):
    """The same system with other arrays in its model."""
    return replace(system, model=freeze(system.model._replace(**arrays)))


def edited(system, name, **values):
    """The same system with fields of all records of one array set."""
    array = getattr(system.model, name).copy()
    for key, value in values.items():
        array[key] = value
    return replaced(system, **{name: array})


def on_rails(system, displacement, step=0.05, reach=(-45.0, 620.0)):
    """The same system on displaced rails.

    displacement : called with arc lengths (n,); returns values and slopes, each (rail, direction, n): right and left,
        to the right and down [m], [-].
    """
    start, end = reach
    s = start + step * np.arange(round((end - start) / step) + 1)
    value, slope = displacement(s)
    shift = np.stack([value, slope], axis=2).reshape(SHIFT_CHANNELS, s.size).T
    return tuned(replaced(system, shift=np.ascontiguousarray(shift)), shift_start=start, shift_step=step)


def waves(s):
    """Displacement of some millimetres of every rail and direction, each with waves of its own."""
    length = np.array([[9.0, 5.0], [7.0, 6.0]])[..., None]
    size = np.array([[2e-3, 3e-3], [1.5e-3, 4e-3]])[..., None]
    phase = 2.0 * np.pi * s / length + np.array([[0.3, 1.1], [2.0, 4.0]])[..., None]
    return size * np.sin(phase), size * np.cos(phase) * 2.0 * np.pi / length


def turn_x(angle):
    """Matrix of a rotation about x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def turn_y(angle):
    """Matrix of a rotation about y: front up."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def turn_z(angle):
    """Matrix of a rotation about z: to the right."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def floating(system, track=None):
    """The same system without rails, weight or drive: bodies and what joins them, in free space."""
    track = system.model.track if track is None else pack(track) if isinstance(track, Track) else track
    free = replaced(system, wheel=np.zeros(0, WHEEL), track=track)
    return tuned(free, gravity=0.0, hold=0.0)


def bodies(system, mass, inertia, spins):
    """Free bodies alone, on the track of a system."""
    array = np.zeros(len(mass), BODY)
    array["mass"], array["inertia"], array["spins"] = mass, inertia, spins
    return replaced(floating(system), body=array, joint=np.zeros(0, JOINT), element=np.zeros(0, ELEMENT))


def data_at(model, q, v, damper=()):
    """Data of a state, with the accelerations that belong to it."""
    data = new_data(model, q, len(damper))
    data.v[:] = v
    data.damper[:] = damper
    assert evaluate(model, data, 0.0) == 0
    return data


def run(system, data, seconds):
    """Advance; any fault is a failure of the test."""
    steps = round(seconds / system.model.param[0]["step"])
    assert advance(system.model, data, steps) == 0
    return data


def stored_at(table, y, z, roll, yaw):
    """Energy and gradient of a table of heights, its patches."""
    sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))
    count, _, depth, *gradient = stored(
        table.record[0], table.cell, table.branch, table.heights, y, roll, yaw, z, 0, sample
    )
    assert count >= 0
    return depth * gradient[1] / POWER, np.array(gradient), sample[:count]


def cone(angle):
    """Right-hand wheel without a flange whose radius falls by tan(angle) per metre to the field side."""
    y = np.linspace(-0.06, 0.06, 25)
    return Profile.from_points("cone", "wheel", y, -np.tan(angle) * y)


def round_rail(radius=HEAD):
    """Rail whose head is a circle, wide enough to have a gauge face 14 mm below its top."""
    angle = np.linspace(-0.38, 0.38, 153)
    return Profile("round", "rail", radius * np.sin(angle), radius * (1.0 - np.cos(angle)), angle)


def round_settings(**values):
    """Settings under which the tape circle stands over the crown of round rails: seat = 0."""
    settings = TableSettings(**{"normal": "hertz", "inclination": 0.0, **values})
    half = np.sqrt(HEAD**2 - (HEAD - 0.014) ** 2)
    return replace(settings, gauge=2.0 * (settings.lateral - half))


def cone_table(angle, **values):
    """Table of cones on round rails, with few cells, in which everything is smooth."""
    grid = {"y_range": 8e-3, "y_step": 1e-3, "roll_range": 4e-3, "roll_step": 1e-3, "yaw_range": 12e-3, "yaw_count": 4}
    settings = round_settings(**{**grid, **values})
    return build_table(cone(angle), round_rail(), settings)[0]


def lone_wheelset(table, speed, step=0.5e-3, mass=2000.0, inertia=(1000.0, 100.0, 1000.0), track=None, **contact):
    """One wheelset on its own two wheels."""
    body = Body(name="wheelset", mass=mass, inertia=inertia, x=0.0, wheel_radius=table.settings.radius)
    return alone(table, Vehicle(name="lone wheelset", bodies=(body,)), speed, step, track, **contact)


def alone(table, vehicle, speed, step, track=None, **contact):
    """A vehicle on straight track, or another."""
    scenario = Scenario(
        name="lone wheelset",
        vehicle=vehicle,
        run=Run(speed=speed, step=step, output_interval=step),
        track=track or Track((Straight(length=500.0),)),
        contact=Contact(
            **{
                "flange_back": table.settings.flange_back,
                "normal": table.settings.normal,
                "creep_law": "hard",
                **contact,
            }
        ),
    )
    return assemble(scenario, [table])


def energy(system, data):
    """Of motion, weight, springs and, while each wheel has one patch, the elastic half-spaces: 2/5 N d."""
    model, body = system.model, system.model.body
    at = numpy_twin.kinematics(model, data.q, data.v)
    total = 0.5 * np.sum(body["mass"][:, None] * at.velocity**2)
    total += 0.5 * np.sum(body["inertia"] * data.v[:, 3:] ** 2)
    total -= model.param["gravity"][0] * np.sum(body["mass"] * at.position[:, 2])
    for j, joint in enumerate(model.joint):
        ends = ((at.position[i], at.axes[i]) for i in (joint["lower"], joint["upper"]))
        total += naive.joint_energy(model, j, *ends, data.damper)
    if model.wheel.size:
        patches = numpy_twin.contact(model, at, data.q, data.v)
        assert (np.count_nonzero(patches.normal, axis=1) <= 1).all()
        cosine = np.where(patches.normal > 0.0, -patches.force[..., 2] / np.maximum(patches.normal, 1.0), 0.0)
        total += 0.4 * np.sum(patches.normal * patches.depth * cosine)
    return total


def reseal(path, title="railcli time series"):
    """Give a sealed file that was changed the head that fits it, as if it had been written so."""
    from railcli.files import seal

    image = path.read_bytes()[seal.HEAD_SIZE :]
    path.write_bytes(seal.head(title, image) + image)
