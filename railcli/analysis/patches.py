"""Contact patches of a wheelset that stands on its rails under load (theory.md section 6).

The law of the step at directly found contact points: for `hertz` penetration, elastic force of each minimum with
overlapping patches merged, Hertz's ellipse; for `overlap` the strips that bear. Friction is left out; whatever holds
the wheelset at its lateral position does so without bearing weight.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from railcli.errors import InputError
from railcli.kernels.contact import PART, elastic_share
from railcli.kernels.difference import BARRIER_CAP
from railcli.kernels.hertz import pressure
from railcli.kernels.layout import NODE_CHANNELS, Node, Region
from railcli.kernels.tabulate import describe

from .build_table import wheel_regions
from .certify import direct_minima
from .overlap import Law
from .rigid_contact import fine_stations, level_out, on_rail, wheel_pose

DEPTH_ACCURACY = 1e-13  # [m]
STRIP_ACCURACY = 1e-9  # where strips bear [m]
TOO_HEAVY = (
    "at y = {:g} mm a load of {:g} kN would press a wheel in by more than {:g} mm; give a smaller load"
)  # fmt: skip
OUTLINE = 120  # points around an ellipse; a multiple of four, so that its vertices are among them


@dataclass(frozen=True)
class Patch:
    """One loaded contact.

    Attributes
    ----------
    side : str
        Wheel, "right" or "left".
    on_wheel, on_rail : float
        Profile coordinates to the field side: from the tape circle, and in the axes of the inclined rail [m].
    angle : float
        Contact angle, positive when the normal leans to the flange [rad].
    radius : float
        Rolling radius [m].
    region : str
        Part of the wheel profile: "tread", "root", "flank" or "tip".
    normal : float
        Force along the contact's normal [N].
    approach : float
        Of the two bodies along the normal, that belongs to this force alone; of strips the greatest overlap [m].
    pressure : float
        Its greatest value [Pa].
    area : float
        [m^2]
    outline : array (n, 2)
        Closed polygon in the contact plane about the contact point: forward, and to the field side [m].
    """

    side: str
    on_wheel: float
    on_rail: float
    angle: float
    radius: float
    region: str
    normal: float
    approach: float
    pressure: float
    area: float
    outline: np.ndarray

    @property
    def half_length(self):
        """Half of its extent in the rolling direction; the semi-axis a of an ellipse [m]."""
        return 0.5 * float(np.ptp(self.outline[:, 0]))

    @property
    def half_width(self):
        """Half of its extent across the rail; the semi-axis b of an ellipse [m]."""
        return 0.5 * float(np.ptp(self.outline[:, 1]))


@dataclass(frozen=True)
class Standing:
    """A loaded wheelset at one lateral position.

    Attributes
    ----------
    y : float
        Of its centre, to the right [m].
    roll : float
        [rad]
    patches : tuple of Patch
        Of the right wheel, then of the left one, each from the flange to the field side.
    """

    y: float
    roll: float
    patches: tuple

    def of(self, side):
        """Patches of one wheel."""
        return [patch for patch in self.patches if patch.side == side]


def standing(wheelset, load, young, poisson, with_roll=False, yaw=0.0, normal="hertz"):
    """How a wheelset stands under a vertical load as a function of its lateral position.

    Parameters
    ----------
    wheelset : Wheelset
    load : float
        Vertical component of the normal forces of each wheel [N].
    young, poisson : float
        Of wheels and rails [Pa], [-].
    with_roll : bool
        Roll the wheelset until each wheel bears this load; else each level wheel is pressed on for itself.
    yaw : float
        [rad]
    normal : {"hertz", "overlap"}
        Law of the normal force.

    Returns
    -------
    callable
        Gives the Standing for y [m].
    """
    kind = {"hertz": _OnPoints, "overlap": _OnStrips}[normal]
    wheels = [kind(mounting, young, poisson) for mounting in wheelset.mountings]

    def bearing(k, y, roll):
        pose, below = wheel_pose(wheelset, k, y, roll, yaw)
        depth, patches = wheels[k].under(load, pose, y)
        return below - depth, patches

    roll_at = level_out(lambda y, roll: bearing(0, y, roll)[0] - bearing(1, y, roll)[0])

    def stand(y):
        roll = roll_at(y) if with_roll else 0.0
        patches = [patch for k, side in enumerate(("right", "left")) for patch in bearing(k, y, roll)[1](side)]
        return Standing(y, roll, tuple(patches))

    return stand


class _OnPoints:
    """A wheel that bears by Hertz's law at its contact points."""

    def __init__(self, mounting, young, poisson):
        self.mounting = mounting
        self.given = mounting, fine_stations(mounting), wheel_regions(mounting), young, poisson

    def under(self, load, pose, y):
        """Height at which it bears a vertical load [m], and a function of the name of its side: its patches."""
        minimum = _described(*self.given, pose)
        depth = _sunk(minimum, load, y)

        def patches(side):
            rows, elastic = _loaded(minimum, depth)
            shares = zip(rows, elastic, strict=True)
            return [_patch(side, self.mounting, pose, row, share) for row, share in shares if share > 0.0]

        return depth, patches


class _OnStrips:
    """A wheel that bears by the law of strips."""

    def __init__(self, mounting, young, poisson):
        self.mounting, self.law, self.regions = mounting, Law(mounting, young, poisson), wheel_regions(mounting)

    def under(self, load, pose, y):
        """As `_OnPoints.under`."""
        minima = direct_minima(self.mounting, (pose[0], pose[1], abs(pose[2])), self.law.stations)
        touch = minima[:, 1].min()

        def excess(depth):
            return self.law(pose[0], depth, pose[1], abs(pose[2]), minima).gradient[1] - load

        if excess(touch + BARRIER_CAP) < 0.0:
            raise InputError("contact patches", TOO_HEAVY.format(y * 1e3, load / 1e3, BARRIER_CAP * 1e3))
        depth = brentq(excess, touch, touch + BARRIER_CAP, xtol=STRIP_ACCURACY)
        return depth, lambda side: self._patches(side, self.law(pose[0], depth, pose[1], abs(pose[2]), minima))

    def _patches(self, side, bearing):
        strips, loads = self.law.strips.strip, bearing.line_load
        on = np.flatnonzero(loads > 0.0)
        return [
            self._patch(side, strips[run], bearing.overlap[run], loads[run])
            for run in np.split(on, np.flatnonzero(np.diff(on) > 1) + 1)
        ]

    def _patch(self, side, strips, rows, line_load):
        load, half = line_load * strips["width"], rows["half"]
        share = load / load.sum()
        force = np.array([load @ rows["by_y"], load @ rows["by_z"]])
        on_wheel = float(share @ rows["lateral"])
        ahead, arc = float(share @ rows["ahead"]), float(share @ strips["arc"])
        edge = np.concatenate([[strips["arc"][0] - 0.5 * strips["width"][0]], strips["arc"],
                               [strips["arc"][-1] + 0.5 * strips["width"][-1]]]) - arc  # fmt: skip
        middle = np.interp(edge + arc, strips["arc"], rows["ahead"]) - ahead
        out = np.concatenate([[0.0], half, [0.0]])
        return Patch(
            side=side,
            on_wheel=on_wheel,
            on_rail=float(share @ strips["y"]),
            angle=float(np.arctan2(force[0], force[1])),
            radius=float(share @ rows["radius"]),
            region=Region(3 - int(np.searchsorted(self.regions, on_wheel, side="right"))).name.lower(),
            normal=float(np.hypot(*force)),
            approach=float(rows["h"].max()),
            pressure=float((2.0 * line_load / (math.pi * half)).max()),
            area=float(np.sum(2.0 * half * strips["width"])),
            outline=np.column_stack([np.r_[middle + out, (middle - out)[::-1]], np.r_[edge, edge[::-1]]]),
        )


def _described(mounting, station, regions, young, poisson, pose):
    """Minima of one pose with their Hertz factors: rows of a contact table."""
    found = direct_minima(mounting, pose, station)
    if found.shape[0] == 0:
        raise InputError("contact patches", f"at y = {pose[0] * 1e3:g} mm no part of the wheel touches the rail")
    minimum = np.zeros((found.shape[0], NODE_CHANNELS))
    for row, place in zip(minimum, found, strict=True):
        describe(place[0], *pose, *mounting.kernel_arguments, young, poisson, regions, row)
        row[Node.BARRIER_GAUGE], row[Node.BARRIER_FIELD] = np.minimum(place[2:4], BARRIER_CAP)
    return minimum


def _cosine(rows):
    return 1.0 / np.sqrt(1.0 + rows[:, Node.SLOPE] ** 2)


def _loaded(minimum, depth):
    """Minima that are penetrated with the wheel at `depth` [m], and their elastic force over the Hertz factor."""
    rows = minimum[minimum[:, Node.GAP] < depth].copy()
    rows[:, Node.GAP] = depth - rows[:, Node.GAP]
    rows[:, PART] = 1.0
    shares = [elastic_share(rows, len(rows), j, cosine) for j, cosine in enumerate(_cosine(rows))]
    return rows, np.array(shares)


def _sunk(minimum, load, y):
    """Height of the wheel's reference point at which it bears a vertical load [m]."""

    def excess(depth):
        rows, elastic = _loaded(minimum, depth)
        return float(np.sum(rows[:, Node.HERTZ] * elastic * _cosine(rows))) - load

    touch = minimum[:, Node.GAP].min()
    if excess(touch + BARRIER_CAP) < 0.0:
        raise InputError("contact patches", TOO_HEAVY.format(y * 1e3, load / 1e3, BARRIER_CAP * 1e3))
    return brentq(excess, touch, touch + BARRIER_CAP, xtol=DEPTH_ACCURACY)


def _patch(side, mounting, pose, row, elastic):
    approach = elastic ** (2.0 / 3.0)
    a, b = row[Node.SEMI_X] * math.sqrt(approach), row[Node.SEMI_Y] * math.sqrt(approach)
    normal = row[Node.HERTZ] * elastic
    return Patch(
        side=side,
        on_wheel=float(row[Node.LATERAL]),
        on_rail=float(on_rail(mounting, pose, row[Node.LATERAL])),
        angle=float(-np.arctan(row[Node.SLOPE])),
        radius=float(row[Node.RADIUS]),
        region=Region(round(row[Node.REGION])).name.lower(),
        normal=float(normal),
        approach=float(approach),
        pressure=pressure(normal, a, b),
        area=math.pi * a * b,
        outline=ellipse_outline(a, b),
    )


def ellipse_outline(a, b):
    """Polygon (OUTLINE, 2) of an ellipse with the semi-axes a forward and b across [m]."""
    turn = np.linspace(0.0, 2.0 * math.pi, OUTLINE, endpoint=False)
    return np.column_stack([a * np.cos(turn), b * np.sin(turn)])
