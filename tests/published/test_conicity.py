"""Equivalent conicity against the tables of EN 15302 (benchmarks/conicity/SOURCES.md)."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.conicity import conicity, rolling
from railcli.analysis.conicity_check import COMBINATIONS, REACH, near_jumps, quadrature_error, reference_wheelset
from railcli.files.conicity_reference import conicity_criteria, reference_profiles, reference_tables

FOLDER = Path(__file__).parents[2] / "benchmarks/conicity"
TABLES = reference_tables()
PROFILES = {"sections": reference_profiles(), "digitised": reference_profiles(digitised=True)}


def contact_of(combination, profiles="sections", with_roll=False, reach=REACH):
    wheel, rail = COMBINATIONS[combination]
    return rolling(reference_wheelset(PROFILES[profiles][wheel], PROFILES[profiles][rail]), reach, with_roll)


@pytest.fixture(scope="module")
def contacts():
    return {name: contact_of(name) for name in COMBINATIONS}


def ours(contact, table):
    return np.array([motion.conicity for motion in conicity(contact, table.amplitude)])


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_tables_of_2021(contacts, combination):
    table = TABLES["2021", combination]
    assert table.amplitude.size == 33 and table.y.size == 69
    away = ~near_jumps(contacts[combination], table.amplitude, 0.1e-3)
    assert np.count_nonzero(away) >= 28
    found = ours(contacts[combination], table)
    assert_allclose(found[away], table.conicity[away], atol=tol.EN15302_CONICITY, rtol=0.0)
    assert np.all(np.abs(found - table.conicity) <= np.minimum(0.05, 0.5 * table.conicity))


@pytest.mark.parametrize("profiles", PROFILES)
@pytest.mark.parametrize("combination", COMBINATIONS)
def test_tolerance_of_the_standard(combination, profiles):
    """Also from the digitised points, noise and all."""
    table = TABLES["2021", combination]
    found = ours(contact_of(combination, profiles), table)
    assert np.all(np.abs(found - table.conicity) <= np.minimum(0.05, 0.5 * table.conicity))


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_conicity_of_2008_follows_from_its_own_delta_r(combination):
    assert quadrature_error(TABLES["2008", combination]) <= conicity_criteria()["quadrature"]["own_table"]


def test_jumps_of_h_on_a_lie_between_the_table_s_values(contacts):
    contact = contacts["H/A"]
    places = contact.y[contact.jumps]
    assert np.count_nonzero((places > 2.5e-3) & (places < 2.6e-3)) == 1
    assert np.count_nonzero((places > 6.7e-3) & (places < 6.8e-3)) == 1
    assert np.count_nonzero(places > 0.0) == 2


def test_delta_r_of_h_on_a(contacts):
    table = TABLES["2021", "H/A"]
    contact = contacts["H/A"]
    assert_allclose(
        np.interp(table.y, contact.y, contact.radius_difference), table.difference, atol=tol.EN15302_DELTA_R
    )


def test_delta_r_of_a_on_a_with_and_without_roll(contacts):
    """At 2 mm: 0.667 mm level (the table); 0.677 mm with roll, y taken at rail level (an independent computation)."""
    level = contacts["A/A"]
    assert_allclose(np.interp(2e-3, level.y, level.radius_difference), 0.667e-3, atol=tol.EN15302_DELTA_R)
    rolled = contact_of("A/A", with_roll=True, reach=2.2e-3)
    at_rail = rolled.y - rolled.wheelset.radius * np.sin(rolled.values["roll"])
    assert_allclose(np.interp(2e-3, at_rail, rolled.radius_difference), 0.677e-3, atol=tol.EN15302_ROLL)


def test_profiles_are_what_the_script_writes(tmp_path):
    subprocess.run([sys.executable, FOLDER / "generate.py", tmp_path], check=True, capture_output=True)
    for path in tmp_path.iterdir():
        assert path.read_text() == (FOLDER / path.name).read_text()
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("name", PROFILES["sections"])
def test_sections_are_the_digitised_points(name):
    """Two editions, two sources: heights on treads and head; the older one rounds the corner of wheel H."""
    section, points = (PROFILES[key][name] for key in ("sections", "digitised"))
    y = np.linspace(-25e-3, 25e-3, 501)
    found = np.interp(y, section.y, section.z) - np.interp(y, points.y, points.z)
    corner = np.abs(y + 10.23e-3) < 2.0e-3
    assert_allclose(found[~corner], 0.0, atol=tol.EN15302_EDITIONS)
