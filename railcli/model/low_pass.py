"""The low-pass through which every step of a run reaches its assessment: symmetric, of finite length."""

from math import ceil
from typing import NamedTuple

import numpy as np

INTERVAL = 2e-3  # longest interval of the low-passed stream [s]
PASSED = 100.0  # what lies below passes, and nothing folds there: the comfort filters end at it [Hz]
ATTENUATION = 62.0  # of what would fold below PASSED [dB]


class LowPass(NamedTuple):
    """Coefficients for one step.

    Attributes
    ----------
    stride : int
        Steps from one filtered row to the next.
    taps : array (2 half + 1,)
        Symmetric, their sum is 1.
    """

    stride: int
    taps: np.ndarray


def low_pass(step):
    """The LowPass of a step [s]: a sinc cut at half the rate of the rows, in a Kaiser window.

    The transition ends where frequencies begin to fold below PASSED, at the rate less PASSED. Length and shape of the
    window are Kaiser's formulas for the attenuation (Oppenheim and Schafer, Discrete-Time Signal Processing, 7.5.3).
    So short a window keeps them nearly: below PASSED all passes within 0.2 %, and of what folds there stays at most
    0.12 %. Where a row is one step, nothing is left to filter.
    """
    stride = max(1, int(INTERVAL / step * (1.0 + 1e-9)))
    if stride == 1:
        return LowPass(1, np.ones(1))
    transition = 2.0 * np.pi * (1.0 / (stride * step) - 2.0 * PASSED) * step  # [rad per step]
    half = ceil(0.5 * (ATTENUATION - 7.95) / (2.285 * transition))
    at = np.arange(-half, half + 1)
    taps = np.sinc(at / stride) * np.kaiser(at.size, 0.1102 * (ATTENUATION - 8.7))
    return LowPass(stride, taps / taps.sum())
