"""A recorded run seen by place: which rows hold a stretch of track."""

import math

import numpy as np

BLOCK = 100_000  # rows evaluated at once
STRIDE = 100  # rows between the places that are kept


class Run:
    """A run and what every part of an assessment asks of it.

    Parameters
    ----------
    results : files.read_results.Results
        Anything with its `rows`, `channels`, `read`, `pieces`, `bodies`, `wheelsets`, `wheels`, `filtered`, `scenario`.
    limits : Limits
    broken : bool
        The run did not reach its end: there is no run-out.

    Attributes
    ----------
    source : files.read_results.Rows
        What is judged: the low-passed stream, or the rows where there is none.
    interval, rate : float
        Between two rows [s]; its inverse [Hz].
    speed : float
        [m/s]
    first_row, last_row : int
        The first one after the run-in, and the one behind the last that counts.
    """

    def __init__(self, results, limits, broken=False):
        self.limits, self.broken, self.scenario = limits, broken, results.scenario
        self.source = source = results.filtered or results
        self.filtered = results.filtered is not None
        self.speed = self.scenario.run.speed
        begin, end = (float(source.read("time", row, row + 1)[0]) for row in (0, source.rows - 1))
        self.interval = round((end - begin) / max(source.rows - 1, 1), 9) or self.scenario.run.output_interval
        self.rate = round(1.0 / self.interval, 6)
        self.first_row = max(0, min(source.rows, math.ceil((limits.run_in - begin) / self.interval - 1e-6)))
        self.last_row = source.rows - (0 if broken else round(limits.run_out / self.interval))
        name = f"bodies/{source.bodies[0]}/{'s' if self.filtered else 'position'}"
        self._places = np.concatenate(
            [place.reshape(len(place), -1)[::STRIDE, 0] for (place,) in source.pieces(name, size=100 * STRIDE)]
        )
        self._offsets = self._wheelset_places(0) - self._places[0]

    def _wheelset_places(self, row):
        return np.array([self.places(name, row, row + 1)[0] for name in self.source.wheelsets])

    def places(self, body, start, stop):
        """Arc lengths of a body in rows [m]."""
        if self.filtered:
            return self.source.read(f"bodies/{body}/s", start, stop)
        return self.source.read(f"bodies/{body}/position", start, stop)[:, 0]

    def absent(self, names):
        """The first of the channels that was not recorded, or None."""
        return next((name for name in names if name not in self.source.channels), None)

    def stretch(self):
        """Arc lengths between which every wheelset ran in rows that count; of a broken run, as far as any came [m]."""
        if self.first_row >= self.last_row:
            return 0.0, 0.0
        first, last = (self._wheelset_places(row) for row in (self.first_row, self.last_row - 1))
        return float(first.max()), float(last.max() if self.broken else last.min())

    def rows(self, start, end, margin):
        """First row and the one behind the last that hold a stretch for every wheelset, with a margin [m]."""
        low, high = start - margin - self._offsets.max(), end + margin - self._offsets.min()
        first = (np.searchsorted(self._places, low) - 1) * STRIDE
        last = (np.searchsorted(self._places, high) + 1) * STRIDE
        return max(0, int(first)), min(self.source.rows, int(last))

    def blocks(self, sections):
        """Numbers of adjoining sections, as many at a time as make a block of rows."""
        length = BLOCK * self.interval * self.speed
        group = []
        for number, section in enumerate(sections):
            before = sections[number - 1]
            if group and (section.end - sections[group[0]].start > length or section.start > before.end + 1e-6):
                yield group
                group = []
            group.append(number)
        if group:
            yield group
