"""What EN 13803 says to an alignment: closed forms of deficiency, rates, twist; limits and who sets them."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.alignment import LIMITS, course, deficiency, judge
from railcli.model.limits import Limits
from railcli.model.sections import Curve, Gradient, Straight, Transition
from railcli.model.track import Track, pack

BASE, GRAVITY, SPEED, RADIUS, CANT, LENGTH = 1.5, 9.81, 25.0, 600.0, 0.110, 90.0


def turn(shape="clothoid", hand="right", cant=CANT, radius=RADIUS):
    return Track(
        (
            Straight(length=50.0),
            Transition(length=LENGTH, shape=shape),
            Curve(length=80.0, radius=radius, hand=hand, cant=cant),
        )
    )


def judged(track, speed=SPEED, gradients=(), **limits):
    pieces = pack(track, gradients=gradients)
    return judge(track, pieces, Limits(**limits), BASE, 1.435, GRAVITY, speed)


def test_balance_is_11_8_v_squared_over_r():
    """Of cant in mm, with km/h and m, for a base of 1500 mm."""
    (found,) = [course(pack(turn()), [200.0])]
    balance = 1e3 * (deficiency(found, SPEED, GRAVITY, BASE) + found.cant)
    assert balance[0] == pytest.approx(11.8 * (3.6 * SPEED) ** 2 / RADIUS, rel=tol.ELEVEN_POINT_EIGHT)


@pytest.mark.parametrize("hand", ["left", "right"])
def test_values_of_a_clothoid(hand):
    """Deficiency of the curve; what changes over the transition does so evenly."""
    straight, transition, curve = judged(turn(hand=hand))
    lack = BASE * SPEED**2 / RADIUS / GRAVITY - CANT
    assert curve.values["cant_deficiency"] == pytest.approx(lack)
    assert curve.values["cant_excess"] == 0.0
    assert transition.values["twist"] == pytest.approx(CANT / LENGTH)
    assert transition.values["cant_rate"] == pytest.approx(SPEED * CANT / LENGTH)
    assert transition.values["cant_deficiency_rate"] == pytest.approx(SPEED * lack / LENGTH)
    assert straight.values["twist"] == curve.values["twist"] == pytest.approx(0.0, abs=tol.TRACK_HEADING)
    assert curve.cant.first == pytest.approx(CANT if hand == "right" else -CANT)


@pytest.mark.parametrize(
    ("shape", "steepest"), [("bloss", 1.5), ("helmert", 2.0), ("cosine", np.pi / 2), ("sine", 2.0)]
)
def test_steepest_slope_of_a_shape(shape, steepest):
    """Over the mean slope, in the middle; a chord of 3 m in 90 m sees a little less."""
    transition = judged(turn(shape))[1]
    assert transition.values["twist"] == pytest.approx(steepest * CANT / LENGTH, rel=tol.CHORD_SLOPE)


def test_excess_of_a_slow_train():
    curve = judged(turn(), speed=5.0)[2]
    assert curve.values["cant_excess"] == pytest.approx(CANT - BASE * 25.0 / RADIUS / GRAVITY)
    assert curve.values["cant_deficiency"] == 0.0


def test_reversing_curve_changes_all_of_both_deficiencies():
    """From a left into a right curve: dI/dt is their sum over the time between."""
    track = Track(
        (
            Curve(length=50.0, radius=RADIUS, hand="left", cant=CANT),
            Transition(length=LENGTH),
            Curve(length=50.0, radius=RADIUS, hand="right", cant=CANT),
        )
    )
    lack = BASE * SPEED**2 / RADIUS / GRAVITY - CANT
    assert judged(track)[1].values["cant_deficiency_rate"] == pytest.approx(2.0 * SPEED * lack / LENGTH)


def test_vertical_acceleration():
    gradients = (Gradient(at=25.0, gradient=0.01, radius=2000.0),)
    straight, transition, _ = judged(turn(), gradients=gradients)
    assert straight.values["vertical_acceleration"] == pytest.approx(SPEED**2 / 2000.0)
    assert transition.values["vertical_acceleration"] == 0.0


def test_without_speed_only_what_needs_none():
    assert set(judged(turn(), speed=None)[2].values) == {"cant", "twist"}


def findings(track, **given):
    return [(one.section, one.key, one.kind) for section in judged(track, **given) for one in section.findings]


@pytest.mark.parametrize(("cant", "kind"), [(0.159, None), (0.161, "normal"), (0.181, "exceptional")])
def test_limits_of_cant(cant, kind):
    found = [one for one in findings(turn(cant=cant)) if one[1] == "cant"]
    assert found == ([] if kind is None else [(3, "cant", kind)])


def test_cant_in_a_small_radius():
    """(R - 50 m) / 1.5 mm/m: 100 mm at 200 m."""
    assert (3, "cant", "small radius") not in findings(turn(radius=200.0, cant=0.0999), speed=10.0)
    assert (3, "cant", "small radius") in findings(turn(radius=200.0, cant=0.101), speed=10.0)


def test_own_limits_take_the_place_of_the_standards():
    lack = BASE * SPEED**2 / RADIUS / GRAVITY - CANT
    assert findings(turn()) == []
    assert findings(turn(), cant_deficiency=lack - 1e-4) == [(3, "cant_deficiency", "own")]
    assert findings(turn(cant=0.17), cant=0.2, twist=0.1, cant_rate=1.0) == []


def test_a_limit_reached_is_not_beyond_it():
    normal = LIMITS["cant"].normal
    assert not [one for one in findings(turn(cant=normal)) if one[1] == "cant"]


def test_course_closes_a_ring():
    """Two half circles and two straights, end at the beginning, turned once."""
    long, half = 80.0, np.pi * 150.0
    curve = {"radius": 150.0, "hand": "right"}
    turns = Transition(length=40.0)
    quarter = half - 40.0  # a transition at either end turns as far as half of it in the curve
    track = Track(
        (Straight(length=long), turns, Curve(length=quarter, **curve), turns) * 2 + (Straight(length=long / 2),)
    )
    end = course(pack(track), [0.0, 2.0 * (long + 80.0 + quarter)])
    assert_allclose(end.heading, [0.0, 2.0 * np.pi], atol=tol.TRACK_JOIN)
    assert_allclose(end.place[1], end.place[0], atol=tol.TRACK_PLACE)
