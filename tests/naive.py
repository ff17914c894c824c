"""Slow and obvious twins of the kernels."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipkm1

from railcli.kernels.layout import Kind


def hertz_displacement(a, b, peak, modulus, x, y):
    """Sum of both bodies' normal displacements [m] at (x, y) under half an ellipsoid of pressure.

    Each chord through the point carries a semi-ellipse of pressure, whose integral is exact; the sum over the
    directions of the chords is a trapezoid rule on a periodic function. modulus = E / (2 (1 - nu^2)) [Pa].
    """
    angle = np.linspace(0, np.pi, 4001)[:-1]
    c, s = np.cos(angle), np.sin(angle)
    square = (c / a) ** 2 + (s / b) ** 2
    mixed = x * c / a**2 + y * s / b**2
    height = 1 - (x / a) ** 2 - (y / b) ** 2 + mixed**2 / square
    chords = np.pi / 2 * height / np.sqrt(square)
    return peak / (np.pi * modulus) * np.pi * chords.mean()


def hertz_ellipse(along, across, young, poisson, normal):
    """Semi-axes and approach (a along x, b along y, delta) [m] by scipy's elliptic integrals and Brent's method."""
    low, high = sorted([along, across])
    modulus = young / (2 * (1 - poisson**2))

    def integrals(kappa):
        first, second = ellipkm1(kappa**2), ellipe(1 - kappa**2)
        return first, (first - second) / (1 - kappa**2), (second - kappa**2 * first) / (1 - kappa**2)

    def error(log_kappa):
        _, d, b = integrals(np.exp(log_kappa))
        return np.log(b / d) - 2 * log_kappa - np.log(high / low)

    kappa = np.exp(brentq(error, -20, -1e-4, xtol=1e-15))
    first, d, _ = integrals(kappa)
    long = (3 * normal * d / (2 * np.pi * modulus * low)) ** (1 / 3)
    approach = 3 * normal * first / (2 * np.pi * modulus * long)
    return (long, kappa * long, approach) if along <= across else (kappa * long, long, approach)


def kalker_coefficients(table, a_over_b, poisson):
    """C11, C22, C23, C33 from rows (a / b, nu = 0, 1/4, 1/2 of each): linear in min(a/b, b/a), parabola in 1 / C."""
    g = np.minimum(table[:, 0], 1 / table[:, 0])
    rows = table[table[:, 0] < 1 + 1e-9] if a_over_b <= 1 else table[table[:, 0] > 1 - 1e-9][::-1]
    g = np.minimum(rows[:, 0], 1 / rows[:, 0])
    at_g = np.array([np.interp(min(a_over_b, 1 / a_over_b), g, column) for column in rows[:, 1:].T]).reshape(4, 3)
    return [1 / np.polyval(np.polyfit([0, 0.25, 0.5], 1 / values, 2), poisson) for values in at_g]


def kalker_asymptotes(a_over_b, poisson):
    """Kalker's (1990, table E.3) C11, C22, C23 of slender ellipses; C33 by strips for a << b, None for a >> b."""
    nu, pi = poisson, np.pi
    if a_over_b < 1:
        g = a_over_b
        big = np.log(16 / g**2)
        return [
            pi**2 / (4 * (1 - nu)),
            pi**2 / 4,
            pi * np.sqrt(g) / (3 * (1 - nu)) * (1 + nu * (big / 2 + np.log(4) - 5)),
            pi**2 / (16 * (1 - nu) * g),
        ]
    g = 1 / a_over_b
    big = np.log(16 / g**2)
    return [
        2 * pi / ((big - 2 * nu) * g) * (1 + (3 - np.log(4)) / (big - 2 * nu)),
        2 * pi / g * (1 + (1 - nu) * (3 - np.log(4)) / ((1 - nu) * big + 2 * nu)) / ((1 - nu) * big + 2 * nu),
        2 * pi / (3 * g**1.5) / ((1 - nu) * big - 2 + 4 * nu),
        None,
    ]


def rolling_elements(a_over_b, poisson, across_x, across_y):
    """Half-spaces in steady rolling by boundary elements; the ellipse has the area pi.

    The ellipse is cut into across_x by across_y rectangles of constant traction on two elastic half-spaces. A particle
    that travels backwards by one element meets u(x) - u(x + dx) = creepage dx, with no traction ahead of the ellipse.

    Returns middles x, y (n,), area of an element, slip of all elements over their tractions (2n, 2n) and over the three
    creepages (2n, 3), for a shear modulus of 1.
    """
    a, b = np.sqrt(a_over_b), 1 / np.sqrt(a_over_b)
    dx, dy = 2 * a / across_x, 2 * b / across_y
    x = (np.arange(across_x) + 0.5) * dx - a
    y = (np.arange(across_y) + 0.5) * dy - b
    i, j = np.nonzero((x[:, None] / a) ** 2 + (y[None, :] / b) ** 2 < 1)
    x, y = x[i], y[j]

    def over_rectangle(integral):
        far_x, far_y = np.meshgrid(np.arange(-across_x, across_x + 2) * dx, np.arange(-across_y, across_y + 1) * dy)
        edges = [(s, t, s * t) for s in (1, -1) for t in (1, -1)]
        values = sum(sign * integral(far_x + s * dx / 2, far_y + t * dy / 2) for s, t, sign in edges).T
        step = values[:-1] - values[1:]
        return step[i[:, None] - i + across_x, j[:, None] - j + across_y]

    xx = over_rectangle(lambda p, q: q * np.arcsinh(p / np.abs(q)))  # x^2 / R^3, integrated over the rectangle
    yy = over_rectangle(lambda p, q: p * np.arcsinh(q / np.abs(p)))  # y^2 / R^3
    xy = over_rectangle(lambda p, q: -np.hypot(p, q))  # x y / R^3
    cerruti = np.block([[xx + (1 - poisson) * yy, poisson * xy], [poisson * xy, (1 - poisson) * xx + yy]]) / np.pi
    none, one = np.zeros_like(x), np.ones_like(x)
    creepage = dx * np.column_stack([np.r_[one, none], np.r_[none, one], np.r_[-y, x + dx / 2]])
    return x, y, dx * dy, cerruti, creepage


def linear_rolling(a_over_b, poisson, across_x, across_y):
    """C11, C22, C23, C33 by boundary elements: the linear theory of rolling itself, without slip."""
    x, y, area, cerruti, creepage = rolling_elements(a_over_b, poisson, across_x, across_y)
    px, py = np.split(np.linalg.solve(cerruti, creepage) * area, 2)
    fx, fy, mz = px.sum(0), py.sum(0), (x[:, None] * py - y[:, None] * px).sum(0)
    return [fx[0], fy[1], (fy[2] - mz[1]) / 2, mz[2]]


def rolling_with_slip(elements, a_over_b, creepage):
    """Tx, Ty, Mz on the wheel of `rolling_elements` under Hertz's pressure, mu N = 1: the full solution.

    Newton's method on all tractions at once. An element that adheres has no slip; one that slips has the bound, and a
    slip without part across its traction. One that pulls beyond the bound begins to slip; one whose slip goes along
    with its traction stops.
    """
    x, y, area, cerruti, over_creepage = elements
    n, rigid = x.size, over_creepage @ creepage
    bound = np.sqrt(np.maximum(1 - x**2 / a_over_b - y**2 * a_over_b, 1e-3))
    bound /= bound.sum() * area
    p, slips = np.linalg.solve(cerruti, -rigid), np.zeros(n, bool)
    for _ in range(50):
        size = np.hypot(*p.reshape(2, n))
        along = (p * (cerruti @ p + rigid)).reshape(2, n).sum(0)
        before, slips = slips, np.where(slips, along <= 0, size > bound * (1 + 1e-9))
        cut = np.where(slips | (size > bound), bound / size, 1.0)
        px, py = p.reshape(2, n) * cut
        p = np.r_[px, py]
        sx, sy = (cerruti @ p + rigid).reshape(2, n)
        across = (sx * py - sy * px) / bound
        off = np.where(slips, np.abs(across), np.hypot(sx, sy)).max()
        if (slips == before).all() and off < 1e-5 * np.abs(rigid).max():
            return np.array([px.sum(), py.sum(), (x * py - y * px).sum()]) * area
        matrix, right = cerruti.copy(), -np.r_[sx, sy]
        k = np.flatnonzero(slips)
        matrix[k] = (cerruti[k] * py[k, None] - cerruti[n + k] * px[k, None]) / bound[k, None]
        matrix[k, n + k] += sx[k] / bound[k]
        matrix[k, k] -= sy[k] / bound[k]
        matrix[n + k] = 0.0
        matrix[n + k, k], matrix[n + k, n + k] = px[k] / bound[k], py[k] / bound[k]
        right[k], right[n + k] = -across[k], 0.0
        change = np.linalg.solve(matrix, right)
        turn = np.hypot(*change.reshape(2, n)) / bound
        p = p + change * np.tile(np.where(slips, np.minimum(1.0, 0.8 / np.maximum(turn, 1e-12)), 1.0), 2)
    raise ArithmeticError(f"no full solution for {creepage}")


def creep_forces(smooth, linear, limit, creepage):
    """Tx, Ty, Mz from the matrix of the linear law, one factor for all, by Shen's cubic or cut off at the limit."""
    force = -linear @ creepage
    size = np.hypot(force[0], force[1])
    if size == 0:
        return force
    u = size / limit
    if smooth:
        allowed = limit * (u - u**2 / 3 + u**3 / 27) if u < 3 else limit
    else:
        allowed = min(size, limit)
    return force * allowed / size


def polach_forces(k_a, k_s, a, b, f, limit, creepage):
    """Tx, Ty, Mz of Polach (1999, 2005), with the moment that takes from f33 and f23 what spin loses of its force."""
    f11, f22, f23, f33 = f
    xi, eta, phi = creepage
    edge = eta + phi * a
    far = edge if abs(edge) > abs(eta) else eta
    slip, total = np.hypot(xi, eta), np.hypot(xi, far)
    e = np.pi / 4 * np.hypot(f11 * xi, f22 * eta) / slip * total / limit
    force = 2 * limit / np.pi * (k_a * e / (1 + (k_a * e) ** 2) + np.arctan(k_s * e))
    wide = 1 + 6.3 * (1 - np.exp(-a / b))
    e_s = abs(8 / 3 * f23 / a / limit * far / wide)
    d = (e_s**2 - 1) / (e_s**2 + 1)
    k_m = e_s * (d**3 / 3 - d**2 / 2 + 1 / 6) - np.sqrt((1 - d**2) ** 3) / 3
    spin = 9 / 16 * a * limit * k_m * wide * phi / total
    left = -spin / (f23 * phi) if phi else 0.0
    return np.array([-force * xi / total, -force * eta / total + spin, left * (f23 * eta - f33 * phi)])


def fastsim_forces(n, a, b, f, limit, creepage):
    """Tx, Ty, Mz of Kalker (1982) in SI units, n strips of n elements; the bound is its mean over an element."""
    f11, f22, f23, _ = f
    xi, eta, phi = creepage
    flexible = 8 * a**2 * b / 3 / np.array([f11, f22]), np.pi * a**3 * b / 4 / f23  # L1, L2; L3 [m/Pa]
    y = -b + (np.arange(n) + 0.5) * 2 * b / n
    edge = a * np.sqrt(1 - (y / b) ** 2)
    dx = 2 * edge / n
    pressure = 2 * limit / (np.pi * a * b)
    p, found = np.zeros((2, n)), np.zeros(3)
    for j in range(n):
        ahead, x = (edge, edge - dx / 2) if j == 0 else (edge - (j - 0.5) * dx, edge - (j + 0.5) * dx)
        middle = (ahead + x) / 2
        turn_x, turn_y = -phi * y / flexible[1], phi * middle / flexible[1]
        slope = np.array([xi / flexible[0][0] + turn_x, eta / flexible[0][1] + turn_y])
        p = p - slope * (ahead - x)
        bound = pressure * (1 - (y / b) ** 2 - (x**2 + dx**2 / 12) / a**2)
        size = np.hypot(*p)
        p = np.where(size > bound, p * bound / np.where(size > 0, size, 1), p)
        found += np.sum(np.array([p[0], p[1], x * p[1] - y * p[0]]) * dx * 2 * b / n, axis=1)
    return found


# --- Track and bodies, from their definitions ---


SHARES = {  # of a transition over the share x of its length, and their integrals
    "clothoid": (lambda x: x, lambda x: x**2 / 2),
    "bloss": (lambda x: 3 * x**2 - 2 * x**3, lambda x: x**3 - x**4 / 2),
    "helmert": (
        lambda x: np.where(x < 0.5, 2 * x**2, 1 - 2 * (1 - x) ** 2),
        lambda x: np.where(x < 0.5, 2 * x**3 / 3, x + 2 * (1 - x) ** 3 / 3 - 0.5),
    ),
    "cosine": (lambda x: (1 - np.cos(np.pi * x)) / 2, lambda x: x / 2 - np.sin(np.pi * x) / (2 * np.pi)),
    "sine": (
        lambda x: x - np.sin(2 * np.pi * x) / (2 * np.pi),
        lambda x: x**2 / 2 + (np.cos(2 * np.pi * x) - 1) / (4 * np.pi**2),
    ),
}


def slope_angle(gradients, s):
    """Angle of the rising track: arcs of circles around the places where the gradient changes."""
    angle = 0.0
    for one in gradients:
        after = np.arctan(one.gradient)
        if one.at == 0.0:
            angle = after
            continue
        half = one.radius * abs(after - angle) / 2
        if s < one.at - half:
            return angle
        if s < one.at + half:
            return angle + np.sign(after - angle) * (s - one.at + half) / one.radius
        angle = after
    return angle


def bends(gradients):
    """Where vertical curves begin and end."""
    found, angle = [], 0.0
    for one in gradients:
        after = np.arctan(one.gradient)
        if one.at > 0.0:
            half = one.radius * abs(after - angle) / 2
            found += [one.at - half, one.at + half]
        angle = after
    return np.array(found)


def track_course(track, s, gradients=()):
    """Heading, place (x, y, z) of the line, curvature and cant at one s >= 0, by integrating the sections one by one.

    cant is the height of the left over the right rail.
    """
    nodes, weights = np.polynomial.legendre.leggauss(24)
    heading, place, start = 0.0, np.zeros(3), 0.0
    sections = track.sections
    for i, section in enumerate(sections):
        if section.kind == "transition":
            one, two = sections[i - 1], sections[i + 1]
            share, turned = SHARES[section.shape]
        else:
            one, two, share, turned = section, section, np.zeros_like, np.zeros_like
        change = two.curvature - one.curvature
        length = section.length
        end = s if i == len(sections) - 1 else min(start + length, s)
        cuts = np.append(np.linspace(start, end, 9), start + length / 2)
        cuts = np.sort(np.concatenate([cuts, bends(gradients)]))
        cuts = cuts[(cuts >= start) & (cuts <= end)]

        def direction(u, one=one, change=change, length=length, turned=turned, heading=heading):
            return heading + one.curvature * u + change * length * turned(u / length)

        for low, high in zip(cuts, cuts[1:], strict=False):
            at = (low + high) / 2 + (high - low) / 2 * nodes
            rise, way = np.array([slope_angle(gradients, x) for x in at]), direction(at - start)
            tangent = np.array([np.cos(rise) * np.cos(way), np.cos(rise) * np.sin(way), -np.sin(rise)])
            place = place + (high - low) / 2 * tangent @ weights
        heading = float(direction(end - start))
        if end >= s:
            x = (s - start) / length
            cant = one.signed_cant + (two.signed_cant - one.signed_cant) * share(x)
            return heading, place, one.curvature + change * share(x), cant
        start += length
    raise ValueError("beyond the track")


LIFT = {"centre": 0.0, "inner": 0.5, "outer": -0.5}


def track_pose(track, s, cant_base, gradients=(), pivot="centre"):
    """Origin and axes (columns) of the track frame: turned by heading about z, gradient about y, cant about x."""
    heading, place, _, cant = track_course(track, s, gradients)
    angles = [heading, slope_angle(gradients, s), np.arcsin(cant / cant_base)]
    axes = Rotation.from_euler("ZYX", angles).as_matrix()
    return place - [0.0, 0.0, LIFT[pivot] * abs(cant)], axes


def body_pose(track, q, cant_base, gradients=(), pivot="centre"):
    """Centre and axes of a body in ground axes; yaw, roll, pitch turn it in this order, each about its newest axis."""
    origin, axes = track_pose(track, q[0], cant_base, gradients, pivot)
    own = Rotation.from_euler("ZXY", [q[5], q[3], q[4]]).as_matrix()
    return origin + axes @ np.array([0.0, q[1], q[2]]), axes @ own


# --- Force elements: the energy that their springs hold ---


def curve_energy(curve, x):
    """Integral from 0 to x of a piecewise linear force, continued along its last slopes."""
    count = curve["count"]
    xs, ys = curve["x"][:count], curve["y"][:count]
    inner = xs[1:-1][(xs[1:-1] > min(0.0, x)) & (xs[1:-1] < max(0.0, x))]
    points = np.sort(np.concatenate([[0.0, x], inner]))
    slopes = np.diff(ys) / np.diff(xs)
    piece = np.clip(np.searchsorted(xs, (points[1:] + points[:-1]) / 2) - 1, 0, count - 2)
    middle = ys[piece] + slopes[piece] * ((points[1:] + points[:-1]) / 2 - xs[piece])
    return np.sign(x) * np.sum(middle * np.diff(points))


def series_energy(element, length, x):
    """Of a spring whose far end stands at x, and of the one that may stand beside its damper."""
    return 0.5 * element["series"] * (length - x) ** 2 + 0.5 * element["reservoir"] * x**2


def turn_energy(turn, lower, upper, spins):
    """Of rotational stiffness: twice the sine of half the angle ; on a wheelset the slope of its axle."""
    if not any(spins):
        relative = Rotation.from_matrix(lower.T @ upper)
        return 0.5 * np.sum(turn * (2 * relative.as_quat()[:3]) ** 2)
    wheelset, other = (lower, upper) if spins[0] else (upper, lower)
    along, _, down = other.T @ wheelset[:, 1]
    return 0.5 * (turn[2] * along**2 + turn[0] * down**2)


def joint_energy(model, j, lower, upper, damper):
    """Energy of joint j; lower, upper : (position, axes) of its bodies.

    Bushings stretch along the axes of the upper body or along those halfway between the bodies (half the rotation
    vector); rotations count as twice the vector of their quaternion.
    """
    joint = model.joint[j]
    relative = Rotation.from_matrix(lower[1].T @ upper[1])
    half = Rotation.from_rotvec(relative.as_rotvec() / 2).as_matrix()
    frame = lower[1] @ half if joint["axes"] == 0 else upper[1]
    spins = [model.body[joint[end]]["spins"] for end in ("lower", "upper")]
    turned = 2 * relative.as_quat()[:3]
    energy = turn_energy(joint["turn"], lower[1], upper[1], spins)
    for element in model.element[joint["first"] : joint["first"] + joint["count"]]:
        kind = Kind(element["kind"])
        if kind == Kind.TORQUE:
            if not any(spins):
                angle = element["lower"] @ turned
                energy += 0.5 * element["k"][0] * angle**2
                if element["spring_curve"][0] >= 0:
                    energy += curve_energy(model.curve[element["spring_curve"][0]], angle)
            continue
        gap = upper[0] + upper[1] @ element["upper"] - lower[0] - lower[1] @ element["lower"]
        if kind == Kind.LINK:
            stretch = np.linalg.norm(gap) - element["length"]
            energy += 0.5 * element["k"][0] * stretch**2 + element["preload"][0] * stretch
            if element["spring_curve"][0] >= 0:
                energy += curve_energy(model.curve[element["spring_curve"][0]], stretch)
            if element["state"] >= 0:
                energy += series_energy(element, np.linalg.norm(gap), damper[element["state"]])
            continue
        d = frame.T @ gap
        energy -= element["preload"] @ d
        if kind == Kind.MATRIX:
            x = np.concatenate([d, turned])
            energy += 0.5 * x @ model.matrix[element["matrix"]][:6] @ x
            continue
        assert kind in (Kind.BUSHING, Kind.AIR)
        energy += np.sum(0.5 * element["k"] * d**2)
        curves = zip(element["spring_curve"], d, strict=True)
        energy += sum(curve_energy(model.curve[i], x) for i, x in curves if i >= 0)
        if kind == Kind.AIR:
            energy += series_energy(element, d[2], damper[element["state"]])
    return energy


def friction(ends, start, series, limit):
    """Forces (n, m) of a series spring on a rubbing end, led through places (n, m).

    The rubbing end goes where the energy of the spring and the work of sliding from where it was are least.
    """
    x, forces = np.array(start, float), []
    for end in ends:
        unit = limit / series

        def cost(moved, x=x, end=end, unit=unit):
            stretch = (end - x) / unit - moved
            return 0.5 * stretch @ stretch + np.linalg.norm(moved)

        pull = (end - x) / unit
        found = minimize(cost, 0.9 * pull + 1e-3, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-14})
        still = np.zeros_like(pull)
        x = x + unit * (found.x if cost(found.x) < cost(still) else still)
        forces.append(series * (end - x))
    return np.array(forces)


def series_tension(lengths, start, series, rates, forces, step):
    """Tension of a damper table behind a spring, led through lengths: x from one to the next by backward Euler."""

    def table(rate):
        slopes = np.diff(forces) / np.diff(rates)
        piece = np.clip(np.searchsorted(rates, rate) - 1, 0, slopes.size - 1)
        return forces[piece] + slopes[piece] * (rate - rates[piece])

    x, tensions = start, []
    for length in lengths:

        def gap(rate, x=x, to=length):
            return table(rate) - series * (to - x - step * rate)

        x += step * brentq(gap, -1e3, 1e3, xtol=1e-15, rtol=1e-14)
        tensions.append(series * (length - x))
    return np.array(tensions)


def leaf_spring(way, upper, lower, decay):
    """Force against deflection of a leaf spring led through deflections, from 0 and no force; envelopes (x, force)."""
    place, force, forces = 0.0, 0.0, []
    for to in way:
        x, y = upper if to > place else lower
        sign = 1.0 if to > place else -1.0
        knots = [knot for knot in x if min(place, to) < knot < max(place, to)]
        for stop in [*sorted(knots, reverse=sign < 0), to]:

            def slope(at, f, x=x, y=y, sign=sign):
                return sign * (np.interp(at, x, y) - f) / decay

            force = solve_ivp(slope, (place, stop), [force], rtol=1e-11, atol=1e-8).y[0, -1]
            place = stop
        forces.append(force)
    return np.array(forces)


def dry_energy(system, data):
    """Energy of two free bodies [J] where `evaluate` saw them: motion, springs, series springs, leaf springs.

    Of a leaf spring it is what can be had back at most. Between lines k d +- B, with f the force beside k d, the decay
    b and B' = B - b k, that is the integral of f b / (B' + |f|), which the way back to f = 0 gives.
    """
    model = system.model
    energy = 0.5 * np.sum(model.body["mass"][:, None] * data.v[:, :3] ** 2)
    energy += 0.5 * np.sum(model.body["inertia"] * data.v[:, 3:] ** 2)
    (low, axes_a), (up, axes_b) = zip(data.frame["position"], data.frame["axes"], strict=True)
    relative = Rotation.from_matrix(axes_a.T @ axes_b)
    frame = axes_a @ Rotation.from_rotvec(relative.as_rotvec() / 2).as_matrix()
    energy += 0.5 * np.sum(model.joint[0]["turn"] * (2 * relative.as_quat()[:3]) ** 2)
    for element in model.element:
        gap = up + axes_b @ element["upper"] - low - axes_a @ element["lower"]
        d, state = frame.T @ gap, element["state"]
        if element["kind"] == Kind.BUSHING:
            energy += np.sum(0.5 * element["k"] * d**2 - element["preload"] * d)
        elif element["kind"] == Kind.DRY:
            kept = np.flatnonzero(element["k"])
            energy += 0.5 * element["series"] * np.sum((d[kept] - data.damper[state : state + kept.size]) ** 2)
        elif element["kind"] == Kind.LEAF:
            lines = model.curve[element["spring_curve"][:2]]
            k = (lines[0]["y"][1] - lines[0]["y"][0]) / (lines[0]["x"][1] - lines[0]["x"][0])
            band = lines[0]["y"][0] - k * lines[0]["x"][0] - element["decay"] * k
            f = abs(data.damper[state + 1] - k * data.damper[state])
            energy += 0.5 * k * d[2] ** 2 + element["decay"] * (f - band * np.log1p(f / band))
        else:
            energy += 0.5 * element["series"] * (np.linalg.norm(gap) - data.damper[state]) ** 2
    return energy


# --- Wheel on rail: the difference surface on a dense grid ---


def difference_minima(wheel, rail, settings, pose, near=0.5e-3):
    """Rows (s, D) of the minima of the difference surface within `near` of the deepest, from flange to field side.

    The wheel is the set of points whose distance from the axle is that of the profile; D is rail z less wheel z over a
    grid in x and y, first coarse, then fine about each minimum.
    """
    y, roll, yaw = pose
    axle = Rotation.from_euler("ZX", [yaw, roll]).apply([0.0, 1.0, 0.0])
    down = Rotation.from_euler("ZX", [yaw, roll]).apply([0.0, 0.0, 1.0])
    turn = np.arctan(1.0 / settings.inclination) if settings.inclination else 0.0
    rail_y, rail_z, angle, _ = rail.at(np.linspace(0.0, rail.arc[-1], 60001))
    rail_y, rail_z = np.cos(turn) * rail_y + np.sin(turn) * rail_z, np.cos(turn) * rail_z - np.sin(turn) * rail_y
    rail_z = rail_z - rail_z.min()
    face = np.argmax(rail_z < 0.014) + np.array([0, -1])
    innermost = min(np.interp(0.014, rail_z[face], rail_y[face]), rail_y[rail_z < 0.014].min())
    rail_y = rail_y + settings.gauge / 2.0 - innermost
    good = np.abs(angle - turn) < np.radians(80.0)
    rail_y, rail_z = rail_y[good], rail_z[good]
    wheel_s, wheel_z, angle, _ = wheel.at(np.linspace(0.0, wheel.arc[-1], 60001))
    good = np.abs(angle) < np.radians(80.0)
    wheel_s, wheel_z = wheel_s[good], wheel_z[good]
    lateral = settings.flange_back / 2.0 + settings.tape_to_back
    foot = np.array([0.0, lateral + y, 0.0])
    centre = foot - settings.radius * down

    def surface(across, along):
        """D and s over a grid."""
        x, at = np.meshgrid(along, across)
        z = np.zeros_like(x)
        for _ in range(60):
            to = np.stack([x, at, z], axis=-1) - centre
            s = to @ axle
            wanted = settings.radius + np.interp(s, wheel_s, wheel_z, -np.inf, -np.inf)
            out = np.sqrt(np.maximum(np.sum(to**2, axis=-1) - s**2, 0.0))
            step = np.clip(wanted - out, -0.02, 0.02)
            z = z + 0.8 * step
        value = np.interp(at, rail_y, rail_z, np.inf, np.inf) - z
        return np.where(np.isfinite(value) & (np.abs(step) < 1e-12), value, np.inf), s

    def profile_of(across, along):
        value, s = surface(across, along)
        best = np.argmin(value, axis=1)
        rows = np.arange(across.size)
        return value[rows, best], s[rows, best], along[best]

    across = np.arange(lateral - 0.05, lateral + 0.05, 0.05e-3)
    value, _, where = profile_of(across, np.arange(-30e-3, 30.01e-3, 0.5e-3))
    inner = np.arange(1, across.size - 1)
    low = inner[(value[inner] < value[inner - 1]) & (value[inner] <= value[inner + 1]) & np.isfinite(value[inner + 1])]
    rows = []
    for i in low[value[low] < value[low].min() + near]:
        y0, x0 = across[i], where[i]
        for reach in (60e-6, 6e-6):
            ys, xs = y0 + np.linspace(-reach, reach, 41), x0 + np.linspace(-20 * reach, 20 * reach, 41)
            value_here, s_here, x_here = profile_of(ys, xs)
            k = np.argmin(value_here)
            y0, x0 = ys[k], x_here[k]
        rows.append((s_here[k], value_here[k]))
    return np.array(rows)


def cone_on_circle(pose, angle, r0, head):
    """s, D, contact angle, radius where a cone lies on a circular rail whose crown is the origin.

    The cone's tangent plane at its contact has a normal n with n . e = sin(angle) and no part along the rail; it
    passes at r0 cos(angle) from the point of the axle over the tape circle, and at the rail's radius from its centre.
    """
    y, roll, yaw = pose
    e = np.array([-np.sin(yaw) * np.cos(roll), np.cos(yaw) * np.cos(roll), np.sin(roll)])
    down = np.array([np.sin(yaw) * np.sin(roll), -np.cos(yaw) * np.sin(roll), np.cos(roll)])
    lean = np.arctan2(e[2], e[1]) - np.arcsin(np.sin(angle) / np.hypot(e[1], e[2]))
    n = np.array([0.0, -np.sin(lean), np.cos(lean)])
    axle = np.array([0.0, y, 0.0]) - r0 * down
    gap = (n @ (np.array([0.0, 0.0, head]) - axle) - head - r0 * np.cos(angle)) / n[2]
    radial = (n - np.sin(angle) * e) / np.cos(angle)
    s = (head * np.sin(lean) - axle[1] - r0 * radial[1]) / (e[1] - np.tan(angle) * radial[1])
    return s, gap, -lean, r0 - s * np.tan(angle)


def pull_of_rectangles(hx, hy, nx, ny, young, poisson):
    """Approach of two bodies at every element of a grid under unit pressure on the one in the middle: Love (1929)."""
    x, y = np.meshgrid(np.arange(1 - nx, nx) * hx, np.arange(1 - ny, ny) * hy, indexing="ij")

    def corner(a, b):
        return a * np.log(b + np.hypot(a, b)) + b * np.log(a + np.hypot(a, b))

    ends = [(corner(x + i * hx / 2, y + j * hy / 2), i * j) for i in (-1, 1) for j in (-1, 1)]
    return 2.0 * (1.0 - poisson**2) / (np.pi * young) * sum(value * sign for value, sign in ends)


def pressures(overlap, hx, hy, young, poisson):
    """Pressures [Pa] of elastic half spaces on a grid of rectangles hx by hy: overlap [m] taken up where they touch.

    Boundary elements: solve on those that overlap, let go those that would pull, repeat.
    """
    nx, ny = overlap.shape
    pull = pull_of_rectangles(hx, hy, nx, ny, young, poisson)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    touches = overlap.ravel() > 0.0
    found = np.zeros(overlap.size)
    while True:
        k = np.flatnonzero(touches)
        matrix = pull[i[k][:, None] - i[k] + nx - 1, j[k][:, None] - j[k] + ny - 1]
        pressure = np.linalg.solve(matrix, overlap.ravel()[k])
        if (pressure >= 0.0).all():
            found[k] = pressure
            return found.reshape(overlap.shape)
        touches[k[pressure < 0.0]] = False


def low_gain(frequency, corner, rate=100.0):
    """Both runs of the bilinear Butterworth filter: 1 / (1 + (sqrt 2 - 1) (w / wc)^4), w = tan(pi f / rate)."""
    ratio = np.tan(np.pi * frequency / rate) / np.tan(np.pi * corner / rate)
    return 1.0 / (1.0 + (np.sqrt(2.0) - 1.0) * ratio**4)


def high_gain(frequency, corner, rate=100.0):
    """Likewise of the high-pass."""
    ratio = np.tan(np.pi * corner / rate) / np.tan(np.pi * frequency / rate)
    return 1.0 / (1.0 + (np.sqrt(2.0) - 1.0) * ratio**4)
