"""Vibration of wheel forces at the end of a run: on smooth track nothing asks for it."""

from typing import NamedTuple

import numpy as np

from .faults import wheel_name

PERIODS = 2.0  # in the stretch that is looked at, at least; what is slower is a run that has not settled
FINE = 4  # the spectrum is padded with zeros to so many times its points
LEAST = 1e-3  # peak to peak below which forces have no frequency worth a number [N]


class Vibration(NamedTuple):
    """The wheel force that moves most.

    Attributes
    ----------
    force : {"Y", "Q"}
    wheel : str
        `W2 left`.
    peak_to_peak : float
        Of every step, no filter [N].
    frequency : float
        Of the highest line in the spectrum of the low-passed force; NaN below two periods in the stretch [Hz].
    """

    force: str
    wheel: str
    peak_to_peak: float
    frequency: float


class Listener:
    """A sink of low-passed blocks (simulate.Filtered) that keeps Y and Q of all wheels.

    Parameters
    ----------
    n_wheel : int
    start : float
        Arc length of the first body from which on they are kept [m].
    """

    def __init__(self, n_wheel, start):
        self._n_wheel, self._start = n_wheel, start
        self._time, self._force = [], []

    def __call__(self, block):
        inside = block.place[:, 0] >= self._start
        if inside.any():
            self._time.append(block.time[inside])
            self._force.append(block.filtered[inside, : 2 * self._n_wheel])

    def frequency(self, force, wheel):
        """Of the highest line in the spectrum of one force, 0 for Y or 1 for Q, without mean and trend [Hz]."""
        if not self._time:
            return np.nan
        time = np.concatenate(self._time)
        values = np.concatenate([block[:, force * self._n_wheel + wheel] for block in self._force]).astype(float)
        if time.size < 4:
            return np.nan
        values -= np.polynomial.Polynomial.fit(time, values, 1)(time)
        spectrum = np.abs(np.fft.rfft(values * np.hanning(time.size), FINE * time.size))
        frequency = np.fft.rfftfreq(FINE * time.size, np.diff(time).mean())
        found = float(frequency[np.argmax(spectrum)])
        return found if found * np.ptp(time) >= PERIODS else np.nan


def vibration(system, window, listener):
    """The Vibration of a stretch that a SteadyWindow and a Listener have followed."""
    swings = np.stack([window.peak_to_peak("y_force"), window.peak_to_peak("q_force")])
    force, wheel = np.unravel_index(np.argmax(swings), swings.shape)
    size = float(swings[force, wheel])
    frequency = listener.frequency(int(force), int(wheel)) if size >= LEAST else np.nan
    return Vibration("YQ"[force], wheel_name(system, int(wheel)), size, frequency)
