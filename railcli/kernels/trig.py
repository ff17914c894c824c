"""Sine and cosine of the small angles of a vehicle, in line: a call of the library costs several times as much."""

from math import asin, cos, sin

from .jit import kernel

SMALL_SINE = 0.06  # likewise for the inverse [-]
SMALL = 0.25  # below it the series' first neglected terms are under half a unit of the last digit [rad]


@kernel
def sine_cosine(x):
    """Sine and cosine of x [rad], to rounding."""
    if abs(x) < SMALL:
        u = x * x
        sine = 1.0 / 362880.0 - u * (1.0 / 39916800.0)
        sine = 1.0 - u * (1.0 / 6.0 - u * (1.0 / 120.0 - u * (1.0 / 5040.0 - u * sine)))
        cosine = 1.0 / 40320.0 - u * (1.0 / 3628800.0 - u * (1.0 / 479001600.0))
        cosine = 1.0 - u * (0.5 - u * (1.0 / 24.0 - u * (1.0 / 720.0 - u * cosine)))
        return x * sine, cosine
    return sin(x), cos(x)


@kernel
def arc_sine(x):
    """Angle whose sine is x [rad], to rounding."""
    if abs(x) < SMALL_SINE:
        u = x * x
        return x + x * u * (
            1.0 / 6.0 + u * (3.0 / 40.0 + u * (15.0 / 336.0 + u * (105.0 / 3456.0 + u * (945.0 / 42240.0))))
        )
    return asin(x)
