"""A rigid wheelset on two rigid rails: where its wheels touch, level or when both do (theory.md section 4)."""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from railcli.errors import InputError
from railcli.kernels.contact import enter
from railcli.kernels.difference import locus, wheel_axes
from railcli.model.contact_table import Mounting, mount

from .build_table import stations
from .certify import direct_contacts

STATION = 0.1e-3  # of the direct search along the contact locus [m]
LARGEST_ROLL = 0.05  # [rad]
NEAR_ROLL = 0.2e-3  # tried first about the last one found [rad]
ROLL_ACCURACY = 1e-12  # [rad]
SIDES = (1.0, -1.0)  # right, left

COLUMNS = ("s_right", "s_left", "rail_right", "rail_left", "angle_right", "angle_left", "r_right", "r_left", "roll")


@dataclass(frozen=True)
class Wheelset:
    """A wheelset over its track.

    Attributes
    ----------
    right, left : Mounting
        Each in the axes of a right-hand wheel; the same object when both sides are alike.
    lateral : float
        Distance of the tape circles from the middle of the wheelset [m].
    """

    right: Mounting
    left: Mounting
    lateral: float

    @property
    def base(self):
        """Distance e of the tape circles, which stands for that of the contact circles [m]."""
        return 2.0 * self.lateral

    @property
    def radius(self):
        """Mean radius r0 of the tape circles [m]."""
        return 0.5 * (self.right.radius + self.left.radius)

    @property
    def alike(self):
        return self.left is self.right

    @property
    def mountings(self):
        return self.right, self.left

    def pressed_in(self, depth):
        """The same wheelset with quasi-elastic contact points, the wheels pressed in by a depth [m]."""
        right = replace(self.right, pressed=depth)
        return replace(self, right=right, left=right if self.alike else replace(self.left, pressed=depth))


def wheelset_on(settings, wheel, rail, left_wheel=None, left_rail=None, left_radius=None):
    """Mount a wheelset over a track; what is not given on the left is as on the right.

    Parameters
    ----------
    settings : TableSettings
        Gauge, flange-back, inclination, radius.
    wheel, rail, left_wheel, left_rail : Profile
        All in the axes of right-hand profiles: y to the field side.
    left_radius : float
        [m]

    Returns
    -------
    Wheelset
    """
    right = mount(wheel, rail, settings)
    if left_wheel is None and left_rail is None and left_radius is None:
        return Wheelset(right, right, settings.lateral)
    radius = settings.radius if left_radius is None else left_radius
    left = mount(left_wheel or wheel, left_rail or rail, replace(settings, radius=radius))
    return Wheelset(right, left, settings.lateral)


def fine_stations(mounting):
    """Profile coordinates of a search that misses no basin wider than STATION [m]."""
    low, high = stations(mounting)[[0, -1]]
    return np.arange(low, high, STATION)


def wheel_pose(wheelset, k, y, roll, yaw):
    """Pose of wheel k (0 right, 1 left) in the axes of a right-hand one.

    Returns
    -------
    pose : tuple
        Lateral position about nominal [m], roll and yaw [rad]; contact geometry is even in yaw.
    below : float
        How far its reference point lies under the wheelset's centre [m].
    """
    side, mounting = SIDES[k], wheelset.mountings[k]
    across, below = enter(
        side, wheelset.lateral, mounting.radius, y, 0.0, math.sin(roll), math.cos(roll), math.cos(yaw)
    )
    return (across, side * roll, abs(yaw)), below


def on_rail(mounting, pose, s):
    """Lateral coordinate, in the axes of the inclined rail, of the point of a wheel that may touch at s [m]."""
    across = locus(s, *wheel_axes(*pose[1:]), mounting.radius, *mounting.kernel_arguments[2:5])[0]
    return pose[0] + mounting.seat + across


def level_out(apart):
    """Finder of the roll at which both wheels bear.

    Parameters
    ----------
    apart : callable
        Of y [m] and roll [rad]: how much higher the centre stands for the right wheel than for the left one [m]; it
        grows with roll.

    Returns
    -------
    callable
        Roll [rad] of y [m].
    """
    last = 0.0

    def roll_at(y):
        nonlocal last
        for low, high in ((last - NEAR_ROLL, last + NEAR_ROLL), (-LARGEST_ROLL, LARGEST_ROLL)):
            if apart(y, low) < 0.0 < apart(y, high):
                last = brentq(lambda roll: apart(y, roll), low, high, xtol=ROLL_ACCURACY)
                return last
        raise InputError("contact geometry", f"at y = {y * 1e3:g} mm no roll lets both wheels touch")

    return roll_at


def contact_at(wheelset, with_roll=False, yaw=0.0):
    """Deepest contact of both wheels as a function of the lateral position; a direct search, without a table.

    Parameters
    ----------
    wheelset : Wheelset
    with_roll : bool
        Roll the wheelset until both wheels touch; else each level wheel is for itself.
    yaw : float
        [rad]

    Returns
    -------
    callable
        Gives a tuple in the order of COLUMNS for y [m].
    """
    station = [fine_stations(mounting) for mounting in wheelset.mountings]

    @cache
    def touch(k, y, roll):
        pose, below = wheel_pose(wheelset, k, y, roll, yaw)
        found = direct_contacts(wheelset.mountings[k], pose, station[k])
        if found.shape[0] == 0:
            raise InputError("contact geometry", f"at y = {y * 1e3:g} mm no part of the wheel touches the rail")
        s, gap, angle, radius, _ = found[np.argmin(found[:, 1])]
        return s, on_rail(wheelset.mountings[k], pose, s), angle, radius, below - gap

    roll_at = level_out(lambda y, roll: touch(0, y, roll)[4] - touch(1, y, roll)[4])

    def contact(y):
        roll = roll_at(y) if with_roll else 0.0
        right, left = touch(0, y, roll), touch(1, y, roll)
        touch.cache_clear()
        return (*(value for pair in zip(right[:4], left[:4], strict=True) for value in pair), roll)

    return contact
