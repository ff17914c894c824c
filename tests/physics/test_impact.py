"""A wheelset dropped on frictionless rails: the normal force never pulls and an impact never gains energy."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from scipy.optimize import brentq

from railcli.kernels.recording import new_rows
from railcli.kernels.step import record

GRAVITY, STEP, SPEED = 9.81, 1e-5, 20.0
LAW = ("damping", "damping_rate_power", "damping_depth_power")
POSES = {  # lateral position [m], roll, yaw [rad]
    "centred": (0.0, 0.0, 0.0),
    "aside": (3e-3, 0.0, 0.0),
    "on the flange": (5.5e-3, 0.0, 0.0),
    "rolled and yawed": (-5e-3, 2e-3, 4e-3),
    "on both": (6e-3, -3e-3, 8e-3),
}


def drop(table, pose, seconds=0.2, fall=0.0, **param):
    """Drop from 6 mm, at first falling at `fall` [m/s]: normal forces, energy and vertical velocity at every step."""
    system = scenes.tuned(scenes.lone_wheelset(table, SPEED, step=STEP, friction=0.0), hold=0.0, **param)
    q = system.rest.copy()
    q[0] += 3.0, pose[0], -6e-3, pose[1], 0.0, pose[2]
    v = np.array([[SPEED, 0.0, fall, 0.0, -SPEED / table.settings.radius, 0.0]])
    data = scenes.data_at(system.model, q, v)
    rows = new_rows(system.model, round(seconds / STEP))
    count, status = record(system.model, data, rows, 1)
    assert (count, status) == (rows.time.size, 0)
    body = system.model.body[0]
    motion = 0.5 * body["mass"] * np.sum(rows.v[:, 0, :3] ** 2, axis=1)
    motion += 0.5 * np.sum(body["inertia"] * rows.v[:, 0, 3:] ** 2, axis=1)
    return rows.contact["normal"], motion - body["mass"] * GRAVITY * rows.q[:, 0, 2], rows.v[:, 0, 2]


def flights(normal, values):
    """Values within each stretch of time in which no wheel touches."""
    flying = (normal == 0.0).all(axis=(1, 2))
    cuts = np.flatnonzero(np.diff(flying)) + 1
    return [part for part, free in zip(np.split(values, cuts), np.split(flying, cuts), strict=True) if free[0]]


@pytest.mark.parametrize("law", [(2.0, 1.0, 1.5), (0.02, 1.5, 1.0)], ids=["Hunt-Crossley", "other powers"])
@pytest.mark.parametrize("pose", POSES.values(), ids=POSES)
def test_impacts_only_lose_energy(table, pose, law):
    """Each flight has less energy than the one before, and keeps it to rounding; forces only push."""
    normal, energy, _ = drop(table, pose, **dict(zip(LAW, law, strict=True)))
    assert (normal >= 0.0).all()
    parts = flights(normal, energy)
    assert len(parts) >= 3
    assert max(np.ptp(part) for part in parts) < tol.FLIGHT
    assert (np.diff([part[0] for part in parts]) < -tol.FLIGHT).all()


def test_without_damping_a_centred_wheelset_rebounds_to_its_height(table):
    normal, energy, _ = drop(table, POSES["centred"], damping=0.0)
    levels = np.array([part[0] for part in flights(normal, energy)])
    fallen = 2000.0 * GRAVITY * 6e-3
    assert np.abs(levels - levels[0]).max() < tol.REBOUND * fallen


@pytest.mark.parametrize("damping", [0.2, 1.0])
def test_rebound_of_hunt_and_crossley(table, damping):
    """N = k d^1.5 (1 + c v): v / c - ln(1 + c v) / c^2 is the same before and after, whatever k; no weight."""
    normal, _, velocity = drop(table, POSES["centred"], 0.1, fall=0.35, gravity=0.0, damping=damping)
    before, after = (part[index] for part, index in zip(flights(normal, velocity)[:2], (-1, 0), strict=True))

    def level(v):
        return v / damping - np.log1p(damping * v) / damping**2

    expected = brentq(lambda v: level(v) - level(before), -before, -1e-6)
    assert after == pytest.approx(expected, rel=tol.RESTITUTION)
