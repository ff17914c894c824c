"""Rolling radius difference of a rigid wheelset and its equivalent conicity (docs/conicity.md).

Method of EN 15302 and UIC 519: point contact of rigid profiles, kinematic motion y'' = -delta_r(y) / (e r0), and the
cone whose motion has the same wavelength.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from .build_table import wheel_regions
from .rigid_contact import COLUMNS, Wheelset, contact_at

GRID = 0.05e-3  # lateral positions to begin with [m]
MOVE = 0.2e-3  # of a contact on its wheel between two lateral positions, beyond which one is put between them [m]
CHORD = 0.1e-6  # the same for delta-r in the middle of two against their mean [m]
JUMP_WIDTH = 1e-9  # a jump is located to this in y [m]
GAUSS = 4  # points per interval of the quadrature
CENTRES = 401  # trial centres of a swing; of several the one nearest to the middle of the track is taken
ROUNDING = 1e-12  # of the lateral potential, relative


@dataclass(frozen=True)
class Rolling:
    """Contact of a rigid wheelset over its lateral position, exact jumps included.

    Attributes
    ----------
    wheelset : Wheelset
    y : array (n,)
        Lateral position of the wheelset to the right, growing; two within JUMP_WIDTH enclose a jump [m].
    values : dict of arrays (n,)
        COLUMNS: contact on wheel and rail in their profile axes to the field side [m], contact angle to the flange
        [rad], rolling radius [m], roll [rad].
    """

    wheelset: Wheelset
    y: np.ndarray
    values: dict

    @property
    def radius_difference(self):
        """delta-r: rolling radius of the right less that of the left wheel [m]."""
        return self.values["r_right"] - self.values["r_left"]

    @property
    def angle_difference(self):
        """Delta-tan-gamma: slope of the right contact plane less that of the left [-]."""
        return np.tan(self.values["angle_right"]) - np.tan(self.values["angle_left"])

    @property
    def jumps(self):
        """Indices i where the contact jumps between y[i] and y[i + 1]."""
        move = np.maximum(*(np.abs(np.diff(self.values[f"s_{side}"])) for side in ("right", "left")))
        return np.flatnonzero((np.diff(self.y) <= JUMP_WIDTH) & (move > MOVE))

    @property
    def clearance(self):
        """Lateral positions to the left (negative) and right where a flank first touches [m]; else infinite."""
        touching = [
            self.values[f"s_{side}"] < wheel_regions(mounting)[1]
            for side, mounting in (("right", self.wheelset.right), ("left", self.wheelset.left))
        ]
        places = self.y[np.any(touching, axis=0)]
        return (
            float(places[places < 0.0].max(initial=-math.inf)),
            float(places[places >= 0.0].min(initial=math.inf)),
        )

    def reaches_flank(self, motion):
        """True when a Swing goes as far as a flank."""
        left, right = self.clearance
        return motion.centre - motion.amplitude <= left or motion.centre + motion.amplitude >= right


def rolling(wheelset, reach, with_roll=False, progress=None, yaw=0.0):
    """Follow the contacts of a rigid wheelset over its lateral position.

    Every position is a direct search along the closed-form contact locus. Between two positions more are put until
    delta-r runs straight within CHORD and no contact moves by more than MOVE; what is then still steeper than that over
    JUMP_WIDTH is a jump.

    Parameters
    ----------
    wheelset : Wheelset
    reach : float
        Largest lateral position, to both sides [m].
    with_roll : bool
        Roll the wheelset until both wheels touch; without, it stays level, as EN 15302 neglects its roll.
    progress : callable, optional
        Called with the share done, 0 ... 1.
    yaw : float
        [rad]

    Returns
    -------
    Rolling
    """
    contact = contact_at(wheelset, with_roll, yaw)
    start = 0.0 if wheelset.alike else -reach
    grid = np.linspace(start, reach, max(2, round((reach - start) / GRID) + 1))
    rows = [(grid[0], contact(grid[0]))]
    for i in range(1, grid.size):
        _between(contact, rows, (grid[i], contact(grid[i])))
        if progress:
            progress(i / (grid.size - 1))
    y = np.array([row[0] for row in rows])
    values = dict(zip(COLUMNS, np.array([row[1] for row in rows]).T, strict=True))
    if wheelset.alike:
        y, values = _mirrored(y, values)
    return Rolling(wheelset, y, values)


def _between(contact, rows, last):
    """Append positions up to `last`, halving each interval until it is straight or narrower than a jump."""
    ahead = [last]
    while ahead:
        (low, before), (high, after) = rows[-1], ahead[-1]
        if high - low <= JUMP_WIDTH:
            rows.append(ahead.pop())
            continue
        middle = 0.5 * (low + high)
        value = contact(middle)
        moved = max(abs(after[0] - before[0]), abs(after[1] - before[1]))
        bend = (value[6] - value[7]) - 0.5 * (before[6] - before[7] + after[6] - after[7])
        if moved <= MOVE and abs(bend) <= CHORD:
            rows += [(middle, value), ahead.pop()]
        else:
            ahead.append((middle, value))


def _mirrored(y, values):
    """Both halves from that with y >= 0 of a wheelset with like sides."""
    other = {
        key: values[key.replace("right", "#").replace("left", "right").replace("#", "left")] for key in COLUMNS[:-1]
    }
    other["roll"] = -values["roll"]
    return (
        np.concatenate([-y[:0:-1], y]),
        {key: np.concatenate([other[key][:0:-1], values[key]]) for key in COLUMNS},
    )


@dataclass(frozen=True)
class Swing:
    """Kinematic motion of one amplitude.

    Attributes
    ----------
    amplitude : float
        Half of the distance of its turning points [m].
    centre : float
        Their middle [m].
    wavelength : float
        [m]; infinite when nothing drives the wheelset back, NaN when there is no such motion.
    conicity : float
        tan gamma_e [-]; NaN when there is no such motion.
    linearised : float
        tan gamma_e by harmonic linearisation: the cone whose delta-r has the same first harmonic over this swing [-].
    """

    amplitude: float
    centre: float
    wavelength: float
    conicity: float
    linearised: float


def sweep(y, centre, amplitude):
    """Quadrature over half a sine from centre - amplitude to centre + amplitude, split at the given positions.

    Parameters
    ----------
    y : array (n,)
        Positions between which a function is smooth, growing [m].
    centre, amplitude : float
        [m]

    Returns
    -------
    angle, weight : arrays (m, GAUSS)
        Phase of the sine, -pi/2 ... pi/2 [rad], and weights whose sum is pi.
    """
    inner = y[(y > centre - amplitude + JUMP_WIDTH) & (y < centre + amplitude - JUMP_WIDTH)]
    theta = np.arcsin(np.clip((inner - centre) / amplitude, -1.0, 1.0))
    theta = np.concatenate([[-0.5 * math.pi], theta, [0.5 * math.pi]])
    point, weight = np.polynomial.legendre.leggauss(GAUSS)
    half = 0.5 * np.diff(theta)[:, None]
    return theta[:-1, None] + half * (1.0 + point), half * weight


def swing(y, difference, base, radius, amplitude):
    """Equivalent conicity of a delta-r function at one amplitude, as an exact quadrature.

    y'' = -delta_r / (e r0) keeps y'^2 / 2 + U(y) / (e r0) with U the integral of delta_r, so the wavelength is the
    integral of dy / y' over a swing and back. delta_r is taken as straight between the given positions (jumps are steep
    intervals), U then is exact; y = centre + amplitude sin(theta) takes the roots at both ends out of the integral.

    Parameters
    ----------
    y, difference : array (n,)
        Lateral position, growing, and delta-r [m].
    base, radius : float
        e and r0 [m].
    amplitude : float
        [m]

    Returns
    -------
    Swing
    """
    slope = np.diff(difference) / np.diff(y)
    steps = 0.5 * (difference[1:] + difference[:-1]) * np.diff(y)
    integral = np.concatenate([[0.0], np.cumsum(steps)])

    def potential(at):
        i = np.clip(np.searchsorted(y, at, side="right") - 1, 0, y.size - 2)
        eta = at - y[i]
        return integral[i] + eta * (difference[i] + 0.5 * slope[i] * eta)

    def uneven(middle):
        return potential(middle + amplitude) - potential(middle - amplitude)

    none = Swing(amplitude, math.nan, math.nan, math.nan, math.nan)
    room = min(y[-1] - amplitude, -amplitude - y[0])
    noise = ROUNDING * np.ptp(integral)
    if room < -JUMP_WIDTH:
        return none
    centre = 0.0
    if abs(uneven(0.0)) > noise:
        place = np.linspace(-room, room, CENTRES)
        value = uneven(place)
        found = np.flatnonzero((value[:-1] < 0.0) & (value[1:] >= 0.0))
        if found.size == 0:
            return none
        k = found[np.argmin(np.abs(place[found] + place[found + 1]))]
        centre = brentq(uneven, place[k], place[k + 1], xtol=1e-12)
    low, high = centre - amplitude, centre + amplitude
    angle, weight = sweep(y, centre, amplitude)
    at = centre + amplitude * np.sin(angle)
    harmonic = np.sum(weight * np.interp(at, y, difference) * np.sin(angle)) / (math.pi * amplitude)
    drop = max(potential(low), potential(high)) - potential(at)
    if np.abs(drop).max() <= noise:
        return Swing(amplitude, centre, math.inf, 0.0, float(harmonic))
    if drop.min() <= 0.0:
        return Swing(amplitude, centre, math.nan, math.nan, float(harmonic))
    rate = np.sqrt(2.0 * drop / (base * radius))
    wavelength = 2.0 * np.sum(weight * amplitude * np.cos(angle) / rate)
    conicity = 0.5 * base * radius * (2.0 * math.pi / wavelength) ** 2
    return Swing(amplitude, float(centre), float(wavelength), float(conicity), float(harmonic))


def conicity(contact, amplitudes):
    """Equivalent conicity over amplitude.

    Parameters
    ----------
    contact : Rolling
    amplitudes : sequence of float
        [m]

    Returns
    -------
    list of Swing
    """
    wheelset = contact.wheelset
    return [
        swing(contact.y, contact.radius_difference, wheelset.base, wheelset.radius, amplitude)
        for amplitude in amplitudes
    ]


@dataclass(frozen=True)
class Steering:
    """Whether a free wheelset can roll radially in a curve.

    Attributes
    ----------
    curve : float
        Radius R [m].
    needed : float
        delta-r with which both wheels roll without slip, e r0 / R [m].
    outwards : float
        Smallest lateral displacement that gives it before the flank touches [m]; NaN if none does.
    index : float
        `needed` over the largest delta-r before the flank touches: as well the conicity of a cone that steers over that
        of one that gives as much as this wheelset; above 1 it slips [-].
    """

    curve: float
    needed: float
    outwards: float
    index: float


def steering(contact, curves):
    """Radial steering of a wheelset in curves, outwards to the right.

    Parameters
    ----------
    contact : Rolling
    curves : sequence of float
        Radii [m].

    Returns
    -------
    list of Steering
    """
    wheelset = contact.wheelset
    free = (contact.y >= 0.0) & (contact.y < contact.clearance[1])
    y, difference = contact.y[free], contact.radius_difference[free]
    rows = []
    for curve in curves:
        needed = wheelset.base * wheelset.radius / curve
        enough = y[difference >= needed]
        index = needed / difference.max() if difference.max() > 0.0 else math.inf
        rows.append(Steering(curve, needed, float(enough[0]) if enough.size else math.nan, float(index)))
    return rows
