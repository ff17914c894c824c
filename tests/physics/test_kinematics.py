"""Motion of bodies against the absolute pose, and of the whole right-hand side against its NumPy twin."""

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from benchmarks.speed import equality, numpy_twin
from railcli.kernels.layout import Creep
from railcli.kernels.step import advance, evaluate
from railcli.model.track import pack

BASE = 1.5


def random_motion(rng, n):
    """Coordinates and velocities of bodies all along the winding track, far from nominal."""
    q = rng.uniform(-1, 1, (n, 6)) * [0, 2, 2, 1, 1, 1]
    q[:, 0] = np.linspace(1, scenes.WINDING.length - 1, n)
    return q, rng.uniform(-1, 1, (n, 6)) * [60, 5, 5, 3, 3, 3]


@pytest.mark.parametrize(("gradients", "pivot"), [((), "centre"), (scenes.HILLS, "inner")], ids=["level", "hills"])
def test_rates_move_the_body(wagon, gradients, pivot):
    """Coordinates that change at the core's rates carry the centre at v and turn the axes at omega."""
    n, h = 40, 1e-4
    spins = np.arange(n) % 2
    pieces = pack(scenes.WINDING, gradients=gradients, pivot=pivot)
    system = scenes.floating(scenes.bodies(wagon, np.ones(n), np.ones((n, 3)), spins), pieces)
    at = BASE, gradients, pivot
    q, v = random_motion(np.random.default_rng(1), n)
    data = scenes.data_at(system.model, q, v)
    for i in range(n):
        (ahead, turned), (behind, turned_back) = (
            naive.body_pose(scenes.WINDING, q[i] + d * data.rate[i], *at) for d in (h, -h)
        )
        track = naive.track_pose(scenes.WINDING, q[i, 0], *at)[1]
        assert_allclose(track.T @ (ahead - behind) / (2 * h), v[i, :3], atol=tol.RATE)
        spin = (turned - turned_back) / (2 * h) @ naive.body_pose(scenes.WINDING, q[i], *at)[1].T
        omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        own = naive.body_pose(scenes.WINDING, q[i] * [1, 1, 1, 1, 1 - spins[i], 1], *at)[1]
        assert_allclose(own.T @ omega, v[i, 3:], atol=tol.RATE)
        assert_allclose(data.frame[i]["omega"], omega, atol=tol.RATE)
        assert_allclose(data.frame[i]["axes"], own, atol=tol.TRACK_AXES)


@pytest.mark.parametrize("law", equality.LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("half_step, rails", [(0.0, "ideal"), (0.25e-3, "displaced"), (1e9, "ideal")])
@pytest.mark.parametrize("hilly", [False, True], ids=["level", "hills"])
def test_right_hand_side_against_twin(wagon, law, half_step, rails, hilly):
    """Track, kinematics, suspension, contact, creep and inertia forces all at once, at random states."""
    rng = np.random.default_rng(3)
    system = scenes.tuned(wagon, creep_law=int(law))
    if hilly:
        system = scenes.replaced(system, track=pack(scenes.WINDING, gradients=scenes.HILLS, pivot="inner"))
    if rails == "displaced":
        system = scenes.on_rails(system, scenes.waves)
    patches = []
    for place in np.linspace(5.0, 270.0 if hilly else 600.0, 12):
        data = equality.shaken(system, rng, place)
        q, v = data.q.copy(), data.v.copy()
        assert evaluate(system.model, data, half_step) == 0
        twin = numpy_twin.evaluate(system.model, q, v, data.damper, half_step)
        size = np.abs(twin.load).max(axis=0)
        assert_allclose(data.load / size, twin.load / size, atol=tol.TWIN)
        mass = np.column_stack([*[system.model.body["mass"]] * 3, system.model.body["inertia"]])
        assert_allclose(data.dv, data.load / mass)
        assert_allclose(data.rate, twin.bodies.rate, rtol=tol.TWIN, atol=tol.TWIN)
        assert_allclose(data.damper_rate, twin.damper_rate, rtol=tol.TWIN, atol=tol.TWIN)
        assert_allclose(data.contact["normal"], twin.patches.normal, atol=tol.TWIN * twin.patches.normal.max())
        reaction = np.stack([data.rail["x"], data.rail["y"], data.rail["q"]], axis=1)
        assert_allclose(reaction, -twin.patches.force.sum(axis=1), atol=tol.TWIN * np.abs(reaction).max())
        patches.extend(data.rail["patches"])
    assert max(patches) >= 2 and min(patches) == 0


def test_twin_with_tables_and_fallen_powers(wagon):
    """Any exponents of the damping of the normal force; running backwards."""
    system = scenes.tuned(wagon, damping_rate_power=0.7, damping_depth_power=1.1, damping=0.05)
    data = equality.shaken(system, np.random.default_rng(5), 200.0)
    data.v[:, 0] *= -1
    q, v = data.q.copy(), data.v.copy()
    assert evaluate(system.model, data, 0.0) == 0
    twin = numpy_twin.evaluate(system.model, q, v, data.damper)
    size = np.abs(twin.load).max(axis=0)
    assert_allclose(data.load / size, twin.load / size, atol=tol.TWIN)


NEWTON = 6  # steps of Newton's method


def wheel_loads(model, q, v):
    """Loads (n, 6) of wheels and rails on the bodies."""
    bodies = numpy_twin.kinematics(model, q, v)
    patches = numpy_twin.contact(model, bodies, q, v)
    loads, of = np.zeros_like(v), model.wheel["body"]
    np.add.at(loads[:, :3], of, patches.force.sum(axis=1))
    np.add.at(loads[:, 3:], of, numpy_twin.turn_back(bodies.pose[of], patches.moment.sum(axis=1)))
    return loads


def creep_damping(model, q, v):
    """Minus the slopes of the wheels' loads on the bodies (n, 6, 6) over their velocities, by central differences."""
    h = 1e-6
    sides = ([wheel_loads(model, q, v + way * h * e) for way in (-1, 1)] for e in np.eye(6))
    return np.stack([(low - high) / (2 * h) for low, high in sides], axis=2)


def midpoint_step(model, q, v, dv, damper, held, h):
    """One step: wheels and rails at 9/16 of it by Newton's method to its end, all else at the predicted midpoint."""
    half, reach, lag = h / 2, 9 / 16 * h, 1 / 16 * h
    q_mid = q + half * numpy_twin.kinematics(model, q, v).rate
    predicted = v + half * dv
    found = numpy_twin.evaluate(model, q_mid, predicted, damper, half)
    rest = found.load - wheel_loads(model, q_mid, predicted)
    rest[0, 0] += held[0]
    mass = np.column_stack([*[model.body["mass"]] * 3, model.body["inertia"]])
    last, new = dv, dv.copy()
    for _ in range(NEWTON):
        at = np.where(model.body["spins"][:, None], v + reach * new - lag * last, predicted)
        left = rest + wheel_loads(model, q_mid, at) - mass * new
        matrix = mass[:, :, None] * np.eye(6) + reach * creep_damping(model, q_mid, at)
        new = new + np.linalg.solve(matrix, left[..., None])[..., 0]
    rate = numpy_twin.kinematics(model, q_mid, v + half * new).rate
    param = model.param[0]
    held = held + h * param["hold_rate"] * param["hold"] * (param["speed"] - rate[0, 0])
    return q + h * rate, v + h * new, new, damper + h * found.damper_rate, held


def test_steps_against_twin(wagon):
    """Ten whole steps, creep forces solved to the end; without damping of the normal forces."""
    system = scenes.tuned(wagon, creep_law=int(Creep.SMOOTH), damping=0.0, settled=1e-9)
    data = equality.shaken(system, np.random.default_rng(11), 150.0)
    data.v[:, 0] = 45.0
    data = scenes.data_at(system.model, data.q, data.v, data.damper)
    state = data.q.copy(), data.v.copy(), data.dv.copy(), data.damper.copy(), data.held.copy()
    for _ in range(10):
        assert advance(system.model, data, 1) == 0
        state = midpoint_step(system.model, *state, system.model.param["step"][0])
        for mine, twin in zip((data.q, data.v, data.dv, data.damper, data.held), state, strict=True):
            assert_allclose(mine, twin, rtol=tol.STEP_TWIN, atol=tol.STEP_TWIN * np.abs(twin).max())
    assert data.rail["patches"].max() >= 1
