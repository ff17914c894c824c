"""Dampers and dry friction that act implicitly in their rate: the rule that the step promises, and closed forms."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from pairs import element, pair, somewhere

from railcli.kernels.layout import Axes, Kind, new_data
from railcli.kernels.step import THETA, advance, evaluate
from railcli.model.stiff import mark_stiff
from railcli.model.vehicle import PackedVehicle

AXES = pytest.mark.parametrize("axes", list(Axes), ids=lambda axes: axes.name)


def marked(system, step):
    """The system with a step for which its stiff dampers have been marked."""
    model = system.model
    rest = np.zeros((model.body.size, 6))
    packed = PackedVehicle(model.body, model.joint, model.element, model.curve, model.wheel, rest, None, model.matrix)
    return scenes.tuned(scenes.replaced(system, element=mark_stiff(packed, step)), step=step)


def stiff_elements(rng):
    return [
        element(Kind.BUSHING, rng, k=(1e4, 2e4, 3e4), c=(3e4, 1e5, 2e6)),
        element(Kind.BUSHING, rng, damper_curve=(1, -1, 0), c=(0, 4e4, 0), dampers=1),
        element(Kind.LINK, rng, c=(5e6, 0, 0), length=0.5),
        element(Kind.LINK, rng, damper_curve=(1, -1, -1), length=0.5),
        element(Kind.TORQUE, rng, lower=(0.36, 0.48, 0.8), c=(1e5, 0, 0)),
        element(Kind.TORQUE, rng, lower=(0.6, 0.0, -0.8), damper_curve=(1, -1, -1)),
    ]


@AXES
@pytest.mark.parametrize("which", [*range(6), "together"])
def test_one_step_meets_its_rule(wagon, axes, which):
    """dv of a step is what explicit elements give at its middle place and at v0 + h (theta dv - (theta - 1/2) dv last).

    Unit inertias about all axes, so that nothing but the elements depends on velocity.
    """
    rng = np.random.default_rng(5)
    step = 1e-3
    for _ in range(3):
        elements = stiff_elements(rng)
        elements = [elements[k] for k in ((0, 2, 5) if which == "together" else (which,))]
        for row in elements:
            row["c"] *= 0.02 if which == "together" else 1.0
        system = marked(pair(wagon, axes, elements), step)
        assert np.count_nonzero(system.model.element["stiff"] >= 0) >= 1
        explicit = scenes.edited(system, "element", stiff=-1)
        q, v, last = somewhere(rng), rng.uniform(-0.5, 0.5, (2, 6)), rng.uniform(-5, 5, (2, 6))
        data = new_data(system.model, q, 0)
        data.tension[:] = rng.uniform(-1e3, 1e3, data.tension.size)
        rate = new_data(system.model, q, 0)
        rate.v[:] = v
        assert evaluate(explicit.model, rate, 0.0) == 0
        data.v[:], data.dv[:] = v, last
        assert advance(system.model, data, 1) == 0
        middle = new_data(system.model, q + 0.5 * step * rate.rate, 0)
        middle.v[:] = v + step * (THETA * data.dv - (THETA - 0.5) * last)
        assert evaluate(explicit.model, middle, 0.0) == 0
        assert_allclose(data.dv, middle.dv, atol=tol.IMPLICIT * np.abs(data.tension).max())


def on_a_line(wagon, row, step, mass=(2.0, 5.0), inertia=(0.3, 0.7), ahead=0.0):
    """Two bodies joined at their centres by one element; masses along, inertias about y."""
    system = pair(wagon, 0, [row])
    ends = {"upper": (ahead, 0, 0)} if row["kind"] == Kind.TORQUE else {"upper": (ahead, 0, 0), "lower": 0.0}
    system = scenes.edited(system, "element", **ends)
    body = system.model.body.copy()
    body["mass"], body["inertia"] = mass, np.array(inertia)[:, None]
    return marked(scenes.replaced(system, body=body), step)


def moving(system, v, place=5.0):
    data = new_data(system.model, np.array([[place, 0, 0, 0, 0, 0]] * 2), 0)
    data.v[:] = v
    assert evaluate(system.model, data, 0.0) == 0
    return data


@pytest.mark.parametrize("step", [0.1e-3, 1e-3, 10e-3])
@pytest.mark.parametrize("damping", [1e5, 1e8, 1e12])
def test_a_damper_of_any_stiffness_joins_two_bodies(wagon, damping, step):
    """h c / m up to 1e10: both bodies move on with their common velocity, which momentum decides."""
    system = on_a_line(wagon, element(Kind.BUSHING, np.random.default_rng(0), c=(damping, 0, 0)), step)
    data = moving(system, [[0.3, 0, 0, 0, 0, 0], [-0.1, 0, 0, 0, 0, 0]])
    data.dv[:] = 0.0
    differences = []
    for _ in range(40):
        assert advance(system.model, data, 1) == 0
        differences.append(data.v[1, 0] - data.v[0, 0])
    common = (2.0 * 0.3 - 5.0 * 0.1) / 7.0
    assert_allclose(data.v[:, 0], common, atol=1e-9)
    assert np.abs(differences[20:]).max() < 1e-6


def test_a_moderate_damper_decays_exponentially(wagon):
    """Second order in the step: velocity difference against exp(-c t / m)."""
    row = element(Kind.BUSHING, np.random.default_rng(0), c=(400.0, 0, 0))
    reduced = 2.0 * 5.0 / 7.0
    errors = []
    for step in (2e-3, 1e-3):
        system = on_a_line(wagon, row, step)
        assert system.model.element["stiff"][0, 0] == 0
        data = moving(system, [[0.3, 0, 0, 0, 0, 0], [-0.1, 0, 0, 0, 0, 0]])
        scenes.run(system, data, 0.01)
        errors.append(data.v[1, 0] - data.v[0, 0] + 0.4 * np.exp(-400.0 * 0.01 / reduced))
    assert abs(errors[0]) < 0.02 and errors[0] / errors[1] == pytest.approx(4.0, rel=0.35)


@pytest.mark.parametrize("step", [0.1e-3, 0.5e-3, 2e-3])
def test_dry_friction_stops_and_holds(wagon, step):
    """A torque F of dry friction: relative spin falls by F t / I, is zero at once, and stays so under less than F."""
    row = element(Kind.TORQUE, np.random.default_rng(0), lower=(0.0, 1.0, 0.0), limit=6.0)
    system = on_a_line(wagon, row, step)
    reduced = 0.3 * 0.7 / 1.0
    stop = 2.0 * reduced / 6.0
    data = moving(system, [[0.0, 0, 0, 0, 1.2, 0], [0.0, 0, 0, 0, -0.8, 0]])
    scenes.run(system, data, 0.04)
    assert data.v[0, 4] - data.v[1, 4] == pytest.approx(2.0 - 6.0 / reduced * 0.04, abs=1e-9)
    scenes.run(system, data, 0.1)
    assert stop < 0.14 and abs(data.v[0, 4] - data.v[1, 4]) < 1e-12
    pushed = element(Kind.TORQUE, np.random.default_rng(0), lower=(0.0, 1.0, 0.0), limit=6.0, preload=(5.9, 0, 0))
    system = on_a_line(wagon, pushed, step)
    data = moving(system, np.zeros((2, 6)))
    scenes.run(system, data, 1.0)
    assert np.abs(data.q[:, 4]).max() < 1e-12 + 10 * step**2 * 5.9 / 0.3
    before = data.q[:, 4].copy()
    scenes.run(system, data, 5.0)
    assert_allclose(data.q[:, 4], before, atol=1e-12)


def test_friction_gives_way_at_its_limit(wagon):
    """A constant torque P beyond F: the bodies turn apart with (P - F) / I."""
    row = element(Kind.TORQUE, np.random.default_rng(0), lower=(0.0, 1.0, 0.0), limit=6.0, preload=(8.0, 0, 0))
    system = on_a_line(wagon, row, 1e-3)
    data = moving(system, np.zeros((2, 6)))
    scenes.run(system, data, 0.2)
    assert data.v[1, 4] == pytest.approx(2.0 / 0.7 * 0.2, rel=0.02)
    assert data.v[0, 4] == pytest.approx(-2.0 / 0.3 * 0.2, rel=0.02)


def test_a_plateau_slides_like_dry_friction(wagon):
    """A damper table of 9 N from 1 um/s on, beyond any explicit step: constant deceleration, then rest."""
    row = element(Kind.LINK, np.random.default_rng(0), damper_curve=(0, -1, -1))
    system = on_a_line(wagon, row, 1e-3, ahead=1.0)
    curve = system.model.curve.copy()
    curve[0]["count"], curve[0]["x"][:4], curve[0]["y"][:4] = 4, (-1, -1e-6, 1e-6, 1), (-9, -9, 9, 9.0)
    system = marked(scenes.replaced(system, curve=curve), 1e-3)
    data = moving(system, [[0.0, 0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0, 0]])
    scenes.run(system, data, 0.05)
    reduced = 2.0 * 5.0 / 7.0
    assert data.v[1, 0] - data.v[0, 0] == pytest.approx(0.5 - 9.0 / reduced * 0.05, abs=1e-6)
    scenes.run(system, data, 0.1)
    assert abs(data.v[1, 0] - data.v[0, 0]) < 1e-9


def test_energy_only_falls_whatever_the_dampers(wagon):
    """A network of stiff dampers of all kinds: kinetic energy of free bodies falls from step to step."""
    rng = np.random.default_rng(3)
    for axes in (0, 1):
        rows = [row for row in stiff_elements(rng)]
        for row in rows:
            row["k"] = 0.0
        system = marked(pair(wagon, axes, rows), 0.5e-3)
        data = new_data(system.model, somewhere(rng), 0)
        data.v[:] = rng.uniform(-1, 1, (2, 6))
        assert evaluate(system.model, data, 0.0) == 0
        data.dv[:] = 0.0
        energy = []
        for _ in range(200):
            assert advance(system.model, data, 1) == 0
            energy.append(0.5 * np.sum(data.v**2))
        assert (np.diff(energy[2:]) < 1e-9).all()


@pytest.mark.parametrize("step", [0.2e-3, 1e-3])
def test_a_brake_stops_a_spinning_wheelset_and_holds_it(wagon, step):
    """Its spin falls by F t / I against a heavy frame, then the wheelset does not turn at all."""
    row = element(Kind.TORQUE, np.random.default_rng(0), lower=(0.0, 1.0, 0.0), limit=50.0)
    system = scenes.edited(pair(wagon, Axes.UPPER, [row], spins=(1, 0)), "body", inertia=[[3.0] * 3, [1e9] * 3])
    system = marked(system, step)
    data = moving(system, [[0, 0, 0, 0, -40.0, 0], [0.0] * 6])
    scenes.run(system, data, 1.2)
    assert data.v[0, 4] == pytest.approx(-40.0 + 50.0 / 3.0 * 1.2, abs=1e-6)
    scenes.run(system, data, 1.4)
    angle = data.q[0, 4]
    scenes.run(system, data, 2.0)
    assert abs(data.v[0, 4] - data.v[1, 4]) < 1e-12
    assert data.q[0, 4] - angle == pytest.approx(2.0 * data.v[1, 4], abs=1e-9)  # an angle of 34 rad over 1e4 steps
