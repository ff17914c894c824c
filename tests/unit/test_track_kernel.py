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
PLACES = np.concatenate([np.linspace(0.01, scenes.WINDING.length - 0.01, 57), [20.0, 60.0, 90.0, 160.0, 190.0]])


def frames_at(wagon, places):
    """The core's frames of bodies that stand at these arc lengths, on the centre line."""
    n = len(places)
    system = scenes.floating(scenes.bodies(wagon, np.ones(n), np.ones((n, 3)), np.zeros(n)), scenes.WINDING)
    q = np.zeros((n, 6))
    q[:, 0] = places
    return scenes.data_at(system.model, q, np.zeros((n, 6))).frame


def test_origin_and_axes(wagon):
    """Heading about z, then cant about x, at every kind of section."""
    for s, frame in zip(PLACES, frames_at(wagon, PLACES), strict=True):
        origin, axes = naive.track_pose(scenes.WINDING, s, BASE)
        assert_allclose(frame["position"], origin, atol=tol.TRACK_PLACE)
        assert_allclose(frame["track"], axes, atol=tol.TRACK_AXES)


def test_rotation_per_metre(wagon):
    """The angular velocity of the frame at 1 m/s, by central differences of its axes."""
    h = 1e-3
    for s, frame in zip(PLACES[:57], frames_at(wagon, PLACES[:57]), strict=True):
        if np.abs(np.cumsum([section.length for section in scenes.WINDING.sections]) - s).min() < 2 * h:
            continue
        ahead, behind = (naive.track_pose(scenes.WINDING, s + d, BASE)[1] for d in (h, -h))
        spin = frame["track"].T @ (ahead - behind) / (2 * h)
        assert_allclose(frame["rate"], (spin[2, 1], spin[0, 2], spin[1, 0]), atol=tol.TRACK_TURNING)


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
