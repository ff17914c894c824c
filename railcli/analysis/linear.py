"""The compiled model about its steady motion on straight level track, linearised by differences of its state.

State x = (q, v, damper, yielded): coordinates, velocities, states of the elements and places of moving rails, as `Data`
has them. dx/dt = (rate, dv, damper_rate, yielding) is what `evaluate` gives (docs/stability.md, section 1).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from railcli.errors import SimulationError
from railcli.kernels.layout import NO_SHIFT, Status, freeze
from railcli.kernels.step import evaluate
from railcli.model.track import Straight, Track, pack

from .equilibrium import steady

STEP = np.array([1e-7] * 6 + [1e-4] * 6)  # of q [m, rad] and v [m/s, rad/s]; dampers as q (docs/stability.md, 1.2)
FREE = 1e-3  # an eigenvalue this small belongs to a motion that nothing holds [1/s]


@dataclass(frozen=True)
class Linear:
    """dx/dt = A x about a steady motion.

    Attributes
    ----------
    system : System
        On straight level track.
    data : Data
        The steady motion.
    speed : float
        [m/s]
    matrix : array (n, n)
        A, without the states that nothing depends on.
    kept : array (n,)
        Places of its states in (q, v, damper, yielded).
    contact : array (n_wheel, n, 12)
        Of each wheel: slopes of dx/dt over the q and v of its wheelset that its contact makes; empty unless asked for.
    """

    system: object
    data: object
    speed: float
    matrix: np.ndarray
    kept: np.ndarray
    contact: np.ndarray

    @property
    def size(self):
        """Number of bodies."""
        return self.data.q.shape[0]

    def expand(self, x):
        """States (..., n) in the places of (q, v, damper, yielded), zero elsewhere."""
        full = np.zeros((*x.shape[:-1], 12 * self.size + self.data.damper.size + self.data.yielded.size), x.dtype)
        full[..., self.kept] = x
        return full

    def coordinates(self, x):
        """Displacements (..., n_body, 6) of states (..., n)."""
        return self.expand(x)[..., : 6 * self.size].reshape(*x.shape[:-1], self.size, 6)


def linearise(system, speed=None, scale=1.0, contact=False):
    """Linearise a system about its steady motion on straight level track.

    Parameters
    ----------
    system : System
    speed : float, optional
        [m/s]; the system's own when absent.
    scale, contact
        As `linear_about`.

    Returns
    -------
    Linear

    Raises
    ------
    SimulationError
        No steady motion was found, or a wheel leaves its contact within a difference step.
    """
    speed = system.speed if speed is None else speed
    data = steady(system, 0.0, 0.0, speed).data
    return linear_about(system, data, speed, scale, contact)


def linear_about(system, data, speed, scale=1.0, contact=False, curved=False):
    """Linearise a system about a steady motion: on straight level track, or on the constant curve of its own track.

    Nothing there depends on the common place along the track nor on the angles of the wheelsets' spin, so these
    states are left out; places along the track count from the first body. The force that holds the speed is a device of
    time runs and is left out too, but in a curve, where it takes part in the balance.

    Parameters
    ----------
    system : System
    data : Data
        The motion; kept.
    speed : float
        Its speed [m/s].
    scale : float
        Of the difference steps.
    contact : bool
        Also the part of each wheel's contact.
    curved : bool
        The motion is one on the system's own track, all of which must be one curve.

    Returns
    -------
    Linear
    """
    free = system if curved else on_straight(system, hold=0.0)
    full = _jacobian(free.model, data, scale)
    n = data.q.shape[0]
    spins = np.flatnonzero(free.model.body["spins"])
    full[6 * np.arange(1, n)] -= full[0]
    resting = 12 * n + np.flatnonzero(~full[12 * n :].any(axis=1))
    kept = np.setdiff1d(np.arange(full.shape[0]), [0, *(6 * spins + 4), *resting])
    parts = np.zeros((0, kept.size, 12))
    if contact:
        parts = _contact_parts(free, data, scale)[:, kept]
    return Linear(free, data, float(speed), full[np.ix_(kept, kept)], kept, parts)


def on_straight(system, length=1.0, **values):
    """The system on ideal straight level track of this length [m], with other values in its PARAM."""
    param = system.model.param.copy()
    for key, value in values.items():
        param[key] = value
    track = pack(Track((Straight(length=length),)))
    speed = float(param[0]["speed"])
    return replace(system, model=freeze(system.model._replace(param=param, track=track, shift=NO_SHIFT)), speed=speed)


def _probe(model, data, array, place, step):
    """Slope of (rate, dv, damper_rate, yielding) over one entry of a state array, by a central difference."""
    sides = []
    rest = array.flat[place]
    for sign in (1.0, -1.0):
        array.flat[place] = rest + sign * step
        status = evaluate(model, data, 0.0)
        if status != 0:
            reason = Status(status).name.lower().replace("_", " ")
            raise SimulationError(f"the model cannot be linearised: {reason} within a difference step of {step:g}")
        sides.append(np.concatenate([data.rate.ravel(), data.dv.ravel(), data.damper_rate, data.yielding.ravel()]))
    array.flat[place] = rest
    return (sides[0] - sides[1]) / (2.0 * step)


def _jacobian(model, data, scale):
    n = data.q.size
    matrix = np.empty((2 * n + data.damper.size + data.yielded.size,) * 2)
    for k in range(n):
        matrix[:, k] = _probe(model, data, data.q, k, scale * STEP[k % 6])
        matrix[:, n + k] = _probe(model, data, data.v, k, scale * STEP[6 + k % 6])
    for k in range(data.damper.size):
        matrix[:, 2 * n + k] = _probe(model, data, data.damper, k, scale * STEP[0])
    for k in range(data.yielded.size):
        matrix[:, 2 * n + data.damper.size + k] = _probe(model, data, data.yielded, k, scale * STEP[0])
    evaluate(model, data, 0.0)
    return matrix


def _contact_parts(system, data, scale):
    """Of each wheel: slopes over q and v of its wheelset that vanish with the wheel, (n_wheel, states, 12)."""
    model = system.model
    fixed = 2 * data.q.size + data.damper.size
    rails = ("yielded", "yielding", "dragged", "support", "wheel_damping")

    def slopes(wheel, i):
        part = freeze(model._replace(wheel=model.wheel[wheel].copy()))
        own = data._replace(**{name: getattr(data, name)[wheel] for name in rails})
        columns = [
            _probe(part, own, array, 6 * i + a, scale * STEP[shift + a])
            for array, shift in ((data.q, 0), (data.v, 6))
            for a in range(6)
        ]
        found = np.zeros((fixed + data.yielded.size, 12))
        first = fixed + 2 * wheel.start
        of_rail = own.yielded.size
        values = np.stack(columns, axis=1)
        found[:fixed], found[first : first + of_rail] = values[:fixed], values[fixed:]
        return found

    without = {i: slopes(slice(0, 0), i) for i in set(model.wheel["body"].tolist())}
    parts = [slopes(slice(w, w + 1), i) - without[i] for w, i in enumerate(model.wheel["body"].tolist())]
    evaluate(model, data, 0.0)
    return np.array(parts)


@dataclass(frozen=True)
class Modes:
    """Eigenvalues and eigenvectors of a Linear; of each conjugate pair the one with positive frequency.

    Attributes
    ----------
    linear : Linear
    value : complex array (m,)
        Sorted by frequency, those that do not oscillate behind [1/s].
    right, left : complex arrays (m, n)
        A right = value right, left^H A = value left^H, left^H right = 1; `right` scaled by `_scaled`.
    free : int
        Motions that nothing holds: eigenvalues below FREE, left out.
    """

    linear: Linear
    value: np.ndarray
    right: np.ndarray
    left: np.ndarray
    free: int

    @property
    def frequency(self):
        """Of the damped oscillation [Hz]."""
        return self.value.imag / (2.0 * np.pi)

    @property
    def damping(self):
        """Damping ratio, -Re / |value| [-]."""
        return -self.value.real / np.abs(self.value)

    @property
    def oscillates(self):
        return self.value.imag > 0.0

    def shift(self, other):
        """First-order change of the eigenvalues when the matrix becomes that of another Linear [1/s]."""
        change = other.matrix - self.linear.matrix
        return np.einsum("mi,ij,mj->m", self.left.conj(), change, self.right)


def roots(linear):
    """Eigenvalues that oscillate, of each pair the one with positive frequency [1/s]."""
    value = linalg.eigvals(linear.matrix)
    return value[value.imag > 0.0]


def modes(linear):
    """Eigenvalues and eigenvectors of a linearised system."""
    value, left, right = linalg.eig(linear.matrix, left=True)
    free = np.abs(value) < FREE
    keep = np.flatnonzero((value.imag >= 0.0) & ~free)
    keep = keep[np.lexsort((value[keep].real, value[keep].imag, value[keep].imag == 0.0))]
    value, right, left = value[keep], right[:, keep].T, left[:, keep].T
    right = np.array([_scaled(linear, row) for row in right]).reshape(right.shape)
    left = left / np.einsum("mi,mi->m", left.conj(), right).conj()[:, None]
    return Modes(linear, value, right, left, int(free.sum()))


def _scaled(linear, x):
    """An eigenvector with its largest coordinate (rotations times 1 m) real and 1."""
    q = linear.coordinates(x)
    return x / q.flat[np.argmax(np.abs(q))]
