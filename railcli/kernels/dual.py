"""Numbers with their derivatives by the three creepages: tuples (value, by xi, by eta, by phi)."""

from .jit import kernel


@kernel
def plus(p, q):
    """p + q."""
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]


@kernel
def product(p, q):
    """p q."""
    return p[0] * q[0], p[0] * q[1] + p[1] * q[0], p[0] * q[2] + p[2] * q[0], p[0] * q[3] + p[3] * q[0]


@kernel
def multiple(c, p):
    """c p for a number c."""
    return c * p[0], c * p[1], c * p[2], c * p[3]


@kernel
def chain(value, slope, p):
    """f(p) from f and df/dp at the value of p."""
    return value, slope * p[1], slope * p[2], slope * p[3]
