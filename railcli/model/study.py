"""A parameter study: which keys of a scenario take which values, and what is kept of every run."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, model_validator

from .checks import Description, Name, Place, Positive, Real, Text

DISTRIBUTIONS = {  # name: what it needs beside min and max
    "uniform": (),
    "loguniform": (),
    "triangular": ("mode",),
    "normal": ("mean", "sd"),
    "lognormal": ("median", "factor"),
}
METHODS = ("latin-hypercube", "sobol", "random", "sobol-indices")
GROUPS = {  # of outputs
    "steady": "steady motion at the end by Newton's method, without a run",
    "end": "means over the last metres of a run",
    "assessment": "figures of railcli assess",
}
STATISTICS = ("mean", "min", "max", "std", "rms", "range", "last")  # and p followed by a percentage
LARGEST_SEED = 2**32 - 1
LEAST_WITHIN = 1e-6  # share of a distribution that its bounds leave

_Count = Annotated[int, Strict(), Field(ge=1, le=10**9)]
_Seed = Annotated[int, Strict(), Field(ge=0, le=LARGEST_SEED)]


class Parameter(Description):
    """A key, or several that take the same value, and its values: a list, a range, or a distribution.

    Values are in the unit that the key names. Lists and ranges are crossed with one another and with the sample that
    distributions make.
    """

    key: Text | tuple[Text, ...]
    values: Annotated[tuple[Any, ...], Field(min_length=1)] | None = None
    first: Real | None = Field(None, alias="from")
    last: Real | None = Field(None, alias="to")
    count: Annotated[_Count, Field(ge=2)] | None = None
    step: Positive | None = None
    distribution: Literal[tuple(DISTRIBUTIONS)] | None = None
    min: Real | None = None
    max: Real | None = None
    mode: Real | None = None
    mean: Real | None = None
    sd: Positive | None = None
    median: Positive | None = None
    factor: Annotated[Real, Field(gt=1.0)] | None = None

    @model_validator(mode="after")
    def _is_one_kind(self):
        if not self.keys or not all(self.keys):
            raise ValueError("key: names no key; give one such as 'contact.friction'")
        given = {name for name in type(self).model_fields if getattr(self, name) is not None} - {"key"}
        ways = [way for way, name in (("values", "values"), ("from", "first"), ("distribution", "distribution"))
                if name in given]  # fmt: skip
        if len(ways) != 1:
            found = " and ".join(ways) or "none of them"
            raise ValueError(f"{self.name}: give either values, or from and to, or a distribution; got {found}")
        allowed = {
            "values": {"values"},
            "from": {"first", "last", "count", "step"},
            "distribution": {"distribution", "min", "max", *DISTRIBUTIONS.get(self.distribution, ())},
        }[ways[0]]
        if extra := sorted(given - allowed):
            raise ValueError(f"{self.name}: {extra[0]!r} does not go with {ways[0]!r}")
        if ways[0] == "from":
            self._check_range()
        if ways[0] == "distribution":
            self._check_distribution()
        return self

    def _check_range(self):
        if self.last is None or (self.count is None) == (self.step is None):
            raise ValueError(f"{self.name}: a range needs from, to, and either count or step")
        if self.first == self.last:
            raise ValueError(f"{self.name}: a range from {self.first:g} to {self.last:g} is one value; give values")

    def _check_distribution(self):
        if self.min is None or self.max is None or not self.min < self.max:
            raise ValueError(
                f"{self.name}: a distribution needs bounds, min below max: no run is made beyond them; "
                f"got min {_shown(self.min)}, max {_shown(self.max)}"
            )
        for name in DISTRIBUTIONS[self.distribution]:
            if getattr(self, name) is None:
                raise ValueError(f"{self.name}: distribution {self.distribution!r} needs {name!r}")
        if self.distribution in ("loguniform", "lognormal") and self.min <= 0.0:
            raise ValueError(f"{self.name}: distribution {self.distribution!r} needs min > 0, got {self.min:g}")
        if self.mode is not None and not self.min <= self.mode <= self.max:
            raise ValueError(f"{self.name}: mode must lie from {self.min:g} to {self.max:g}, got {self.mode:g}")
        if self.within < LEAST_WITHIN:
            raise ValueError(
                f"{self.name}: next to nothing of the distribution lies from min {self.min:g} to max {self.max:g}; "
                "choose other bounds"
            )

    @property
    def within(self):
        """Share of a normal or lognormal distribution that its bounds leave; 1 of others."""
        if self.distribution == "normal":
            low, high = ((bound - self.mean) / self.sd for bound in (self.min, self.max))
        elif self.distribution == "lognormal":
            low, high = (math.log(bound / self.median) / math.log(self.factor) for bound in (self.min, self.max))
        else:
            return 1.0
        if low > 0.0:
            low, high = -high, -low  # the tail without the rounding of 1
        return 0.5 * (math.erfc(-high / math.sqrt(2.0)) - math.erfc(-low / math.sqrt(2.0)))

    @property
    def keys(self):
        return (self.key,) if isinstance(self.key, str) else self.key

    @property
    def name(self):
        """By which columns call it."""
        return self.keys[0] if self.keys else "vary"

    @property
    def is_sampled(self):
        return self.distribution is not None


class Sample(Description):
    """How many points distributions are drawn at, and how."""

    method: Literal[METHODS] = "latin-hypercube"
    count: Annotated[_Count, Field(ge=2)]
    seed: _Seed = 1

    @model_validator(mode="after")
    def _is_balanced(self):
        if self.method.startswith("sobol") and self.count & (self.count - 1):
            less = 1 << (self.count.bit_length() - 1)
            raise ValueError(
                f"sample.count: Sobol points are balanced in powers of 2 only; give {less} or {2 * less}, "
                f"got {self.count}"
            )
        return self


class ChannelOutput(Description):
    """Statistics of recorded channels, by globs as in `railcli export`, over a stretch of the run."""

    channel: Text
    statistics: Annotated[tuple[Text, ...], Field(min_length=1)] = ("min", "mean", "max")
    start: Real = Field(0.0, alias="from_m")
    end: Real | None = Field(None, alias="to_m")

    @model_validator(mode="after")
    def _can_be_formed(self):
        for text in self.statistics:
            if text not in STATISTICS and percentage(text) is None:
                raise ValueError(
                    f"statistics: {text!r} is none; give some of {', '.join(STATISTICS)} or a percentile such as p99.85"
                )
        if self.end is not None and self.end <= self.start:
            raise ValueError(f"to_m must lie behind from_m, got {self.start:g} and {self.end:g} m")
        return self


class Study(Description):
    """A parameter study; built from a file or from options by `railcli.files.study`."""

    name: Name
    title: Text = ""
    description: Text = ""
    scenario: Place | None = None
    parameters: tuple[Parameter, ...] = Field((), alias="vary")
    sample: Sample | None = None
    seeds: _Count | Annotated[tuple[_Seed, ...], Field(min_length=1)] | None = None
    outputs: tuple[Text, ...] | None = None  # globs; None: all groups, but those of runs where channels are asked for
    channels: tuple[ChannelOutput, ...] = Field((), alias="channel")
    limits: Place | None = None
    figures: tuple[Text, ...] = ()  # outputs to draw; the first ones without

    @model_validator(mode="after")
    def _fits_together(self):
        if not self.parameters and self.seeds is None:
            raise ValueError("names no key to vary; give a table [[vary]] with key and values, or --vary KEY=VALUES")
        keys = [key for one in self.parameters for key in one.keys]
        if doubles := sorted({key for key in keys if keys.count(key) > 1}):
            raise ValueError(f"vary: {doubles[0]!r} stands twice; keep one of them")
        sampled = [one.name for one in self.parameters if one.is_sampled]
        if sampled and self.sample is None:
            raise ValueError(f"sample: {sampled[0]!r} has a distribution; give [sample] with count, or --sample COUNT")
        if self.sample and not sampled:
            raise ValueError("sample: no key has a distribution to draw from; give one, or leave the sample out")
        if self.sample and self.sample.method == "sobol-indices":
            if len(sampled) < len(self.parameters) or self.seeds is not None:
                raise ValueError("sample: 'sobol-indices' goes with distributions alone, no lists, ranges or seeds")
        for pattern in self.outputs or ():
            if pattern.partition(".")[0] not in GROUPS:
                raise ValueError(f"outputs: {pattern!r} begins with no group; known: {', '.join(GROUPS)}")
        return self

    @property
    def patterns(self):
        """Globs of the outputs that are kept."""
        if self.outputs is not None:
            return self.outputs
        return () if self.channels else tuple(f"{group}.*" for group in GROUPS)

    def wants(self, group):
        """True when outputs of a group are kept."""
        return any(pattern.partition(".")[0] == group for pattern in self.patterns)

    @property
    def runs_in_time(self):
        """False when quasi-static values are all that is asked for."""
        return bool(self.channels) or self.wants("end") or self.wants("assessment")


def percentage(text):
    """The percentage that a statistic such as ``p99.85`` names; None for other texts."""
    try:
        value = float(text[1:]) if text.startswith("p") else -1.0
    except ValueError:
        return None
    return value if 0.0 <= value <= 100.0 else None


def _shown(value):
    return "none" if value is None else f"{value:g}"
