"""The certificate of forces of a contact table: its look-up against the same law evaluated directly at random poses."""

from dataclasses import dataclass, field

import numpy as np

from railcli.kernels.contact import elastic_share, look_up
from railcli.kernels.difference import slope_difference, wheel_axes
from railcli.kernels.heights import stored
from railcli.kernels.layout import MAX_CONTACT, NODE_CHANNELS, SAMPLE_ROWS, TABLE, Node, Part, Region
from railcli.kernels.tabulate import fill_nodes
from railcli.model.contact_table import mount

from .build_table import wheel_regions
from .certify import FINE, SEED, direct_minima, largest, random_poses
from .overlap import Law

DEPTHS = 10e-6, 120e-6  # beyond first touch, along the normal of the part that touches first: working depths [m]
QUANTITIES = ("normal_percent", "lateral_percent", "vertical_percent", "centre_mm", "radius_mm")
COUNTED = 0.01  # share of the load from which a patch is missed or invented [-]
BESIDE = 0.3e-3  # a patch looked up so far beside a true one is another [m]
AIMS = {"normal_percent": (0.5, 1.0, 3.0), "centre_mm": (0.05, 0.1, 0.3)}  # of the errors' p99, p99.9 and largest
LIMITS = {"normal_percent": 4.0, "centre_mm": 0.5}  # of their p99, which a good table keeps
OFF = 1.0  # error of the resultant that poses are counted for [%]
MOST_UNLIKE = 0.01  # of the compared poses: patches missed or invented
SIZES = ("p99", "p999", "max")
REGIONS = Region.TIP, Region.FLANK, Region.ROOT, Region.TREAD  # from the flange to the field side


@dataclass(frozen=True, eq=False)
class Load:
    """What a wheel bears.

    Attributes
    ----------
    y, q : float
        Lateral and vertical part of the normal force on the rail [N].
    share, place, radius : array (n,)
        Of each patch: share of the normal forces, profile coordinate on the wheel and rolling radius there [m].
    low, high : array (n,)
        Ends of each patch on the wheel [m].
    """

    y: float
    q: float
    share: np.ndarray
    place: np.ndarray
    radius: np.ndarray
    low: np.ndarray = field(repr=False)
    high: np.ndarray = field(repr=False)

    @property
    def normal(self):
        """Resultant [N]."""
        return float(np.hypot(self.y, self.q))

    def mean(self, values):
        """Of a value of the patches, by their shares."""
        return float(self.share @ values / self.share.sum())


class LookUp:
    """What a table says a wheel bears; called with pose and height z of T. None: off the table, or too many patches."""

    def __init__(self, table):
        self.record, self.arrays = table.record[0], (table.cell, table.branch)
        self.node, self.heights = table.node, table.heights if table.settings.stores_heights else None
        self.sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))

    def __call__(self, pose, z):
        if self.heights is not None:
            count, _, _, by_y, by_z, *_ = stored(self.record, *self.arrays, self.heights, *pose, z, 0, self.sample)
            return _of_parts(by_y, by_z, self.sample[:count]) if 0 <= count <= MAX_CONTACT else None
        count = look_up(self.record, self.node, *self.arrays, *pose, z, self.sample)
        return _of_branches(self.sample[:count]) if 0 <= count <= MAX_CONTACT else None


def _of_parts(by_y, by_z, rows):
    share, slope, place, radius, half = rows[:, [Part.SHARE, Part.SLOPE, Part.LATERAL, Part.RADIUS, Part.SEMI_Y]].T
    half = half / np.hypot(1.0, slope)
    return Load(by_y, by_z, share, place, radius, place - half, place + half)


def _of_branches(rows):
    cosine = 1.0 / np.hypot(1.0, rows[:, Node.SLOPE])
    elastic = np.array([elastic_share(rows, len(rows), j, each) for j, each in enumerate(cosine)])
    normal, place = rows[:, Node.HERTZ] * elastic, rows[:, Node.LATERAL].copy()
    half = rows[:, Node.SEMI_Y] * np.cbrt(elastic) * cosine
    share = normal / max(normal.sum(), 1e-300)
    q = normal * cosine
    return Load(
        float(-q @ rows[:, Node.SLOPE]), float(q.sum()), share, place, rows[:, Node.RADIUS].copy(),
        place - half, place + half,
    )  # fmt: skip


class Strips:
    """The law of strips, directly; called with pose, height z of T and minima of D.

    Patches: strips that bear, with those between them while the bodies overlap from one to the other.
    """

    def __init__(self, mounting, settings):
        self.law = Law(mounting, settings.young, settings.poisson)
        self.width = self.law.strips.strip["width"]

    def __call__(self, pose, z, minima):
        bearing = self.law(pose[0], z, pose[1], pose[2], minima)
        load, row = bearing.line_load * self.width, bearing.overlap
        bears = np.flatnonzero(load > 0.0)
        if bears.size == 0:
            return Load(0.0, 0.0, *np.zeros((5, 0)))
        clear = np.cumsum(~(row["h"] > 0.0))[bears]
        ends = np.flatnonzero(np.diff(clear)) + 1
        first, last = bears[np.r_[0, ends]], bears[np.r_[ends - 1, bears.size - 1]] + 1
        of_run = np.add.reduceat
        runs = np.column_stack([first, np.minimum(last, load.size - 1)]).ravel()
        if last[-1] == load.size:
            runs = runs[:-1]
        total = of_run(load, runs)[::2]
        place, radius = (of_run(load * row[key], runs)[::2] / total for key in ("lateral", "radius"))
        low, high = row["lateral"][first], row["lateral"][last - 1]
        return Load(*bearing.gradient[:2], total / total.sum(), place, radius, low, high)


class Branches:
    """The law at minima of D (`hertz`), directly: as `Strips`, by a table whose corners are all this pose."""

    def __init__(self, mounting, settings):
        self.mounting, self.settings, self.regions = mounting, settings, wheel_regions(mounting)
        self.record, self.sample = np.zeros(1, TABLE)[0], np.zeros((SAMPLE_ROWS, NODE_CHANNELS))
        for key in ("y", "roll", "yaw2"):
            self.record[f"{key}_count"], self.record[f"{key}_step"] = 2, 1.0
        self.record["levels"] = -1
        self.record["shear"], self.record["poisson"] = 0.5 * settings.young / (1.0 + settings.poisson), settings.poisson

    def __call__(self, pose, z, minima):
        y, roll, yaw = pose
        n = minima.shape[0]
        found, counts = minima[None], np.array([n])
        geometry = self.mounting.kernel_arguments
        node, basin = np.zeros((n, NODE_CHANNELS)), np.zeros((n, 2))
        material = self.settings.young, self.settings.poisson
        fill_nodes(roll, yaw, y, 1.0, *geometry, *material, self.regions, found, counts, node, basin)
        self.record["y_start"], self.record["roll_start"] = y, roll
        cell = np.array([0, n], np.int32)
        branch = np.repeat(np.arange(n, dtype=np.int32)[:, None], 8, axis=1)
        for array in (node, cell, branch):
            array.flags.writeable = False
        count = look_up(self.record, node, cell, branch, y, roll, yaw, z, self.sample)
        return _of_branches(self.sample[: min(count, MAX_CONTACT)])


def direct(mounting, settings):
    """The normal law of a table without the table: callable of pose, height z of T [m] and minima of D."""
    return (Strips if settings.stores_heights else Branches)(mounting, settings)


def first_touch(mounting, pose, minima):
    """Height z of T at first touch [m], and the cosine of the contact angle there."""
    first = np.argmin(minima[:, 1])
    axes = wheel_axes(*pose[1:])
    slope = slope_difference(minima[first, 0], pose[0], *axes, *mounting.kernel_arguments)[2]
    return minima[first, 1], 1.0 / np.hypot(1.0, slope)


def unlike(looked, true):
    """Patches missed and invented: those that bear more than COUNTED of the load on one side and have no match.

    A patch that is looked up belongs to the nearest true one, up to BESIDE from its ends.
    """
    away = np.maximum(true.low[:, None] - looked.place, looked.place - true.high[:, None]).clip(0.0)
    match = away <= BESIDE
    missed = (true.share > COUNTED) & ~match.any(axis=1)
    invented = (looked.share > COUNTED) & ~match.any(axis=0)
    return int(missed.sum()), int(invented.sum())


def certify_forces(table, wheel, rail, poses, seed=SEED, progress=None):
    """Measure the error of table look-up against the law evaluated directly, over all poses.

    Parameters
    ----------
    table : ContactTable
    wheel, rail : Profile
        From which it was built.
    poses, seed : int
        Number of random poses, each at a random working depth (DEPTHS), and what makes them.
    progress : callable, optional
        Called with the share done, 0 ... 1.

    Returns
    -------
    dict
        Poses `compared`, in `by_region` by the part of the wheel that bears most; `refused` by the look-up; patches
        that bear more than COUNTED of the load `missed` and `invented`; `off_share` of the poses at which the resultant
        is off by more than OFF; for every quantity p99, p999, max, where the
        worst is, and `by_region` p99, p999 and max of each part: resultant normal_percent, its parts lateral_percent
        and vertical_percent, all over the true resultant; load centre on the wheel centre_mm and rolling radius_mm,
        means by the load. Without the quantities when there was nothing to compare.
    """
    mounting = mount(wheel, rail, table.settings)
    low = mounting.wheel_start
    station = np.arange(low, low + mounting.wheel_step * (mounting.wheel.shape[0] - 1), FINE)
    law, look, edges = direct(mounting, table.settings), LookUp(table), wheel_regions(mounting)
    depths = np.random.default_rng((seed, 1)).uniform(*DEPTHS, poses)
    errors, regions, where = [], [], []
    missed = invented = refused = 0
    for number, (pose, depth) in enumerate(zip(random_poses(table.settings, poses, seed), depths, strict=True)):
        if progress and number % 200 == 0:
            progress(number / poses)
        mirror = pose[0], pose[1], abs(pose[2])
        minima = direct_minima(mounting, mirror, station)
        if minima.shape[0] == 0:
            continue
        touch, cosine = first_touch(mounting, mirror, minima)
        z = touch + depth / cosine
        true, looked = law(mirror, z, minima), look(tuple(pose), z)
        if looked is None:
            refused += 1
            continue
        few, many = unlike(looked, true)
        missed, invented = missed + few, invented + many
        errors.append(_errors(looked, true))
        regions.append(REGIONS[np.searchsorted(edges, true.place[np.argmax(true.share)])])
        where.append((*pose, depth))
    errors, regions, where = np.array(errors).reshape(-1, len(QUANTITIES)), np.array(regions), np.array(where)
    certificate = {"compared": len(errors), "refused": refused, "missed": missed, "invented": invented}
    if not len(errors):
        return certificate
    certificate["off_share"] = float((errors[:, 0] > OFF).mean())
    parts = {region.name.lower(): regions == region for region in Region if (regions == region).any()}
    certificate["by_region"] = {name: int(part.sum()) for name, part in parts.items()}
    for name, column in zip(QUANTITIES, errors.T, strict=True):
        worst = where[np.argmax(column)] * [1e3, 1e3, 1e3, 1e6]
        certificate[name] = {
            **largest(column),
            "worst_at": dict(zip(("y_mm", "roll_mrad", "yaw_mrad", "depth_um"), worst.tolist(), strict=True)),
            "by_region": {key: largest(column[part]) for key, part in parts.items()},
        }
    return certificate


def shortcomings(forces):
    """Sentences that say in what a certificate of forces falls short of LIMITS; none for a good table."""
    if not forces["compared"]:
        return ["no force could be compared"]
    texts = [
        f"p99 of {key} is {forces[key]['p99']:.3g}, allowed: {limit:g}"
        for key, limit in LIMITS.items()
        if not forces[key]["p99"] <= limit
    ]
    allowed = MOST_UNLIKE * forces["compared"]
    texts += [
        f"{forces[key]} patches {key}, allowed: {allowed:.0f} at {forces['compared']} poses"
        for key in ("missed", "invented")
        if forces[key] > allowed
    ]
    return [*texts, f"{forces['refused']} poses refused by the look-up"] if forces["refused"] else texts


def beyond_aims(forces):
    """What exceeds AIMS: quantity and part of the wheel (None: all poses) to its p99, p99.9 and largest error."""
    found = {}
    for key, aims in AIMS.items():
        for part, errors in {None: forces[key], **forces[key]["by_region"]}.items():
            sizes = tuple(errors[size] for size in SIZES)
            if any(size > aim for size, aim in zip(sizes, aims, strict=True)):
                found[key, part] = sizes
    return found


def _errors(looked, true):
    """In the order of QUANTITIES; a load that is lost leaves its place where the law has it."""
    per = 100.0 / true.normal
    forces = [abs(a - b) * per for a, b in ((looked.normal, true.normal), (looked.y, true.y), (looked.q, true.q))]
    if not looked.share.sum() > 0.0:
        return *forces, 0.0, 0.0
    apart = [looked.mean(getattr(looked, key)) - true.mean(getattr(true, key)) for key in ("place", "radius")]
    return *forces, *(abs(each) * 1e3 for each in apart)
