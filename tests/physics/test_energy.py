"""Energy of suspended bodies: kept without dampers, only lost with them."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import static
from railcli.model.sections import Gradient, Straight
from railcli.model.track import Track, constant_track, pack


def undamped(system):
    """The same system without any damper, those with series stiffness taken out with their springs."""
    element = system.model.element.copy()
    element["c"], element["damper_curve"], element["series"], element["state"] = 0.0, -1, 0.0, -1
    return scenes.tuned(scenes.replaced(system, element=element), damping=0.0)


def weightless(wagon, track, step):
    """The wagon without rails, weight and the preloads that carry it."""
    system = scenes.edited(scenes.floating(wagon, track), "element", preload=0.0)
    return scenes.tuned(system, step=step)


def swinging(system, seed=1):
    """All bodies of the wagon thrown against each other, short of the bump stops."""
    rng = np.random.default_rng(seed)
    v = rng.uniform(-0.1, 0.1, (7, 6))
    v[:, 0] += 20.0
    return scenes.data_at(system.model, system.rest + [12.0, 0, 0, 0, 0, 0], v, system.damper)


def course(system, data, seconds, samples):
    """Energy at equal intervals."""
    found = [scenes.energy(system, data)]
    for _ in range(samples):
        scenes.run(system, data, seconds / samples)
        found.append(scenes.energy(system, data))
    return np.array(found)


def stored(course, system, data):
    """Energy less that of the common motion, which nothing can change: what springs and motion exchange."""
    mass = system.model.body["mass"]
    mean = np.sum(mass[:, None] * data.frame["velocity"], axis=0) / mass.sum()
    return course[0] - 0.5 * mass.sum() * mean @ mean


def test_springs_keep_energy(wagon):
    """In free space while the track curves away: the error swings, does not grow, and falls as the step squared."""
    errors = []
    for step in (0.5e-3, 0.25e-3):
        system = undamped(weightless(wagon, scenes.SMOOTH, step))
        data = swinging(system)
        found = course(system, data, 2.0, 200)
        error = (found - found[0]) / stored(found, system, swinging(system))
        errors.append(error.std())
        assert np.abs(error).max() < tol.SPRING_ENERGY
        assert abs(error[100:].mean() - error[:100].mean()) < error.std()
    assert_allclose(errors[0] / errors[1], 4.0, rtol=tol.ENERGY_ORDER)


def test_dampers_only_lose_energy(wagon):
    """The same with every damper of the wagon: from sample to sample the energy falls."""
    system = weightless(wagon, scenes.WINDING, 0.25e-3)
    data = swinging(system)
    found = course(system, data, 2.0, 40)
    assert (np.diff(found) < 0.0).all()


def test_bouncing_wagon_keeps_energy(wagon):
    """On frictionless rails, car body and bogies bouncing and pitching: springs, weight and contact exchange energy."""
    level = scenes.pack(constant_track(0.0, 0.0))
    rolling = scenes.edited(scenes.tuned(undamped(wagon), speed=20.0), "wheel", friction=0.0)
    rolling = scenes.replaced(rolling, track=level)
    errors = []
    for step in (0.1e-3, 0.05e-3):
        system = scenes.tuned(rolling, step=step, hold=0.0)
        rest = static(system).data
        v = np.zeros((7, 6))
        v[:, 0] = 20.0
        v[:3, 2] = 0.1, 0.05, -0.05
        v[:3, 4] = 0.01, 0.05, 0.05
        data = scenes.data_at(system.model, rest.q, v)
        found = course(system, data, 0.3, 100)
        scale = 0.5 * np.sum(system.model.body["mass"] * v[:, 2] ** 2)
        errors.append((found - found[0]).std() / scale)
    assert errors[0] < tol.BOUNCE_ENERGY
    assert_allclose(errors[0] / errors[1], 4.0, rtol=tol.ENERGY_ORDER)


def test_coasting_wagon_trades_height_for_speed(wagon):
    """Let go on frictionless rails, down into a valley: weight, motion, springs and contacts exchange energy."""
    gradients = Gradient(at=0.0, gradient=-0.03), Gradient(at=25.0, gradient=0.02, radius=800.0)
    track = pack(Track((Straight(length=50.0),)), gradients=gradients)
    free = scenes.edited(scenes.tuned(undamped(wagon), speed=10.0, hold=0.0), "wheel", friction=0.0)
    system = scenes.replaced(scenes.tuned(free, step=0.1e-3), track=track)
    v = np.zeros((7, 6))
    v[:, 0] = 10.0
    data = scenes.data_at(system.model, static(system).data.q, v)
    mass, high = system.model.body["mass"], data.frame["position"][:, 2].copy()
    found = course(system, data, 2.0, 40)
    work = 9.81 * mass @ (data.frame["position"][:, 2] - high)
    gained = 0.5 * mass @ (data.v[:, 0] ** 2 - 100.0)
    assert data.v[0, 0] > 10.3 and gained == pytest.approx(work, rel=tol.COASTING)
    assert np.abs(found - found[0]).max() < tol.COASTING_ENERGY * work
