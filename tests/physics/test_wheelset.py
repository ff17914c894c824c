"""One wheelset on its rails: what it keeps, and Klingel's motion."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import touching_depth
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record


def rolling(system, y, yaw=0.0, depth=0.06e-3):
    """Data of a wheelset that rolls from y, yawed, a little pressed into both rails."""
    data = system.start(0.0, y)
    data.q[0, 2] += touching_depth(system.model) + depth
    data.q[0, 5] = yaw
    return scenes.data_at(system.model, data.q, data.v)


@pytest.mark.parametrize("pose", [(0.0, 5e-3), (5.5e-3, 10e-3), (-5e-3, -8e-3)], ids=["tread", "right", "left"])
def test_frictionless_wheelset_keeps_its_spin(table, pose):
    """Every contact normal meets the axle: without friction a yawed wheelset spins on, sliding into its flanges."""
    system = scenes.tuned(scenes.lone_wheelset(table, 20.0, step=0.1e-3, friction=0.0), hold=0.0)
    data = rolling(system, *pose)
    spin = data.v[0, 4]
    scenes.run(system, data, 0.2)
    assert data.v[0, 4] == pytest.approx(spin, rel=tol.SPIN)
    assert np.abs(data.q[0, 1:4] - system.rest[0, 1:4]).max() > 1e-4


@pytest.mark.parametrize("angle", [0.01, 0.025])
def test_klingel_wavelength(angle):
    """A slow wheelset on cones swings with 2 pi sqrt(b r / tan(angle)), b half the distance of its contacts."""
    speed, step, stride = 5.0, 0.2e-3, 20
    table = scenes.cone_table(angle)
    track = scenes.Track((scenes.Straight(length=300.0),))
    system = scenes.lone_wheelset(table, speed, step=step, track=track)
    system = scenes.edited(system, "wheel", friction=50.0)
    rows = new_rows(system.model, round(100.0 / speed / step / stride))
    assert record(system.model, rolling(system, 1e-3), rows, stride) == (rows.time.size, 0)
    x, y = rows.q[:, 0, 0], rows.q[:, 0, 1]
    i = np.flatnonzero(y[:-1] * y[1:] < 0.0)
    waves = 2 * np.diff(x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i]))
    half = table.settings.lateral - scenes.HEAD * np.sin(angle)
    assert waves.size >= 2
    assert_allclose(waves, 2 * np.pi * np.sqrt(half * table.settings.radius / np.tan(angle)), rtol=tol.KLINGEL)


def test_cylinders_do_not_steer():
    """A centred wheelset with cylindrical wheels, once yawed, rolls straight on in that direction."""
    table = scenes.cone_table(0.0)
    system = scenes.edited(scenes.lone_wheelset(table, 5.0, step=0.2e-3), "wheel", friction=50.0)
    data = rolling(system, -2e-3, 1e-3)
    data.v[0, 1] = 5.0e-3
    start = data.q[0].copy()
    scenes.run(system, data, 0.6)
    moved = data.q[0] - start
    assert moved[1] / moved[0] == pytest.approx(np.tan(1e-3), rel=tol.STRAIGHT_ON)
    assert data.q[0, 5] == pytest.approx(1e-3, rel=tol.STRAIGHT_ON)
