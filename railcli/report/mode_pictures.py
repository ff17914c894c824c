"""Mode shapes as stick figures: from the side, from above, from behind."""

import numpy as np

from railcli.analysis.mode_shapes import groups

from .figures import GREY

VIEWS = {"side": (0, 2), "above": (0, 1), "behind": (1, 2)}
REACH = 0.22  # displacement of the farthest point over the height of the picture at rest
TALL = {"car body": 1.1, "bogie": 0.15, "hung part": 0.25}  # half heights of the boxes [m]
WIDE = {"car body": 1.4, "bogie": 1.0, "hung part": 0.45, "wheelset": 0.75}  # half widths [m]
OVERHANG = {"car body": 1.1, "bogie": 1.15, "hung part": 0.35}  # of a box beyond what it stands on


def draw_shapes(figure, modes, shapes, chosen, colours):
    """A panel for each chosen mode: at rest in grey, displaced in the colour of its plane."""
    rows = -(-len(chosen) // 3)
    axes = figure.subplots(rows, 3, squeeze=False)
    for axis, k in zip(axes.ravel(), chosen, strict=False):
        q = modes.linear.coordinates(modes.right[k])
        view = _view(shapes[k], q)
        _draw(axis, modes.linear, q, view, colours[shapes[k].plane])
        numbers = f"{k + 1}: {modes.frequency[k]:.2f} Hz, {100 * modes.damping[k]:.1f} %"
        axis.set_title(f"{numbers}\n{shapes[k].words}", fontsize=7.5)
        axis.set_xlabel({"side": "from the side", "above": "from above", "behind": "from behind"}[view], fontsize=7)
    for axis in axes.ravel():
        axis.set_xticks([])
        axis.set_yticks([])
        axis.grid(False)
        for spine in axis.spines.values():
            spine.set_visible(False)
    for axis in axes.ravel()[len(chosen) :]:
        axis.set_visible(False)


def _view(shape, q):
    if shape.plane == "vertical":
        return "side"
    return "behind" if "sway" in shape.words or "roll" in shape.words else "above"


def _draw(axis, linear, q, view, colour):
    """Displaced at the instant at which the mode reaches farthest, and a quarter of a period later, paler."""
    outlines = _outlines(linear, view)
    corners = [_moved(points, centre, q[i], view) for i, centre, points in outlines]
    size = max(np.abs(move).max() for move in corners)
    height = np.ptp(np.concatenate([points for _, _, points in outlines]), axis=0)[1]
    scale = REACH * height / max(size, 1e-30)
    for (_, _, points), move in zip(outlines, corners, strict=True):
        axis.plot(*points.T, color=GREY, linewidth=0.7, alpha=0.7)
        for turn, alpha in ((1j, 0.3), (1.0, 1.0)):
            axis.plot(*(points + scale * (move * turn).real).T, color=colour, linewidth=1.2, alpha=alpha)
    if view != "above":
        axis.axhline(0.0, color=GREY, linewidth=0.8)
        axis.set_aspect("equal", adjustable="datalim") if view == "behind" else None
    axis.invert_yaxis()
    axis.margins(0.08)


def _moved(points, centre, q, view):
    """Complex displacements of points (n, 2) of a body: of its centre and by its small rotations."""
    a, b = VIEWS[view]
    u, v = (points - centre).T
    turn = {"side": q[4], "above": -q[5], "behind": -q[3]}[view]
    return np.column_stack([q[a] + turn * v, q[b] - turn * u])


def _outlines(linear, view):
    """Index, centre and outline (n, 2) of each body in a view, at rest, track axes [m]."""
    model, q = linear.system.model, linear.data.q
    of = groups(model)
    a, b = VIEWS[view]
    radius = {int(wheel["body"]): float(wheel["radius"]) for wheel in model.wheel}
    drawn = []
    for i in range(q.shape[0]):
        if view == "behind" and of[i] != "car body" and any(of[j] == of[i] for j, _, _ in drawn):
            continue
        centre = q[i, [a, b]]
        drawn.append((i, centre, centre + _outline(model, q, i, of[i], view, radius)))
    return drawn


def _outline(model, q, i, group, view, radius):
    """Outline of a body about its centre."""
    wide = WIDE[group]
    if group == "wheelset":
        if view == "side":
            angle = np.linspace(0.0, 2.0 * np.pi, 37)
            return radius[i] * np.column_stack([np.cos(angle), np.sin(angle)])
        if view == "above":
            r = radius[i]
            return np.array([[-r, -wide], [r, -wide], [0, -wide], [0, wide], [-r, wide], [r, wide]])
        r = radius[i]
        return np.array([[-wide, -r], [-wide, r], [-wide, 0], [wide, 0], [wide, -r], [wide, r]])
    carriers = [int(joint["lower"]) for joint in model.joint if joint["upper"] == i]
    half = OVERHANG[group] * max([abs(q[j, 0] - q[i, 0]) for j in carriers], default=1.0)
    tall = TALL[group]
    across, up = {"side": (half, tall), "above": (half, wide), "behind": (wide, tall)}[view]
    return np.array([[-across, -up], [across, -up], [across, up], [-across, up], [-across, -up]])
