"""The linear vertical model against closed forms, and the compiled model against it over small disturbances."""

from dataclasses import replace

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis import disturbance
from railcli.analysis.vertical_model import Contact, vertical_model
from railcli.files.benchmark import manchester_criteria
from railcli.files.scenario import load, load_vehicle
from railcli.model.elements import Joint
from railcli.model.track_support import TrackSupport
from railcli.model.vehicle import Body, Vehicle

CONTACT = Contact(force=5e4, depth=8e-5, cosine=1.0, creep=8e6, damping=0.0)
GRAVITY = 9.81


def test_lone_wheelset():
    """Mass on two contact springs: dQ = -k_c m w^2 / (2 k_c - m w^2) per wheel and height; acceleration -2 dQ / m."""
    mass, speed = 1813.0, 40.0
    body = Body(name="w", mass=mass, inertia=(1120.0, 112.0, 1120.0), x=0.0, wheel_radius=0.46)
    model = vertical_model(Vehicle(name="w", bodies=(body,)), [CONTACT], speed, 0.0, GRAVITY)
    f = np.array([1.0, 10.0, 50.0, 100.0])
    inertia, k = mass * (2 * np.pi * f) ** 2, CONTACT.stiffness
    force, acceleration = model.transfer(f).T
    assert_allclose(force, k * inertia / (2 * k - inertia), rtol=tol.CLOSED_RESPONSE)
    assert_allclose(acceleration, -2.0 * force / mass, rtol=tol.CLOSED_RESPONSE)


@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_lone_wheelset_on_rails_that_give_way(damping):
    """The contact and the rail's spring and damper in series under half the mass, by hand."""
    mass, speed, rail = 1813.0, 40.0, (5e7, 7e4)
    body = Body(name="w", mass=mass, inertia=(1120.0, 112.0, 1120.0), x=0.0, wheel_radius=0.46)
    contact = replace(CONTACT, damping=damping, rail=rail)
    model = vertical_model(Vehicle(name="w", bodies=(body,)), [contact], speed, 0.0, GRAVITY)
    for f in (1.0, 20.0, 50.0, 100.0, 400.0):
        jw = 2j * np.pi * f
        series = 1.0 / (1.0 / (contact.stiffness + jw * contact.resistance) + 1.0 / (rail[0] + jw * rail[1]))
        sunk = 2.0 * series / (2.0 * series + mass * jw**2)  # of the wheelset per height of the rails
        force, acceleration = model.transfer(f)[0]
        assert force == pytest.approx(series * (sunk - 1.0), rel=tol.CLOSED_RESPONSE)
        assert acceleration == pytest.approx(jw**2 * sunk, rel=tol.CLOSED_RESPONSE)


def quarter():
    """A wheelset below one sprung mass: spring and a damper with series stiffness."""
    bodies = (
        Body(name="top", mass=8000.0, inertia=(1e4, 1e4, 1e4), x=0.0, height=1.0),
        Body(name="w", mass=1800.0, inertia=(1000.0, 100.0, 1000.0), x=0.0, wheel_radius=0.46),
    )
    joint = Joint.model_validate(
        {
            "name": "spring",
            "pairs": [["w", "top"]],
            "axes": "upper",
            "bushing": [
                {
                    "name": "spring", "at_m": [0.0, 1.0, 0.46], "mirror": "y",
                    "stiffness_N_per_m": [1e7, 1e6, 8e5], "carries_weight": True,
                }
            ],
            "link": [
                {
                    "name": "damper", "lower_m": [0.0, 1.0, 0.46], "upper_m": [0.0, 1.0, 0.9], "mirror": "y",
                    "damping_Ns_per_m": 2e4, "series_stiffness_N_per_m": 3e6,
                }
            ],
        }
    )  # fmt: skip
    return Vehicle(name="quarter", bodies=bodies, joints=(joint,))


def test_two_masses():
    """Dynamic stiffness of spring and Maxwell element between two masses on the contact, by hand."""
    model = vertical_model(quarter(), [CONTACT], 30.0, 0.0, GRAVITY)
    for f in (0.7, 2.0, 8.0, 60.0):
        jw = 2j * np.pi * f
        spring = 2.0 * (8e5 + 1.0 / (1.0 / 3e6 + 1.0 / (2e4 * jw)))
        contact = 2.0 * CONTACT.stiffness
        matrix = np.array([[8000.0 * jw**2 + spring, -spring], [-spring, 1800.0 * jw**2 + spring + contact]])
        top, wheel = np.linalg.solve(matrix, [0.0, contact])
        force, *acceleration = model.transfer(f)[0]
        assert force == pytest.approx(CONTACT.stiffness * (wheel - 1.0), rel=tol.CLOSED_RESPONSE)
        assert_allclose(acceleration, [top * jw**2, wheel * jw**2], rtol=tol.CLOSED_RESPONSE)


def test_long_waves():
    """All bodies follow a long wave, each at its own place: forces are those of their inertia."""
    vehicle = load_vehicle("manchester")
    model = vertical_model(vehicle, [CONTACT] * 4, 40.0, 1e6, GRAVITY)
    f = 0.02
    force, acceleration = np.split(model.transfer(f)[0], [4])
    place = np.array([body.x for body in vehicle.bodies])
    wave = -((2 * np.pi * f) ** 2) * np.exp(2j * np.pi * f * place / 40.0)
    assert_allclose(acceleration, wave, rtol=tol.VERTICAL_WAVE)
    mass = np.array([body.mass for body in vehicle.bodies])
    assert -2.0 * force.sum() == pytest.approx(mass @ acceleration, rel=tol.CLOSED_RESPONSE)


def test_time_and_frequency_agree():
    """The response in time to a long row of waves is the transfer function's."""
    damped = replace(CONTACT, damping=2.0)
    model = vertical_model(load_vehicle("manchester"), [damped] * 4, 40.0, 1e6, GRAVITY)
    time = np.arange(0.0, 10.0, 0.25e-3)
    number = 2 * np.pi * 4.0 / 40.0  # [rad/m], at 4 Hz
    found = model.response(time, lambda s: (np.sin(number * s), number * np.cos(number * s)))
    late = time > 9.0
    wanted = np.imag(model.transfer(4.0)[0][None, :] * np.exp(2j * np.pi * 4.0 * time[late])[:, None])
    size = np.abs(wanted).max(axis=0)
    assert_allclose(found[late] / size, wanted / size, atol=tol.SAMPLED_RESPONSE)


@pytest.fixture(scope="module")
def case(wagon):
    return load("straight-60")


def test_small_bumps(case, table):
    """Compiled and linear model over a bump: within 1 % once the step is halved, by second order in the step."""
    criteria = manchester_criteria()["disturbance"]
    errors = []
    for step in disturbance.STEPS:
        plain = disturbance.traced(disturbance.straight(case, 160.0, step), [table])
        bump = disturbance.small_bump(case, [table], plain, 0.4, step)
        assert 0.02 < bump.share < 0.06
        errors.append(bump.force_error)
    assert 100.0 * errors[1] < criteria["force_percent"]
    assert 100.0 * bump.acceleration_error < criteria["acceleration_percent"]
    assert errors[0] / errors[1] > 3.0


def test_small_bump_on_rails_that_give_way(case, table):
    """Compiled model against the linear one whose rails give way."""
    criteria = manchester_criteria()["disturbance"]
    soft = case.varied(track_support=TrackSupport(kind="ballasted-soft"), contact={"damping": 0.2})
    step = disturbance.STEPS[1]
    plain = disturbance.traced(disturbance.straight(soft, 160.0, step), [table])
    bump = disturbance.small_bump(soft, [table], plain, 0.4, step)
    assert 0.001 < bump.share < 0.06
    assert 100.0 * bump.force_error < criteria["force_percent"]
    assert 100.0 * bump.acceleration_error < criteria["acceleration_percent"]


def test_frequency_response(case, table, monkeypatch):
    """Waves of 1.5 Hz (car body), 7 Hz (bogies) and 85 Hz (contact)."""
    monkeypatch.setattr(disturbance, "FREQUENCIES", (1.5, 7.0, 85.0))
    found = disturbance.waves(case, [table], disturbance.STEPS[1])
    limit = manchester_criteria()["disturbance"]["response_percent"]
    assert 100.0 * found.force_error.max() < limit and 100.0 * found.acceleration_error.max() < limit


def test_what_the_comparison_would_notice(case):
    """A primary spring 5 % too stiff in the linear model would be seen."""
    joint = case.vehicle.joints[0]
    spring = joint.bushings[0]
    stiff = spring.model_copy(update={"stiffness": (*spring.stiffness[:2], 1.05 * spring.stiffness[2])})
    joints = (joint.model_copy(update={"bushings": (stiff,)}), *case.vehicle.joints[1:])
    other = case.vehicle.model_copy(update={"joints": joints})
    right = vertical_model(case.vehicle, [CONTACT] * 4, 40.0, 1e6, GRAVITY).transfer(5.0)[0, :4]
    wrong = vertical_model(other, [CONTACT] * 4, 40.0, 1e6, GRAVITY).transfer(5.0)[0, :4]
    assert 100.0 * np.abs(wrong / right - 1.0).max() > manchester_criteria()["disturbance"]["response_percent"]


def test_lateral_mirror(case, table):
    """Rails that move left give the mirror image of rails that move right."""
    found = disturbance.lateral(case, [table], "step", 0.5e-3)
    assert found.mirror_error < tol.MIRRORED_RUN
    assert found.trace.lateral[-1, 3:] == pytest.approx(4e-3, abs=tol.FOLLOWED)


def test_wheel_lift(case, table):
    """The linear model pulls at the rail where the wheel lifts off; the wheel does not."""
    plain = disturbance.traced(disturbance.straight(case, 160.0, 0.25e-3), [table])
    bump = disturbance.large_bump(case, [table], plain, 20e-3, 0.25e-3)
    assert bump.linear_force.min() < 0.0 <= bump.force.min() and bump.lifted > 5e-3
