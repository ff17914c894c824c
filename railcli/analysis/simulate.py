"""A run: the vehicle at rest on the track, then time steps, with rows of results handed on as they come."""

import math
import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from railcli.kernels.layout import NO_SHIFT, freeze, new_rows
from railcli.kernels.step import evaluate, record
from railcli.model.track import constant_track, pack

from .equilibrium import HEIGHT_AND_ROLL, set_down, static
from .faults import copied, verdict

BLOCK = 50  # rows between two returns to Python, at most
BLOCK_TIME = 0.5  # simulated time between them, at most but for one row [s]
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
    """

    rows: int
    time: float
    distance: float
    cpu_s: float
    fault: str
    status: int

    @property
    def real_time_factor(self):
        """Simulated time over processor time."""
        return self.time / self.cpu_s if self.cpu_s > 0.0 else math.inf


def settled_start(system, lateral=0.0):
    """Data of the vehicle rolling at its speed, in static equilibrium but for a lateral shift of all bodies [m].

    Wheelsets stand on their rails there.

    Dampers and dry friction carry nothing: the vehicle was not pushed about before.
    """
    rest = static(system).data
    data = system.start(0.0, lateral)
    data.q[:, 0] = rest.q[:, 0] - rest.q[0, 0]
    data.q[:, 2:] = rest.q[:, 2:]
    data.q[:, 1] = rest.q[:, 1] + lateral
    data.damper[:] = rest.damper
    if lateral:
        _set_down(system, data, lateral)
    return data


def _set_down(system, data, lateral):
    """Let the rails carry each wheelset where it stands aside as they do in the middle; where they cannot, leave it."""
    track = pack(constant_track(0.0, 0.0))
    model = freeze(system.model._replace(joint=system.model.joint[:0], track=track, shift=NO_SHIFT))
    for i in system.wheelsets:
        before = data.q[i].copy()
        data.q[i, 1] = before[1] - lateral
        if evaluate(model, data, 0.0) == 0:
            carried = data.load[i, HEIGHT_AND_ROLL].copy()
            data.q[i, 1] = before[1]
            if set_down(model, data, i, carried):
                continue
        data.q[i] = before


def simulate(scenario, system, sink, progress=None):
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

    Returns
    -------
    Outcome
    """
    if scenario.run.course is not None:
        system = system.following(*scenario.run.course.knots())
    stride, interval = scenario.run.steps_per_output, scenario.run.output_interval
    total = max(1, round(scenario.duration / interval))
    data = settled_start(system, scenario.start.lateral)
    rows = new_rows(system.model, min(BLOCK, max(1, round(BLOCK_TIME / interval))))
    most = rows.time.size
    kept = deque(maxlen=KEPT)
    done, cpu, status = 0, 0.0, 0
    while done < total and status == 0:
        if not kept or data.clock[0] - kept[-1].clock[0] > (1.0 - 1e-9) * BLOCK_TIME:
            kept.append(copied(data))
        block = rows if total - done >= most else type(rows)(*(array[: total - done] for array in rows))
        began = time.process_time()
        count, status = record(system.model, data, block, stride)
        cpu += time.process_time() - began
        done += count
        if count:
            sink(type(rows)(*(array[:count] for array in block)))
        if progress:
            progress(float(data.clock[0]), data.clock[0] / max(cpu, 1e-9))
    fault = verdict(system, data, status, kept[0]) if status else ""
    return Outcome(done, float(data.clock[0]), float(data.q[0, 0]), cpu, fault, int(status))


class SteadyWindow:
    """Mean and peak-to-peak of named channels over the last metres of a run, gathered as rows come.

    Parameters
    ----------
    start : float
        Arc length of the first body from which on rows count [m].
    """

    def __init__(self, start):
        self.start = start
        self.count = 0

    def __call__(self, rows):
        inside = rows.q[:, 0, 0] >= self.start
        if not inside.any():
            return
        for key, values in self.channels(rows).items():
            values = values[inside]
            total, low, high = values.sum(axis=0), values.min(axis=0), values.max(axis=0)
            if self.count:
                old_total, old_low, old_high = getattr(self, key)
                total, low, high = total + old_total, np.minimum(low, old_low), np.maximum(high, old_high)
            setattr(self, key, (total, low, high))
        self.count += int(inside.sum())

    @staticmethod
    def channels(rows):
        """What is averaged: coordinates (n, n_body, 6) and rail forces Y, Q (n, n_wheel); SI, track axes."""
        return {"q": rows.q, "y_force": rows.rail["y"], "q_force": rows.rail["q"], "traction": rows.traction}

    def mean(self, key):
        """Mean of one channel over the window."""
        return getattr(self, key)[0] / self.count

    def peak_to_peak(self, key):
        """Largest less smallest value of one channel in the window."""
        return getattr(self, key)[2] - getattr(self, key)[1]
