"""A contact table for readers: its summary, the verdict on its errors, its picture."""

import numpy as np

from railcli.analysis.build_table import wheel_regions
from railcli.analysis.certify import direct_minima
from railcli.analysis.certify_forces import AIMS, LookUp, direct, first_touch
from railcli.analysis.conicity import rolling
from railcli.analysis.refine import GOALS
from railcli.analysis.rigid_contact import fine_stations, wheelset_on
from railcli.kernels.layout import Node, Region
from railcli.kernels.tabulate import MIN_CURVATURE
from railcli.model.heights import knots_of

from . import wheelset
from .certificate import FORCES, QUANTITIES, certificate_lines
from .figures import BLUE, GREY, ORANGE, PURPLE, SKY, VERMILION, draw
from .text import columns, facts
from .wheelset import flange_back, inclination

REGION_COLOURS = {Region.TREAD: BLUE, Region.ROOT: ORANGE, Region.FLANK: VERMILION, Region.TIP: PURPLE}
SHOWN_Y = 10e-3  # the figure shows lateral positions to both sides up to this [m]
SHOWN_COUNT = 201  # of which patches are shown
SHOWN_DEPTH = 60e-6  # and how deep the wheel is pressed in for them [m]


def title(table):
    """`ORES1002 on UIC60, inclination 1:20, ...`"""
    s = table.settings
    return (
        f"{table.wheel_name} on {table.rail_name}, inclination {inclination(s)}, gauge {s.gauge * 1e3:g} mm, "
        f"{flange_back(s)}, wheel radius {s.radius * 1e3:g} mm"
    )


def summary(table, certificate, size, cpu_s=None):
    """Lines that say what a table is, what it took, and how accurate it is.

    Parameters
    ----------
    table : ContactTable
    certificate : dict
        Empty when there is none.
    size : int
        Of its file [bytes].
    cpu_s : float, optional
        Processor time of building it [s].
    """
    s = table.settings
    positions = int(np.prod(table.counts))
    pairs = [
        ("wheel", f"{table.wheel_name} (sha256 {table.wheel_digest[:12]}), radius {s.radius * 1e3:g} mm"),
        ("rail", f"{table.rail_name} (sha256 {table.rail_digest[:12]}), inclination {inclination(s)}"),
        ("track", f"gauge {s.gauge * 1e3:g} mm, {flange_back(s)}"),
        ("material", f"E = {s.young / 1e9:g} GPa, Poisson's ratio {s.poisson:g}"),
        *(_knots(table) if s.stores_heights else _grid(s)),
        ("wheel positions", f"{positions:,}"),
        (
            "parts of contact" if s.stores_heights else "contact points",
            f"{table.points:,} in {table.branch.shape[0]:,} branches",
        ),
        ("size", f"{size / 1e6:.1f} MB"),
        ("method", {"simplex": "simplex (Nelder and Mead)", "locus": "closed-form locus"}[table.method]),
    ]
    if cpu_s is not None:
        pairs.append(("CPU time", f"{cpu_s:.2f} s, {positions / max(cpu_s, 1e-9):,.0f} positions/s"))
    return [f"Contact table: {title(table)}", *facts(pairs), *certificate_lines(certificate)]


def _grid(s):
    grid = (
        f"y +-{s.y_range * 1e3:g} mm by {s.y_step * 1e3:g}, roll +-{s.roll_range * 1e3:g} mrad by "
        f"{s.roll_step * 1e3:g}, yaw 0 ... {s.yaw_range * 1e3:g} mrad in {s.yaw_count} values even in its square"
    )
    curvature = (
        f"averaged over {s.curvature_window * 1e3:g} mm of arc; difference of wheel and rail at least "
        f"{MIN_CURVATURE:g} 1/m (conformal contact)"
    )
    return [("normal law", s.normal), ("grid", grid), ("curvature", curvature)]


def _knots(table):
    """The grid of a table of heights: numbers of knots and their distances."""
    s, (y, roll, yaw2) = table.settings, knots_of(table.heights, table.counts)

    def apart(knots, factor):
        low, high = np.diff(knots).min() * factor, np.diff(knots).max() * factor
        return f"{low:.3g}" if high < 1.001 * low else f"{low:.3g} to {high:.3g}"

    grid = (
        f"y +-{s.y_range * 1e3:g} mm in {y.size} knots {apart(y, 1e3)} mm apart, roll +-{s.roll_range * 1e3:g} mrad "
        f"in {roll.size} {apart(roll, 1e3)} mrad apart, yaw 0 ... {s.yaw_range * 1e3:g} mrad in {yaw2.size} even in "
        f"its square; fineness {s.fineness:g}"
    )
    return [("normal law", s.normal), ("grid", grid)]


def refinement_lines(accuracy, stages):
    """What an accuracy asks for, and the grids on the way to it with their cost: stages of `analysis.refine`."""
    goals = [
        f"on {name} {accuracy * GOALS[region]['angle_mrad']:g} mrad and {accuracy * GOALS[region]['radius_um']:g} um"
        for name, region in (("the tread", "tread"), ("root and flange", "root"))
    ]
    if stages[0].settings.stores_heights:
        return _refinement_of_knots(accuracy, stages)
    rows = []
    for number, stage in enumerate(stages, 1):
        s = stage.settings
        rows.append(
            (
                f"grid {number}",
                *(f"{1e3 * step:.4g}" for step in (s.y_step, s.roll_step)),
                f"{s.yaw_count}",
                *(f"{value:.1f}" for value in (stage.bytes / 1e6, stage.cpu_s)),
                f"{stage.look_up_ns:.0f}",
                f"{stage.excess:.2f}",
                f"{QUANTITIES[stage.worst[1]][0]}, {stage.worst[0]}" if stage.worst[1] else "nothing to compare",
            )
        )
    header = ("", "y [mm]", "roll [mrad]", "yaws", "MB", "CPU [s]", "look-up [ns]", "error/allowed", "worst")
    return [
        f"Accuracy {accuracy:g} mrad, 99.9 % of contact angle and rolling radius: {'; '.join(goals)}:",
        *columns(rows, header),
        "  A step looks up once per wheel.",
    ]


def _refinement_of_knots(accuracy, stages):
    goals = "; ".join(
        f"{FORCES[key][0]} {' / '.join(f'{accuracy * aim:g}' for aim in aims[:2])} {FORCES[key][1]}"
        for key, aims in AIMS.items()
    )
    rows = [
        (
            f"grid {number}",
            f"{stage.settings.fineness:.3g}",
            *(f"{value:.1f}" for value in (stage.bytes / 1e6, stage.cpu_s)),
            f"{stage.excess:.2f}",
            f"{FORCES[stage.worst[1]][0]}, {stage.worst[0]}" if stage.worst[1] else "nothing to compare",
        )
        for number, stage in enumerate(stages, 1)
    ]
    return [
        f"Accuracy {accuracy:g} %, p99 / p99.9 over all poses: {goals}:",
        *columns(rows, ("", "fineness", "MB", "CPU [s]", "error/allowed", "worst")),
    ]


def refinement_facts(stages):
    """The same for a machine."""
    if stages[0].settings.stores_heights:
        return [
            {
                "fineness": stage.settings.fineness,
                "bytes": stage.bytes,
                "cpu_s": stage.cpu_s,
                "error_over_allowed": stage.excess,
                "worst": list(stage.worst),
            }
            for stage in stages
        ]
    return [
        {
            "y_step_mm": stage.settings.y_step * 1e3,
            "roll_step_mrad": stage.settings.roll_step * 1e3,
            "yaw_count": stage.settings.yaw_count,
            "bytes": stage.bytes,
            "cpu_s": stage.cpu_s,
            "look_up_ns": stage.look_up_ns,
            "error_over_allowed": stage.excess,
            "worst": list(stage.worst),
        }
        for stage in stages
    ]


def plot(table, wheel, rail, path):
    """Draw profiles with contact points, rolling radius difference, contact angle and the branches of a table.

    Parameters
    ----------
    table : ContactTable
    wheel, rail : Profile
        From which it was built.
    path : path-like
        File of the figure.
    """
    pair = wheelset_on(table.settings, wheel, rail)
    contact = rolling(pair, SHOWN_Y, with_roll=True)

    def paint(figure):
        figure.suptitle(title(table), fontsize=12)
        grid = figure.add_gridspec(2, 3, height_ratios=(1.25, 1.0))
        axis = figure.add_subplot(grid[0, :])
        wheelset.profiles(axis, contact, "right", labels=True)
        axis.set_title(f"Right wheel, drawn {wheelset.LIFT:g} mm above its rail; contact points at each mm of y")
        bar = figure.colorbar(wheelset.colours_of(contact), ax=axis, shrink=0.85, aspect=30)
        bar.set_label("lateral position y of the wheelset, to the right [mm]")
        wheelset.radius_difference(figure.add_subplot(grid[1, 0]), contact)
        axis = figure.add_subplot(grid[1, 1])
        wheelset.over_y(axis, contact, "Contact angle, yaw = 0, both wheels touching", "contact angle [degrees]")
        wheelset.both_sides(axis, contact, "angle", np.degrees)
        paint_places = _patches if table.settings.stores_heights else _branches
        paint_places(figure.add_subplot(grid[1, 2]), table, pair.right)

    draw(paint, path, (13.0, 9.5))


def level_nodes(table):
    """Nodes of the table at roll = yaw = 0: lateral position [m] of the pose and row of `table.node` for each."""
    s = table.settings
    row = (s.roll_count // 2) * (s.yaw_count - 1) * (s.y_count - 1)
    y, nodes = [], []
    for i in range(s.y_count):
        cell, corner = row + min(i, s.y_count - 2), int(i == s.y_count - 1)
        found = table.branch[table.cell[cell] : table.cell[cell + 1], corner]
        nodes.append(found[found >= 0])
        y.append(np.full(nodes[-1].size, -s.y_step * (s.y_count // 2) + i * s.y_step))
    return np.concatenate(y), np.concatenate(nodes)


def _branches(axis, table, mounting):
    y, index = level_nodes(table)
    node = table.node[index]
    deepest = np.zeros(y.size, bool)
    for place in np.unique(y):
        same = np.flatnonzero(y == place)
        deepest[same[np.argmin(node[same, Node.GAP])]] = True
    axis.plot(
        1e3 * y[deepest], 1e3 * node[deepest, Node.LATERAL], "s", color="#cccccc", markersize=6, label="deepest"
    )
    for region, colour in REGION_COLOURS.items():
        here, name = np.round(node[:, Node.REGION]) == region, region.name.lower()
        if here.any():
            axis.plot(1e3 * y[here], 1e3 * node[here, Node.LATERAL], ".", color=colour, markersize=3, label=name)
    _name_places(axis, mounting, "Branches in the table, roll = yaw = 0")


def _patches(axis, table, mounting):
    """Patches of a table of heights beside those of the law itself, their area as their share of the load."""
    s = table.settings
    station, law, look = fine_stations(mounting), direct(mounting, s), LookUp(table)
    reach = min(SHOWN_Y, s.y_range)
    true, looked = [], []
    for y in np.linspace(-reach, reach, SHOWN_COUNT):
        pose = float(y), 0.0, 0.0
        minima = direct_minima(mounting, pose, station)
        touch, cosine = first_touch(mounting, pose, minima)
        z = touch + SHOWN_DEPTH / cosine
        for load, found in ((law(pose, z, minima), true), (look(pose, z), looked)):
            if load is not None:
                found += [(y, place, share) for place, share in zip(load.place, load.share, strict=True)]
    for found, colour, least, most, name in (
        (true, SKY, 8.0, 60.0, "by the law directly"), (looked, VERMILION, 1.0, 8.0, "looked up")
    ):  # fmt: skip
        y, place, share = np.array(found).T
        axis.scatter(1e3 * y, 1e3 * place, least + (most - least) * share, color=colour, label=name)
    _name_places(axis, mounting, f"Patches, roll = yaw = 0, {SHOWN_DEPTH * 1e6:g} um beyond first touch")


def _name_places(axis, mounting, title):
    for edge in wheel_regions(mounting):
        axis.axhline(1e3 * edge, color=GREY, linewidth=0.7, linestyle=":")
    axis.set_title(title)
    axis.set_xlabel("lateral position of the wheel about nominal [mm]")
    axis.set_ylabel("on the wheel, from the tape circle to the field side [mm]")
    axis.legend(loc="lower left", markerscale=2.0)
