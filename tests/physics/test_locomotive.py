"""The example locomotive: what it weighs, which way its motors drive, that they react on its frames."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import build_table
from railcli.analysis.equilibrium import static, steady
from railcli.kernels.layout import Kind

RADIUS, DRAG, TORQUE = 0.555, 60.0, 5000.0


@pytest.fixture(scope="module")
def locomotive(profiles):
    """On a small table of its own radius, in its curve."""
    table = build_table(*profiles, replace(scenes.SMALL, radius=RADIUS))[0]
    return scenes.wagon(table, "locomotive-curve-300", contact={"inclination": 20.0})


def pulling(system, torque):
    element = system.model.element.copy()
    element["preload"][element["kind"] == Kind.TORQUE, 0] = torque
    return scenes.replaced(system, element=element)


def test_it_weighs_84_t(locomotive):
    assert_allclose(static(locomotive).data.rail["q"], 84e3 * 9.81 / 8.0, atol=tol.WEIGHT)


def test_motors_drive_forwards_and_drag_resists(locomotive):
    """The force that holds the speed is the drawbar's: 4 (drag - torque) / r, but for the wheels' way to the rails."""
    for torque in (0.0, TORQUE):
        data = steady(pulling(locomotive, torque), 0.0, 0.0).data
        assert data.traction[0] == pytest.approx(4.0 * (DRAG - torque) / RADIUS, rel=tol.DRAWBAR)
        assert_allclose(data.rail["x"].sum(), 4.0 * (DRAG - torque) / RADIUS, rtol=tol.DRAWBAR)


def test_a_motor_turns_against_its_wheelset(locomotive):
    """Reaction of 5 kN m: the mounts of each motor give way, front up, all the same; nothing else turns so far."""
    names = list(locomotive.bodies)
    free, pulled = (steady(pulling(locomotive, torque), 0.0, 0.0).data.q[:, 4] for torque in (0.0, TORQUE))
    motors = [names.index(f"motor {n}") for n in range(1, 5)]
    turned = (pulled - free)[motors]
    along = np.array([0.3, 0.3, -0.5])  # mounts about their middle: a couple turns the motor about it
    stiffness = 15e6 * np.sum((along - along.mean()) ** 2)
    frame = (pulled - free)[[names.index(f"bogie {n}") for n in (1, 1, 2, 2)]]
    assert (turned > 0.0).all() and np.ptp(turned - frame) < 0.2 * turned.min()
    assert (turned - frame).mean() == pytest.approx(TORQUE / stiffness, rel=tol.DRAWBAR)
