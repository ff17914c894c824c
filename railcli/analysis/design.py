"""Points of a parameter study: lists and ranges crossed with a sample of the distributions and with seeds.

Seeds change fastest, then points of the sample, then lists and ranges, the last of them first. A point depends on its
number and the study alone.
"""

import hashlib
import math
from functools import cached_property
from itertools import pairwise

import numpy as np

from railcli.errors import InputError
from railcli.model.study import LARGEST_SEED

SEED = "seed"  # name of the column
ALMOST = 1e-9  # of a step that rounding may cost the last value of a range


class Design:
    """The points of a study, each made when it is asked for.

    Parameters
    ----------
    study : model.study.Study

    Attributes
    ----------
    names : tuple of str
        Of the columns: parameters in the order of the study, then the seed.
    """

    def __init__(self, study):
        self.study = study
        self._grid = {one.name: one for one in study.parameters if not one.is_sampled}
        self._sampled = [one for one in study.parameters if one.is_sampled]
        self._lengths = {name: length(one) for name, one in self._grid.items()}
        self._seeds = range(1, study.seeds + 1) if isinstance(study.seeds, int) else study.seeds or ()
        self.names = (*(one.name for one in study.parameters), *([SEED] if self._seeds else []))

    @property
    def count(self):
        """Number of points."""
        return math.prod(self._lengths.values()) * self.sample_size * (len(self._seeds) or 1)

    @property
    def sample_size(self):
        """Points of the sample at each point of the grid."""
        sample = self.study.sample
        if sample is None:
            return 1
        return sample.count * (len(self._sampled) + 2) if sample.method == "sobol-indices" else sample.count

    def point(self, number):
        """Values by name of the point with this number, counted from 0."""
        found = {}
        if self._seeds:
            number, k = divmod(number, len(self._seeds))
            found[SEED] = self._seeds[k]
        number, k = divmod(number, self.sample_size)
        for one, value in zip(self._sampled, self._drawn[k] if self._sampled else (), strict=True):
            found[one.name] = float(value)
        for name in reversed(self._grid):
            number, k = divmod(number, self._lengths[name])
            found[name] = value_of(self._grid[name], k)
        return {name: found[name] for name in self.names}

    def digest(self):
        """Of the points, for a study that goes on."""
        given = self.study.model_dump(mode="json", include={"parameters", "sample", "seeds"})
        drawn = self._drawn.tobytes() if self._sampled else b""
        return hashlib.sha256(repr(given).encode() + drawn).hexdigest()[:16]

    @cached_property
    def _drawn(self):
        """Points of the sample (sample_size, number of distributions)."""
        unit = unit_points(self.study.sample, len(self._sampled))
        return np.stack([quantile(one, unit[:, k]) for k, one in enumerate(self._sampled)], axis=1)


def length(parameter):
    """Number of values of a list or range."""
    if parameter.values is not None:
        return len(parameter.values)
    if parameter.count is not None:
        return parameter.count
    return math.floor(abs(parameter.last - parameter.first) / parameter.step * (1.0 + ALMOST) + ALMOST) + 1


def value_of(parameter, k):
    """Value number k of a list or range, counted from 0."""
    if parameter.values is not None:
        return parameter.values[k]
    first, last = parameter.first, parameter.last
    if parameter.count is not None:
        share = k / (parameter.count - 1)
        return last if share == 1.0 else first + share * (last - first)
    return first + math.copysign(parameter.step, last - first) * k


def unit_points(sample, dimensions):
    """Points of a sample in the unit cube, (n, dimensions).

    Of ``sobol-indices`` each base point is followed by its mixtures: A, then A with each column in turn from B, then B
    (Saltelli et al. 2010, Comput. Phys. Commun. 181, 259), as SALib orders them.
    """
    from scipy.stats import qmc

    def engine(kind, d, **options):
        generator = np.random.default_rng(sample.seed)
        try:
            return kind(d, rng=generator, **options)
        except TypeError:  # SciPy before 1.15
            return kind(d, seed=generator, **options)

    if sample.method == "random":
        return np.random.default_rng(sample.seed).random((sample.count, dimensions))
    if sample.method == "latin-hypercube":
        return engine(qmc.LatinHypercube, dimensions).random(sample.count)
    if sample.method == "sobol":
        return engine(qmc.Sobol, dimensions, scramble=True).random(sample.count)
    both = engine(qmc.Sobol, 2 * dimensions, scramble=True).random(sample.count)
    a, b = both[:, :dimensions], both[:, dimensions:]
    mixed = []
    for k in range(dimensions):
        mixed.append(a.copy())
        mixed[-1][:, k] = b[:, k]
    return np.stack([a, *mixed, b], axis=1).reshape(-1, dimensions)


def quantile(parameter, share):
    """Values of a distribution, cut off at its bounds, at cumulative shares (n,) of what is left of it."""
    from scipy import stats

    low, high = parameter.min, parameter.max
    if parameter.distribution == "uniform":
        found = low + share * (high - low)
    elif parameter.distribution == "loguniform":
        found = np.exp(np.log(low) + share * (np.log(high) - np.log(low)))
    elif parameter.distribution == "triangular":
        found = stats.triang.ppf(share, (parameter.mode - low) / (high - low), low, high - low)
    elif parameter.distribution == "normal":
        found = _cut_normal(share, low, high, parameter.mean, parameter.sd)
    else:
        spread = math.log(parameter.factor)
        found = np.exp(_cut_normal(share, math.log(low), math.log(high), math.log(parameter.median), spread))
    return np.clip(found, low, high)


def _cut_normal(share, low, high, mean, spread):
    from scipy import stats

    return stats.truncnorm.ppf(share, (low - mean) / spread, (high - mean) / spread, mean, spread)


def seeds_of(scenario, seed):
    """Changes that give the random irregularity of a scenario a seed; several sources keep the distance of theirs.

    Raises
    ------
    InputError
        There is none.
    """
    given = {k: source.seed for k, source in enumerate(scenario.irregularity, start=1) if hasattr(source, "seed")}
    if not given:
        raise InputError(scenario.name, "has no [[irregularity]] with a seed; leave seeds out")
    first = next(iter(given.values()))
    return {f"irregularity[{k}].seed": (seed + own - first) % (LARGEST_SEED + 1) for k, own in given.items()}


def spread(count, most):
    """Numbers of at most so many points that lie all over a design, first and last among them."""
    if count <= most:
        return list(range(count))
    found = [round(k * (count - 1) / (most - 1)) for k in range(most)]
    return [found[0], *(b for a, b in pairwise(found) if b != a)]
