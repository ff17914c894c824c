"""Points of parameter studies: order, samples, distributions and their bounds."""

import math
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError
from scipy import integrate
from tolerances import MOMENT_OF_A_SAMPLE, SUM_OF_A_GRID

from railcli.analysis.design import Design, length, quantile, seeds_of, spread, unit_points, value_of
from railcli.errors import InputError
from railcli.files.scenario import load
from railcli.model.study import Parameter, Sample, Study

SPEED = {"key": "run.speed_kmh", "values": [60.0, 70.0, 80.0]}
FRICTION = {"key": "contact.friction", "from": 0.1, "to": 0.5, "count": 5}
MASS = {"key": "vehicle.body[1].mass_t", "distribution": "uniform", "min": 20.0, "max": 30.0}


def study(*parameters, **more):
    return Study.model_validate({"name": "study", "vary": parameters, **more}, by_alias=True, by_name=False)


def points(design):
    return [tuple(design.point(number).values()) for number in range(design.count)]


def test_lists_and_ranges_are_crossed_the_last_one_fastest():
    found = points(Design(study(SPEED, FRICTION)))

    assert_allclose(found, list(product((60.0, 70.0, 80.0), np.linspace(0.1, 0.5, 5))), rtol=SUM_OF_A_GRID)
    assert found[-1] == (80.0, 0.5)  # the end as it was given


def test_seeds_change_fastest_then_the_sample():
    design = Design(study(SPEED, MASS, sample={"count": 4}, seeds=3))
    rows = points(design)
    assert design.names == ("run.speed_kmh", "vehicle.body[1].mass_t", "seed") and design.count == 3 * 4 * 3
    assert [row[2] for row in rows] == [1, 2, 3] * 12
    masses = [row[1] for row in rows]
    assert masses[0] == masses[1] == masses[2] != masses[3] and masses[:12] == masses[12:24] == masses[24:]
    assert len(set(masses)) == 4


@pytest.mark.parametrize(
    "first, last, step, expected",
    [
        (60, 100, 10, [60, 70, 80, 90, 100]),
        (0.1, 0.4, 0.1, [0.1, 0.2, 0.3, 0.4]),
        (5, 1, 2, [5, 3, 1]),
        (0, 1, 0.4, [0, 0.4, 0.8]),
    ],
)
def test_a_range_by_step_ends_at_its_end_or_before(first, last, step, expected):
    one = Parameter(key="run.speed_kmh", first=float(first), last=float(last), step=float(step))
    assert_allclose([value_of(one, k) for k in range(length(one))], expected, rtol=SUM_OF_A_GRID)


def test_a_point_depends_on_its_number_alone():
    one, other = (Design(study(SPEED, MASS, sample={"count": 64, "method": "sobol"})) for _ in range(2))
    forwards = points(one)
    assert [tuple(other.point(number).values()) for number in reversed(range(other.count))] == forwards[::-1]
    assert one.digest() == other.digest()
    assert one.digest() != Design(study(SPEED, MASS, sample={"count": 64, "method": "sobol", "seed": 2})).digest()


def test_a_grid_beyond_all_measure_is_counted_not_made():
    wide = [{"key": f"vehicle.body[{k}].mass_t", "from": 1, "to": 2, "count": 10**6} for k in range(4)]
    design = Design(study(*wide))
    assert design.count == 10**24
    assert set(design.point(0).values()) == {1.0} and set(design.point(10**24 - 1).values()) == {2.0}


def test_latin_hypercube_has_one_point_in_every_stratum():
    unit = unit_points(Sample(count=50, seed=3), 3)
    assert (np.sort(np.floor(50 * unit), axis=0) == np.arange(50)[:, None]).all()


def test_sobol_points_fill_every_elementary_interval():
    """A scrambled (0, m, 2) net in base 2: every box of area 1/16 has one of 16 points."""
    unit = unit_points(Sample(method="sobol", count=16), 2)
    for k in range(5):
        boxes = np.floor(unit * [2**k, 2 ** (4 - k)]).astype(int)
        assert len({tuple(box) for box in boxes}) == 16


def test_points_for_indices_are_mixtures_of_two_samples():
    unit = unit_points(Sample(method="sobol-indices", count=8), 3).reshape(8, 5, 3)
    a, b = unit[:, 0], unit[:, -1]
    assert not (a == b).any()
    for k in range(3):
        others = [j for j in range(3) if j != k]
        assert (unit[:, 1 + k, k] == b[:, k]).all() and (unit[:, 1 + k][:, others] == a[:, others]).all()


@pytest.mark.parametrize(
    "kind, given, density",
    [
        ("uniform", {"min": 2.0, "max": 5.0}, lambda x: 1.0),
        ("loguniform", {"min": 2.0, "max": 50.0}, lambda x: 1.0 / x),
        ("triangular", {"min": 1.0, "mode": 2.0, "max": 5.0}, lambda x: min(3.0 * (x - 1.0), 5.0 - x)),
        ("normal", {"mean": 0.3, "sd": 0.1, "min": 0.25, "max": 0.6}, lambda x: np.exp(-0.5 * ((x - 0.3) / 0.1) ** 2)),
        (
            "lognormal", {"median": 2.0, "factor": 1.5, "min": 1.0, "max": 9.0},
            lambda x: np.exp(-0.5 * (np.log(x / 2.0) / np.log(1.5)) ** 2) / x,
        ),
    ],
)  # fmt: skip
def test_distributions_have_their_density_within_their_bounds(kind, given, density):
    """Shares of values below a place against the integral of the density cut off at the bounds."""
    entry = {"key": "contact.friction", "distribution": kind, **given}
    one = Parameter.model_validate(entry, by_alias=True, by_name=False)
    x = quantile(one, (np.arange(4000) + 0.5) / 4000)
    low, high = given["min"], given["max"]
    assert low <= x.min() and x.max() <= high and (np.diff(x) > 0.0).all()
    whole = integrate.quad(density, low, high)[0]
    for at in np.linspace(low, high, 7)[1:-1]:
        assert (x < at).mean() == pytest.approx(integrate.quad(density, low, at)[0] / whole, abs=MOMENT_OF_A_SAMPLE)


def test_seeds_of_several_sources_keep_their_distance():
    case = load("random-track")
    sources = tuple(case.irregularity[0].model_copy(update={"seed": seed}) for seed in (7, 19))
    both = case.varied(irregularity=sources)
    assert seeds_of(both, 100) == {"irregularity[1].seed": 100, "irregularity[2].seed": 112}
    assert seeds_of(case, 5) == {"irregularity[1].seed": 5}
    with pytest.raises(InputError, match="no \\[\\[irregularity\\]\\] with a seed"):
        seeds_of(load("curve-300"), 1)


def test_points_to_look_at_lie_all_over():
    assert spread(5, 20) == [0, 1, 2, 3, 4]
    found = spread(10_001, 20)
    assert found[0] == 0 and found[-1] == 10_000 and len(found) == 20
    assert math.isclose(np.diff(found).max(), np.diff(found).min(), abs_tol=1)


@pytest.mark.parametrize(
    "parameters, more, words",
    [
        ([], {}, "names no key to vary"),
        ([{"key": ""}], {}, "names no key"),
        ([{"key": "a.b"}], {}, "give either values, or from and to, or a distribution"),
        ([{**SPEED, "from": 1.0}], {}, "give either values"),
        ([{"key": "a.b", "from": 1.0, "to": 2.0}], {}, "either count or step"),
        ([{"key": "a.b", "from": 1.0, "to": 1.0, "count": 3}], {}, "is one value"),
        ([{**MASS, "max": None}], {"sample": {"count": 4}}, "needs bounds.*got min 20, max none"),
        ([{**MASS, "min": 40.0}], {"sample": {"count": 4}}, "needs bounds"),
        ([{**MASS, "distribution": "normal"}], {"sample": {"count": 4}}, "needs 'mean'"),
        ([{**MASS, "mean": 25.0}], {"sample": {"count": 4}}, "'mean' does not go with"),
        ([{**MASS, "distribution": "loguniform", "min": 0.0}], {"sample": {"count": 4}}, "needs min > 0"),
        (
            [{"key": "a.b", "distribution": "normal", "mean": 0.0, "sd": 1e-3, "min": 0.4, "max": 0.5}],
            {"sample": {"count": 4}}, "next to nothing of the distribution lies from min 0.4 to max 0.5",
        ),
        ([MASS], {}, "has a distribution; give"),
        ([SPEED], {"sample": {"count": 4}}, "no key has a distribution"),
        ([SPEED, SPEED], {}, "stands twice"),
        ([MASS], {"sample": {"count": 100, "method": "sobol"}}, "give 64 or 128, got 100"),
        ([SPEED, MASS], {"sample": {"count": 4, "method": "sobol-indices"}}, "distributions alone"),
        ([SPEED], {"outputs": ["stedy.*"]}, "begins with no group"),
        ([SPEED], {"channel": [{"channel": "wheels/*/Q", "statistics": ["median"]}]}, "'median' is none"),
    ],
)  # fmt: skip
def test_what_is_no_study_is_told(parameters, more, words):
    with pytest.raises(ValidationError, match=words):
        study(*parameters, **more)
