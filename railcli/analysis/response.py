"""Frequency response of the linear model to displaced rails (docs/stability.md, section 6)."""

from dataclasses import dataclass

import numpy as np

from .mode_shapes import groups

INPUTS = {  # axis of the displacement, and its sign on the right and on the left rail
    "vertical": (2, 1.0, 1.0),  # both rails down
    "lateral": (1, 1.0, 1.0),  # both rails to the right
    "cross_level": (2, 0.5, -0.5),  # right rail down against the left one
    "gauge": (1, 0.5, -0.5),  # rails apart
}

FREQUENCIES = np.geomspace(0.1, 100.0, 301)  # [Hz]


@dataclass(frozen=True)
class Response:
    """Complex amplitudes per metre of a harmonic displacement of the rails, under the first wheelset in phase.

    Attributes
    ----------
    frequency : array (n,)
        [Hz]
    acceleration : complex array (n, n_body, 2)
        Lateral and vertical, of the centres of the bodies [1/s^2].
    over_bogies : complex array (n, k, 2)
        The same of the car bodies, at their own height, over each body that carries them.
    wheel : complex array (n, n_wheel, 2)
        Changes of Y and Q [N/m].
    """

    frequency: np.ndarray
    acceleration: np.ndarray
    over_bogies: np.ndarray
    wheel: np.ndarray


def inputs(linear, kind):
    """What displaced rails do: dx/dt = A x + sum over wheels of (still d + moving dd/dt), columns (n_wheel, n).

    A wheel sees its rail by their relative place and motion only, so a displaced rail is a displaced wheelset with the
    opposite sign, in the part of the matrix that this wheel's contact makes.
    """
    axis, right, left = INPUTS[kind]
    sign = np.where(linear.system.model.wheel["side"] > 0.0, right, left)[:, None]
    return -sign * linear.contact[:, :, axis], -sign * linear.contact[:, :, 6 + axis]


def carried(model):
    """Pairs (car body, what carries it)."""
    of = groups(model)
    return [(int(j["upper"]), int(j["lower"])) for j in model.joint if of[j["upper"]] == "car body"]


def response(linear, kind, frequencies):
    """Response to a sine of the rails along the track, which each wheelset meets as it comes.

    Parameters
    ----------
    linear : Linear
        Made with ``contact=True``.
    kind : str
        A key of INPUTS.
    frequencies : array_like
        [Hz], positive.

    Returns
    -------
    Response
    """
    model, q = linear.system.model, linear.data.q
    n, bodies = q.size, model.wheel["body"]
    still, moving = inputs(linear, kind)
    axis, right, left = INPUTS[kind]
    side = np.where(model.wheel["side"] > 0.0, right, left)
    ahead = (q[bodies, 0] - q[bodies, 0].max()) / linear.speed
    pairs = carried(model)
    eye = np.eye(linear.matrix.shape[0])
    rows = {name: [] for name in ("acceleration", "over", "wheel")}
    for frequency in np.asarray(frequencies, float):
        s = 2j * np.pi * frequency
        lag = np.exp(s * ahead)
        x = np.linalg.solve(s * eye - linear.matrix, lag @ (still + s * moving))
        full = linear.expand(x)
        at, v = full[:n].reshape(q.shape), full[n : 2 * n].reshape(q.shape)
        rows["acceleration"].append(s * s * at[:, 1:3])
        rows["over"].append([_over(s * s * at[i], q[j, 0] - q[i, 0]) for i, j in pairs])
        rows["wheel"].append(_forces(linear, model, at, v, side[:, None] * lag[:, None] * np.array([1.0, s]), axis))
    return Response(
        np.asarray(frequencies, float),
        np.array(rows["acceleration"]),
        np.array(rows["over"]).reshape(len(rows["over"]), len(pairs), 2),
        np.array(rows["wheel"]),
    )


def responses(linear):
    """Responses to every kind of displacement at FREQUENCIES, by the names of INPUTS."""
    return {kind: response(linear, kind, FREQUENCIES) for kind in INPUTS}


def _over(a, x):
    """Lateral and vertical acceleration of a body at distance x before its centre."""
    return a[1] + x * a[5], a[2] - x * a[4]


def _forces(linear, model, at, v, rail, axis):
    """Changes of Y and Q of every wheel; rail : displacement and velocity of its rail along `axis`, (n_wheel, 2)."""
    n = at.size
    found = np.empty((model.wheel.size, 2), complex)
    place = {int(k): row for row, k in enumerate(linear.kept)}
    for w, i in enumerate(model.wheel["body"].tolist()):
        relative = np.concatenate([at[i], v[i]])
        relative[axis] -= rail[w, 0]
        relative[6 + axis] -= rail[w, 1]
        for k in (1, 2):
            found[w, k - 1] = -model.body[i]["mass"] * linear.contact[w, place[n + 6 * i + k]] @ relative
    return found
