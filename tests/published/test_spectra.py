"""Power spectra of track irregularity against published values, and realisations against their spectrum."""

import numpy as np
import pytest
import tolerances as tol
from scipy.integrate import quad
from scipy.signal import welch

from railcli.model.spectra import CHANNELS, SPECTRA, realise

# RMS of bands of wavelengths [mm], S one-sided: coefficients of ERRI B176 as usually coded, integrated by hand
B176 = [
    ("b176-low", "vertical", 3.0, 25.0, 0.984),
    ("b176-low", "vertical", 25.0, 70.0, 1.651),
    ("b176-low", "vertical", 3.0, 150.0, 2.863),
    ("b176-high", "vertical", 3.0, 25.0, 1.611),
    ("b176-high", "vertical", 25.0, 70.0, 2.702),
    ("b176-low", "alignment", 3.0, 25.0, 0.714),
    ("b176-low", "alignment", 25.0, 70.0, 1.197),
    ("b176-high", "alignment", 3.0, 25.0, 1.213),
    ("b176-high", "alignment", 25.0, 70.0, 2.035),
]
# OpenRailVehicleDynamics, commit 4706df9e, docs on track irregularity spectra: f from 0.024 to 0.333 1/m [mm]
AAR = [("fra-5", "alignment", 3.06242), ("fra-5", "vertical", 5.07784), ("fra-6", "alignment", 2.04262)]
ALL = [(name, channel) for name in SPECTRA for channel in CHANNELS]


@pytest.mark.parametrize("name, channel, shortest, longest, rms", B176)
def test_b176(name, channel, shortest, longest, rms):
    found = 1e3 * SPECTRA[name].channels[channel].band_rms(shortest, longest)
    assert found == pytest.approx(rms, abs=tol.PRINTED_RMS)


@pytest.mark.parametrize("name, channel, rms", AAR)
def test_aar(name, channel, rms):
    found = 1e3 * SPECTRA[name].channels[channel].band_rms(1.0 / 0.333, 1.0 / 0.024)
    assert found == pytest.approx(rms, abs=tol.PRINTED_AAR)


@pytest.mark.parametrize("name, channel", ALL)
def test_closed_variance(name, channel):
    """Partial fractions against adaptive quadrature of the density."""
    density = SPECTRA[name].channels[channel]
    for low, high in ((0.04, 0.25), (0.25, 2.1), (0.04, 60.0)):
        slow = quad(density, low, high, epsabs=0.0, epsrel=1e-11, limit=500)[0]
        assert density.variance(low, high) == pytest.approx(slow, rel=tol.PARTIAL_FRACTIONS)


@pytest.mark.parametrize("name, channel", [("b176-low", "vertical"), ("b176-high", "gauge"), ("fra-4", "cross_level")])
@pytest.mark.parametrize("sides, factor", [("one", 1.0), ("two", 2.0)])
def test_realised_rms(name, channel, sides, factor):
    """A period's mean square is the closed variance of the band, for any seed, whatever the line spacing."""
    density = SPECTRA[name].channels[channel]
    for seed, length in ((1, 400.0), (2, 1234.5), (3, 70.0)):
        series = realise(density, 3.0, 70.0, length, seed, channel, sides)
        wanted = factor * density.variance(2 * np.pi / 70.0, 2 * np.pi / 3.0)
        assert np.mean(series.value**2) == pytest.approx(wanted, rel=tol.PARSEVAL)
        assert np.gradient(series.value, series.spacing)[2:-2] == pytest.approx(
            series.slope[2:-2], abs=tol.WAVE_SLOPE * np.abs(series.slope).max()
        )


def test_rms_over_seeds():
    """Of stretches much shorter than the period the mean square scatters about the variance; its mean does not."""
    density = SPECTRA["b176-low"].channels["vertical"]
    found = []
    for seed in range(60):
        series = realise(density, 3.0, 25.0, 1000.0, seed, "vertical")
        found.append(np.mean(series.value[: series.value.size // 10] ** 2))
    wanted = density.variance(2 * np.pi / 25.0, 2 * np.pi / 3.0)
    error = np.std(found) / np.sqrt(len(found))
    assert np.mean(found) == pytest.approx(wanted, abs=4.0 * error)
    assert error < 0.1 * wanted


@pytest.mark.parametrize("name", ["b176-low", "fra-5"])
def test_welch_spectrum(name):
    """Welch's estimate lies about the target, within what chi squared with two degrees of freedom per segment allows.

    Lines of fixed size scatter less than a Gaussian track would.
    """
    channel, shortest, longest = "vertical", 3.0, 70.0
    density = SPECTRA[name].channels[channel]
    series = realise(density, shortest, longest, 20_000.0, 7, channel)
    size = round(500.0 / series.spacing)
    f, found = welch(series.value, 1.0 / series.spacing, "hann", size, detrend=False)
    inside = (f > 2.0 / longest) & (f < 0.8 / shortest)
    ratio = found[inside] / (2 * np.pi * density(2 * np.pi * f[inside]))
    segments = 2 * 20_000.0 / 500.0 - 1
    scatter = np.sqrt(11.0 / 9.0 / segments)  # Hann, half overlapped (Welch 1967)
    assert ratio.mean() == pytest.approx(1.0, abs=4.0 * scatter / np.sqrt(ratio.size / 2.0))
    assert ratio.std() < scatter and np.abs(ratio - 1.0).max() < 4.0 * scatter


def test_channels_are_independent():
    """No two channels of one seed share their phases: correlations are those of chance."""
    series = [
        realise(SPECTRA["fra-6"].channels[channel], 3.0, 70.0, 20_000.0, 5, channel).value for channel in CHANNELS
    ]
    correlation = np.corrcoef(series) - np.eye(4)
    assert np.abs(correlation).max() < tol.CHANCE


def test_seed_decides():
    """The same seed gives the same track to the last bit, another one another track."""
    density = SPECTRA["b176-low"].channels["gauge"]
    one, two, other = (realise(density, 3.0, 70.0, 500.0, seed, "gauge").value for seed in (4, 4, 5))
    assert np.array_equal(one, two)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.5
