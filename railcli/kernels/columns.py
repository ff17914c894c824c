"""Heights at which a wheel stores given energies, and its patches there: what a table of heights holds (theory.md 6.8).

Right-hand wheel, poses and profile graphs as in `difference`; strips and their law as in `strips`.
"""

from math import pi, sqrt

import numpy as np

from .branches import PER_CORNER
from .difference import locus, wheel_axes
from .jit import builder, kernel
from .layout import HEIGHTS, Part
from .overlap import OVERLAP, spread
from .strips import CHI, CHI_RANGE, LANE_ROWS, LANES, press

FIRST_DEPTH = 30e-6  # beyond first touch, where the search for the first height begins [m]
TRIES = 10
NEAR = 0.03  # difference from a wanted w that a tangent bridges [-]
DEEPER = 2.5  # times as deep where first touch falls between strips
RESTART = 0.3  # least share of its depth that a try may keep
CLOSE = 0.6e-3  # positions so near that the loads at one are a good guess at the next [m]
ALONG = 2.1
LOOSE = 0.6  # line load over E* h to begin with
SMALL = 1e-4  # semi-axes over sqrt(w) of a part that never bears
POWER = 0.4  # w = U^POWER is about proportional to the depth


@kernel
def pressed_to(z, y, e, f, d, r0, seat, wheel, w0, wh, strip, apart, elastic, tolerance, most,
               minima, count, row, h, q, chi, work, lanes, matrix):  # fmt: skip
    """Energy and vertical force of a wheel at the height z of T; line loads in q.

    minima : (k, 6) as `difference.minima`, the first `count` of them.  Others: `strips.press`, `overlap.spread`.
    Returns energy [J], vertical force [N], and how many strips were taken into account.
    """
    first, last = strip.size, 0
    h[:] = 0.0
    for j in range(count):
        if minima[j, 1] < z:
            low, high = spread(minima[j, 0], y, z, e, f, d, r0, seat, wheel, w0, wh, strip, row, h)
            if low < high:
                first, last = min(first, low), max(last, high)
    for i in range(strip.size):
        if not h[i] > 0.0:
            q[i] = 0.0
    if last == 0:
        return 0.0, 0.0, 0
    energy, n, _ = press(
        strip, apart, h, first, last, elastic, tolerance, most, q, chi, work, lanes, matrix
    )
    force = 0.0
    for i in range(first, last):
        if h[i] > 0.0:
            force += q[i] * strip[i]["width"] * row[i]["by_z"]
    return energy, force, n


@kernel
def stretch(ratio, strip, q, old):
    """Guess line loads at a depth `ratio` times that of q: each run grows as Hertz's patch does. old : (n,) scratch."""
    n = strip.size
    root = 1.0 / sqrt(ratio)
    for i in range(n):
        old[i] = q[i]
        q[i] = 0.0
    i = 0
    while i < n:
        if not old[i] > 0.0:
            i += 1
            continue
        end, load, centre = i, 0.0, 0.0
        while end < n and old[end] > 0.0:
            part = old[end] * strip[end]["width"]
            load += part
            centre += part * strip[end]["arc"]
            end += 1
        centre /= load
        low = centre + (strip[i]["arc"] - strip[i]["width"] - centre) / root
        high = centre + (strip[end - 1]["arc"] + strip[end - 1]["width"] - centre) / root
        k, source = i, i
        while k > 0 and strip[k - 1]["arc"] > low:
            k -= 1
        while k < n and strip[k]["arc"] < high:
            place = centre + (strip[k]["arc"] - centre) * root
            while source < end - 1 and strip[source + 1]["arc"] < place:
                source += 1
            after = min(source + 1, n - 1)
            gap = strip[after]["arc"] - strip[source]["arc"]
            part = min(max((place - strip[source]["arc"]) / gap, 0.0), 1.0) if gap > 0.0 else 0.0
            value = old[source] + part * ((old[after] if after < end else 0.0) - old[source])
            q[k] = max(q[k], ratio * value)
            k += 1
        i = end


@kernel
def follow(along, past, past_chi, q, chi):
    """Guess line loads and slenderness factors from those at the last two lateral positions.

    along : the way from the last position over that to it, below ALONG for the guess to be linear.
    """
    part = along if along < ALONG else 0.0
    for i in range(q.size):
        q[i] = max(past[0, i] + part * (past[0, i] - past[1, i]), 0.0)
    for m in range(chi.size):
        chi[m] = past_chi[0, m]
        if part > 0.0:
            chi[m] = min(max(chi[m] * (chi[m] / past_chi[1, m]) ** part, CHI_RANGE[0]), CHI_RANGE[1])


@kernel
def part_of(s, minima, count):
    """Minimum in whose basin the profile coordinate s lies."""
    part = 0
    for j in range(count - 1):
        border = minima[j, 5]
        if not border < np.inf:
            border = 0.5 * (minima[j, 0] + minima[j + 1, 0])
        if s > border:
            part = j + 1
    return part


@kernel
def describe_parts(w, n, minima, count, strip, row, q, work, sums, level, patches):
    """Write the share, place and size of each part of the contact at one height into its rows (members of `Part`).

    Strips that bear side by side are one part, of the minimum in whose basin they bear most. Pressures are those of the
    mean loads from which half lengths follow.

    w : U^POWER [J^POWER].  n, work : as `strips.press` returns them.  sums : (count, 9) scratch.
    patches : (count, HEIGHTS, HEIGHTS) filled at `level`.
    """
    sums[:count] = 0.0
    total = 0.0
    k = 0
    while k < n:
        end, heaviest, owner = k, 0.0, 0
        sums[:count, 7] = 0.0
        while end < n and q[int(work[5, end])] > 0.0 and int(work[5, end]) - int(work[5, k]) == end - k:
            i = int(work[5, end])
            j = part_of(row[i]["lateral"], minima, count)
            sums[j, 7] += q[i] * strip[i]["width"]
            if sums[j, 7] > heaviest:
                heaviest, owner = sums[j, 7], j
            end += 1
        part = sums[owner]
        for m in range(k, end):
            i = int(work[5, m])
            load, half = q[i] * strip[i]["width"], sqrt(work[0, m])
            part[0] += load
            part[1] += load * row[i]["by_y"]
            part[2] += load * row[i]["by_z"]
            part[3] += load * row[i]["lateral"]
            part[4] += load * row[i]["radius"]
            part[5] += 2.0 * half * strip[i]["width"]
            part[6] = max(part[6], half)
            mean = 0.5 * q[i] + 0.25 * (q[max(i - 1, 0)] + q[min(i + 1, q.size - 1)])
            part[8] = max(part[8], 2.0 * mean / (pi * half))
            total += load
        k = max(end, k + 1)
    root = 1.0 / sqrt(w)
    for j in range(count):
        load, out = sums[j, 0], patches[j, level]
        out[Part.SHARE] = 0.0
        if load > 0.0:
            per = 1.0 / load
            out[Part.SHARE] = load / total
            out[Part.SLOPE] = -sums[j, 1] / sums[j, 2]
            out[Part.LATERAL], out[Part.RADIUS] = sums[j, 3] * per, sums[j, 4] * per
            out[Part.SEMI_X] = root * sums[j, 6]
            out[Part.SEMI_Y] = root * sums[j, 5] / (pi * sums[j, 6])
            out[Part.PRESSURE] = root * sums[j, 8]


@kernel
def complete_parts(e, f, d, r0, wheel, w0, wh, minima, count, patches):
    """Where a part bears nothing, its place and size are those of the next height at which it does, or rigid ones."""
    for j in range(count):
        _, _, slope, radius = locus(minima[j, 0], e, f, d, r0, wheel, w0, wh)
        known = False
        for turn in range(2 * HEIGHTS):
            level = HEIGHTS - 1 - turn if turn < HEIGHTS else turn - HEIGHTS
            here = patches[j, level]
            if here[Part.SHARE] > 0.0:
                known = True
            elif known or turn >= HEIGHTS:
                other = level + 1 if turn < HEIGHTS else level - 1
                if known and 0 <= other and other < HEIGHTS:
                    for c in range(1, HEIGHTS):
                        here[c] = patches[j, other, c]
        if not known:
            for level in range(HEIGHTS):
                here = patches[j, level]
                here[Part.SLOPE], here[Part.LATERAL], here[Part.RADIUS] = slope, minima[j, 0], radius
                here[Part.SEMI_X], here[Part.SEMI_Y] = SMALL, SMALL


@builder
def scratch(n):
    """What `strips.press` needs for n strips: work, lanes, matrix."""
    return (
        np.zeros((7, n + 2)), np.zeros((LANE_ROWS, n + LANES), np.float32), np.zeros((2, n * (n + LANES)), np.float32)
    )  # fmt: skip


@builder
def bear(z, roll, yaw, y, r0, seat, wheel, w0, wh, strip, apart, elastic, tolerance, most, minima,
         row, h, q, chi, patches):  # fmt: skip
    """A wheel at the height z of T, directly by the law.

    Parameters
    ----------
    z, roll, yaw, y : float
        Pose.
    minima : array (k, 6)
        As `difference.minima`, from the flange to the field side.
    row, h, q : arrays (n,)
        Filled: OVERLAP, its h [m] and the line loads [N/m] of every strip.
    chi : array
        Filled with the slenderness factors.
    patches : array (k, 1, HEIGHTS)
        Filled with the part of each minimum, SEMI_X and SEMI_Y in [m].

    Returns
    -------
    energy : float
        [J]
    by_y, by_z, by_roll, by_yaw : float
        Its gradient [N], [N], [N m], [N m].
    """
    e, f, d = wheel_axes(roll, yaw)
    n = strip.size
    work, lanes, matrix = scratch(n)
    sums = np.zeros((minima.shape[0], 9))
    chi[:] = CHI
    q[:] = LOOSE * elastic * FIRST_DEPTH
    patches[:] = 0.0
    energy, _, count = pressed_to(
        z, y, e, f, d, r0, seat, wheel, w0, wh, strip, apart, elastic, tolerance, most,
        minima, minima.shape[0], row, h, q, chi, work, lanes, matrix,
    )  # fmt: skip
    by_y, by_z, by_roll, by_yaw = 0.0, 0.0, 0.0, 0.0
    if energy > 0.0:
        describe_parts(1.0, count, minima, minima.shape[0], strip, row, q, work, sums, 0, patches)
        for k in range(count):
            row[int(work[5, k])]["half"] = sqrt(work[0, k])
        for i in range(n):
            load = q[i] * strip[i]["width"]
            if load > 0.0:
                by_y, by_z = by_y + load * row[i]["by_y"], by_z + load * row[i]["by_z"]
                by_roll, by_yaw = by_roll + load * row[i]["by_roll"], by_yaw + load * row[i]["by_yaw"]
    return energy, by_y, by_z, by_roll, by_yaw


@builder
def fill_columns(roll, yaw, y, r0, seat, wheel, w0, wh, rail, g0, gh, strip, apart, elastic,
                 levels, tolerance, most, found, counts, heights, parts):  # fmt: skip
    """Heights and patches for every lateral position of one orientation.

    Parameters
    ----------
    y : array (n_y,)
        [m]
    levels : array (HEIGHTS,)
        U^POWER, rising [J^POWER].
    found, counts : arrays (n_y, PER_CORNER, 6), (n_y,)
        Minima of the difference surface, as `difference.minima`.
    heights : array (n_y, HEIGHTS)
        Filled with z of T [m].
    parts : array (n * HEIGHTS, HEIGHTS)
        Filled: rows of each minimum in turn, members of `Part`, one for every height. Without rows: not filled.

    Returns
    -------
    int
        Solutions found.
    """
    e, f, d = wheel_axes(roll, yaw)
    size = strip.size
    row, h, q, chi = np.zeros(size, OVERLAP), np.zeros(size), np.zeros(size), np.empty(strip[size - 1]["hat"] + 2)
    work, lanes, matrix = scratch(size)
    sums, patches = np.zeros((PER_CORNER, 9)), np.zeros((PER_CORNER, HEIGHTS, HEIGHTS))
    past, past_chi, past_rate = np.zeros((2, HEIGHTS, size)), np.zeros((2, HEIGHTS, chi.size)), np.zeros(HEIGHTS)
    solved, at = 0, 0
    for i in range(y.size):
        gap = y[i] - y[i - 1] if i > 0 else np.inf
        along = gap / (y[i - 1] - y[i - 2]) if i > 1 else np.inf
        count = counts[i]
        touch = np.inf
        for j in range(count):
            touch = min(touch, found[i, j, 1])
        clear = touch
        chi[:] = CHI
        q[:] = 0.0
        z, rate, value = touch + FIRST_DEPTH, 0.0, 0.0
        for level in range(HEIGHTS):
            if level > 0:
                z += (levels[level] - value) * (0.5 * (rate + past_rate[level]) if gap < CLOSE else rate)
            if gap < CLOSE:
                follow(along, past[:, level], past_chi[:, level], q, chi)
            elif level > 0:
                stretch(levels[level] / value, strip, q, h)
            else:
                q[:] = LOOSE * elastic * FIRST_DEPTH
            n, deep = 0, np.inf
            for turn in range(TRIES):
                energy, force, n = pressed_to(
                    z, y[i], e, f, d, r0, seat, wheel, w0, wh, strip, apart, elastic, tolerance, most,
                    found[i], count, row, h, q, chi, work, lanes, matrix,
                )  # fmt: skip
                solved += 1
                if not energy > 0.0:
                    if turn == TRIES - 1:
                        return -1
                    clear = max(clear, z)
                    z = 0.5 * (clear + deep) if deep < np.inf else touch + DEEPER * (z - touch)
                    continue
                deep = z
                value = energy**POWER
                rate = energy / (POWER * value * force)
                if abs(levels[level] - value) < NEAR * levels[level] or turn == TRIES - 1:
                    break
                z = max(z + (levels[level] - value) * rate, clear + RESTART * (z - clear))
            heights[i, level] = z + (levels[level] - value) * rate
            past[1, level], past_chi[1, level] = past[0, level], past_chi[0, level]
            past[0, level], past_chi[0, level], past_rate[level] = q, chi, rate
            if parts.shape[0] > 0:
                describe_parts(value, n, found[i], count, strip, row, q, work, sums, level, patches)
        if parts.shape[0] > 0:
            complete_parts(e, f, d, r0, wheel, w0, wh, found[i], count, patches)
            for j in range(count):
                for level in range(HEIGHTS):
                    for c in range(HEIGHTS):
                        parts[at + level, c] = patches[j, level, c]
                at += HEIGHTS
    return solved
