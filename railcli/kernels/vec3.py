"""Vectors of three and 3 x 3 matrices; vectors are tuples, matrices arrays whose columns are axes."""

from .jit import kernel


@kernel
def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def add(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel
def sub(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def scale(k, a):
    """k a."""
    return k * a[0], k * a[1], k * a[2]


@kernel
def get(a):
    """Tuple of the first three entries of an array."""
    return a[0], a[1], a[2]


@kernel
def put(a, v):
    """Write a tuple into the first three entries of an array."""
    a[0] = v[0]
    a[1] = v[1]
    a[2] = v[2]


@kernel
def accumulate(a, v):
    """Add a tuple to the first three entries of an array."""
    a[0] += v[0]
    a[1] += v[1]
    a[2] += v[2]


@kernel
def outward(m, v):
    """m v: components along the axes in m become components in the axes that m is written in."""
    return (
        m[0, 0] * v[0] + m[0, 1] * v[1] + m[0, 2] * v[2],
        m[1, 0] * v[0] + m[1, 1] * v[1] + m[1, 2] * v[2],
        m[2, 0] * v[0] + m[2, 1] * v[1] + m[2, 2] * v[2],
    )


@kernel
def inward(m, v):
    """m^T v: the inverse of `outward` for a rotation m."""
    return (
        m[0, 0] * v[0] + m[1, 0] * v[1] + m[2, 0] * v[2],
        m[0, 1] * v[0] + m[1, 1] * v[1] + m[2, 1] * v[2],
        m[0, 2] * v[0] + m[1, 2] * v[1] + m[2, 2] * v[2],
    )
