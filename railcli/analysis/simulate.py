"""A run: the vehicle at rest on the track, then time steps, with rows of results handed on as they come."""

import math
import time
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from railcli.errors import InputError, SimulationError
from railcli.kernels.layout import NO_SHIFT, Data, freeze
from railcli.kernels.recording import Count, averaged, forget_done, new_rows, new_stream
from railcli.kernels.step import evaluate, finish, record_rows
from railcli.model.low_pass import low_pass
from railcli.model.track import constant_track, pack

from .equilibrium import HEIGHT_AND_ROLL, SETTLED, set_down, settle_rails, static, steady
from .faults import copied, verdict

BLOCK_TIME = 0.5  # simulated time between two returns to Python, at most but for one row [s]
MOST_ROWS = 1000  # between them
_BEGIN = "begin the track with a straight, and a transition behind it"
JOLT = 1.0  # acceleration of a body at the start that is told [m/s^2]
KEPT = 4  # states, BLOCK_TIME apart or more, from the first of which a fault is followed once more


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    rows : int
        Written.
    time, distance : float
        Reached [s], [m].
    cpu_s : float
        Processor time of the compiled steps [s].
    fault : str
        Empty when the run reached its end, else what stopped it.
    status : int
        The core's Status.
    jolt : str
        A sentence when the run does not begin in equilibrium though nothing was put aside; else empty.
    first, last : Data
        At its beginning and its end.
    """

    rows: int
    time: float
    distance: float
    cpu_s: float
    fault: str
    status: int
    jolt: str = ""
    first: Data | None = None
    last: Data | None = None

    @property
    def real_time_factor(self):
        """Simulated time over processor time."""
        return self.time / self.cpu_s if self.cpu_s > 0.0 else math.inf


class Filtered(NamedTuple):
    """A block of what every step gave, low-passed (model.low_pass); its arrays are used again.

    Attributes
    ----------
    time : array (n,)
        [s]
    filtered, place, still : array (n, ...)
        As kernels.recording.Stream.
    """

    time: np.ndarray
    filtered: np.ndarray
    place: np.ndarray
    still: np.ndarray


def start_of_run(scenario, system):
    """Data in which a run begins: at rest on straight track, or in the steady motion of a curve or gradient.

    Raises
    ------
    SimulationError
        There is no such motion.
    InputError
        Bodies are to be put aside in a curve.
    """
    first, lateral = system.model.track[0], scenario.start.lateral
    curvature, cant, angle = (float(first[name][0]) for name in ("curvature", "cant", "gradient"))
    in_curve = curvature != 0.0 or cant != 0.0
    if in_curve and lateral:
        raise InputError(
            "start.lateral_mm", f"bodies cannot be put aside where the track begins in a curve or on cant; {_BEGIN}"
        )
    if not in_curve and (angle == 0.0 or system.speed == 0.0 or lateral):
        return settled_start(system, lateral)
    aside = scenario.track.shifts([0.0], scenario.contact.gauge)[:, 0]
    try:
        found = steady(system, curvature, cant, gradient=np.tan(angle), aside=tuple(aside.tolist()))
    except SimulationError as error:
        raise SimulationError(f"a run begins in the steady motion of its first section: {error}; {_BEGIN}") from None
    data = system.start()
    for own, its in zip(data, found.data, strict=True):
        own[...] = its
    return data


def jolt(system, data):
    """A sentence when some body does not begin in equilibrium; empty when all do within JOLT."""
    there = copied(data)
    if evaluate(system.model, there, 0.0):
        return ""
    size = np.abs(there.dv[:, :3]).max(axis=1)
    body = int(np.argmax(size))
    if size[body] < JOLT:
        return ""
    return (
        f"The run begins with a jolt of {size[body]:.3g} m/s^2 at {system.bodies[body]}: the track is not alike under "
        "the whole vehicle there; begin with a longer straight or curve, level or on one gradient."
    )


def settled_start(system, lateral=0.0):
    """Data of the vehicle rolling at its speed, in static equilibrium but for a lateral shift of its bodies [m].

    `lateral` is one for all or one for each body. Wheelsets stand on their rails there.

    Dampers and dry friction carry nothing: the vehicle was not pushed about before.
    """
    rest = static(system).data
    data = system.start(0.0, lateral)
    data.q[:, 0] = rest.q[:, 0] - rest.q[0, 0]
    data.q[:, 2:] = rest.q[:, 2:]
    data.q[:, 1] = rest.q[:, 1] + lateral
    data.damper[:] = rest.damper
    spins = np.flatnonzero(system.model.body["spins"])
    data.v[spins, 4] = -system.speed / _rolling_radii(system, rest, spins)
    data.yielded[:], data.dragged[:] = rest.yielded, rest.dragged
    if np.any(lateral):
        _set_down(system, data, np.broadcast_to(lateral, data.q.shape[0]))
    return data


def _rolling_radii(system, rest, spins):
    """Radius on which each body that spins rolls at rest, the mean over its patches by their normal forces [m]."""
    normal, radius = rest.contact["normal"], rest.contact["radius"]
    bodies = system.model.wheel["body"]
    load = np.array([normal[bodies == i].sum() for i in spins])
    moment = np.array([(normal * radius)[bodies == i].sum() for i in spins])
    return np.divide(moment, load, out=system.radii[spins], where=load > 0.0)


def _set_down(system, data, aside):
    """Let the rails carry each wheelset that stands aside [m] as they do in the middle; where they cannot, leave it."""
    track = pack(constant_track(0.0, 0.0))
    model = freeze(system.model._replace(joint=system.model.joint[:0], track=track, shift=NO_SHIFT))
    for i, other in system.model.wheel["body"].reshape(-1, 2):
        if i != other or aside[i] == 0.0:  # two wheels that stand only by what joins them
            continue
        before = data.q[i].copy()
        data.q[i, 1] = before[1] - aside[i]
        if evaluate(model, data, SETTLED) == 0:
            carried = data.load[i, HEIGHT_AND_ROLL].copy()
            data.q[i, 1] = before[1]
            if set_down(model, data, i, carried):
                continue
        data.q[i] = before
    settle_rails(data)


def simulate(scenario, system, sink, progress=None, filtered_sink=None):
    """Run a scenario.

    Parameters
    ----------
    scenario : Scenario
    system : System
        The scenario assembled with its contact tables; both with the step that `step_choice.with_step` settled.
    sink : callable
        Called with each block of recorded instants (Rows, only as long as filled); its arrays are used again.
    progress : callable, optional
        Called with the simulated time [s] and the real-time factor so far.
    filtered_sink : callable, optional
        Called with each block that was low-passed (Filtered).

    Returns
    -------
    Outcome
    """
    if scenario.run.course is not None:
        system = system.following(*scenario.run.course.knots())
    stride, interval = scenario.run.steps_per_output, scenario.run.output_interval
    steps = round(scenario.duration * stride / interval)
    total = max(1, steps // stride)
    rest = steps - total * stride  # behind the last row: only the low-passed stream has them
    data = start_of_run(scenario, system)
    if scenario.is_free:
        data.held[:] = data.traction[:] = 0.0  # of the steady motion of a gradient; nobody holds its speed now
    first = copied(data)
    beginning = "" if scenario.start.lateral else jolt(system, data)
    rows = new_rows(system.model, min(total, MOST_ROWS, max(1, round(BLOCK_TIME / interval))))
    most = rows.time.size
    low_passed = _LowPassed(system.model, most * stride, filtered_sink)
    kept = deque(maxlen=KEPT)
    done, cpu, status = 0, 0.0, 0
    while done < total and status == 0:
        if not kept or data.clock[0] - kept[-1].clock[0] > (1.0 - 1e-9) * BLOCK_TIME:
            kept.append(copied(data))
        block = rows if total - done >= most else type(rows)(*(array[: total - done] for array in rows))
        began = time.process_time()
        count, status = record_rows(system.model, data, block, low_passed.stream, stride)
        cpu += time.process_time() - began
        done += count
        if count:
            sink(type(rows)(*(array[:count] for array in block)))
        low_passed.hand_on()
        if progress:
            progress(float(data.clock[0]), data.clock[0] / max(cpu, 1e-9))
        if status == 0 and count < block.time.size:
            rest = 0  # a free run is over where it ends
            break
    if status == 0 and rest > 0:
        _, status = record_rows(system.model, data, new_rows(system.model, 1), low_passed.stream, rest)
    finish(low_passed.stream)
    low_passed.hand_on()
    fault = verdict(system, data, status, kept[0]) if status else ""
    return Outcome(done, float(data.clock[0]), float(data.q[0, 0]), cpu, fault, int(status), beginning, first, data)


class _LowPassed:
    """The low-passed stream of a run, handed on block by block; none without a sink."""

    def __init__(self, model, steps, sink):
        step = float(model.param[0]["step"])
        stride, taps = low_pass(step)
        self._interval, self._sink, self._handed = stride * step, sink, 0
        self.stream = new_stream(model, taps, stride, steps) if sink else new_stream(model)

    def hand_on(self):
        """Give the rows that are finished to the sink."""
        count = int(self.stream.count[Count.DONE])
        if count:
            time = self._interval * np.arange(self._handed + 1, self._handed + count + 1)
            self._handed += count
            rows = (self.stream.filtered, self.stream.place, self.stream.still)
            self._sink(Filtered(time, *(array[:count] for array in rows)))
            forget_done(self.stream)


class SteadyWindow:
    """What a stretch of a run amounts to, gathered as rows come: means and extremes, forces from every step.

    Parameters
    ----------
    start : float
        Arc length of the first body from which on rows count [m]; by default the whole run counts.

    Attributes
    ----------
    count : int
        Rows that counted.
    """

    def __init__(self, start=-math.inf):
        self.start = start
        self.count = 0
        self._gathered = {}

    def __call__(self, rows):
        inside = rows.q[:, 0, 0] >= self.start
        if not inside.any():
            return
        for key, (mean, least, greatest) in self._channels(rows).items():
            new = mean[inside].sum(axis=0), least[inside].min(axis=0), greatest[inside].max(axis=0)
            if self.count:
                total, low, high = self._gathered[key]
                new = new[0] + total, np.minimum(new[1], low), np.maximum(new[2], high)
            self._gathered[key] = new
        self.count += int(inside.sum())

    @staticmethod
    def _channels(rows):
        """Mean, least and greatest value of each row."""
        of_steps = averaged(rows.rail.shape[1], rows.q.shape[1])
        found = {"q": (rows.q,) * 3, "turn": (rows.turn,) * 3, "move": (rows.move,) * 3}
        for key, span in (("y_force", of_steps.y), ("q_force", of_steps.q), ("traction", of_steps.traction.start)):
            found[key] = rows.mean[:, span], rows.least[:, span], rows.greatest[:, span]
        return found

    def mean(self, key):
        """Mean of ``q`` (n_body, 6) over rows; of ``y_force``, ``q_force`` (n_wheel,) and ``traction`` over steps."""
        return self._gathered[key][0] / self.count

    def peak_to_peak(self, key):
        """Largest less smallest value of what `mean` knows."""
        _, low, high = self._gathered[key]
        return high - low

    def alternation(self):
        """How Y and Q move from step to step, with no filter.

        Returns
        -------
        turn : array (2, n_wheel)
            Of Y and of Q: sum of d_k d_(k-1) over the sum of d_k^2, d_k what the force moves by in step k. -1: it
            alternates with every step; 1: it is smooth. 0 where it does not move.
        amplitude : array (2, n_wheel)
            Of the force if it alternated, half the root mean square of d_k [N].
        """
        move = self.mean("move").reshape(2, -1)
        turn = np.zeros_like(move)
        np.divide(self.mean("turn").reshape(2, -1), move, out=turn, where=move > 0.0)
        return turn, 0.5 * np.sqrt(move)
