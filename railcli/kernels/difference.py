"""The wheel-rail difference surface and its minima (theory.md section 4).

Right-hand wheel; track axes (x forward, y right, z down). A wheel pose is (y, roll, yaw): y is the lateral position of
its reference point T, the bottom of the tape circle, about nominal; T is held at z = 0, so that D, the distance from
rail to wheel along z at one place of the wheel, is the depth of T at which that place touches.

Profiles come as graphs: rows (value, slope, mean curvature) on a uniform lateral grid, read by cubic Hermite
interpolation and continued along the last tangent.
"""

from math import cos, sin, sqrt

import numpy as np

from .jit import kernel

BARRIER_CAP = 1e-3  # barriers and gaps between branches beyond this are not resolved [m]
SIMPLEX_SIZE = 0.4e-3  # edge of the first simplex [m]
SIMPLEX_STOP = 5e-6  # largest edge at which the simplex stops, Newton takes over [m]
SIMPLEX_STEPS = 200
PROBE = 2e-6  # difference step along the profile [m]
SECTIONS = 16  # of golden section: two stations 1 mm apart shrink to a micrometre
GOLDEN = 0.6180339887498949
SAME_POINT = 20e-6  # two minima closer than this are one [m]


@kernel
def height(graph, start, step, y):
    """Value and slope of a profile graph at lateral position y [m]; along the last tangent beyond its ends."""
    n = graph.shape[0]
    place = (y - start) / step
    if not place > 0.0:
        return graph[0, 0] + graph[0, 1] * (y - start), graph[0, 1]
    if place >= n - 1:
        return graph[n - 1, 0] + graph[n - 1, 1] * (y - start - (n - 1) * step), graph[n - 1, 1]
    i = int(place)
    t = place - i
    f0 = graph[i, 0]
    f1 = graph[i + 1, 0]
    m0 = graph[i, 1] * step
    m1 = graph[i + 1, 1] * step
    c2 = 3.0 * (f1 - f0) - 2.0 * m0 - m1
    c3 = 2.0 * (f0 - f1) + m0 + m1
    return f0 + t * (m0 + t * (c2 + t * c3)), (m0 + t * (2.0 * c2 + 3.0 * t * c3)) / step


@kernel
def mean_curvature(graph, start, step, y):
    """Mean curvature [1/m] of a profile graph at y: its third column, linear between nodes, held beyond the ends."""
    n = graph.shape[0]
    place = min(max((y - start) / step, 0.0), n - 1.000001)
    i = int(place)
    return graph[i, 2] + (place - i) * (graph[i + 1, 2] - graph[i, 2])


@kernel
def wheel_axes(roll, yaw):
    """Axle direction e (to the right), forward f and downward d = f x e of a wheelset, in track axes."""
    sr, cr = sin(roll), cos(roll)
    sy, cy = sin(yaw), cos(yaw)
    return (-sy * cr, cy * cr, sr), (cy, sy, 0.0), (sy * sr, -cy * sr, cr)


@kernel
def surface_point(s, radius, sine, e, f, d, r0):
    """(y, z) of the wheel surface against T, at profile coordinate s and angle asin(sine) ahead of the bottom [m]."""
    down = radius * sqrt(1.0 - sine * sine) - r0
    return s * e[1] + radius * sine * f[1] + down * d[1], s * e[2] + down * d[2]


@kernel
def lean_gap(value, rail_slope, level):
    """What a contact point minimises: D [m] for a rigid contact (level infinite), else (D - level) cos(contact angle).

    The second is minus the approach along the rail's normal while T stands at z = level: where profiles conform, the
    places that bear the load are those where it is greatest, not those that touch first.
    """
    if level < np.inf:
        return (value - level) / sqrt(1.0 + rail_slope * rail_slope)
    return value


@kernel
def gap(s, along, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Difference surface at s on the profile, `along` ahead of the bottom as on the tape circle; as `lean_gap` [m].

    seat [m] is the lateral position of nominal T in the axes of the rail profile.
    """
    value, _ = height(wheel, w0, wh, s)
    sine = min(max(along / r0, -0.9), 0.9)
    py, pz = surface_point(s, r0 + value, sine, e, f, d, r0)
    z, slope = height(rail, g0, gh, y + seat + py)
    return lean_gap(z - pz, slope, level)


@kernel
def ahead(slope, e, f, d):
    """Sine and cosine of the angle ahead of the bottom at which the wheel's normal has no component along the rail."""
    reach = sqrt(d[0] * d[0] + f[0] * f[0])
    lean_sin, lean_cos = d[0] / reach, f[0] / reach
    g = min(max(slope * e[0] / reach, -0.99), 0.99)
    h = sqrt(1.0 - g * g)
    return g * lean_cos - h * lean_sin, h * lean_cos + g * lean_sin


@kernel
def locus(s, e, f, d, r0, wheel, w0, wh):
    """The contact locus: the point at profile coordinate s whose normal has no component along the rail.

    Returns y, z against T [m], the slope dz/dy of the wheel there, and the radius [m].
    Wang (1984); de Pater; Arnold and Frischmuth (1998).
    """
    value, slope = height(wheel, w0, wh, s)
    radius = r0 + value
    sine, cosine = ahead(slope, e, f, d)
    ny = cosine * d[1] + sine * f[1] - slope * e[1]
    nz = cosine * d[2] - slope * e[2]
    down = radius * cosine - r0
    return s * e[1] + radius * sine * f[1] + down * d[1], s * e[2] + down * d[2], -ny / nz, radius


@kernel
def slope_difference(s, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Rail slope minus wheel slope on the locus, D [m] and the rail's slope there: the first is zero at a contact."""
    py, pz, slope, _ = locus(s, e, f, d, r0, wheel, w0, wh)
    z, rail_slope = height(rail, g0, gh, y + seat + py)
    return rail_slope - slope, z - pz, rail_slope


@kernel
def locus_gap(s, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """The difference surface on the locus, as `lean_gap` [m]."""
    _, value, slope = slope_difference(s, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    return lean_gap(value, slope, level)


@kernel
def ascent(s, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Zero at a contact point, positive beyond it: slope difference of a rigid contact, else d `locus_gap` / ds."""
    if level < np.inf:
        right = locus_gap(s + PROBE, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        left = locus_gap(s - PROBE, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        return 0.5 * (right - left) / PROBE
    return slope_difference(s, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)[0]


@kernel
def polish(s, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Newton on `ascent` from a minimum found by other means; stays within 0.2 mm of it. Returns s [m]."""
    low, high = s - 0.2e-3, s + 0.2e-3
    for _ in range(12):
        value = ascent(s, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        right = ascent(s + PROBE, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        rate = (right - value) / PROBE
        if rate <= 0.0:
            break
        if value > 0.0:
            high = min(high, s)
        else:
            low = max(low, s)
        move = -value / rate
        after = s + move
        if after <= low or after >= high:
            after = 0.5 * (low + high)
        done = abs(after - s) < 1e-9
        s = after
        if done:
            break
    return s


@kernel
def lowest_between(low, high, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Lowest place of the locus between two stations by golden section, for a basin that a simplex has left [m]."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left = locus_gap(left, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    at_right = locus_gap(right, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    for _ in range(SECTIONS):
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = locus_gap(left, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = locus_gap(right, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    return 0.5 * (low + high)


@kernel
def simplex(s, along, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Minimise the difference surface from one seed by the simplex method of Nelder and Mead (1965).

    Reflection 1, expansion 2, contraction and shrinkage 1/2, as in their paper.
    Returns s, the place along the circle [m], the minimum [m] and the number of evaluations.
    """
    ax, ay = s, along
    bx, by = s + SIMPLEX_SIZE, along
    cx, cy = s, along + 10.0 * SIMPLEX_SIZE
    fa = gap(ax, ay, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    fb = gap(bx, by, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    fc = gap(cx, cy, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    count = 3
    for _ in range(SIMPLEX_STEPS):
        if fb < fa:
            ax, ay, fa, bx, by, fb = bx, by, fb, ax, ay, fa
        if fc < fa:
            ax, ay, fa, cx, cy, fc = cx, cy, fc, ax, ay, fa
        if fc < fb:
            bx, by, fb, cx, cy, fc = cx, cy, fc, bx, by, fb
        if max(abs(bx - ax), abs(cx - ax)) < SIMPLEX_STOP and max(abs(by - ay), abs(cy - ay)) < 10.0 * SIMPLEX_STOP:
            break
        mx, my = 0.5 * (ax + bx), 0.5 * (ay + by)
        rx, ry = 2.0 * mx - cx, 2.0 * my - cy
        fr = gap(rx, ry, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        count += 1
        if fr < fa:
            ex, ey = 3.0 * mx - 2.0 * cx, 3.0 * my - 2.0 * cy
            fe = gap(ex, ey, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
            count += 1
            if fe < fr:
                cx, cy, fc = ex, ey, fe
            else:
                cx, cy, fc = rx, ry, fr
            continue
        if fr < fb:
            cx, cy, fc = rx, ry, fr
            continue
        if fr < fc:
            kx, ky = 0.5 * (mx + rx), 0.5 * (my + ry)
        else:
            kx, ky = 0.5 * (mx + cx), 0.5 * (my + cy)
        fk = gap(kx, ky, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        count += 1
        if fk < min(fr, fc):
            cx, cy, fc = kx, ky, fk
            continue
        bx, by = 0.5 * (ax + bx), 0.5 * (ay + by)
        cx, cy = 0.5 * (ax + cx), 0.5 * (ay + cy)
        fb = gap(bx, by, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        fc = gap(cx, cy, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        count += 2
    return ax, ay, fa, count


@kernel
def prepare_scan(station, e, f, d, r0, wheel, w0, wh, scan_y, scan_z):
    """The contact locus at every station for one orientation; the scan then only shifts it.

    scan_y, scan_z : (n,) filled with its points against T [m].
    """
    for i in range(station.size):
        scan_y[i], scan_z[i], _, _ = locus(station[i], e, f, d, r0, wheel, w0, wh)


@kernel
def scan(level, y, seat, rail, g0, gh, scan_y, scan_z, lowest):
    """The difference surface on the locus at every station, as `lean_gap` [m]; returns the station of the lowest."""
    best = 0
    for i in range(lowest.size):
        z, slope = height(rail, g0, gh, y + seat + scan_y[i])
        lowest[i] = lean_gap(z - scan_z[i], slope, level)
        if lowest[i] < lowest[best]:
            best = i
    return best


@kernel
def _crest(station, value, i):
    """Place and height of the parabola through points i - 1, i, i + 1 (uneven spacing), for a saddle."""
    x0, x1, x2 = station[i - 1], station[i], station[i + 1]
    p = (value[i] - value[i - 1]) / (x1 - x0)
    q = (value[i + 1] - value[i]) / (x2 - x1)
    bend = (q - p) / (x2 - x0)
    if bend >= 0.0:
        return x1, value[i]
    x = 0.5 * (x0 + x1) - 0.5 * p / bend
    return x, value[i] - 0.25 * (p + bend * (x1 - x0)) ** 2 / bend


@kernel
def drop_shallowest(found, count, value):
    """Remove the minimum with the largest D, if larger than value, from the rows of `minima`. Returns how many stay."""
    worst = 0
    for j in range(1, count):
        if found[j, 1] > found[worst, 1]:
            worst = j
    if found[worst, 1] <= value:
        return count
    remove_row(found, count, worst)
    return count - 1


@kernel
def remove_row(found, count, row):
    """Move the rows behind `row` one place up."""
    for j in range(row, count - 1):
        for k in range(found.shape[1]):
            found[j, k] = found[j + 1, k]


@kernel
def drop_strays(found, count):
    """Remove minima of a simplex that left its basin for one that another seed found as well. Returns how many."""
    strays = 0
    j = 0
    while j < count - strays:
        s = found[j, 0]
        twins = 0
        for k in range(count - strays):
            if abs(found[k, 0] - s) < SAME_POINT:
                twins += 1
        if twins > 1 and not (found[j, 4] < s and s < found[j, 5]):
            remove_row(found, count - strays, j)
            strays += 1
        else:
            j += 1
    return strays


@kernel
def search(method, i, station, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh):
    """Minimum near station i, which lies lower than both neighbours: its s [m] and the number of evaluations of D.

    A simplex may leave its basin; then, and for method 1, the locus is searched between the neighbours.
    """
    evaluations = 0
    s = station[i]
    if method == 0:
        _, slope = height(wheel, w0, wh, s)
        seed = r0 * ahead(slope, e, f, d)[0]
        s, _, _, evaluations = simplex(s, seed, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        s = polish(s, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
    if method == 1 or not station[i - 1] <= s <= station[i + 1]:
        s = lowest_between(station[i - 1], station[i + 1], level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        s = polish(s, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        evaluations += SECTIONS + 2
    return s, evaluations


@kernel
def minima(
    method, pressed, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh, station, scan_y, scan_z, lowest, found
):
    """All contact points of one wheel pose within BARRIER_CAP of the deepest.

    method : 0 simplex on D from every basin of the scan along the locus; 1 the locus alone (its twin).
    pressed : 0 for rigid contact; else contact points are the places of greatest approach when the wheel is pressed
        in by this much beyond first touch [m].
    scan_y, scan_z : as `prepare_scan` fills them.  lowest : (n,) scratch.
    found : (k, 6) filled from the flange to the field side with s [m], D [m], the barriers towards flange and field
        side (how much D rises to the saddle; infinite where there is none), and the s of these saddles.
    Returns the number of minima (may exceed k: then the shallowest were left out) and of evaluations of D.
    """
    n = station.size
    level = np.inf
    deepest = scan(level, y, seat, rail, g0, gh, scan_y, scan_z, lowest)
    evaluations = n
    if pressed > 0.0:
        s, used = station[deepest], 0
        if 0 < deepest < n - 1:
            s, used = search(method, deepest, station, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        level = locus_gap(s, np.inf, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh) + pressed
        deepest = scan(level, y, seat, rail, g0, gh, scan_y, scan_z, lowest)
        evaluations += n + used
    best = lowest[deepest]
    capacity = found.shape[0]
    count = 0
    total = 0
    saddle_s, saddle = -np.inf, np.inf
    for i in range(1, n - 1):
        if lowest[i] >= lowest[i - 1] and lowest[i] > lowest[i + 1]:
            saddle_s, saddle = _crest(station, lowest, i)
            if count > 0 and not found[count - 1, 3] < np.inf:
                found[count - 1, 3], found[count - 1, 5] = saddle, saddle_s
        elif lowest[i] < lowest[i - 1] and lowest[i] <= lowest[i + 1]:
            if lowest[i] > best + BARRIER_CAP + 0.1e-3:
                continue
            s, used = search(method, i, station, level, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
            evaluations += used
            if count > 0 and abs(s - found[count - 1, 0]) < SAME_POINT:
                found[count - 1, 3] = np.inf
                continue
            total += 1
            _, value, _ = slope_difference(s, y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
            if count == capacity:
                count = drop_shallowest(found, count, value)
            if count == capacity:
                continue
            found[count, 0], found[count, 1] = s, value
            found[count, 2], found[count, 4] = saddle, saddle_s
            found[count, 3], found[count, 5] = np.inf, np.inf
            count += 1
    strays = drop_strays(found, count)
    count, total = count - strays, total - strays
    for j in range(count):
        _, value, slope = slope_difference(found[j, 0], y, e, f, d, r0, seat, wheel, w0, wh, rail, g0, gh)
        bottom = lean_gap(value, slope, level)
        upright = 1.0 if pressed == 0.0 else sqrt(1.0 + slope * slope)
        found[j, 2] = max(found[j, 2] - bottom, 0.0) * upright
        found[j, 3] = max(found[j, 3] - bottom, 0.0) * upright
    return total, evaluations
