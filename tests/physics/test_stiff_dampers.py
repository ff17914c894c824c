"""Vehicles with elements far stiffer than an explicit step bears: runs against Newton's method, equilibria, restart."""

from pathlib import Path

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import TOLERANCE, static, steady
from railcli.analysis.simulate import settled_start
from railcli.files import toml
from railcli.files.scenario import load
from railcli.kernels.layout import new_data
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.sections import Curve, Straight, Transition
from railcli.model.system import assemble
from railcli.model.track import Track
from railcli.model.vehicle import Vehicle

DATA = Path(__file__).parents[1] / "data"
CURVE = Track((Straight(length=40.0), Transition(length=60.0, shape="bloss"),
               Curve(length=160.0, radius=400.0, hand="right", cant=0.06)))  # fmt: skip


def system_of(name, table, step):
    """A vehicle of the tests' data in the curve, every law as usual."""
    vehicle = toml.build(Vehicle, toml.read(DATA / name), name)
    case = load("curve-1200-45").varied(
        vehicle=vehicle, track=CURVE, contact={"creep_law": "table"},
        run={"speed": 20.0, "step": step, "output_interval": 10e-3, "average_over": 20.0, "distance": 230.0},
    )  # fmt: skip
    return assemble(case, [table])


@pytest.mark.parametrize("step", [0.25e-3, 0.5e-3])
def test_a_wagon_on_dampers_like_dry_friction(table, step):
    """6 kN at 1 mm/s on eight links, h c / m up to 2.3: sum Q is Newton's at every step, and does not alternate."""
    system = system_of("stiff_damper_wagon.toml", table, step)
    assert np.count_nonzero(system.model.element["stiff"] >= 0) >= 8
    balance = steady(system, 1.0 / 400.0, 0.06).data.rail["q"].sum()
    rows = new_rows(system.model, round(11.4 / step))
    assert record(system.model, settled_start(system), rows, 1) == (rows.time.size, 0)
    total = rows.rail["q"].sum(axis=1)[rows.time > 10.9]
    for interval in (1, 2, 7, 40):
        assert total[::interval].mean() == pytest.approx(balance, rel=tol.STIFF_DAMPER_BALANCE)
    change = np.diff(total)
    assert np.sum(change[1:] * change[:-1]) > -0.5 * np.sum(change**2) or np.abs(change).max() < 1.0


def test_restart_with_implicit_dampers_is_equal_to_the_bit(table):
    """Tensions are state: a run continued from its saved state is the one that was never interrupted."""
    system = system_of("stiff_damper_wagon.toml", table, 0.5e-3)
    data = settled_start(system, 3e-3)
    scenes.run(system, data, 0.5)
    again = new_data(system.model, data.q, data.damper.size)
    for name in ("q", "v", "dv", "damper", "tension", "clock", "held"):
        getattr(again, name)[:] = getattr(data, name)
    assert np.abs(data.tension).max() > 1.0
    for one in (data, again):
        scenes.run(system, one, 0.5)
    assert data.q.tobytes() == again.q.tobytes() and data.tension.tobytes() == again.tension.tobytes()


def test_very_stiff_bearings_have_an_equilibrium(table):
    """Six motors on nose bearings of 1e11 N/m: rounding of places alone makes 1e-7 m/s^2 there."""
    system = system_of("stiff_bearing_locomotive.toml", table, 0.5e-3)
    found = static(system)
    assert found.residual < TOLERANCE
    assert found.data.rail["q"].sum() == pytest.approx(9.81 * system.model.body["mass"].sum(), rel=tol.STIFF_BALANCE)
    assert_allclose(np.abs(found.data.dv[: system.model.body.size - 1]), 0.0, atol=1e-4)
