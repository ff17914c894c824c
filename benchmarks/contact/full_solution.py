"""Normal contact of a wheel on a rail as two half spaces, solved on elements: slow, exact, apart from every law.

    python benchmarks/contact/full_solution.py [states | a22 | planar | finer]

`states` writes reference/normal.csv (see SOURCES.md), `a22` compares with the published states of the benchmark,
`planar` lays the half spaces on one plane instead of along the profile, `finer` takes smaller elements.

Elements are rectangles dx by du: x along the rail, u the arc of the rail's profile. An element's undeformed distance is
that of the true surfaces along the rail's normal there, the wheel a body of revolution, rolled and yawed. Uniform
pressure on an element moves the others by Boussinesq's and Love's closed form (Johnson, Contact Mechanics, 3.2.6),
along their own normals: times n_i . n_j. The pressures are the non-negative ones that leave no overlap, by conjugate
gradients (Polonsky and Keer, Wear 231 (1999), 206-219). Lengths in m, pressures in Pa, forces in N, angles in rad.
Lateral axis to the field side, z down.
"""

import csv
import math
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, rfft
from scipy.interpolate import CubicHermiteSpline

COARSE = 0.25e-3, 0.5e-3  # elements du, dx of the first look [m]
ACROSS, ALONG = 40, 60  # elements over a patch
MARGIN = 0.12  # of a patch's width that its fine elements reach beyond it
APART = 8e-3  # from which patches do not feel each other in `a22`; CONTACT's default [m]
WIDEST = 0.15e-3  # element du outside the patches [m]
GROWTH = 0.3  # of the width from one strip to the next, at most
STEEPEST = 4.0  # slope of the rail up to which it has elements
DEEPER = 20e-6  # than the wheel is thought to be, that overlaps are looked for [m]
PRECISION = 1e-7  # of the pressures' sum in an iteration
LOAD = 1e-5  # relative accuracy of the vertical force
COLUMNS = {  # of reference/normal.csv: name -> factor from SI and decimals
    "y_mm": (1e3, 3), "yaw_mrad": (1e3, 3), "roll_mrad": (1e3, 6), "load_kN": (1e-3, 0), "touch_um": (1e6, 3),
    "sink_um": (1e6, 3), "normal_N": (1.0, 1), "pmax_MPa": (1e-6, 2), "area_mm2": (1e6, 3), "rail_mm": (1e3, 4),
    "wheel_mm": (1e3, 4), "patches": (1, 0), "share": (1, 4),
}  # fmt: skip


def love(x, u, dx, du):
    """Integral of 1 / r over a rectangle dx by du, seen from (x, u) against its middle [m]."""
    near, far, left, right = x + 0.5 * dx, x - 0.5 * dx, u + 0.5 * du, u - 0.5 * du

    def part(a, b, c):
        return a * np.log((b + np.hypot(a, b)) / (c + np.hypot(a, c)))

    return part(near, left, right) + part(right, far, near) + part(far, right, left) + part(left, near, far)


class HalfSpaces:
    """Rectangles in rows along x, their strips of any width across.

    Parameters
    ----------
    count : int
        Elements along x.
    dx : float
    u, du : array (n,)
        Place and width of the strips.
    modulus : float
        E / (2 (1 - nu^2)) of two equal bodies [Pa].
    lean : array (n, 2), optional
        Unit normal of every strip.
    reach : float, optional
        Distance from which strips do not feel each other [m].
    """

    def __init__(self, count, dx, u, du, modulus, lean=None, reach=math.inf):
        self.shape, self.dx, self.du = (count, u.size), dx, du
        away, apart = np.arange(count + 1)[:, None, None] * dx, np.abs(u[:, None] - u)
        pull = love(away, apart[None], dx, du[None, None, :]) / du
        pull = 0.5 * (pull + pull.transpose(0, 2, 1))  # of unit line load, mutual: exact for strips of one width
        factor = 1.0 if lean is None else lean @ lean.T
        pull *= factor * (apart < reach) / (math.pi * modulus)
        self._spectrum = rfft(np.concatenate([pull, pull[-2:0:-1]]), axis=0).real

    def give(self, p):
        """Displacements of both bodies together under pressures p (count, n)."""
        load = rfft(p * self.du, n=2 * self.shape[0], axis=0)
        moved = np.matmul(self._spectrum, load[:, :, None])[:, :, 0]
        return irfft(moved, n=2 * self.shape[0], axis=0)[: self.shape[0]]

    def solve(self, h, start=None, most=2000):
        """Pressures (count, n) >= 0 that take away the overlap h, and none where that leaves a gap."""
        p = np.where(h > 0.0, 1.0, 0.0) if start is None else start.copy()
        if start is None:
            moved = self.give(p)
            p *= np.sum(h * p * self.du) / np.sum(moved * p * self.du)
        way, last, kept = np.zeros_like(p), 1.0, 0.0
        for _ in range(most):
            gap = self.give(p) - h
            bears = p > 0.0
            square = np.sum(self.du * np.where(bears, gap, 0.0) ** 2)
            way = np.where(bears, gap + kept * square / last * way, 0.0)
            last = square
            turn = self.give(way)
            step = np.sum(self.du * gap * way) / np.sum(self.du * turn * way)
            after = np.maximum(p - step * way, 0.0)
            joins = (after == 0.0) & (gap < 0.0)
            kept = 0.0 if joins.any() else 1.0
            after[joins] = -step * gap[joins]
            changed = np.sum(self.du * np.abs(after - p))
            p = after
            if changed < PRECISION * np.sum(self.du * p):
                return p
        raise ArithmeticError("pressures do not settle")


class Found(NamedTuple):
    """The contact of one state.

    height : of the wheel's reference point.  vertical, normal : forces.  pressure : the largest.  rail, wheel : centre
    of the load, lateral coordinates from the rail's highest point and the tape circle.  patches : runs of strips under
    load.  share : of the heaviest patch in the normal force.  overlap : the greatest, of the undeformed surfaces.
    """

    height: float
    vertical: float
    normal: float
    pressure: float
    area: float
    rail: float
    wheel: float
    patches: int
    share: float
    overlap: float


class Profiles:
    """A right-hand wheel over a rail, as `railcli.model.contact_table.Mounting` describes them."""

    def __init__(self, mounting):
        def spline(table, start, step):
            place = start + step * np.arange(table.shape[0])
            return CubicHermiteSpline(place, table[:, 0], table[:, 1], extrapolate=True)

        self.radius, self.seat = mounting.radius, mounting.seat
        self.wheel = spline(mounting.wheel, mounting.wheel_start, mounting.wheel_step)
        self.rail = spline(mounting.rail, mounting.rail_start, mounting.rail_step)
        self.lean, self.rail_lean = self.wheel.derivative(), self.rail.derivative()
        ends = mounting.rail_start, mounting.rail_start + mounting.rail_step * (mounting.rail.shape[0] - 1)
        eta = np.linspace(*ends, 40_001)
        slope = self.rail_lean(eta)
        usable = np.flatnonzero(np.abs(slope) < STEEPEST)
        eta = eta[usable[0] : usable[-1] + 1]
        tall = np.hypot(1.0, self.rail_lean(eta))
        self._eta, self._arc = eta, np.r_[0.0, np.cumsum(0.5 * (tall[1:] + tall[:-1]) * np.diff(eta))]
        self.length = self._arc[-1]
        self._low, self._high = self.wheel.x[0], self.wheel.x[-1]

    def station(self, u):
        """Lateral coordinate of the rail at arc u."""
        return np.interp(u, self._arc, self._eta)

    def distance(self, pose, height, x, eta, lean=None):
        """Distance of the wheel from the rail at (x, eta), negative where they overlap, and its profile coordinate.

        pose : (y, roll, yaw).  x : (m,).  eta : (n,).  Along the rail's own normals, or along `lean` (n, 2): unit
        vectors in the lateral plane that point down into the rail.
        """
        y, roll, yaw = pose
        sr, cr, sy, cy = math.sin(roll), math.cos(roll), math.sin(yaw), math.cos(yaw)
        axle, down = np.array([-sy * cr, cy * cr, sr]), np.array([sy * sr, -cy * sr, cr])
        centre = np.array([0.0, y + self.seat, height]) - self.radius * down
        lean = self.normals(eta) if lean is None else lean
        at = np.empty((x.size, eta.size, 3))
        at[..., 0], at[..., 1], at[..., 2] = x[:, None], eta, self.rail(eta)
        at -= centre
        way = np.stack([np.zeros(eta.size), -lean[:, 0], -lean[:, 1]], axis=-1)
        t = np.zeros((x.size, eta.size))
        for _ in range(60):
            here = at + t[..., None] * way
            s = here @ axle
            out = here - s[..., None] * axle
            reach = np.sqrt(np.sum(out * out, axis=-1))
            inside = np.clip(s, self._low, self._high)
            slope = self.lean(inside)
            missing = reach - self.radius - self.wheel(inside) - slope * (s - inside)
            rate = np.sum(out * way, axis=-1) / reach - slope * (way @ axle)
            change = np.clip(-missing / np.minimum(rate, -0.05), -2e-3, 2e-3)
            t += change
            if np.abs(change).max() < 1e-12:
                break
        return t, s

    def normals(self, eta):
        """Unit vectors (lateral, down) into the rail."""
        slope = self.rail_lean(eta)
        return np.stack([-slope, np.ones_like(slope)], axis=-1) / np.hypot(1.0, slope)[:, None]


class Contact:
    """Solutions of one pose.

    Parameters
    ----------
    profiles : Profiles
    modulus : float
        E / (2 (1 - nu^2)).
    pose : tuple
        y of the reference point about nominal, roll, yaw (both of a right-hand wheel).
    planar : bool
        One contact plane for all: every pressure along one normal, the mean over the overlap, places projected on the
        plane. Else the profile unrolled, each strip with its own normal.
    reach : float
        As `HalfSpaces`.
    fine : float
        Factor on the number of elements.
    element : float, optional
        Squares of this size instead of elements fitted to the patches.
    """

    def __init__(self, profiles, modulus, pose, planar=False, reach=math.inf, fine=1.0, element=None):
        self.profiles, self.modulus, self.pose = profiles, modulus, pose
        self.planar, self.reach, self.fine, self.element = planar, reach, fine, element
        self._eta, self._x = profiles.station(np.arange(0.0, profiles.length, COARSE[0])), np.zeros(0)
        self.touch = self._touch()

    def _touch(self):
        """Height of the reference point at first touch: where the smallest distance is zero."""
        eta, x = self._eta, np.linspace(-30e-3, 30e-3, 121)
        height, width = 0.0, (x[1] - x[0], 2.0 * COARSE[0])
        for turn in range(40):
            t, _ = self.profiles.distance(self.pose, height, x, eta)
            i, j = np.unravel_index(np.argmin(t), t.shape)
            move = t[i, j] / self.profiles.normals(eta[j : j + 1])[0, 1]
            height += move
            if turn > 2:
                x = x[i] + np.linspace(-width[0], width[0], 21)
                eta = eta[j] + np.linspace(-width[1], width[1], 21)
                width = 0.4 * width[0], 0.4 * width[1]
            if turn > 2 and abs(move) < 1e-11 and width[0] < 2e-5:
                break
        return height

    def _mesh(self, edges, x, height):
        """Half spaces on strips between edges (arc of the rail) and x; height: about that of the wheel."""
        mesh = Mesh()
        mesh.height = height
        mesh.u = 0.5 * (edges[1:] + edges[:-1])
        mesh.eta, mesh.x = self.profiles.station(mesh.u), x
        mesh.lean = self.profiles.normals(mesh.eta)
        mesh.du, place = np.diff(edges), mesh.u
        if self.planar:
            mesh.lean, mesh.du, place = self._plane(edges, mesh)
        mesh.half_spaces = HalfSpaces(
            x.size, x[1] - x[0], place, mesh.du, self.modulus, None if self.planar else mesh.lean, self.reach
        )  # fmt: skip
        return mesh

    def _plane(self, edges, mesh):
        over = np.maximum(-self.profiles.distance(self.pose, mesh.height, mesh.x, mesh.eta)[0], 0.0).sum(axis=0)
        angle = np.arctan2(-mesh.lean[:, 0], mesh.lean[:, 1])
        angle = np.sum(angle * over * mesh.du) / np.sum(over * mesh.du)
        eta = self.profiles.station(edges)
        along = eta * math.cos(angle) + self.profiles.rail(eta) * math.sin(angle)
        lean = np.tile([-math.sin(angle), math.cos(angle)], (mesh.u.size, 1))
        return lean, np.diff(along), 0.5 * (along[1:] + along[:-1])

    def bear(self, load):
        """The contact under a vertical force.

        Returns
        -------
        Found
        """
        height, reached = self._guess(load), -math.inf
        while height > reached:
            reached = height + DEEPER
            mesh = self._coarse(reached)
            height, p = self._settle(mesh, height, load, 1e-3)
        for _ in range(2):
            mesh = self._refined(mesh, p, height)
            height, p = self._settle(mesh, height, load, LOAD)
        if p[[0, -1]].any() or p[:, [0, -1]].any():
            raise ArithmeticError(f"elements end within a patch at {self.pose}, {load:g} N")
        self.mesh, self.p = mesh, p
        return self._found(mesh, height, p)

    def _guess(self, load):
        """Depth of a circular contact of the wheel's radius."""
        return self.touch + (0.75 * load / (self.modulus * math.sqrt(0.3 * self.profiles.radius))) ** (2.0 / 3.0)

    def _coarse(self, height):
        """Strips wherever the surfaces overlap at a height."""
        profiles, x = self.profiles, np.arange(-60, 61) * COARSE[1]
        while True:
            over = profiles.distance(self.pose, height, x, self._eta)[0] < 0.0
            if not over[[0, -1]].any():
                break
            x = np.arange(2.0 * x[0], 2.0 * x[-1] + 0.5 * COARSE[1], COARSE[1])
        rows = np.flatnonzero(over.any(axis=1))
        columns = np.flatnonzero(over.any(axis=0))
        edges = COARSE[0] * (np.arange(columns[0] - 2, columns[-1] + 4) - 0.5)
        edges = edges[(edges > 0.0) & (edges < profiles.length)]
        return self._mesh(edges, x[max(rows[0] - 2, 0) : rows[-1] + 3], height)

    def _refined(self, mesh, p, height):
        """Elements fitted to the patches of a solution."""
        runs = patches(p)
        ends = []
        for first, last in runs:
            half = 0.5 * (mesh.u[min(last + 1, mesh.u.size - 1)] - mesh.u[max(last - 1, 0)])
            left, right = mesh.u[first] - 0.5 * half, mesh.u[last] + 0.5 * half
            spare = MARGIN * (right - left) + half
            ends.append((left - spare, right + spare, (right - left) / (ACROSS * self.fine)))
        start, stop = mesh.u[0] - 0.5 * (mesh.u[1] - mesh.u[0]), mesh.u[-1] + 0.5 * (mesh.u[-1] - mesh.u[-2])
        start = max(min(start, ends[0][0]), 0.0)
        stop = min(max(stop, ends[-1][1]), self.profiles.length)

        def width(u):
            found = WIDEST
            for left, right, du in ends:
                found = min(found, du + GROWTH * max(left - u, u - right, 0.0))
            return found

        edges = [start]
        while edges[-1] < stop:
            du = width(edges[-1])
            edges.append(edges[-1] + min(du, width(edges[-1] + du)))
        if self.element:
            edges = np.arange(start, stop, self.element)
            return self._mesh(edges, np.arange(mesh.x[0], mesh.x[-1], self.element), height)
        rows = np.flatnonzero((p > 0.0).any(axis=1))
        dx = mesh.x[1] - mesh.x[0]
        first, last = mesh.x[rows[0]] - dx, mesh.x[rows[-1]] + dx
        longest = max(np.count_nonzero(p[:, a : b + 1].any(axis=1)) for a, b in runs) * dx
        fine = longest / (ALONG * self.fine)
        count = math.ceil((last - first) / fine) + 6
        x = 0.5 * (first + last) + fine * (np.arange(count) - 0.5 * (count - 1))
        return self._mesh(np.array(edges), x, height)

    def _settle(self, mesh, height, load, accuracy):
        """Height and pressures under a vertical force; secants of force^(2/3) over height."""
        p, tried = None, []
        for _ in range(30):
            h = -self.profiles.distance(self.pose, height, mesh.x, mesh.eta, mesh.lean)[0]
            if not (h > 0.0).any():
                height += 10e-6
                continue
            p = mesh.half_spaces.solve(h, p if p is not None and p.any() else None)
            force = self._vertical(mesh, p)
            if abs(force / load - 1.0) < accuracy:
                break
            tried.append((height, force ** (2.0 / 3.0)))
            wanted = load ** (2.0 / 3.0)
            if len(tried) == 1:
                height = self.touch + (height - self.touch) * min(max(wanted / tried[0][1], 0.4), 2.5)
            else:
                (h0, f0), (h1, f1) = tried[-2:]
                height = max(h1 + (wanted - f1) * (h1 - h0) / (f1 - f0), self.touch + 0.2 * (h1 - self.touch))
        else:
            raise ArithmeticError(f"no height bears {load:g} N at {self.pose}")
        return height, p

    def _vertical(self, mesh, p):
        return float(np.sum(p * mesh.du * mesh.lean[:, 1]) * mesh.half_spaces.dx)

    def _found(self, mesh, height, p):
        distance, s = self.profiles.distance(self.pose, height, mesh.x, mesh.eta, mesh.lean)
        load = p * mesh.du * mesh.half_spaces.dx
        total = load.sum()
        runs = patches(p)
        shares = [load[:, a : b + 1].sum() / total for a, b in runs]
        return Found(
            height, self._vertical(mesh, p), float(total), float(p.max()),
            area(p, mesh.half_spaces.dx, mesh.du), float(np.sum(load * mesh.eta) / total),
            float(np.sum(load * s) / total), len(runs), float(max(shares)), float(-distance.min()),
        )  # fmt: skip


class Mesh:
    """Elements of one solution: x, arc u, lateral eta, width du, normals lean, half_spaces; height."""


def patches(p):
    """First and last strip of every run of strips under load."""
    bears = np.r_[False, (p > 0.0).any(axis=0), False].astype(int)
    ends = np.diff(bears)
    return list(zip(np.flatnonzero(ends > 0), np.flatnonzero(ends < 0) - 1, strict=True))


def area(p, dx, du):
    """Area under load [m^2]; a strip ends where the square of its pressure would, straight on from its second element.

    The outermost element takes what belongs to others: counting elements gives 1 % too much with 40 over a patch.
    """
    total = 0.0
    for column, width in zip(p.T, du, strict=True):
        (bears,) = np.nonzero(column)
        if bears.size == 0:
            continue
        length = bears.size
        if bears.size >= 8:
            first, last = bears[0], bears[-1]
            length = last - first - 2
            for second, third in ((first + 1, first + 2), (last - 1, last - 2)):
                rise = column[third] ** 2 - column[second] ** 2
                length += min(column[second] ** 2 / rise, 2.5) if rise > 0.0 else 1.5
        total += length * dx * width
    return float(total)


LATERAL = np.arange(-14, 15) * 0.5e-3  # of the own states [m]
YAW = 0.0, 2e-3  # [rad]
LOADS = 10e3, 50e3, 100e3  # vertical, on the wheel [N]
HEADER = """\
# Normal contact of the right wheel without friction, S1002 on UIC60 1:40 as in case A-2.2; by ../full_solution.py
# touch: height of the tape circle's bottom in the rail's axes at first touch, sink: how far below it the load is borne,
# both down; load: vertical; normal: sum of normal forces; rail, wheel: centre of the load from the rail's highest point
# and the tape circle, to the field side; patches: runs of strips under load; share: of the heaviest patch in normal
"""


def benchmark():
    """The benchmark's wheelset, its right side's profiles and E / (2 (1 - nu^2))."""
    from railcli.analysis.contact_benchmark import SETTINGS
    from railcli.files.contact_reference import benchmark_wheelset

    pair = benchmark_wheelset()
    return pair, Profiles(pair.right), SETTINGS.young / (2.0 * (1.0 - SETTINGS.poisson**2))


def own_poses(pair, lateral=LATERAL, yaws=YAW):
    """(y, yaw, roll) of the wheelset, roll by the rigid contact of both wheels, and the pose of the right wheel."""
    from railcli.analysis.rigid_contact import contact_at, wheel_pose

    for yaw in yaws:
        contact = contact_at(pair, with_roll=True, yaw=yaw)
        for y in lateral:
            roll = contact(y)[-1]
            yield (y, yaw, roll), wheel_pose(pair, 0, y, roll, yaw)[0]


def row(state, load, touch, found):
    """A row of normal.csv."""
    y, yaw, roll = state
    values = (
        y, yaw, roll, load, touch, found.height - touch, found.normal, found.pressure, found.area, found.rail,
        found.wheel, found.patches, found.share,
    )  # fmt: skip
    cells = zip(values, COLUMNS.values(), strict=True)
    return [f"{factor * value + 0.0:.{digits}f}" for value, (factor, digits) in cells]


def write_states():
    """Solve every own state and write reference/normal.csv."""
    pair, profiles, modulus = benchmark()
    rows = []
    for state, pose in own_poses(pair):
        contact = Contact(profiles, modulus, pose)
        for load in LOADS:
            rows.append(row(state, load, contact.touch, contact.bear(load)))
            print(*rows[-1], flush=True)
    with open(Path(__file__).with_name("reference") / "normal.csv", "w", encoding="utf-8", newline="") as file:
        file.write(HEADER)
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


def compare_published():
    """Print this solution less the published one of case A-2.2, at the same vertical part of the normal force.

    With elements fitted to the patches, with those of the published one, and patches that do not feel each other.
    """
    from railcli.analysis.rigid_contact import wheel_pose
    from railcli.files.contact_reference import published

    pair, profiles, modulus = benchmark()
    reference = published().benchmark
    ways = {"fitted": {}, "0.2 mm": {"element": 0.2e-3}, "apart": {"reach": APART}}
    print("   y  side elements  approach pressure     area rail [mm]  wheel [mm] patches")
    for i, y in enumerate(reference.y):
        for k, side in enumerate(("right", "left")):
            pose, _ = wheel_pose(pair, k, y, reference.roll[i], reference.yaw[i])
            wanted = {key: values[i, k] for key, values in reference.values.items()}
            load, parts = wanted["normal"] * math.cos(wanted["angle"]), 2
            for name, settings in ways.items():
                if name == "apart" and parts == 1:
                    continue
                found = Contact(profiles, modulus, pose, **settings).bear(load)
                parts = found.patches
                off = (
                    found.overlap / wanted["approach"] - 1.0, found.pressure / wanted["pressure"] - 1.0,
                    found.area / wanted["area"] - 1.0,
                )  # fmt: skip
                places = 1e3 * (found.rail - wanted["on_rail"]), 1e3 * (found.wheel - wanted["on_wheel"])
                print(
                    f"{y * 1e3:4g} {side:>5} {name:>8}", *(f"{value:+9.1%}" for value in off),
                    *(f"{place:+10.2f}" for place in places), found.patches,
                    flush=True,
                )  # fmt: skip


def compare_ways(lateral, **settings):
    """Print how far solutions of other settings of `Contact` lie from the reference's at no yaw, state by state.

    And how wide the patches are [mm], and by how much the rail turns under each [rad].
    """
    pair, profiles, modulus = benchmark()
    print("   y load     sink   normal pressure     area  place [mm]  patches: width, turn")
    for (y, _, _), pose in own_poses(pair, lateral, YAW[:1]):
        contact, other = Contact(profiles, modulus, pose), Contact(profiles, modulus, pose, **settings)
        for load in LOADS:
            base, found = contact.bear(load), other.bear(load)
            off = (
                (found.height - contact.touch) / (base.height - contact.touch), found.normal / base.normal,
                found.pressure / base.pressure, found.area / base.area,
            )  # fmt: skip
            mesh, wide = contact.mesh, []
            for first, last in patches(contact.p):
                turn = math.acos(min(float(mesh.lean[first] @ mesh.lean[last]), 1.0))
                wide.append(f"{1e3 * mesh.du[first : last + 1].sum():.2f}, {turn:.2f}")
            print(
                f"{y * 1e3:4g} {load * 1e-3:4g}", *(f"{v - 1.0:+8.2%}" for v in off),
                f"{1e3 * (found.rail - base.rail):+10.3f}", "; ".join(wide), flush=True,
            )  # fmt: skip


ORDERS = {
    "states": write_states,
    "a22": compare_published,
    "planar": lambda: compare_ways(LATERAL[::2], planar=True),
    "finer": lambda: compare_ways(LATERAL[::4], fine=1.6),
}

if __name__ == "__main__":
    ORDERS[sys.argv[1] if len(sys.argv) == 2 and sys.argv[1] in ORDERS else "a22"]()
