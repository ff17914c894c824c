"""Heights at which a wheel stores given energies, and its patches there: what a table of heights holds (theory.md 6.8).

Right-hand wheel, poses and profile graphs as in `difference`; strips and their law as in `strips`.
"""

from math import pi, sqrt

import numpy as np

from .branches import PER_CORNER
from .difference import locus, wheel_axes
from .jit import builder, kernel
from .layout import LEVELS, PART_LEVELS, PARTS, ROW, Part
from .overlap import OVERLAP, spread
from .strips import CHI, CHI_RANGE, LANE_ROWS, LANES, press

FIRST_DEPTH = 12e-6  # beyond first touch, where the search for the first height begins [m]
TRIES = 10
NEAR = 0.03  # difference from a wanted w that a tangent bridges [-]
DEEPER = 2.5  # times as deep where first touch falls between strips
RESTART = 0.3  # least share of its depth that a try may keep
CLOSE = 0.6e-3  # positions so near that the loads at one are a good guess at the next [m]
ALONG = 2.1
LOOSE = 0.6  # line load over E* h to begin with
SMALL = 1e-4  # semi-axes over sqrt(w) of a part that never bears
BESIDE = 1.0 / 12.0  # share of each neighbour's load in a strip's for its pressure: single strips vary (theory.md 6.8)
POWER = 0.4  # w = U^POWER is about proportional to the depth


@kernel
def bend_weights(strip, i):
    """What the strips below and above i add to the mean of the overlap over its width, each less its own [-].

    The mean of the parabola through the three; nothing at the ends of the strips.
    """
    if i == 0 or i == strip.size - 1:
        return 0.0, 0.0
    below, above = strip[i]["arc"] - strip[i - 1]["arc"], strip[i + 1]["arc"] - strip[i]["arc"]
    share = strip[i]["width"] * strip[i]["width"] / (12.0 * (below + above))
    return share / below, share / above


@kernel
def average(strip, row, first, last, h):
    """Replace overlaps h at the middles of strips first ... last - 1 by their means over the widths.

    Rows of the strips beside those that overlap are filled too: that is where `overlap.spread` finds the ends.
    """
    for i in range(first, last):
        if h[i] > 0.0:
            low, high = bend_weights(strip, i)
            if low > 0.0:
                here = row[i]["h"]
                h[i] = here + low * (row[i - 1]["h"] - here) + high * (row[i + 1]["h"] - here)


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
    average(strip, row, first, last, h)
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
def stretch(ratio, source_strip, old, strip, q):
    """Guess line loads at a depth `ratio` times that of loads `old` on other strips: each run grows as Hertz's patch.

    source_strip, old : strips and loads; strip, q : those to fill.
    """
    n, last = old.size, q.size - 1
    q[:] = 0.0
    root = 1.0 / sqrt(ratio)
    i, k = 0, 0
    while i < n:
        if not old[i] > 0.0:
            i += 1
            continue
        end, load, centre = i, 0.0, 0.0
        while end < n and old[end] > 0.0:
            part = old[end] * source_strip[end]["width"]
            load += part
            centre += part * source_strip[end]["arc"]
            end += 1
        centre /= load
        low = centre + (source_strip[i]["arc"] - source_strip[i]["width"] - centre) / root
        high = centre + (source_strip[end - 1]["arc"] + source_strip[end - 1]["width"] - centre) / root
        while k > 0 and strip[k - 1]["arc"] > low:
            k -= 1
        while k < last and not strip[k]["arc"] > low:
            k += 1
        at = i
        while k <= last and strip[k]["arc"] < high:
            place = centre + (strip[k]["arc"] - centre) * root
            while at < end - 1 and source_strip[at + 1]["arc"] < place:
                at += 1
            after = min(at + 1, n - 1)
            gap = source_strip[after]["arc"] - source_strip[at]["arc"]
            part = min(max((place - source_strip[at]["arc"]) / gap, 0.0), 1.0) if gap > 0.0 else 0.0
            value = old[at] + part * ((old[after] if after < end else 0.0) - old[at])
            q[k] = max(q[k], ratio * value)
            k += 1
        k = min(k, last)
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

    Strips that bear side by side are one part, of the minimum in whose basin they bear most. Pressures are those of
    loads that take BESIDE from either side.

    w : U^POWER [J^POWER].  n, work : as `strips.press` returns them.  sums : (count, 9) scratch.
    patches : (count, PARTS, ROW) filled at `level`, which counts PART_LEVELS.
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
            beside = q[max(i - 1, 0)] + q[min(i + 1, q.size - 1)]
            mean = (1.0 - 2.0 * BESIDE) * q[i] + BESIDE * beside
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
        for turn in range(2 * PARTS):
            level = PARTS - 1 - turn if turn < PARTS else turn - PARTS
            here = patches[j, level]
            if here[Part.SHARE] > 0.0:
                known = True
            elif known or turn >= PARTS:
                other = level + 1 if turn < PARTS else level - 1
                if known and 0 <= other and other < PARTS:
                    for c in range(1, ROW):
                        here[c] = patches[j, other, c]
        if not known:
            for level in range(PARTS):
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
    patches : array (k, 1, ROW)
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
                low, high = bend_weights(strip, i)
                for k in range(max(i - 1, 0), min(i + 2, n)):
                    part = load * (low if k < i else high if k > i else 1.0 - low - high)
                    by_y, by_z = by_y + part * row[k]["by_y"], by_z + part * row[k]["by_z"]
                    by_roll, by_yaw = by_roll + part * row[k]["by_roll"], by_yaw + part * row[k]["by_yaw"]
    return energy, by_y, by_z, by_roll, by_yaw


@builder
def fill_columns(roll, yaw, y, r0, seat, wheel, w0, wh, rail, g0, gh, strips, first, aparts, elastic,
                 levels, tolerance, most, found, counts, heights, parts):  # fmt: skip
    """Heights and patches for every lateral position of one orientation.

    Parameters
    ----------
    y : array (n_y,)
        [m]
    strips, first : STRIP array (n,), array (LEVELS + 1,)
        Strips of each level in turn, and where they begin.
    aparts : array (sum of squares of their numbers,), single precision
        Their distances, as `strips.press`, one level after another.
    levels : array (LEVELS,)
        U^POWER, rising [J^POWER].
    found, counts : arrays (n_y, PER_CORNER, 6), (n_y,)
        Minima of the difference surface, as `difference.minima`.
    heights : array (n_y, LEVELS)
        Filled with z of T [m].
    parts : array (n * PARTS, ROW)
        Filled: rows of each minimum in turn, members of `Part`, one for each of PART_LEVELS. Without rows: not filled.

    Returns
    -------
    int
        Solutions found.
    """
    e, f, d = wheel_axes(roll, yaw)
    size, nodes = 0, 0
    apart_first = np.zeros(LEVELS + 1, np.int64)
    for level in range(LEVELS):
        n = first[level + 1] - first[level]
        size, nodes = max(size, n), max(nodes, strips[first[level + 1] - 1]["hat"] + 2)
        apart_first[level + 1] = apart_first[level] + n * n
    rows, loads, overlaps = np.zeros(size, OVERLAP), np.zeros(size), np.zeros(size)
    work, lanes, matrix = scratch(size)
    chi = np.empty(nodes)
    sums, patches = np.zeros((PER_CORNER, 9)), np.zeros((PER_CORNER, PARTS, ROW))
    past, past_chi, past_rate = np.zeros((2, LEVELS, size)), np.zeros((2, LEVELS, nodes)), np.zeros(LEVELS)
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
        z, rate, value = touch + FIRST_DEPTH, 0.0, 0.0
        part = 0
        for level in range(LEVELS):
            strip = strips[first[level] : first[level + 1]]
            n = strip.size
            apart = aparts[apart_first[level] : apart_first[level + 1]].reshape((n, n))
            row, q, h = rows[:n], loads[:n], overlaps[:n]
            if level > 0:
                z += (levels[level] - value) * (0.5 * (rate + past_rate[level]) if gap < CLOSE else rate)
            if gap < CLOSE:
                follow(along, past[:, level, :n], past_chi[:, level], q, chi)
            elif level > 0:
                before = strips[first[level - 1] : first[level]]
                stretch(levels[level] / value, before, past[0, level - 1, : before.size], strip, q)
            else:
                q[:] = LOOSE * elastic * FIRST_DEPTH
            taken, deep = 0, np.inf
            for turn in range(TRIES):
                energy, force, taken = pressed_to(
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
            past[0, level, :n], past_chi[0, level], past_rate[level] = q, chi, rate
            if parts.shape[0] > 0 and level == PART_LEVELS[part]:
                describe_parts(value, taken, found[i], count, strip, row, q, work, sums, part, patches)
                part = min(part + 1, PARTS - 1)
        if parts.shape[0] > 0:
            complete_parts(e, f, d, r0, wheel, w0, wh, found[i], count, patches)
            for j in range(count):
                for level in range(PARTS):
                    for c in range(ROW):
                        parts[at + level, c] = patches[j, level, c]
                at += PARTS
    return solved
