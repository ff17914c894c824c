"""The steady end of a run: means over its last metres, the balance of forces, and the steady motion that Newton finds.

Values are counted towards the outer rail; on straight track to the right.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from railcli.errors import SimulationError
from railcli.model.track import gradient_course

from .equilibrium import steady
from .parts import LEVEL_CANT, parts
from .vibration import Vibration

UNEVEN = 2e-3  # by which a measured gradient may vary where a motion counts as steady [rad]


@dataclass(frozen=True)
class Stretch:
    """Straight or curve in which a run ends, from before its averaging window begins.

    Attributes
    ----------
    kind : {"straight", "right-hand curve", "left-hand curve"}
    curvature, cant : float
        Signed as in the core: positive in a right-hand curve [1/m], left over right rail [m].
    gradient : float
        Rise over horizontal length [-].
    aside : pair of float
        How far left and right rail stand to the right of their nominal places, where the gauge is wider [m].
    """

    kind: str
    curvature: float
    cant: float
    gradient: float = 0.0
    aside: tuple = (0.0, 0.0)

    @property
    def outwards(self):
        """Sign that counts lateral values towards the outer rail."""
        return -1.0 if self.curvature > 0.0 else 1.0

    @property
    def outer_side(self):
        """Sign of the side of the outer rail, or of the right one on straight track: +1 right, -1 left."""
        return self.outwards


def final_stretch(scenario):
    """The Stretch in which the whole averaging window lies; None when the track or the speed changes there.

    In a measured alignment it lies in one of its straights or curves, and has the means over the window.
    """
    if scenario.final_speed is None:
        return None
    begin, end = scenario.distance - scenario.average_over, scenario.distance
    curvatures, uneven = set(), 0.0
    for start, section in scenario.track.located():
        if start < end and start + section.length > begin:
            if section.kind == "measured":
                curvatures.add(_measured_end(section, start, max(begin, start), min(end, start + section.length)))
                uneven = UNEVEN if section.gradient is not None else uneven
                continue
            constant = section.kind in ("straight", "curve")
            curvatures.add((section.curvature, section.signed_cant) if constant else None)
    s, angle = gradient_course(scenario.track, scenario.gradients)
    angles = np.interp([begin, *s[(s > begin) & (s < end)], end], s, angle)
    if len(curvatures) != 1 or None in curvatures or np.ptp(angles) > uneven:
        return None
    curvature, cant = curvatures.pop()
    kind = "straight" if curvature == 0.0 else "right-hand curve" if curvature > 0.0 else "left-hand curve"
    aside = scenario.track.shifts([0.5 * (begin + end)], scenario.contact.gauge)[:, 0]
    return Stretch(kind, curvature, cant, float(np.tan(angles.mean())), tuple(aside.tolist()))


def _measured_end(section, start, begin, end):
    """Mean curvature and cant between two places in one straight or curve of a measured section; else None."""
    inside = [part for part in parts(section, start) if part.start < end and part.end > begin]
    if len(inside) != 1 or inside[0].kind == "transition":
        return None
    at = np.array(section.position) - section.position[0] + start
    s = np.array([begin, *at[(at > begin) & (at < end)], end])
    cant = np.interp(s, at, section.column("cant"))
    if np.ptp(cant) > LEVEL_CANT:
        return None
    means = [np.trapezoid(np.interp(s, at, section.column(name)), s) / (end - begin) for name in ("curvature", "cant")]
    return (0.0 if inside[0].kind == "straight" else float(means[0])), float(means[1])


def weight_along(scenario, stretch):
    """Component of the vehicle's weight against the direction of travel on the stretch's gradient [N]."""
    mass = sum(body.mass for body in scenario.vehicle.bodies)
    return float(mass * scenario.run.gravity * np.sin(np.arctan(stretch.gradient)))


def expected_forces(scenario, stretch):
    """Sums of the lateral and vertical forces on the rails that balance the vehicle.

    Returns
    -------
    lateral : float
        In the track plane, counted outwards: m (V^2/R cos(cant) - g sin(cant)) cos(gradient) [N].
    vertical : float
        Normal to it: m (g cos(cant) + V^2/R sin(cant)) cos(gradient) [N].
    """
    mass = sum(body.mass for body in scenario.vehicle.bodies)
    sine = stretch.cant / scenario.cant_base
    cosine = np.sqrt(1.0 - sine**2)
    level = np.cos(np.arctan(stretch.gradient))
    gravity, centrifugal = scenario.run.gravity * level, stretch.curvature * scenario.final_speed**2 * level
    lateral = mass * (gravity * sine - centrifugal * cosine)
    return float(stretch.outwards * lateral), float(mass * (gravity * cosine + centrifugal * sine))


@dataclass(frozen=True)
class SteadyValues:
    """Lateral values counted outwards; wheels: outer and inner one of each wheelset (on straight track right and left).

    Attributes
    ----------
    lateral, yaw : array (n_wheelset,)
        [m], [rad]
    y_force, q_force : array (n_wheelset, 2)
        Forces on the rails [N].
    """

    lateral: np.ndarray
    yaw: np.ndarray
    y_force: np.ndarray
    q_force: np.ndarray


class End(NamedTuple):
    """What the steady end of a run amounts to.

    Attributes
    ----------
    mean, swing : SteadyValues
        Means; largest less smallest values.
    newton : SteadyValues or None
        The steady motion that Newton's method finds.
    balance : pair of float
        Sums of Y and Q as `expected_forces` gives them [N].
    traction, weight_along : float
        Force that holds the speed, and weight against the direction of travel [N].
    vibration : Vibration or None
        None on a track with irregularity.
    """

    mean: SteadyValues
    swing: SteadyValues
    newton: SteadyValues | None
    balance: tuple
    traction: float
    weight_along: float
    vibration: Vibration | None


def _arranged(system, stretch, sign, q, y_force, q_force):
    """SteadyValues from coordinates and rail forces in track axes."""
    wheelsets = list(system.wheelsets)
    order = slice(None) if stretch.outer_side > 0.0 else slice(None, None, -1)
    return SteadyValues(
        lateral=sign * q[wheelsets, 1],
        yaw=sign * q[wheelsets, 5],
        y_force=sign * y_force.reshape(-1, 2)[:, order],
        q_force=q_force.reshape(-1, 2)[:, order],
    )


def means(system, stretch, window):
    """Means of a SteadyWindow."""
    values = (window.mean(key) for key in ("q", "y_force", "q_force"))
    return _arranged(system, stretch, stretch.outwards, *values)


def peaks_to_peaks(system, stretch, window):
    """Largest less smallest values in a SteadyWindow."""
    values = (window.peak_to_peak(key) for key in ("q", "y_force", "q_force"))
    return _arranged(system, stretch, 1.0, *values)


def solved(system, stretch, speed):
    """The steady motion by Newton's method at a speed [m/s]; None when none is found, or the vehicle stands."""
    if speed == 0.0:
        return None
    try:
        return motion(system, stretch, speed)
    except SimulationError:
        return None


def motion(system, stretch, speed):
    """As `solved`, but a SimulationError says why there is none."""
    place = stretch.curvature, stretch.cant, speed
    data = steady(system, *place, gradient=stretch.gradient, aside=stretch.aside).data
    return _arranged(system, stretch, stretch.outwards, data.q, data.rail["y"], data.rail["q"])
