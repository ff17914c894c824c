"""Equilibrium by Newton's method: at rest on straight track, and running steadily in a constant curve.

The unknowns of a steady motion are the coordinates of every body that do not grow (y, z, roll, yaw; pitch but for
wheelsets), the places of the bodies along the track against the first, the spin of the wheelsets and the one speed of
all bodies; the equations are all accelerations of the compiled model, 6 per body (theory.md section 9). Rails lie in
their ideal place: irregularity does not enter.
"""

from dataclasses import dataclass, replace

import numpy as np

from railcli.errors import SimulationError
from railcli.kernels.body import own_axes, sines
from railcli.kernels.contact import look_up
from railcli.kernels.heights import stored
from railcli.kernels.layout import MAX_CONTACT, NO_SHIFT, NODE_CHANNELS, SAMPLE_ROWS, Kind, Node, freeze
from railcli.kernels.step import advance, evaluate
from railcli.model.rails import constant as constant_rails
from railcli.model.sections import Gradient, Straight, Transition
from railcli.model.system import hold_gain
from railcli.model.track import Track, constant_track, pack

GROWN = 2  # times that the force which holds the speed takes over what an error of the speed asks of it
SETTLED = 1e9  # half step for which dampers, dry friction and moving rails are at rest [s]
PROBE = 1e-8  # difference step of coordinates [m, rad]; rates take 100 times as much
TOLERANCE = 1e-7  # largest acceleration that counts as zero [m/s^2, rad/s^2]; `_Steady.rounding` adds to it
PLACE_ROUNDING = 8.0 * np.finfo(float).eps  # of a sum of some coordinates, by the largest of them
ITERATIONS = 60
SETTLING = 12.0  # time in the curve after which a run serves as a first guess [s]
RUN_IN = 60.0  # lengths of straight and of transition before it [m]
HEIGHT_AND_ROLL = [2, 3]  # coordinates of a wheelset
SEATED = 10.0  # force and moment that may be left when a wheelset has been set down [N, N m]
SINK = 0.2e-3  # largest move of one iteration of that [m, rad]
TRIES = 30
PRESSED = 0.1e-3  # penetration to begin with [m]
SHORTEST_STRIDE = 1e-3  # of the way from straight track to the curve


@dataclass(frozen=True)
class Equilibrium:
    """A solved equilibrium.

    Attributes
    ----------
    data : Data
        The core's data there, forces included.
    residual : float
        Largest acceleration left, by the rounding of stiff elements [m/s^2, rad/s^2].
    iterations : int
    """

    data: object
    residual: float
    iterations: int


class _Steady:
    """Unknowns of a steady motion and the accelerations that belong to them."""

    def __init__(self, system, model, speed, s, held=None, blurred=None):
        """blurred : `rounding` of the model, where it is known."""
        self.model, self.s = model, s
        self.held = held or {}
        self.data = system.start(s)
        self.rest = system.rest
        self.damper = system.damper
        self.radii = system.radii
        spins = model.body["spins"].astype(bool)
        n = spins.size
        coordinate = np.zeros((n, 6), bool)
        coordinate[:, [1, 2, 3, 5]] = True
        coordinate[~spins, 4] = True
        coordinate[1:, 0] = True
        coordinate[list(self.held), 1] = False
        self.free = np.ones(6 * n, bool)
        self.free[[6 * i + 1 for i in self.held]] = False
        self.coordinate = coordinate
        self.spins = spins
        blurred = rounding(model, self.rest) if blurred is None else blurred
        self.tolerance = TOLERANCE + blurred.ravel()[self.free]
        self.moving = speed > 0.0
        rate = np.zeros(n) if not self.moving else np.where(spins, 1.0, 0.0)
        self.n_q = int(coordinate.sum())
        self.n_spin = int(rate.sum())
        self.size = self.n_q + self.n_spin + (1 if self.moving else 0)
        self.q, self.v = np.zeros((n, 6)), np.zeros((n, 6))  # places, and velocities without spin
        for i, y in self.held.items():
            self.q[i, 1] = y
        self.at = np.flatnonzero(coordinate)
        self.spinning = np.flatnonzero(spins)
        self.given = [()] * n  # what decided the velocities of each body
        self.scale = np.concatenate(
            [np.full(self.n_q, 1.0), np.full(self.n_spin, 100.0), np.full(self.size - self.n_q - self.n_spin, 100.0)]
        )

    def first_guess(self, speed):
        x = np.zeros(self.size)
        q = self.rest.copy()
        q[:, 2] += touching_depth(self.model) + PRESSED
        for right in range(0, self.model.wheel.size, 2):
            body, other = self.model.wheel[right : right + 2]["body"]
            if body == other and sides_differ(self.model, right):
                q[body, 2], q[body, 3] = seat(self.model, right)
                q[body, 2] += PRESSED
        x[: self.n_q] = q[self.coordinate]
        if self.moving:
            x[self.n_q : -1] = -speed / self.radii[self.spins]
            x[-1] = speed
        return x

    def unknowns(self, data):
        """The unknowns at the motion that data holds."""
        q = data.q.copy()
        q[:, 0] -= q[0, 0]
        return np.concatenate([q[self.coordinate], data.rate[self.spins, 4], data.rate[:1, 0]])

    def place(self, x, turning):
        """Write the motion x into data; turning : rotation of the track frame per metre [1/m]."""
        data = self.data
        self.q.ravel()[self.at] = x[: self.n_q]
        data.q[:] = self.q
        data.q[:, 0] += self.s
        data.v[:] = 0.0
        data.dv[:] = 0.0
        if not self.moving:
            return
        speed = x[-1]
        if not any(turning):
            data.v[:, 0] = speed
            data.v[self.spins, 4] = x[self.n_q : -1]
            return
        for i, place in enumerate(self.q[:, 1:].tolist()):
            given = (*place, speed, turning)
            if self.given[i] != given:  # most evaluations move one body of all
                self.given[i], self.v[i] = given, self._velocity(i, *given)
        data.v[:] = self.v
        data.v[self.spinning, 4] += x[self.n_q : -1]

    def _velocity(self, i, y, z, roll, pitch, yaw, speed, turning):
        """Velocities (6,) of a body that is carried along by a track frame that turns, without its spin."""
        kx, ky, kz = turning
        axes = own_axes(*sines(roll, pitch, yaw, self.spins[i]))
        carried = speed * (1.0 + ky * z - kz * y), -speed * kx * z, speed * kx * y
        return *carried, *(speed * (kx * x + ky * y + kz * z) for x, y, z in zip(*axes, strict=True))

    def accelerations(self, x, turning):
        self.place(x, turning)
        status = evaluate(self.model, self.data, SETTLED)
        if status != 0:
            return None, status
        return self.data.dv.ravel()[self.free], 0

    def size_of(self, accelerations):
        """Largest acceleration; those of stiff elements on light bodies count less, by their rounding."""
        return TOLERANCE * np.abs(accelerations / self.tolerance).max()


def rounding(model, rest):
    """Accelerations (n_body, 6) that rounding of places makes in the elements of each body [m/s^2, rad/s^2].

    The ends of an element are known to some rounding of the vehicle's length, and its force to its stiffness times
    that: for stiff elements on light bodies more than TOLERANCE.
    """
    found = np.zeros((model.body.size, 6))
    blurred = PLACE_ROUNDING * max(np.abs(rest).max(), 1.0)
    for joint in model.joint:
        for row in model.element[joint["first"] : joint["first"] + joint["count"]]:
            stiffness = row["k"].max() + row["series"]
            if row["matrix"] >= 0:
                stiffness += np.abs(model.matrix[row["matrix"], :6]).max()
            for curve in model.curve[row["spring_curve"][row["spring_curve"] >= 0]]:
                n = curve["count"]
                stiffness += (np.diff(curve["y"][:n]) / np.diff(curve["x"][:n])).max()
            for end in ("lower", "upper"):
                found[joint[end], :3] += stiffness * blurred
                found[joint[end], 3:] += stiffness * blurred * max(np.abs(row[end]).max(), 0.1)
        for end in ("lower", "upper"):
            found[joint[end], 3:] += PLACE_ROUNDING * joint["turn"].max()
    found[:, :3] /= model.body["mass"][:, None]
    found[:, 3:] /= model.body["inertia"]
    return found


def sides_differ(model, right):
    """True when the right wheel of this index and the left one beside it differ in radius or contact table."""
    return bool((model.wheel[right : right + 2][["radius", "table"]] != model.wheel[right][["radius", "table"]]).any())


def seat(model, right):
    """Height z [m] and roll [rad] of a centred wheelset that touches both rails; `right` its right wheel."""
    wheels = model.wheel[right : right + 2]
    heights = [touching_depth(model, right + k) - wheels[k]["radius"] for k in (0, 1)]
    return 0.5 * sum(heights), np.arcsin(0.5 * (heights[0] - heights[1]) / wheels[0]["lateral"])


def set_down(model, data, i, carried):
    """Put a wheelset on its rails at its lateral place: they carry a load there.

    Parameters
    ----------
    model : Model
        Without joints.
    data : Data
        Its heights and rolls are first guesses; those of the wheelset move.
    i : int
        Of its body.
    carried : array (2,)
        Vertical force and roll moment that are left when the rails do [N, N m].

    Returns
    -------
    bool
        False if it cannot stand there.
    """
    for _ in range(TRIES):
        if evaluate(model, data, SETTLED):
            return False
        left = data.load[i, HEIGHT_AND_ROLL] - carried
        if np.abs(left).max() < SEATED:
            return True
        slopes = np.empty((2, 2))
        for column, k in enumerate(HEIGHT_AND_ROLL):
            rest = data.q[i, k]
            data.q[i, k] = rest + PROBE
            status = evaluate(model, data, SETTLED)
            data.q[i, k] = rest
            if status:
                return False
            slopes[:, column] = (data.load[i, HEIGHT_AND_ROLL] - carried - left) / (PROBE)
        if np.linalg.det(slopes) == 0.0:
            return False
        data.q[i, HEIGHT_AND_ROLL] += np.clip(np.linalg.solve(slopes, -left), -SINK, SINK)
    return False


def touching_depth(model, index=0):
    """How far a wheel must sink from nominal, centred and upright, until it touches its rail [m]."""
    deep = 5e-3
    sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))
    wheel = model.wheel[index]
    table = model.table[wheel["table"]]
    if table["levels"] >= 0:
        return _first_force(model, table, sample, deep)
    if look_up(table, model.node, model.cell, model.branch, 0.0, 0.0, 0.0, deep, sample) < 1:
        raise SimulationError("a centred wheel does not touch its rail within 5 mm of its nominal height")
    return deep - sample[:MAX_CONTACT, Node.GAP].max()


def _first_force(model, table, sample, deep):
    """As `touching_depth`, from a table of heights."""

    def force(depth):
        return stored(table, model.cell, model.branch, model.heights, 0.0, 0.0, 0.0, depth, 0, sample)[4]

    low, high = -deep, deep
    if force(low) > 0.0 or not force(high) > 0.0:
        raise SimulationError("a centred wheel does not touch its rail within 5 mm of its nominal height")
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if force(middle) > 0.0 else (middle, high)
    return high


def _newton(motion, x, turning):
    """Damped Newton; the least-norm step leaves free what no force decides. Returns x, residual, iterations.

    At least one step is taken, for a guess that is all but right. The residual is the largest acceleration over
    its tolerance, times TOLERANCE.
    """
    r, status = motion.accelerations(x, turning)
    if r is None:
        return x, np.inf, 0
    for iteration in range(1, ITERATIONS + 1):
        size = motion.size_of(r)
        if size < TOLERANCE and iteration > 1:
            return x, size, iteration - 1
        jacobian = np.empty((r.size, x.size))
        for k in range(x.size):
            probe = x.copy()
            probe[k] += PROBE * motion.scale[k]
            other, status = motion.accelerations(probe, turning)
            if other is None:
                return x, np.inf, iteration
            jacobian[:, k] = (other - r) / PROBE
        move = np.linalg.lstsq(jacobian, -r, rcond=1e-12)[0] * motion.scale
        share = 1.0
        while share > 1e-3:
            after, _ = motion.accelerations(x + share * move, turning)
            if after is not None and np.linalg.norm(after) < (1.0 - 0.1 * share) * np.linalg.norm(r):
                break
            share *= 0.5
        else:
            return x, size, iteration
        x, r = x + share * move, after
    return x, motion.size_of(r), ITERATIONS


def _finish(motion, x, turning, residual, iterations):
    """The motion x, with the states of dampers and friction that belong to no force of theirs."""
    motion.accelerations(x, turning)
    motion.data.damper[:] += SETTLED * motion.data.damper_rate
    settle_rails(motion.data)
    return Equilibrium(motion.data, float(residual), iterations)


def settle_rails(data):
    """Put rails that give way to where what was evaluated with SETTLED presses them."""
    data.yielded[:] += SETTLED * data.yielding
    data.yielding[:] = 0.0


def static(system):
    """The vehicle at rest on straight level track.

    Wheelsets whose sides differ stand centred: friction keeps them there, and forces that would move them are not
    looked at. Constant torques are off.

    Returns
    -------
    Equilibrium

    Raises
    ------
    SimulationError
        No equilibrium was found.
    """
    param, element = system.model.param.copy(), system.model.element.copy()
    param["speed"] = 0.0
    element["preload"][element["kind"] == Kind.TORQUE] = 0.0
    track = pack(constant_track(0.0, 0.0))
    model = freeze(system.model._replace(param=param, track=track, shift=NO_SHIFT, element=element))
    wheels = model.wheel
    held = {wheels[i]["body"]: 0.0 for i in range(0, wheels.size, 2) if sides_differ(model, i)}
    motion = _Steady(system, model, 0.0, 0.0, held)
    x, residual, iterations = _newton(motion, motion.first_guess(0.0), (0.0, 0.0, 0.0))
    if not residual < TOLERANCE:
        raise SimulationError(f"no static equilibrium found: an acceleration of {residual:.2g} m/s^2 stays")
    return _finish(motion, x, (0.0, 0.0, 0.0), residual, iterations)


def _follow(solve, x, stride=0.25):
    """Follow a solution while a share goes from 0 to 1, in strides that shrink where Newton's method fails.

    solve : called with the share and a first guess; returns motion, x, turning, residual and iterations.
    Returns the last motion, x, turning, residual and all iterations; a residual beyond TOLERANCE says that it stopped.
    """
    done, total = 0.0, 0
    while True:
        share = min(done + stride, 1.0)
        motion, after, turning, residual, iterations = solve(share, x)
        total += iterations
        if residual < TOLERANCE:
            x, done, stride = after, share, 1.5 * stride
            if done == 1.0:
                return motion, x, turning, residual, total
            continue
        stride *= 0.5
        if stride < SHORTEST_STRIDE:
            return motion, after, turning, residual, total


def _turning(curvature, cant, base, gradient):
    """Rotation of the track frame per metre where curvature, cant and gradient are constant, in track axes [1/m]."""
    sine, angle = cant / base, np.arctan(gradient)
    level = curvature * np.cos(angle)
    return -curvature * np.sin(angle), level * sine, level * np.sqrt(1.0 - sine**2)


def steady(system, curvature, cant, speed=None, lateral=None, gradient=0.0, aside=(0.0, 0.0)):
    """Quasi-static curving: the steady motion at constant speed in a constant curve, on a constant gradient.

    Found by Newton's method while curvature, cant and gradient grow together from straight level track. In a vertical
    curve there is no steady motion, because the direction of the weight changes.

    Parameters
    ----------
    system : System
    curvature : float
        Positive in a right-hand curve [1/m].
    cant : float
        Height of the left over the right rail [m].
    speed : float, optional
        Asked for [m/s]; the system's own when absent.
    lateral : dict of int to float, optional
        Bodies that a lateral force brings from their steady place to this lateral position [m] and keeps there:
        minus data.load[i, 1] of the result [N].
    gradient : float
        Rise over horizontal length [-].
    aside : pair of float
        Left and right rail stand to the right of their nominal places by this [m].

    Returns
    -------
    Equilibrium

    Raises
    ------
    SimulationError
        No steady motion was found: there is none, or it is not smooth there.
    """
    speed = system.speed if speed is None else speed
    system = system.passive()
    param = system.model.param.copy()
    param["speed"] = speed
    if system.model.assembly[0]["free"]:  # nobody holds its speed in the run; here a force does
        param["hold"] = hold_gain(system.model.body[0]["mass"], float(param[0]["step"]))
    base = param[0]["cant_base"]
    blurred = rounding(system.model, system.rest)

    def into_curve(share, x):
        track = pack(constant_track(share * curvature, share * cant), gradients=rising(share * gradient))
        own = param.copy()
        shift, own["shift_start"], own["shift_step"] = constant_rails(*(share * rail for rail in aside))
        model = freeze(system.model._replace(param=own, track=track, shift=shift))
        motion = _Steady(system, model, speed, 0.0, blurred=blurred)
        turning = _turning(share * curvature, share * cant, base, share * gradient)
        return (motion, *_solve(motion, motion.first_guess(speed) if x is None else x, turning))

    is_straight = curvature == 0.0 and cant == 0.0
    motion, x, turning, residual, total = _follow(into_curve, None, 1.0 if is_straight else 0.25)
    if not residual < TOLERANCE:
        motion, x, turning, residual, more = into_curve(1.0, _settle(system, param, curvature, cant, speed, gradient))
        total += more
    if residual < TOLERANCE and lateral:
        model = motion.model
        own = {i: motion.data.q[i, 1] for i in lateral}
        free_x = _Steady(system, model, speed, 0.0, own).unknowns(motion.data)

        def pushed(share, x):
            there = {i: own[i] + share * (lateral[i] - own[i]) for i in lateral}
            motion = _Steady(system, model, speed, 0.0, there)
            return (motion, *_solve(motion, x, turning))

        motion, x, turning, residual, more = _follow(pushed, free_x)
        total += more
    if not residual < TOLERANCE:
        raise SimulationError(
            f"no steady motion found at {speed:g} m/s, curvature {curvature:.4g} 1/m, cant {cant * 1e3:.3g} mm, "
            f"gradient {gradient * 1e3:.3g} per mille: an acceleration of {residual:.2g} m/s^2 stays"
        )
    for _ in range(GROWN if speed > 0.0 else 0):
        motion.data.held[:] = motion.data.traction
        x, turning, residual, more = _solve(motion, x, turning)
        total += more
    return _finish(motion, x, turning, residual, total)


def rising(gradient):
    """Gradients of a track that rises by the same slope everywhere."""
    return (Gradient(gradient=gradient),)


def _settle(system, param, curvature, cant, speed, gradient):
    """First guess from a run into the curve, SETTLING long: where the path from straight track is not smooth."""
    curve = constant_track(curvature, cant).sections[0]
    into = Straight(length=RUN_IN), Transition(length=RUN_IN)
    track = Track((*into, curve.model_copy(update={"length": speed * SETTLING + RUN_IN})))
    track = pack(track, gradients=rising(gradient))
    run = replace(system, model=freeze(system.model._replace(param=param, track=track, shift=NO_SHIFT)), speed=speed)
    data = run.start()
    data.q[:, 2:] = static(system).data.q[:, 2:]
    advance(run.model, data, round((2.0 * RUN_IN / speed + SETTLING) / param[0]["step"]))
    return _Steady(system, run.model, speed, 0.0).unknowns(data)


def _solve(motion, guess, turning):
    x, residual, iterations = _newton(motion, guess, turning)
    motion.accelerations(x, turning)
    return x, turning, residual, iterations
