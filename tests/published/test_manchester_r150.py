"""Steady curving at R = 150 m, by Newton's method, beside ADAMS/Rail and Universal Mechanism.

Source and reading of the table: benchmarks/curves/SOURCES.md, [R]. A value counts as met when it lies no further from
the nearer code than the codes lie apart at most in that quantity.
"""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol

from railcli.analysis.build_table import build_table
from railcli.analysis.curving_check import SPRING, UPPER_HEIGHT, curving, sprung_at
from railcli.files.curves_reference import curves_reference, curves_scenarios

OUTSIDE = {("Q outer", 2), ("Q inner", 2), ("Q outer", 4), ("Q inner", 4)}


@pytest.fixture(scope="module")
def codes():
    return curves_reference().codes


@pytest.fixture(scope="module")
def found(profiles, codes):
    """The curve with the secondary springs at their middle and at their upper end."""
    scenario = curves_scenarios({"creep_law": "table", "normal": "hertz"})[0]
    contact = scenario.contact
    settings = replace(scenes.SMALL, inclination=contact.inclination, gauge=contact.gauge, yaw_range=20e-3)
    table = build_table(*profiles, settings)[0]
    raised = scenario.varied(vehicle=sprung_at(scenario.vehicle, SPRING, UPPER_HEIGHT))
    return [curving(case, [table], codes) for case in (scenario, raised)]


def transfer(codes, values):
    """Wheel load that goes from the outer to the inner rail [kN]."""
    signs = [{"Q inner": 1.0, "Q outer": -1.0}.get(name, 0.0) for name in codes.quantity]
    return float(np.nansum(np.array(signs) * values))


def test_within_the_spread_of_both_codes(codes, found):
    """But for Q of the trailing wheelsets, whose load transfer the next test explains."""
    beyond = {}
    for key, values, ours in zip(
        zip(codes.quantity, codes.wheelset, strict=True), codes.values, found[0].values, strict=True
    ):
        away = np.nanmin(np.abs(values - ours))
        if away > codes.spread(key[0][0]) + tol.PRINTED_TENTH:
            beyond[key] = away
    assert set(beyond) == OUTSIDE
    assert max(beyond.values()) < tol.R150_TRAILING_Q


def test_total_load_transfer_is_that_of_springs_that_act_at_their_upper_end(codes, found):
    """With the secondary springs at 1.13 m in place of their middle, 0.8275 m: an idealisation no source defines."""
    printed = [transfer(codes, codes.values[:, k]) for k in (0, 1)]
    low, high = (transfer(codes, curve.values) for curve in found)
    assert low - max(printed) > 1.0
    assert high == pytest.approx(np.mean(printed), abs=tol.R150_TRANSFER)


def test_forces_balance_the_vehicle(found):
    for curve in found:
        assert curve.balance_error < tol.R150_BALANCE
