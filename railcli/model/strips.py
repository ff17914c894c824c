"""Strips of a rail's surface that bear the normal force, and their distances (theory.md section 6.7)."""

import math
from dataclasses import dataclass

import numpy as np

from railcli.kernels.difference import height
from railcli.kernels.strips import STRIP

BEYOND = 8e-3  # of the surface beyond the ends of the rail's graph, along its last tangent, has strips too [m]
HAT = 6e-3  # distance of the nodes of the slenderness factor along the rail [m]
FAR = 10.0  # distance over the greatest width from which a strip counts by its middle and second moment
WIDTHS = (  # contact angle [rad] and width there [m], linear between: patches are the narrower the steeper
    (math.radians(4.0), 0.24e-3),
    (math.radians(12.0), 0.18e-3),
    (math.radians(50.0), 0.18e-3),
    (math.radians(60.0), 0.12e-3),
)
LEVEL_WIDTHS = (*WIDTHS[:-1], (math.radians(60.0), 0.075e-3))  # of the levels of a table, at a depth of penetration of
LEVEL_DEPTH = 16e-6  # [m]; patches widen with its square root


@dataclass(frozen=True, eq=False)
class Strips:
    """Strips of a right-hand rail, from the gauge side to the field side.

    Attributes
    ----------
    strip : STRIP array (n,)
    apart : array (n, n)
        Distance of each two along the surface, geometric mean over both widths, in single precision [m].
    nodes : int
        Of the slenderness factor.
    """

    strip: np.ndarray
    apart: np.ndarray
    nodes: int


def strips_of(mounting, fineness=1.0, widths=WIDTHS):
    """Strips of the rail of a Mounting.

    Parameters
    ----------
    mounting : Mounting
    fineness : float
        Divides the widths.
    widths : tuple
        As WIDTHS.
    """
    graph = mounting.rail, mounting.rail_start, mounting.rail_step
    ends = mounting.rail_start, mounting.rail_start + mounting.rail_step * (mounting.rail.shape[0] - 1)
    top = mounting.rail_start + mounting.rail_step * int(np.argmin(mounting.rail[:, 0]))
    angles, across = np.array(widths).T

    def advance(y, slope):
        return np.interp(math.atan(abs(slope)), angles, across) / fineness / math.hypot(1.0, slope)

    found = []
    for way in (-1.0, 1.0):
        y = top
        while True:
            slope = height(*graph, y)[1]
            middle = y + 0.5 * way * advance(y, slope)
            step = advance(y, height(*graph, middle)[1])
            after = y + way * step
            over = max(ends[0] - after, after - ends[1], 0.0)
            if over * math.hypot(1.0, slope) > BEYOND:
                break
            found.append((y + 0.5 * way * step, step))
            y = after
    y, across = np.array(sorted(found)).T
    z, slope = np.array([height(*graph, each) for each in y]).T
    cosine = 1.0 / np.hypot(1.0, slope)
    strip = np.zeros(y.size, STRIP)
    strip["y"], strip["z"] = y, z
    strip["normal_y"], strip["normal_z"] = -slope * cosine, cosine
    strip["width"] = across / cosine
    strip["arc"] = np.cumsum(strip["width"]) - 0.5 * strip["width"]
    strip["bend"] = 0.5 * cosine / (mounting.radius + z)
    strip["hat"], strip["share"] = np.divmod(strip["arc"] / HAT, 1.0)
    return Strips(strip, _apart(strip["arc"], strip["width"]), int(strip["hat"].max()) + 2)


def strips_at(mounting, depths):
    """Strips for each of several depths of penetration [m], as much wider as patches are."""
    return [strips_of(mounting, math.sqrt(LEVEL_DEPTH / depth), LEVEL_WIDTHS) for depth in depths]


def _apart(arc, width):
    """Geometric mean distances of the points of each two strips [m], beyond FAR to the second order of their widths."""
    apart = np.abs(arc[:, None] - arc[None, :])
    near = np.nonzero(apart < FAR * width.max())
    with np.errstate(divide="ignore"):
        square = width * width / 24.0
        mean = apart - (square[:, None] + square[None, :]) / apart
    mean[near] = _mean_distance(apart[near], width[near[0]], width[near[1]])
    return mean.astype(np.float32)


def _mean_distance(apart, width, other):
    """Geometric mean of the distances of the points of two strips, exactly [m]."""

    def twice_integral(x):
        x = np.abs(x)
        return x * x * (0.5 * np.log(np.where(x > 0.0, x, 1.0)) - 0.75)

    outer, inner = 0.5 * (width + other), 0.5 * (width - other)
    total = (
        twice_integral(apart + outer) + twice_integral(apart - outer)
        - twice_integral(apart + inner) - twice_integral(apart - inner)
    )  # fmt: skip
    return np.exp(total / (width * other))
