"""Creep laws against CONTACT's full solution and our own; origin and signs in tests/data/contact/SOURCE.md.

`test_contact_benchmark.py` puts every law through the same states.

CONTACT lists slip of rail over wheel and the force on the rail; with all signs flipped the law keeps its form.
"""

from pathlib import Path

import naive
import numpy as np
import pandas as pd
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels import creep, creep_table, fastrip, fastsim, kalker
from railcli.kernels.layout import Creep
from railcli.model.system import creep_table as table_of

ROWS = pd.read_csv(Path(__file__).parents[1] / "data/contact/tangential_hertz.csv", comment="#")
LIMIT, SHEAR, POISSON = 0.3 * 82e3, 82e9, 0.28
SPINS = sorted(abs(ROWS.phi_per_mm).unique())  # 0 and three steps; a 1:20 cone of 0.46 m radius spins 1.5 of the first
STATES = {"no spin": SPINS[:1], "light spin": SPINS[1:2], "medium spin": SPINS[2:3], "heavy spin": SPINS[3:]}
SHAPES = {"a:b = 1:2": 6, "a:b = 2:1": 12}


def deviations(law, rows):
    """Distance of the force vectors over mu N, distance of the moments over mu N sqrt(a b), excess of the size."""
    found = []
    for row in rows.itertuples():
        a, b = row.a_mm * 1e-3, row.b_mm * 1e-3
        f = kalker.stiffness(a, b, SHEAR, POISSON)
        tx, ty, mz = creep.forces(int(law), *f, LIMIT, row.xi, row.eta, row.phi_per_mm * 1e3)
        found.append((tx / LIMIT, ty / LIMIT, mz / (LIMIT * np.sqrt(a * b))))
    found, full = np.array(found), rows[["fx", "fy", "mz"]].to_numpy()
    size = np.hypot(*found[:, :2].T) - np.hypot(*full[:, :2].T)
    return np.hypot(*(found - full)[:, :2].T), abs(found - full)[:, 2], size


@pytest.mark.parametrize("law", [Creep.HARD, Creep.SMOOTH], ids=lambda law: law.name)
@pytest.mark.parametrize("state", STATES)
def test_creep_force(law, state):
    force, moment, _ = deviations(law, ROWS[abs(ROWS.phi_per_mm).isin(STATES[state])])
    mean, largest, mean_moment = tol.CREEP_AGAINST_CONTACT[law.name, state]
    assert force.mean() < mean
    assert force.max() < largest
    assert moment.mean() < mean_moment


def test_smooth_is_the_closer_law_in_every_state():
    for spins in STATES.values():
        rows = ROWS[abs(ROWS.phi_per_mm).isin(spins)]
        assert deviations(Creep.SMOOTH, rows)[0].mean() < deviations(Creep.HARD, rows)[0].mean()


def test_hard_law_never_gives_less_than_the_full_solution_without_spin():
    """The linear force and the friction limit both bound the force from above."""
    size = deviations(Creep.HARD, ROWS[ROWS.phi_per_mm == 0])[2]
    assert size.min() > -tol.CONTACT_ROUNDING


def test_smooth_size_without_spin():
    size = deviations(Creep.SMOOTH, ROWS[ROWS.phi_per_mm == 0])[2]
    assert abs(size).max() < tol.CREEP_SIZE_SMOOTH


def strip_forces(a, b, f, limit, creepage):
    """Tx, Ty over mu N, Mz over mu N sqrt(a b): the law itself, and its table."""
    scaled = fastsim.scaled_creepages(*f[:3], limit, *creepage)
    shape, grid = fastrip.proportions(b / a), (creep_table.STRIPS, creep_table.ELEMENTS)
    point = fastrip.rolling(*scaled, b / a, shape, *grid)
    table = creep_table.integrals(table_of("fastrip"), *scaled, b / a, fastrip.levers(a, b, *f[1:]))
    return [(fx, fy, (a * my - b * mx) / np.sqrt(a * b)) for fx, fy, mx, my in (point, table[:4])]


@pytest.mark.parametrize("state", STATES)
def test_strips_against_contact(state):
    rows = ROWS[abs(ROWS.phi_per_mm).isin(STATES[state])]
    found = []
    for row in rows.itertuples():
        a, b = row.a_mm * 1e-3, row.b_mm * 1e-3
        creepage = row.xi, row.eta, row.phi_per_mm * 1e3
        found.append(strip_forces(a, b, kalker.stiffness(a, b, SHEAR, POISSON), LIMIT, creepage))
    apart = np.array(found) - rows[["fx", "fy", "mz"]].to_numpy()[:, None]
    for law in (0, 1):
        force, moment = np.hypot(apart[:, law, 0], apart[:, law, 1]), np.abs(apart[:, law, 2])
        mean, largest, mean_moment = tol.STRIPS_AGAINST_CONTACT[state]
        assert force.mean() < mean
        assert force.max() < largest
        assert moment.mean() < mean_moment


def test_own_full_solution_is_that_of_contact():
    """Creepages are scaled by what the elements' own coefficients are off, so that the linear forces agree."""
    for shape in SHAPES.values():
        rows = ROWS[ROWS.a_mm == shape].iloc[5::80]
        a_over_b, scale = shape**2 / 72, SHEAR * 72e-6 / LIMIT
        elements = naive.rolling_elements(a_over_b, POISSON, 26, 20)
        own = np.array(kalker.coefficients(a_over_b, POISSON)) / naive.linear_rolling(a_over_b, POISSON, 26, 20)
        creepages = np.array([rows.xi, rows.eta, rows.phi_per_mm * np.sqrt(72.0)]).T * scale * own[:3]
        found = np.array([-naive.rolling_with_slip(elements, a_over_b, -creepage) for creepage in creepages])
        assert_allclose(found, rows[["fx", "fy", "mz"]], atol=tol.FULL_SOLUTION)


@pytest.mark.parametrize("a_over_b", [0.2, 1.0, 5.0])
def test_strips_against_the_full_solution_on_other_ellipses(a_over_b):
    """Creepages and spins of the file, of which the ellipses have the area."""
    cuts = {0.2: (20, 34), 1.0: (26, 24), 5.0: (40, 18)}[a_over_b]
    a, b, scale = np.sqrt(a_over_b), 1 / np.sqrt(a_over_b), SHEAR * 72e-6 / LIMIT
    elements, f = naive.rolling_elements(a_over_b, POISSON, *cuts), naive.linear_rolling(a_over_b, POISSON, *cuts)
    own = np.array(kalker.coefficients(a_over_b, POISSON)) / f
    rows = ROWS[(ROWS.a_mm == 6) & ((ROWS.xi != 0) | (ROWS.eta != 0))].iloc[7::31]
    creepages = np.array([rows.xi, rows.eta, rows.phi_per_mm * np.sqrt(72.0)]).T * scale * own[:3]
    full = np.array([naive.rolling_with_slip(elements, a_over_b, creepage) for creepage in creepages])
    apart = np.array([strip_forces(a, b, f, 1.0, creepage) for creepage in creepages]) - full[:, None]
    force = np.hypot(apart[..., 0], apart[..., 1])
    assert (force.mean(axis=0) < tol.STRIPS_MEAN).all()
    assert (force.max(axis=0) < tol.STRIPS_LARGEST).all()
    assert (np.abs(apart[..., 2]).mean(axis=0) < tol.STRIPS_MEAN).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_coefficients_are_the_slopes_at_zero_creepage(shape):
    """A parabola through the six smallest creepages, over creepage, gives CONTACT's slopes: C11, C22 and C23."""
    rows = ROWS[(ROWS.a_mm == SHAPES[shape]) & (ROWS.phi_per_mm == 0)]
    c = np.sqrt(72e-6)
    expected = kalker.coefficients(rows.a_mm.iloc[0] / rows.b_mm.iloc[0], POISSON)
    along, across = (rows[(rows[x] != 0) & (rows[y] == 0)] for x, y in (("xi", "eta"), ("eta", "xi")))
    slopes = [
        -slope(along.xi, along.fx) * LIMIT / (SHEAR * c**2),
        -slope(across.eta, across.fy) * LIMIT / (SHEAR * c**2),
        slope(across.eta, across.mz) * LIMIT / (SHEAR * c**2),
    ]
    assert_allclose(slopes, expected[:3], rtol=tol.CONTACT_SLOPE)


def slope(creepage, force):
    order = abs(creepage).sort_values().index[:6]
    scaled = abs(creepage[order]) * 1e4
    return np.polyfit(scaled, force[order] / creepage[order], 2)[-1]
