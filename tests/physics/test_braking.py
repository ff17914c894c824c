"""Braking: the subsystems on a running mass against closed forms and a slow twin, the wagon against its balances."""

import math

import numpy as np
import pytest
import tolerances as tol
from scipy.integrate import solve_ivp

from railcli.analysis.braking_check import LOAD, PATCH, exponential_stop
from railcli.analysis.faults import copied
from railcli.analysis.ledger import kinetic_energy, ledger
from railcli.analysis.longitudinal import model_of, stop
from railcli.analysis.simulate import simulate
from railcli.analysis.step_choice import with_step
from railcli.files.scenario import load
from railcli.kernels.longitudinal import coast
from railcli.kernels.step import advance
from railcli.model.submodels import ADHESION_SETS
from railcli.model.system import assemble

MASS, INERTIA, RADIUS = 44482.0, 112.0, 0.46  # the Manchester wagon
FULL = 5358.91  # torque of an axle that gives it 1.0 m/s^2 [N m]
GRIP = {"stretch": [{"friction": 1.0}]}


def scenario(**tables):
    base = {
        "name": "brake",
        "run": {"speed_m_per_s": 30.0, "step_ms": 1.0, "duration_s": 400.0, "output_interval_ms": 10.0},
        "track": [{"kind": "straight", "length_m": 5000.0}],
        "contact": {"creep_law": "polach", "normal": "hertz"},
        "driver": {"kind": "demand", "time_s": [0, 1], "brake": [1, 1]},
        "brake": {"kind": "torque", "torque_Nm": FULL, "apply_s": 0.0},
        "adhesion": {"stretch": [{"set": "dry"}]},
        **tables,
    }
    return load({key: value for key, value in base.items() if value is not None})


def brake(**values):
    return {"kind": "torque", "torque_Nm": FULL, "apply_s": 0.0, **values}


def ran(case, table):
    """A run of the whole wagon: system, outcome, rows joined by name."""
    case, system, _ = with_step(case, assemble(case, [table]))
    blocks = []

    def sink(rows):
        blocks.append({name: array.copy() for name, array in rows._asdict().items()})

    outcome = simulate(case, system, sink)
    return system, outcome, {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}


@pytest.mark.parametrize("speed", [10.0, 30.0, 80.0])
def test_stop_from_rolling(speed):
    found = stop(scenario(run={"speed_m_per_s": speed, "step_ms": 1.0}, adhesion=GRIP), PATCH, LOAD)
    assert found.distance == pytest.approx(speed**2 / 2.0, rel=1e-3)


def test_exponential_rise():
    found = stop(scenario(brake=brake(rise="exponential", apply_s=4.0), adhesion=GRIP), PATCH, LOAD)
    assert found.distance == pytest.approx(exponential_stop(30.0, 1.0, 4.0 / math.log(20.0)), rel=1e-3)


def test_friction_in_steps_of_the_speed():
    """a(V) constant in two pieces: sum of (v_hi^2 - v_lo^2) / 2 a."""
    discs = {
        "kind": "discs", "clamp_force_N": 20e3, "radius_m": 0.25, "discs": 2, "apply_s": 0.0,
        "friction_speed_m_per_s": [0.0, 15.0, 15.0001, 40.0], "friction_values": [0.4, 0.4, 0.2, 0.2],
    }  # fmt: skip
    found = stop(scenario(brake=discs, adhesion=GRIP), PATCH, LOAD)
    slow, fast = (4 * 4 * 20e3 * mu * 0.25 / RADIUS / (MASS + 4 * INERTIA / RADIUS**2) for mu in (0.4, 0.2))
    assert found.distance == pytest.approx(15.0**2 / (2 * slow) + (30.0**2 - 15.0**2) / (2 * fast), rel=1e-3)


def polach(w, v, name):
    """Creep force of a wheel of the published patch, written out (Polach 2005) [N]."""
    mu0, a, b, ka, ks = ADHESION_SETS[name].value
    mu = mu0 * ((1.0 - a) * math.exp(-b * abs(w)) + a)
    s = abs(w) / max(v, 0.5)
    e = PATCH.shear * math.pi * PATCH.semi_x * PATCH.semi_y * PATCH.c11 * s / (4.0 * LOAD * mu)
    return math.copysign(2.0 * mu * LOAD / math.pi * (ka * e / (1.0 + (ka * e) ** 2) + math.atan(ks * e)), w)


def test_sliding_against_a_slow_twin():
    """Low adhesion, 8 s: one mass and four wheelsets by an adaptive stiff method, until they lock and beyond."""

    def rates(t, state):
        v, omega = state
        force = 2.0 * polach(v - RADIUS * omega, v, "low")
        return [-4.0 * force / MASS, (RADIUS * force - FULL) / INERTIA]

    def locked(t, state):
        return state[1]

    locked.terminal = True
    first = solve_ivp(rates, (0.0, 8.0), [30.0, 30.0 / RADIUS], method="LSODA", rtol=1e-9, atol=1e-10, events=locked)
    time, speed = first.t[-1], first.y[0, -1]
    rest = solve_ivp(lambda t, v: [-8.0 * polach(v[0], v[0], "low") / MASS], (time, 8.0), [speed], rtol=1e-9)
    case = scenario(adhesion={"stretch": [{"set": "low"}]})
    model, data = model_of(case)
    coast(model, data, PATCH.packed(), LOAD, 8000)
    assert data.v[model.axle[0]["wheelset"], 4] == 0.0
    assert data.v[0, 0] == pytest.approx(rest.y[0, -1], abs=2e-3)
    before = stop(case, PATCH, LOAD)
    assert before.locked_at == pytest.approx(time, abs=6e-3)
    assert before.locked_speed == pytest.approx(speed, abs=6e-3)


def test_halved_steps_stop_at_the_same_place():
    wet = {"stretch": [{"set": "wet"}]}
    runs = ({"speed_m_per_s": 30.0, "step_ms": step} for step in (1.0, 0.5, 0.25))
    found = [stop(scenario(run=run, adhesion=wet), PATCH, LOAD) for run in runs]
    apart = [abs(one.distance - found[2].distance) for one in found[:2]]
    assert apart[0] < 0.05 and apart[1] < 0.6 * apart[0]


def test_rail_remembers_for_the_axles_behind():
    """The first axle meets the film; the second what the first has left of it: it has the more to hold on to."""
    film = {
        "memory": "rail", "cleaning_m_per_J": 1.9e-4, "cell_m": 1.0, "stretch": [{"set": "low", "clean": "dry"}],
    }  # fmt: skip
    case = scenario(adhesion=film, brake=brake(apply_s=1.0))
    model, data = model_of(case)
    coast(model, data, PATCH.packed(), LOAD, 8000)
    grips = data.rail["grip"][:, 0].reshape(-1, 2)[:, 0]
    assert grips[0] == pytest.approx(0.06, abs=tol.ROUNDING)
    assert (np.diff(grips) > 0.0).all() and grips[1] > 0.1
    cell = int(data.q[model.axle[1]["wheelset"], 0] - model.assembly[0]["cell_start"])
    worked = data.memory[0, cell]
    assert grips[1] == pytest.approx(0.55 - 0.49 * math.exp(-1.9e-4 * worked), rel=1e-6)


def test_own_work_cleans_its_own_contact():
    film = {"memory": "own", "stretch": [{"set": "low", "clean": "dry"}]}
    with_film = stop(scenario(adhesion=film), PATCH, LOAD)
    without = stop(scenario(adhesion={"stretch": [{"set": "low"}]}), PATCH, LOAD)
    assert with_film.distance < 0.8 * without.distance


def test_energy_of_the_reduced_model_closes():
    for name in ("dry", "low"):
        found = stop(scenario(adhesion={"stretch": [{"set": name}]}), PATCH, LOAD)
        assert abs(found.unbooked) < tol.UNBOOKED
        assert found.creep_share + found.brake_share == pytest.approx(1.0, abs=tol.UNBOOKED)


@pytest.fixture(scope="module")
def downhill(table):
    """The wagon brakes down a gradient from 20 m/s on wet rail, protected; then stands."""
    return ran(
        scenario(
            run={"speed_m_per_s": 20.0, "step_ms": 1.0, "duration_s": 60.0, "output_interval_ms": 1.0},
            gradient=[{"at_m": 0, "gradient_permille": -20}],
            brake=brake(apply_s=2.0, valves={}),
            slide_protection={"reference": "true"},
            adhesion={"stretch": [{"set": "low", "friction": 0.09}]},
        ),
        table,
    )


def test_energy_of_the_wagon_closes(downhill):
    system, outcome, _ = downhill
    found = ledger(system, outcome.first, outcome.last)
    assert abs(found.share) < tol.UNBOOKED
    assert found.losses["creep_loss"] > 0.0 and found.losses["brake_loss"] > 0.5 * found.start


def test_gravity_gives_the_lost_height(downhill):
    system, outcome, rows = downhill
    run = rows["q"][-1, 0, 0] - outcome.first.q[0, 0]
    height = run * 0.02 / math.hypot(1.0, 0.02)
    weight = system.model.body["mass"].sum() * 9.81
    assert ledger(system, outcome.first, outcome.last).gains["gravity_work"] == pytest.approx(weight * height, rel=1e-3)


def test_brakes_take_torque_times_relative_spin(downhill):
    system, outcome, rows = downhill
    axle = system.model.axle
    spin = -rows["v"][:, axle["wheelset"], 4] + rows["v"][:, axle["frame"], 4]
    power = (rows["port"]["brake_torque"] * spin).sum(axis=1)
    taken = np.trapezoid(power, rows["time"])
    assert ledger(system, outcome.first, outcome.last).losses["brake_loss"] == pytest.approx(taken, rel=2e-3)


def test_kinetic_energy_counts_everything(downhill):
    system, outcome, _ = downhill
    spins = 4 * 0.5 * INERTIA * (20.0 / RADIUS) ** 2
    assert kinetic_energy(system.model, outcome.first) == pytest.approx(0.5 * MASS * 400.0 + spins, rel=1e-3)


def test_a_braked_wagon_stands_on_its_gradient(downhill):
    system, outcome, _ = downhill
    assert outcome.last.train[0]["stop_time"] > 0.0
    later = copied(outcome.last)
    places = []
    for _ in range(2):
        assert advance(system.model, later, 15_000) == 0
        places.append(later.q[system.model.axle["wheelset"], 0].copy())
    assert np.abs(places[1] - places[0]).max() < tol.CREEPS_NOT
    held = later.port["brake_torque"].sum()
    asked = MASS * 9.81 * math.sin(math.atan(0.02)) * RADIUS
    assert held == pytest.approx(asked, rel=1e-3)


def test_slide_stays_within_the_limits_of_the_protection(downhill):
    _, outcome, _ = downhill
    assert 0.05 < outcome.last.port["largest_slide"].max() < 0.30
    assert outcome.last.port["vents"].sum() > 0
    assert not outcome.last.port["locked"].any()


def test_starting_accelerates_by_force_over_mass_with_its_rotors(table):
    case = scenario(
        run={"speed_m_per_s": 20.0, "step_ms": 1.0, "duration_s": 8.0},
        start={"initial_speed_m_per_s": 0.0},
        driver={"kind": "demand", "time_s": [0, 1, 1.1], "traction": [0, 0, 1]},
        brake=None,
        traction={"speed_m_per_s": [0, 50], "torque_Nm": [2000, 2000], "ratio": 4.0, "rotor_inertia_kg_m2": 2.0},
    )
    _, outcome, rows = ran(case, table)
    inside = (rows["time"] > 3.0) & (rows["time"] < 7.0)
    found = np.polyfit(rows["time"][inside], rows["v"][inside, 0, 0], 1)[0]
    spun = 4 * (INERTIA + 4.0**2 * 2.0) / RADIUS**2
    assert found == pytest.approx(4 * 2000.0 / RADIUS / (MASS + spun), rel=2e-3)


def test_a_mirrored_wagon_brakes_alike(table):
    curve = [{"kind": "straight", "length_m": 20.0}, {"kind": "transition", "length_m": 60.0, "shape": "clothoid"}]
    ends = []
    for hand in ("right", "left"):
        track = [*curve, {"kind": "curve", "length_m": 600.0, "radius_m": 600.0, "hand": hand, "cant_mm": 60}]
        run = {"speed_m_per_s": 15.0, "step_ms": 1.0, "duration_s": 30.0}
        _, outcome, _ = ran(scenario(track=track, run=run), table)
        ends.append((outcome.last.train[0]["stop_place"], outcome.last.port["slide"].sum()))
    assert ends[0][0] == pytest.approx(ends[1][0], rel=1e-9)


def test_resistance_slows_a_wagon_that_coasts(table):
    case = scenario(
        run={"speed_m_per_s": 30.0, "step_ms": 1.0, "duration_s": 10.0}, driver={"kind": "coast"}, brake=None,
        resistance={"a_N": 1000.0, "b_Ns_per_m": 50.0, "c_Ns2_per_m2": 2.0},
    )  # fmt: skip
    _, outcome, _ = ran(case, table)
    mass = MASS + 4 * INERTIA / RADIUS**2
    wanted = solve_ivp(lambda t, v: -(1000.0 + 50.0 * v + 2.0 * v * v) / mass, (0.0, 10.0), [30.0], rtol=1e-10)
    assert outcome.last.v[0, 0] == pytest.approx(wanted.y[0, -1], rel=1e-4)
