"""A creep law as a table that covers every ellipse and every creepage; theory.md sections 7.6 and 7.10.

With h = sqrt(ux^2 + uy^2), w = sqrt(wa^2 + wb^2), s = h + w (fastsim.py) the axes of the table are

    1 - 1 / sqrt(1 + s),    w / s,    uy / (|ux| + |uy|),    wa / (wa + wb) = a / (a + b),

all of them bounded, so that nothing lies outside. The root is there because the part of a spinning patch that adheres
shrinks as 1 / sqrt(s). Mirror images give the rest: ux and spin are taken positive. Tabulated is H of

    F = F0 / (1 + s / BENT) + (1 - 1 / sqrt(1 + s)) H,

with F0 the linear force: the first part alone is Kalker's for small creepages, and opposes a large slip without spin
with the full friction. For FaStrip's moments the first factor is squared, so that in full slip none of F0 is left.
"""

import math

import numpy as np

from . import fastrip, fastsim
from .jit import builder, kernel
from .layout import Creep

BENT = 3.0 * math.pi / 16.0  # s at which the linear force without spin reaches the friction limit
SIZES, SPINS, WAYS, SHAPES = 21, 17, 17, 9  # points of the axes, in the order above
NODES = SIZES * SPINS * WAYS * SHAPES
CHANNELS = 4  # px, py, y px, x py of `rolling`
GRID = 15  # of the coarser of two FASTSIM solutions
STRIPS, ELEMENTS = 16, 24  # of a FaStrip solution
NOTHING, ENDLESS = 1e-100, 1e6  # s below which all is linear; s at the far end of the first axis
SLENDER = 1e-6  # a / b and b / a at the ends of the last axis
LINEAR = (16.0 / (3.0 * math.pi), 0.5)  # px by ux and py by uy, py by wa
LEVERS = (16.0 / (15.0 * math.pi), 0.5, 0.0)  # FASTSIM's y px by wb, x py by uy; 1 if they fade as the square


@kernel
def linear_integrals(ux, uy, wa, wb, levers):
    """The integrals of `rolling` without a bound on the traction; levers: y px by wb, x py by uy."""
    return -LINEAR[0] * ux, -LINEAR[0] * uy - LINEAR[1] * wa, levers[0] * wb, levers[1] * uy


@kernel
def solution(law, ux, uy, wa, narrow, shape):
    """The integrals of `rolling` by the law itself; shape: `fastrip.proportions`.

    FASTSIM's error goes as the length of an element, so twice the solution on 2 x 2 times as many elements less that
    on one is free of it: of 15 and 30 as near to the limit as 100 x 100 elements, at a ninth of the work.
    """
    if law == Creep.FASTRIP:
        return fastrip.rolling(ux, uy, wa, narrow, shape, STRIPS, ELEMENTS)
    coarse, fine = fastsim.rolling(ux, uy, wa, narrow, GRID), fastsim.rolling(ux, uy, wa, narrow, 2 * GRID)
    return 2.0 * fine[0] - coarse[0], 2.0 * fine[1] - coarse[1], 2.0 * fine[2] - coarse[2], 2.0 * fine[3] - coarse[3]


@builder
def tabulate(law):
    """The table of TABLE or FASTRIP of `Creep`, shape (NODES, CHANNELS), first axis fastest."""
    table = np.zeros((NODES, CHANNELS))
    for k in range(SHAPES):
        long = min(max(k / (SHAPES - 1.0), SLENDER), 1.0 - SLENDER)
        narrow = (1.0 - long) / long
        shape = fastrip.proportions(narrow)
        levers = (shape[2], shape[3], shape[4]) if law == Creep.FASTRIP else LEVERS
        for j in range(WAYS):
            across = 2.0 * j / (WAYS - 1.0) - 1.0
            along = 1.0 - abs(across)
            size = math.sqrt(along * along + across * across)
            for i in range(SPINS):
                spin = i / (SPINS - 1.0)
                for m in range(1, SIZES):
                    part = m / (SIZES - 1.0)
                    s = min(1.0 / max(1.0 - part, 1e-6) ** 2 - 1.0, ENDLESS)
                    ux, uy = s * (1.0 - spin) * along / size, s * (1.0 - spin) * across / size
                    wa = s * spin / math.sqrt(1.0 + narrow * narrow)
                    found = solution(law, ux, uy, wa, narrow, shape)
                    linear = linear_integrals(ux, uy, wa, narrow * wa, levers)
                    for c in range(CHANNELS):
                        row = ((k * WAYS + j) * SPINS + i) * SIZES + m
                        grow = BENT / (s + BENT)
                        if c > 1:
                            grow *= 1.0 + levers[2] * (grow - 1.0)
                        table[row, c] = (found[c] - linear[c] * grow) / part
    return table


@kernel
def cell(place, points):
    """First point of the cell and the share of it, for a place in 0 ... 1."""
    at = place * (points - 1)
    low = int(min(max(at, 0.0), points - 2.0))
    return low, at - low


@kernel
def line(table, row, step, c, t):
    """Channel c between rows row and row + step, at share t."""
    low = table[row, c]
    return low + t * (table[row + step, c] - low)


@kernel
def integrals(table, ux, uy, wa, narrow, levers):
    """As `fastsim.rolling`, from the table; levers as `linear_integrals`; NaN in, NaN out."""
    along, across, wb = abs(ux), uy, narrow * wa
    turned = -1.0 if wa < 0.0 else 1.0
    across, wa, wb = turned * across, turned * wa, turned * wb
    tilt = math.sqrt(1.0 + narrow * narrow)
    h, w = math.sqrt(along * along + across * across), wa * tilt
    s = h + w
    linear = linear_integrals(along, across, wa, wb, levers)
    if not (s > NOTHING and s < math.inf):
        bad = s - s if s == s else s
        return (
            bad, bad, bad, bad, -LINEAR[0] + bad, bad, bad, bad, bad, -LINEAR[0] + bad, bad, levers[1] + bad,
            bad, -LINEAR[1] + bad, narrow * levers[0] + bad, bad,
        )  # fmt: skip
    per, left, bend = 1.0 / s, 1.0 / math.sqrt(1.0 + s), 1.0 / (s + BENT)
    part, part_s = 1.0 - left, 0.5 * left * left * left
    both = along + abs(across)
    share = 1.0 / both if both > NOTHING else 0.0
    way = across * share
    m, tm = cell(part, SIZES)
    i, ti = cell(w * per, SPINS)
    j, tj = cell(0.5 * (1.0 + way), WAYS)
    k, tk = cell(1.0 / (1.0 + narrow), SHAPES)
    base = ((k * WAYS + j) * SPINS + i) * SIZES + m
    next_way, next_shape = SPINS * SIZES, WAYS * SPINS * SIZES
    # derivatives of the first three axes, in points, by along, across and wa
    h_u, h_v = (along / h, across / h) if h > 0.0 else (0.0, 0.0)
    spin_h, spin_w = -(SPINS - 1) * w * per * per, (SPINS - 1) * h * per * per
    way_u, way_v = -0.5 * (WAYS - 1) * way * share, 0.5 * (WAYS - 1) * along * share * share
    grow, grow_s = BENT * bend, -BENT * bend * bend
    fx = channel(table, base, next_way, next_shape, tm, ti, tj, tk, 0)
    fy = channel(table, base, next_way, next_shape, tm, ti, tj, tk, 1)
    mx = channel(table, base, next_way, next_shape, tm, ti, tj, tk, 2)
    my = channel(table, base, next_way, next_shape, tm, ti, tj, tk, 3)
    scales = (part, part_s, grow, grow_s, h_u, h_v, tilt, spin_h, spin_w, way_u, way_v)
    slow = 1.0 + levers[2] * (grow - 1.0)
    moments = (
        part, part_s, grow * slow, grow_s * (slow + levers[2] * grow), h_u, h_v, tilt, spin_h, spin_w, way_u, way_v,
    )  # fmt: skip
    fx0, fxu, fxv, fxw = assembled(fx, linear[0], -LINEAR[0], 0.0, 0.0, scales)
    fy0, fyu, fyv, fyw = assembled(fy, linear[1], 0.0, -LINEAR[0], -LINEAR[1], scales)
    mx0, mxu, mxv, mxw = assembled(mx, linear[2], 0.0, 0.0, narrow * levers[0], moments)
    my0, myu, myv, myw = assembled(my, linear[3], 0.0, levers[1], 0.0, moments)
    mirrored = -1.0 if ux < 0.0 else 1.0
    return (
        mirrored * fx0, turned * fy0, turned * mx0, turned * my0,
        fxu, mirrored * turned * fyu, mirrored * turned * mxu, mirrored * turned * myu,
        mirrored * turned * fxv, fyv, mxv, myv,
        mirrored * turned * fxw, fyw, mxw, myw,
    )  # fmt: skip


@kernel
def channel(table, base, next_way, next_shape, tm, ti, tj, tk, c):
    """Value of one channel of the table, and its derivatives by the first three axes, per point."""
    a0 = line(table, base, next_shape, c, tk)
    a1 = line(table, base + 1, next_shape, c, tk)
    a2 = line(table, base + SIZES, next_shape, c, tk)
    a3 = line(table, base + SIZES + 1, next_shape, c, tk)
    a4 = line(table, base + next_way, next_shape, c, tk)
    a5 = line(table, base + next_way + 1, next_shape, c, tk)
    a6 = line(table, base + next_way + SIZES, next_shape, c, tk)
    a7 = line(table, base + next_way + SIZES + 1, next_shape, c, tk)
    b0, b1, b2, b3 = a0 + tj * (a4 - a0), a1 + tj * (a5 - a1), a2 + tj * (a6 - a2), a3 + tj * (a7 - a3)
    c0, c1 = b0 + ti * (b2 - b0), b1 + ti * (b3 - b1)
    low = (a4 - a0) + ti * ((a6 - a2) - (a4 - a0))
    high = (a5 - a1) + ti * ((a7 - a3) - (a5 - a1))
    return c0 + tm * (c1 - c0), c1 - c0, (b2 - b0) + tm * ((b3 - b1) - (b2 - b0)), low + tm * (high - low)


@kernel
def assembled(found, linear, linear_u, linear_v, linear_w, scales):
    """One integral and its derivatives by along, across and wa from the table's channel and the linear one."""
    part, part_s, grow, grow_s, h_u, h_v, tilt, spin_h, spin_w, way_u, way_v = scales
    value, by_size, by_spin, by_way = found
    by_s = linear * grow_s + (value + part * by_size * (SIZES - 1)) * part_s
    by_h, by_w = by_s + part * by_spin * spin_h, by_s + part * by_spin * spin_w
    return (
        linear * grow + value * part,
        linear_u * grow + by_h * h_u + part * by_way * way_u,
        linear_v * grow + by_h * h_v + part * by_way * way_v,
        linear_w * grow + by_w * tilt,
    )
