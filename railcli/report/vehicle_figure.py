"""A vehicle drawn as it stands: from the side, from above, from behind."""

import numpy as np

from .figures import BLUE, GREY, VERMILION, plain
from .vehicle_shapes import shapes

ROUND = np.linspace(0.0, 2.0 * np.pi, 49)
COLOURS = {"body": BLUE, "bogie": VERMILION, "wheelset": "black"}


def side(axis, vehicle, tape_circle):
    """Bodies over their places along the vehicle, heights above the rails; travel is to the right."""
    for body, shape in _drawn(vehicle, tape_circle):
        x, _, height = body.centre
        if shape.kind == "wheelset":
            radius = body.wheel_radius
            axis.plot(x + radius * np.cos(ROUND), height + radius * np.sin(ROUND), color=COLOURS[shape.kind])
            continue
        ahead, down = shape.above[:, 0], shape.behind[:, 1]
        ends, tops = (ahead.min(), ahead.max()), (-down.max(), -down.min())
        outline = np.array([(ends[i], tops[k]) for i, k in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))])
        axis.plot(x + outline[:, 0], height + outline[:, 1], color=COLOURS[shape.kind])
        axis.plot(x, height, "+", color=COLOURS[shape.kind])
    axis.axhline(0.0, color=GREY, linewidth=1.5)
    _finish(axis, "x, forward [m]", "height [m]")


def above(axis, vehicle, tape_circle):
    """Bodies as a bird sees them, the right-hand side below."""
    for body, shape in _drawn(vehicle, tape_circle):
        x, y, _ = body.centre
        axis.plot(x + shape.above[:, 0], y + shape.above[:, 1], color=COLOURS[shape.kind])
    axis.invert_yaxis()
    _finish(axis, "x, forward [m]", "y, to the right [m]")


def behind(axis, vehicle, tape_circle):
    """Bodies as one sees them from behind."""
    for body, shape in _drawn(vehicle, tape_circle):
        _, y, height = body.centre
        axis.plot(y + shape.behind[:, 0], height - shape.behind[:, 1], color=COLOURS[shape.kind])
    axis.axhline(0.0, color=GREY, linewidth=1.5)
    _finish(axis, "y, to the right [m]", "height [m]")


def figure(canvas, vehicle, tape_circle):
    """All three views."""
    top, bottom = canvas.subfigures(2, 1)
    side(top.subplots(), vehicle, tape_circle)
    left, right = bottom.subplots(1, 2, width_ratios=(3.0, 1.0))
    above(left, vehicle, tape_circle)
    behind(right, vehicle, tape_circle)
    canvas.suptitle(plain(vehicle.name))


def _drawn(vehicle, tape_circle):
    found = shapes(vehicle, tape_circle)
    return [(body, found[body.name]) for body in vehicle.bodies]


def _finish(axis, x, y):
    axis.set_aspect("equal")
    axis.set_xlabel(x)
    axis.set_ylabel(y)
