"""Two bodies in free space joined by elements: what the tests of force elements share."""

import naive
import numpy as np
import scenes
from scipy.spatial.transform import Rotation

from railcli.kernels.layout import CURVE, ELEMENT, JOINT, new_data
from railcli.kernels.step import evaluate
from railcli.model.track import constant_track

LEVEL = constant_track(0.0, 0.0)


def element(kind, rng, **values):
    row = np.zeros(1, ELEMENT)[0]
    row["kind"] = kind
    row["lower"], row["upper"] = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
    for key in ("spring_curve", "damper_curve", "stiff", "state", "source", "matrix"):
        row[key] = -1
    for key, value in values.items():
        row[key] = value
    return row


def passive(rng):
    """Symmetric matrix (6, 6) without negative eigenvalues."""
    root = rng.uniform(-1, 1, (6, 6))
    return 1e5 * root @ root.T


def pair(wagon, axes, elements, turn=(0.0, 0.0, 0.0), spins=(0, 0)):
    """Two bodies of unit mass and inertia joined by elements, far from the origin of the ground axes."""
    rng = np.random.default_rng(7)
    matrix = np.array([np.concatenate([passive(rng), 0.05 * passive(rng)])])
    curves = np.zeros(2, CURVE)
    points = [([-0.3, -0.1, 0.1, 0.4], [-5e4, 0, 0, 9e4]), ([-1, 0, 0.2], [-1e3, 0, 4e4])]
    for row, (x, y) in zip(curves, points, strict=True):
        row["count"], row["x"][: len(x)], row["y"][: len(y)] = len(x), x, y
    joint = np.zeros(1, JOINT)
    joint["upper"], joint["count"], joint["axes"], joint["turn"] = 1, len(elements), axes, turn
    free = scenes.bodies(wagon, np.ones(2), np.ones((2, 3)), np.array(spins))
    element = np.array(elements, ELEMENT).reshape(-1)
    free = scenes.replaced(free, joint=joint, element=element, curve=curves, matrix=matrix)
    return scenes.floating(free, LEVEL)


def somewhere(rng, angle=0.8):
    """Coordinates of both bodies, up to a metre and `angle` [rad] from each other."""
    q = rng.uniform(-0.4, 0.4, (2, 6))
    q[:, 3:] = rng.uniform(-angle, angle, (2, 3)) / 2
    q[:, 0] += 5.0
    return q


def forces(system, q, v=None, damper=(0.3,), half_step=0.0):
    """Force and moment about the centre of both bodies, in ground axes, and the data."""
    data = new_data(system.model, q, len(damper))
    data.damper[:] = damper
    data.v[:] = 0.0 if v is None else v
    assert evaluate(system.model, data, half_step) == 0
    return data.frame["force"].copy(), data.frame["moment"].copy(), data


def poses(q):
    return [naive.body_pose(LEVEL, row, 1.5) for row in q]


def moved(pose, k, h):
    """A pose displaced by h along (k < 3) or turned by h about ground axis k - 3."""
    position, axes = pose
    step = h * np.eye(3)[k % 3]
    return (position + step, axes) if k < 3 else (position, Rotation.from_rotvec(step).as_matrix() @ axes)
