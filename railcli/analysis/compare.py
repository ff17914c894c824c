"""Two results channel by channel: by how much they differ, where, and whether that is more than allowed."""

from dataclasses import dataclass, field

import numpy as np

RELATIVE = 1e-6  # of the channel's range
ABSOLUTE = {  # a millionth of an ordinary value: 1 mm, 1 mrad, 0.1 m/s, 50 kN, creepage 0.001, 10 N m, 1 m/s^2
    "s": 1e-9,
    "m": 1e-9,
    "rad": 1e-9,
    "m/s": 1e-7,
    "rad/s": 1e-7,
    "m/s^2": 1e-6,
    "N": 0.05,
    "N m": 1e-5,
    "1/m": 1e-7,
    "-": 1e-9,
}
SAME_INSTANT = 1e-3  # of the shorter interval


@dataclass(frozen=True)
class Tolerances:
    """What two results may differ by: the larger of a share of the channel's range and a value for its unit."""

    relative: float = RELATIVE
    absolute: dict = field(default_factory=lambda: dict(ABSOLUTE))

    def of(self, units, extent):
        """For a channel of these units and this range, in its units."""
        return max(self.relative * extent, self.absolute.get(units, 0.0))


@dataclass(frozen=True)
class Difference:
    """How a channel of two results differs, in its units.

    Attributes
    ----------
    name, units : str
    largest : float
        Largest difference without sign; zero when there is none.
    row : int
        Where it is largest, or, when only one of the results has numbers somewhere, the first such place.
    first_row : int
        Where the difference first is more than the tolerance; `row` when it never is.
    one, two : float
        The values at `row`.
    extent, tolerance : float
        Range of the first result's values, and what is allowed.
    beyond : int
        Rows at which the difference is more than the tolerance, or only one of the results has a number.
    one_sided : int
        Rows at which only one of them has a number.
    """

    name: str
    units: str
    largest: float
    row: int
    first_row: int
    one: float
    two: float
    extent: float
    tolerance: float
    beyond: int
    one_sided: int

    @property
    def excess(self):
        """Largest difference over the tolerance; rows where only one of the results has a number do not count."""
        return self.largest / self.tolerance if self.tolerance else np.inf if self.largest else 0.0


@dataclass(frozen=True)
class Sampling:
    """When a result was recorded: rows, first and last time, usual interval [s]."""

    rows: int
    first: float
    last: float
    interval: float

    @classmethod
    def of(cls, time):
        """Of rising times [s], at least one."""
        usual = float(np.median(np.diff(time))) if time.size > 1 else 0.0
        return cls(time.size, float(time[0]), float(time[-1]), usual)


@dataclass(frozen=True)
class Comparison:
    """Two results compared.

    Attributes
    ----------
    differences : tuple of Difference
        One for each column that both have, in the order of the first result, whether it differs or not.
    only_one, only_two : tuple of str
        Columns that one of them has.
    units_differ : tuple of (str, str, str)
        Columns whose units differ, which were not compared: name, units of the first, of the second.
    sampling : (Sampling, Sampling)
    time, place : array
        Instants at which both were compared [s], and arc length of the first result's first body there [m].
    common : bool
        What only one of them has is no difference.
    of_intervals : int
        Columns of means and extremes, which were not compared because the intervals of the rows differ.
    """

    differences: tuple
    only_one: tuple
    only_two: tuple
    units_differ: tuple
    sampling: tuple
    time: np.ndarray
    place: np.ndarray
    common: bool
    of_intervals: int

    @property
    def beyond(self):
        """Differences beyond tolerance, the worst first; last those where only one of the results has a number."""
        return sorted((one for one in self.differences if one.beyond), key=lambda one: (-one.excess, -one.one_sided))

    @property
    def same_instants(self):
        """True when both have rows at the same times."""
        return self.time.size == self.sampling[0].rows == self.sampling[1].rows

    @property
    def differs(self):
        """True when the results are not the same within the tolerances."""
        alone = bool(self.only_one or self.only_two) or not self.same_instants
        return bool(self.beyond or self.units_differ or not self.differences or (alone and not self.common))


def compare_results(one, two, of_one, of_two, tolerances, common=False, progress=lambda percent: None):
    """Compare two results at the instants that both have.

    Parameters
    ----------
    one, two : Results
    of_one, of_two : sequence of Column
        What to compare; the first of each is time.
    tolerances : Tolerances
    common : bool
        What only one of them has is no difference.
    progress : callable
        Is told the share that is done [%].

    Returns
    -------
    Comparison
    """
    names = {column.name: column for column in of_two}
    times = one.time, two.time
    rows_one, rows_two = common_instants(*times)
    sampling = tuple(Sampling.of(time) for time in times)
    both = [(column, names[column.name]) for column in of_one if column.name in names]
    of_intervals = [pair for pair in both if any(column.of_interval for column in pair)]
    if np.isclose(*(when.interval for when in sampling), rtol=SAME_INSTANT):
        of_intervals = []
    both = [pair for pair in both if pair not in of_intervals]
    found, kept, values = [], None, None
    for k, (column, other) in enumerate(both):
        if column.units == other.units and rows_one.size:
            if column.channel != kept:  # a channel's columns follow one another
                kept = column.channel
                values = one.read(kept)[rows_one], two.read(kept)[rows_two]
            pair = column.of(values[0]), other.of(values[1])
            found.append(compare(column.name, column.units, *pair, tolerances))
        progress(100 * (k + 1) // len(both))
    return Comparison(
        differences=tuple(found),
        only_one=tuple(column.name for column in of_one if column.name not in names),
        only_two=tuple(name for name in names if name not in {column.name for column in of_one}),
        units_differ=tuple((a.name, a.units, b.units) for a, b in both if a.units != b.units),
        sampling=sampling,
        time=times[0][rows_one],
        place=one.s[rows_one],
        common=common,
        of_intervals=len(of_intervals),
    )


def compare(name, units, one, two, tolerances):
    """Compare the values of a channel at the same instants.

    Parameters
    ----------
    name, units : str
    one, two : array (n,)
        n at least 1. Not a number at the same places is no difference.
    tolerances : Tolerances

    Returns
    -------
    Difference
    """
    finite = one[np.isfinite(one)]
    extent = float(np.ptp(finite)) if finite.size else 0.0
    tolerance = tolerances.of(units, extent)
    alike = (one == two) | (np.isnan(one) & np.isnan(two))
    odd = ~alike & ~(np.isfinite(one) & np.isfinite(two))
    with np.errstate(invalid="ignore"):
        distance = np.where(alike | odd, 0.0, np.abs(one - two))
    beyond = (distance > tolerance) | odd
    row = int(odd.argmax() if odd.any() and not distance.any() else distance.argmax())
    return Difference(
        name=name,
        units=units,
        largest=float(distance.max()),
        row=row,
        first_row=int(beyond.argmax()) if beyond.any() else row,
        one=float(one[row]),
        two=float(two[row]),
        extent=extent,
        tolerance=tolerance,
        beyond=int(beyond.sum()),
        one_sided=int(odd.sum()),
    )


def common_instants(one, two):
    """Rows of two results at the same times.

    Parameters
    ----------
    one, two : array
        Their times, rising [s].

    Returns
    -------
    rows_one, rows_two : array of int
        Pairs, in order of time.
    """
    room = SAME_INSTANT * min((time.interval for time in map(Sampling.of, (one, two)) if time.rows > 1), default=1.0)
    after = np.clip(np.searchsorted(two, one), 0, two.size - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(one - two[before]) < np.abs(two[after] - one), before, after)
    same = np.abs(one - two[nearest]) <= room
    return np.flatnonzero(same), nearest[same]
