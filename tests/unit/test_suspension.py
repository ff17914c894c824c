"""Force elements between two bodies in free space: energy, action and reaction, dissipation."""

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from pairs import LEVEL, element, forces, moved, pair, poses, somewhere
from scipy.spatial.transform import Rotation

from railcli.kernels.layout import Axes, Kind

AXES = pytest.mark.parametrize("axes", list(Axes), ids=lambda axes: axes.name)


def spring_kinds(rng):
    """One element of each kind of spring; the curves are those of `pair`."""
    k = rng.uniform(1e5, 1e6, 3)
    return {
        "bushing": element(Kind.BUSHING, rng, k=k),
        "preloaded bushing": element(Kind.BUSHING, rng, k=k, preload=rng.uniform(-1e4, 1e4, 3)),
        "bushing with tables": element(Kind.BUSHING, rng, k=k, spring_curve=(0, 1, 0)),
        "link": element(Kind.LINK, rng, k=k, length=0.7),
        "preloaded link with a table": element(
            Kind.LINK, rng, k=k, length=0.7, preload=(2e3, 0, 0), spring_curve=(1, -1, -1)
        ),
        "damper in series": element(Kind.LINK, rng, c=(1e4, 0, 0), series=1e6, state=0),
        "matrix": element(Kind.MATRIX, rng, matrix=0, preload=rng.uniform(-1e4, 1e4, 3)),
        "air spring": element(
            Kind.AIR, rng, k=k, c=(0, 0, 1e4), dampers=1, series=1e6, reservoir=3e5, state=0, preload=(0, 0, -4e4)
        ),
        "torsion spring": element(Kind.TORQUE, rng, lower=(0.36, 0.48, 0.8), k=k, spring_curve=(1, -1, -1)),
    }  # fmt: skip


KINDS = tuple(spring_kinds(np.random.default_rng(0)))


@AXES
@pytest.mark.parametrize("kind", KINDS)
def test_force_is_the_slope_of_the_energy(wagon, axes, kind):
    """Springs keep energy: forces and moments on both bodies are its negative derivatives, at finite rotations."""
    rng = np.random.default_rng(2)
    h = 1e-5
    for _ in range(6):
        system = pair(wagon, axes, [spring_kinds(rng)[kind]])
        q = somewhere(rng)
        force, moment, data = forces(system, q)
        found = np.concatenate([force, moment], axis=1)
        slope = np.zeros((2, 6))
        for body in range(2):
            for k in range(6):
                pair_ahead, pair_behind = poses(q), poses(q)
                pair_ahead[body], pair_behind[body] = moved(pair_ahead[body], k, h), moved(pair_behind[body], k, -h)
                slope[body, k] = (
                    naive.joint_energy(system.model, 0, *pair_ahead, data.damper)
                    - naive.joint_energy(system.model, 0, *pair_behind, data.damper)
                ) / (2 * h)
        assert_allclose(found, -slope, atol=tol.ENERGY_SLOPE * np.abs(slope).max())


@AXES
def test_turn_of_a_joint_is_the_slope_of_its_energy(wagon, axes):
    """Rotational stiffness alone, up to 80 degrees between the bodies."""
    rng = np.random.default_rng(4)
    h = 1e-5
    system = pair(wagon, axes, [], turn=(1e6, 3e5, 2e5))
    for angle in (1e-3, 0.3, 1.4):
        q = somewhere(rng, angle)
        force, moment, data = forces(system, q)
        slope = [
            (naive.joint_energy(system.model, 0, poses(q)[0], moved(poses(q)[1], k, h), ())
             - naive.joint_energy(system.model, 0, poses(q)[0], moved(poses(q)[1], k, -h), ())) / (2 * h)
            for k in (3, 4, 5)
        ]  # fmt: skip
        assert_allclose(moment[1], -np.array(slope), atol=tol.ENERGY_SLOPE * np.abs(slope).max())
        assert not force.any()


@pytest.mark.parametrize("spins", [(1, 0), (0, 1)], ids=["wheelset below", "wheelset above"])
def test_turn_of_an_axle_is_the_slope_of_its_energy(wagon, spins):
    """Rotational stiffness on a wheelset follows the direction of its axle, and has no moment about it."""
    rng = np.random.default_rng(4)
    h = 1e-5
    system = pair(wagon, Axes.UPPER, [], turn=(1e6, 0.0, 2e5), spins=spins)
    for angle in (1e-3, 0.3, 1.4):
        q = somewhere(rng, angle)
        q[spins.index(1), 4] = 0.0
        _, moment, data = forces(system, q)
        for body in (0, 1):
            energies = [[], []]
            for k in (3, 4, 5):
                for side, sign in zip(energies, (1.0, -1.0), strict=True):
                    at = poses(q)
                    at[body] = moved(at[body], k, sign * h)
                    side.append(naive.joint_energy(system.model, 0, *at, ()))
            slope = np.subtract(*energies) / (2 * h)
            assert_allclose(moment[body], -slope, atol=tol.ENERGY_SLOPE * np.abs(slope).max())
        axle = data.frame["axes"][spins.index(1)][:, 1]
        assert abs(moment[spins.index(1)] @ axle) < tol.ROUNDING * np.abs(moment).max()


@AXES
def test_small_turn_is_linear(wagon, axes):
    """A bar of c N m/rad gives c times a small angle, about the axis of that angle."""
    system = pair(wagon, axes, [], turn=(1e6, 3e5, 2e5))
    q = np.zeros((2, 6))
    q[1, 3:] = 1e-6, -2e-6, 3e-6
    _, moment, _ = forces(system, q)
    assert_allclose(moment[1], (-1.0, 0.6, -0.6), rtol=1e-5)


def everything(rng):
    """All springs and dampers at once."""
    dampers = [
        element(Kind.BUSHING, rng, c=rng.uniform(1e3, 1e4, 3)),
        element(Kind.LINK, rng, c=(2e4, 0, 0)),
        element(Kind.LINK, rng, damper_curve=1),
        element(Kind.BUSHING, rng, damper_curve=1, dampers=1),
        element(Kind.TORQUE, rng, lower=(0.6, 0.0, 0.8), c=(2e4, 0, 0), limit=1e3),
    ]
    return [*spring_kinds(rng).values(), *dampers]


@AXES
def test_action_is_reaction(wagon, axes):
    """Forces cancel, and so do moments about a point, whatever moves."""
    rng = np.random.default_rng(6)
    for _ in range(10):
        system = pair(wagon, axes, everything(rng), turn=rng.uniform(0, 1e6, 3))
        force, moment, data = forces(system, somewhere(rng), rng.uniform(-3, 3, (2, 6)), half_step=1e-3)
        about_origin = moment + np.cross(data.frame["position"], force)
        assert_allclose(force.sum(axis=0), 0.0, atol=tol.ROUNDING * np.abs(force).max())
        assert_allclose(about_origin.sum(axis=0), 0.0, atol=tol.ROUNDING * np.abs(about_origin).max() * 10)


@AXES
def test_forces_ride_along(wagon, axes):
    """The same pair moved and turned as a whole, moving as one body, feels the same forces in its own axes."""
    rng = np.random.default_rng(8)
    system = pair(wagon, axes, everything(rng), turn=(1e6, 3e5, 2e5))
    q = somewhere(rng)
    whole = Rotation.from_rotvec([0.3, -0.5, 0.9])
    (p0, a0), (p1, a1) = poses(q)
    turned = q.copy()
    spin = np.array([1.0, -2.0, 0.5])
    v = np.zeros((2, 6))
    for row, rates, p, a in zip(turned, v, (p0, p1), (a0, a1), strict=True):
        row[:3] = p0 + whole.apply(p - p0)
        yaw, roll, pitch = (whole * Rotation.from_matrix(a)).as_euler("ZXY")
        row[3:] = roll, pitch, yaw
        rates[:3] = np.cross(spin, row[:3] - p0)
        rates[3:] = (whole.as_matrix() @ a).T @ spin
    for one, other in zip(forces(system, q)[:2], forces(system, turned, v)[:2], strict=True):
        assert_allclose(whole.apply(one), other, atol=tol.TWIN * np.abs(other).max())


def power(data, force, moment):
    """Work of the forces on both bodies per second."""
    return np.sum(force * data.frame["velocity"]) + np.sum(moment * data.frame["omega"])


@AXES
@pytest.mark.parametrize(
    "values",
    [
        {"kind": Kind.BUSHING, "c": (1e4, 2e3, 5e3)},
        {"kind": Kind.LINK, "c": (1e4, 0, 0)},
        {"kind": Kind.LINK, "damper_curve": 1},
        {"kind": Kind.BUSHING, "damper_curve": 1, "dampers": 1},
        {"kind": Kind.MATRIX, "matrix": 0},
        {"kind": Kind.TORQUE, "c": (1e4, 0, 0), "lower": (0.6, 0.0, 0.8)},
        {"kind": Kind.TORQUE, "damper_curve": 1, "lower": (0.6, 0.0, 0.8)},
        {"kind": Kind.TORQUE, "limit": 1e4, "lower": (0.6, 0.0, 0.8)},
    ],
    ids=["bushing", "link", "link with a table", "bushing with tables", "matrix", "torque", "torque with a table",
         "friction"],
)
def test_dampers_only_dissipate(wagon, axes, values):
    """Their power is never positive, at any pose and motion; and one of them always takes some."""
    rng = np.random.default_rng(10)
    taken = []
    for _ in range(50):
        system = pair(wagon, axes, [element(rng=rng, **values)])
        system = scenes.replaced(system, matrix=system.model.matrix * np.repeat([0.0, 1.0], 6)[:, None])
        force, moment, data = forces(system, somewhere(rng), rng.uniform(-2, 2, (2, 6)))
        taken.append(power(data, force, moment))
    assert max(taken) < 0.0


@pytest.mark.parametrize("law", ["linear", "table"])
def test_damper_in_series_only_dissipates(wagon, law):
    """What it takes from the bodies less what its spring stores is tension times the rate of the piston."""
    rng = np.random.default_rng(12)
    h = 1e-6
    for _ in range(20):
        values = {"c": (1e4, 0, 0), "series": 1e6, "state": 0}
        system = pair(wagon, Axes.MEAN, [element(Kind.LINK, rng, **values)])
        if law == "table":
            curve = system.model.curve.copy()
            curve[0]["x"][:4], curve[0]["y"][:4] = (-2, 0, 1, 5), (-1e5, 0, 1e5, 2e5)
            system = scenes.edited(scenes.replaced(system, curve=curve), "element", damper_curve=(0, -1, -1))
        q, v = somewhere(rng), rng.uniform(-2, 2, (2, 6))
        force, moment, data = forces(system, q, v)

        def stored(t, system=system, q=q, data=data):
            at = [naive.body_pose(LEVEL, row + t * rate, 1.5) for row, rate in zip(q, data.rate, strict=True)]
            return naive.joint_energy(system.model, 0, *at, data.damper + t * data.damper_rate)

        dissipated = -power(data, force, moment) - (stored(h) - stored(-h)) / (2 * h)
        assert dissipated > -tol.DIFFERENCE_QUOTIENT * np.abs(power(data, force, moment))
        tension = np.linalg.norm(force[1])
        assert dissipated == pytest.approx(tension * abs(data.damper_rate[0]), rel=1e-4)


def test_series_damper_relaxes(wagon):
    """Ends held still: the tension of a damper c with series stiffness k dies out as exp(-k t / c)."""
    row = element(Kind.LINK, np.random.default_rng(0), c=(1e4, 0, 0), series=1e6, state=0, lower=0.0, upper=0.0)
    free = pair(wagon, Axes.MEAN, [row])
    heavy = scenes.edited(free, "body", mass=1e15)
    q = np.zeros((2, 6))
    q[1, 1] = 0.5
    for step in (1e-3, 5e-4):
        system = scenes.tuned(heavy, step=step)
        data = scenes.data_at(system.model, q, np.zeros((2, 6)), (0.499,))
        scenes.run(system, data, 0.02)
        left = (0.5 - data.damper[0]) / 1e-3
        assert left == pytest.approx(np.exp(-2.0), abs=tol.RELAXATION * (step / 1e-3) ** 2)
