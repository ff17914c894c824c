"""Figures of an assessment: how candidates become values, and signals along the track for figures."""

import math
from dataclasses import dataclass, field

import numpy as np

from railcli.model.assessment import FIGURES, GRADES

STEP = 0.5  # of sliding means, and least width of a bin of a trace [m]
BINS = 1500  # of a trace
FAR = 1e-12


@dataclass(frozen=True)
class Value:
    """A figure, judged.

    Attributes
    ----------
    key : str
        Of model.assessment.FIGURES.
    value, limit : float or None
        SI; None: not evaluated, no limit.
    status : {"pass", "warn", "fail", "no limit", "not evaluated"}
    place : str
        Where it is nearest to its limit.
    note : str
    """

    key: str
    value: float | None
    limit: float | None
    status: str
    place: str = ""
    note: str = ""


class Trace:
    """Smallest and largest value of a signal in bins along the track.

    Parameters
    ----------
    sections : list of Section
    spacing : float
        Of the samples [m].

    Attributes
    ----------
    places, low, high : array (n,)
        Middles of the bins [m]; NaN where nothing fell.
    """

    def __init__(self, sections, spacing):
        start, end = sections[0].start, sections[-1].end
        count = int(np.clip((end - start) / max(1.5 * spacing, STEP), 1, BINS))
        self._edges = np.linspace(start, end, count + 1)
        self.places = 0.5 * (self._edges[1:] + self._edges[:-1])
        self.low, self.high = np.full(count, np.nan), np.full(count, np.nan)

    def add(self, s, x):
        """Take in values at places."""
        bins = np.searchsorted(self._edges, s, "right") - 1
        inside = (bins >= 0) & (bins < self.low.size) & ~np.isnan(x)
        np.fmin.at(self.low, bins[inside], x[inside])
        np.fmax.at(self.high, bins[inside], x[inside])


@dataclass
class Assessment:
    """What was formed of a run.

    Attributes
    ----------
    values : list of Value
    sections : list of Section
    by_section : dict of str to list
        For each figure its value in each section; None where it is not evaluated.
    wear : dict of str to dict of str to (float, float)
        Wheel, part of the profile -> mean over all sections and largest mean of a section of T-gamma [N].
    traces : dict of str to dict of str to Trace
        Figure, line -> signal along the track.
    bounds : dict of str to float
        Limits to draw into the traces; None where there is none.
    conditions : dict of str to value
        What was evaluated, and how.
    warnings : list of str
    fault : str
        What broke the run off; empty when it reached its end.
    """

    values: list = field(default_factory=list)
    sections: list = field(default_factory=list)
    by_section: dict = field(default_factory=dict)
    wear: dict = field(default_factory=dict)
    traces: dict = field(default_factory=dict)
    bounds: dict = field(default_factory=dict)
    conditions: dict = field(default_factory=dict)
    warnings: list = field(default_factory=list)
    fault: str = ""

    @property
    def accepted(self):
        """Nothing failed, and the run reached its end."""
        return not self.fault and not self.count("fail")

    def count(self, status):
        """How many figures have a status."""
        return sum(value.status == status for value in self.values)


class Tally:
    """Gathers the candidates of every figure and keeps the one nearest to its limit."""

    def __init__(self, count, warn_share):
        self._best, self._missing = {}, {}
        self._warn_share = warn_share
        self.by_section = {key: [None] * count for key in FIGURES}

    def offer(self, key, value, limit, place, note="", section=None):
        """A candidate for a figure; `section` is the number of the section it belongs to."""
        value = float(value)
        if not math.isfinite(value):
            return
        rank = value / limit if limit else value * FAR  # one that has a limit comes first
        if key not in self._best or rank > self._best[key][0]:
            self._best[key] = (rank, value, limit, place, note)
        if section is not None:
            row = self.by_section[key]
            row[section] = value if row[section] is None else max(row[section], value)

    def missing(self, keys, reason):
        """Say why figures may not be formed; the first reason stays."""
        for key in keys:
            self._missing.setdefault(key, reason)

    def values(self):
        """All figures in their order."""
        return [self._value(key) for key in FIGURES]

    def _value(self, key):
        if key not in self._best:
            return Value(key, None, None, "not evaluated", note=self._missing.get(key, "nothing to form it of"))
        _, value, limit, place, note = self._best[key]
        if key in GRADES:
            grade = next(word for bound, word in GRADES[key] if value < bound)
            note = f"{grade}; {note}" if note else grade
        if limit is None:
            return Value(key, value, None, "no limit", place, note)
        share = value / limit
        status = "fail" if share > 1.0 else "warn" if share > self._warn_share else "pass"
        return Value(key, value, limit, status, place, note)
