"""Braked weight percentage to deceleration and braking distance: the conversion model of ETCS.

SUBSET-026-3 (version 4), appendix A.3.7 to A.3.9; valid for 0 to 200 km/h, 30 to 250 %, trains up to 900 m (passenger)
or 1500 m (freight).
"""

from typing import NamedTuple

import numpy as np

KMH = 1.0 / 3.6
ENDS = np.array([100.0, 120.0, 150.0, 180.0, np.inf])  # speed up to which a row of STEPS holds [km/h]
STEPS = np.array(  # a3, a2, a1, a0 of deceleration over percentage [m/s^2]
    [
        (-6.30e-7, 6.10e-5, 4.72e-3, 0.0663),
        (2.73e-7, -4.54e-6, 5.14e-3, 0.1300),
        (5.58e-8, -6.76e-6, 5.81e-3, 0.0479),
        (3.00e-8, -3.85e-6, 5.52e-3, 0.0480),
        (3.23e-9, 1.66e-6, 5.06e-3, 0.0559),
    ]
)
BUILD_UP = {  # emergency: a, b, c of the equivalent build-up time a + b x + c x^2 [s], x = length / 100 m; least length
    "passenger": (2.30, 0.0, 0.17, 400.0),
    "freight P": (2.30, 0.0, 0.17, 400.0),
    "freight P, long": (-0.40, 1.60, 0.03, 900.0),
    "freight G": (12.0, 0.0, 0.05, 0.0),
}
RANGE = (30.0, 250.0)  # [%]


class Deceleration(NamedTuple):
    """A deceleration in steps over the speed."""

    upto: np.ndarray  # speeds at which the steps end [m/s]; the last is infinite
    value: np.ndarray  # [m/s^2]

    def distance(self, speed, target=0.0):
        """Braking distance from one speed to another, without build-up [m]."""
        low = np.concatenate([[0.0], self.upto[:-1]])
        start, end = np.maximum(low, target), np.minimum(self.upto, speed)
        return float(np.sum(np.where(end > start, (end**2 - start**2) / (2.0 * self.value), 0.0)))


def limit_speed(percentage):
    """Speed up to which the deceleration is constant [m/s]."""
    return 16.85 * percentage**0.428 * KMH


def deceleration(percentage):
    """Emergency deceleration of a braked weight percentage, as Deceleration."""
    first = limit_speed(percentage)
    upto, value = [first], [0.0075 * percentage + 0.076]
    powers = percentage ** np.array([3, 2, 1, 0])
    for end, row in zip(ENDS * KMH, STEPS, strict=True):
        if end > first:
            upto.append(end)
            value.append(float(row @ powers))
    return Deceleration(np.array(upto), np.array(value))


def build_up_time(train, length):
    """Equivalent build-up time of an emergency brake [s].

    Parameters
    ----------
    train : str
        Key of BUILD_UP.
    length : float
        Of the train [m].
    """
    a, b, c, least = BUILD_UP[train]
    x = max(length, least) / 100.0
    return a + b * x + c * x * x
