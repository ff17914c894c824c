"""Readings, deviations, identification and verdict of the comparison, on cases with a known answer."""

import numpy as np
import pytest
import tolerances as tol

from railcli.analysis import validate
from railcli.analysis.steady_values import expected_forces, final_stretch
from railcli.analysis.validate import Curving, Reference, Scan
from railcli.files.scenario import load

SPEEDS = (45.0, 30.0, 15.0)
SIMULINK = np.array([[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0]])
REFERENCE = Reference(SPEEDS, SIMULINK, SIMULINK + 0.5)
FRICTION = np.linspace(0.05, 0.60, 23)
CRITERIA = {
    "nominal": {"rms_mm": 0.9, "max_mm": 1.6},
    "leading": {"max_mm": 0.4},
    "identified": {"rms_simulink_mm": 0.45, "rms_adams_mm": 0.55, "max_mm": 1.1},
    "balance": {"force_kN": 0.2},
}
GOOD = {"rms_simulink_mm": 0.1, "rms_adams_mm": 0.1, "max_mm": 0.1}


def curving(**values):
    """A run with balanced forces unless told otherwise."""
    usual = {
        "speed": 45.0, "outwards_mm": np.zeros(4), "peak_to_peak_mm": np.zeros(4), "yaw": np.zeros(4),
        "q_outer": np.full(4, 60e3), "q_inner": np.full(4, 50e3), "y_outwards": np.full(4, -10e3),
        "expected_y": -40e3, "expected_q": 440e3, "hold": 300.0,
    }  # fmt: skip
    return Curving(**{**usual, **values})


def straight_lines(slope):
    """A scan in which every displacement is `slope` [mm] times friction."""
    return Scan(FRICTION, np.multiply.outer(FRICTION, np.broadcast_to(slope, (3, 4))))


def test_as_printed_is_as_printed():
    simulink, adams = REFERENCE.read("as_printed")
    np.testing.assert_array_equal(simulink, SIMULINK)
    np.testing.assert_array_equal(adams, SIMULINK + 0.5)


def test_exchanged_swaps_first_and_last_row_only():
    simulink, adams = REFERENCE.read("exchanged")
    np.testing.assert_array_equal(simulink, [[9, 10, 11, 12], [5, 6, 7, 8], [1, 2, 3, 4]])
    np.testing.assert_array_equal(adams, simulink + 0.5)


def test_trailing_inside_turns_the_sign_of_w2_and_w4():
    simulink, _ = REFERENCE.read("trailing_inside")
    np.testing.assert_array_equal(simulink, [[1, -2, 3, -4], [5, -6, 7, -8], [9, -10, 11, -12]])


def test_deviations_by_hand():
    ours = np.zeros((3, 4))
    simulink, adams = np.zeros((3, 4)), np.full((3, 4), 0.5)
    simulink[1, 2] = -1.2
    found = validate.deviations(ours, simulink, adams)
    assert found["rms_simulink_mm"] == pytest.approx(1.2 / 12**0.5)
    assert found["rms_adams_mm"] == pytest.approx(0.5)
    assert found["max_mm"] == pytest.approx(1.2)


def test_identifies_the_friction_that_made_the_targets():
    slope = np.linspace(-3.0, 8.0, 12).reshape(3, 4)
    best, low, high, at_bound = validate.identify_friction(straight_lines(slope), slope * 0.233, slope * 0.233)
    assert [best, low, high] == pytest.approx([0.233] * 3, abs=tol.IDENTIFIED)
    assert not at_bound


def test_interval_of_a_mean_is_twice_its_standard_error():
    """Where all cells move alike the fit is a mean, and the jackknife error of a mean is its standard error."""
    wanted = 0.25 + 0.02 * np.array([-2, 1, 0, 3, -1, 0, 2, -3, 1, 0, -1, 0.5]).reshape(3, 4)
    best, low, high, _ = validate.identify_friction(straight_lines(5.0), 5.0 * wanted, 5.0 * wanted)
    error = wanted.std(ddof=1) / wanted.size**0.5
    assert best == pytest.approx(wanted.mean(), abs=tol.IDENTIFIED)
    assert [low, high] == pytest.approx([best - 2 * error, best + 2 * error], abs=tol.IDENTIFIED)


def test_two_codes_weigh_alike():
    scan = straight_lines(5.0)
    best, *_ = validate.identify_friction(scan, np.full((3, 4), 5.0 * 0.20), np.full((3, 4), 5.0 * 0.30))
    assert best == pytest.approx(0.25, abs=tol.IDENTIFIED)


@pytest.mark.parametrize("wanted, end", [(0.7, 0.60), (0.01, 0.05)])
def test_a_friction_beyond_the_range_is_its_end_and_said(wanted, end):
    target = np.full((3, 4), 5.0 * wanted)
    best, low, high, at_bound = validate.identify_friction(straight_lines(5.0), target, target)
    assert [best, low, high] == pytest.approx([end] * 3)
    assert at_bound


def test_scan_leaves_out_what_has_no_steady_motion(monkeypatch):
    def moved(scenario, tables, speeds):
        return np.full((3, 4), np.nan if scenario.contact.friction < 0.2 else scenario.contact.friction)

    monkeypatch.setattr(validate, "steady_displacements", moved)
    told = []
    scan = validate.scan_friction(load(), [], SPEEDS, lambda *step: told.append(step))
    assert scan.friction.min() == pytest.approx(0.2) and scan.friction.max() == pytest.approx(0.6)
    np.testing.assert_allclose(scan.outwards_mm, np.broadcast_to(scan.friction[:, None, None], (17, 3, 4)))
    assert told[-1] == (23, 23)


def verdict(**values):
    """Names of the criteria that are not met and of those of them that count."""
    given = {"nominal": GOOD, "identified": GOOD, "leading_mm": 0.1, "balance_kn": 0.01, **values}
    missed = [row for row in validate.judge(CRITERIA, **given) if not row[4]]
    return [row[0] for row in missed], [row[0] for row in missed if row[5]]


def test_all_met():
    assert verdict() == ([], [])


@pytest.mark.parametrize(
    "values, name",
    [
        ({"nominal": {**GOOD, "rms_simulink_mm": 0.901}}, "nominal, rms from Simulink"),
        ({"nominal": {**GOOD, "rms_adams_mm": 0.901}}, "nominal, rms from ADAMS"),
        ({"nominal": {**GOOD, "max_mm": 1.601}}, "nominal, largest of one cell"),
        ({"balance_kn": 0.201}, "force balances, largest error"),
        ({"nominal": {**GOOD, "max_mm": np.nan}}, "nominal, largest of one cell"),
    ],
)
def test_missed_criterion_that_counts(values, name):
    assert verdict(**values) == ([name], [name])


@pytest.mark.parametrize(
    "values, name",
    [
        ({"leading_mm": 0.401}, "nominal, largest of W1 and W3"),
        ({"identified": {**GOOD, "rms_simulink_mm": 0.451}}, "identified, rms from Simulink"),
        ({"identified": {**GOOD, "rms_adams_mm": 0.551}}, "identified, rms from ADAMS"),
        ({"identified": {**GOOD, "max_mm": 1.101}}, "identified, largest of one cell"),
    ],
)
def test_missed_criterion_that_is_only_shown(values, name):
    assert verdict(**values) == ([name], [])


def test_a_value_at_its_limit_is_met():
    at_limit = {"rms_simulink_mm": 0.9, "rms_adams_mm": 0.9, "max_mm": 1.6}
    assert verdict(nominal=at_limit, balance_kn=0.2, leading_mm=0.4) == ([], [])


def test_balance_error_is_the_largest_of_all():
    runs = [curving(), curving(y_outwards=np.full(4, -10.05e3)), curving(q_inner=np.full(4, 49.9e3))]
    assert validate.balance_error(runs) == pytest.approx(400.0)
    assert validate.balance_error(runs[:2]) == pytest.approx(200.0)


def test_no_lateral_force_at_the_speed_that_balances_the_cant():
    slope = np.arcsin(0.090 / 1.5)
    scenario = load().varied(run={"speed": float(np.sqrt(9.81 * np.tan(slope) * 1200.0))})
    mass = sum(body.mass for body in scenario.vehicle.bodies)
    lateral, vertical = expected_forces(scenario, final_stretch(scenario))
    assert lateral / mass == pytest.approx(0.0, abs=tol.STATICS)
    assert vertical == pytest.approx(mass * 9.81 / np.cos(slope))


def test_stretch_that_ends_a_run():
    right, left = final_stretch(load("curve-1200-45")), final_stretch(load("curve-300"))
    assert (right.curvature, right.cant, right.outwards) == pytest.approx((1 / 1200, 0.090, -1.0))
    assert (left.curvature, left.cant, left.outwards) == pytest.approx((-1 / 300, -0.150, 1.0))
