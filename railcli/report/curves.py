"""Recorded results as curves to draw: few enough points for a picture, with every peak kept, whatever the length."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.signal import welch

from railcli.analysis.alignment import course
from railcli.errors import InputError
from railcli.model.rails import contributions, displacement

MOST_POINTS = 6000  # of a curve
RAIL_POINTS = 10_000  # of the displacement of rails
PIECE = 20_000  # rows in memory, at least
SEGMENT = 5.0  # of a spectrum [s]
FEWEST = 16  # rows of a spectrum
EVEN = 1e-3  # allowed variation of the interval of a spectrum's rows
SIDES = ("right", "left")
CREEPAGES = ("xi", "eta", "phi", "on_wheel")


@dataclass
class Curves:
    """What a report draws of one result; SI, track axes.

    Parameters
    ----------
    results : Results
        Open as long as anything is read.
    label : str
        What stands in legends and at the head of columns.

    Attributes
    ----------
    notes : list of str
        What could not be read or drawn, and why.
    """

    results: object
    label: str
    notes: list = field(default_factory=list)
    _creepages: dict = field(default_factory=dict, repr=False)

    @property
    def bucket(self):
        """Rows whose lowest and highest value are drawn; 1: all rows are."""
        return 1 if self.results.rows <= MOST_POINTS else -(-2 * self.results.rows // MOST_POINTS)

    @cached_property
    def s(self):
        """Arc length of the first body at the points of all curves [m]."""
        (position,) = self.thinned([f"bodies/{self.results.bodies[0]}/position"], lambda position: position[:, :1])
        return position

    def thinned(self, channels, *functions):
        """Points of curves: all rows, or of each bucket of rows the lowest and the highest value.

        Parameters
        ----------
        channels : sequence of str
        *functions : callable
            Each takes the values of the channels and gives a curve, shape (n, 1).

        Returns
        -------
        list of array
            One for each function.
        """
        bucket, found = self.bucket, [[] for _ in functions]
        for values in self.results.pieces(*channels, size=-(-PIECE // bucket) * bucket):
            for curve, function in zip(found, functions, strict=True):
                curve.append(_extremes(function(*values)[:, 0], bucket))
        return [np.concatenate(curve) for curve in found]

    def component(self, channel, k):
        """Component k of a channel, for instance of a body's position."""
        return self.thinned([channel], lambda values: values[:, k : k + 1])[0]

    def single(self, channel):
        """A channel of single numbers."""
        return self.thinned([channel], lambda values: values[:, None])[0]

    def of_steps(self, channel, end):
        """Name of the channel of its least or greatest value of a step; itself where only instants were recorded."""
        name = f"{channel}_{end}"
        return name if name in self.results.channels else channel

    @cached_property
    def wheelsets(self):
        """Names of the right and left wheel of each wheelset."""
        wheels = self.results.wheels
        return tuple(zip(wheels[::2], wheels[1::2], strict=True))

    @property
    def sprung(self):
        """Names of the bodies that are no wheelsets."""
        return tuple(name for name in self.results.bodies if name not in self.results.wheelsets)

    def quotient(self, wheel):
        """Y over Q of a wheel, positive towards its flange; none where it bears nothing."""
        sign = 1.0 if wheel.endswith("right") else -1.0

        def curve(y, q):
            bears = q > 0.0
            return np.where(bears, sign * y / np.where(bears, q, 1.0), np.nan)[:, None]

        return self.thinned([f"wheels/{wheel}/Y", f"wheels/{wheel}/Q"], curve)[0]

    @cached_property
    def has_contact(self):
        """Whether the channels of the contact patches that figures draw were recorded; a note when not."""
        wheels = (wheel for pair in self.wheelsets for wheel in pair)
        found = all(name in self.results.channels for wheel in wheels for name in _drawn_contact(wheel))
        if not found:
            self._note("no creepages and contact places: their channels were not recorded")
        return found

    def creepages(self, wheel):
        """Of the patch of a wheel that bears most: creepages xi, eta, phi and its place on the wheel."""
        if wheel in self._creepages:
            return self._creepages[wheel]
        names = _drawn_contact(wheel)

        def of(k):
            def curve(normal, *rest):
                return np.take_along_axis(rest[k], normal.argmax(axis=1)[:, None], axis=1)

            return curve

        self._creepages[wheel] = self.thinned(names, *map(of, range(len(CREEPAGES))))
        return self._creepages[wheel]

    def spectrum(self, channel, k):
        """One-sided power spectral density of a component (Welch; Hann, segments of 5 s, half overlapping).

        Returns
        -------
        frequency, density : array or None
            [Hz], units squared per Hz; None, with a note, when the rows are too few or not even.
        """
        time = self.results.time
        steps = np.diff(time)
        if time.size < FEWEST or np.ptp(steps) > EVEN * steps.mean():
            self._note("no spectra: they need at least 16 rows at even intervals")
            return None
        rate = (time.size - 1) / (time[-1] - time[0])
        frequency, density = welch(
            self.results.read(channel)[:, k], rate, nperseg=min(time.size, max(FEWEST, round(SEGMENT * rate)))
        )
        return frequency[1:], density[1:]

    @cached_property
    def scenario(self):
        """The Scenario; None, with a note, when this version cannot read it."""
        try:
            return self.results.scenario
        except InputError as error:
            self._note(f"no track and no assessment: {error}")
            return None

    @cached_property
    def track(self):
        """The Course of the alignment along the run; None without a scenario."""
        if self.scenario is None:
            return None
        pieces = self.scenario.pieces()
        s = (pieces["start"][:, None] + pieces["length"][:, None] * np.linspace(0.0, 1.0, 9)).ravel()
        return course(pieces, np.unique(s[(s >= 0.0) & (s <= self.s.max())]))

    @cached_property
    def rails(self):
        """Arc length (n,) and displacement of the rails, (right and left, to the right and down, n) [m]; or None."""
        scenario = self.scenario
        try:
            if scenario is None or not any(True for _ in contributions(scenario)):
                return None
            s = np.linspace(0.0, self.s.max(), RAIL_POINTS)
            return s, displacement(scenario, s)[0]
        except InputError as error:
            self._note(f"no displacement of the rails: {error}")
            return None

    def _note(self, text):
        if text not in self.notes:
            self.notes.append(text)


def _drawn_contact(wheel):
    return [f"wheels/{wheel}/contact/{name}" for name in ("normal", *CREEPAGES)]


def _extremes(values, bucket):
    """Lowest and highest value of every bucket of rows, in turn; a bucket of one row: the values."""
    if bucket == 1:
        return values
    starts = np.arange(0, values.size, bucket)
    return np.stack([np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)], axis=1).ravel()
