"""Longest stable step of a model: from the compiled step itself, and by a rule for wheelsets aside (theory.md 8.4).

Two limits, of which the lesser counts. The compiled step, linearised about the vehicle rolling on straight track: the
spectral radius of its Jacobian. And for each wheelset, at every lateral place up to its flanges, the rule
h^2 K/4 + h C <= M for what the step treats explicitly, which creep is not.
"""

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from railcli.errors import SimulationError
from railcli.kernels.layout import NO_SHIFT, Kind, freeze
from railcli.kernels.step import advance, evaluate
from railcli.model.track import constant_track, pack

from .equilibrium import set_down
from .faults import sentence
from .simulate import settled_start

MARGIN = 1.2  # of the stable over the allowed step: loads of three times the static ones stiffen a contact by 1.44
CEILING = 2.4e-3  # a longer step is not looked for [s]
FLOOR = 1e-7  # nor a shorter one [s]
ACCURACY = 1.01  # ratio within which a limit is found
STATE = {  # arrays of the state, difference steps
    "q": 1e-7, "v": 1e-5, "dv": 1e-2, "damper": 1e-7, "tension": 1.0, "yielded": 1e-7, "yielding": 1e-5, "dragged": 1.0,
}  # fmt: skip
SIZE = {  # of each in one mode
    "q": 1.0, "v": 1e2, "dv": 1e5, "damper": 1.0, "tension": 1e7, "yielded": 1.0, "yielding": 1e2, "dragged": 1e7,
}  # fmt: skip
FORCE = 1.0, 1e6  # both for states that are forces [N]
SMALL = 0.1  # of the limit of dry friction: what a difference step may load it with
ROUNDING = 1e-4  # by which differences may lift the magnitude of an eigenvalue over 1
GROWTH = 50.0  # fastest growth of an oscillation that belongs to the vehicle and not to the step [1/s]
PLACES = 0.1e-3  # between two lateral places of a wheelset [m]
OUTERMOST = 20e-3  # where the last one is at most [m]
PRESSED = 10e3, 1.0 / 3.0  # up to which sum Y it is pressed: 10 kN and a third of its load, the limit of EN 14363
SECOND = 0.5  # of the share of the first part in a growing disturbance, from which a second one is named
LIFTED = 5e-3  # by which wheels off their rails are smaller [m]
CROSSWISE = [1, 2, 3, 5]  # y, z, roll, yaw
MOVES = ("moves along the track", "moves sideways", "bounces", "rolls", "pitches", "yaws")


APART = ("track", "shift", "node", "cell", "branch", "heights")  # arrays of a model: where it runs, contact tables


@dataclass(frozen=True)
class StepLimit:
    """The longest stable step and what limits it.

    Attributes
    ----------
    stable : float
        Longest step at which no disturbance grows from step to step [s]; CEILING when that is stable too.
    limited_by : str
        Element, or wheelset on its rails, and the motion that would grow.
    """

    stable: float
    limited_by: str

    @property
    def allowed(self):
        """Longest step that leaves MARGIN for what the linearised states do not show [s]."""
        return self.stable / MARGIN


def step_limit(system, speeds=()):
    """The longest stable step of a system.

    Parameters
    ----------
    system : System
    speeds : sequence of float
        Lowest and highest speed of the run [m/s], in this order; the system's own when there are none.

    Returns
    -------
    StepLimit
    """
    system = stiffest(system)
    limit = StepLimit(CEILING, "nothing in the model")
    system = system.passive()
    motions = [OneStep(system, speed) for speed in dict.fromkeys(speeds or (system.speed,))]
    last = motions[-1]
    held = OneStep(system.on_rigid_track(), last.system.speed) if last.data.yielded.size else last
    for k, (right, left) in enumerate(system.model.wheel["body"].reshape(-1, 2)):
        if right == left:
            limit = aside(held, k, limit)
    for motion in motions:
        limit = motion.limit(limit)
    return limit


def fingerprint(system, speeds=()):
    """Digest of all of a system that its limit depends on, but for what is in its contact tables."""
    model, param = system.model, system.model.param.copy()
    param["shift_start"] = param["shift_step"] = 0.0
    parts = [param, system.rest, system.damper, np.array(speeds), np.array([system.speed])]
    parts += [array for name, array in model._asdict().items() if name not in ("param", *APART)]
    return hashlib.sha256(b"".join(part.tobytes() for part in parts)).hexdigest()


def stiffest(system):
    """The system on ideal straight level track, with a line of its steepest slope for each spring and damper table."""
    element, rows = system.model.element.copy(), [system.model.curve]

    def line(number):
        if number < 0:
            return number
        curve = system.model.curve[number]
        x, y = curve["x"][: curve["count"]], curve["y"][: curve["count"]]
        row = np.zeros(1, curve.dtype)
        row["count"], row["x"][0, 1], row["y"][0, 1] = 2, 1.0, np.max(np.diff(y) / np.diff(x))
        rows.append(row)
        return sum(map(len, rows)) - 1

    for one in element:
        if one["kind"] in (Kind.BUSHING, Kind.LINK):
            one["spring_curve"] = [line(number) for number in one["spring_curve"]]
            one["damper_curve"] = [line(number) for number in one["damper_curve"]]
    track = pack(constant_track(0.0, 0.0))
    return _with(system, element=element, curve=np.concatenate(rows), track=track, shift=NO_SHIFT)


def without_implicit(model):
    """The model without dampers and friction that act implicitly in their rate, which no step is too long for."""
    element = model.element.copy()
    implicit = element["stiff"] >= 0
    element["c"][implicit], element["damper_curve"][implicit], element["limit"][implicit[:, 0]] = 0.0, -1, 0.0
    return freeze(model._replace(element=element))


def _with(system, **arrays):
    return replace(system, model=freeze(system.model._replace(**arrays)))


class OneStep:
    """One compiled step about the vehicle that rolls on straight track at rest against it, and its Jacobian.

    Parameters
    ----------
    system : System
        On straight level track.
    speed : float
        [m/s]
    """

    def __init__(self, system, speed):
        param = system.model.param.copy()
        param["speed"] = speed
        self.system = replace(_with(system, param=param), speed=speed)
        self.data = settled_start(self.system)
        self.arrays = [getattr(self.data, name) for name in STATE]
        self.rest = self._state()
        each = [array.size for array in self.arrays]
        self.probe, self.size = np.repeat(list(STATE.values()), each), np.repeat(list(SIZE.values()), each)
        leaves = system.model.element["state"][system.model.element["kind"] == Kind.LEAF]
        before = sum(each[: list(STATE).index("damper")])
        forces = before + leaves + 1  # states that are forces and not lengths
        self.probe[forces], self.size[forces] = FORCE
        self.probe *= self._sticking()
        n = self.data.q.shape[0]
        self.behind = 6 * np.arange(1, n)  # arc lengths, which count from that of the first body
        ignored = [0, *(6 * np.flatnonzero(self.system.model.body["spins"]) + 4)]  # nothing depends on them
        self.used = np.setdiff1d(np.arange(self.rest.size), ignored)

    def _state(self):
        return np.concatenate([array.ravel() for array in self.arrays])

    def _sticking(self):
        """Share of the difference steps within which dry friction does not slide."""
        share, element = 1.0, self.system.model.element
        evaluate(self.system.model, self.data, 0.0)
        for one in element[np.isin(element["kind"], (Kind.DRY, Kind.DRY_LINK))]:
            load = self.data.carried[one["source"]] if one["source"] >= 0 else 0.0
            limit = one["limit"] + one["coefficient"] * max(load, 0.0)
            if limit > 0.0:
                share = min(share, SMALL * limit / (one["series"] * STATE["q"]))
        return share

    def place(self, change=0.0):
        """Put the vehicle into its state at rest plus a change."""
        state, first = self.rest + change, 0
        for array in self.arrays:
            array.flat = state[first : first + array.size]
            first += array.size
        self.data.clock[0] = self.data.held[0] = 0.0
        self.data.lag[:] = 0.0

    def _after(self, model, change):
        """State one step after that at rest plus a change."""
        self.place(change)
        status = advance(model, self.data, 1)
        if status:
            raise SimulationError(f"the step cannot be linearised: {sentence(self.system, self.data, status)}")
        state = self._state()
        state[self.behind] -= state[0]
        return state

    def slope(self, model, change):
        """Change of the state after one step per change before it."""
        return 0.5 * (self._after(model, change) - self._after(model, -change))

    def jacobian(self, step):
        """Of one step [s], over the states on which something depends, each over its SIZE."""
        model = self.system.stepped(step).model
        columns, change = [], np.zeros(self.rest.size)
        for k in self.used:
            change[k] = self.probe[k]
            columns.append(self.slope(model, change)[self.used] / self.probe[k])
            change[k] = 0.0
        size = self.size[self.used]
        return np.array(columns).T * size / size[:, None]

    def grows(self, step):
        """True when a disturbance grows from step to step, and not as slowly as the vehicle's own motions do."""
        return bool((_excess(np.linalg.eigvals(self.jacobian(step)), step) > 0.0).any())

    def limit(self, known):
        """The lesser of a known StepLimit and this motion's."""
        high = known.stable
        if not self.grows(high):
            return known
        low = 0.5 * high
        while self.grows(low):
            low, high = 0.5 * low, low
            if low < FLOOR:
                return StepLimit(low, self.culprit(high))
        while high > ACCURACY * low:
            middle = (low * high) ** 0.5
            low, high = (low, middle) if self.grows(middle) else (middle, high)
        return StepLimit(low, self.culprit(high))

    def culprit(self, step):
        """What makes a disturbance grow at this step, in words.

        The growing eigenvalue z = w J u of the Jacobian J, with w u = 1, loses w (J - J') u when a part of the model
        is left out, which gives J'; the part named is that which brings z furthest out, and one that does half as much.
        """
        jacobian = self.jacobian(step)
        value, right = np.linalg.eig(jacobian)
        k = int(np.argmax(_excess(value, step)))
        left = np.linalg.inv(right)[k]
        shape = np.zeros(self.rest.size, complex)
        shape[self.used] = right[:, k] * self.size[self.used]
        weight = np.zeros(self.rest.size, complex)
        weight[self.used] = left / self.size[self.used]
        outwards = value[k].conj() / abs(value[k])
        per = np.abs(shape / self.probe).max()

        def image(model):
            real = self.slope(model, shape.real / per)
            return real if value[k].imag == 0.0 else real + 1j * self.slope(model, shape.imag / per)

        whole = image(self.system.stepped(step).model)
        shares = {}
        for words, model in self._parts(step):
            share = float((outwards * (weight @ (whole - image(model)))).real * per)
            shares[words] = shares.get(words, 0.0) + share
        first, *others = sorted(shares, key=shares.get, reverse=True)
        named = " and ".join([first, *(words for words in others[:1] if shares[words] > SECOND * shares[first])])
        q = shape[: self.data.q.size].reshape(-1, 6)
        body = self.system.model.body
        energy = np.column_stack([*[body["mass"]] * 3, body["inertia"]]) * np.abs(q) ** 2
        mover, how = np.unravel_index(np.argmax(energy), energy.shape)
        return f"{named}, on which {self.system.bodies[mover]} {MOVES[how]}"

    def _parts(self, step):
        """Every part of the model in words, with a model that lacks it."""
        model = self.system.stepped(step).model
        for j, joint in enumerate(model.joint):
            first, count = int(joint["first"]), int(joint["count"])
            for e in range(first, first + count):
                split = model.joint[[j, j]]
                split["first"], split["count"] = (first, e + 1), (e - first, first + count - e - 1)
                split["turn"][1] = 0.0
                yield self.system.elements[e], _without(model, joint=_spliced(model.joint, j, split))
            if joint["turn"].any():
                soft = model.joint[j : j + 1].copy()
                soft["turn"] = 0.0
                yield f"turn stiffness of {self.system.joints[j]}", _without(
                    model, joint=_spliced(model.joint, j, soft)
                )
        for k in range(0, model.wheel.size, 2):
            wheel = model.wheel.copy()
            wheel["radius"][k : k + 2] -= LIFTED
            yield f"W{k // 2 + 1} on its rails", _without(model, wheel=wheel)
        param = model.param.copy()
        param["hold"] = 0.0
        yield "the force that holds the speed", _without(model, param=param)


def _without(model, **arrays):
    return freeze(model._replace(**arrays))


def _spliced(array, place, rows):
    return np.concatenate([array[:place], rows, array[place + 1 :]])


def _excess(value, step):
    """How far the magnitude of eigenvalues is beyond what is allowed: 1, and slow growth of what does not alternate."""
    allowed = np.where(value.real < 0.0, 1.0 + ROUNDING, np.exp(GROWTH * step))
    return np.abs(value) - allowed


def aside(motion, number, known):
    """The lesser of a known StepLimit and that of one wheelset at all lateral places to both sides.

    It is pushed at its axle: at each place it takes the height and the roll at which its rails carry what they carry in
    the middle, until they press it back with PRESSED. What joins it to the vehicle is as stiff as in the middle.

    Parameters
    ----------
    motion : OneStep
    number : int
        Of the wheelset, from 0.
    known : StepLimit
    """
    model, data = without_implicit(motion.system.model), motion.data
    i, wheels = motion.system.wheelsets[number], slice(2 * number, 2 * number + 2)
    mass = np.r_[np.full(3, model.body[i]["mass"]), model.body[i]["inertia"]][CROSSWISE]
    alike = bool((model.wheel[wheels][["radius", "table"]] == model.wheel[wheels][0][["radius", "table"]]).all())
    whole, model = model, _without(model, joint=model.joint[:0])
    motion.place()
    joined = _local(whole, data, i, mass) - _local(model, data, i, mass)
    carried = data.load[i, [2, 3]].copy()
    for side in (1.0,) if alike else (1.0, -1.0):
        motion.place()
        for y in np.arange(0.0, OUTERMOST, PLACES):
            data.q[i, 1] = side * y
            if not set_down(model, data, i, carried):
                break
            load = data.rail["q"][wheels].sum()
            if abs(data.rail["y"][wheels].sum()) > PRESSED[0] + PRESSED[1] * load:
                break
            words = "in the middle" if y == 0.0 else f"{1e3 * y:.1f} mm to the {'right' if side > 0 else 'left'}"
            right, left = data.rail["patches"][wheels].astype(int)
            step = by_rule(*(joined + _local(model, data, i, mass)), known.stable)
            if step < known.stable:
                touching = f"{right} {'patch' if right == 1 else 'patches'} right and {left} left"
                known = StepLimit(step, f"W{number + 1} on its rails {words}, on {touching}")
    motion.place()
    return known


def _local(model, data, i, mass):
    """Stiffness and damping without creep of wheelset i over CROSSWISE, symmetric parts over the mass, (2, 4, 4)."""
    matrices = []
    for name in ("q", "v"):
        array, size, columns = getattr(data, name), STATE[name], []
        for k in CROSSWISE:
            rest, sides = array[i, k], []
            for sign in (1.0, -1.0):
                array[i, k] = rest + sign * size
                evaluate(model, data, 0.0)
                sides.append(data.load[i, CROSSWISE])
            array[i, k] = rest
            columns.append((sides[1] - sides[0]) / (2.0 * size))
        matrices.append(np.array(columns).T)
    evaluate(model, data, 0.0)
    matrices[1] -= data.creep_damping[i][np.ix_(CROSSWISE, CROSSWISE)]
    root = np.sqrt(mass)
    return np.array([0.5 * (matrix + matrix.T) / root / root[:, None] for matrix in matrices])


def by_rule(stiffness, damping, high):
    """Longest step up to `high` with h^2 K/4 + h C <= 1; both matrices symmetric, over the mass [1/s^2], [1/s]."""

    def largest(step):
        return np.linalg.eigvalsh(0.25 * step**2 * stiffness + step * damping)[-1]

    if largest(high) <= 1.0:
        return high
    low = FLOOR
    while high > ACCURACY * low:
        middle = (low * high) ** 0.5
        low, high = (low, middle) if largest(middle) > 1.0 else (middle, high)
    return low
