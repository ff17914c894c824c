"""Piecewise linear curves, continued along their first and last slopes."""

from .jit import kernel


@kernel
def read_curve(curve, x):
    """Value and slope of a CURVE at x."""
    n = curve["count"]
    xs, ys = curve["x"], curve["y"]
    i = 0
    while i < n - 2 and x > xs[i + 1]:
        i += 1
    slope = (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i])
    return ys[i] + slope * (x - xs[i]), slope


@kernel
def solve_curve(curve, weight, target):
    """x at which y(x) + weight x = target, of a CURVE that does not fall, and y there; weight >= 0.

    Without weight a flat part has no such x, or many: then the one of its ends that lies nearer to 0, or 0 within it.
    """
    n = curve["count"]
    xs, ys = curve["x"], curve["y"]
    i = 0
    while i < n - 2 and target > ys[i + 1] + weight * xs[i + 1]:
        i += 1
    slope = (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i])
    if slope + weight > 0.0:
        x = xs[i] + (target - ys[i] - weight * xs[i]) / (slope + weight)
    else:
        x = min(max(0.0, xs[i]), xs[i + 1])
    return x, ys[i] + slope * (x - xs[i])
