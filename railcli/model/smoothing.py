"""Smoothing and resampling of profiles, and what they change.

A smoothing spline f through values g minimises sum w (g - f)^2 + lambda integral f''^2. With each point's weight w its
share of the arc length, the sum is the integral of (g - f)^2, whatever the spacing, and f'''' lambda + f = g: a wave of
length L keeps the share 1 / (1 + lambda (2 pi / L)^4). The cut-off wavelength C, of which half the amplitude remains,
is therefore given by lambda = (C / 2 pi)^4, and a wave of length L keeps 1 / (1 + (C / L)^4): 94 % at 2 C, 99.6 % at
4 C, 6 % at C / 2. An arc of radius R shrinks by the share (C / 2 pi R)^4.

Both coordinates are smoothed over arc length, so that steep faces are treated like flat ones, and tangents come from
the splines. Arc length is taken anew from the smoothed curve, for noise makes the measured one too long.
"""

import math

import numpy as np

from railcli.errors import InputError

from .profile import Profile

CUTOFF = (0.2e-3, 50e-3)  # allowed cut-off wavelengths [m]
RESAMPLE = (0.01e-3, 5e-3)  # allowed distances [m]
MOST_POINTS = 20_000
PASSES = 3
PINNED = 1e6  # weight factor of a corner, which stays in its place
FEWEST = 5  # points that a smoothing spline needs
WINDOW = 2e-3  # arc length over which curvature is averaged for comparison [m]


def smooth(name, kind, y, z, cutoff, corners=()):
    """The profile without waves shorter than about `cutoff`.

    Parameters
    ----------
    y, z : array (n,)
        Points [m], in order.
    cutoff : float
        Wavelength of which half the amplitude remains [m].
    corners : sequence of int
        Points that stay in place; what lies between them is smoothed on its own, so that edges remain edges.

    Returns
    -------
    Profile
        Nodes that belong to the given points one by one.
    """
    if not CUTOFF[0] <= cutoff <= CUTOFF[1]:
        low, high = (limit * 1e3 for limit in CUTOFF)
        raise InputError("--smooth", f"the wavelength is {cutoff * 1e3:g} mm; allowed: {low:g} to {high:g} mm")
    y, z = np.asarray(y, dtype=float), np.asarray(z, dtype=float)
    nodes = np.array([y, z, Profile.from_points(name, kind, y, z).angle])
    edges = [0, *corners, y.size - 1]
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        part = slice(first, last + 1)
        if last - first + 1 >= FEWEST:
            pinned = (first > 0, last < y.size - 1)
            nodes[:, part] = _smooth_part(y[part] * 1e3, z[part] * 1e3, cutoff * 1e3, pinned)
    for corner in corners:  # the tangent there is a compromise, as for all points of `Profile.from_points`
        around = slice(corner - 1, corner + 2)
        nodes[2, corner] = Profile.from_points(name, kind, *nodes[:2, around]).angle[1]
    return Profile(name, kind, *nodes)


def resample(profile, distance):
    """The profile with nodes at equal arc lengths, at most `distance` [m] apart."""
    if not RESAMPLE[0] <= distance <= RESAMPLE[1]:
        low, high = (limit * 1e3 for limit in RESAMPLE)
        raise InputError("--resample", f"the distance is {distance * 1e3:g} mm; allowed: {low:g} to {high:g} mm")
    count = math.ceil(profile.arc[-1] / distance - 1e-9) + 1
    if count > MOST_POINTS:
        raise InputError("--resample", f"{count} points; at most {MOST_POINTS} are allowed: choose a larger distance")
    y, z, angle, _ = profile.at(np.linspace(0.0, profile.arc[-1], count))
    return Profile(profile.name, profile.kind, y, z, np.unwrap(angle))


def change(before, after, part=None):
    """Largest change between two profiles whose nodes belong together.

    Parameters
    ----------
    before, after : Profile
    part : bool array (n,), optional
        Nodes to look at; all without it.

    Returns
    -------
    dict
        `position_mm`, across the curve, and `position_at_mm` (y, z); `curvature_per_m`, of the mean over 2 mm of arc,
        and `curvature_at_mm`.
    """
    across = (after.z - before.z) * np.cos(after.angle) - (after.y - before.y) * np.sin(after.angle)
    bent = mean_curvature(after, after.arc) - mean_curvature(before, before.arc)
    if part is not None:
        across, bent = np.where(part, across, 0.0), np.where(part, bent, 0.0)
    moved = int(np.argmax(np.abs(across)))
    most = int(np.argmax(np.abs(bent)))
    return {
        "position_mm": abs(float(across[moved])) * 1e3,
        "position_at_mm": [float(before.y[moved]) * 1e3, float(before.z[moved]) * 1e3],
        "curvature_per_m": abs(float(bent[most])),
        "curvature_at_mm": [float(before.y[most]) * 1e3, float(before.z[most]) * 1e3],
    }


def mean_curvature(profile, sigma, window=WINDOW):
    """Curvature at arc lengths `sigma` [m], averaged over `window` [m] of arc (shorter at the ends) [1/m]."""
    before = np.maximum(sigma - window / 2.0, 0.0)
    after = np.minimum(sigma + window / 2.0, profile.arc[-1])
    angle = np.unwrap(profile.angle)
    turn = (profile.at(after)[2] - np.interp(after, profile.arc, angle)) - (
        profile.at(before)[2] - np.interp(before, profile.arc, angle)
    )
    turn = np.remainder(turn + math.pi, 2.0 * math.pi) - math.pi
    return (turn + np.interp(after, profile.arc, angle) - np.interp(before, profile.arc, angle)) / (after - before)


def _smooth_part(y, z, cutoff, pinned):
    """Smoothed y, z [m] and tangent angle [rad] of a part without corners; lengths given in mm."""
    from scipy.interpolate import make_smoothing_spline

    factor = (cutoff / (2.0 * math.pi)) ** 4
    along_y, along_z = y, z
    for _ in range(PASSES):
        steps = np.hypot(np.diff(along_y), np.diff(along_z))
        s = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-3 * steps.mean()))])
        weight = np.gradient(s)
        weight[[0, -1]] /= 2.0
        sides = [_Side(s, cutoff, at_end, held) for at_end, held in zip((False, True), pinned, strict=True)]
        smooth = []
        for values in (y, z):
            (s_low, low, w_low), (s_high, high, w_high) = (side.beyond(s, values, weight) for side in sides)
            w = weight.copy()
            w[[0, -1]] *= [PINNED if held else 2.0 for held in pinned]
            smooth.append(
                make_smoothing_spline(
                    np.r_[s_low, s, s_high], np.r_[low, values, high], w=np.r_[w_low, w, w_high], lam=factor
                )
            )
        along_y, along_z = smooth[0](s), smooth[1](s)
    angle = np.unwrap(np.arctan2(smooth[1](s, 1), smooth[0](s, 1)))
    if pinned[0]:
        along_y[0], along_z[0] = y[0], z[0]
    if pinned[1]:
        along_y[-1], along_z[-1] = y[-1], z[-1]
    return np.array([along_y / 1e3, along_z / 1e3, angle])


class _Side:
    """Continuation beyond one end, for a spline's own end has no curvature: the points near it, mirrored about the
    parabola that fits them best."""

    def __init__(self, s, cutoff, at_end, held):
        self.end = s[-1] if at_end else s[0]
        distance = np.abs(s - self.end)
        near = min(max(int(np.count_nonzero(distance <= cutoff)), FEWEST), s.size - 1)
        self.pick = np.arange(1, near + 1) if not at_end else np.arange(s.size - 1 - near, s.size - 1)
        self.held = held

    def beyond(self, s, values, weight):
        """Arc lengths, values and weights of the points beyond the end; none at a corner, where the curve may bend."""
        if self.held:
            return np.zeros(0), np.zeros(0), np.zeros(0)
        u = s - self.end
        near = np.r_[self.pick, np.flatnonzero(u == 0.0)]
        parabola = np.polynomial.Polynomial.fit(u[near], values[near], 2)
        mirrored = -u[self.pick][::-1]
        rest = (values - parabola(u))[self.pick][::-1]
        return self.end + mirrored, parabola(mirrored) + rest, weight[self.pick][::-1]
