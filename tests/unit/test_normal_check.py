"""Normal laws under a vertical force without friction: Hertz on round bodies, and what the criteria catch."""

import math

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.normal_check import NormalStates, normal_deviations, normal_rows, normal_states, ranks
from railcli.analysis.rigid_contact import wheelset_on
from railcli.files.contact_reference import contact_criteria, published

SLOPE = 0.05
WORDS = {"sink": "approach", "pressure": "largest pressure", "area": "area", "place": "place"}


@pytest.fixture(scope="module")
def reference():
    return published().normal


@pytest.fixture(scope="module")
def criteria():
    return contact_criteria()["normal"] | {"held": ["it"]}


def test_cone_on_a_round_rail_is_hertz_s():
    """It touches where the rail is as steep as the cone; the normal approach is the sinking times the cosine."""
    angle = math.atan(SLOPE)
    cosine, place = math.cos(angle), -scenes.HEAD * math.sin(angle)
    table = scenes.cone_table(angle)
    settings, pair = table.settings, wheelset_on(table.settings, scenes.cone(angle), scenes.round_rail())
    y, load = np.array([0.0, 1e-3]), np.array([20e3, 90e3])
    wheel = place - y
    touch = scenes.HEAD * (1.0 - cosine) + SLOPE * wheel
    found = normal_states(pair, table, NormalStates(y, np.zeros(2), np.zeros(2), load, touch, {}))
    along, across = 0.5 * cosine / (settings.radius - SLOPE * wheel), 0.5 / scenes.HEAD
    hertz = [
        naive.hertz_ellipse(*pair, settings.young, settings.poisson, normal)
        for *pair, normal in zip(along, [across] * 2, load / cosine, strict=True)
    ]
    a, b, approach = np.transpose(hertz)
    expected = {
        "sink": approach / cosine, "normal": load / cosine, "pressure": 1.5 * load / cosine / (math.pi * a * b),
        "area": math.pi * a * b, "rail": [place] * 2, "wheel": wheel, "patches": [1.0, 1.0], "share": [1.0, 1.0],
    }  # fmt: skip
    assert found.keys() == expected.keys() == published().normal.values.keys()
    for key, values in expected.items():
        assert_allclose(found[key], values, rtol=tol.CONE_HERTZ, atol=tol.CHECKED_PLACE, err_msg=key)


def test_reference_itself_meets_every_criterion(reference, criteria):
    rows = normal_rows("it", reference.values, reference, criteria)
    assert len(rows) == 4 * reference.loads.size
    assert all(row.found == 0.0 and row.kept and row.counts for row in rows)


@pytest.mark.parametrize(
    "key, change, name",
    [
        ("sink", ("times", 1.011), "sink"),
        ("pressure", ("times", 0.92), "pressure"),
        ("area", ("times", 1.16), "area"),
        ("rail", ("plus", 0.41e-3), "place"),
        ("wheel", ("plus", -0.41e-3), "place"),
    ],
)
@pytest.mark.parametrize("count, caught", [(2, False), (4, True)])
def test_criteria_allow_one_state_in_twenty(reference, criteria, key, change, name, count, caught):
    """58 states under each load: 2 may be off by more, 4 may not."""
    values = reference.values | {key: reference.values[key].copy()}
    at = np.flatnonzero(reference.load == 50e3)[:count]
    how, amount = change
    values[key][at] = values[key][at] * amount if how == "times" else values[key][at] + amount
    missed = [row.name for row in normal_rows("it", values, reference, criteria) if not row.kept]
    assert [text.startswith(f"normal law it, 50 kN: {WORDS[name]}") for text in missed] == [True] * caught


def test_laws_that_are_not_held_are_shown_only(reference, criteria):
    rows = normal_rows("another", reference.values, reference, criteria)
    assert not any(row.counts for row in rows)


def test_place_is_that_of_rail_or_wheel_which_is_further_off(reference):
    values = reference.values | {
        "rail": reference.values["rail"] + 0.1e-3, "wheel": reference.values["wheel"] - 0.2e-3,
    }  # fmt: skip
    off = normal_deviations(values, reference)
    assert_allclose(off["place"], -0.2e-3)
    assert all(np.all(off[key] == 0.0) for key in ("sink", "pressure", "area"))
    assert ranks(np.array([-3.0, 1.0, 2.0])) == {"median": 2.0, "p95": pytest.approx(2.9), "largest": 3.0}


def test_reference_covers_every_pose_under_every_load(reference):
    poses = {(round(y * 1e3, 3), round(yaw * 1e3, 3)) for y, yaw in zip(reference.y, reference.yaw, strict=True)}
    assert poses == {(0.5 * i, yaw) for i in range(-14, 15) for yaw in (0.0, 2.0)}
    assert reference.y.size == 58 * 3 and list(reference.loads) == [10e3, 50e3, 100e3]
