"""Strip theory where the patch sticks, simplified theory where it slips (FaStrip); theory.md section 7.10.

Coordinates, scaled creepages and signs are those of `fastsim`: the ellipse is the unit circle. Tractions here are over
mu times the greatest pressure, so that the bound is sqrt(1 - x^2 - y^2). A strip y = const of half length c has, at its
leading end, an area of adhesion 2 D - c < x < c with the traction of the plane problem of rolling,

    px = k e(x) - k E(x),    py = (l + S) e(x) - l E(x),    e^2 = c^2 - x^2,  E^2 = (c - D)^2 - (x - D)^2,

k D = X, l D = Y, with X, Y the scaled creepages and S that of spin. The bound at its end, k^2 + (l + S)^2 = 1, gives D.
Behind it, and where there is no such area, an element takes the bound with the traction opposite to its own slip.

The idea is that of Sichani, Enblom and Berg (2016), Vehicle System Dynamics 54, 748-764, after Kalker (1967),
Proceedings KNAW B 70, 10-62; the slip in its own direction and the strips of large spin are ours. Range: steady rolling
of an ellipse of Hertz, like materials of steel's Poisson ratio, one coefficient of friction in the patch; any creepage
and spin. Known limit: strips do not feel each other, which shows most under spin on long ellipses.
"""

import math

from .jit import kernel
from .kalker import stiffness

POISSON = 0.28  # of the ratios of Kalker's coefficients: steel
PER_CREEP = 64.0 / (9.0 * math.pi**2)  # X, Y over ux, uy: force of all strips Kalker's, 16 / (3 pi) ux
PER_SPIN = 0.5  # S over wa: likewise
PRESSED = 4.0 / 3.0  # p0 of `fastsim` over the greatest pressure
FORCE = 1.5 / math.pi  # greatest pressure times a b over the normal force
NEWTON, CLOSE = 30, 1e-12  # iterations at most, and the share of itself by which the root then still moves
STUCK = 1e-12  # D below which a strip adheres throughout


@kernel
def levers(a, b, f22, f23, f33):
    """Kalker's linear spin moment: integral of y px over wb, and of x py over uy; 1, for it fades fast [-].

    As `creep_table.integrals` takes them. In full slip nothing of the linear moment may be left, whatever the ellipse.
    """
    return f33 * a / (2.0 * b * b * f23), 16.0 * f23 / (3.0 * math.pi * a * f22), 1.0


@kernel
def proportions(narrow):
    """What the law needs of the ellipse b / a = narrow, for steel [-].

    Returns
    -------
    soft, turn : float
        Flexibility along the rail, and that of spin, over that across.
    lever_x, lever_y, fading : float
        `levers`.
    """
    f11, f22, f23, f33 = stiffness(1.0, narrow, 1.0, POISSON)
    lever_x, lever_y, fading = levers(1.0, narrow, f22, f23, f33)
    return f22 / f11, 3.0 * math.pi / 32.0 * f22 / f23, lever_x, lever_y, fading


@kernel
def segment(x, c):
    """Integral of sqrt(c^2 - x^2) from 0 to x; x is first cut back to -c ... c."""
    if not c > 0.0:
        return 0.0
    x = min(max(x, -c), c)
    return 0.5 * (x * math.sqrt(max(c * c - x * x, 0.0)) + c * c * math.asin(x / c))


@kernel
def slipping(ax, ay, soft, bound):
    """Traction of size `bound` against which the element slips in its very direction.

    With L = (soft, 1) and a = L p_before - slip of the wheel over the rail, p (L + s) = a, s >= 0 the size of the slip.
    """
    s = max(math.sqrt(ax * ax + ay * ay) / bound - max(soft, 1.0), 0.0)
    for _ in range(NEWTON):
        px, py = ax / (soft + s), ay / (1.0 + s)
        square = px * px + py * py
        size = math.sqrt(square)
        step = square * (size / bound - 1.0) / (px * px / (soft + s) + py * py / (1.0 + s))
        s += step
        if abs(step) <= CLOSE * (1.0 + s):
            break
    return ax / (soft + s), ay / (1.0 + s)


@kernel
def adhesion(x, y, s, c):
    """How far the middle D of the area of adhesion lies ahead, and the direction (kx, ky) at its trailing end.

    For |S| < 1 the positive root of (1 - S^2) D^2 - 2 S Y D - X^2 - Y^2 = 0; for larger spin it lives on where creepage
    opposes spin, as long as the leading edge keeps the bound. D >= c: no adhesion there.

    Parameters
    ----------
    x, y, s : float
        X, Y, S of the strip [-].
    c : float
        Its half length.
    """
    square, rest = x * x + y * y, 1.0 - s * s
    inside = s * s * y * y + rest * square
    if rest > 0.0 and square <= STUCK * STUCK:
        return 0.0, 0.0, s
    if rest <= 0.0 and (s * y >= 0.0 or inside < 0.0):
        return c, 0.0, 0.0
    d = square / (math.sqrt(inside) - s * y)
    if d >= c:
        return c, 0.0, 0.0
    kx, ky = x / d, y / d + s
    if rest <= 0.0:
        shrunk = math.sqrt(1.0 - d / c)
        edge_x, edge_y = kx * (1.0 - shrunk), ky - (ky - s) * shrunk
        if edge_x * edge_x + edge_y * edge_y > 1.0:
            return c, 0.0, 0.0
    return d, kx, ky


@kernel
def rolling(ux, uy, wa, narrow, shape, strips, elements):
    """Integrals of the traction over the unit circle.

    Parameters
    ----------
    ux, uy, wa, narrow : float
        As `fastsim.rolling`.
    shape : tuple of 5 float
        `proportions` of narrow.
    strips, elements : int
        Strips across, at equal angles of the circle; elements of each.

    Returns
    -------
    fx, fy, mx, my : float
        As the first four of `fastsim.rolling`.
    """
    soft, turn, lever_x, lever_y, _ = shape
    fx, fy, mx, my = 0.0, 0.0, 0.0, 0.0
    wb, s = narrow * wa, -PER_SPIN * wa
    twist = 0.75 * math.pi * lever_x * wb  # with which the strips' moment of spin is Kalker's
    for i in range(strips):
        angle = math.pi * (i + 0.5) / strips
        y, c = -math.cos(angle), math.sin(angle)
        h = 2.0 * c / elements
        area = FORCE * h * c * math.pi / strips
        big_x, big_y = -PER_CREEP * (ux - twist * y), -PER_CREEP * uy
        d, kx, ky = adhesion(big_x, big_y, s, c)
        stick = d < c
        lag_x, lag_y = kx, ky - s
        if stick:
            left = c - d
            my -= FORCE * c * math.pi / strips * (lever_y / PER_CREEP - 1.0) * 0.5 * math.pi * big_y * left * left
        px, py, before = 0.0, 0.0, c * c * math.pi * 0.25
        for k in range(elements):
            ahead = c - k * h
            middle = ahead - 0.5 * h
            behind = segment(ahead - h, c)
            bound, before = (before - behind) / h, behind
            if stick and middle > 2.0 * d - c:
                lag = (segment(ahead - d, c - d) - segment(ahead - h - d, c - d)) / h
                px, py = kx * bound - lag_x * lag, ky * bound - lag_y * lag
                size = math.sqrt(px * px + py * py)
                if size > bound:
                    px, py = px * bound / size, py * bound / size
            else:
                way, place = (h, ahead) if k > 0 else (0.5 * h, ahead - 0.25 * h)
                way *= PRESSED
                slip_x, slip_y = (soft * ux - turn * wb * y) * way, (uy + turn * wa * place) * way
                fed = px * slip_x / soft + py * slip_y <= 0.0
                ax, ay = soft * px - slip_x, py - slip_y
                px, py = ax / soft, ay
                size = math.sqrt(px * px + py * py)
                if size > bound:
                    px, py = slipping(ax, ay, soft, bound)
                elif fed and size > 0.0:
                    px, py = px * bound / size, py * bound / size
            fx, fy, mx, my = fx + area * px, fy + area * py, mx + area * y * px, my + area * middle * py
    return fx, fy, mx, my
