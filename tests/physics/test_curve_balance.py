"""Steady curving balances as a whole: force and moment in ground axes, and power.

A steady motion turns about the vertical axis through the centre of the curve at W = ds/dt / R and stays as it is
otherwise. So the momentum P and the angular momentum H of the whole vehicle turn at W, and no energy changes:

    W x P = sum of forces,    W x H + v_C x P = sum of moments about C,    0 = power of rails and traction

with C a point that goes along. Forces are weight, the patches' on the wheels, and the traction at the first body.
"""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.build_table import build_table
from railcli.analysis.equilibrium import steady

G, BASE = 9.81, 1.5
CURVES = {150.0: (0.10, 4.4), 300.0: (0.09, 16.0), 1200.0: (0.09, 45.0)}  # radius [m]: cant [m], speed [m/s]


class Curving:
    """A steady motion seen from the ground; every vector in ground axes."""

    def __init__(self, table, radius):
        cant, speed = CURVES[radius]
        system = scenes.wagon(table, "curve-300", run={"speed": speed}, contact={"creep_law": "table"})
        self.data = data = steady(system, 1.0 / radius, cant).data
        self.model, self.frame = system.model, data.frame
        self.mass, self.inertia = system.model.body["mass"], system.model.body["inertia"]
        sine = cant / BASE
        self.turn = np.array([0.0, sine, np.sqrt(1.0 - sine**2)]) / radius  # of the track frame, own axes [1/m]
        origin = self.frame[0]  # the middle of the track under the car body
        self.below = origin["position"] - origin["track"][:, 1:] @ data.q[0, 1:3]
        outwards = np.array([-origin["track"][1, 0], origin["track"][0, 0], 0.0])
        self.centre = self.below + radius * outwards
        self.rate = np.array([0.0, 0.0, data.rate[0, 0] / radius])  # W
        self.patches = [
            self.patch(w, data.contact[w, j])
            for w in range(self.model.wheel.size)
            for j in range(int(data.rail[w]["patches"]))
        ]

    def patch(self, w, contact):
        """Place, force on the wheel, its normal part, moment about the normal, slip velocity, turning."""
        frame = self.frame[self.model.wheel[w]["body"]]
        arm, cosine = contact["arm"], np.cos(np.arctan(contact["slope"]))
        normal = np.array([0.0, -contact["slope"] * cosine, cosine])
        along = np.array([1.0, self.turn[2] * arm[0], -self.turn[1] * arm[0]])
        across = np.cross(normal, along)
        creep = contact["creep_x"] * along + contact["creep_t"] * across
        axes = frame["track"]
        arm, normal, creep = axes @ arm, axes @ normal, axes @ creep
        velocity = frame["velocity"] + np.cross(frame["omega"], arm)
        speed = np.linalg.norm(frame["velocity"])
        return {
            "place": frame["position"] + arm,
            "creep": creep,
            "push": -contact["normal"] * normal,
            "moment": contact["spin_moment"] * normal,
            "velocity": velocity,
            "turning": frame["omega"],
            "dissipated": -speed * (contact["creep_x"] * contact["xi"] + contact["creep_t"] * contact["eta"]
                                    + contact["spin_moment"] * contact["phi"]),
        }  # fmt: skip

    @property
    def traction(self):
        return self.data.traction[0] * self.frame[0]["track"][:, 0]

    def momenta(self, about):
        """Momentum, and angular momentum about a point."""
        velocity = self.frame["velocity"]
        spin = np.einsum("bij,bj,bkj,bk->bi", self.frame["axes"], self.inertia, self.frame["axes"], self.frame["omega"])
        arm = self.frame["position"] - about
        return self.mass @ velocity, self.mass @ np.cross(arm, velocity) + spin.sum(axis=0)

    def loads(self, about):
        """Sum of forces, and of moments about a point."""
        acts = [(p["place"], p["creep"] + p["push"]) for p in self.patches]
        acts += [(body["position"], [0.0, 0.0, m * G]) for body, m in zip(self.frame, self.mass, strict=True)]
        acts.append((self.frame[0]["position"], self.traction))
        moment = sum(np.cross(place - about, force) for place, force in acts) + sum(p["moment"] for p in self.patches)
        return sum(np.array(force) for _, force in acts), moment


@pytest.fixture(scope="module")
def wide_table(profiles):
    """Over the yaw of 15 mrad that R = 150 m takes."""
    return build_table(*profiles, replace(scenes.SMALL, yaw_range=20e-3))[0]


@pytest.fixture(scope="module", params=CURVES, ids="R{:g}".format)
def curving(request, wide_table):
    return Curving(wide_table, request.param)


def test_forces_and_moments_in_ground_axes(curving):
    """About the middle of the track under the car body; load transfer, gyroscopic moments and all else are in it."""
    momentum, turning = curving.momenta(curving.below)
    moving = np.cross(curving.rate, curving.below - curving.centre)
    force, moment = curving.loads(curving.below)
    weight = curving.mass.sum() * G
    assert_allclose(force / weight, np.cross(curving.rate, momentum) / weight, rtol=0.0, atol=tol.GROUND_BALANCE)
    wanted = np.cross(curving.rate, turning) + np.cross(moving, momentum)
    assert_allclose(moment / weight, wanted / weight, rtol=0.0, atol=tol.GROUND_BALANCE)


def test_creep_takes_the_power_that_traction_gives(curving):
    """What creep forces and spin moments dissipate, and what little N does where the rail bends ahead of the axle."""
    given = curving.traction @ curving.frame[0]["velocity"]
    slid = -sum(p["creep"] @ p["velocity"] + p["moment"] @ p["turning"] for p in curving.patches)
    taken = sum(p["dissipated"] for p in curving.patches)
    pushed = sum(p["push"] @ p["velocity"] for p in curving.patches)
    assert given > 0.0
    assert slid == pytest.approx(taken, rel=tol.ROUNDING)
    assert taken - pushed == pytest.approx(given, rel=tol.POWER_BALANCE)
    assert taken == pytest.approx(given, rel=tol.BENT_RAIL_POWER)
