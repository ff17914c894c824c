"""The track description and its pieces against closed forms and quadrature."""

import naive
import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from pydantic import ValidationError
from scipy.integrate import quad
from scipy.special import fresnel

from railcli.kernels.layout import PATH_ORDER
from railcli.model.sections import Curve, Gradient, Measured, Straight, Transition
from railcli.model.track import LARGEST_TURN, LONGEST_PIECE, MARGIN, Track, gradient_course, pack


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


@pytest.mark.parametrize("shape", ["helmert", "cosine", "sine"])
def test_other_shapes_against_quadrature(shape):
    """Curvature, cant, heading and place of the shapes in pieces; where a sine is made of cubics, to their error."""
    length, radius = 80.0, 300.0
    pieces = pack(turn(shape, radius=radius, length=length))
    share, turned = naive.SHARES[shape]
    for s in np.linspace(0.0, length, 23):
        found, heading, curvature, cant = place(pieces, 30.0 + s)
        x, y = (
            quad(lambda u, part=part: part(length / radius * turned(u / length)), 0.0, s, epsabs=1e-12, limit=200)[0]
            for part in (np.cos, np.sin)
        )
        assert curvature * radius == pytest.approx(share(s / length), abs=tol.TRACK_SINE)
        assert cant / 0.15 == pytest.approx(share(s / length), abs=tol.TRACK_SINE)
        assert heading == pytest.approx(length / radius * turned(s / length), abs=tol.TRACK_SINE * length / radius)
        assert abs(found - (30.0 + x + 1j * y)) < tol.TRACK_SINE * length**2 / radius


@pytest.mark.parametrize(
    ("shape", "smooth"), [("clothoid", 0), ("bloss", 1), ("helmert", 1), ("cosine", 1), ("sine", 2)]
)
def test_promised_smoothness(shape, smooth):
    """Jumps where pieces meet, in a curve, a transition to the other hand, and out: value, slope, second derivative.

    A clothoid's slope jumps at its ends; that of Bloss, Helmert and cosine does not; a sine's second derivative does
    not jump at the ends either.
    """
    track = Track((curve("left", 400.0), Transition(length=90.0, shape=shape), curve("right", 300.0, 0.1)))
    pieces = pack(track)
    ends = [piece["start"] for piece in pieces if abs(piece["start"] % 90.0 - 10.0) < 1e-6]
    for name in ("curvature", "cant"):
        c, u = pieces[name], pieces["length"]
        behind = [c[:, 0] + u * (c[:, 1] + u * (c[:, 2] + u * c[:, 3])), c[:, 1] + u * (2 * c[:, 2] + 3 * u * c[:, 3])]
        ahead = [c[:, 0], c[:, 1]]
        scale = np.ptp(c[:, 0])
        for order in range(min(smooth, 1) + 1):
            jump = np.abs(behind[order][:-1] - ahead[order][1:])
            assert jump.max() * 90.0**order < tol.TRACK_HEADING * scale * 1e3
        bent = np.abs(c[np.isin(pieces["start"], ends), 2]).max() * 90.0**2 / scale
        assert (bent < 0.25) == (smooth == 2 or shape == "clothoid")


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
def test_vertical_curve_is_a_circle():
    """From 30 m level into 20 per mille: height R (1 - cos), then R (1 - cos) + sin times the length."""
    track = Track((Straight(length=100.0),))
    radius, climb = 1000.0, np.arctan(0.02)
    gradients = (Gradient(at=30.0 + radius * climb / 2.0, gradient=0.02, radius=radius),)
    s, angle = gradient_course(track, gradients)
    assert_allclose(s, [30.0, 30.0 + radius * climb], atol=tol.PLACE)
    assert_allclose(angle, [0.0, climb], atol=tol.PLACE)
    pieces = pack(track, gradients=gradients)

    def level(s):
        piece = piece_at(pieces, s)
        powers = (s - piece["start"]) ** np.arange(1, PATH_ORDER + 1)
        return piece["x"] + piece["path_x"] @ powers, piece["z"] + piece["path_z"] @ powers

    for u in np.linspace(0.0, radius * climb, 9):
        x, z = level(30.0 + u)
        assert x == pytest.approx(30.0 + radius * np.sin(u / radius), abs=tol.TRACK_PLACE)
        assert -z == pytest.approx(radius * (1.0 - np.cos(u / radius)), abs=tol.TRACK_PLACE)
    top = radius * (1.0 - np.cos(climb)), 30.0 + radius * np.sin(climb)
    rest = 100.0 - 30.0 - radius * climb
    assert level(100.0) == pytest.approx((top[1] + rest * np.cos(climb), -top[0] - rest * np.sin(climb)))


def test_level_track_is_marked_level():
    """So that the core need not look at gradients; only pieces on slopes are marked."""
    track = Track((Straight(length=200.0),))
    assert not pack(track)["graded"].any()
    graded = pack(track, gradients=(Gradient(at=100.0, gradient=0.01, radius=1000.0),))
    assert_allclose(graded["graded"], graded["start"] + graded["length"] > 96.0)


def test_measured_table_is_the_same_track():
    """A table with points where sections begin and end is the clothoid, curve and gradient that it was made from."""
    track, gradients = turn(), (Gradient(gradient=0.01),)
    positions = (100.0, 130.0, 230.0, 330.0, 390.0, 410.0)
    table = Measured(
        position=positions,
        curvature=(0.0, 0.0, 1 / 300, 1 / 300, 0.0, 0.0),
        cant=(0.0, 0.0, 0.15, 0.15, 0.0, 0.0),
        gradient=(0.01,) * 6,
    )
    one, other = pack(track, gradients=gradients), pack(Track((table,)))
    for s in np.linspace(-20.0, 340.0, 50):
        assert_allclose(np.array(place(other, s)), np.array(place(one, s)), atol=tol.TRACK_JOIN)
        assert piece_at(other, s)["gradient"][0] == pytest.approx(np.arctan(0.01))


def test_rails_of_a_widened_curve():
    """The inner rail stands aside in the curve and halfway in the middle of a transition, either hand."""
    track = Track(
        (
            Straight(length=20.0),
            Transition(length=40.0),
            Curve(length=30.0, radius=150.0, hand="right", gauge_widening=0.01),
            Transition(length=40.0, shape="bloss"),
            Curve(length=30.0, radius=200.0, hand="left", gauge_widening=0.004),
        )
    )
    left, right = track.shifts([-5.0, 10.0, 40.0, 75.0, 100.0, 110.0, 145.0, 200.0], 1.435)
    share = 3 * 0.25**2 - 2 * 0.25**3
    assert_allclose(right, [0.0, 0.0, 0.005, 0.01, 0.01 * (1 - share), 0.005, 0.0, 0.0], atol=tol.PLACE)
    assert_allclose(left, [0.0, 0.0, 0.0, 0.0, -0.004 * share, -0.002, -0.004, -0.004], atol=tol.PLACE)


def test_rails_of_a_measured_gauge():
    table = Measured(position=(0.0, 10.0, 20.0), curvature=(0.0,) * 3, gauge=(1.435, 1.445, 1.431))
    left, right = Track((table,)).shifts([5.0, 10.0, 20.0], 1.435)
    assert_allclose(right, [0.0025, 0.005, -0.002], atol=tol.PLACE)
    assert_allclose(left, -right, atol=tol.PLACE)


BAD = [
    ((), "has no section"),
    ((TRANSITION, STRAIGHT), "begins or ends with a transition"),
    ((STRAIGHT, TRANSITION), "begins or ends with a transition"),
    ((STRAIGHT, TRANSITION, TRANSITION, curve()), "sections 2 and 3 are both transitions"),
    ((STRAIGHT, curve()), "jumps between sections 1 and 2 (straight, curve)"),
    ((curve(), curve(cant=0.1)), "jumps between sections 1 and 2"),
    ((curve("left"), curve("right")), "jumps between sections 1 and 2"),
    ((STRAIGHT, Straight(length=10.0, cant=0.05)), "jumps between sections 1 and 2"),
    ((curve(), curve().model_copy(update={"gauge_widening": 0.01})), "gauge jumps between sections 1 and 2"),
]


@pytest.mark.parametrize(("sections", "message"), BAD)
def test_bad_track(sections, message):
    with pytest.raises(ValidationError) as error:
        Track(sections)
    assert message in str(error.value)


BAD_GRADIENTS = [
    ((Gradient(at=50.0, gradient=0.01),), "gradient 1: radius_m of the vertical curve is missing"),
    ((Gradient(at=20.0, gradient=0.02, radius=5000.0),), "would begin at -29.9933 m, before 0 m where the track"),
    (
        (Gradient(at=60.0, gradient=0.02, radius=2000.0), Gradient(at=90.0, gradient=0.0, radius=2000.0)),
        "gradient 2: its vertical curve would begin at 70.0027 m, before 79.9973 m where the one before it ends",
    ),
    ((Gradient(at=500.0, gradient=0.02, radius=2000.0),), "behind the end of the track, 200 m"),
]


@pytest.mark.parametrize(("gradients", "message"), BAD_GRADIENTS)
def test_bad_gradients(gradients, message):
    with pytest.raises(ValueError, match=message):
        gradient_course(Track((Straight(length=200.0),)), gradients)


BAD_TABLES = [
    ({"position": (0.0, 1.0, 1.0)}, "position repeats: 1 m follows 1 m"),
    ({"position": (0.0, 2.0, 1.0)}, "position falls: 1 m follows 2 m"),
    ({"curvature": (0.0, 0.0)}, "3 positions and 2 values of curvature"),
    ({"curvature": (0.0, 1.2, 0.0)}, "curvature 1.2 1/m at 1 m: must be -0.1 to 0.1 1/m; check the unit"),
    ({"cant": (0.0, 5.0, 0.0)}, "cant 5000 mm at 1 m"),
    ({"gradient": (0.0, -2.5, 0.0)}, "gradient -2500 per mille at 1 m"),
    ({"gauge": (1.435, 1.435, 1435.0)}, "gauge 1.435e+06 mm at 2 m"),
    ({"cant": (0.0, float("nan"), 0.0)}, "finite"),
]


@pytest.mark.parametrize(("change", "message"), BAD_TABLES)
def test_bad_measured_table(change, message):
    with pytest.raises(ValidationError) as error:
        Measured(**{"position": (0.0, 1.0, 2.0), "curvature": (0.0,) * 3, **change})
    assert message in str(error.value)
