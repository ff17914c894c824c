"""Power spectra of track irregularity, and series that realise them.

Densities S(Omega) over the angular wavenumber Omega [rad/m], in m^2/(rad/m). All are of the form

    S = K Omega^(2 m) / product of (Omega^2 + p_i),   p_i different,

whose integral is closed by partial fractions. Channels: vertical and alignment are those of the centre line (mean of
both rails), cross-level is the height of one rail over the other at 1.5 m, gauge the change of their distance.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

CHANNELS = ("vertical", "alignment", "cross_level", "gauge")
LEVEL_BASE = 1.5  # distance over which the spectra's cross-level is measured [m]
SIDES = {"one": 1.0, "two": 2.0}  # of the axis of wavenumbers that carry the variance, if S is given for one of them
BANDS = {"D1": (3.0, 25.0), "D2": (25.0, 70.0), "D3": (70.0, 150.0)}  # EN 13848-1, wavelengths [m]
SAMPLES_PER_WAVE = 16  # of the shortest wave, in a realisation


@dataclass(frozen=True)
class Density:
    """S(Omega) = factor Omega^(2 power) / product of (Omega^2 + pole), one-sided [m^2/(rad/m)]."""

    factor: float
    poles: tuple  # squares of wavenumbers, different from each other [rad^2/m^2]
    power: int = 0

    def __call__(self, omega):
        """S at angular wavenumbers [rad/m]."""
        square = np.asarray(omega, float) ** 2
        return self.factor * square**self.power / np.prod([square + pole for pole in self.poles], axis=0)

    def variance(self, low, high):
        """Integral of S from `low` to `high` [rad/m], both > 0, in closed form [m^2]."""
        total = 0.0
        for i, pole in enumerate(self.poles):
            others = np.prod([other - pole for k, other in enumerate(self.poles) if k != i])
            root = math.sqrt(pole)
            upper, lower = (
                np.arctan(np.asarray(x, float) / root) / root if root else -1.0 / np.asarray(x, float)
                for x in (high, low)
            )
            total = total + (-pole) ** self.power / others * (upper - lower)
        return self.factor * total

    def band_rms(self, shortest, longest):
        """RMS of the wavelengths from `shortest` to `longest` [m]."""
        return math.sqrt(self.variance(2.0 * math.pi / longest, 2.0 * math.pi / shortest))


class Family(NamedTuple):
    """The spectra of one kind of track."""

    channels: dict  # name of the channel -> Density
    summary: str
    source: str


def _b176(vertical, alignment, gauge):
    """ERRI B176: A_v, A_a, A_g [m rad]; 0.75 m is half the distance of the rails, S_c that of their angle."""
    c, r, s, half = 0.8246**2, 0.0206**2, 0.4380**2, 0.75
    angle = vertical / half**2
    return {
        "vertical": Density(vertical * c, (r, c)),
        "alignment": Density(alignment * c, (r, c)),
        "cross_level": Density(angle * LEVEL_BASE**2 * c, (r, c, s), 1),
        "gauge": Density(gauge * c, (r, c, s), 1),
    }


def _fra(vertical, alignment, s):
    """FRA: A_v, A_a [cm^2 rad/m], cut-off of gauge and cross-level [rad/m]; k = 0.25."""
    k, c = 0.25e-4, 0.8245**2
    both = Density(4.0 * k * vertical * c, (c, s**2))
    return {
        "vertical": Density(k * vertical * c, (0.0, c)),
        "alignment": Density(k * alignment * c, (0.0, c)),
        "cross_level": both,
        "gauge": both,
    }


_ERRI = "ERRI B176 RP1 (1989), as usually coded: one-sided; coefficients in field literature, not the report itself"
_FRA = "FRA/AAR classes, Hamid et al. (1982) with k = 0.25; as published with public codes, not the report itself"
SPECTRA = {
    "b176-low": Family(_b176(4.032e-7, 2.119e-7, 5.32e-8), "ERRI B176, low disturbance", _ERRI),
    "b176-high": Family(_b176(1.080e-6, 6.125e-7, 1.032e-7), "ERRI B176, high disturbance", _ERRI),
    "fra-1": Family(_fra(1.2107, 3.3634, 0.6046), "FRA class 1", _FRA),
    "fra-2": Family(_fra(1.0181, 1.2107, 0.9308), "FRA class 2", _FRA),
    "fra-3": Family(_fra(0.6816, 0.4128, 0.8520), "FRA class 3", _FRA),
    "fra-4": Family(_fra(0.5376, 0.3027, 1.1312), "FRA class 4", _FRA),
    "fra-5": Family(_fra(0.2095, 0.0762, 0.8209), "FRA class 5", _FRA),
    "fra-6": Family(_fra(0.0339, 0.0339, 0.4380), "FRA class 6", _FRA),
}


class Series(NamedTuple):
    """A realisation over one period: values and slopes at equal distances from 0."""

    spacing: float  # [m]
    value: np.ndarray  # [m]
    slope: np.ndarray  # [-]

    def at(self, place):
        """Values and slopes at places (n,) [m], periodic."""
        from scipy.interpolate import CubicHermiteSpline  # takes half a second to load, so only where it is used

        count = self.value.size
        knots = self.spacing * np.arange(count + 1)
        curve = CubicHermiteSpline(knots, np.append(self.value, self.value[0]), np.append(self.slope, self.slope[0]))
        place = np.mod(place, knots[-1])
        return curve(place), curve(place, 1)


def realise(density, shortest, longest, length, seed, channel, sides="one", spacing=None):
    """Waves of random phase whose variance in the band is that of the density.

    Every line carries the integral of S over its share of the band, so the variance of a period is the closed
    integral. Lines lie 1 / period apart, the period being the least multiple of `longest` that holds `length`.

    Parameters
    ----------
    density : Density
    shortest, longest, length : float
        Band of wavelengths, and length wanted [m].
    seed : int
    channel : str
        One of CHANNELS; each draws phases of its own.
    sides : "one" or "two"
    spacing : float, optional
        Largest distance of samples [m].

    Returns
    -------
    Series
    """
    from scipy.fft import irfft, next_fast_len

    period = longest * math.ceil(length / longest - 1e-9)
    spacing = spacing or shortest / SAMPLES_PER_WAVE
    count = next_fast_len(math.ceil(period / spacing - 1e-9), real=True)
    line = np.arange(round(period / longest), math.ceil(period / shortest - 1e-9) + 1)
    low = np.maximum((line - 0.5) / period, 1.0 / longest)
    high = np.minimum((line + 0.5) / period, 1.0 / shortest)
    line, low, high = (array[high > low] for array in (line, low, high))
    variance = SIDES[sides] * density.variance(2.0 * np.pi * low, 2.0 * np.pi * high)
    phase = np.random.default_rng([seed, CHANNELS.index(channel)]).uniform(0.0, 2.0 * np.pi, line.size)
    wave = np.zeros(count // 2 + 1, complex)
    wave[line] = 0.5 * count * np.sqrt(2.0 * variance) * np.exp(1j * phase)
    turning = 2j * np.pi / period * np.arange(wave.size)
    return Series(period / count, irfft(wave, count), irfft(turning * wave, count))
