"""The certificate of forces of a contact table: its look-up against the same law evaluated directly at random poses."""

import numpy as np

from railcli.kernels.contact import elastic_share, look_up
from railcli.kernels.heights import stored
from railcli.kernels.layout import MAX_CONTACT, NODE_CHANNELS, SAMPLE_ROWS, Node, Part, Region
from railcli.model.contact_table import mount

from .build_table import wheel_regions
from .certify import FINE, SEED, direct_minima, largest, random_poses
from .overlap import Law
from .patches import describe_minima, loaded

DEPTHS = 10e-6, 120e-6  # beyond first touch, along the normal of the part that touches first: working depths [m]
QUANTITIES = ("normal_percent", "lateral_percent", "vertical_percent", "centre_mm", "radius_mm")
COUNTED = 0.01  # share of the load above which a patch is missed or invented [-]
GOALS = {"normal_percent": (0.5, 1.0, 3.0), "centre_mm": (0.05, 0.1, 0.3)}  # p99, p99.9 and largest


def forces_stored(table, pose, z, sample):
    """Lateral and vertical force [N], patches (share, place [m], radius [m]) of a look-up; None off the table."""
    record = table.record[0]
    if table.settings.stores_heights:
        count, _, y, q, *_ = stored(record, table.cell, table.branch, table.heights, *_split(pose), z, sample)
        if count < 0 or count > MAX_CONTACT:
            return None
        rows = sample[:count]
        return y, q, rows[:, [Part.SHARE, Part.LATERAL, Part.RADIUS]].copy()
    count = look_up(record, table.node, table.cell, table.branch, *pose, z, sample)
    if count < 0 or count > MAX_CONTACT:
        return None
    return _summed(sample, count)


def _split(pose):
    return pose[0], pose[1], pose[2]


def _summed(rows, count):
    cosines = 1.0 / np.sqrt(1.0 + rows[:count, Node.SLOPE] ** 2)
    elastic = np.array([elastic_share(rows, count, j, cosine) for j, cosine in enumerate(cosines)])
    normal = rows[:count, Node.HERTZ] * elastic
    total = max(normal.sum(), 1e-300)
    y, q = -np.sum(normal * cosines * rows[:count, Node.SLOPE]), np.sum(normal * cosines)
    return y, q, np.column_stack([normal / total, rows[:count, Node.LATERAL], rows[:count, Node.RADIUS]])
