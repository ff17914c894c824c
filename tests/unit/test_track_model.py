"""The track description and its pieces against closed forms and quadrature."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from pydantic import ValidationError
from scipy.integrate import quad
from scipy.special import fresnel

from railcli.kernels.layout import PATH_ORDER
from railcli.model.track import LARGEST_TURN, LONGEST_PIECE, MARGIN, Curve, Straight, Track, Transition, pack


def curve(hand="right", radius=300.0, cant=0.15, length=100.0):
    return Curve(length=length, radius=radius, hand=hand, cant=cant)


def turn(shape="clothoid", hand="right", radius=300.0, length=100.0):
    return Track(
        (Straight(length=30.0), Transition(length=length, shape=shape), curve(hand, radius), Transition(length=60.0),
         Straight(length=20.0))
    )  # fmt: skip


def piece_at(pieces, s):
    return pieces[max(np.searchsorted(pieces["start"], s, side="right") - 1, 0)]


def place(pieces, s):
    """Plan position as a complex number, heading, curvature and cant at s, straight from the definition of PIECE."""
    piece = piece_at(pieces, s)
    u = s - piece["start"]
    path = np.sum((piece["path_x"] + 1j * piece["path_y"]) * u ** np.arange(1, PATH_ORDER + 1))
    heading = piece["heading"] + np.sum(piece["curvature"] * u ** np.arange(1, 5) / np.arange(1, 5))
    curvature, cant = (np.sum(piece[name] * u ** np.arange(4)) for name in ("curvature", "cant"))
    return piece["x"] + 1j * piece["y"] + np.exp(1j * piece["heading"]) * path, heading, curvature, cant


def test_clothoid_against_fresnel_integrals():
    """Cornu's spiral with R = 300 m after 100 m, 30 m after the start."""
    pieces = pack(turn())
    scale = np.sqrt(300.0 * 100.0 * np.pi)
    for s in np.linspace(0.0, 100.0, 41):
        sine, cosine = fresnel(s / scale)
        found, heading, curvature, cant = place(pieces, 30.0 + s)
        assert abs(found - (30.0 + scale * (cosine + 1j * sine))) < tol.TRACK_PLACE
        assert heading == pytest.approx(s**2 / 6e4, abs=tol.TRACK_HEADING)
        assert curvature == pytest.approx(s / 3e4, abs=tol.TRACK_HEADING)
        assert cant == pytest.approx(0.15 * s / 100.0, abs=tol.TRACK_HEADING)


def test_curve_is_a_circle():
    pieces = pack(Track((curve("left", 150.0),)))
    for s in np.linspace(-MARGIN, 100.0 + MARGIN, 67):
        found, heading, curvature, cant = place(pieces, s)
        assert abs(found - 150.0j * (np.exp(-1j * s / 150.0) - 1.0)) < tol.TRACK_PLACE
        assert (heading, curvature, cant) == pytest.approx((-s / 150.0, -1.0 / 150.0, -0.15), abs=tol.TRACK_HEADING)


@pytest.mark.parametrize("length", [20.0, 100.0])
@pytest.mark.parametrize("radius", [15.0, 300.0, 1e6])
@pytest.mark.parametrize("shape", ["clothoid", "bloss"])
def test_transition_against_quadrature(shape, radius, length):
    """Bloss: curvature (3 x^2 - 2 x^3) / R with x = s / L, so heading L (x^3 - x^4 / 2) / R."""
    pieces = pack(turn(shape, radius=radius, length=length))

    def heading(s):
        x = s / length
        return length / radius * (x**2 / 2.0 if shape == "clothoid" else x**3 - x**4 / 2.0)

    for s in np.linspace(0.0, length, 5)[1:]:
        x = quad(lambda u: np.cos(heading(u)), 0.0, s, epsabs=1e-13, epsrel=1e-13, limit=200)[0]
        y = quad(lambda u: np.sin(heading(u)), 0.0, s, epsabs=1e-13, epsrel=1e-13, limit=200)[0]
        found, angle, _, _ = place(pieces, 30.0 + s)
        assert abs(found - (30.0 + x + 1j * y)) < tol.TRACK_PLACE
        assert angle == pytest.approx(heading(s), abs=tol.TRACK_HEADING)


@pytest.mark.parametrize("radius", [15.0, 300.0])
@pytest.mark.parametrize("shape", ["clothoid", "bloss"])
def test_polynomials_of_each_piece(shape, radius):
    """Within its piece each polynomial is the integral of exp(i heading), here by Gauss with 20 points."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for piece in pack(turn(shape, radius=radius, length=40.0)):
        for u in (0.4 * piece["length"], piece["length"]):
            at = u * (nodes + 1.0) / 2.0
            heading = np.polynomial.polynomial.polyval(at, [0.0, *piece["curvature"] / np.arange(1, 5)])
            exact = u / 2.0 * np.sum(weights * np.exp(1j * heading))
            path = np.sum((piece["path_x"] + 1j * piece["path_y"]) * u ** np.arange(1, PATH_ORDER + 1))
            assert abs(path - exact) < tol.PLACE


def test_end_heading_is_the_integral_of_curvature():
    """A transition turns by half of what its length would turn in the curve, either shape."""
    for shape in ("clothoid", "bloss"):
        _, heading, curvature, cant = place(pack(turn(shape)), 310.0)
        assert heading == pytest.approx((50.0 + 100.0 + 30.0) / 300.0, abs=tol.TRACK_HEADING)
        assert (curvature, cant) == (0.0, 0.0)


@pytest.mark.parametrize("shape", ["clothoid", "bloss"])
@pytest.mark.parametrize("hand", ["left", "right"])
def test_pieces_join(shape, hand):
    """Position, heading, curvature and cant from both sides of every join; the pieces cover the track and margins."""
    track = Track(
        (curve(hand, 300.0), Transition(length=80.0, shape=shape), curve("left", 180.0, 0.1), curve("left", 180.0, 0.1))
    )
    pieces = pack(track)
    for one, two in zip(pieces, pieces[1:], strict=False):
        assert two["start"] == pytest.approx(one["start"] + one["length"], abs=tol.PLACE)
        before, after = place(pieces[pieces["start"] == one["start"]], two["start"]), place(pieces, two["start"])
        assert_allclose(np.array(before), np.array(after), atol=tol.TRACK_JOIN)
    assert pieces["start"][0] == -MARGIN
    assert pieces["start"][-1] + pieces["length"][-1] == pytest.approx(track.length + MARGIN)
    assert pieces["length"].max() <= LONGEST_PIECE
    steepest = np.maximum(abs(pieces["curvature"][:, 0]), abs(np.append(pieces["curvature"][1:, 0], 0.0)))
    assert (steepest * pieces["length"]).max() <= LARGEST_TURN * (1.0 + tol.ROUNDING)


def test_tangent_of_the_path_is_the_heading():
    pieces = pack(turn("bloss", radius=50.0))
    h = 1e-4
    for s in np.linspace(1.0, 300.0, 31):
        chord = place(pieces, s + h)[0] - place(pieces, s - h)[0]
        assert np.angle(chord * np.exp(-1j * place(pieces, s)[1])) == pytest.approx(0.0, abs=tol.TRACK_TANGENT)


def test_mirrored_hand():
    right, left = pack(turn("bloss", "right")), pack(turn("bloss", "left"))
    for name in ("start", "length", "x", "path_x"):
        assert_allclose(left[name], right[name], atol=tol.PLACE)
    for name in ("y", "heading", "curvature", "cant", "path_y"):
        assert_allclose(left[name], -right[name], atol=tol.PLACE)


def test_right_hand_curve_turns_right_and_lifts_the_left_rail():
    found, heading, curvature, cant = place(pack(turn()), 200.0)
    assert found.imag > 0.0 and heading > 0.0 and curvature == pytest.approx(1.0 / 300.0)
    assert cant == pytest.approx(0.15)


def test_origin_is_where_the_first_section_begins():
    assert place(pack(Track((curve("left", 80.0),))), 0.0)[:2] == (0.0, 0.0)


def test_pieces_are_read_only():
    assert not pack(turn()).flags.writeable


STRAIGHT, TRANSITION = Straight(length=10.0), Transition(length=10.0)
BAD = [
    ((), "has no section"),
    ((TRANSITION, STRAIGHT), "begins or ends with a transition"),
    ((STRAIGHT, TRANSITION), "begins or ends with a transition"),
    ((STRAIGHT, TRANSITION, TRANSITION, curve()), "sections 2 and 3 are both transitions"),
    ((STRAIGHT, curve()), "jumps between sections 1 and 2 (straight, curve)"),
    ((curve(), curve(cant=0.1)), "jumps between sections 1 and 2"),
    ((curve("left"), curve("right")), "jumps between sections 1 and 2"),
]


@pytest.mark.parametrize(("sections", "message"), BAD)
def test_bad_track(sections, message):
    with pytest.raises(ValidationError) as error:
        Track(sections)
    assert message in str(error.value)
