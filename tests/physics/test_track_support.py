"""Rails on springs and dampers: balance, receptance, deflection, energy, and a step that need not be shorter."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import static, steady
from railcli.analysis.linear import linear_about
from railcli.analysis.simulate import settled_start
from railcli.analysis.step_limit import OneStep, StepLimit, stiffest
from railcli.kernels.step import advance, evaluate
from railcli.model.track import constant_track, pack
from railcli.model.track_support import RAIL_BENDING, SEAT_SPACING, SETS, TrackSupport, under_a_wheel

THETA = 9.0 / 16.0
GRAVITY = 9.81
SIDES = [1, 0]


def supported(system, kind="ballasted-soft"):
    """The same system on rails that give way."""
    stiffness, damping = TrackSupport(kind=kind).packed()
    return scenes.tuned(system, rail_stiffness=stiffness, rail_damping=damping)


def lone(table, speed=20.0, kind="ballasted-soft", step=1e-4, load=11e3, **contact):
    """A wheelset as heavy as a loaded axle on rails that give way."""
    return supported(scenes.lone_wheelset(table, speed, step=step, mass=load, **contact), kind)


def rails_of(system):
    param = system.model.param[0]
    return param["rail_stiffness"], param["rail_damping"]


@pytest.mark.parametrize("kind", SETS)
def test_a_wheelset_at_rest_sinks_by_load_over_stiffness(table, kind):
    system = lone(table, kind=kind)
    stiffness, _ = rails_of(system)
    rest, held = static(system).data, static(system.on_rigid_track()).data
    load = 0.5 * system.model.body[0]["mass"] * GRAVITY
    assert_allclose(rest.yielded[:, 1], load / stiffness[1], rtol=tol.RAIL_DEFLECTION)
    assert_allclose(rest.yielded[:, 0], rest.rail["y"] / stiffness[0], rtol=tol.RAIL_DEFLECTION)
    assert rest.q[0, 2] - held.q[0, 2] == pytest.approx(load / stiffness[1], rel=tol.RAILS_SPREAD)


def test_receptance_is_that_of_a_spring_beside_a_damper(table):
    """u / F = 1 / (k + i w c) in both directions, from the linearised model shaken through its wheelset."""
    system = lone(table, creep_law="smooth")
    stiffness, damping = rails_of(system)
    data = steady(system, 0.0, 0.0).data
    linear = linear_about(system, data, system.speed)
    states = {int(k): column for column, k in enumerate(linear.kept)}
    rails = [states[12 + k] for k in range(4)]

    def forces(array, k, step):
        sides = []
        for sign in (1.0, -1.0):
            array.flat[k] += sign * step
            assert evaluate(linear.system.model, data, 0.0) == 0
            sides.append(np.column_stack([data.rail["y"], data.rail["q"]]).ravel())
            array.flat[k] -= sign * step
        return (sides[0] - sides[1]) / (2.0 * step)

    over_rails = np.column_stack([forces(data.yielded, k, 1e-7) for k in range(4)])
    for k in (1, 2, 3):
        over_q, over_v = forces(data.q, k, 1e-7), forces(data.v, k, 1e-5)
        for frequency in (0.5, 5.0, 50.0, 500.0):
            iw = 2j * np.pi * frequency
            shaken = linear.matrix[np.ix_(rails, [states[k]])] + iw * linear.matrix[np.ix_(rails, [states[6 + k]])]
            u = np.linalg.solve(iw * np.eye(4) - linear.matrix[np.ix_(rails, rails)], shaken[:, 0])
            force = over_q + iw * over_v + over_rails @ u
            closed = force / (np.tile(stiffness, 2) + iw * np.tile(damping, 2))
            assert_allclose(u, closed, rtol=0, atol=tol.RECEPTANCE * np.abs(closed).max())


def test_each_step_balances_the_rails(table):
    """k u* + c w is the wheel's force, with u* and w from the rails' places of three steps."""
    system = scenes.on_rails(lone(table, step=0.5e-3), scenes.waves)
    stiffness, damping = rails_of(system)
    data, h = settled_start(system), float(system.model.param[0]["step"])
    assert advance(system.model, data, 200) == 0
    worst, size = 0.0, 0.0
    for _ in range(100):
        place, before = data.yielded.copy(), data.yielding.copy()
        assert advance(system.model, data, 1) == 0
        rate = (data.yielded - place) / h
        at = place + h * (THETA * rate - (THETA - 0.5) * before)
        seat = stiffness * at + damping * rate
        assert_allclose(data.rail["seat"], seat, rtol=tol.RAIL_DEFLECTION, atol=tol.RAIL_FORCE)
        wheel = np.column_stack([data.rail["y"], data.rail["q"]])
        worst, size = max(worst, np.abs(seat - wheel).max()), max(size, np.abs(wheel).max())
    assert worst < tol.RAIL_LAG * size


def test_a_dropped_wheelset_loses_energy_until_it_rests(table):
    """No damping in the contact, no friction: motion, weight, contact and rails together never gain."""
    system = scenes.tuned(lone(table, step=2e-5, friction=0.0), hold=0.0, damping=0.0)
    stiffness, _ = rails_of(system)
    rest = static(system).data
    data = settled_start(system)
    data.q[0, 2] -= 0.5e-3
    body, energy = system.model.body[0], []
    fallen = body["mass"] * GRAVITY * 0.5e-3
    for _ in range(40_000):
        assert advance(system.model, data, 1) == 0
        motion = 0.5 * body["mass"] * data.v[0, 2] ** 2 - body["mass"] * GRAVITY * (data.q[0, 2] - rest.q[0, 2])
        normal, depth, slope = (data.contact[name][:, 0] for name in ("normal", "depth", "slope"))
        pressed = np.where(normal > 0.0, 0.4 * normal * depth / np.sqrt(1.0 + slope**2), 0.0)
        energy.append(motion + pressed.sum() + 0.5 * (stiffness * data.yielded**2).sum())
    energy = np.array(energy)
    assert (energy - np.minimum.accumulate(energy)).max() < tol.RAIL_ENERGY * fallen
    assert energy[0] - energy[-1] > 0.5 * fallen
    assert data.q[0, 2] == pytest.approx(rest.q[0, 2], abs=tol.RAIL_RESTS)


@pytest.mark.parametrize("damping", [5e3, 2e4])
def test_dipped_joint_gives_the_published_peak(table, damping):
    """P2 = P0 + 2 a V sqrt(K M) (1 - pi C / (4 sqrt(K M))), Jenkins et al. (1974), for a track without mass.

    K is that of the rail and the contact in series, M half the wheelset, 2 a the kink at the bottom of the dip.
    """
    kink, speed, reach, joint, spacing = 5e-4, 40.0, 5.0, 25.005, 0.01

    def dip(s):
        value, slope = np.zeros((2, 2, s.size)), np.zeros((2, 2, s.size))
        before, behind = np.clip((s - joint) / reach + 1.0, 0.0, 1.0), np.clip(1.0 - (s - joint) / reach, 0.0, 1.0)
        side = np.where(s < joint, before, behind)
        value[:, 1] = 0.25 * kink * reach * side**2
        slope[:, 1] = 0.5 * kink * np.where(s < joint, before, -behind)
        return value, slope

    system = scenes.tuned(lone(table, speed, step=5e-5), rail_stiffness=(2e7, 5e7), rail_damping=(1e4, damping))
    system = scenes.on_rails(scenes.tuned(system, damping=0.0), dip, spacing, (-45.0, 60.0))
    rest = static(system).data
    patch, mass = rest.contact[0, 0], 0.5 * system.model.body[0]["mass"]
    stiffness = 1.0 / (1.0 / 5e7 + patch["depth"] / (1.5 * rest.rail["q"][0]))
    data, peak = settled_start(system), 0.0
    while data.q[0, 0] < joint + 1.0:
        assert advance(system.model, data, 1) == 0
        peak = max(peak, data.rail["q"][0])
    root = np.sqrt(stiffness * mass)
    formula = kink * speed * root * (1.0 - 0.25 * np.pi * damping / root)
    assert peak - rest.rail["q"][0] == pytest.approx(formula, rel=tol.P2)


def test_steady_curving_stays(wagon):
    """Newton's steady motion is one of the time steps too, and the rails bear what the wheels press."""
    system = supported(wagon)
    curve = (1 / 1200.0, 0.09)
    found = steady(system, *curve, 30.0).data
    stiffness, _ = rails_of(system)
    assert_allclose(found.yielded * stiffness, np.column_stack([found.rail["y"], found.rail["q"]]), atol=tol.RAIL_BEARS)
    there = scenes.tuned(scenes.replaced(system, track=pack(constant_track(*curve), 3000.0)), speed=30.0)
    data = there.start()
    for own, its in zip(data, found, strict=True):
        own[...] = its
    assert advance(there.model, data, 1000) == 0
    assert_allclose(data.q[:, 1:4], found.q[:, 1:4], rtol=0, atol=tol.RAIL_STAYS)
    assert_allclose(data.yielded, found.yielded, rtol=0, atol=tol.RAIL_STAYS)


def test_mirrored_rails_give_way_mirrored(table):
    """A wheelset yawed one way and its mirror image."""
    moved = []
    for sign in (1.0, -1.0):
        system = lone(table, step=0.5e-3)
        data = settled_start(system)
        data.q[0, 1], data.q[0, 5] = sign * 2e-3, sign * 1e-3
        assert advance(system.model, data, 50) == 0
        moved.append(data.yielded.copy())
    assert_allclose(moved[1], moved[0][SIDES] * [-1.0, 1.0], rtol=0, atol=tol.RAIL_MIRROR)


@pytest.mark.parametrize("kind", SETS)
def test_the_step_need_not_be_shorter(wagon, kind):
    """One step about straight running: what grows on rigid rails sets the limit on rails that give way too."""
    known = StepLimit(2.4e-3, "nothing")
    limits = [OneStep(stiffest(system), 30.0).limit(known).stable for system in (wagon, supported(wagon, kind))]
    assert limits[1] >= (1.0 - tol.STEP_BISECTED) * limits[0]


def test_rails_that_hardly_give_way_are_rigid(table):
    """The motion on rails of 1e10 N/m is that on rigid ones but for the deflection."""
    rigid = scenes.lone_wheelset(table, 20.0, step=1e-4, mass=11e3)
    stiff = scenes.tuned(rigid, rail_stiffness=(1e11, 1e11), rail_damping=(1e3, 1e3))
    places = []
    for system in (rigid, stiff):
        data = settled_start(system, 1e-3)
        assert advance(system.model, data, 2000) == 0
        places.append(data.q[0, [1, 2, 3, 5]].copy())
    assert_allclose(places[1], places[0], rtol=0, atol=tol.RAIL_ALL_BUT_RIGID)


@pytest.mark.parametrize("kind", SETS)
def test_a_flange_strike_does_not_hang_on_the_step(table, kind):
    """Largest Y and Q of a wheelset that strikes its flange at 0.2 m/s: at 1 ms as at 0.125 ms."""
    peaks = []
    for step in (0.125e-3, 1e-3):
        system = scenes.tuned(lone(table, 50.0, kind, step), damping=0.2)
        data, peak = settled_start(system), np.zeros(2)
        data.v[0, 1] = 0.2
        for _ in range(round(0.08 / step)):
            assert advance(system.model, data, 1) == 0
            peak = np.maximum(peak, [np.abs(data.rail["y"]).max(), data.rail["q"].max()])
        peaks.append(peak)
    assert peaks[0][0] > 20e3
    assert_allclose(peaks[1], peaks[0], rtol=tol.STRIKE)


def test_sets_are_beams_on_their_seats():
    """Stiffness and low-frequency damping of an endless beam on a bed, against its differential equation by sums.

    The beam's deflection under a load is the integral of F / (E I x^4 + k + i w c) / (2 pi) over wave numbers x.
    """
    x = np.linspace(0.0, 200.0, 400_001)
    for seat in SETS.values():
        for bending, (stiffness, damping) in zip(RAIL_BENDING, (seat.vertical, seat.lateral), strict=True):
            found, damped = under_a_wheel(bending, stiffness, damping)
            omega = 1e-3 * stiffness / damping
            bed = (stiffness + 1j * omega * damping) / SEAT_SPACING
            whole = 1.0 / (np.trapezoid(1.0 / (bending * x**4 + bed), x) / np.pi)
            assert whole.real == pytest.approx(found, rel=tol.BEAM_ON_BED)
            assert whole.imag / omega == pytest.approx(damped, rel=tol.BEAM_ON_BED)
