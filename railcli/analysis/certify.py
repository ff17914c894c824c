"""The certificate of a contact table: its look-up against direct minimisation at random poses."""

import numpy as np

from railcli.kernels.contact import look_up
from railcli.kernels.difference import locus, minima, prepare_scan, slope_difference, wheel_axes
from railcli.kernels.layout import MAX_CONTACT, NODE_CHANNELS, Node, Region
from railcli.model.contact_table import mount

POSES = 20_000
LOADED = 0.1e-3  # branches within this of the deepest count as loaded, and the wheel is pressed in by it [m]
FINE = 0.1e-3  # stations of the direct search along the locus [m]
SEED = 20260101
QUANTITIES = ("gap_um", "position_mm", "angle_mrad", "radius_um")
LIMITS = {"gap_um": 1.2, "angle_mrad": 1.0, "radius_um": 10.0}  # of the errors' p99, which a good table keeps
MOST_MISSED = 1e-3  # of the compared branches: loaded contacts missed or invented
MISSED_BARRIER = 1.0e-6  # minima that a shallower saddle parts from a deeper one are one contact [m]


def random_poses(settings, count, seed=SEED):
    """Poses uniform in y, roll and yaw (both signs) over the whole table, shape (count, 3)."""
    random = np.random.default_rng(seed)
    half = np.array([settings.y_range, settings.roll_range, settings.yaw_range]) * (1.0 - 1e-9)
    return random.uniform(-half, half, (count, 3))


def direct_minima(mounting, pose, station):
    """Minima of the difference surface at one pose by the closed-form locus on given stations.

    Returns
    -------
    array (n, 6)
        As `kernels.difference.minima` says.
    """
    y, roll, yaw = pose
    axes, found = wheel_axes(roll, yaw), np.zeros((16, 6))
    scan_y, scan_z, lowest = np.empty((3, station.size))
    r0, _, *wheel = mounting.kernel_arguments[:5]
    prepare_scan(station, *axes, r0, *wheel, scan_y, scan_z)
    total, _ = minima(
        1, mounting.pressed, y, *axes, *mounting.kernel_arguments, station, scan_y, scan_z, lowest, found
    )
    return found[: min(total, 16)]


def direct_contacts(mounting, pose, station):
    """Contact points of one pose by the closed-form locus on fine stations.

    Returns
    -------
    array (n, 5)
        s [m], D [m], contact angle [rad], radius [m], lower of its two barriers [m].
    """
    y, roll, yaw = pose
    e, f, d = wheel_axes(roll, yaw)
    arguments = mounting.kernel_arguments
    rows = []
    for s, gap, gauge, field, *_ in direct_minima(mounting, pose, station):
        _, _, slope = slope_difference(s, y, e, f, d, *arguments)
        radius = locus(s, e, f, d, mounting.radius, mounting.wheel, mounting.wheel_start, mounting.wheel_step)[3]
        rows.append((s, gap, -np.arctan(slope), radius, min(gauge, field)))
    return np.array(rows).reshape(-1, 5)


def near_end(table, record, pose, lateral):
    """True when the branch at profile coordinate `lateral` ends in the pose's cell or in a cell that adjoins it."""
    counts = np.array([record["y_count"], record["roll_count"], record["yaw2_count"]]) - 1
    place = np.array(
        [
            (pose[0] - record["y_start"]) / record["y_step"],
            (pose[1] - record["roll_start"]) / record["roll_step"],
            pose[2] ** 2 / record["yaw2_step"],
        ]
    )
    centre = np.minimum(place.astype(int), counts - 1)
    for shift in ((0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)):
        iy, ir, iw = centre + shift
        if not (0 <= iy < counts[0] and 0 <= ir < counts[1] and 0 <= iw < counts[2]):
            continue
        cell = (ir * counts[2] + iw) * counts[0] + iy
        rows = table.branch[table.cell[cell] : table.cell[cell + 1]]
        if rows.shape[0] == 0:
            return True
        means = [table.node[row[row >= 0], Node.LATERAL].mean() for row in rows]
        if (rows[int(np.argmin(np.abs(np.array(means) - lateral)))] < 0).any():
            return True
    return False


def on_lines(poses, settings, axis):
    """The same poses moved to grid lines along one axis (0 y, 1 roll, 2 yaw): all else is at a node."""
    count = np.array([settings.y_count - 1, settings.roll_count - 1, settings.yaw_count - 1])
    reach = np.array([settings.y_range, settings.roll_range, settings.yaw_range])
    share = poses / reach
    share[:, 2] = share[:, 2] ** 2
    half = np.array([0.5, 0.5, 1.0]) * count
    nodes = np.round(share * half) / half
    nodes[:, axis] = share[:, axis]
    nodes[:, 2] = np.sqrt(nodes[:, 2])
    return nodes * reach * (1.0 - 1e-9)


def certify(table, wheel, rail, poses=POSES, seed=SEED, progress=None, axis=None):
    """Measure the error of table look-up against direct minimisation.

    Parameters
    ----------
    table : ContactTable
    wheel, rail : Profile
        From which it was built.
    poses, seed : int
        Number of random poses and what makes them.
    progress : callable, optional
        Called with the share done, 0 ... 1.
    axis : int, optional
        Only the error of interpolation along y (0), roll (1) or yaw (2): see `on_lines`.

    Returns
    -------
    dict
        `poses`, `branches` compared, `near_end_share` (within one cell of a branch's end: counted apart and left out
        of the errors), `missed` loaded contacts and `invented` ones outside such cells, `overfull` poses with
        more branches than the core keeps, `contacts` compared by region, for every quantity (gap_um, position_mm,
        angle_mrad, radius_um) p99, p999, max and where the worst is, and `by_region` p99, p999 and max of each region;
        without the quantities when there was nothing to compare.
    """
    mounting = mount(wheel, rail, table.settings)
    low = mounting.wheel_start
    station = np.arange(low, low + mounting.wheel_step * (mounting.wheel.shape[0] - 1), FINE)
    record = table.record[0]
    sample = np.zeros((MAX_CONTACT, NODE_CHANNELS))
    errors, regions, where = [], [], []
    apart = missed = invented = overfull = 0
    at = random_poses(table.settings, poses, seed)
    if axis is not None:
        at = on_lines(at, table.settings, axis)
    for number, pose in enumerate(at):
        mirror = np.array([pose[0], pose[1], abs(pose[2])])
        truth = direct_contacts(mounting, mirror, station)
        if truth.shape[0] == 0:
            continue
        depth = truth[:, 1].min() + LOADED
        truth = truth[(truth[:, 1] < depth) & (truth[:, 4] > MISSED_BARRIER)]
        count = look_up(record, table.node, table.cell, table.branch, *pose, depth, sample)
        overfull += count > MAX_CONTACT
        looked = sample[: min(count, MAX_CONTACT)].copy()
        taken = np.zeros(looked.shape[0], bool)
        for s, gap, angle, radius, _ in truth:
            free = np.flatnonzero(~taken)
            if near_end(table, record, mirror, s):
                apart += 1
                if free.size:
                    taken[free[np.argmin(np.abs(looked[free, Node.LATERAL] - s))]] = True
                continue
            if free.size == 0:
                missed += 1
                continue
            j = free[np.argmin(np.abs(looked[free, Node.LATERAL] - s))]
            taken[j] = True
            row = looked[j]
            errors.append(
                (
                    abs(depth - row[Node.GAP] - gap) * 1e6,
                    abs(row[Node.LATERAL] - s) * 1e3,
                    abs(-np.arctan(row[Node.SLOPE]) - angle) * 1e3,
                    abs(row[Node.RADIUS] - radius) * 1e6,
                )
            )
            regions.append(round(row[Node.REGION]))
            where.append(pose)
        for j in np.flatnonzero(~taken):
            if looked[j, Node.GAP] > 1e-6 and not near_end(table, record, mirror, looked[j, Node.LATERAL]):
                invented += 1
        if progress and number % 200 == 0:
            progress(number / poses)
    errors, regions, where = np.array(errors), np.array(regions), np.array(where)
    certificate = {
        "poses": poses,
        "seed": seed,
        "branches": int(errors.shape[0]),
        "near_end_share": apart / max(apart + errors.shape[0], 1),
        "missed": missed,
        "invented": invented,
        "overfull": overfull,
    }
    if not errors.size:
        return certificate
    parts = {region.name.lower(): regions == region for region in Region if (regions == region).any()}
    certificate["contacts"] = {name: int(part.sum()) for name, part in parts.items()}
    for k, name in enumerate(QUANTITIES):
        column = errors[:, k]
        worst = where[np.argmax(column)]
        certificate[name] = {
            **largest(column),
            "worst_at": dict(zip(("y_mm", "roll_mrad", "yaw_mrad"), (worst * 1e3).tolist(), strict=True)),
            "by_region": {name: largest(column[part]) for name, part in parts.items()},
        }
    return certificate


def largest(errors):
    """99 % and 99.9 % quantile and the largest of errors."""
    p99, p999, most = np.quantile(errors, (0.99, 0.999, 1.0))
    return {"p99": float(p99), "p999": float(p999), "max": float(most)}


def shortcomings(certificate):
    """Sentences that say in what a table falls short of LIMITS; none for a good one."""
    if certificate["branches"] == 0:
        return ["no branch could be compared: the grid is too coarse"]
    texts = [
        f"p99 of {key} is {certificate[key]['p99']:.3g}, allowed: {limit:g}"
        for key, limit in LIMITS.items()
        if not certificate[key]["p99"] <= limit
    ]
    for key in ("missed", "invented"):
        if certificate[key] > MOST_MISSED * certificate["branches"]:
            allowed = MOST_MISSED * certificate["branches"]
            texts.append(f"{certificate[key]} contacts {key}, allowed: {allowed:.0f} of {certificate['branches']}")
    return texts
