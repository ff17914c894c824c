"""The comparison of two results: sizes and places by hand, instants against every pair."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from railcli.analysis.compare import Tolerances, common_instants, compare

NAN = np.nan
TENTH = Tolerances(0.1, {"N": 0.5})


def test_the_larger_of_both_tolerances_counts():
    """Range 10: 0.1 of it is 1; a channel without range has only the absolute tolerance; so has one of another unit."""
    one = np.array([0.0, 10.0, 5.0, 5.0])
    assert compare("a", "N", one, one + [0, 0, 0.99, 0], TENTH).beyond == 0
    found = compare("a", "N", one, one + [0, 1.01, 0, -4.0], TENTH)
    assert (found.largest, found.row, found.first_row, found.beyond, found.tolerance) == (4.0, 3, 1, 2, 1.0)
    assert (found.one, found.two, found.excess) == (5.0, 1.0, 4.0)
    flat = np.full(3, 7.0)
    assert compare("a", "N", flat, flat + 0.4, TENTH).beyond == 0
    assert compare("a", "N", flat, flat + 0.6, TENTH).beyond == 3
    assert compare("a", "m", flat, flat + 1e-12, TENTH).beyond == 3


def test_a_value_that_only_one_has_is_a_difference():
    one, two = np.array([NAN, 1.0, NAN, 2.0, np.inf]), np.array([NAN, 1.0, 3.0, NAN, np.inf])
    found = compare("a", "N", one, two, Tolerances(1.0, {"N": 1e9}))
    assert (found.beyond, found.one_sided, found.row, found.first_row, found.largest) == (2, 2, 2, 2, 0.0)
    empty = np.full(2, NAN)
    assert compare("a", "N", empty, empty, TENTH).beyond == 0
    assert compare("a", "N", np.array([1.0, 2.0]), np.array([np.inf, 2.0]), TENTH).one_sided == 1


def every_pair(one, two, room):
    return [(i, k) for i, a in enumerate(one) for k, b in enumerate(two) if abs(a - b) <= room]


@given(
    st.lists(st.integers(0, 60), min_size=1, max_size=20, unique=True),
    st.lists(st.integers(0, 60), min_size=1, max_size=20, unique=True),
)
def test_common_instants_are_those_of_every_pair(one, two):
    """Times of a grid, with rounding as a clock that adds steps has it."""
    one, two = np.sort(one) * 0.01, np.sort(two) * 0.01 * (1 + 1e-12)
    rows = common_instants(one, two)
    assert list(zip(*map(list, rows), strict=True)) == every_pair(one, two, 1e-6)


@pytest.mark.parametrize("times", [(np.arange(1, 5) * 0.01, np.arange(1, 9) * 0.005 + 0.0021), ([0.1], [0.2])])
def test_no_instant_in_common(times):
    one, two = common_instants(*map(np.asarray, times))
    assert one.size == two.size == 0
