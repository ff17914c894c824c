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
from functools import cache

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

SINGULAR = 16.0 / (3.0 * math.pi**2)  # integral of the product of two semi-ellipses of unit load and half length 1
FAR_TOP = 0.949  # v = 1 / (1 + t^2) up to which `far` is used
FAR_COUNT = 2049
NEAR_COUNT = 4001
NEAR_TOP = 60.0  # t of its last entry
MARGIN = 3  # strips beside those that bear which may come to bear in one iteration
SEED = 0.2  # line load over E* and overlap with which a patch begins
AROUND = 2e-3  # a patch does not bear where the overlap is less than a share of the greatest one so near [m]
DEPTH_LEFT = 0.35
SWEEPS = 6  # of one iteration
OVER = 1.3  # relaxation
DAMPING = 1.0  # share of a strip's own change of length that an iteration takes into account
CHI = 1.5  # to begin with
CHI_RANGE = (0.3, 100.0)


@cache
def pulls():
    """Tables of the influence Gamma(t) of one semi-elliptic load on another at the distance t.

    Gamma is the mean of 1 / sqrt((x - x')^2 + t^2) over two semi-elliptic weights of half length 1.

    Returns
    -------
    far : array (FAR_COUNT, 2)
        Gamma (1 + t^2)^(1/2) and (Gamma + t Gamma') (1 + t^2)^(3/2), evenly spaced in v = 1 / (1 + t^2).
    near : array (NEAR_COUNT, 2)
        Gamma + 2 SINGULAR ln t and t Gamma' + 2 SINGULAR, evenly spaced in t / (1 + t).
    """
    angle, weight = np.polynomial.legendre.leggauss(200)
    angle = 0.5 * math.pi * (angle + 1.0)
    node, share = np.polynomial.legendre.leggauss(400)
    node, share = 0.5 * (node + 1.0), 0.5 * share
    apart, share = 2.0 * node**3, 6.0 * node**2 * share  # x - x', fine near 0
    half = 0.5 * (2.0 - apart)
    x = 0.5 * apart[:, None] - half[:, None] * np.cos(angle)
    product = np.sqrt(np.maximum(1.0 - x * x, 0.0) * np.maximum(1.0 - (x - apart[:, None]) ** 2, 0.0))
    joint = (2.0 / math.pi) ** 2 * 0.5 * math.pi * half * ((product * np.sin(angle)) @ weight)

    def smooth(t):
        square = t[:, None] ** 2
        distance = np.sqrt(apart**2 + square)
        far = np.sqrt(4.0 + t * t)
        bent = (joint - SINGULAR) * share
        value = 2.0 * (bent / distance).sum(axis=1) + 2.0 * SINGULAR * np.log(2.0 + far)
        slope = -2.0 * square[:, 0] * (bent / distance**3).sum(axis=1)
        return np.column_stack([value, slope + 2.0 * SINGULAR * t * t / (far * (2.0 + far))])

    place = np.linspace(0.0, NEAR_TOP / (1.0 + NEAR_TOP), NEAR_COUNT)
    t = place / (1.0 - place)
    t[0] = 1e-9
    near = smooth(t)
    v = np.linspace(0.0, 0.95, FAR_COUNT)
    t = np.sqrt((1.0 - v[1:]) / v[1:])
    value, slope = smooth(t).T
    value, slope = value - 2.0 * SINGULAR * np.log(t), slope - 2.0 * SINGULAR
    series = 1.0 / t - 0.25 / t**3 + 15.0 / 64.0 / t**5, -1.0 / t + 0.75 / t**3 - 75.0 / 64.0 / t**5
    value, slope = np.where(t > 20.0, series[0], value), np.where(t > 20.0, series[1], slope)
    far = np.empty((FAR_COUNT, 2))
    far[0] = 1.0, 0.5
    far[1:, 0] = value * np.sqrt(1.0 + t * t)
    far[1:, 1] = (value + slope) * (1.0 + t * t) ** 1.5
    return far, near


@kernel
def pull(square, half_square, far, near):
    """Gamma / a and (Gamma + t Gamma') / a^3 of two strips.

    square : of their distance, for close ones that of the geometric mean distance of their points [m^2].
    half_square : mean of their a^2 [m^2].
    """
    total = half_square + square
    v = half_square / total
    if v < FAR_TOP:
        place = v * ((FAR_COUNT - 1) / 0.95)
        i = int(place)
        part = place - i
        inverse = 1.0 / total
        root = math.sqrt(inverse)
        return (
            (far[i, 0] + part * (far[i + 1, 0] - far[i, 0])) * root,
            (far[i, 1] + part * (far[i + 1, 1] - far[i, 1])) * root * inverse,
        )
    t = math.sqrt(square / half_square)
    place = t / (1.0 + t) * ((NEAR_COUNT - 1) * (1.0 + NEAR_TOP) / NEAR_TOP)
    i = int(place)
    part = place - i
    value = near[i, 0] + part * (near[i + 1, 0] - near[i, 0]) - 2.0 * SINGULAR * math.log(t)
    slope = near[i, 1] + part * (near[i + 1, 1] - near[i, 1]) - 2.0 * SINGULAR
    root = 1.0 / math.sqrt(half_square)
    return value * root, (value + slope) * root * root * root


@kernel
def press(strip, square, h, first, last, elastic, far, near, tolerance, most, q, chi, work, matrix):
    """Line loads of the strips first ... last - 1: the maximum of the energy.

    Parameters
    ----------
    strip : STRIP array (n,)
    square : array (n, n)
        Squared distances, the geometric mean over the widths of both strips [m^2].
    h : array (n,)
        Normal overlap [m]; strips without any bear nothing.
    elastic : float
        E / (2 (1 - nu^2)) [Pa].
    far, near : arrays
        As `pulls`.
    tolerance : float
        Relative change of the energy at which the iteration ends.
    most : int
        Iterations at most.
    q, chi : arrays (n,), (m,)
        Start, then result: line loads [N/m]; slenderness factors [-].
    work, matrix : arrays (8, n), (n, n)
        Scratch; on return work[0] holds a^2 of the strips taken into account, and work[7] their indices.

    Returns
    -------
    energy : float
        [J]
    count, iterations : int
        Strips taken into account; iterations used.
    """
    a2, pinch, rest, kappa, own, inverse, turn, index = (
        work[0], work[1], work[2], work[3], work[4], work[5], work[6], work[7]
    )  # fmt: skip
    scale = 1.0 / (math.pi * elastic)
    energy = 0.0
    n, used = 0, 0
    seed(strip, h, first, last, elastic, q)
    for step in range(most + 1):
        n = candidates(h, first, last, q, index)
        for k in range(n):
            i = int(index[k])
            m, part = strip[i]["hat"], strip[i]["share"]
            slender = chi[m] ** (1.0 - part) * chi[m + 1] ** part
            kappa[k] = 0.5 * math.pi * elastic * strip[i]["bend"] * slender
            own[k] = DAMPING * 0.5 * scale / (slender * strip[i]["width"])
            mean = 0.5 * q[i]
            if i > first:
                mean += 0.25 * q[i - 1]
            if i < last - 1:
                mean += 0.25 * q[i + 1]
            a2[k] = mean / kappa[k] + 0.25 * strip[i]["width"] ** 2
            pinch[k] = 0.0
            rest[k] = 0.0
        for k in range(n):
            i = int(index[k])
            load = q[i] * strip[i]["width"]
            here, ny, nz = a2[k], scale * strip[i]["normal_y"], scale * strip[i]["normal_z"]
            sum_pinch, sum_rest = 0.0, 0.0
            for j in range(k, n):
                other = int(index[j])
                value, slope = pull(square[i, other], 0.5 * (here + a2[j]), far, near)
                lean = ny * strip[other]["normal_y"] + nz * strip[other]["normal_z"]
                value *= lean
                slope *= lean
                matrix[k, j] = value
                matrix[j, k] = value
                push = q[other] * strip[other]["width"]
                sum_pinch += push * slope
                sum_rest += push * value
                if j > k:
                    pinch[j] += load * slope
                    rest[j] += load * value
            pinch[k] += sum_pinch
            rest[k] += sum_rest
        before, energy = energy, 0.0
        for k in range(n):
            i = int(index[k])
            energy += strip[i]["width"] * q[i] * (h[i] - 0.25 * strip[i]["bend"] * a2[k] - 0.5 * rest[k])
        used = step
        if n == 0 or step == most or (step > 1 and abs(energy - before) < tolerance * energy):
            break
        relax(strip, h, first, last, n, q, chi, work)
        sweep(n, rest, own, inverse, turn, matrix)
        for k in range(n):
            i = int(index[k])
            q[i] = turn[k] / strip[i]["width"]
    return energy, n, used


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
def candidates(h, first, last, q, index):
    """Strips that overlap and may bear: near one that does, or where the overlap is greatest. Returns how many."""
    n, reach = 0, -1
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
            index[n] = i
            n += 1
        else:
            q[i] = 0.0
    return n


@kernel
def relax(strip, h, first, last, n, q, chi, work):
    """Right-hand sides (work[2]) and first loads [N] (work[6]) at fixed a; the next chi."""
    a2, pinch, rest, kappa, own, turn, index = work[0], work[1], work[2], work[3], work[4], work[6], work[7]
    for m in range(strip[int(index[0])]["hat"], strip[int(index[n - 1])]["hat"] + 2):
        low, high = 0.0, 0.0
        for k in range(n):
            i = int(index[k])
            node, part = strip[i]["hat"], strip[i]["share"]
            if node == m or node + 1 == m:
                hat = 1.0 - part if node == m else part
                width = strip[i]["width"]
                pressed = hat * q[i] * width * (a2[k] - 0.25 * width * width)
                low += pressed * strip[i]["bend"]
                high += pressed * pinch[k]
        if low > 0.0:
            chi[m] = min(max(chi[m] / min(max(high / low, 0.5), 2.0), CHI_RANGE[0]), CHI_RANGE[1])
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
        width = strip[i]["width"]
        rest[k] = h[i] - 0.25 * strip[i]["bend"] * a2[k] + mean / width + own[k] * q[i] * width
    for k in range(n):
        i = int(index[k])
        turn[k] = q[i] * strip[i]["width"]


@kernel
def sweep(n, rest, own, inverse, load, matrix):
    """SWEEPS of projected over-relaxation for the loads [N] of n strips, forwards and backwards in turn."""
    for k in range(n):
        inverse[k] = OVER / (matrix[k, k] + own[k])
    for turn in range(SWEEPS):
        for each in range(n):
            k = each if turn % 2 == 0 else n - 1 - each
            s0, s1, s2, s3 = own[k] * load[k], 0.0, 0.0, 0.0
            whole = n - n % 4
            for j in range(0, whole, 4):
                s0 += matrix[k, j] * load[j]
                s1 += matrix[k, j + 1] * load[j + 1]
                s2 += matrix[k, j + 2] * load[j + 2]
                s3 += matrix[k, j + 3] * load[j + 3]
            for j in range(whole, n):
                s0 += matrix[k, j] * load[j]
            load[k] = max(load[k] + inverse[k] * (rest[k] - ((s0 + s1) + (s2 + s3))), 0.0)
