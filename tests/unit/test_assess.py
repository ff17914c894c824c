"""Assessment of runs that are made up of signals with known figures."""

import math

import numpy as np
import pytest
import tolerances as tol
from naive import high_gain, low_gain

from railcli.analysis import indices
from railcli.analysis.assess import assess
from railcli.analysis.assessment import run as run_module
from railcli.analysis.assessment.sections import sections
from railcli.errors import InputError
from railcli.files.limits import load_limits
from railcli.files.read_results import Channel
from railcli.files.scenario import load
from railcli.kernels.layout import MAX_CONTACT, Region
from railcli.model.assessment import FIGURES, Limits
from railcli.model.scenario import SpeedCourse
from railcli.model.track import Curve, Straight, Track, Transition
from railcli.model.vehicle import Body, Vehicle, static_wheel_loads

SPEED = 20.0
STRAIGHT = Track((Straight(length=4000.0),))


def curved(hand="left", radius=500.0, length=1000.0):
    """A curve from the beginning."""
    return Track((Curve(length=length, radius=radius, hand=hand, cant=0.1),))


class Recorded:
    """Results in memory: the wagon rolls steadily, its wheels carry their static loads, nothing else happens."""

    fault, filtered = "", None

    def __init__(self, track=STRAIGHT, seconds=40.0, rate=100.0, speed=SPEED, vehicle=None):
        self.scenario = load("straight-60").varied(
            track=track,
            run={"speed": speed, "distance": min(seconds * speed, track.length)},
            **({"vehicle": vehicle} if vehicle else {}),
        )
        vehicle = self.scenario.vehicle
        self.rows = round(seconds * rate)
        self.time = np.arange(1, self.rows + 1) / rate
        self.bodies = vehicle.names
        self.wheelsets = tuple(vehicle.names[i] for i in vehicle.wheelsets)
        self.wheels = tuple(f"W{k + 1}_{side}" for k in range(len(self.wheelsets)) for side in ("right", "left"))
        self.static = static_wheel_loads(vehicle, 9.81, self.scenario.contact.tape_circle)
        self.arrays = {"time": self.time}
        for body in vehicle.bodies:
            place = np.zeros((self.rows, 3))
            place[:, 0] = speed * self.time + body.x - vehicle.bodies[0].x
            self.arrays[f"bodies/{body.name}/position"] = place
            for name in ("rotation", "angular_velocity", "acceleration"):
                self.arrays[f"bodies/{body.name}/{name}"] = np.zeros((self.rows, 3))
        for wheel, load_at_rest in zip(self.wheels, self.static.ravel(), strict=True):
            self.arrays[f"wheels/{wheel}/Y"] = np.zeros(self.rows)
            self.arrays[f"wheels/{wheel}/Q"] = np.full(self.rows, load_at_rest)
            for name in ("creep_x", "creep_t"):
                self.arrays[f"wheels/{wheel}/contact/{name}"] = np.zeros((self.rows, MAX_CONTACT))
            for name in ("xi", "eta", "region"):
                self.arrays[f"wheels/{wheel}/contact/{name}"] = np.full((self.rows, MAX_CONTACT), np.nan)

    @property
    def channels(self):
        return {name: Channel(name, "", "", ()) for name in self.arrays}

    def read(self, name, start=0, stop=None):
        return self.arrays[name][start:stop]

    def pieces(self, *names, size):
        for start in range(0, self.rows, size):
            yield tuple(self.read(name, start, start + size) for name in names)


def found(results, limits=None):
    """Values by key."""
    return {value.key: value for value in assess(results, limits).values}


def test_wagon_at_rest_on_its_springs_passes_with_nothing():
    values = found(Recorded())
    assert [values[key].status for key in ("sum_Y", "Y_Q", "Y_Q_peak", "unloading", "Q_max", "stability")] == [
        "pass"
    ] * 6
    assert values["Q_max"].value == pytest.approx(54.55e3, rel=1e-3)
    for key in ("sum_Y", "Y_Q", "unloading", "stability", "ay_max", "az_max", "wear_wheel"):
        assert values[key].value == pytest.approx(0.0, abs=1e-9), key


def test_sum_of_guiding_forces_of_a_sine():
    """Amplitude times the gain of the low-pass times that of the 2 m window; at 2.1 Hz and 20 m/s L = 9.52 m."""
    results = Recorded(seconds=60.0)
    for wheel, amplitude in (("W2_right", 30e3), ("W2_left", 10e3)):
        results.arrays[f"wheels/{wheel}/Y"] += amplitude * np.sin(2.0 * np.pi * 2.1 * results.time)
    value = found(results)["sum_Y"]
    assert value.value == pytest.approx(40e3 * low_gain(2.1, 20.0) * np.sinc(0.21), rel=tol.SIGNAL)
    assert value.place.startswith("W2, ") and value.status == "pass"
    assert value.limit == pytest.approx(10e3 + results.static[1].sum() / 3.0)


@pytest.mark.parametrize("hand, wheel, sign", [("left", "W3_right", 1.0), ("right", "W3_left", -1.0)])
def test_guiding_wheel_is_the_outer_one_and_outwards_is_positive(hand, wheel, sign):
    results = Recorded(curved(hand))
    inner = wheel.replace("right", "x").replace("left", "right").replace("x", "left")
    results.arrays[f"wheels/{wheel}/Y"] += sign * 20e3
    results.arrays[f"wheels/{inner}/Y"] += -sign * 30e3  # to the field side too, but it does not guide
    values = found(results)
    load_at_rest = results.static[2, 0]
    assert values["Y_Q"].value == pytest.approx(20e3 / load_at_rest, rel=1e-6)
    assert values["Y_Q"].place.startswith(wheel.replace("_", " "))
    assert values["Y_qst"].value == pytest.approx(20e3, rel=1e-6)
    assert values["Y_Q_peak"].value == pytest.approx(30e3 / load_at_rest, rel=1e-6)
    assert values["sum_Y"].value == pytest.approx(10e3, rel=1e-6)


def test_on_straight_track_both_wheels_guide_and_nothing_is_quasi_static():
    results = Recorded()
    results.arrays["wheels/W4_left/Y"] -= 15e3
    values = found(results)
    assert values["Y_Q"].value == pytest.approx(15e3 / results.static[3, 1], rel=1e-6)
    assert values["Y_qst"].status == "not evaluated" and "no full curve" in values["Y_qst"].note


def test_wheel_load_and_unloading():
    results = Recorded(curved())
    results.arrays["wheels/W3_left/Q"][:] = 80e3
    results.arrays["wheels/W3_right/Q"][:] = 30e3
    values = found(results)
    assert values["Q_max"].value == pytest.approx(80e3, rel=1e-9)
    assert values["Q_max"].limit == pytest.approx(90e3 + results.static[2].mean())
    assert values["unloading"].value == pytest.approx(1.0 - 30e3 / results.static[2, 0], rel=1e-9)
    assert values["unloading"].place.startswith("W3 right")
    assert values["Q_qst"].value == pytest.approx(results.static.max(), rel=1e-9)  # outer is right: 30 kN and at rest


def test_a_wheel_that_lifts_fails_and_leaves_the_ratio_out_there():
    results = Recorded()
    lifted = slice(2000, 2100)  # 20 m
    results.arrays["wheels/W1_right/Q"][lifted] = 0.0
    results.arrays["wheels/W1_right/Y"][:] = 5e3
    results.arrays["wheels/W1_right/Y"][lifted] = 0.0
    values = found(results)
    assert values["unloading"].status == "fail" and values["unloading"].value == pytest.approx(1.0, abs=tol.OVERSHOOT)
    assert "below 0.05 Q0" in values["Y_Q_peak"].note
    assert values["Y_Q"].value < 0.2


def test_a_run_whose_speed_changes_is_not_assessed():
    results = Recorded()
    course = SpeedCourse(time=(0.0, 10.0), speed=(SPEED, 0.5 * SPEED))
    results.scenario = results.scenario.varied(run={"course": course, "distance": None, "duration": 40.0})
    with pytest.raises(InputError, match="the speed of the run changes"):
        assess(results)


def test_run_in_does_not_count():
    results = Recorded()
    results.arrays["wheels/W1_right/Y"][:200] = 100e3  # 2 of the first 3 s
    assert found(results)["sum_Y"].value == pytest.approx(0.0, abs=1.0)
    assert found(results, Limits(run_in=1.0))["sum_Y"].status == "fail"


@pytest.mark.parametrize("phase", np.arange(0.0, 2.0, 0.25) * np.pi)
def test_a_record_that_ends_in_a_swing_shows_no_peak_there(phase):
    """A steady swing of 1.2 Hz that stops with the record: nothing but its amplitude, whatever its phase is then."""
    results = Recorded(seconds=30.0)
    swing = np.cos(2.0 * np.pi * 1.2 * (results.time - results.time[-1]) + phase)
    results.arrays["bodies/car body/acceleration"][:, 1] = swing
    results.arrays["bodies/car body/acceleration"][:, 2] = swing
    values = found(results)
    for key in ("ay_max", "az_max"):
        assert values[key].value == pytest.approx(high_gain(1.2, 0.4) * low_gain(1.2, 10.0), rel=tol.RECORD_END), key
    expected = abs(indices.weighting("W_d", 1.2)) / math.sqrt(2.0)
    assert values["C_y"].value == pytest.approx(expected, rel=tol.RECORD_END)


def test_stability_of_a_swinging_wheelset():
    """Amplitude over sqrt 2, times the gain of the band from 3 to 7 Hz at 5 Hz; the frequency is told."""
    results = Recorded()
    results.arrays["wheels/W2_left/Y"] += 20e3 * np.sin(2.0 * np.pi * 5.0 * results.time) + 5e3
    value = found(results)["stability"]
    expected = 20e3 / math.sqrt(2.0) * high_gain(5.0, 3.0) * low_gain(5.0, 7.0)
    assert value.value == pytest.approx(expected, rel=tol.SIGNAL)
    assert value.limit == pytest.approx(0.5 * (10e3 + results.static[1].sum() / 3.0))
    assert "5.00 Hz" in value.note and value.place.startswith("W2, ")


def test_accelerations_of_a_sine_and_of_a_steady_curve():
    results = Recorded(curved(length=4000.0), seconds=60.0)
    acceleration = results.arrays["bodies/car body/acceleration"]
    acceleration[:, 1] = 1.2 + 0.8 * np.sin(2.0 * np.pi * 2.0 * results.time)
    acceleration[:, 2] = 0.5 * np.sin(2.0 * np.pi * 8.0 * results.time)
    values = found(results)
    y, z = (high_gain(f, 0.4) * low_gain(f, 10.0) for f in (2.0, 8.0))
    assert values["ay_max"].value == pytest.approx(0.8 * y, rel=tol.SIGNAL)
    assert values["ay_centre"].value == pytest.approx(0.8 * y, rel=tol.SIGNAL)
    assert values["ay_rms"].value == pytest.approx(0.8 * y / math.sqrt(2.0), rel=tol.SECTION_ENDS)
    assert values["az_max"].value == pytest.approx(0.5 * z, rel=tol.COARSE_SINE)
    assert values["az_rms"].value == pytest.approx(0.5 * z / math.sqrt(2.0), rel=tol.SECTION_ENDS)
    assert values["ay_qst"].value == pytest.approx(1.2, rel=tol.SIGNAL)
    assert values["ay_max"].status == "pass" and values["az_rms"].status == "pass"


def test_yawing_shows_above_the_bogies_and_not_at_the_centre():
    """Yaw acceleration times 9.5 m to the bogies; opposite at both, so both have the same figure."""
    results = Recorded(seconds=60.0)
    omega = 2.0 * np.pi * 1.5
    results.arrays["bodies/car body/rotation"][:, 2] = 0.002 * np.sin(omega * results.time)
    results.arrays["bodies/car body/angular_velocity"][:, 2] = 0.002 * omega * np.cos(omega * results.time)
    values = found(results)
    gain = high_gain(1.5, 0.4) * low_gain(1.5, 10.0)
    assert values["ay_max"].value == pytest.approx(9.5 * 0.002 * omega**2 * gain, rel=tol.SIGNAL)
    assert values["ay_centre"].value == pytest.approx(0.0, abs=1e-9)


def test_comfort_of_stationary_sines():
    """105 s after the run-in are 20 windows and more: N_MV, C and Wz of sines."""
    results = Recorded(seconds=120.0)
    acceleration = results.arrays["bodies/car body/acceleration"]
    acceleration[:, 1] = 0.3 * np.sin(2.0 * np.pi * 1.0 * results.time)
    acceleration[:, 2] = 0.4 * np.sin(2.0 * np.pi * 5.0 * results.time)
    values = found(results)
    lateral = 0.3 * abs(indices.weighting("W_d", 1.0)) / math.sqrt(2.0)
    vertical = 0.4 * abs(indices.weighting("W_b", 5.0)) / math.sqrt(2.0)
    assert values["N_MV"].value == pytest.approx(6.0 * math.hypot(lateral, vertical), rel=tol.SIGNAL)
    assert values["N_MV"].note == "comfortable; 23 windows, 5 minutes have 60"
    assert values["C_z"].value == pytest.approx(vertical, rel=tol.SIGNAL)
    rms = 0.4 * float(indices.sperling_weighting(5.0)) / math.sqrt(2.0)
    assert values["Wz_z"].value == pytest.approx(4.42 * rms**0.3, rel=tol.SIGNAL)


def test_short_runs_say_what_is_missing():
    values = found(Recorded(seconds=21.0))
    assert values["N_MV"].status == "not evaluated" and "3 windows of 5 s" in values["N_MV"].note
    assert values["Wz_z"].status == "no limit"
    values = found(Recorded(seconds=7.0))
    assert values["Wz_z"].status == "not evaluated" and values["stability"].status == "not evaluated"
    assert "100 m" in values["stability"].note
    outcome = assess(Recorded(seconds=2.5))
    assert {value.status for value in outcome.values} == {"not evaluated"} and not outcome.sections
    assert all("first 3 and the last 2 s" in value.note for value in outcome.values)


@pytest.mark.parametrize(
    "rate, statuses, warning",
    [(25.0, {"not evaluated"}, ""), (80.0, {"pass"}, "Forces: recorded at 80 Hz"), (200.0, {"pass"}, "")],
)
def test_recorded_rate(rate, statuses, warning):
    outcome = assess(Recorded(rate=rate))
    values = {value.key: value for value in outcome.values}
    assert {values[key].status for key in ("sum_Y", "Q_max", "unloading", "ay_max")} == statuses
    if rate == 25.0:
        assert "output_interval_ms = 10" in values["sum_Y"].note
    text = " ".join(outcome.warnings)
    assert warning in text and ("Comfort" in text) == (rate == 80.0)


def test_wear_numbers_by_wheel_and_part():
    """One contact on the root with 5 kN at 4 per mille over half of the run, one on the tread with 1 kN at 1."""
    results = Recorded(seconds=45.0)
    state = {name: results.arrays[f"wheels/W1_right/contact/{name}"] for name in ("creep_x", "xi", "eta", "region")}
    half = results.time < 3.0 + 20.0
    state["creep_x"][half, 0], state["xi"][half, 0], state["eta"][half, 0] = -5e3, 4e-3, 0.0
    state["region"][half, 0] = Region.ROOT - 1e-9  # as interpolation leaves it
    state["creep_x"][:, 1], state["xi"][:, 1], state["eta"][:, 1] = 1e3, -1e-3, 0.0
    state["region"][:, 1] = Region.TREAD
    outcome = assess(results)
    values = {value.key: value for value in outcome.values}
    wheel = outcome.wear["W1_right"]
    assert wheel["tread"] == pytest.approx((1.0, 1.0))
    assert wheel["flange root"][1] == pytest.approx(20.0)
    assert wheel["flange root"][0] == pytest.approx(10.0, rel=0.03)  # sections begin 10 m before, see the run-in
    assert values["wear_wheel"].value == pytest.approx(21.0) and values["wear_contact"].value == pytest.approx(20.0)
    assert "flange root" in values["wear_contact"].note
    assert outcome.wear["W1_left"]["all contacts"] == (0.0, 0.0)


def test_blocks_are_not_seen(monkeypatch):
    """A long run in blocks of 1000 rows, or in one: the same figures."""
    results = Recorded(seconds=170.0)
    random = np.random.default_rng(11)
    for name in ("wheels/W1_right/Y", "wheels/W2_left/Q"):
        results.arrays[name] += 3e3 * random.normal(size=results.rows)
    results.arrays["bodies/car body/acceleration"][:] = random.normal(size=(results.rows, 3))
    whole = assess(results)
    monkeypatch.setattr(run_module, "BLOCK", 1000)
    pieces = assess(results)
    assert len(whole.sections) == 13
    for one, two in zip(whole.values, pieces.values, strict=True):
        if one.key != "stability" and one.value is not None:  # windows of 100 m and the spectrum end with the block
            assert two.value == pytest.approx(one.value, rel=tol.BLOCKWISE), one.key
            assert two.place == one.place
    trace, other = (outcome.traces["Q_max"]["W2_left"] for outcome in (whole, pieces))
    assert np.array_equal(np.isnan(trace.high), np.isnan(other.high))
    np.testing.assert_allclose(other.high, trace.high, rtol=tol.BLOCKWISE)


def test_a_broken_run_counts_as_far_as_each_wheelset_came():
    """The front wheelset's last 10 m, where no other one has been, enter only then."""
    results = Recorded()
    results.arrays["wheels/W1_right/Y"][-50:] = 60e3
    whole = found(results)
    results.fault = "derailed"
    broken = found(results)
    assert whole["Y_Q"].value < 0.2
    assert broken["Y_Q"].value > 0.9 and broken["Y_Q"].place.startswith("W1 right")
    assert not assess(results).accepted
    assert assess(results, fault="").count("fail") == 0


def test_what_was_not_recorded_is_named():
    results = Recorded()
    del results.arrays["wheels/W3_left/Q"]
    values = found(results)
    assert values["sum_Y"].note == "channel wheels/W3_left/Q was not recorded"
    assert values["ay_max"].status == "pass"


def test_a_lone_wheelset_has_forces_and_no_ride():
    body = Body(name="axle", mass=2000.0, inertia=(1e3, 1e2, 1e3), x=0.0, wheel_radius=0.46)
    values = found(Recorded(vehicle=Vehicle(name="axle", bodies=(body,))))
    assert values["Q_max"].value == pytest.approx(9810.0)
    assert values["ay_max"].note == values["N_MV"].note == "the vehicle has no body above its wheelsets"


@pytest.mark.parametrize("share, status", [(0.85, "pass"), (0.95, "warn"), (1.05, "fail")])
def test_verdict(share, status):
    results = Recorded()
    for wheel in ("W1_right", "W1_left"):
        results.arrays[f"wheels/{wheel}/Y"] += share * 0.5 * indices.prudhomme(results.static[0].sum())
    assert found(results)["sum_Y"].status == status


def test_tight_curves_have_no_limit_of_guiding_forces():
    results = Recorded(curved(radius=200.0))
    results.arrays["wheels/W1_right/Y"] += 30e3
    values = found(results)
    assert values["Y_Q"].status == values["Y_qst"].status == "no limit"
    assert "250 m" in values["Y_Q"].note and values["Y_Q"].value > 0.5
    assert values["Y_Q_peak"].limit == pytest.approx(indices.nadal(math.radians(70.0), 0.3))


def test_limits_that_depend_on_the_run():
    limits = Limits()
    assert [limits.largest_y_qst(radius) for radius in (200.0, 250.0, 300.0, 350.0, 400.0, 3000.0)] == [
        None, 72e3, 65e3, 60e3, 60e3, 60e3,
    ]  # fmt: skip
    for kmh, expected in ((160.0, 200e3), (161.0, 190e3), (220.0, 180e3), (300.0, 170e3), (320.0, 160e3)):
        assert limits.largest_q(115e3, kmh / 3.6) == expected
    assert limits.largest_q(50e3, 30.0) == 140e3
    assert Limits(q_max=120e3).largest_q(50e3, 30.0) == 120e3


def test_limits_from_a_file(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text("Y_over_Q = 0.7\nQ_max_kN = 180\nflange_angle_deg = 60\nay_max_m_per_s2 = 2\nT_gamma_N = 175\n")
    limits = load_limits(path)
    assert (limits.y_over_q, limits.q_max, limits.ay_max, limits.t_gamma) == (0.7, 180e3, 2.0, 175.0)
    assert limits.flange_angle == pytest.approx(math.radians(60.0))
    assert limits.unloading == Limits().unloading


SNAKE = Track(
    (
        Straight(length=1000.0),
        Transition(length=100.0, shape="clothoid"),
        Curve(length=220.0, radius=350.0, hand="right", cant=0.1),
        Transition(length=160.0, shape="bloss"),
        Curve(length=900.0, radius=1500.0, hand="left", cant=0.1),
    )
)


def test_sections_of_a_track():
    """At 30 m/s: 250 m on straights, 70 m below 400 m radius, 100 m in a large one; an S-curve has two transitions."""
    parts = sections(SNAKE, 100.0, 2300.0, 30.0)
    kinds = [(part.kind, round(part.start), round(part.end)) for part in parts]
    assert kinds[:3] == [("straight", 100, 400), ("straight", 400, 700), ("straight", 700, 1000)]
    assert kinds[3:7] == [
        ("transition", 1000, 1100),
        ("curve", 1100, 1173),
        ("curve", 1173, 1247),
        ("curve", 1247, 1320),
    ]
    turning = [part for part in parts if part.kind == "transition" and part.start > 1300.0]
    assert [part.outer for part in turning] == [1, 0]  # left rail, then right rail
    assert turning[0].start == pytest.approx(1320.0) and turning[1].end == pytest.approx(1480.0)
    rest = parts[parts.index(turning[1]) + 1 :]
    assert len(rest) == 8 and [part.radius for part in rest] == pytest.approx([1500.0] * 8)
    assert not any(part.short for part in parts)


def test_sections_that_are_cut_short():
    parts = sections(SNAKE, 900.0, 1109.0, 30.0)
    assert [(part.kind, part.short) for part in parts] == [("straight", True), ("transition", False)]
    assert [part.start for part in sections(SNAKE, 0.0, 1000.0, 30.0, 100.0)] == pytest.approx(
        np.arange(0.0, 1000.0, 100.0)
    )
    assert len(sections(SNAKE, 0.0, 1000.0, 65.0)) == 2  # 234 km/h: 500 m


def test_every_figure_has_a_value_or_a_reason():
    for results in (Recorded(), Recorded(seconds=2.0), Recorded(rate=10.0)):
        values = assess(results).values
        assert [value.key for value in values] == list(FIGURES)
        assert all((value.value is None) == (value.status == "not evaluated") for value in values)
        assert all(value.note for value in values if value.value is None)
