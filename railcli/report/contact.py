"""A contact table for readers: its summary, the verdict on its errors, its picture."""

import numpy as np

from railcli.analysis.build_table import wheel_regions
from railcli.analysis.conicity import rolling
from railcli.analysis.refine import GOALS
from railcli.analysis.rigid_contact import wheelset_on
from railcli.kernels.layout import Node, Region
from railcli.kernels.tabulate import MIN_CURVATURE

from . import wheelset
from .figures import BLUE, GREY, ORANGE, PURPLE, VERMILION, draw
from .text import columns, facts
from .wheelset import flange_back, inclination

QUANTITIES = {  # channel of the certificate: name, unit
    "gap_um": ("distance D", "um"),
    "position_mm": ("position", "mm"),
    "angle_mrad": ("contact angle", "mrad"),
    "radius_um": ("rolling radius", "um"),
}
REGION_COLOURS = {Region.TREAD: BLUE, Region.ROOT: ORANGE, Region.FLANK: VERMILION, Region.TIP: PURPLE}
SHOWN_Y = 10e-3  # the figure shows lateral positions to both sides up to this [m]


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
    grid = (
        f"y +-{s.y_range * 1e3:g} mm by {s.y_step * 1e3:g}, roll +-{s.roll_range * 1e3:g} mrad by "
        f"{s.roll_step * 1e3:g}, yaw 0 ... {s.yaw_range * 1e3:g} mrad in {s.yaw_count} values even in its square"
    )
    pairs = [
        ("wheel", f"{table.wheel_name} (sha256 {table.wheel_digest[:12]}), radius {s.radius * 1e3:g} mm"),
        ("rail", f"{table.rail_name} (sha256 {table.rail_digest[:12]}), inclination {inclination(s)}"),
        ("track", f"gauge {s.gauge * 1e3:g} mm, {flange_back(s)}"),
        ("material", f"E = {s.young / 1e9:g} GPa, Poisson's ratio {s.poisson:g}"),
        ("grid", grid),
        ("wheel positions", f"{s.positions:,}"),
        ("contact points", f"{table.points:,} in {table.branch.shape[0]:,} branches"),
        (
            "curvature",
            f"averaged over {s.curvature_window * 1e3:g} mm of arc; difference of wheel and rail at least "
            f"{MIN_CURVATURE:g} 1/m (conformal contact)",
        ),
        ("size", f"{size / 1e6:.1f} MB"),
        ("method", {"simplex": "simplex (Nelder and Mead)", "locus": "closed-form locus"}[table.method]),
    ]
    if cpu_s is not None:
        pairs.append(("CPU time", f"{cpu_s:.2f} s, {s.positions / max(cpu_s, 1e-9):,.0f} positions/s"))
    return [f"Contact table: {title(table)}", *facts(pairs), *certificate_lines(certificate)]


def certificate_lines(certificate):
    """The error of look-up against direct minimisation as a table of text."""
    if "gap_um" not in certificate:
        return []
    names = {key: f"{name} [{unit}]" for key, (name, unit) in QUANTITIES.items()}
    rows = []
    for key, name in names.items():
        error = certificate[key]
        at = error["worst_at"]
        worst = f"y {at['y_mm']:+.2f} mm, roll {at['roll_mrad']:+.2f} mrad, yaw {at['yaw_mrad']:+.2f} mrad"
        rows.append((name, *(f"{error[part]:.3g}" for part in ("p99", "p999", "max")), worst))
    parts = [
        (part, f"{count:,}", *(_quantiles(certificate[key]["by_region"][part]) for key in QUANTITIES))
        for part, count in certificate["contacts"].items()
    ]
    return [
        f"Error of look-up against direct minimisation at {certificate['poses']:,} random poses "
        f"(seed {certificate['seed']}), loaded branches:",
        *columns(rows, ("", "p99", "p99.9", "max", "worst at")),
        "By part of the wheel profile, p99 / p99.9:",
        *columns(parts, ("", "contacts", *names.values())),
        f"  {certificate['near_end_share']:.2%} of the contact points lie within one cell of a branch's end: they are "
        "counted apart and left out",
        f"  elsewhere missed: {certificate['missed']}, invented: {certificate['invented']}, poses with more contacts "
        f"than a wheel keeps: {certificate['overfull']}",
    ]


def _quantiles(error):
    return f"{error['p99']:.2g} / {error['p999']:.2g}"


def refinement_lines(accuracy, stages):
    """What an accuracy asks for, and the grids on the way to it with their cost: stages of `analysis.refine`."""
    goals = [
        f"on {name} {accuracy * GOALS[region]['angle_mrad']:g} mrad and {accuracy * GOALS[region]['radius_um']:g} um"
        for name, region in (("the tread", "tread"), ("root and flange", "root"))
    ]
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


def refinement_facts(stages):
    """The same for a machine."""
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
        _branches(figure.add_subplot(grid[1, 2]), table, pair.right)

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
    for edge in wheel_regions(mounting):
        axis.axhline(1e3 * edge, color=GREY, linewidth=0.7, linestyle=":")
    axis.set_title("Branches in the table, roll = yaw = 0")
    axis.set_xlabel("lateral position of the wheel about nominal [mm]")
    axis.set_ylabel("on the wheel, from the tape circle to the field side [mm]")
    axis.legend(loc="lower left", markerscale=2.0)
