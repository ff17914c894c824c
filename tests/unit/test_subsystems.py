"""Brake, traction, sensors, odometry and adhesion by themselves, against closed forms and slow twins."""

import math

import numpy as np
import pytest
import tolerances as tol
from scipy.integrate import solve_ivp

from railcli.analysis.longitudinal import model_of
from railcli.errors import InputError
from railcli.files.scenario import load
from railcli.kernels.adhesion import grip_of
from railcli.kernels.assembly_layout import ASSEMBLY, LINE, PLAN, PORT, TRAIN, Rise, Sensor, Valve
from railcli.kernels.brake import cast_iron, delayed, distribute, fill_cylinder, switch
from railcli.kernels.sensor import listen, noise
from railcli.model.submodels import ADHESION_SETS
from railcli.model.subsystems import reacting_body

STEP = 1e-3


def assembly(**values):
    row = np.zeros(1, ASSEMBLY)[0]
    for key, value in values.items():
        row[key] = value
    return row


def scenario(**tables):
    """A wagon that brakes from 30 m/s, with some tables of a file replaced; None leaves one out."""
    base = {
        "name": "brake",
        "run": {"speed_m_per_s": 30.0, "step_ms": 1.0, "duration_s": 100.0},
        "track": [{"kind": "straight", "length_m": 3000.0}],
        "contact": {"creep_law": "polach"},
        "driver": {"kind": "demand", "time_s": [0, 1], "brake": [1, 1]},
        "brake": {"kind": "torque", "torque_Nm": 5000.0, "valves": {}},
        "adhesion": {"stretch": [{"set": "dry"}]},
        **tables,
    }
    return load({key: value for key, value in base.items() if value is not None})


def risen(steps, demand=1.0, start=0.0, **values):
    """Pressures of a distributor at the ends of steps."""
    row, found = assembly(**values), [start]
    for _ in range(steps):
        found.append(distribute(row, found[-1], demand, STEP))
    return np.array(found)


def test_linear_rise_and_release():
    up = risen(5000, rise=Rise.LINEAR, apply=4.0, release=20.0)
    time = STEP * np.arange(up.size)
    np.testing.assert_allclose(up, np.minimum(time / 4.0, 1.0), atol=tol.ROUNDING)
    down = risen(5000, 0.0, 1.0, rise=Rise.LINEAR, apply=4.0, release=20.0)
    np.testing.assert_allclose(down, 1.0 - time / 20.0, atol=tol.ROUNDING)


def test_exponential_rise_has_95_percent_at_its_time():
    up = risen(4000, rise=Rise.EXPONENTIAL, apply=4.0, release=1.0)
    assert up[-1] == pytest.approx(0.95, rel=tol.ROUNDING)
    assert up[2000] == pytest.approx(1.0 - math.sqrt(0.05), rel=tol.ROUNDING)


def test_stepped_rise_has_an_inshot():
    up = risen(25000, rise=Rise.STEPPED, apply=24.0, inshot=0.1, inshot_time=0.5)
    assert up[500] == pytest.approx(0.1, abs=tol.ROUNDING)
    assert up[500 + 11750] == pytest.approx(0.55, abs=1e-3)
    assert up[24000] == pytest.approx(1.0, abs=1e-3)


def test_delay_shifts_the_demand():
    samples, train = np.zeros(256), np.zeros(1, TRAIN)[0]
    demand = lambda t: 0.5 + 0.5 * math.sin(t)  # noqa: E731
    worst = 0.0
    for k in range(6000):
        t = STEP * k
        found = delayed(samples, train, demand(t), 1.5, t, STEP)
        worst = max(worst, abs(found - (demand(t - 1.5) if t >= 1.5 else 0.0)))
    assert worst < 2e-3  # samples lie 6 ms apart


def test_cylinder_against_its_differential_equation():
    row = assembly(fill=0.35, vent=0.25)
    valves = [Valve.FILL, Valve.VENT, Valve.HOLD, Valve.FILL]
    found = [0.0]
    for k in range(2000):
        t = STEP * k
        found.append(fill_cylinder(row, valves[k // 500].value, found[-1], 0.4 * t, 0.4 * (t + STEP), STEP))
    def rate(t, p):
        valve = valves[min(int(t / 0.5), 3)]
        return {Valve.FILL: (0.4 * t - p) / 0.35, Valve.VENT: -p / 0.25, Valve.HOLD: 0.0 * p}[valve]

    value = 0.0
    for k in range(4):
        solution = solve_ivp(rate, (0.5 * k, 0.5 * (k + 1) - 1e-12), [value], rtol=1e-10, atol=1e-12)
        value = solution.y[0, -1]
        assert found[500 * (k + 1)] == pytest.approx(value, abs=1e-5)


def test_valves_act_after_their_dead_time():
    port, seen = np.zeros(1, PORT)[0], []
    for k in range(100):
        wanted = Valve.VENT if 10 <= k < 15 else Valve.HOLD if 15 <= k < 40 else Valve.FILL
        switch(port, wanted.value, 0.020, STEP * k)
        seen.append(int(port["valve_now"]))
    assert seen == [0] * 30 + [2] * 5 + [1] * 25 + [0] * 40
    assert port["vents"] == 1


def test_cast_iron_as_published():
    """Reference page of the project: 20 kN at 0, 60, 100, 120 km/h."""
    found = [cast_iron(20e3, v / 3.6) for v in (0.0, 60.0, 100.0, 120.0)]
    np.testing.assert_allclose(found, [0.305, 0.122, 0.1015, 0.0957], atol=0.5e-3)


def sensed(kind, speeds, teeth=80, radius=0.46, period=0.01, clock=0.0):
    """Speeds that a phonic wheel tells at its samples, of an axle whose tread runs at speeds (per sample)."""
    row = assembly(sensor=kind, teeth=teeth, period=period, clock=clock)
    port, tooth = np.zeros(1, PORT)[0], 2.0 * math.pi / teeth
    port["edge_time"], place, found = -1.0, 0.37, []
    for k, v in enumerate(speeds):
        rate = v / (tooth * radius)
        listen(port, place, rate, tooth * radius, row, period * k)
        found.append(float(port["speed"]))
        place += rate * period
    return np.array(found)


def test_counting_resolves_whole_edges_only():
    found = sensed(Sensor.COUNTING, np.full(2000, 10.0))[1:]
    step = 2.0 * math.pi * 0.46 / (80 * 0.01)
    np.testing.assert_allclose(found / step, np.round(found / step), atol=1e-9)
    assert step == pytest.approx(3.61, abs=0.005)  # published: N = 80, r = 0.46 m, 10 ms
    assert found.mean() == pytest.approx(10.0, rel=1e-3)


def test_timing_is_exact_but_for_its_clock():
    exact = sensed(Sensor.TIMING, np.full(500, 44.4))[5:]
    np.testing.assert_allclose(exact, 44.4, rtol=1e-9)
    rough = sensed(Sensor.TIMING, np.full(500, 44.4), clock=1e-4)[5:]
    assert 0.0 < np.abs(rough - 44.4).max() <= 2.0 * 44.4 * 1e-4 / 0.008


def test_a_wheel_without_edges_slows_down():
    found = sensed(Sensor.TIMING, np.concatenate([np.full(50, 5.0), np.zeros(200)]))
    assert found[-1] < 0.02 * 5.0
    assert (np.diff(found[52:]) <= 0.0).all()


def test_noise_has_variance_one():
    train = np.zeros(1, TRAIN)
    train["seed"] = 7
    values = np.array([noise(train[0]) for _ in range(20000)])
    assert abs(values.mean()) < 0.03
    assert values.std() == pytest.approx(1.0, abs=0.03)


def test_grip_blends_between_stretches():
    line = np.zeros(2, LINE)
    line["start"], line["blend"] = (-np.inf, 100.0), 20.0
    line["grip"][0], line["grip"][1] = ADHESION_SETS["dry"].value, ADHESION_SETS["low"].value
    found = [grip_of(line, 1 if s >= 100.0 else 0, 0, s, 0.0, 0) for s in (99.9, 100.0, 110.0, 120.0, 500.0)]
    np.testing.assert_allclose(found, [0.55, 0.55, 0.305, 0.06, 0.06], rtol=1e-12)


def test_torques_react_on_the_bogies():
    vehicle = load("curve-1200-45").vehicle
    names = [vehicle.names[reacting_body(vehicle, i)] for i in vehicle.wheelsets]
    assert names == ["bogie 1", "bogie 1", "bogie 2", "bogie 2"]


def test_assembly_of_a_plan():
    driver = {"kind": "line", "place": [{"at_m": 0, "speed_kmh": 36}, {"at_m": 500, "dwell_s": 10}]}
    model, _ = model_of(scenario(driver=driver))
    assert model.plan.dtype == PLAN
    np.testing.assert_allclose(model.plan["speed"], [10.0, 10.0])
    np.testing.assert_allclose(model.plan["dwell"], [0.0, 10.0])


BAD = {
    "no brake": ({"brake": None}, "driver.brake: there is no brake"),
    "no valves": (
        {"brake": {"kind": "torque", "torque_Nm": 1.0}, "slide_protection": {}}, "acts on dump valves; give"
    ),
    "no motors": ({"anti_slip": {}}, "acts on motors; give"),
    "sensor alone": ({"speed_sensor": {}}, "nobody reads it"),
    "period": (
        {"slide_protection": {}, "speed_sensor": {"period_ms": 2.5}}, "speed_sensor.period_ms: must be a whole number"
    ),
    "two frictions": ({"contact": {"creep_law": "polach", "friction": 0.3}}, "contact.friction: .adhesion. says"),
    "law": ({"contact": {"creep_law": "fastrip"}}, "which only Polach's law knows"),
    "unknown set": ({"adhesion": {"stretch": [{"set": "lo"}]}}, "unknown name 'lo'"),
    "film": ({"adhesion": {"stretch": [{"set": "low", "clean": "dry"}]}}, "memory says by whom"),
    "not in order": (
        {"adhesion": {"stretch": [{"set": "dry"}, {"from_m": 50, "set": "low"}, {"from_m": 20, "set": "dry"}]}},
        "from_m must increase",
    ),
    "nan": ({"brake": {"kind": "torque", "torque_Nm": math.nan}}, "brake.torque_Nm: must be a finite number"),
    "negative": ({"brake": {"kind": "torque", "torque_Nm": -1}}, "brake.torque_Nm: must be > 0 N m"),
    "kind": ({"brake": {"kind": "disks"}}, "must be one of 'torque', 'discs', 'blocks', got 'disks'"),
    "friction of discs": (
        {"brake": {"kind": "discs", "clamp_force_kN": 20, "radius_m": 0.25}}, "friction of the brake: give one of"
    ),
    "no function": (
        {"traction": {"speed_kmh": [0, 50, 50], "torque_Nm": [3, 2, 1]}}, "must increase from each value to the next"
    ),
    "rises": ({"traction": {"speed_kmh": [0, 50], "torque_Nm": [1, 2]}}, "torque_Nm must not rise"),
    "axle": (
        {"traction": {"speed_kmh": [0, 50], "torque_Nm": [2, 1], "axles": [5]}}, "the vehicle has 4 axles, got 5"
    ),
    "frames": (
        {"brake": {"kind": "torque", "torque_Nm": 1.0, "frames": ["bogie 1"]}}, "must name a body for each of the 4"
    ),
    "demand": ({"driver": {"kind": "demand", "time_s": [0, 1], "brake": [0, 1.5]}}, "must be <= 1"),
    "times": ({"driver": {"kind": "demand", "time_s": [0, 2, 1], "brake": [0, 1, 1]}}, "not fall"),
}  # fmt: skip


@pytest.mark.parametrize("tables, message", BAD.values(), ids=BAD)
def test_what_does_not_fit_is_one_line(tables, message):
    with pytest.raises(InputError, match=message) as caught:
        scenario(**tables)
    assert "\n" not in str(caught.value)
