"""Dry friction, plateaus behind a spring and leaf springs: closed forms, twins, dissipation."""

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import SETTLED
from railcli.analysis.faults import sentence
from railcli.analysis.linear import linear_about, modes
from railcli.kernels.layout import CURVE, ELEMENT, JOINT, Axes, Kind, Status
from railcli.kernels.step import advance, evaluate
from railcli.model.track import constant_track

MASS, SPRING, SERIES, LIMIT = 1000.0, 1e5, 1e7, 2000.0
STEP = 0.5e-3
LEVEL = constant_track(0.0, 0.0)


def element(kind, **values):
    """A record whose ends both lie in the bodies' centres."""
    row = np.zeros(1, ELEMENT)[0]
    row["kind"] = kind
    for key in ("spring_curve", "damper_curve", "stiff", "state", "source", "matrix"):
        row[key] = -1
    for key, value in values.items():
        row[key] = value
    return row


def dry(axes="x", state=0, **values):
    along = [SERIES * (axis in axes) for axis in "xyz"]
    return element(Kind.DRY, **{"k": along, "series": SERIES, "limit": LIMIT, "state": state, **values})


def curve(x, y):
    row = np.zeros(1, CURVE)[0]
    row["count"], row["x"][: len(x)], row["y"][: len(y)] = len(x), x, y
    return row


def block(wagon, elements, curves=(), mass=MASS, step=STEP, axes=Axes.MEAN):
    """A body joined to one so heavy that it stays where it is, in free space on straight track."""
    joint = np.zeros(1, JOINT)
    joint["upper"], joint["count"], joint["axes"] = 1, len(elements), axes
    free = scenes.bodies(wagon, np.array([1e18, mass]), np.full((2, 3), 1e18), np.zeros(2))
    arrays = {"joint": joint, "element": np.array(elements, ELEMENT), "curve": np.array(curves or [], CURVE)}
    return scenes.tuned(scenes.floating(scenes.replaced(free, **arrays), LEVEL), step=step)


def at(system, place, damper=(0.0,), v=(0.0, 0.0, 0.0)):
    """Data with the block at a place against the heavy body."""
    q, rates = np.full((2, 6), 0.0), np.zeros((2, 6))
    q[:, 0] = 5.0
    q[1, :3] += place
    rates[1, :3] = v
    return scenes.data_at(system.model, q, rates, damper)


def led(system, data, path, half_step=STEP / 2):
    """Forces on the block, led along a path (n, 3) as its elements meet it in the middle of steps."""
    forces = []
    for place in path:
        data.q[1, :3] = [5.0, 0.0, 0.0] + np.asarray(place)
        assert evaluate(system.model, data, half_step) == 0
        data.damper[:] += 2.0 * half_step * data.damper_rate
        forces.append(data.frame["force"][1].copy())
    return np.array(forces)


def followed(system, data, steps):
    """Places and forces of the block along x after each of so many steps."""
    rows = []
    for _ in range(steps):
        assert advance(system.model, data, 1) == 0
        rows.append((data.q[1, 0] - 5.0, data.frame["force"][1, 0]))
    return np.array(rows).T


def swings(place):
    """Sizes of the turning points of a motion."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(place))) != 0) + 1
    return np.abs(place[turns])


def test_swing_loses_what_friction_takes(wagon):
    """Spring k with Coulomb friction F behind ks: from turn to turn k/2 (A0^2 - A1^2) = F (A0 + A1) - 2 F^2 / ks.

    Between them the end slides by A0 + A1 less the 2 F / ks that the series spring gives as its force turns over.
    """
    system = block(wagon, [element(Kind.BUSHING, k=(SPRING, 0, 0)), dry()])
    data = at(system, (0.25, 0, 0), (0.25,))
    place, _ = followed(system, data, 2000)
    found = swings(place)[:5]
    for before, after in zip(found[:-1], found[1:], strict=True):
        lost = 2.0 * LIMIT * before - SPRING * before**2 - 4.0 * LIMIT**2 / SERIES
        root = (-LIMIT + np.sqrt(LIMIT**2 - SPRING * lost)) / SPRING
        assert after == pytest.approx(root, abs=tol.SWING)
    assert np.diff(found) == pytest.approx(-2.0 * LIMIT / SPRING, abs=2.0 * LIMIT / SERIES)


def test_it_stops_and_stays(wagon):
    """At rest with the spring still pulling: no creep, no alternation of the force, once the series spring is calm."""
    system = block(wagon, [element(Kind.BUSHING, k=(SPRING, 0, 0)), dry(c=(2 * 0.05 * np.sqrt(SERIES * MASS), 0, 0))])
    data = at(system, (0.1, 0, 0), (0.1,))
    followed(system, data, round(4.0 / STEP))
    slid = data.damper[0]
    place, force = followed(system, data, round(2.0 / STEP))
    assert abs(SPRING * place[-1]) > 0.05 * LIMIT
    assert data.damper[0] == slid
    assert np.ptp(place) < tol.STUCK and np.abs(np.diff(force, 2)).max() < tol.STUCK_FORCE


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_friction_holds_up_to_its_limit(wagon, share):
    """A constant pull below the limit moves nothing but the series spring; above, what is beyond it accelerates."""
    damped = dry(c=(2 * 0.05 * np.sqrt(SERIES * MASS), 0, 0))
    system = block(wagon, [element(Kind.BUSHING, preload=(share * LIMIT, 0, 0)), damped])
    data = at(system, (share * LIMIT / SERIES, 0, 0))
    scenes.run(system, data, 2.0)
    if share < 1.0:
        assert data.damper[0] == 0.0 and abs(data.q[1, 0] - 5.0 - share * LIMIT / SERIES) < tol.STUCK
    else:
        assert data.v[1, 0] == pytest.approx((share - 1.0) * LIMIT / MASS * 2.0, rel=tol.SLIDING)


def test_loop_of_dry_friction(wagon):
    """Led to and fro by A: the loop over the place encloses 4 F (A - F / ks)."""
    amplitude = 5.0 * LIMIT / SERIES
    system = block(wagon, [dry()])
    turn = amplitude * np.sin(np.linspace(0.0, 4.0 * np.pi, 8001))
    path = np.stack([turn, 0.0 * turn, 0.0 * turn], axis=1)
    force = led(system, at(system, (0, 0, 0)), path)[:, 0]
    area = -np.sum(0.5 * (force[4001:] + force[4000:-1]) * np.diff(turn[4000:]))
    assert area == pytest.approx(4.0 * LIMIT * (amplitude - LIMIT / SERIES), rel=tol.LOOP)


def test_limit_is_a_circle(wagon):
    """Pulled far in any direction of its plane the friction is its limit, straight back."""
    system = block(wagon, [dry("xy")])
    for angle in np.linspace(0.0, 2.0 * np.pi, 13):
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        force = led(system, at(system, (0, 0, 0), (0.0, 0.0)), np.linspace(0.0, 5e-3, 50)[:, None] * way)[-1]
        assert_allclose(force, -LIMIT * way, atol=tol.ROUNDING * LIMIT)


def test_friction_on_a_round_way(wagon):
    """Led round a circle of radius R its end follows as a tractrix, on a circle of R^2 - (F / ks)^2 in the end."""
    radius, reach = 1e-3, LIMIT / SERIES
    system = block(wagon, [dry("yz")])
    angle = np.linspace(0.0, 20.0 * np.pi, 40001)
    path = radius * np.stack([0.0 * angle, np.cos(angle), np.sin(angle)], axis=1)
    data = at(system, path[0], (radius, 0.0))
    force = led(system, data, path)[-1]
    assert np.hypot(*data.damper) == pytest.approx(np.sqrt(radius**2 - reach**2), rel=tol.TRACTRIX)
    assert np.hypot(*force[1:]) == pytest.approx(LIMIT, rel=tol.ROUNDING)
    inwards = -force[1] / LIMIT
    assert inwards == pytest.approx(reach / radius, rel=tol.TRACTRIX)


def test_friction_follows_its_load(wagon):
    """Limit = constant + coefficient times what the bushing carries; a bushing that pulls adds nothing."""
    loaded = element(Kind.BUSHING, k=(0, 0, 1e6))
    rubbing = dry("x", limit=100.0, coefficient=0.4, source=0)
    system = block(wagon, [loaded, rubbing])
    for sunk, limit in ((0.005, 100.0 + 0.4 * 5000.0), (0.0, 100.0), (-0.005, 100.0)):
        path = np.stack([np.linspace(0, 0.01, 30), np.zeros(30), np.full(30, sunk)], axis=1)
        force = led(system, at(system, path[0]), path)[-1, 0]
        assert force == pytest.approx(-limit, rel=tol.ROUNDING)


@pytest.mark.parametrize("axes", list(Axes), ids=lambda axes: axes.name)
@pytest.mark.parametrize("kind", ["plane", "space", "link"])
def test_twin_of_friction(wagon, axes, kind):
    """Along a random way, by the least of elastic energy and what sliding costs, found by an optimiser."""
    rng = np.random.default_rng(3)
    path = np.cumsum(rng.uniform(-2e-4, 2e-4, (60, 3)), axis=0)
    if kind == "link":
        path[:, 0] += 0.5
        rubbing, start = element(Kind.DRY_LINK, series=SERIES, limit=LIMIT, state=0, length=0.5), np.array([0.5])
    else:
        names = {"plane": "xz", "space": "xyz"}[kind]
        rubbing, start = dry(names), np.zeros(len(names))
        kept = ["xyz".index(name) for name in names]
    system = block(wagon, [rubbing], axes=axes)
    found = led(system, at(system, path[0], start), path)
    ends = np.linalg.norm(path, axis=1)[:, None] if kind == "link" else path[:, kept]
    twin = naive.friction(ends, start, SERIES, LIMIT)
    if kind == "link":
        assert_allclose(found, -twin * path / ends, atol=tol.OPTIMISED * LIMIT)
    else:
        assert_allclose(found[:, kept], -twin, atol=tol.OPTIMISED * LIMIT)


PLATEAU = ([-1.0, -1e-3, 0.0, 1e-3, 1.0], [-6000.0, -6000.0, 0.0, 6000.0, 6000.0])


def plateau_link(**values):
    return element(Kind.LINK, series=SERIES, damper_curve=0, dry=1, state=0, length=1.0, **values)


def test_plateau_behind_a_spring(wagon):
    """Extended beyond the plateau's beginning the tension is the plateau at once; then held, it relaxes by c / ks."""
    system = block(wagon, [plateau_link()], [curve(*PLATEAU)])
    speed = 0.05
    path = np.zeros((200, 3))
    path[:, 0] = 1.0 + speed * STEP * np.arange(1, 201)
    data = at(system, (1.0, 0, 0), (1.0,))
    force = led(system, data, path)[:, 0]
    assert_allclose(force[100:], -6000.0, rtol=tol.ROUNDING)
    held = led(system, data, path[-1:].repeat(200, axis=0))[:, 0]
    fade = (1.0 + STEP * SERIES / 6e6) ** -np.arange(1.0, 200.0)
    assert_allclose(held[1:] / held[0], fade, rtol=tol.TWIN)


@pytest.mark.parametrize("step", [0.1e-3, 1e-3])
def test_twin_of_plateau(wagon, step):
    """Any way, any slopes: the tension is that of the rate which closes the gap, by a root finder."""
    rng = np.random.default_rng(5)
    x, y = [-0.2, -0.01, 0.0, 0.02, 0.1, 0.5], [-4000.0, -3000.0, 0.0, 5000.0, 5000.0, 9000.0]
    path = np.zeros((80, 3))
    path[:, 0] = 1.0 + np.cumsum(rng.uniform(-1, 1, 80)) * 0.1 * step
    system = block(wagon, [plateau_link()], [curve(x, y)], step=step)
    found = led(system, at(system, (1.0, 0, 0), (1.0,)), path, step / 2)[:, 0]
    assert_allclose(found, -naive.series_tension(path[:, 0], 1.0, SERIES, x, y, step), atol=tol.TWIN * 9000.0)


def test_plateau_is_the_friction_it_stands_for(wagon):
    """A table that rises over 0.01 mm/s and stays level brakes a mass as dry friction does."""
    table = curve([-1.0, -1e-5, 0.0, 1e-5, 1.0], [-LIMIT, -LIMIT, 0.0, LIMIT, LIMIT])
    spring = element(Kind.BUSHING, k=(SPRING, 0, 0))
    behind = {"lower": (-1.0, 0.0, 0.0)}
    plateau = block(wagon, [spring, plateau_link(**behind)], [table])
    friction = block(wagon, [spring, element(Kind.DRY_LINK, series=SERIES, limit=LIMIT, state=0, **behind)])
    ways = [followed(system, at(system, (0.1, 0, 0), (1.1,)), 1500)[0] for system in (plateau, friction)]
    assert_allclose(ways[0], ways[1], atol=tol.NEARLY_DRY)


BAND, LEAF_STIFFNESS, DECAY = 3000.0, 2e5, 2e-3
LEAF_LINES = [curve([-1.0, 1.0], LEAF_STIFFNESS * np.array([-1, 1]) + sign * BAND) for sign in (1, -1)]


def leaf(**values):
    return element(Kind.LEAF, spring_curve=(0, 1, -1), decay=DECAY, **{"state": 0, **values})


def test_loop_of_a_leaf_spring(wagon):
    """Between lines F = k d +- B the loop of amplitude A encloses 4 B' (A - b tanh(A / b)), B' = B - b k, b the decay.

    The force lags behind its envelope by b k, the rest fades as exp(-way / b) from turn to turn.
    """
    amplitude = 3e-3
    system = block(wagon, [leaf()], LEAF_LINES)
    for samples in (400, 4000):  # the answer does not depend on how finely the way is cut
        turn = np.concatenate([np.linspace(-1, 1, samples), np.linspace(1, -1, samples)[1:]] * 4) * amplitude
        path = np.stack([0.0 * turn, 0.0 * turn, turn], axis=1)
        force = led(system, at(system, path[0], (turn[0], 0.0)), path)[:, 2]
        n = 2 * samples - 1
        one, way = force[-n:], turn[-n:]
        area = -np.sum(0.5 * (one[1:] + one[:-1]) * np.diff(way))
        width = BAND - DECAY * LEAF_STIFFNESS
        expected = 4.0 * width * (amplitude - DECAY * np.tanh(amplitude / DECAY))
        assert area == pytest.approx(expected, rel=tol.LEAF_LOOP * (400 / samples) ** 2)
        top = LEAF_STIFFNESS * amplitude + width * np.tanh(amplitude / DECAY)
        assert np.abs(one).max() == pytest.approx(top, rel=tol.LEAF_FADED)


def test_twin_of_a_leaf_spring(wagon):
    """Along a random way between tables, by an integrator of dF/d|d| = (envelope - F) / decay."""
    rng = np.random.default_rng(7)
    upper, lower = ([-0.1, 0.0, 0.02, 0.1], [-6e3, 2e3, 9e3, 49e3]), ([-0.1, 0.0, 0.02, 0.1], [-12e3, -2e3, 1e3, 29e3])
    way = np.cumsum(rng.uniform(-3e-3, 3e-3, 60))
    system = block(wagon, [leaf()], [curve(*upper), curve(*lower)])
    path = np.stack([0.0 * way, 0.0 * way, way], axis=1)
    found = led(system, at(system, path[0], (0.0, 0.0)), path)[:, 2]
    assert_allclose(found, -naive.leaf_spring(way, upper, lower, DECAY), atol=tol.LEAF_TWIN * 9e3)


def test_settled_elements_carry_no_friction(wagon):
    """For equilibria: dry friction nothing, a leaf spring the middle of its envelopes; the states are told."""
    system = block(wagon, [dry("xz"), leaf(state=2)], LEAF_LINES)
    data = at(system, (0.01, 0.0, 0.02), (0.0, 0.0, 0.0, 500.0))
    assert evaluate(system.model, data, SETTLED) == 0
    assert_allclose(data.frame["force"][1], [0.0, 0.0, -LEAF_STIFFNESS * 0.02], rtol=tol.ROUNDING)
    settled = data.damper + SETTLED * data.damper_rate
    assert_allclose(settled, [0.01, 0.02, 0.02, LEAF_STIFFNESS * 0.02], rtol=tol.ROUNDING)


def test_modes_know_friction_as_its_series_spring(wagon):
    """Small motion slides nothing: stiffness of spring and series spring together, no state that only stands."""
    system = block(wagon, [element(Kind.BUSHING, k=(SPRING, SPRING, SPRING)), dry("xyz"), leaf(state=3)], LEAF_LINES)
    data = at(system, (0.0, 0.0, 0.0), np.zeros(5))
    linear = linear_about(system, data, 0.0)
    found = modes(linear)
    assert linear.kept.max() < 24
    side = np.sqrt((SPRING + SERIES) / MASS)
    up = np.sqrt((SPRING + SERIES + BAND / DECAY) / MASS)
    rates = np.sort(np.unique(np.round(found.value.imag, 6)))
    assert np.abs(rates - side).min() < tol.STUCK_MODE * side and np.abs(rates - up).min() < tol.STUCK_MODE * up


def test_free_assembly_never_gains_energy(wagon):
    """Two bodies on springs with every dry element thrown against each other: motion, springs and what friction holds.

    From sample to sample the sum never rises; a leaf spring counts with the energy that can be had back from it.
    """
    rng = np.random.default_rng(9)
    damped = (2 * 0.05 * np.sqrt(SERIES * 500.0), 0, 0)
    ends = {"lower": (0.1, -0.3, 0.2), "upper": (0.1, -0.3, 0.2)}
    elements = [
        element(Kind.BUSHING, k=(3e5, 2e5, 4e5), preload=(0, 0, -8000.0)),
        dry("xy", 0, c=damped, coefficient=0.3, source=0, **ends),
        element(Kind.DRY_LINK, series=SERIES, limit=1500.0, state=2, c=damped, lower=(0.3, 0, 0), upper=(-0.3, 0.2, 0)),
        leaf(state=3, lower=(-0.2, 0.2, 0), upper=(-0.2, 0.2, 0)),
        plateau_link(lower=(0, 0.5, 0), upper=(0.4, 0.1, 0.1)),
    ]
    elements[4]["state"], elements[4]["damper_curve"] = 5, 2
    joint = np.zeros(1, JOINT)
    joint["upper"], joint["count"], joint["turn"] = 1, len(elements), (4e4, 4e4, 4e4)
    free = scenes.bodies(wagon, np.full(2, MASS), np.full((2, 3), 200.0), np.zeros(2))
    curves = np.array([*LEAF_LINES, curve(*PLATEAU)], CURVE)
    system = scenes.replaced(free, joint=joint, element=np.array(elements, ELEMENT), curve=curves)
    system = scenes.tuned(scenes.floating(system, LEVEL), step=0.05e-3)
    for _ in range(3):
        q, v = np.zeros((2, 6)), rng.uniform(-0.5, 0.5, (2, 6))
        q[:, 0] = 5.0
        q[1, 2] = -8000.0 / 4e5
        length = np.linalg.norm([-0.6, 0.2, -0.02]), np.linalg.norm([0.4, -0.4, 0.08])
        data = scenes.data_at(system.model, q, v, (0.0, 0.0, length[0], -0.02, -0.02 * LEAF_STIFFNESS, length[1]))
        found = [naive.dry_energy(system, data)]
        for _ in range(200):
            scenes.run(system, data, 2e-3)
            assert evaluate(system.model, data, 0.0) == 0
            found.append(naive.dry_energy(system, data))
        found = np.array(found)
        assert np.diff(found).max() < tol.DRY_ENERGY * np.ptp(found) and np.ptp(found) > 50.0


def test_unknown_kind_is_told(wagon):
    system = block(wagon, [element(99)])
    data = scenes.new_data(system.model, np.full((2, 6), 0.0), 0)
    assert advance(system.model, data, 1) == Status.UNKNOWN_ELEMENT
    assert "force element 1 is of kind 99, which the core does not know" in sentence(system, data, 7)
