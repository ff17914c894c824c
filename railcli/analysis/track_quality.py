"""What a recording of track geometry looks like beside the ranges that EN 13848 asks recording cars to cover."""

from typing import NamedTuple

import numpy as np

from railcli.model.irregularity import rails
from railcli.model.spectra import BANDS

NOT_CONSULTED = (
    "Ranges of EN 13848-1 as commonly quoted; the standard itself could not be consulted. They say what a car must be "
    "able to record, not what a track may have."
)
RANGES = {  # of values [m]; of twist [-]; by quantity and band
    ("level", "D1"): (-0.050, 0.050),
    ("level", "D2"): (-0.100, 0.100),
    ("alignment", "D1"): (-0.050, 0.050),
    ("alignment", "D2"): (-0.100, 0.100),
    ("gauge", ""): (-0.025, 0.045),
    ("cross-level", ""): (-0.225, 0.225),
    ("twist", "3 m"): (-0.015, 0.015),
}
LARGEST_STEP = 0.5  # between samples [m]
TWIST_BASE = 3.0  # [m]
QUIET, ROUGH = 0.05e-3, 8e-3  # rms in D1 that no track has: a wrong unit, or no measurement [m]


class Quality(NamedTuple):
    """One quantity in one band of wavelengths.

    Attributes
    ----------
    quantity, side, band : str
        `side` and `band` may be empty.
    rms, lowest, highest : float
        About the mean where there is a band [m]; of twist [-].
    at : float
        Position of the largest magnitude [m].
    low, high : float
        The range.
    words : str
        What is wrong; empty where nothing is.
    """

    quantity: str
    side: str
    band: str
    rms: float
    lowest: float
    highest: float
    at: float
    low: float
    high: float
    words: str


def judged(position, channels):
    """Rows of Quality of channels (dict of name to array (n,), signs and names of `model.irregularity`).

    position : array (n,)
        At equal distances [m].
    """
    step = float(position[-1] - position[0]) / (position.size - 1)
    moved = rails(channels, 1.0)
    rows = []
    for quantity, direction, sign in (("level", 1, -1.0), ("alignment", 0, 1.0)):
        for side, rail in (("left", 1), ("right", 0)):
            values = sign * moved[rail, direction]
            if not values.any():
                continue
            for band in ("D1", "D2"):
                shortest, longest = BANDS[band]
                if longest <= 0.5 * (position[-1] - position[0]) and shortest >= 2.0 * step:
                    rows.append(_row(quantity, side, band, position, _banded(values, step, shortest, longest)))
    wide = moved[0, 0] - moved[1, 0]
    if wide.any():
        rows.append(_row("gauge", "", "", position, wide))
    level = moved[0, 1] - moved[1, 1]
    if level.any():
        rows.append(_row("cross-level", "", "", position, level))
        count = max(1, round(TWIST_BASE / step))
        if count < position.size:
            twist = (level[count:] - level[:-count]) / (count * step)
            rows.append(_row("twist", "", "3 m", position[count:], twist))
    return rows


def _banded(values, step, shortest, longest):
    """Waves of a band: Butterworth of second order, run both ways, half the power left at its ends."""
    from scipy.signal import butter, sosfiltfilt

    low, high = step / longest, step / shortest
    moved = (np.sqrt(2.0) - 1.0) ** 0.25  # of the corners, so that two runs have -3 dB there
    corners = [2.0 * low * moved, min(2.0 * high / moved, 0.99)]
    return sosfiltfilt(butter(2, corners, "bandpass", output="sos"), values - values.mean())


def _row(quantity, side, band, position, values):
    low, high = RANGES[quantity, band]
    worst = int(np.argmax(np.abs(values)))
    rms = float(np.sqrt(np.mean(values**2)))
    words = "" if low <= values.min() and values.max() <= high else "beyond the range"
    if band == "D1" and not words:
        words = "quieter than any track: check the unit" if rms < QUIET else ""
        words = "rougher than any track in service: check the unit" if rms > ROUGH else words
    extremes = float(values.min()), float(values.max())
    return Quality(quantity, side, band, rms, *extremes, float(position[worst]), low, high, words)
