"""A rigid wheelset on two rigid rails: where its wheels touch when both do (theory.md section 4)."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from railcli.errors import InputError
from railcli.kernels.contact import enter
from railcli.kernels.difference import locus, wheel_axes

from .build_table import stations
from .certify import direct_contacts

LARGEST_ROLL = 0.05  # [rad]
ROLL_ACCURACY = 1e-12  # [rad]
SIDES = (1.0, -1.0)  # right, left


@dataclass(frozen=True)
class RigidContact:
    """Contact of both wheels over the lateral position of the wheelset; last axis: right, left wheel.

    Attributes
    ----------
    y : array (n,)
        Lateral position of the wheelset's centre, to the right [m].
    roll : array (n,)
        Roll at which both wheels touch [rad].
    on_wheel, on_rail : array (n, 2)
        Profile coordinates of the contact, to the field side: from the tape circle, and in the axes of the inclined
        rail [m].
    angle : array (n, 2)
        Contact angle, positive when the normal leans to the flange [rad].
    radius : array (n, 2)
        Rolling radius [m].
    """

    y: np.ndarray
    roll: np.ndarray
    on_wheel: np.ndarray
    on_rail: np.ndarray
    angle: np.ndarray
    radius: np.ndarray

    @property
    def radius_difference(self):
        """Rolling radius of the right less that of the left wheel [m]."""
        return self.radius[:, 0] - self.radius[:, 1]


def rigid_contact(mounting, lateral, y, yaw=0.0):
    """Roll a wheelset until both wheels touch, for every lateral position; by direct minimisation, without a table.

    Parameters
    ----------
    mounting : Mounting
        Of the right-hand wheel; the left one is its mirror image.
    lateral : float
        Distance of the tape circles from the middle of the wheelset [m].
    y : array_like (n,)
        Lateral positions of the wheelset's centre [m].
    yaw : float
        [rad]

    Returns
    -------
    RigidContact
    """
    station = stations(mounting)

    def deepest(side, at, roll):
        """Pose of one wheel in its own axes, how far its contact lies under the wheelset's centre, and the contact."""
        across, depth = enter(side, lateral, mounting.radius, at, 0.0, math.sin(roll), math.cos(roll), math.cos(yaw))
        pose = (across, side * roll, abs(yaw))
        contacts = direct_contacts(mounting, pose, station)
        contact = contacts[np.argmin(contacts[:, 1])]
        return pose, depth - contact[1], contact

    def apart(roll, at):
        return deepest(1.0, at, roll)[1] - deepest(-1.0, at, roll)[1]

    y = np.atleast_1d(np.asarray(y, dtype=float))
    result = RigidContact(y, np.empty(y.size), *(np.empty((y.size, 2)) for _ in range(4)))
    for i, at in enumerate(y):
        if not apart(-LARGEST_ROLL, at) < 0.0 < apart(LARGEST_ROLL, at):
            raise InputError("contact geometry", f"at y = {at * 1e3:g} mm no roll lets both wheels touch")
        result.roll[i] = roll = brentq(apart, -LARGEST_ROLL, LARGEST_ROLL, args=(at,), xtol=ROLL_ACCURACY)
        for k, side in enumerate(SIDES):
            pose, _, (s, _, angle, radius, _) = deepest(side, at, roll)
            across = locus(s, *wheel_axes(*pose[1:]), mounting.radius, *mounting.kernel_arguments[2:5])[0]
            result.on_wheel[i, k], result.on_rail[i, k] = s, pose[0] + mounting.seat + across
            result.angle[i, k], result.radius[i, k] = angle, radius
    return result
