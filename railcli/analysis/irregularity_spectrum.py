"""What an irregularity is made of: RMS per channel and band, and spectra by Welch's method, beside their targets."""

from dataclasses import dataclass

import numpy as np

from railcli.errors import InputError
from railcli.model import rails
from railcli.model.irregularity import Spectrum, channels
from railcli.model.spectra import BANDS, CHANNELS, LEVEL_BASE

SEGMENTS = 6  # at least, in Welch's estimate, half overlapped
LONGEST_PER_SEGMENT = 4.0  # wavelengths of the longest wave in a segment, where the track is long enough
LONGEST_TRACK = 1e5  # [m]
MOST_VALUES = 2_000_000
USUAL_SPACING = 0.25  # [m]
TAPERED = 0.1  # share of the track that is faded out in a periodogram
EDGE = 1e-9  # by which a wavenumber may lie beyond a band for rounding
ZERO = 1e-9  # a channel that stays below has nothing to show [m]


@dataclass(frozen=True)
class Record:
    """Channels of a track at equal distances, in the user's signs.

    Attributes
    ----------
    title : str
    position : array (n,)
        Rising by equal steps [m].
    channels : dict of str to array (n,)
        CHANNELS [m].
    targets : list of Target
    settled : float
        Position from which on irregularity has its full size [m].
    """

    title: str
    position: np.ndarray
    channels: dict
    targets: list
    settled: float = 0.0

    @property
    def spacing(self):
        return float(self.position[-1] - self.position[0]) / (self.position.size - 1)

    def target(self, name, omega):
        """One-sided density of a channel at Omega [rad/m], summed over the targets, each within its band."""
        total = np.zeros_like(omega)
        for one in self.targets:
            if name in one.channels:
                low, high = 2 * np.pi / one.longest, 2 * np.pi / one.shortest
                inside = (omega >= low * (1.0 - EDGE)) & (omega <= high * (1.0 + EDGE))
                total += np.where(inside, one.channels[name](omega), 0.0)
        return total

    def target_rms(self, name, shortest, longest):
        """Its RMS over a band of wavelengths, in closed form [m]; None where no target has the channel."""
        variance, known = 0.0, False
        for one in self.targets:
            if name in one.channels:
                known = True
                low, high = max(1.0 / longest, 1.0 / one.longest), min(1.0 / shortest, 1.0 / one.shortest)
                if high > low:
                    variance += one.channels[name].variance(2 * np.pi * low, 2 * np.pi * high)
        return float(np.sqrt(variance)) if known else None


@dataclass(frozen=True)
class Target:
    """Spectra that a track should have: channel -> Density, within a band of wavelengths [m]."""

    name: str
    channels: dict
    shortest: float
    longest: float


@dataclass(frozen=True)
class Band:
    """RMS of one channel over a band of wavelengths [m]; `scatter`: standard error that a Gaussian track would have."""

    channel: str
    name: str
    shortest: float
    longest: float
    rms: float
    target: float | None
    scatter: float


def evenly(position, samples):
    """Positions at equal distances and channels there, by a cubic spline where the samples lie unevenly."""
    step = np.diff(position)
    if np.allclose(step, step[0], rtol=1e-6):
        return position, samples
    from scipy.interpolate import CubicSpline  # takes half a second to load, so only where it is used

    even = np.linspace(position[0], position[-1], position.size)
    return even, {name: CubicSpline(position, values)(even) for name, values in samples.items()}


def check_band(where, shortest, longest, spacing, length):
    """Refuse a band that samples at a spacing over a length cannot hold."""
    if shortest < 2.0 * spacing * (1.0 - 1e-9):
        raise InputError(
            where,
            f"waves of {shortest:g} m need samples every {0.5 * shortest:g} m at least, these lie {spacing:.3g} m "
            "apart: lower the spacing or raise the shortest wavelength",
        )
    if longest > length * (1.0 + 1e-9):
        raise InputError(
            where,
            f"waves of {longest:g} m do not fit into {length:g} m: lower the longest wavelength or give a longer track",
        )


def made(source, length, spacing):
    """A realisation of a Spectrum over a length [m], at full size from its beginning.

    Raises
    ------
    InputError
        The length or the spacing cannot be, or cannot hold the band.
    """
    if not 0.0 < length <= LONGEST_TRACK:
        raise InputError("--length", f"must be > 0 and at most {LONGEST_TRACK:g} m, got {length:g}")
    _check_spacing(length, spacing)
    check_band("--shortest, --longest", source.shortest, source.longest, spacing, length)
    position = spacing * np.arange(round(length / spacing) + 1)
    found = {name: source.series(name, length).at(position)[0] for name in CHANNELS}
    return Record(f"{source.spectrum}, seed {source.seed}", position, found, [target_of(source)])


def of_scenario(case, spacing=None):
    """What displaces the rails of a scenario over its run, with the targets of its spectra.

    spacing : distance of values [m]; without it one that holds all sources.

    Raises
    ------
    InputError
        It has no irregularity, or the spacing cannot hold a spectrum's band.
    """
    if not case.irregularity:
        raise InputError(case.name, "has no [[irregularity]]: its rails lie in their ideal place")
    about = rails.course(case)
    if spacing is None:
        finest = min(source.spacing for source in case.irregularity)
        spacing = max(min(USUAL_SPACING, 4.0 * finest), about.end / MOST_VALUES)
    _check_spacing(about.end, spacing)
    position = spacing * np.arange(int(about.end / spacing + 1e-9) + 1)
    moved, _ = rails.displacement(case, position)
    stretches = [source for source in case.irregularity if source.kind != "defect"]
    sources = [source for source in stretches if isinstance(source, Spectrum)]
    for source in sources:
        check_band(case.name, source.shortest, source.longest, spacing, about.end)
    settled = max([source.start(about) + source.fade for source in stretches], default=0.0)
    return Record(case.name, position, channels(moved, about.level), [target_of(one) for one in sources], settled)


def target_of(source):
    """Target of a Spectrum."""
    sided = "S one-sided" if source.sided == "one" else "S two-sided, so counted twice"
    densities = {name: source.target(name) for name in source.channels}
    words = f"{source.spectrum} ({sided}; cross-level at {LEVEL_BASE:g} m)"
    return Target(words, densities, source.shortest, source.longest)


def _check_spacing(length, spacing):
    if not spacing > 0.0 or length / spacing > MOST_VALUES:
        raise InputError("--spacing", f"must be > 0 and give at most {MOST_VALUES:,} values, got {spacing:g} m")


def settled_part(record):
    """Positions and channels where irregularity has its full size."""
    inside = record.position >= record.settled
    return record.position[inside], {name: values[inside] for name, values in record.channels.items()}


def bands(record):
    """RMS of every channel that is not zero: of all waves, and in the bands of EN 13848 that the track holds.

    All waves: about the straight line through the values. Bands: integral of the periodogram, ends tapered. Bands
    without a target's share are left out where there are targets.

    Returns
    -------
    list of Band
    """
    from scipy.signal import detrend, periodogram

    position, values_of = settled_part(record)
    length = float(position[-1] - position[0])
    rows = []
    for name in CHANNELS:
        values = values_of[name]
        if np.abs(values).max() < ZERO:
            continue
        f, density = periodogram(values, 1.0 / record.spacing, ("tukey", TAPERED), detrend="linear")
        whole = (length, 2.0 * record.spacing)
        if record.targets:
            whole = max(one.longest for one in record.targets), min(one.shortest for one in record.targets)
        for band, (shortest, longest) in {"all": whole[::-1], **BANDS}.items():
            if band != "all" and (longest > length or shortest < 2.0 * record.spacing):
                continue
            target = record.target_rms(name, shortest, longest)
            if target == 0.0:
                continue
            inside = (f >= 1.0 / longest) & (f <= 1.0 / shortest)
            rms = np.std(detrend(values)) if band == "all" else np.sqrt(density[inside].sum() * f[1])
            power = density[inside] if target is None else record.target(name, 2 * np.pi * f[inside])
            scatter = 0.5 * np.sqrt(np.sum(power**2)) / np.sum(power)
            rows.append(Band(name, band, shortest, longest, float(rms), target, float(scatter)))
    return rows


def spectra(record):
    """Welch's estimates, channel -> (frequency [1/m], one-sided density [m^2 m]), of the channels that are not zero."""
    from scipy.signal import welch

    _, values_of = settled_part(record)
    size = next(iter(values_of.values())).size
    longest = max([one.longest for one in record.targets], default=BANDS["D2"][1])
    segment = min(round(LONGEST_PER_SEGMENT * longest / record.spacing), 2 * size // (SEGMENTS + 1))
    found = {}
    for name, values in values_of.items():
        if np.abs(values).max() >= ZERO:
            f, density = welch(values, 1.0 / record.spacing, "hann", max(segment, 8), detrend="linear")
            found[name] = (f[1:], density[1:])
    return found
