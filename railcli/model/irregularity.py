"""Irregularity of the rails: measured tracks, discrete defects, power spectra.

Users count heights up and lateral positions to the right; cross-level is the height of the left over the right rail,
gauge the widening. Inside, displacements of rails are arrays (rail, direction, n): right and left rail; to the right
and down. Every source gives values [m] and slopes [-].
"""

import hashlib
import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field, InstanceOf, computed_field, model_validator

from railcli.errors import InputError

from . import checks
from .checks import Description, NotNegative, Positive, Real, one_of
from .spectra import CHANNELS, SAMPLES_PER_WAVE, SPECTRA, realise

LARGEST = 0.1  # displacement that can be meant [m]
FADE = 10.0  # length over which stretches of irregularity begin [m]
ROUNDING = 0.05  # length over which corners of a defect are rounded [m]
PIECES = 32  # of a defect's length
FINEST = 0.01  # distance of nodes that keeps the jump of curvature where a defect begins [m]
PER_SAMPLE = 4  # nodes per distance of measured samples

ChordParts = Annotated[
    tuple[Annotated[Positive, Field(le=100.0)], ...],
    BeforeValidator(lambda value: value if isinstance(value, list | tuple) else (value / 2.0, value / 2.0)
                    if isinstance(value, float | int) and not isinstance(value, bool) else value),
    Field(min_length=2, max_length=2),
]  # fmt: skip
Size = Annotated[Real, Field(ge=-LARGEST, le=LARGEST)]
Place = Annotated[Real, Field(ge=-1e6, le=1e6)]
Length = Annotated[Positive, Field(le=1e5)]


class Course(NamedTuple):
    """What a source must know of the run."""

    front: float  # arc length of the foremost wheelset at the start [m]
    end: float  # and at the end of the run [m]
    track_end: float  # where the track ends, its continuation included [m]
    level: float  # distance of the rails over the base of cross-level [-]
    origin: float = 0.0  # position along the line at s = 0, as the track counts it [m]


def rails(channels, level):
    """Displacements (rail, direction, n) of channels: dict of name to array (n,), in the user's signs.

    Names are CHANNELS, and `right_vertical`, `left_alignment` and so on for one rail.
    """
    size = np.size(next(iter(channels.values())))
    moved = np.zeros((2, 2, size))
    for name, value in channels.items():
        if name in ("alignment", "gauge"):
            half = 0.5 if name == "gauge" else 1.0
            moved[0, 0] += half * value
            moved[1, 0] += -half * value if name == "gauge" else value
        elif name == "vertical":
            moved[:, 1] -= value
        elif name == "cross_level":
            moved[0, 1] += 0.5 * level * value
            moved[1, 1] -= 0.5 * level * value
        else:
            side, direction = name.split("_")
            down = direction == "vertical"
            moved[0 if side == "right" else 1, int(down)] += -value if down else value
    return moved


def channels(moved, level):
    """The four CHANNELS of displacements (rail, direction, n), in the user's signs: the inverse of `rails`."""
    right, left = moved
    return {
        "vertical": -0.5 * (right[1] + left[1]),
        "alignment": 0.5 * (right[0] + left[0]),
        "cross_level": (right[1] - left[1]) / level,
        "gauge": right[0] - left[0],
    }


def fade(s, begin, length):
    """Factor that grows smoothly from 0 at `begin` to 1, and its slope: 10 u^3 - 15 u^4 + 6 u^5."""
    u = np.clip((s - begin) / length, 0.0, 1.0)
    return u**3 * (10.0 - u * (15.0 - 6.0 * u)), 30.0 * u**2 * (1.0 - u) ** 2 / length


def _faded(value, slope, s, begin, length):
    factor, rise = fade(s, begin, length)
    return factor * value, factor * slope + rise * value


class Stretch(Description):
    """What stretches of irregularity have in common: where they begin, and how softly."""

    begin: Place | None = Field(None, alias="begin_m")  # default: under the foremost wheelset at the start
    fade: Annotated[Positive, Field(le=1e4)] = Field(FADE, alias="fade_m")

    def start(self, course):
        return course.front if self.begin is None else self.begin

    def _check_start(self, course):
        if self.start(course) < course.front - 1e-9:
            raise ValueError(
                f"begins at {self.start(course):g} m, but the vehicle starts on perfect track and its foremost "
                f"wheelset stands at {course.front:g} m: begin_m must be at least that"
            )


class Spectrum(Stretch):
    """Waves of random phase with the density of a power spectrum."""

    kind: Literal["random"] = "random"
    spectrum: one_of(SPECTRA)
    channels: Annotated[tuple[Literal[CHANNELS], ...], Field(min_length=1)] = CHANNELS
    shortest: Annotated[Positive, Field(ge=0.02, le=1e3)] = Field(3.0, alias="shortest_m")
    longest: Annotated[Positive, Field(le=1e4)] = Field(70.0, alias="longest_m")
    seed: Annotated[int, Field(ge=0, le=2**32 - 1, strict=True)] = 1
    sided: Literal["one", "two"] = "one"  # what S of the publication means
    scale: Annotated[Positive, Field(le=100.0)] = 1.0  # of all values

    @model_validator(mode="after")
    def _band(self):
        if self.shortest >= self.longest:
            raise ValueError(
                f"no band from {self.shortest:g} to {self.longest:g} m: shortest_m must be below longest_m"
            )
        if len(set(self.channels)) < len(self.channels):
            raise ValueError("names a channel twice in channels")
        return self

    def check(self, course):
        self._check_start(course)
        stretch = course.end - self.start(course)
        if self.longest > stretch * (1.0 + 1e-9):
            raise ValueError(
                f"longest_m = {self.longest:g} m is longer than the {max(stretch, 0.0):g} m of the run it lies on; "
                "lower it or lengthen the run"
            )

    @property
    def spacing(self):
        """Distance of nodes that this source needs [m]."""
        return self.shortest / SAMPLES_PER_WAVE

    def target(self, channel):
        """Density of a channel with its convention and scale: called with Omega, gives m^2/(rad/m), one-sided."""
        factor = self.scale**2 * (2.0 if self.sided == "two" else 1.0)
        density = SPECTRA[self.spectrum].channels[channel]
        return type(density)(factor * density.factor, density.poles, density.power)

    def series(self, channel, length):
        """Series of one channel over a length [m]."""
        return _series(self.spectrum, channel, self.shortest, self.longest, length, self.seed, self.sided, self.scale)

    def displacement(self, s, course):
        begin = self.start(course)
        value, slope = {}, {}
        for name in self.channels:
            series = self.series(name, course.track_end - begin)
            value[name], slope[name] = series.at(np.maximum(s - begin, 0.0))
        return _faded(rails(value, course.level), rails(slope, course.level), s, begin, self.fade)


@lru_cache(maxsize=8)
def _series(spectrum, channel, shortest, longest, length, seed, sided, scale):
    made = realise(SPECTRA[spectrum].channels[channel], shortest, longest, length, seed, channel, sided)
    return made._replace(value=scale * made.value, slope=scale * made.slope)


@dataclass(frozen=True, eq=False)
class Samples:
    """A measured track: positions (n,) rising [m], channels of n values, in the user's signs [m]."""

    position: np.ndarray = field(repr=False)
    channels: dict = field(repr=False)

    @cached_property
    def digest(self):
        """SHA-256 (16 digits) over positions and channels; what their file looks like does not enter."""
        digest = hashlib.sha256(np.asarray(self.position, "<f8").tobytes())
        for name in sorted(self.channels):
            digest.update(name.encode())
            digest.update(np.asarray(self.channels[name], "<f8").tobytes())
        return digest.hexdigest()[:16]

    def __eq__(self, other):
        return isinstance(other, Samples) and self.digest == other.digest

    def __hash__(self):
        return hash(self.digest)


class Measured(Stretch):
    """A measured track from a file, through whose samples a cubic spline runs.

    Without samples (results of versions that did not keep them) it says all but where the rails lie.
    """

    kind: Literal["measured"] = "measured"
    file: checks.Place
    offset: Place | None = Field(None, alias="offset_m")  # position in the file at s = 0; None: as the track counts
    vertical_positive: Literal["up", "down"] = "up"
    lateral_positive: Literal["right", "left"] = "right"
    scale: Annotated[Positive, Field(le=100.0)] = 1.0
    cross_level: Literal["found", "absolute", "relative"] = "found"  # whether the file's holds the cant
    bridge: Annotated[NotNegative, Field(le=1e3)] = Field(0.0, alias="bridge_m")  # longest dropout drawn over
    chord: ChordParts | None = Field(None, alias="chord_m")  # of its versines: before and after the point
    samples: InstanceOf[Samples] | None = Field(None, exclude=True, repr=False)

    @computed_field
    @property
    def digest(self) -> str:
        """Of the samples; empty without any."""
        return self.samples.digest if self.samples else ""

    def check(self, course):
        self._check_start(course)
        if self.samples is None:
            return
        position, offset = self.samples.position, self.position_at_start(course)
        first, last = self.start(course) + offset, course.end + offset
        if position[0] > first + 1e-6 or position[-1] < last - 1e-6:
            raise ValueError(
                f"{self.file} covers {position[0]:.10g} to {position[-1]:.10g} m, but the run needs {first:.10g} to "
                f"{last:.10g} m of it; shorten the run, or set begin_m or offset_m, the position in the file at s = 0 "
                f"({offset:.10g} m {'by the track' if self.offset is None else 'as given'})"
            )

    def position_at_start(self, course):
        """Position in the file at s = 0 [m]."""
        return course.origin if self.offset is None else self.offset

    def _at_hand(self):
        if self.samples is None:
            raise InputError(self.file, "the samples of this measured track are not at hand; run its scenario again")
        return self.samples

    @property
    def spacing(self):
        return float(np.median(np.diff(self._at_hand().position))) / PER_SAMPLE

    def displacement(self, s, course):
        from scipy.interpolate import CubicSpline  # takes half a second to load, so only where it is used

        position, at = self._at_hand().position, s + self.position_at_start(course)
        u, inside = np.clip(at, position[0], position[-1]), (at >= position[0]) & (at <= position[-1])
        value, slope = {}, {}
        for name, samples in self.samples.channels.items():
            sign = {"vertical": self.vertical_positive == "down", "alignment": self.lateral_positive == "left"}
            flip = -self.scale if sign.get(name.rpartition("_")[2], False) else self.scale
            curve = CubicSpline(position, flip * samples)
            value[name], slope[name] = curve(u), np.where(inside, curve(u, 1), 0.0)
        return _faded(rails(value, course.level), rails(slope, course.level), s, self.start(course), self.fade)


class Defect(Description):
    """A discrete defect, or several alike in a row. Positive: up, or to the right."""

    kind: Literal["defect"] = "defect"
    shape: Literal["bump", "dip", "kink", "ramp", "step"]
    direction: Literal["vertical", "lateral"] = "vertical"
    rail: Literal["right", "left", "both"] = "both"
    begin: Place = Field(alias="begin_m")
    length: Annotated[Positive, Field(ge=0.01, le=1e4)] = Field(alias="length_m")
    amplitude: Size = Field(alias="amplitude_m")
    rounding: Annotated[Positive, Field(ge=1e-3, le=10.0)] = Field(ROUNDING, alias="rounding_m")
    repeat: Annotated[int, Field(ge=1, le=10_000, strict=True)] = 1
    every: NotNegative = Field(0.0, alias="every_m")

    @model_validator(mode="after")
    def _fits_together(self):
        if self.repeat > 1 and self.every == 0.0:
            raise ValueError("repeat needs every_m, the distance from one to the next")
        if self.shape in CORNERS and self.rounding > 0.5 * self.length:
            raise ValueError(
                f"rounding_m must be at most half of length_m, {0.5 * self.length:g} m, got {self.rounding:g} m"
            )
        return self

    def check(self, course):
        first = self.begin - (0.5 * self.rounding if self.shape in CORNERS else 0.0)
        if first < course.front - 1e-9:
            raise ValueError(
                f"begins at {first:g} m, rounding included, but the vehicle starts on perfect track and its foremost "
                f"wheelset stands at {course.front:g} m: place it ahead of that"
            )
        if first > course.end:
            raise ValueError(
                f"begins at {self.begin:g} m, beyond the {course.end:g} m that the foremost wheelset reaches in the run"
            )

    @property
    def spacing(self):
        return min(self.length / PIECES, self.rounding / 8.0 if self.shape in CORNERS else math.inf, FINEST)

    def displacement(self, s, course):
        """As `rails`; s must rise."""
        value, slope = np.zeros_like(s), np.zeros_like(s)
        stays = self.amplitude if self.shape in STAYING else 0.0
        for begin in self.begin + self.every * np.arange(self.repeat):
            first, last = np.searchsorted(s, [begin - self.rounding, begin + self.length + self.rounding])
            one, rise = SHAPES[self.shape](s[first:last] - begin, self.length, self.rounding)
            value[first:last] += self.amplitude * one
            slope[first:last] += self.amplitude * rise
            value[last:] += stays
        name = "vertical" if self.direction == "vertical" else "alignment"
        names = [f"{side}_{name}" for side in ("right", "left") if self.rail in (side, "both")]
        return rails(dict.fromkeys(names, value), course.level), rails(dict.fromkeys(names, slope), course.level)


def _bump(u, length, _):
    """(1 - cos(2 pi u)) / 2."""
    angle = 2.0 * np.pi * np.clip(u / length, 0.0, 1.0)
    return 0.5 * (1.0 - np.cos(angle)), np.pi / length * np.sin(angle)


def _step(u, length, _):
    """(1 - cos(pi u)) / 2, then 1."""
    angle = np.pi * np.clip(u / length, 0.0, 1.0)
    return 0.5 * (1.0 - np.cos(angle)), 0.5 * np.pi / length * np.sin(angle)


def _rounded(curve):
    """The mean of a curve with corners over the rounding: corners become parabolas, straight parts stay.

    curve : called with u / length; gives its integral over that and its value.
    """

    def rounded(u, length, rounding):
        (after, high), (before, low) = (curve((u + way * 0.5 * rounding) / length) for way in (1.0, -1.0))
        return (after - before) * length / rounding, (high - low) / rounding

    return rounded


def _ramp(u):
    """u, then 1."""
    inside = np.clip(u, 0.0, 1.0)
    return 0.5 * inside**2 + np.maximum(u - 1.0, 0.0), inside


def _kink(u):
    """2 u up to the middle, then back: two straight lines."""
    first, second = np.clip(u, 0.0, 0.5), np.clip(u, 0.5, 1.0) - 0.5
    return first**2 + second - second**2, 2.0 * (first - second)


def _dip(u):
    """-(2 u)^2 to the middle and back: two arcs that meet in a low joint at an angle."""
    first, second = np.clip(u, 0.0, 0.5), 1.0 - np.clip(u, 0.5, 1.0)
    return -4.0 / 3.0 * (first**3 + 0.125 - second**3), -4.0 * np.where(u < 0.5, first, second) ** 2


SHAPES = {"bump": _bump, "step": _step, "ramp": _rounded(_ramp), "kink": _rounded(_kink), "dip": _rounded(_dip)}
CORNERS = ("ramp", "kink", "dip")
STAYING = ("ramp", "step")  # the rail does not come back

Source = Annotated[Spectrum | Measured | Defect, Field(discriminator="kind")]
