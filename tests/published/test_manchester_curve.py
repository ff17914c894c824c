"""The Manchester wagon in the published curve of 1200 m against the Simulink and ADAMS models of Malvezzi et al.

Displacements in mm towards the outer rail, rows for 45, 30 and 15 m/s. Docs: docs/validation.md.
"""

import numpy as np
import pytest
import tolerances as tol

from railcli.analysis import validate
from railcli.analysis.validate import READINGS, SUPPORTED, Scan
from railcli.files.benchmark import manchester_criteria, manchester_reference
from railcli.files.scenario import load

PRINTED = {  # table 1 of the paper: W1 ... W4 by Simulink, then by ADAMS
    45: [6.1, 3.1, 5.8, 3.0, 5.9, 3.2, 5.8, 3.1],
    30: [6.1, 4.5, 6.0, 4.7, 6.0, 4.7, 5.8, 4.8],
    15: [6.0, 6.0, 6.0, 6.3, 6.1, 6.2, 6.0, 6.3],
}
BY_HAND = {  # 44 482 kg times (V^2 / R cos - g sin, g cos + V^2 / R sin), sin = 0.06; outwards and down [N]
    45: (-48_746.0, 440_086.0),
    30: (-7_119.0, 437_584.0),
    15: (17_857.0, 436_083.0),
}
FEW_FRICTIONS = np.array([0.06, 0.075, 0.09, 0.1, 0.11, 0.125, 0.15, 0.2])  # around the minimum
TRAILING = list(validate.TRAILING)


@pytest.fixture(scope="module")
def reference():
    return manchester_reference()


@pytest.fixture(scope="module")
def criteria():
    return manchester_criteria()


@pytest.fixture(scope="module")
def scenario():
    return load("curve-1200-45")


@pytest.fixture(scope="module")
def nominal(scenario, table, reference):
    """Quasi-static displacements, friction 0.30."""
    return validate.steady_displacements(scenario, [table], reference.speeds)


@pytest.fixture(scope="module")
def runs(table):
    """Runs in time through the published curve."""
    return [validate.run_curve(load(f"curve-1200-{speed}"), [table]) for speed in PRINTED]


def test_reference_file_holds_the_printed_table(reference):
    assert reference.speeds == (45.0, 30.0, 15.0)
    np.testing.assert_array_equal(np.hstack([reference.simulink, reference.adams]), list(PRINTED.values()))


def test_nominal_meets_the_criteria(nominal, reference, criteria):
    found = validate.deviations(nominal, *reference.read(SUPPORTED))
    assert found["rms_simulink_mm"] <= criteria["nominal"]["rms_mm"]
    assert found["rms_adams_mm"] <= criteria["nominal"]["rms_mm"]
    assert found["max_mm"] <= criteria["nominal"]["max_mm"]


def test_leading_wheelsets_run_where_both_codes_have_them(nominal, reference, criteria):
    for code in reference.read(SUPPORTED):
        assert np.abs(nominal - code)[:, ::2].max() <= criteria["leading"]["max_mm"]


def test_supported_reading_is_the_nearest(nominal, reference):
    for code in range(2):
        rms = {reading: np.sqrt(np.mean((nominal - reference.read(reading)[code]) ** 2)) for reading in READINGS}
        assert min(rms, key=rms.get) == SUPPORTED


@pytest.mark.parametrize("friction", [0.1, 0.2, 0.3, 0.4, 0.5])
def test_trailing_wheelsets_move_inwards_as_speed_falls(scenario, table, reference, friction):
    """What the printed labels say otherwise, whatever friction is."""
    varied = scenario.varied(contact={"friction": friction})
    moved = validate.steady_displacements(varied, [table], reference.speeds)[:, TRAILING]
    assert (np.diff(moved, axis=0) < -0.5).all()


def test_friction_alone_meets_the_criteria_when_fitted(scenario, table, reference, criteria):
    def moved(friction):
        return validate.steady_displacements(scenario.varied(contact={"friction": friction}), [table], reference.speeds)

    supported = reference.read(SUPPORTED)
    scan = Scan(FEW_FRICTIONS, np.array([moved(friction) for friction in FEW_FRICTIONS]))
    best, low, high, at_bound = validate.identify_friction(scan, *supported)
    found = validate.deviations(moved(best), *supported)
    assert not at_bound and low < best < high
    assert found["rms_simulink_mm"] <= criteria["identified"]["rms_simulink_mm"]
    assert found["rms_adams_mm"] <= criteria["identified"]["rms_adams_mm"]
    assert found["max_mm"] <= criteria["identified"]["max_mm"]


def test_forces_balance(runs, criteria):
    limit = criteria["balance"]["force_kN"] * 1e3
    for run in runs:
        lateral, vertical = BY_HAND[run.speed]
        assert run.expected_y == pytest.approx(lateral, abs=tol.BALANCE_BY_HAND)
        assert run.expected_q == pytest.approx(vertical, abs=tol.BALANCE_BY_HAND)
        assert abs(run.sum_y - lateral) <= limit
        assert abs(run.sum_q - vertical) <= limit


def test_runs_settle_where_newton_puts_them(runs, nominal):
    np.testing.assert_allclose([run.outwards_mm for run in runs], nominal, atol=tol.SETTLED_RUN_MM)


def test_holding_the_speed_takes_a_few_hundred_newtons(runs):
    assert all(0.0 < run.hold < 500.0 for run in runs)


def test_wheelsets_held_where_they_run_need_no_force(scenario, table, reference, nominal):
    forces = validate.holding_forces(scenario, [table], reference.speeds, nominal)
    np.testing.assert_allclose(forces, 0.0, atol=tol.HELD_IN_PLACE)


def test_equal_displacements_at_15_m_per_s_need_a_hand_that_is_not_there(scenario, table, reference):
    """The row printed for 15 m/s: W2 pushed outwards by several tonnes, or no such motion; exchanged, by a few kN."""
    as_printed, exchanged = (np.mean(reference.read(reading), axis=0) for reading in ("as_printed", "exchanged"))
    slow = reference.speeds[-1:]
    weak = scenario.varied(contact={"friction": 0.1})
    for case in (scenario, weak):
        printed = validate.holding_forces(case, [table], slow, as_printed[-1:])
        assert (np.isnan(printed) | (printed > 20e3)).all()
        assert np.abs(validate.holding_forces(case, [table], slow, exchanged[-1:])).max() < 4e3
