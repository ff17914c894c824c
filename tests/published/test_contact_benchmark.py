"""Manchester contact benchmark, case A-2.2, and every creep law, against CONTACT (benchmarks/contact/SOURCES.md)."""

import warnings

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.contact_benchmark import deviations
from railcli.analysis.contact_check import compare_contact
from railcli.files.contact_reference import (
    benchmark_profiles,
    benchmark_wheelset,
    contact_criteria,
    published,
)
from railcli.studies.tables import benchmark_tables

REFERENCE = published().benchmark


@pytest.fixture(scope="module")
def outcome():
    with warnings.catch_warnings():  # one of the tables is coarse, which who builds it first is told
        warnings.simplefilter("ignore", RuntimeWarning)
        tables = benchmark_tables()
    return compare_contact(published(), contact_criteria(), benchmark_wheelset(), tables)


def test_criteria_that_count_are_kept(outcome):
    assert [row.name for row in outcome.rows if row.counts and not row.kept] == []


def test_reference_in_railcli_s_axes_and_signs():
    """The printed values of y = 7 mm: flange contact on the right wheel."""
    i = REFERENCE.at(7e-3)
    assert_allclose([REFERENCE.yaw[i], REFERENCE.roll[i], REFERENCE.spin[i]], [16.8e-3, -6.393e-3, -4.26356])
    printed = {
        "on_rail": (-41.49e-3, -1.92e-3), "on_wheel": (-41.14e-3, 18.67e-3), "z_wheel": (18.376e-3, -0.318e-3),
        "angle": np.radians((60.93, 0.37)), "area": (9.0e-6, 23.0e-6), "pressure": (2622e6, 667e6),
        "normal": (14030.0, 10010.0), "x_force": (-2079.0, 2327.0), "y_force": (10490.0, -1964.0),
        "approach": (35.6e-6, 24.1e-6), "xi": (-19.49e-3, 20.35e-3), "eta": (-34.57e-3, -16.63e-3),
        "phi": (-1.838, 0.028),
    }  # fmt: skip
    for key, values in printed.items():
        assert_allclose(REFERENCE.values[key][i], values, err_msg=key)
    assert_allclose(REFERENCE.delta_r[i], 18.694e-3)


def test_height_on_the_wheel_is_that_of_the_profile_less_what_yaw_lifts(outcome):
    """z = F - x_c^2 / (2 R), x_c = R tan(gamma_w) psi ahead of the axle; 0.1 to 0.2 mm on the flange."""
    wheel, _ = benchmark_profiles()
    states = outcome.states["hertz", "hard"]
    start, step, graph = wheel.graph()
    place = states.values["on_wheel"]
    grid = start + step * np.arange(graph.shape[0])
    height, slope = (np.interp(place, grid, graph[:, k]) for k in (0, 1))
    radius = 0.460 + height
    ahead = radius * slope * np.sin(states.yaw)[:, None]
    assert_allclose(states.values["z_wheel"], height - ahead**2 / (2.0 * radius), atol=tol.BENCH_HEIGHT)
    assert (ahead**2 / (2.0 * radius))[REFERENCE.at(7e-3), 0] > 0.1e-3


def test_what_hertz_cannot_reach(outcome):
    """At y = 0 the full patch has its centre 1.4 mm from the rigid contact; strips come nearer."""
    off = {normal: deviations(outcome.states[normal, "hard"], REFERENCE) for normal in ("hertz", "overlap")}
    hertz, strips = (abs(off[normal]["on_rail"][0, 0]) for normal in ("hertz", "overlap"))
    assert 1.3e-3 < hertz < 1.5e-3 and strips < hertz
    sliding = REFERENCE.y > 0.9e-3
    sliding[REFERENCE.at(5e-3)] = False
    for key in ("on_rail", "on_wheel"):
        assert np.abs(off["overlap"][key][sliding]).max() < np.abs(off["hertz"][key][sliding]).max()


def test_one_factor_on_the_linear_force_keeps_its_direction(outcome):
    """In full slip the force should oppose the slip; on the flange the components are off by 6 % of mu N."""
    for law in ("hard", "smooth"):
        off = deviations(outcome.states["hertz", law], REFERENCE)
        i = REFERENCE.at(7e-3)
        assert 0.05 < max(np.abs(off["creep_x"][i]).max(), np.abs(off["creep_t"][i]).max()) < 0.07
