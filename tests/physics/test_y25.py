"""The Y25 freight wagon: what it weighs, that its friction slides and sticks, that the rails bear it all."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import static
from railcli.analysis.linear import linearise, modes
from railcli.analysis.simulate import settled_start
from railcli.analysis.steady_values import expected_forces, final_stretch
from railcli.files.scenario import load
from railcli.kernels.layout import Kind
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.sections import Straight
from railcli.model.track import Track

STEP = 0.5e-3
MASS = {"empty": 22200.0, "laden": 90200.0}
CASES = pytest.mark.parametrize("case", MASS)


def ran(system, duration):
    """Rows of a run at every step."""
    rows = new_rows(system.model, round(duration / STEP))
    count, status = record(system.model, settled_start(system), rows, 1)
    assert (count, status) == (rows.time.size, 0)
    return rows


@CASES
def test_it_weighs_what_its_name_says(table, case):
    """At rest all wheels carry the same, and every pusher may rub with 0.109 of what its axle box carries."""
    system = scenes.wagon(table, f"y25-{case}-curve-400", run={"step": STEP})
    rest = static(system).data
    assert_allclose(rest.rail["q"], MASS[case] * 9.81 / 8.0, atol=tol.WEIGHT)
    nests = (MASS[case] - 4 * 1400.0) * 9.81 / 8.0
    pushers = [row for row in system.model.element if row["kind"] == Kind.DRY and row["coefficient"] == 0.109]
    assert len(pushers) == 8
    assert_allclose(rest.carried[[row["source"] for row in pushers]], nests, atol=tol.WEIGHT)


@CASES
@pytest.mark.parametrize("interval", [1, 10, 20, 100])
def test_rails_bear_the_wagon(case, interval, curved):
    """Sum Q over the end of a curve, read at any interval: its mean is the balance, and it does not alternate."""
    scenario, rows = curved(case)
    at_end = rows.q[:, 0, 0] > scenario.distance - scenario.average_over
    total = rows.rail["q"].sum(axis=1)[at_end]
    _, balance = expected_forces(scenario, final_stretch(scenario))
    assert total[::interval].mean() == pytest.approx(balance, rel=tol.Y25_BALANCE)
    change = np.diff(total)
    assert np.sum(change[1:] * change[:-1]) > 0.0


@pytest.fixture(scope="module")
def curved(table):
    done = {}

    def run(case):
        if case not in done:
            name = f"y25-{case}-curve-400"
            scenario = load(name)
            done[case] = scenario, ran(scenes.wagon(table, name, run={"step": STEP}), scenario.duration)
        return done[case]

    return run


def test_it_remembers_its_curve(table):
    """On straight track again, the sum is the weight; left and right differ by what the pushers hold, no more.

    They rub 1 m beside the middle, the wheels roll 0.75 m beside it.
    """
    name = "y25-laden-curve-400"
    straight, transition, curve = load(name).track.sections
    sections = straight, transition, curve.model_copy(update={"length": 60.0}), transition, Straight(length=150.0)
    scenario = load(name).varied(track=Track(sections))
    system = scenes.wagon(table, name, run={"step": STEP})
    system = scenes.replaced(system, track=scenario.pieces())
    rows = ran(system, 18.0)
    q = rows.rail["q"][rows.q[:, 0, 0] > 350.0].mean(axis=0)
    assert q.sum() == pytest.approx(MASS["laden"] * 9.81, rel=tol.Y25_BALANCE)
    aside = 0.5 * np.abs(q[::2] - q[1::2])
    hold = 0.109 * (MASS["laden"] - 4 * 1400.0) * 9.81 / 8.0
    assert 1e3 < aside.max() < hold / 0.75


@CASES
def test_modes_are_those_of_sticking_friction(table, case):
    """No eigenvalue of a place that only stays: one motion is free, the running speed."""
    found = modes(linearise(scenes.wagon(table, f"y25-{case}-curve-400", run={"step": STEP})))
    assert found.free == 1
    assert found.value.real.max() < 0.0
