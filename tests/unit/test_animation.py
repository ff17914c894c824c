"""The moving picture: right instants, bodies where they belong, wheels that touch their rails where contacts are."""

import numpy as np
import pytest
import tolerances as tol
from matplotlib.collections import PathCollection

from railcli.errors import InputError
from railcli.files.read_results import Results
from railcli.files.scenario import load
from railcli.report import animation
from railcli.report.animation import Film, frames, magnifications
from railcli.report.curves import Curves
from railcli.report.vehicle_shapes import carriers_of, chain, shapes


@pytest.fixture(scope="module")
def film(recorded):
    with Results(recorded()) as results:
        yield Film(Curves(results, "a"), 30)


def test_frames_are_rows_of_the_result(recorded, monkeypatch):
    """The first and the last row are among them, whatever the pieces in which the file is read."""
    monkeypatch.setattr(animation, "PIECE", 70)
    with Results(recorded()) as results:
        found = frames(results, 12)
        rows = np.searchsorted(results.time, found.time)
        assert rows[0] == 0 and rows[-1] == results.rows - 1 and rows.size == 12
        assert np.array_equal(results.time[rows], found.time)
        assert np.array_equal(results.read("bodies/bogie 2/rotation")[rows], found.rotation["bogie 2"])
        assert np.array_equal(results.read("wheels/W3_left/contact/normal")[rows], found.normal["W3_left"])
        assert np.array_equal(results.s[rows], found.s)
        assert frames(results, 10_000).time.size == results.rows


@pytest.mark.parametrize(("moved", "rolled", "expected"), [
    (0.07, 0.0, (10.0, 10.0)), (0.3, 0.0, (2.0, 2.0)), (0.01, 0.02, (50.0, 10.0)), (5.0, 1.0, (1.0, 1.0)),
    (0.0, 0.0, (1000.0, 1000.0)),
])  # fmt: skip
def test_magnification_is_a_round_number_that_fits(moved, rolled, expected):
    """0.7 m of displacement and 0.2 rad of roll fit into the picture."""
    place, turn = np.zeros((3, 3)), np.zeros((3, 3))
    place[1, 1], turn[2, 0] = moved, -rolled
    shown = animation.Frames(None, None, {"a": place}, {"a": turn}, {}, {}, {})
    assert magnifications(shown) == expected


def test_bodies_stand_on_what_the_joints_say():
    vehicle = load("curve-300").vehicle
    assert chain(vehicle, "wheelset 3") == ["wheelset 3", "bogie 2", "car body"]
    assert set(carriers_of(vehicle).values()) == {"bogie 1", "bogie 2", "car body"}
    found = shapes(vehicle, 0.75)
    assert [found[name].kind for name in ("car body", "bogie 1", "wheelset 1")] == ["body", "bogie", "wheelset"]
    radius = vehicle.bodies[vehicle.wheelsets[0]].wheel_radius
    assert np.nanmax(found["wheelset 1"].above[:, 0]) == radius
    assert found["car body"].above[:, 0].max() > 10.78 - 1.0 > found["bogie 1"].above[:, 0].max()


def test_wheels_touch_their_rails_where_the_contacts_are(film, recorded):
    """From near, every dot lies in the rail by the approach of its contact: poses, profiles and contacts agree."""
    with Results(recorded()) as results:
        rows = np.searchsorted(results.time, film._shown.time)
        contact = {
            (side, name): results.read(f"wheels/W1_{side}/contact/{name}")[rows]
            for side in ("right", "left") for name in ("normal", "depth", "angle")
        }  # fmt: skip
    errors = []
    for axis in film.figure.axes:
        if "to scale" not in (title := axis.get_title(loc="left")):
            continue
        side = title.split()[0].lower()
        (rail,) = (patch.get_xy() for patch in axis.patches)
        (dots,) = (item for item in axis.collections if isinstance(item, PathCollection))
        for k in range(len(film)):
            film.show(k)
            bears = contact[side, "normal"][k] > 0.0
            approach = (contact[side, "depth"][k] * np.cos(contact[side, "angle"][k]))[bears]
            inside = [distance(y, z, rail) for y, z in dots.get_offsets()]
            errors += list(np.array(inside) * 1e-3 - approach)
    assert len(errors) >= 2 * len(film)
    assert np.abs(errors).max() < tol.DRAWN_CONTACT


def distance(y, z, outline):
    """Of a point from a line of many short pieces."""
    start, along = outline[:-1], np.diff(outline, axis=0)
    long = np.hypot(*along.T) > 0.0
    start, along = start[long], along[long]
    share = np.clip(((np.array([y, z]) - start) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return np.hypot(*(start + share[:, None] * along - [y, z]).T).min()


def test_displacements_are_magnified(recorded):
    """Twice the factor, twice as far from the place without any; a wheelset that yaws to the right turns clockwise."""
    with Results(recorded()) as results:
        one, two = (Film(Curves(results, "a"), 5, factor) for factor in (10.0, 20.0))
    outline = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    ahead, position, yaw = one._at("wheelset 1", 4), *(
        getattr(one._shown, name)["wheelset 1"][4] for name in ("position", "rotation")
    )
    for film, factor in ((one, 10.0), (two, 20.0)):
        origin, front, right = film._above("wheelset 1", outline, 4)
        np.testing.assert_allclose(origin, [ahead, factor * position[1]], rtol=tol.ROUNDING)
        np.testing.assert_allclose(front - origin, [1.0, factor * yaw[2]], rtol=tol.ROUNDING)
        np.testing.assert_allclose(right - origin, [-factor * yaw[2], 1.0], rtol=tol.ROUNDING)


def test_films_that_cannot_be_made_are_refused(recorded, monkeypatch):
    monkeypatch.setattr(animation.FFMpegWriter, "isAvailable", classmethod(lambda _: False))
    with Results(recorded()) as results:
        several = [Curves(results, "a")]
        animation.check(several, "gif", 4)
        with pytest.raises(InputError, match="ffmpeg"):
            animation.check(several, "mp4", 1)
        with pytest.raises(InputError, match="has 4 wheelsets, got 5"):
            animation.check(several, "page", 5)
