"""Indices of ride, load, comfort, wear and stability from signals: pure functions of arrays.

Each has its formula and source in docs/assessment.md. Signals are sampled at a constant rate unless places are given.
"""

import math

import numpy as np
from scipy import fft, signal
from scipy.interpolate import CubicSpline

COMFORT_WINDOW = 5.0  # s
SETTLED = 10.0  # of signal beyond what is evaluated, in which filters with 0.4 Hz high-pass settle [s]
HUNTING = (1.0, 12.0)  # where the dominant frequency of sum Y is looked for [Hz]
SPECTRUM_SEGMENT = 5.0  # [s]
FINE = 8  # zero padding of the spectrum: steps of 0.025 Hz
ROUNDING = 1e-24  # spectral density over mean square of a constant that is not quite one [1/Hz]

BAND = (0.4, 100.0, 1.0 / math.sqrt(2.0))  # Hz, Hz, quality of both
WEIGHTS = {  # EN 12299: f3, f4 [Hz], Q2, step (f5 [Hz], Q3, f6 [Hz], Q4) or None, K
    "W_b": (16.0, 16.0, 0.63, (2.5, 0.8, 4.0, 0.8), 0.4),
    "W_c": (8.0, 8.0, 0.63, None, 1.0),
    "W_d": (2.0, 2.0, 0.63, None, 1.0),
}


def lowest_rate(corner):
    """Sampling rate below which a low-pass is not evaluated [Hz]: the corner needs room below half the rate."""
    return 2.5 * corner


def filtered(x, rate, low=None, high=None):
    """Signal without what lies below `low` and above `high`, not shifted in time.

    A Butterworth filter of second order runs forwards and backwards, so that its slope is 24 dB per octave; its corner
    is set so that both runs together have -3 dB at the corner asked for. The signal is continued at its ends by its
    even reflection: an odd one would add a step of twice the last value, which a high-pass turns into a peak.

    Parameters
    ----------
    x : array (n, ...)
        Samples along the first axis.
    rate : float
        Sampling rate [Hz].
    low, high : float, optional
        Corners of the high-pass and of the low-pass [Hz].
    """
    sections = [
        _butterworth(corner, rate, kind)
        for corner, kind in ((low, "highpass"), (high, "lowpass"))
        if corner is not None
    ]
    sos = np.concatenate(sections)
    longest = 3.0 * rate / (low or high)
    return signal.sosfiltfilt(sos, x, axis=0, padtype="even", padlen=int(min(len(x) - 1, longest)))


def _butterworth(corner, rate, kind):
    """Section whose gain is 2^(-1/4) at the corner: passed twice, -3 dB."""
    ratio = (math.sqrt(2.0) - 1.0) ** 0.25
    warped = math.tan(math.pi * corner / rate) * (ratio if kind == "highpass" else 1.0 / ratio)
    return signal.butter(2, math.atan(warped) / math.pi * rate, kind, fs=rate, output="sos")


def sliding_mean(s, x, window, centres):
    """Mean of x over a window of length, at places.

    Parameters
    ----------
    s : array (n,)
        Places of the samples, rising [m].
    x : array (n,)
        Taken as a cubic spline between the samples. Windows that hold a NaN give NaN.
    window : float
        [m]
    centres : array (m,)
        Middles of the windows [m]; NaN is returned where a window reaches beyond the samples.
    """
    bad = np.isnan(x)
    if bad.all():
        return np.full(np.shape(centres), np.nan)
    integral = CubicSpline(s, np.interp(s, s[~bad], x[~bad]) if bad.any() else x).antiderivative()
    left, right = centres - 0.5 * window, centres + 0.5 * window
    result = (integral(right) - integral(left)) / window
    outside = (left < s[0] - 1e-9) | (right > s[-1] + 1e-9)
    if bad.any():
        count = np.concatenate([[0], np.cumsum(bad)])
        outside |= count[np.searchsorted(s, right, "right")] > count[np.searchsorted(s, left, "left")]
    result[outside] = np.nan
    return result


def sliding_rms(s, x, window, centres):
    """Root of the mean of x squared over a window of length, at places; as `sliding_mean`."""
    return np.sqrt(np.maximum(sliding_mean(s, np.square(x), window, centres), 0.0))


def extremes(x, percent=(0.15, 99.85)):
    """Percentiles of values that are not NaN, interpolated linearly between the ordered values."""
    return np.nanpercentile(x, percent)


def root_mean_square(x):
    """Root of the mean of the squares."""
    return math.sqrt(np.mean(np.square(x)))


def prudhomme(axle_load, factor=1.0):
    """Limit of sum Y [N] for a static axle load [N]: factor (10 kN + P0 / 3)."""
    return factor * (10e3 + axle_load / 3.0)


def nadal(angle, friction):
    """Limit of Y/Q at which a wheel with a flange angle [rad] begins to climb: (tan d - mu) / (1 + mu tan d)."""
    tangent = math.tan(angle)
    return (tangent - friction) / (1.0 + friction * tangent)


def weighting(name, frequency):
    """Complex response of a filter of EN 12299 at frequencies [Hz]: W_b vertical, W_d lateral and longitudinal, W_c."""
    f3, f4, q2, step, gain = WEIGHTS[name]
    s = 2j * math.pi * np.asarray(frequency, float)
    low, high, q1 = BAND
    response = s**2 / _second(s, low, q1) * _omega(high) ** 2 / _second(s, high, q1)
    response = response * gain * (s * _omega(f4) ** 2 / _omega(f3) + _omega(f4) ** 2) / _second(s, f4, q2)
    if step:
        f5, q3, f6, q4 = step
        response = response * (_second(s, f5, q3) / _omega(f5) ** 2) / (_second(s, f6, q4) / _omega(f6) ** 2)
    return response


def _omega(frequency):
    return 2.0 * math.pi * frequency


def _second(s, frequency, quality):
    omega = _omega(frequency)
    return s**2 + omega * s / quality + omega**2


def sperling_weighting(frequency, lateral=False):
    """Magnitude of Sperling's weighting B at frequencies [Hz]; the lateral one is 1.25 times the vertical one."""
    f2 = np.square(np.asarray(frequency, float))
    above = 1.911 * f2 + (0.25 * f2) ** 2
    below = (1.0 - 0.277 * f2) ** 2 + f2 * (1.563 - 0.0368 * f2) ** 2
    return 0.588 * (1.25 if lateral else 1.0) * np.sqrt(above / below)


def weighted(x, rate, response):
    """Signal through a filter given by its frequency response.

    The signal is continued at both ends by its even reflection, at most 10 s long.

    Parameters
    ----------
    x : array (n,)
    rate : float
        [Hz]
    response : callable
        Response at an array of frequencies [Hz].
    """
    pad = min(len(x) - 1, int(SETTLED * rate))
    padded = np.pad(x, pad, mode="reflect")
    frequency = fft.rfftfreq(padded.size, 1.0 / rate)
    result = fft.irfft(fft.rfft(padded) * response(frequency), padded.size)
    return result[pad : pad + len(x)]


def window_rms(x, rate, window=COMFORT_WINDOW):
    """Root mean square of x in windows that follow each other; what is left at the end is not used."""
    size = round(window * rate)
    count = len(x) // size
    return np.sqrt(np.square(x[: count * size]).reshape(count, size).mean(axis=1))


def mean_comfort(longitudinal, lateral, vertical):
    """N_MV of EN 12299 from the weighted rms of each window [m/s^2]: 6 sqrt(sum of the squared 95th percentiles)."""
    return 6.0 * math.sqrt(sum(np.percentile(x, 95.0) ** 2 for x in (longitudinal, lateral, vertical)))


def sperling(rms):
    """Sperling's Wz from the rms of the weighted acceleration [m/s^2]: 4.42 rms^0.3."""
    return 4.42 * rms**0.3


def t_gamma(creep_x, creep_t, xi, eta):
    """Wear number [N = J/m]: magnitudes of creep force times creepage, lengthwise and across; spin does not enter.

    Parameters
    ----------
    creep_x, creep_t : array
        Creep forces along and across the rail [N].
    xi, eta : array
        Creepages; NaN where there is no patch.
    """
    return np.nan_to_num(np.abs(creep_x * xi) + np.abs(creep_t * eta))


def dominant_frequency(x, rate, band=HUNTING):
    """Frequency of the highest peak of the spectrum within a band [Hz]; NaN when it has none there.

    Welch's method, Hann windows of 5 s, padded with zeros to steps of 0.025 Hz.
    """
    size = min(len(x), round(SPECTRUM_SEGMENT * rate))
    frequency, density = signal.welch(x, rate, nperseg=size, nfft=FINE * size, detrend="linear")
    coarse = density[::FINE]  # without the ripples that padding adds
    inside = np.flatnonzero((frequency[::FINE] >= band[0]) & (frequency[::FINE] <= band[1]))
    if not inside.size or coarse[inside].max() < ROUNDING * np.square(x).mean():
        return math.nan
    peak = inside[np.argmax(coarse[inside])]
    if coarse[peak] <= max(coarse[peak - 1], coarse[min(peak + 1, coarse.size - 1)]):
        return math.nan
    around = slice((peak - 1) * FINE, (peak + 1) * FINE + 1)
    return float(frequency[around][np.argmax(density[around])])


def derivative(x, rate):
    """Derivative of samples (n, ...) at a rate [Hz] by the cubic spline through them."""
    time = np.arange(len(x)) / rate
    return CubicSpline(time, x)(time, 1)


def floor_acceleration(acceleration, rotation, omega, turning, arms, gravity):
    """What accelerometers fixed to points of a body show, in the body's axes, less their reading at rest.

    With the specific force f of the centre in the body's axes, f + dw/dt x r + w x (w x r), and gravity added to z.

    Parameters
    ----------
    acceleration : array (n, 3)
        Recorded at the centre, axes of its track frame: specific force plus gravity along z [m/s^2].
    rotation : array (n, 3)
        Roll, pitch, yaw against the track frame, in the order yaw, roll, pitch [rad].
    omega : array (n, 3)
        Angular velocity, body axes [rad/s].
    turning : array (n, 3)
        Angular acceleration, body axes [rad/s^2].
    arms : array (m, 3)
        From the centre to the points, body axes [m].
    gravity : float
        [m/s^2]

    Returns
    -------
    array (m, n, 3)
    """
    weight = np.array([0.0, 0.0, gravity])
    roll, pitch, yaw = rotation.T
    x, y, z = (acceleration - weight).T
    x, y = np.cos(yaw) * x + np.sin(yaw) * y, np.cos(yaw) * y - np.sin(yaw) * x
    y, z = np.cos(roll) * y + np.sin(roll) * z, np.cos(roll) * z - np.sin(roll) * y
    x, z = np.cos(pitch) * x - np.sin(pitch) * z, np.cos(pitch) * z + np.sin(pitch) * x
    centre = np.stack([x, y, z], axis=1) + weight
    return np.stack([centre + np.cross(turning, arm) + np.cross(omega, np.cross(omega, arm)) for arm in arms])
