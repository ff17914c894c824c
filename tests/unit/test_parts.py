"""Straights, curves and transitions found in measured alignments whose ends are known."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.alignment import judge
from railcli.analysis.assessment.sections import sections
from railcli.analysis.parts import parts
from railcli.analysis.steady_values import final_stretch
from railcli.files.scenario import load
from railcli.model.limits import Limits
from railcli.model.sections import Curve, Measured, Straight, Transition
from railcli.model.track import Track, pack

ENDS = (0.0, 300.0, 420.0, 920.0, 1040.0, 1300.0)
CURVATURE = (0.0, 0.0, 1.0 / 800.0, 1.0 / 800.0, 0.0, 0.0)
CANT = (0.0, 0.0, 0.1, 0.1, 0.0, 0.0)
KINDS = ["straight", "transition", "curve", "transition", "straight"]
SPARSE = Measured(position=tuple(12400.0 + s for s in ENDS), curvature=CURVATURE, cant=CANT)


def dense(noise, step=0.25):
    s = np.arange(0.0, 1300.0 + step / 2, step)
    return Measured(position=tuple(s), curvature=tuple(np.interp(s, ENDS, CURVATURE) + noise(s)),
                    cant=tuple(np.interp(s, ENDS, CANT)))  # fmt: skip


def white(size):
    return lambda s: size * np.random.default_rng(5).normal(size=s.size)


def waves(s):
    """Alignment of 1 mm in waves of 30 m, and of 1.5 mm in waves of 45 m, seen as curvature."""
    return 4.4e-5 * np.sin(2.0 * np.pi * s / 30.0 + 1.0) + 2.9e-5 * np.sin(2.0 * np.pi * s / 45.0)


def test_points_at_the_ends_of_sections_are_kept():
    found = parts(SPARSE, 50.0)
    assert [part.kind for part in found] == KINDS
    assert_allclose([found[0].start, *(part.end for part in found)], np.array(ENDS) + 50.0, atol=tol.GRID_ROUNDING)
    assert_allclose([part.curvature for part in found], [0.0, 1 / 1600, 1 / 800, 1 / 1600, 0.0], rtol=tol.ROUNDING)


NOISE = {"none": lambda s: 0.0 * s, "3e-5": white(3e-5), "2e-4": white(2e-4), "waves": waves}


@pytest.mark.parametrize("noise", NOISE)
def test_sections_of_a_recording(noise):
    found = parts(dense(NOISE[noise]))
    assert [part.kind for part in found] == KINDS
    assert_allclose([part.end for part in found], ENDS[1:], atol=tol.FOUND_END)
    assert found[2].curvature == pytest.approx(1.0 / 800.0, rel=0.01)


def test_a_reverse_transition_is_two():
    s = np.arange(0.0, 900.0)
    curvature = np.interp(s, (100.0, 200.0, 400.0, 600.0), (0.0, 2e-3, 2e-3, -2e-3))
    found = parts(Measured(position=tuple(s), curvature=tuple(curvature)))
    assert [part.kind for part in found] == ["straight", "transition", "curve", "transition", "transition", "curve"]
    assert found[3].curvature > 0.0 > found[4].curvature and found[3].end == pytest.approx(500.0, abs=3.0)


def described():
    return Track((
        Straight(length=300.0), Transition(length=120.0), Curve(length=500.0, radius=800.0, hand="right", cant=0.1),
        Transition(length=120.0), Straight(length=260.0),
    ))  # fmt: skip


def test_assessment_and_judgement_are_those_of_the_described_track():
    """The same line, once described and once as a table."""
    for one, two in zip(sections(described(), 0.0, 1300.0, 30.0), sections(Track((SPARSE,)), 0.0, 1300.0, 30.0),
                        strict=True):  # fmt: skip
        assert one.kind == two.kind and one.short == two.short
        assert_allclose([one.start, one.end, one.curvature], [two.start, two.end, two.curvature], atol=1e-9)
    judged = [judge(track, pack(track), Limits(), 1.5, 1.435, speed=30.0) for track in (described(), Track((SPARSE,)))]
    for one, two in zip(*judged, strict=True):
        assert two.kind == {"clothoid": "transition"}.get(one.kind, one.kind)
        assert_allclose(list(one.values.values()), list(two.values.values()), atol=1e-9)


@pytest.mark.parametrize(
    ("distance", "curvature", "cant"),
    [(1300.0, 0.0, 0.0), (800.0, 1 / 800, 0.1), (440.0, None, None), (300.0, 0.0, 0.0)],
)
@pytest.mark.parametrize("section", [SPARSE, dense(white(3e-5))], ids=["sparse", "recorded"])
def test_steady_values_in_a_measured_alignment(section, distance, curvature, cant):
    """A window of 100 m in one straight or curve; none where it lies on a transition too."""
    if section is not SPARSE and distance == 300.0:
        distance = 290.0  # the end of the straight is found within a few metres
    case = load("straight-60").varied(run={"distance": distance, "average_over": 100.0}, track=Track((section,)))
    stretch = final_stretch(case)
    if curvature is None:
        assert stretch is None
        return
    assert stretch.curvature == pytest.approx(curvature, abs=1e-5) and stretch.cant == pytest.approx(cant, abs=1e-9)
    assert stretch.kind == ("straight" if curvature == 0.0 else "right-hand curve")
