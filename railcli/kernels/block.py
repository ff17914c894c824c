"""Six equations of one body as 2 x 2 blocks of 3 x 3 matrices; matrices are tuples of rows."""

from .jit import kernel
from .vec3 import add, cross, dot, scale, sub


@kernel
def block(a, i, r, c, factor):
    """factor times the 3 x 3 block of a[i] whose first entry is (r, c)."""
    return (
        scale(factor, (a[i, r, c], a[i, r, c + 1], a[i, r, c + 2])),
        scale(factor, (a[i, r + 1, c], a[i, r + 1, c + 1], a[i, r + 1, c + 2])),
        scale(factor, (a[i, r + 2, c], a[i, r + 2, c + 1], a[i, r + 2, c + 2])),
    )


@kernel
def raise_diagonal(m, d):
    """m + diag(d)."""
    return (
        (m[0][0] + d[0], m[0][1], m[0][2]),
        (m[1][0], m[1][1] + d[1], m[1][2]),
        (m[2][0], m[2][1], m[2][2] + d[2]),
    )


@kernel
def times(m, v):
    """m v."""
    return dot(m[0], v), dot(m[1], v), dot(m[2], v)


@kernel
def combine(v, m):
    """v^T m: the sum of the rows of m, v their weights."""
    return add(scale(v[0], m[0]), add(scale(v[1], m[1]), scale(v[2], m[2])))


@kernel
def inverse(m):
    """m^-1 by cofactors."""
    a, b, c = cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])
    k = 1.0 / dot(m[0], a)
    return (k * a[0], k * b[0], k * c[0]), (k * a[1], k * b[1], k * c[1]), (k * a[2], k * b[2], k * c[2])


@kernel
def solve(p, q, r, s, f, g):
    """u, w with p u + q w = f and r u + s w = g, by elimination of u; p and what is left of s must be regular."""
    inner = inverse(p)
    e0, e1, e2 = combine(r[0], inner), combine(r[1], inner), combine(r[2], inner)
    left = sub(s[0], combine(e0, q)), sub(s[1], combine(e1, q)), sub(s[2], combine(e2, q))
    w = times(inverse(left), sub(g, times((e0, e1, e2), f)))
    return times(inner, sub(f, times(q, w))), w
