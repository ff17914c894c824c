"""Contact tables from profiles (theory.md section 4)."""

import math
import time

import numpy as np

from railcli.errors import InputError
from railcli.kernels.branches import PER_CORNER, cut_knots, fill_slopes, join_cells, link_nodes
from railcli.kernels.layout import NODE_CHANNELS, Node
from railcli.kernels.tabulate import fill_nodes, solve_orientation
from railcli.model.contact_table import ContactTable, mount
from railcli.model.heights import STORED, pack

from .build_heights import Columns, store_heights

METHODS = ("simplex", "locus")
COARSE_STATION = 0.5e-3  # scan of the tread [m]
FINE_STATION = 0.25e-3  # scan of flange and root [m]
TREAD_ANGLE = math.radians(8.0)  # the tread ends where the wheel profile is first this steep
FLANK_ANGLE = math.radians(60.0)  # flank: where it is steeper than this


def wheel_regions(mounting):
    """Profile coordinates [m] that part tip | flank | root | tread on a wheel graph."""
    s = mounting.wheel_start + mounting.wheel_step * np.arange(mounting.wheel.shape[0])
    angle = -np.arctan(mounting.wheel[:, 1])
    gauge_side = s < 0.0
    steepest = int(np.argmax(np.where(gauge_side, angle, -1.0)))
    flank = FLANK_ANGLE if angle[steepest] > FLANK_ANGLE else 0.9 * angle[steepest]
    after = np.arange(s.size) >= steepest
    root = s[after & (angle < flank)][0] if (after & (angle < flank)).any() else s[steepest]
    tread = s[after & (angle < TREAD_ANGLE)][0] if (after & (angle < TREAD_ANGLE)).any() else s[steepest]
    before = (np.arange(s.size) < steepest) & (angle < flank)
    tip = s[before][-1] if before.any() else s[0]
    return np.array([tip, root, tread])


def stations(mounting, fine=FINE_STATION, coarse=COARSE_STATION):
    """Profile coordinates of the coarse scan [m]: finer from the flange to 10 mm past the tread's beginning."""
    low = mounting.wheel_start
    high = low + mounting.wheel_step * (mounting.wheel.shape[0] - 1)
    part = min(wheel_regions(mounting)[2] + 0.010, high)
    found = np.concatenate([np.arange(low, part, fine), np.arange(part, high, coarse), [high]])
    return found[np.append(np.diff(found) > 0.1 * fine, True)]


def check_fit(mounting, settings):
    """A centred wheelset must not stand on its flanges, or there is no wheelset on that track."""
    found = np.zeros((1, PER_CORNER, 6))
    counts = np.zeros(1, np.int64)
    solve_orientation(
        1, 0.0, 0.0, np.zeros(1), *mounting.kernel_arguments, stations(mounting), found, counts
    )
    deepest = found[0, : counts[0]][np.argmin(found[0, : counts[0], 1])] if counts[0] else None
    regions = wheel_regions(mounting)
    if deepest is None or deepest[0] < regions[1] or abs(deepest[1]) > 0.010:
        where = "nowhere" if deepest is None else f"{deepest[0] * 1e3:+.1f} mm from the tape circle"
        raise InputError(
            "contact geometry",
            f"no wheelset fits: gauge {settings.gauge * 1e3:g} mm, flange-back {settings.flange_back * 1e3:g} mm and "
            f"these profiles let a centred wheel touch {where}, not on its tread or flange root; check gauge and "
            "flange-back",
        )


def join(counts, node, basin, shape, steps=None):
    """Branches of the minima at neighbouring grid poses.

    Parameters
    ----------
    counts : int array (n_pose,)
        Minima of each pose, ordered roll, yaw^2, y (fastest).
    node : array (n, NODE_CHANNELS)
        Minima; with steps their slopes of contact angle and place are filled.
    basin : array (n, 2)
        Ends of their basins [m].
    shape : (int, int, int)
        Numbers of y, roll and yaw^2.
    steps : (float, float, float), optional
        Distances of these.

    Returns
    -------
    cell, branch : arrays
        As ContactTable has them.
    facts : dict
    """
    ny, nr, nw = shape
    first = np.concatenate([[0], np.cumsum(counts)])
    cell = np.zeros((nr - 1) * (nw - 1) * (ny - 1) + 1, np.int32)
    link = np.empty((node.shape[0], 3), np.int32)
    link_nodes(first, node, basin, ny, nr, nw, link)
    cuts = cut_knots(first, node, link, ny, nr, nw)
    if steps:
        fill_slopes(node, link, *steps)
    capacity = 2 * cell.size + 1000
    while True:
        branch = np.empty((capacity, 8), np.int32)
        count, ended = join_cells(first, node, link, ny, nr, nw, cell, branch)
        if count <= capacity:
            break
        capacity = count
    facts = {"branches": int(count), "ended": int(ended), "cuts": int(cuts)}
    return cell, np.ascontiguousarray(branch[:count]), facts


def build_table(wheel, rail, settings, method="simplex", progress=None):
    """Build a contact table.

    Parameters
    ----------
    wheel, rail : Profile
        Right-hand profiles; the rail upright.
    settings : TableSettings
    method : {"simplex", "locus"}
        Nelder-Mead on the difference surface, or its closed-form twin.
    progress : callable, optional
        Called with the share done, 0 ... 1.

    Returns
    -------
    table : ContactTable
    facts : dict
        cpu_s, positions, evaluations, crowded poses, branches, ended and knotted branches.
    """
    mounting = mount(wheel, rail, settings)
    check_fit(mounting, settings)
    regions, station = wheel_regions(mounting), stations(mounting)
    if settings.stores_heights:
        return _with_heights(wheel, rail, settings, method, mounting, regions, station, progress)
    ny, nr, nw = settings.y_count, settings.roll_count, settings.yaw_count
    y_start = -settings.y_step * (ny // 2)
    y = y_start + settings.y_step * np.arange(ny)
    found, counts = np.zeros((ny, PER_CORNER, 6)), np.zeros(ny, np.int64)
    all_counts = np.zeros(nr * nw * ny, np.int64)
    nodes, basins = [], []
    evaluations = crowded = 0
    began = time.process_time()
    for ir in range(nr):
        roll = settings.roll_step * (ir - nr // 2)
        for iw in range(nw):
            yaw = settings.yaw_range * math.sqrt(iw / (nw - 1))
            used, full = solve_orientation(
                METHODS.index(method), roll, yaw, y, *mounting.kernel_arguments, station,
                found, counts,
            )  # fmt: skip
            evaluations += used
            crowded += full
            node = np.empty((int(counts.sum()), NODE_CHANNELS))
            basin = np.empty((node.shape[0], 2))
            fill_nodes(
                roll, yaw, y_start, settings.y_step, *mounting.kernel_arguments,
                settings.young, settings.poisson, regions, found, counts, node, basin,
            )
            nodes.append(node)
            basins.append(basin)
            all_counts[(ir * nw + iw) * ny : (ir * nw + iw + 1) * ny] = counts
        if progress:
            progress(0.95 * (ir + 1) / nr)
    node, basin = np.concatenate(nodes), np.concatenate(basins)
    steps = settings.y_step, settings.roll_step, settings.yaw_range**2 / (nw - 1)
    cell, branch, joined = join(all_counts, node, basin, (ny, nr, nw), steps)
    table = ContactTable(
        settings=settings,
        wheel_name=wheel.name,
        rail_name=rail.name,
        wheel_digest=wheel.digest(),
        rail_digest=rail.digest(),
        method=method,
        node=node,
        cell=cell,
        branch=branch,
    )
    facts = {
        "cpu_s": time.process_time() - began,
        "positions": settings.positions,
        "evaluations": int(evaluations),
        "crowded": int(crowded),
        "nodes": int(node.shape[0]),
        **joined,
    }
    if progress:
        progress(1.0)
    return table, facts


def _with_heights(wheel, rail, settings, method, mounting, regions, station, progress):
    """As `build_table`, for a table of heights."""
    began = time.process_time()
    columns = Columns(mounting, settings, station)
    stored = store_heights(columns, settings, METHODS.index(method), progress, settings.fineness)
    places = np.zeros((stored.lateral.size, NODE_CHANNELS))
    places[:, Node.LATERAL] = stored.lateral
    cell, branch, joined = join(stored.minima, places, stored.basin, stored.counts)
    table = ContactTable(
        settings=settings,
        wheel_name=wheel.name,
        rail_name=rail.name,
        wheel_digest=wheel.digest(),
        rail_digest=rail.digest(),
        method=method,
        node=np.zeros((0, NODE_CHANNELS)),
        cell=cell,
        branch=branch,
        heights=pack(
            STORED, regions, settings.radius, settings.poisson, stored.shear, stored.axes, stored.values, stored.parts
        ),
        counts=stored.counts,
    )
    facts = {
        "cpu_s": time.process_time() - began,
        "positions": int(np.prod(stored.counts)),
        "evaluations": int(columns.evaluations),
        "crowded": int(columns.crowded),
        "nodes": stored.lateral.size,
        "solutions": int(columns.solutions),
        **joined,
    }
    if progress:
        progress(1.0)
    return table, facts
