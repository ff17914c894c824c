"""Indices of ride, load, comfort, wear and stability: signals whose answer is known in closed form."""

import math

import numpy as np
import pytest
import tolerances as tol
from naive import high_gain, low_gain
from scipy.stats import norm

from railcli.analysis import indices

RATE = 100.0
G = 9.81


def sine(frequency, seconds=60.0, rate=RATE, amplitude=1.0, phase=0.0):
    time = np.arange(round(seconds * rate)) / rate
    return amplitude * np.sin(2.0 * np.pi * frequency * time + phase)


def complex_amplitude(x, frequency, rate=RATE):
    """Of the middle third, which holds a whole number of periods of the frequencies used here."""
    third = len(x) // 3
    time = np.arange(third, 2 * third) / rate
    return 2j * np.mean(x[third : 2 * third] * np.exp(-2j * np.pi * frequency * time))


@pytest.mark.parametrize("frequency", [0.5, 5.0, 15.0, 20.0, 30.0, 40.0])
@pytest.mark.parametrize("rate", [100.0, 400.0])
def test_low_pass_of_a_sine(frequency, rate):
    """The gain in closed form, -3 dB at the corner, and no shift in time."""
    x = indices.filtered(sine(frequency, rate=rate), rate, high=20.0)
    amplitude = complex_amplitude(x, frequency, rate)
    assert amplitude.real == pytest.approx(low_gain(frequency, 20.0, rate), abs=tol.FILTER_GAIN)
    assert abs(amplitude.imag) < tol.FILTER_GAIN
    if frequency == 20.0:
        assert amplitude.real == pytest.approx(math.sqrt(0.5), abs=tol.FILTER_GAIN)


@pytest.mark.parametrize("frequency", [0.2, 0.4, 1.0, 5.0, 10.0, 20.0])
def test_band_pass_of_a_sine(frequency):
    x = indices.filtered(sine(frequency, 120.0), RATE, 0.4, 10.0)
    expected = high_gain(frequency, 0.4) * low_gain(frequency, 10.0)
    assert complex_amplitude(x, frequency).real == pytest.approx(expected, abs=tol.FILTER_GAIN)


def test_slope_is_24_decibels_an_octave():
    """At a high rate, where tan is straight: an octave from 100 to 200 Hz, corner at 20 Hz."""
    fall = [abs(complex_amplitude(indices.filtered(sine(f, 6.0, 1e4), 1e4, high=20.0), f, 1e4)) for f in (100.0, 200.0)]
    assert 20.0 * math.log10(fall[0] / fall[1]) == pytest.approx(24.1, abs=0.1)


def test_filters_of_a_constant():
    constant = np.full(500, 7.0)
    np.testing.assert_allclose(indices.filtered(constant, RATE, high=20.0), 7.0, rtol=tol.FILTER_EXACT)
    np.testing.assert_allclose(indices.filtered(constant, RATE, 0.4, 10.0), 0.0, atol=tol.FILTER_EXACT * 7.0)


def test_low_pass_of_a_step_is_symmetric_about_it():
    """No shift: the filtered step is odd about its middle, and reaches both levels."""
    step = np.repeat([0.0, 1.0], 500)
    x = indices.filtered(step, RATE, high=20.0)
    np.testing.assert_allclose(x + x[::-1], 1.0, atol=tol.FILTER_GAIN)
    assert x[100] == pytest.approx(0.0, abs=tol.FILTER_GAIN) and x[-100] == pytest.approx(1.0, abs=tol.FILTER_GAIN)


@pytest.mark.parametrize("wavelength", [2.0, 3.0, 8.0, 50.0])
def test_sliding_mean_of_a_sine(wavelength):
    """A window of length w passes sin(pi w / L) / (pi w / L) of wavelength L; at w = L nothing."""
    s = np.arange(0.0, 200.0, wavelength / 40.0)
    centres = np.arange(10.0, 190.0, 0.5)
    found = indices.sliding_mean(s, np.sin(2.0 * np.pi * s / wavelength), 2.0, centres)
    expected = np.sinc(2.0 / wavelength) * np.sin(2.0 * np.pi * centres / wavelength)
    np.testing.assert_allclose(found, expected, atol=tol.SLIDING_MEAN)


def test_sliding_mean_follows_the_distance_not_the_samples():
    """Of a straight line: its value in the middle, however uneven the samples are."""
    s = np.cumsum(np.random.default_rng(5).uniform(0.01, 0.9, 300))
    centres = np.arange(s[0] + 1.0, s[-1] - 1.0, 0.5)
    np.testing.assert_allclose(indices.sliding_mean(s, 3.0 - 2.0 * s, 2.0, centres), 3.0 - 2.0 * centres, rtol=1e-9)


def test_sliding_mean_stays_within_the_samples_and_out_of_gaps():
    s = np.arange(0.0, 20.0, 0.25)
    x = np.ones(s.size)
    x[40] = np.nan  # at 10 m
    found = indices.sliding_mean(s, x, 2.0, np.array([0.5, 1.0, 8.9, 9.1, 10.0, 10.9, 11.1, 18.75, 19.0]))
    assert np.isnan(found).tolist() == [True, False, False, True, True, True, False, False, True]
    np.testing.assert_allclose(found[~np.isnan(found)], 1.0)


def test_sliding_rms_of_a_sine():
    """Over whole wavelengths amplitude / sqrt 2; over others the integral of sin^2."""
    s = np.arange(0.0, 400.0, 0.25)
    centres = np.arange(60.0, 340.0, 10.0)
    for wavelength in (20.0, 30.0):
        k = 2.0 * np.pi / wavelength
        found = indices.sliding_rms(s, 5.0 * np.sin(k * s), 100.0, centres)
        square = 0.5 - np.cos(2.0 * k * centres) * np.sin(100.0 * k) / (200.0 * k)
        np.testing.assert_allclose(found, 5.0 * np.sqrt(square), rtol=tol.SLIDING_MEAN)


def test_percentiles_of_known_distributions():
    uniform = np.linspace(-1.0, 1.0, 2001)
    np.testing.assert_allclose(indices.extremes(uniform), [-0.997, 0.997], rtol=1e-12)
    quantiles = norm.ppf((np.arange(100_000) + 0.5) / 100_000)
    np.testing.assert_allclose(indices.extremes(quantiles), [-2.96774, 2.96774], rtol=tol.BETWEEN_RANKS)
    with_gap = np.concatenate([uniform, [np.nan] * 10])
    np.testing.assert_allclose(indices.extremes(with_gap), [-0.997, 0.997], rtol=1e-12)


FREQUENCIES = [0.5, 1, 2, 4, 5, 8, 10, 16, 20, 31.5, 80]


@pytest.mark.parametrize(
    "name, magnitudes",
    [
        ("W_b", [0.335, 0.391, 0.437, 0.822, 0.957, 1.056, 1.048, 0.918, 0.798, 0.531, 0.174]),
        ("W_d", [0.853, 1.011, 0.890, 0.512, 0.409, 0.253, 0.202, 0.125, 0.100, 0.063, 0.021]),
    ],
)
def test_comfort_filters_have_the_magnitudes_of_their_formula(name, magnitudes):
    """Computed independently from the coefficients of EN 12299, three decimals."""
    np.testing.assert_allclose(np.abs(indices.weighting(name, FREQUENCIES)), magnitudes, atol=tol.PRINTED_THREE)


def test_sperling_weighting_has_the_magnitudes_of_its_formula():
    vertical = indices.sperling_weighting([1.0, 2.0, 5.0, 10.0])
    np.testing.assert_allclose(vertical, [0.489, 0.610, 0.813, 0.493], atol=tol.PRINTED_THREE)
    np.testing.assert_allclose(
        indices.sperling_weighting([1.0, 7.0], True), 1.25 * indices.sperling_weighting([1.0, 7.0])
    )
    assert indices.sperling_weighting(0.0) == 0.0


@pytest.mark.parametrize("name, frequency", [("W_b", 8.0), ("W_b", 0.5), ("W_d", 1.0), ("W_c", 20.0), ("W_b", 40.0)])
def test_weighted_sine(name, frequency):
    """Magnitude and phase of the analogue filter, at 40 of 50 Hz too: no bilinear warping."""
    x = indices.weighted(sine(frequency), RATE, lambda f: indices.weighting(name, f))
    expected = complex(indices.weighting(name, frequency))
    assert complex_amplitude(x, frequency) == pytest.approx(expected, abs=tol.WEIGHTED_START)


def test_windows_follow_each_other():
    """Sines of amplitudes 1, 2, 3, each for 5 s with whole periods, and a rest that is too short for a window."""
    x = np.concatenate([a * sine(2.0, 5.0) for a in (1.0, 2.0, 3.0)] + [np.ones(499)])
    np.testing.assert_allclose(indices.window_rms(x, RATE), np.array([1.0, 2.0, 3.0]) / math.sqrt(2.0), rtol=1e-12)


def test_mean_comfort_of_stationary_sines():
    """Every window alike: 6 sqrt(sum of (amplitude x weight)^2 / 2)."""
    amplitude, frequency, names = (0.1, 0.3, 0.5), (1.0, 1.6, 6.0), ("W_d", "W_d", "W_b")
    values, expected = [], 0.0
    for a, f, name in zip(amplitude, frequency, names, strict=True):
        response = lambda frequencies, name=name: indices.weighting(name, frequencies)  # noqa: E731
        weighted = indices.weighted(sine(f, 320.0, amplitude=a), RATE, response)[1000:31000]
        values.append(indices.window_rms(weighted, RATE))
        expected += (a * abs(complex(indices.weighting(name, f)))) ** 2 / 2.0
    assert [value.size for value in values] == [60] * 3
    assert indices.mean_comfort(*values) == pytest.approx(6.0 * math.sqrt(expected), rel=tol.WEIGHTED_START)


def test_mean_comfort_takes_the_95th_percentile():
    """Of 0 to 100 hundredths it is 0.95; a direction at rest adds nothing."""
    ramp = np.random.default_rng(3).permutation(np.arange(101) / 100.0)
    rest = np.zeros(101)
    assert indices.mean_comfort(rest, ramp, rest) == pytest.approx(6.0 * 0.95)
    assert indices.mean_comfort(ramp, ramp, ramp) == pytest.approx(6.0 * 0.95 * math.sqrt(3.0))


@pytest.mark.parametrize("frequency, amplitude", [(1.0, 0.2), (2.0, 0.5), (6.0, 1.0)])
def test_sperling_of_a_sine_is_the_classical_formula(frequency, amplitude):
    """Wz = (a^3 B^3)^(1/10) with the amplitude a in cm/s^2 (Garg and Dukkipati 1984, chapter 3)."""
    x = indices.weighted(sine(frequency, 100.0, amplitude=amplitude), RATE, indices.sperling_weighting)[2000:8000]
    b = float(indices.sperling_weighting(frequency))
    classical = ((100.0 * amplitude) ** 3 * b**3) ** 0.1
    assert indices.sperling(indices.root_mean_square(x)) == pytest.approx(classical, rel=tol.SPERLING_FACTOR)


def test_wear_number_of_a_known_creep_state():
    """3 kN at 2 per mille and 4 kN at 1 per mille: 6 + 4 N, whatever their signs; no patch, no wear."""
    force_x, force_t = np.array([[3e3, -3e3, 0.0]]), np.array([[-4e3, 4e3, 0.0]])
    xi, eta = np.array([[-2e-3, 2e-3, np.nan]]), np.array([[1e-3, -1e-3, np.nan]])
    np.testing.assert_allclose(indices.t_gamma(force_x, force_t, xi, eta), [[10.0, 10.0, 0.0]], rtol=1e-12)


def test_wear_number_of_full_slip_is_friction_times_slip():
    """Force against the slip, mu N large: T gamma = mu N |slip| for slip along either axis."""
    slip = np.array([5e-3, 0.0]), np.array([0.0, 5e-3])
    forces = [-0.3 * 50e3 * np.sign(part) for part in slip]
    np.testing.assert_allclose(indices.t_gamma(*forces, *slip), 0.3 * 50e3 * 5e-3)


def test_nadal_is_the_balance_of_a_sliding_flange():
    """A normal force N and friction mu N up the wheel's flank, which slides down: Y and Q of their components."""
    angle, friction = math.radians(70.0), 0.36
    y = math.sin(angle) - friction * math.cos(angle)
    q = math.cos(angle) + friction * math.sin(angle)
    assert indices.nadal(angle, friction) == pytest.approx(y / q, rel=1e-12)
    assert indices.nadal(angle, friction) == pytest.approx(1.20, abs=5e-3)


def test_prudhomme():
    assert indices.prudhomme(112.5e3) == pytest.approx(47.5e3)
    assert indices.prudhomme(225e3, 0.85) == pytest.approx(0.85 * 85e3)


@pytest.mark.parametrize("frequency", [1.5, 4.37, 9.1])
def test_dominant_frequency_of_a_sine_in_noise(frequency):
    noise = np.random.default_rng(7).normal(size=6000)
    x = sine(frequency, amplitude=2.0) + noise + np.linspace(0.0, 50.0, 6000)
    assert indices.dominant_frequency(x, RATE) == pytest.approx(frequency, abs=tol.FREQUENCY)


def test_signals_without_a_peak_have_no_dominant_frequency():
    """A constant, a slow decay, and one too short for the band."""
    assert math.isnan(indices.dominant_frequency(np.ones(1000), RATE))
    assert math.isnan(indices.dominant_frequency(np.exp(-np.arange(2000) / 1000.0), RATE))


def turned(roll, pitch, yaw):
    """Rz(yaw) Rx(roll) Ry(pitch)."""
    c, s = np.cos, np.sin
    rz = np.array([[c(yaw), -s(yaw), 0.0], [s(yaw), c(yaw), 0.0], [0.0, 0.0, 1.0]])
    rx = np.array([[1.0, 0.0, 0.0], [0.0, c(roll), -s(roll)], [0.0, s(roll), c(roll)]])
    ry = np.array([[c(pitch), 0.0, s(pitch)], [0.0, 1.0, 0.0], [-s(pitch), 0.0, c(pitch)]])
    return rz @ rx @ ry


def test_floor_acceleration_of_a_body_that_swings():
    """Against second differences of the point's path, turned into the body's axes, gravity included."""
    arm, step = np.array([9.5, 0.4, 0.6]), 1e-3
    time = np.arange(0.0, 4.0, 0.01)

    def angles(t):
        return (
            0.02 * np.sin(2 * np.pi * 1.0 * t),
            0.01 * np.cos(2 * np.pi * 0.8 * t),
            0.03 * np.sin(2 * np.pi * 0.6 * t),
        )

    def centre(t):
        return np.array([20.0 * t, 0.05 * np.sin(2 * np.pi * 0.7 * t), 0.01 * np.cos(2 * np.pi * 1.1 * t)])

    def path(t):
        return centre(t) + turned(*angles(t)) @ arm

    def second(f, t):
        """Of fourth order."""
        values = [f(t + k * step) for k in (-2, -1, 0, 1, 2)]
        return np.tensordot([-1.0, 16.0, -30.0, 16.0, -1.0], values, 1) / (12.0 * step**2)

    def omega(t):
        rate = (turned(*angles(t + 1e-5)) - turned(*angles(t - 1e-5))) / 2e-5
        skew = turned(*angles(t)).T @ rate
        return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])

    weight = np.array([0.0, 0.0, G])
    expected = np.array([turned(*angles(t)).T @ (second(path, t) - weight) + weight for t in time])
    found = indices.floor_acceleration(
        np.array([second(centre, t) for t in time]),  # at the centre: force less weight, plus gravity along z
        np.array([angles(t) for t in time]),
        np.array([omega(t) for t in time]),
        indices.derivative(np.array([omega(t) for t in time]), 100.0),
        np.array([arm]),
        G,
    )[0]
    inside = slice(10, -10)  # a spline's ends are less exact
    np.testing.assert_allclose(found[inside], expected[inside], atol=tol.FLOOR_SPLINE)


def test_floor_of_a_body_that_leans_shows_gravity():
    """At rest, rolled right side down by 0.1 rad: the floor's accelerometer shows g sin to the left of it."""
    rest = np.zeros((5, 3))
    found = indices.floor_acceleration(
        rest, np.tile([0.1, 0.0, 0.0], (5, 1)), rest, rest, np.array([[9.5, 0.0, 0.6]]), G
    )[0]
    np.testing.assert_allclose(found[:, 1], -G * math.sin(0.1))
    np.testing.assert_allclose(found[:, 2], G * (1.0 - math.cos(0.1)))
