"""Normal force of a wheel on a rail as the gradient of one elastic energy (theory.md section 6.7).

The rail's surface is divided into strips along the track. Each bears a line load q >= 0 [N/m] of semi-elliptic pressure
along the track, of half length a. With h the normal overlap of the undeformed bodies at the middle of a strip, D its
width, A half the curvature of the gap along the track, c the cosine between the normals of two strips,

    U = max over q, chi of  sum D q (h - A a^2 / 4) - 1/2 sum sum D D q q c Gamma(t) / (pi E* a),   E* = E/(2(1-nu^2)),
    a^2 = K q / (pi/2 E* A chi) + D^2 / 4,

where a and t = distance / a of two strips take the mean of their a^2, and K averages over neighbours. Only h depends on
the pose of the wheel: whatever is approximate here costs accuracy, never energy.
"""

import math

import numpy as np

from .jit import kernel

STRIP = np.dtype(
    [
        ("y", "f8"),  # middle: lateral position and height in the axes of the inclined rail [m]
        ("z", "f8"),
        ("normal_y", "f8"),  # of the rail there, into the rail [-]
        ("normal_z", "f8"),
        ("arc", "f8"),  # along the rail [m]
        ("width", "f8"),  # [m]
        ("bend", "f8"),  # A [1/m]
        ("hat", "i8"),  # node of chi before it
        ("share", "f8"),  # of the node after it [-]
    ],
    align=True,
)

PULL = (  # Gamma(t) (1 + t^2)^(1/2) as a polynomial of PULL_RATE y - PULL_SHIFT, y^8 = t^2 / (1 + t^2), y 0.18 ... 1
    2.79169089, -2.85664438, 1.27832942, -0.325268324, 0.212099891, -0.245211887, 0.188649921, 0.0646705713,
    -0.124890078, -0.0816033121, 0.0981876782,
)  # fmt: skip
PULL_RATE, PULL_SHIFT = 2.0 / 0.82, 1.18 / 0.82
LANES = 8  # strips that one instruction treats
MARGIN = 3  # strips beside those that bear which may come to bear in one iteration
SEED = 0.07  # line load over E* and overlap with which a patch begins
AROUND = 2e-3  # a patch does not bear where the overlap is less than a share of the greatest one so near [m]
DEPTH_LEFT = 0.35
SWEEPS = 6  # of one iteration
OVER = 1.3  # relaxation
DAMPING = 0.3  # share of a strip's own change of length that an iteration takes into account
CHI = 1.5  # to begin with
CHI_RANGE = (0.3, 100.0)
STIFF = 0.05  # share by which a node of chi resists to move against its neighbours
MOST_STEP = math.log(2.0)  # of ln chi in one iteration


def bent(pull):
    """Coefficients of (Gamma + t Gamma') (1 + t^2)^(3/2): F + y F' / 4 where F(y) is Gamma (1 + t^2)^(1/2)."""
    polynomial = np.polynomial.polynomial
    return polynomial.polyadd(pull, 0.25 * polynomial.polymul(polynomial.polyder(pull), (PULL_SHIFT, 1.0)))


F, H = tuple(np.float32(PULL)), tuple(np.float32(bent(PULL)))
RATE, SHIFT, ONE, HALF, NOTHING = (np.float32(each) for each in (PULL_RATE, PULL_SHIFT, 1.0, 0.5, 0.0))
A2, NORMAL_Y, NORMAL_Z, LOAD, REST, PINCH, OWN, INVERSE, LEFT, LANE_ROWS = range(10)  # rows of `lanes`


@kernel
def influence(apart, half_square):
    """Gamma / a and (Gamma + t Gamma') / a^3 of two strips, in single precision.

    apart : geometric mean distance of their points [m].  half_square : mean of their a^2 [m^2].
    """
    inverse = ONE / (half_square + apart * apart)
    root = math.sqrt(inverse)
    x = RATE * math.sqrt(math.sqrt(apart * root)) - SHIFT
    f = F[5] + x * (F[6] + x * (F[7] + x * (F[8] + x * (F[9] + x * F[10]))))
    f = F[0] + x * (F[1] + x * (F[2] + x * (F[3] + x * (F[4] + x * f))))
    h = H[5] + x * (H[6] + x * (H[7] + x * (H[8] + x * (H[9] + x * H[10]))))
    h = H[0] + x * (H[1] + x * (H[2] + x * (H[3] + x * (H[4] + x * h))))
    return f * root, h * root * inverse


@kernel
def influences(n, stride, scale, lanes, matrix, apart):
    """Fill the matrix [m/N] of n strips, and what their loads press elsewhere (REST [m], PINCH [1/m]).

    One vector instruction treats LANES strips: no branches, sums run over rows.
    """
    a2, normal_y, normal_z, rest, pinch = lanes[A2], lanes[NORMAL_Y], lanes[NORMAL_Z], lanes[REST], lanes[PINCH]
    for j in range(stride):
        rest[j] = NOTHING
        pinch[j] = NOTHING
    for k in range(n):
        half, ny, nz = HALF * a2[k], np.float32(scale * normal_y[k]), np.float32(scale * normal_z[k])
        load = lanes[LOAD, k]
        row, away = matrix[k * stride : (k + 1) * stride], apart[k * stride : (k + 1) * stride]
        for j in range(stride):
            value, slope = influence(away[j], half + HALF * a2[j])
            lean = ny * normal_y[j] + nz * normal_z[j]
            row[j] = lean * value
            rest[j] += load * (lean * value)
            pinch[j] += load * (lean * slope)


@kernel
def press(strip, apart, h, first, last, elastic, tolerance, most, q, chi, work, lanes, matrix):
    """Line loads of the strips first ... last - 1: the maximum of the energy.

    Every iteration holds the lengths a, takes the loads of greatest energy at those, and with them the next chi. The
    energy it returns has what the last change of loads and chi adds to second order; to that order it is exact.

    Parameters
    ----------
    strip : STRIP array (n,)
    apart : array (n, n), single precision
        Geometric mean distances over the widths of both strips [m].
    h : array (n,)
        Normal overlap [m]; strips without any bear nothing.
    elastic : float
        E / (2 (1 - nu^2)) [Pa].
    tolerance : float
        The iteration ends when it adds less than this share to the energy.
    most : int
        Iterations at most.
    q, chi : arrays (n,), (m,)
        Start, then result: line loads [N/m]; slenderness factors [-].
    work : array (7, n + 2)
        Scratch; on return work[0] holds a^2 of the strips taken into account, and work[5] their indices.
    lanes, matrix : arrays (LANE_ROWS, n + LANES), (2, n (n + LANES)), single precision
        Scratch.

    Returns
    -------
    energy : float
        [J]
    count, iterations : int
        Strips taken into account; iterations used.
    """
    index = work[5]
    scale = 1.0 / (math.pi * elastic)
    energy, gain = 0.0, 0.0
    n, stride, used = 0, 0, 0
    seed(strip, h, first, last, elastic, q)
    for step in range(most):
        used = step + 1
        before = n
        n, same = candidates(h, first, last, q, index, before)
        if not same:
            stride = gather(strip, apart, n, index, lanes, matrix[1])
        lengths(strip, elastic, first, last, n, q, chi, work, lanes)
        influences(n, stride, scale, lanes, matrix[0], matrix[1])
        energy = 0.0
        for k in range(n):
            i = int(index[k])
            energy += q[i] * strip[i]["width"] * (h[i] - 0.25 * strip[i]["bend"] * work[0, k] - 0.5 * lanes[REST, k])
        gain = relax(strip, h, n, q, chi, work, lanes, matrix[0], stride)
        sweep(n, stride, lanes, matrix[0])
        for k in range(n):
            i = int(index[k])
            load = float(lanes[LOAD, k])
            gain += 0.5 * (load - q[i] * strip[i]["width"]) * (work[3, k] + lanes[LEFT, k])
            q[i] = load / strip[i]["width"]
        if gain < tolerance * energy:
            break
    lengths(strip, elastic, first, last, n, q, chi, work, lanes)
    return energy + gain, n, used


@kernel
def gather(strip, apart, n, index, lanes, close):
    """Put what is fixed of n strips side by side, LANES of them to a step; returns the length of a row."""
    stride = (n + LANES - 1) // LANES * LANES
    for j in range(n, stride):
        lanes[A2, j], lanes[NORMAL_Y, j], lanes[NORMAL_Z, j] = ONE, NOTHING, NOTHING
    for k in range(n):
        i = int(index[k])
        lanes[NORMAL_Y, k], lanes[NORMAL_Z, k] = strip[i]["normal_y"], strip[i]["normal_z"]
        row = apart[i]
        at = k * stride
        for j in range(n):
            close[at + j] = row[int(index[j])]
        for j in range(n, stride):
            close[at + j] = ONE
    return stride


@kernel
def lengths(strip, elastic, first, last, n, q, chi, work, lanes):
    """Squared half lengths a^2 (work[0]) of the loads, and what a strip's own change of them does."""
    a2, kappa, index = work[0], work[1], work[5]
    node, low, high = -1, 0.0, 0.0
    for k in range(n):
        i = int(index[k])
        if strip[i]["hat"] != node:
            node = strip[i]["hat"]
            low, high = math.log(chi[node]), math.log(chi[node + 1])
        slender = math.exp(low + strip[i]["share"] * (high - low))
        width = strip[i]["width"]
        kappa[k] = 0.5 * math.pi * elastic * strip[i]["bend"] * slender
        mean = 0.5 * q[i]
        if i > first:
            mean += 0.25 * q[i - 1]
        if i < last - 1:
            mean += 0.25 * q[i + 1]
        a2[k] = mean / kappa[k] + 0.25 * width * width
        lanes[A2, k] = a2[k]
        lanes[LOAD, k] = q[i] * width
        lanes[OWN, k] = DAMPING * 0.5 / (math.pi * elastic * slender * width)


@kernel
def seed(strip, h, first, last, elastic, q):
    """Begin with a load wherever a patch may bear: loads vanish in one sweep, but take many to appear."""
    low = first
    for k in range(first, last):
        if not h[k] > 0.0:
            continue
        while strip[low]["arc"] < strip[k]["arc"] - AROUND:
            low += 1
        most = 0.0
        i = low
        while i < last and strip[i]["arc"] < strip[k]["arc"] + AROUND:
            most = max(most, h[i])
            i += 1
        q[k] = max(q[k], SEED * elastic * (h[k] - DEPTH_LEFT * most))


@kernel
def candidates(h, first, last, q, index, before):
    """Strips that overlap and may bear: near one that does, or where the overlap is greatest.

    Returns how many, and whether they are the same as the `before` ones in index.
    """
    n, reach = 0, -1
    same = True
    for i in range(first, last):
        if not h[i] > 0.0:
            q[i] = 0.0
            continue
        ahead = min(i + MARGIN + 1, last)
        near = i <= reach
        for k in range(max(i, reach), ahead):
            if q[k] > 0.0:
                reach = k + MARGIN
                near = True
        for k in range(max(i - 1, first), min(i + 2, last)):
            below = h[k - 1] if k > first else 0.0
            above = h[k + 1] if k < last - 1 else 0.0
            near = near or (h[k] >= below and h[k] >= above)
        if near:
            same = same and n < before and int(index[n]) == i
            index[n] = i
            n += 1
        else:
            q[i] = 0.0
    return n, same and n == before


@kernel
def relax(strip, h, n, q, chi, work, lanes, matrix, stride):
    """What is left of the overlap [m] (work[3], LEFT), the next chi; returns the energy that it adds [J]."""
    a2, kappa, turn, left, index = work[0], work[1], work[2], work[3], work[5]
    pinch = lanes[PINCH]
    gain = slenderness(strip, n, q, chi, pinch, work)
    for k in range(n):
        i = int(index[k])
        turn[k] = 0.25 * q[i] * strip[i]["width"] / kappa[k] * (pinch[k] - strip[i]["bend"])
    for k in range(n):
        i = int(index[k])
        mean = 0.5 * turn[k]
        if k > 0 and int(index[k - 1]) == i - 1:
            mean += 0.25 * turn[k - 1]
        if k < n - 1 and int(index[k + 1]) == i + 1:
            mean += 0.25 * turn[k + 1]
        left[k] = h[i] - 0.25 * strip[i]["bend"] * a2[k] + mean / strip[i]["width"] - lanes[REST, k]
        lanes[LEFT, k] = left[k]
        lanes[INVERSE, k] = OVER / (matrix[k * stride + k] + lanes[OWN, k])
    return gain


@kernel
def slenderness(strip, n, q, chi, pinch, work):
    """The next chi, which makes PINCH equal to A as the strips of each node see it; returns the energy it adds [J].

    PINCH grows about as chi does at its strip: one equation for each node, between its neighbours.
    """
    a2, index, own, next_to, excess, step = work[0], work[5], work[2], work[3], work[4], work[6]
    begin, end = strip[int(index[0])]["hat"], strip[int(index[n - 1])]["hat"] + 2
    count = end - begin
    own[:count] = 0.0
    next_to[:count] = 0.0
    excess[:count] = 0.0
    for k in range(n):
        i = int(index[k])
        m, part, width = strip[i]["hat"] - begin, strip[i]["share"], strip[i]["width"]
        pressed = q[i] * width * (a2[k] - 0.25 * width * width)
        bends, over = pressed * strip[i]["bend"], pressed * (strip[i]["bend"] - pinch[k])
        own[m] += (1.0 - part) * (1.0 - part) * bends + STIFF * (1.0 - part) * bends
        own[m + 1] += part * part * bends + STIFF * part * bends
        next_to[m] += part * (1.0 - part) * bends
        excess[m] += (1.0 - part) * over
        excess[m + 1] += part * over
    for m in range(count):
        step[m] = excess[m]
        if m > 0 and own[m - 1] > 0.0:
            ratio = next_to[m - 1] / own[m - 1]
            own[m] -= ratio * next_to[m - 1]
            step[m] -= ratio * step[m - 1]
    gain = 0.0
    for turn in range(count):
        m = count - 1 - turn
        if own[m] > 0.0:
            step[m] = (step[m] - (next_to[m] * step[m + 1] if m < count - 1 else 0.0)) / own[m]
            old = chi[begin + m]
            factor = math.exp(min(max(step[m], -MOST_STEP), MOST_STEP))
            chi[begin + m] = min(max(old * factor, CHI_RANGE[0]), CHI_RANGE[1])
            gain += 0.125 * excess[m] * math.log(chi[begin + m] / old)
        else:
            step[m] = 0.0
    return gain


@kernel
def sweep(n, stride, lanes, matrix):
    """SWEEPS of projected over-relaxation for the loads of n strips, forwards and backwards in turn."""
    load, left, own, inverse = lanes[LOAD], lanes[LEFT], lanes[OWN], lanes[INVERSE]
    for turn in range(SWEEPS):
        for each in range(n):
            k = each if turn % 2 == 0 else n - 1 - each
            move = max(load[k] + inverse[k] * left[k], NOTHING) - load[k]
            if move != NOTHING:
                row = matrix[k * stride : (k + 1) * stride]
                for j in range(stride):
                    left[j] -= move * row[j]
                left[k] -= own[k] * move
                load[k] += move
