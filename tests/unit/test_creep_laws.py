"""Polach's law, FASTSIM and its table, falling friction: twins, limits, symmetries, derivatives."""

import math

import naive
import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels import creep, creep_table, fastrip, fastsim, kalker
from railcli.kernels.layout import PARAM, Creep
from railcli.model.system import creep_table as table_of

LIMIT, SHEAR, POISSON = 24e3, 82e9, 0.28
ELLIPSES = {"round": (6e-3, 6e-3), "wide": (3e-3, 12e-3), "long": (8e-3, 1.5e-3), "flange": (9e-3, 0.5e-3)}
GRID = 10
TABLED = {Creep.TABLE: "table", Creep.FASTRIP: "fastrip"}
LAWS = pytest.mark.parametrize("law", [Creep.POLACH, Creep.FASTSIM, *TABLED], ids=lambda law: law.name)
SHAPES = pytest.mark.parametrize("ellipse", ELLIPSES.values(), ids=ELLIPSES)
SIZES = (1e-2, 0.3, 1.0, 3.0, 30.0)  # of the creepages, against those whose linear force is the friction limit


def param(law, **values):
    record = np.zeros(1, PARAM)
    settings = {"adhesion_reduction": 1.0, "slip_reduction": 1.0, "fastsim_grid": GRID, **values}
    for key, value in {"creep_law": int(law), **settings}.items():
        record[key] = value
    return record[0]


def stiffness(ellipse):
    return kalker.stiffness(*ellipse, SHEAR, POISSON)


def law_at(law, ellipse, creepage, limit=LIMIT, **values):
    """Force and moment (3,), their derivatives (3, 3)."""
    table = table_of(TABLED[law]) if law in TABLED else np.zeros((0, creep_table.CHANNELS))
    record = param(law, **values)
    reduced = record["adhesion_reduction"], record["slip_reduction"]
    found = creep.tangential(record, table, *reduced, *ellipse, *stiffness(ellipse), limit, *creepage)
    return np.array(found[:3]), np.array(found[3:]).reshape(3, 3)


def units(ellipse):
    """Creepages of which each alone gives a linear force as large as the friction limit."""
    return LIMIT / np.array(stiffness(ellipse)[:3])


def random_creepages(ellipse, size, count=40, seed=5):
    return np.random.default_rng(seed).normal(size=(count, 3)) * size * units(ellipse)


@SHAPES
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("reduced", [(1.0, 1.0), (0.6, 0.3)])
def test_polach_against_the_publication(ellipse, size, reduced):
    for creepage in random_creepages(ellipse, size):
        twin = naive.polach_forces(*reduced, *ellipse, stiffness(ellipse), LIMIT, creepage)
        found, _ = law_at(Creep.POLACH, ellipse, creepage, adhesion_reduction=reduced[0], slip_reduction=reduced[1])
        assert_allclose(found[:2], twin[:2], rtol=tol.CREEP_TWIN, atol=tol.CREEP_TWIN * LIMIT)
        assert_allclose(found[2], twin[2], rtol=tol.CREEP_TWIN, atol=tol.CREEP_TWIN * LIMIT * ellipse[0])


@SHAPES
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("grid", [10, 23])
def test_fastsim_against_the_publication(ellipse, size, grid):
    for creepage in random_creepages(ellipse, size, 10):
        twin = naive.fastsim_forces(grid, *ellipse, stiffness(ellipse), LIMIT, creepage)
        found, _ = law_at(Creep.FASTSIM, ellipse, creepage, fastsim_grid=grid)
        assert_allclose(found, twin, rtol=tol.CREEP_TWIN, atol=tol.CREEP_TWIN * LIMIT)


@SHAPES
def test_fastsim_error_goes_as_the_length_of_an_element(ellipse):
    """What the extrapolation of the table rests on: the error at 10 elements is twice that at 20, four times at 40."""
    fine = {n: [] for n in (10, 20, 40, 160)}
    for creepage in random_creepages(ellipse, 1.0):
        for n, found in fine.items():
            found.append(law_at(Creep.FASTSIM, ellipse, creepage, fastsim_grid=n)[0][:2] / LIMIT)
    limit = 2.0 * np.array(fine[160]) - np.array([law_at(Creep.FASTSIM, ellipse, c, fastsim_grid=80)[0][:2] / LIMIT
                                                  for c in random_creepages(ellipse, 1.0)])  # fmt: skip
    error = {n: np.hypot(*(np.array(found) - limit).T).mean() for n, found in fine.items()}
    assert 1.7 < error[10] / error[20] < 2.3 and 1.7 < error[20] / error[40] < 2.3


@SHAPES
@pytest.mark.parametrize("size", SIZES)
def test_table_against_fastsim(ellipse, size):
    apart = []
    for creepage in random_creepages(ellipse, size):
        fine = law_at(Creep.FASTSIM, ellipse, creepage, fastsim_grid=100)[0]
        apart.append((law_at(Creep.TABLE, ellipse, creepage)[0] - fine) / LIMIT)
    apart = np.array(apart)
    assert np.hypot(*apart[:, :2].T).mean() < tol.CREEP_TABLE_MEAN
    assert np.hypot(*apart[:, :2].T).max() < tol.CREEP_TABLE_MAX
    assert np.abs(apart[:, 2]).mean() < tol.CREEP_TABLE_MEAN * math.sqrt(ellipse[0] * ellipse[1])


def point_law(law, ux, uy, wa, narrow):
    """The integrals at one point, without the table."""
    if law == Creep.FASTRIP:
        shape = fastrip.proportions(narrow)
        return np.array(fastrip.rolling(ux, uy, wa, narrow, shape, creep_table.STRIPS, creep_table.ELEMENTS))
    coarse, fine = (fastsim.rolling(ux, uy, wa, narrow, n)[:4] for n in (creep_table.GRID, 2 * creep_table.GRID))
    return 2 * np.array(fine) - coarse


@pytest.mark.parametrize("law", TABLED, ids=lambda law: law.name)
def test_table_holds_its_points(law):
    """At a point of the table nothing is interpolated: creepages and shape from the axes of the module's text."""
    table, rng = table_of(TABLED[law]), np.random.default_rng(2)
    for _ in range(40):
        m, i, j, k = (int(rng.integers(low, n - low)) for low, n in ((1, 21), (0, 17), (0, 17), (1, 9)))
        s = 1 / (1 - m / 20) ** 2 - 1
        way, spin, narrow = 2 * j / 16 - 1, i / 16, (1 - k / 8) / (k / 8)
        ux, uy = s * (1 - spin) * np.array([1 - abs(way), way]) / math.hypot(1 - abs(way), way)
        wa = s * spin / math.hypot(1, narrow)
        levers = fastrip.proportions(narrow)[2:] if law == Creep.FASTRIP else creep_table.LEVERS
        found = creep_table.integrals(table, ux, uy, wa, narrow, levers)[:4]
        assert_allclose(found, point_law(law, ux, uy, wa, narrow), atol=tol.ROUNDING * 100)


@pytest.mark.parametrize("ratio", [1e-9, 1e-3, 0.05, 20.0, 1e3, 1e9])
@pytest.mark.parametrize("law", TABLED, ids=lambda law: law.name)
def test_table_covers_every_ellipse_and_creepage(law, ratio):
    table, rng = table_of(TABLED[law]), np.random.default_rng(4)
    levers = fastrip.proportions(1.0 / ratio)[2:] if law == Creep.FASTRIP else creep_table.LEVERS
    for size in (1e-300, 1e-30, 1e-9, 1.0, 1e9, 1e30):
        for u in rng.normal(size=(20, 3)) * size:
            found = np.array(creep_table.integrals(table, *u, 1.0 / ratio, levers))
            assert np.isfinite(found).all()
            assert np.hypot(*found[:2]) < 1.0 + tol.CREEP_BOUND


@SHAPES
@LAWS
@pytest.mark.parametrize("size", SIZES)
def test_tangent_is_the_derivative(law, ellipse, size):
    """Central differences; those that reach over a corner of the law are few, and told by their halves."""
    told = 0
    for creepage in random_creepages(ellipse, size):
        _, tangent = law_at(law, ellipse, creepage)
        for column, unit in enumerate(units(ellipse)):
            step = np.zeros(3)
            step[column] = 1e-6 * size * unit
            ahead, here, behind = (law_at(law, ellipse, creepage + k * step)[0] for k in (1, 0, -1))
            scale = LIMIT * np.array([1.0, 1.0, ellipse[0] + ellipse[1]]) / min(size, 1.0)
            halves = (ahead - 2.0 * here + behind) / (1e-6 * size) / scale
            if np.abs(halves).max() < tol.CREEP_TANGENT:
                quotient = (ahead - behind) / (2e-6 * size)
                assert_allclose(quotient / scale, tangent[:, column] * unit / scale, atol=tol.CREEP_TANGENT)
                told += 1
    assert told > 100


@SHAPES
@LAWS
def test_force_without_slip_is_the_linear_one(law, ellipse):
    """Along one direction at a time: Polach's one gradient is then that of the direction, and FASTSIM counts elements.

    Without any creepage Polach's law has no direction: a mean gradient, and no slope by spin.
    """
    f11, f22, f23, f33 = stiffness(ellipse)
    small = 1e-5
    for way, expected in (((1, 0, 0), (1, 0)), ((0, 1, 0), (0, 1)), ((0, 0, 1), (0, 1))):
        found, tangent = law_at(law, ellipse, small * units(ellipse) * way)
        assert_allclose(found[:2] / (small * LIMIT), -np.array(expected), atol=tol.CREEP_LINEAR)
    _, tangent = law_at(law, ellipse, (0.0, 0.0, 0.0))
    wanted = -np.array([[f11, 0.0, 0.0], [0.0, f22, f23]])
    if law == Creep.POLACH:
        wanted[0, 0], wanted[1, 1], wanted[1, 2] = -math.sqrt(f11 * f22), -math.sqrt(f11 * f22), 0.0
    assert_allclose(tangent[:2] * units(ellipse), wanted * units(ellipse), atol=tol.CREEP_LINEAR * LIMIT)
    if law == Creep.FASTRIP:
        assert_allclose(tangent[2], (0.0, f23, -f33), rtol=tol.CREEP_SCALED)


@SHAPES
@LAWS
def test_full_slip_without_spin(law, ellipse):
    for way in np.radians(np.arange(0, 360, 15)):
        creepage = 1e4 * units(ellipse).max() * np.array([math.cos(way), math.sin(way), 0.0])
        force, _ = law_at(law, ellipse, creepage)
        assert_allclose(np.hypot(*force[:2]), LIMIT, rtol=tol.CREEP_BOUND)
        if law == Creep.POLACH:
            assert_allclose(force[:2], -LIMIT * np.array([math.cos(way), math.sin(way)]), atol=tol.CREEP_BOUND * LIMIT)
        if law == Creep.FASTRIP:
            assert_allclose(
                force[:2], -LIMIT * np.array([math.cos(way), math.sin(way)]), atol=tol.STRIPS_OPPOSED * LIMIT
            )
        assert abs(force[2]) < tol.CREEP_MOMENT_LEFT * LIMIT * max(ellipse)


@SHAPES
@LAWS
@pytest.mark.parametrize("size", SIZES)
def test_friction_is_the_bound_and_power_is_lost(law, ellipse, size):
    for creepage in random_creepages(ellipse, size):
        force, _ = law_at(law, ellipse, creepage)
        assert np.hypot(*force[:2]) <= LIMIT * (1.0 + tol.CREEP_BOUND)
        assert force @ creepage <= tol.CREEP_POWER * LIMIT * np.abs(creepage / units(ellipse)).max() * units(ellipse)[0]


@SHAPES
@LAWS
def test_mirror_images(law, ellipse):
    """Seen in a mirror along the rail, and with all slip reversed: two symmetries of every law."""
    for creepage in random_creepages(ellipse, 1.0):
        force, _ = law_at(law, ellipse, creepage)
        mirrored, _ = law_at(law, ellipse, creepage * (1, -1, -1))
        assert_allclose(mirrored, force * (1, -1, -1), rtol=tol.ROUNDING, atol=tol.ROUNDING * LIMIT)
        reversed_slip, _ = law_at(law, ellipse, -creepage)
        assert_allclose(reversed_slip, -force, rtol=tol.ROUNDING, atol=tol.ROUNDING * LIMIT)


@SHAPES
@LAWS
def test_creepages_and_limit_scale_together(law, ellipse):
    for creepage in random_creepages(ellipse, 1.0):
        force, tangent = law_at(law, ellipse, creepage)
        larger, same = law_at(law, ellipse, 3.0 * creepage, 3.0 * LIMIT)
        assert_allclose(larger, 3.0 * force, rtol=tol.CREEP_SCALED, atol=tol.ROUNDING * LIMIT)
        assert_allclose(same, tangent, rtol=tol.CREEP_SCALED, atol=tol.ROUNDING * np.abs(tangent).max())


@LAWS
@pytest.mark.parametrize("limit", [0.0, -1.0])
def test_no_force_without_normal_force(law, limit):
    force, tangent = law_at(law, ELLIPSES["round"], (1e-3, 2e-3, 0.1), limit)
    assert not force.any() and not tangent.any()


@LAWS
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_stays_visible(law, place, bad):
    creepage = np.array([1e-3, 2e-3, 0.1])
    creepage[place] = bad
    force, _ = law_at(law, ELLIPSES["wide"], creepage)
    assert not np.isfinite(force).all() or np.hypot(*force[:2]) <= LIMIT * (1.0 + tol.CREEP_BOUND)
    if math.isnan(bad):
        assert np.isnan(force).any()


def test_falling_friction():
    """Static at rest, the ratio at high speed, an exponential between; the slope is its derivative."""
    static, ratio, decay = 0.45, 0.4, 0.6
    assert creep.falling_friction(ratio, decay, static, 0.0)[0] == pytest.approx(static)
    assert creep.falling_friction(ratio, decay, static, 1e3)[0] == pytest.approx(ratio * static)
    half = math.log(2.0) / decay
    assert creep.falling_friction(ratio, decay, static, half)[0] == pytest.approx(static * (1.0 + ratio) / 2.0)
    h = 1e-6
    ahead, behind = (creep.falling_friction(ratio, decay, static, 1.0 + k * h)[0] for k in (1, -1))
    assert creep.falling_friction(ratio, decay, static, 1.0)[1] == pytest.approx((ahead - behind) / (2.0 * h), rel=1e-6)
