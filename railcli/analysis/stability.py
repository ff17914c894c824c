"""Critical speed: linear by the roots over speed, non-linear by limit cycles (docs/stability.md, sections 4 and 5)."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from railcli.errors import SimulationError
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.vehicle import static_wheel_loads

from . import indices
from .faults import copied, verdict
from .linear import linearise, modes, on_straight, roots
from .mode_shapes import describe
from .simulate import settled_start

USUAL = 3e-3  # amplitude for which conicity is usually stated, and here the linear critical speed [m]
ACCURACY = 0.01  # of a linear critical speed [m/s]
WINDOW = 4.0  # over which an amplitude is taken [s]
SAMPLE = 2.5e-3  # interval at which it is [s]
MOST_WINDOWS = 50  # at one speed
STEADY = 0.01  # relative change from window to window of a limit cycle
DEAD = 0.1e-3  # lateral amplitude that is no hunting unless a caller says otherwise [m]
AROUND, LOWEST = 2.0, 0.4  # band of the rms of sum Y, on both sides of its dominant frequency, but not below [Hz]
EDGE = 0.5  # at both ends of a window, in which the band-pass settles [s]
ROOM = 200.0  # of straight track beyond what a window needs [m]


@dataclass(frozen=True)
class Locus:
    """Roots over speed at one amplitude.

    Attributes
    ----------
    amplitude : float
        [m]
    speeds : array (n,)
        [m/s]
    values : tuple of complex arrays
        Eigenvalues that oscillate, at each speed [1/s].
    critical : float
        Lowest speed at which an oscillation neither grows nor decays, on its way to growing [m/s]; NaN if none does,
        0 if one grows at the lowest speed already.
    frequency : float
        Of that oscillation [Hz].
    mode : str
    """

    amplitude: float
    speeds: np.ndarray
    values: tuple
    critical: float
    frequency: float
    mode: str

    @property
    def growth(self):
        """Largest real part at each speed [1/s]."""
        return np.array([value.real.max() for value in self.values])


def locus(system, amplitude, speeds, progress=None):
    """Roots of a quasi-linear system over speed.

    Parameters
    ----------
    system : System
        As `quasi_linear.on_lines` gives it.
    amplitude : float
        To be noted in the result [m].
    speeds : sequence of float
        Growing [m/s].
    progress : callable, optional
        Called after each speed.

    Returns
    -------
    Locus
    """
    values = []
    for speed in speeds:
        values.append(roots(linearise(system, speed)))
        if progress:
            progress()
    growth = np.array([value.real.max() for value in values])
    critical, frequency, mode = math.nan, math.nan, ""
    grows = np.flatnonzero(growth >= 0.0)
    if grows.size and grows[0] == 0:
        critical = 0.0
    elif grows.size:
        low, high = speeds[grows[0] - 1], speeds[grows[0]]
        critical = float(brentq(lambda speed: roots(linearise(system, speed)).real.max(), low, high, xtol=ACCURACY))
    if critical >= 0.0:
        found = modes(linearise(system, critical or speeds[0]))
        k = int(np.argmax(np.where(found.oscillates, found.value.real, -np.inf)))
        frequency, mode = float(found.frequency[k]), describe(found, k).words
    return Locus(amplitude, np.asarray(speeds, float), tuple(values), critical, frequency, mode)


@dataclass(frozen=True)
class Cycle:
    """What is left of an oscillation at one speed.

    Attributes
    ----------
    speed : float
        [m/s]
    amplitude : array (n_wheelset,)
        Half the lateral peak-to-peak of each wheelset over the last WINDOW [m].
    frequency : float
        Of the wheelset with the largest one [Hz]; NaN without oscillation.
    sum_y_rms : array (n_wheelset,)
        Rms of each wheelset's lateral force on the rails within 2 Hz of its dominant frequency [N].
    time : float
        Run at this speed [s].
    settled : bool
        The amplitude no longer changed.
    hunts : bool
        It is larger than what counts as none.
    """

    speed: float
    amplitude: np.ndarray
    frequency: float
    sum_y_rms: np.ndarray
    time: float
    settled: bool
    hunts: bool

    @property
    def largest(self):
        return float(self.amplitude.max())


@dataclass(frozen=True)
class Measures:
    """What is asked of a limit cycle beside whether it lives.

    Attributes
    ----------
    counted : float
        Lateral amplitude of the widest wheelset from which on a cycle counts [m].
    limit : array (n_wheelset,)
        Of the rms of sum Y [N].
    """

    counted: float
    limit: np.ndarray

    @classmethod
    def of(cls, scenario, counted, limits):
        """Limit of sum Y of a scenario's wheelsets after an assessment's `Limits`: a share of that of sum Y itself."""
        loads = static_wheel_loads(scenario.vehicle, scenario.run.gravity, scenario.contact.tape_circle).sum(axis=1)
        return cls(counted, limits.stability_share * indices.prudhomme(loads, limits.sum_y_factor))

    def counts(self, cycle):
        return cycle.hunts and cycle.largest >= self.counted

    def breaks(self, cycle):
        """Whether the rms of sum Y is at its limit or beyond."""
        return cycle.hunts and bool((cycle.sum_y_rms >= self.limit).any())


def ramp(system, start, step, lowest, lateral, resolution, threshold=DEAD, measures=None):
    """Limit cycles while the speed falls from a large disturbance, then the speeds at which they end.

    Segments of constant speed, each begun with the state in which the one before ended. Where the hunting has died, the
    last speed at which it lived is approached from its own state by halving, as the branch of large amplitudes may
    reach far below the linear critical speed. In the same way the speeds are closed in at which cycles cease to count.

    Parameters
    ----------
    system : System
        With its own contact table and creep law.
    start, step, lowest : float
        Speeds and their difference [m/s].
    lateral : float
        Displacement of all bodies at the beginning [m].
    resolution : float
        Of the speeds at which something ends [m/s].
    threshold : float
        Lateral amplitude of the widest wheelset up to which it does not hunt [m].
    measures : Measures, optional
        What else is to be closed in.

    Yields
    ------
    Cycle
        As they are found; `end_of` reads the results off them.

    Raises
    ------
    SimulationError
        A wheel derailed or left its table.
    """
    length = WINDOW * start + ROOM
    there = on_straight(system, length, speed=start)
    data = settled_start(there, lateral)
    cycle = _settle(there, data, threshold)
    yield cycle
    cycles, states = [cycle], {start: data}
    while cycle.hunts and cycle.speed - step >= lowest:
        cycle, data = _continued(system, length, states, cycle.speed, cycle.speed - step, threshold)
        cycles.append(cycle)
        states[cycle.speed] = data
        yield cycle
    for passes in (hunts, measures.counts, measures.breaks) if measures else (hunts,):
        low, high = end_of(cycles, passes)
        while high - low > resolution:
            cycle, data = _continued(system, length, states, high, 0.5 * (high + low), threshold)
            cycles.append(cycle)
            states[cycle.speed] = data
            yield cycle
            low, high = end_of(cycles, passes)


def _continued(system, length, states, before, speed, threshold):
    """Limit cycle at a speed, begun with the state of another one; and the state in which it ends."""
    data = copied(states[before])
    data.v[:, 0] *= speed / before
    data.v[system.model.body["spins"] == 1, 4] *= speed / before
    return _settle(on_straight(system, length, speed=speed), data, threshold), data


def hunts(cycle):
    return cycle.hunts


def end_of(cycles, passes=hunts):
    """Highest speed at which a cycle does not pass and lowest above it at which one does [m/s]; NaN where none is."""
    below = max((cycle.speed for cycle in cycles if not passes(cycle)), default=math.nan)
    above = min((cycle.speed for cycle in cycles if passes(cycle) and not cycle.speed < below), default=math.nan)
    return below, above


def _settle(system, data, threshold):
    """Run at one speed until the amplitude repeats or has died."""
    step = float(system.model.param[0]["step"])
    stride = max(1, round(SAMPLE / step))
    rows = new_rows(system.model, round(WINDOW / (stride * step)))
    before, time = np.inf, 0.0
    for _ in range(MOST_WINDOWS):
        data.q[:, 0] -= data.q[0, 0]
        kept = copied(data)
        _, status = record(system.model, data, rows, stride)
        time += WINDOW
        if status:
            told = verdict(system, data, status, kept)
            raise SimulationError(f"at {system.speed:g} m/s: {told}; start at a lower speed")
        lateral = rows.q[:, list(system.wheelsets), 1]
        amplitude = 0.5 * np.ptp(lateral, axis=0)
        settled = amplitude.max() <= threshold or abs(amplitude.max() - before) < STEADY * amplitude.max()
        if settled:
            break
        before = amplitude.max()
    widest = lateral[:, int(np.argmax(amplitude))]
    sum_y = rows.rail["y"].reshape(len(rows.time), -1, 2).sum(axis=2)
    interval = stride * step
    return Cycle(
        system.speed, amplitude, _frequency(widest, interval), _rms_around_peak(sum_y, 1.0 / interval), time,
        bool(settled), bool(amplitude.max() > threshold),
    )  # fmt: skip


def _rms_around_peak(sum_y, rate):
    """Rms of signals (n, m) within AROUND of the dominant frequency of each, as the assessment has it over 100 m.

    A limit cycle repeats, so that a window of WINDOW gives what 100 m would.
    """
    edge = round(EDGE * rate)
    found = np.zeros(sum_y.shape[1])
    for k, signal in enumerate(sum_y.T):
        peak = indices.dominant_frequency(signal, rate)
        low, high = indices.HUNTING if math.isnan(peak) else (max(peak - AROUND, LOWEST), peak + AROUND)
        found[k] = indices.root_mean_square(indices.filtered(signal, rate, low, high)[edge:-edge])
    return found


def _frequency(signal, interval):
    """Of a swing, from its upward crossings of the mean [Hz]."""
    signal = signal - signal.mean()
    up = np.flatnonzero((signal[:-1] < 0.0) & (signal[1:] >= 0.0))
    if up.size < 2:
        return math.nan
    place = up + signal[up] / (signal[up] - signal[up + 1])
    return float((up.size - 1) / ((place[-1] - place[0]) * interval))
