"""The track frame of the compiled core against quadrature of the track's description."""

import naive
import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.kernels.layout import Status, new_data
from railcli.kernels.step import evaluate
from railcli.kernels.track import find_piece
from railcli.model.track import MARGIN, pack

BASE = 1.5
HILLY = [  # gradients, pivot
    pytest.param((), "centre", id="level"),
    pytest.param((), "inner", id="level-inner"),
    pytest.param(scenes.HILLS, "centre", id="hills"),
    pytest.param(scenes.HILLS, "outer", id="hills-outer"),
]
PLACES = np.concatenate([np.linspace(0.01, scenes.WINDING.length - 0.01, 57), [20.0, 60.0, 90.0, 160.0, 190.0]])


def frames_at(wagon, places, gradients=(), pivot="centre"):
    """The core's frames of bodies that stand at these arc lengths, on the centre line."""
    n = len(places)
    pieces = pack(scenes.WINDING, gradients=gradients, pivot=pivot)
    system = scenes.floating(scenes.bodies(wagon, np.ones(n), np.ones((n, 3)), np.zeros(n)), pieces)
    q = np.zeros((n, 6))
    q[:, 0] = places
    return scenes.data_at(system.model, q, np.zeros((n, 6))).frame


@pytest.mark.parametrize(("gradients", "pivot"), HILLY)
def test_origin_and_axes(wagon, gradients, pivot):
    """Heading about z, gradient about y, then cant about x, at every kind of section."""
    for s, frame in zip(PLACES, frames_at(wagon, PLACES, gradients, pivot), strict=True):
        origin, axes = naive.track_pose(scenes.WINDING, s, BASE, gradients, pivot)
        assert_allclose(frame["position"], origin, atol=tol.TRACK_PLACE)
        assert_allclose(frame["track"], axes, atol=tol.TRACK_AXES)


@pytest.mark.parametrize(("gradients", "pivot"), HILLY)
def test_rotation_and_motion_per_metre(wagon, gradients, pivot):
    """The angular velocity of the frame and the velocity of its origin at 1 m/s, by central differences."""
    h, reversal = 1e-3, 90.0 + 70.0 * 0.5680644  # cant 0.15 - 0.25 (3 x^2 - 2 x^3) is zero there
    kinks = np.append(np.cumsum([section.length for section in scenes.WINDING.sections]), reversal)
    kinks = np.append(kinks, naive.bends(gradients))
    for s, frame in zip(PLACES[:57], frames_at(wagon, PLACES[:57], gradients, pivot), strict=True):
        if np.abs(kinks - s).min() < 2 * h:
            continue
        (o1, ahead), (o0, behind) = (naive.track_pose(scenes.WINDING, s + d, BASE, gradients, pivot) for d in (h, -h))
        spin = frame["track"].T @ (ahead - behind) / (2 * h)
        assert_allclose(frame["rate"], (spin[2, 1], spin[0, 2], spin[1, 0]), atol=tol.TRACK_TURNING)
        moved = frame["track"].T @ (o1 - o0) / (2 * h)
        assert_allclose(frame["advance"], moved, atol=tol.TRACK_MOTION)


def test_rails_turn_about_the_pivot(wagon):
    """The pivot rail, half the cant base from the middle, keeps the height that it has on level track."""
    side = {"inner": 1.0, "outer": -1.0}  # of a right-hand curve: +1 right
    for pivot in side:
        (frame,) = frames_at(wagon, [75.0], (), pivot)
        rail = frame["position"] + frame["track"] @ [0.0, side[pivot] * BASE / 2, 0.0]
        assert rail[2] == pytest.approx(0.0, abs=tol.PLACE)


def test_right_hand_curve(wagon):
    """To the right, left rail up: heading and roll grow, the frame turns down its own z."""
    (frame,) = frames_at(wagon, [75.0])
    assert frame["track"][1, 0] > 0.0
    assert frame["track"][2, 1] == pytest.approx(0.1)
    assert_allclose(frame["rate"], (0.0, 0.1 / 250.0, np.sqrt(0.99) / 250.0), atol=tol.TRACK_HEADING)


def test_piece_that_holds_a_place():
    pieces = pack(scenes.WINDING)
    ends = np.append(pieces["start"], pieces["start"][-1] + pieces["length"][-1])
    assert [find_piece(pieces, s) for s in ends] == [*range(pieces.size), pieces.size - 1]
    assert [find_piece(pieces, s) for s in (ends[1:] + ends[:-1]) / 2] == [*range(pieces.size)]
    assert [find_piece(pieces, s) for s in (ends[0] - 1e-9, ends[-1] + 1e-9, np.nan, np.inf, -np.inf)] == [-1] * 5


@pytest.mark.parametrize(
    "s, status", [(scenes.WINDING.length + MARGIN + 1.0, Status.LEFT_TRACK), (np.nan, Status.NOT_FINITE)]
)
def test_off_the_track(wagon, s, status):
    system = scenes.floating(scenes.bodies(wagon, np.ones(2), np.ones((2, 3)), np.zeros(2)), scenes.WINDING)
    data = new_data(system.model, np.zeros((2, 6)), 0)
    data.q[1, 0] = s
    assert evaluate(system.model, data, 0.0) == status
    assert data.fault[0] == 1
