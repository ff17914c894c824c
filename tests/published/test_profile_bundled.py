"""The bundled profiles against their published dimensions and against coordinates from other sources."""

import hashlib
import math
import runpy
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.files.profiles import BUNDLED, load_profile
from railcli.files.resources import resource
from railcli.model.profile import Profile

DATA = Path(__file__).parents[1] / "data/profiles"
FILES = {name: path for name, (_, path) in BUNDLED.items()}


@cache
def bundled(name):
    return load_profile(name, BUNDLED[name][0])


@cache
def generator():
    """The script beside the data, run without its last step."""
    return SimpleNamespace(**runpy.run_path(str(resource("profiles/generate.py"))))


def inclined(name, one_in):
    return bundled(name).rotated(-math.atan(1 / one_in))


def on_top(profile, slope):
    """The inclined rail with its top (on the R300, turned by `slope`) moved to the origin."""
    return profile.translated(-0.300 * math.sin(slope), -profile.gauge_point()[1])


def points(name, y_sign=1, z_sign=1):
    return np.loadtxt(DATA / name, delimiter=",", skiprows=2) * [y_sign * 1e-3, z_sign * 1e-3]


def distances(profile, found):
    """Distance [m] of each point from the curve, taken as a polyline of 10 micrometres per chord."""
    y, z, _, _ = profile.at(np.linspace(0.0, profile.arc[-1], 20_001))
    start, chord = np.column_stack([y, z])[:-1], np.diff(np.column_stack([y, z]), axis=0)
    square = (chord**2).sum(axis=1)
    result = []
    for point in found:
        t = np.clip(((point - start) * chord).sum(axis=1) / square, 0.0, 1.0)
        result.append(math.sqrt(((point - start - t[:, None] * chord) ** 2).sum(axis=1).min()))
    return np.array(result)


def at_y(profile, y):
    """Arc length at which a rising profile passes y [m]."""
    return np.interp(y, profile.y, profile.arc)


def test_generator_gives_the_files(tmp_path, capsys):
    generator().main(tmp_path)
    for path in FILES.values():
        assert (tmp_path / Path(path).relative_to("profiles")).read_bytes() == resource(path).read_bytes(), path


@pytest.mark.parametrize("path", FILES.values())
def test_source_tells_the_checksum(path):
    digest = hashlib.sha256(resource(path).read_bytes()).hexdigest()
    source = resource(path).parent / "SOURCE.md"
    assert f"`{Path(path).name}` | `{digest}`" in source.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", BUNDLED)
def test_points_are_close(name):
    profile = bundled(name)
    assert np.diff(profile.arc).max() < 0.2501e-3
    middle = (profile.arc[1:] + profile.arc[:-1]) / 2
    tight = np.abs(profile.at(middle)[3]) > 1 / 20.6e-3
    assert np.diff(profile.arc)[tight].max() < 0.1001e-3


def test_flange_and_rim():
    height, thickness, qr, width = bundled("ORES1002").flange_dimensions()
    assert_allclose([height, thickness, width], [28.0e-3, 32.5e-3, 135e-3], atol=tol.FLANGE_DIMENSION)
    assert_allclose(qr, 10.79e-3, atol=tol.FLANGE_QR)


def test_wheel_is_the_published_sections():
    g, wheel = generator(), bundled("ORES1002")
    tread, root, flank = map(g.polynomial, (g.TREAD, g.ROOT, g.FLANK))
    y, z, angle, _ = wheel.at(np.linspace(0.01e-3, at_y(wheel, 59.9e-3), 7001))

    def arc(k, centre):
        return lambda s: (centre[1] - math.copysign(math.sqrt(k * k - (s - centre[0]) ** 2), k), None)

    sections = [
        (g.BACK, arc(*g.BACK_ARC)), (g.TIP_BACK, arc(*g.TIP_ARC)), (g.TIP_FLANK, arc(*g.FLANK_ARC)),
        (g.FLANK_TOP, flank), (g.FLANK_END, arc(*g.ROOT_ARC)), (g.ROOT_START, root), (g.TREAD_START, tread),
        (g.LINE_START, g.polynomial(g.TREAD_LINE)),
    ]  # fmt: skip
    section = np.searchsorted([start for start, _ in sections], y * 1e3, side="right") - 1
    exact = np.array([sections[i][1](s)[0] for i, s in zip(section, y * 1e3, strict=True)]) * 1e-3
    off = np.abs(z - exact) * np.cos(angle)
    closed = section == 5
    assert off[~closed].max() < tol.PROFILE_CURVE
    assert off[closed].max() < tol.SECTION_STEP


def test_wheel_radii():
    """Flange back 20.5, tip 12, flank 20, straight 70 degrees, root 13, straight field side 1:15 (EN 13715 figure)."""
    wheel = bundled("ORES1002")
    for y, curvature in ((-67, -1 / 20.5), (-55, -1 / 12), (-45, -1 / 20), (-37, 1 / 13)):
        assert_allclose(wheel.at(at_y(wheel, y * 1e-3))[3], curvature * 1e3, rtol=tol.PROFILE_RADIUS)
    assert_allclose(math.degrees(wheel.at(at_y(wheel, -39e-3))[2]), -70.0, atol=1e-6)
    assert_allclose(math.tan(wheel.at(at_y(wheel, 50e-3))[2]), -0.066666667, atol=tol.PROFILE_SLOPE)


@pytest.mark.parametrize("name", ["UIC60", "60E1"])
def test_head_radii(name):
    rail = bundled(name)
    for radius, places in ((300, (0.5, 5, 10)), (80, (11, 18, 25.5)), (13, (26.5, 30, 35))):
        for y in places:
            for side in (-1, 1):
                curvature = rail.at(at_y(rail, side * y * 1e-3))[3]
                assert_allclose(curvature, 1e3 / radius, rtol=tol.PROFILE_RADIUS)


@pytest.mark.parametrize("name", ["UIC60", "60E1"])
def test_side_faces(name):
    rail = bundled(name)
    assert rail.z[0] == rail.z[-1] > 37e-3
    below = at_y(rail, np.array([-36.2e-3, -37e-3]))
    assert_allclose(np.tan(rail.at(below)[2]), -20.0, rtol=tol.PROFILE_SLOPE * 400)
    assert_allclose(rail.rotated(-math.atan(1 / 20)).at(below)[2], -math.pi / 2, atol=tol.PROFILE_SLOPE)
    assert_allclose(rail.at(rail.arc[-1] - below)[2], math.atan(20), atol=tol.PROFILE_SLOPE)


def test_head_widths():
    """EN 13674-1: 72 mm wide 14.3 mm below the crown; UIC60: ends of R300 and R80 at 10.5 and 26 mm."""
    rail = bundled("60E1")
    width = 2 * np.interp(0.0143, rail.z[rail.y > 0], rail.y[rail.y > 0])
    assert_allclose(width, 72e-3, atol=0.5e-6)
    rail = bundled("UIC60")
    for end, before, after in ((10.5e-3, 300, 80), (26e-3, 80, 13)):
        sigma = rail.arc[np.argmin(np.abs(rail.y - end))]
        assert_allclose(rail.at(sigma)[0], end, atol=tol.PROFILE_GRID)
        assert_allclose(1e3 / rail.at(sigma - 1e-6)[3], before, rtol=tol.PROFILE_RADIUS)
        assert_allclose(1e3 / rail.at(sigma + 1e-6)[3], after, rtol=tol.PROFILE_RADIUS)


@pytest.mark.parametrize("one_in, inside", [(math.inf, 35.9813), (40, 35.5347), (30, 35.3694), (20, 35.0123)])
def test_gauge_point_of_60e1(one_in, inside):
    assert_allclose(inclined("60E1", one_in).gauge_point()[0], -inside * 1e-3, atol=tol.GAUGE_POINT)


@pytest.mark.parametrize("name", ["UIC60", "60E1"])
def test_top_of_the_inclined_rail(name):
    """At 1:40 the top lies on the R300, whose centre turns about the crown."""
    assert_allclose(
        inclined(name, 40).gauge_point()[1], 0.3 * (math.cos(math.atan(1 / 40)) - 1), atol=tol.PROFILE_CURVE
    )


def test_wheel_of_the_manchester_benchmark():
    found = points("mbench_s1002.csv", y_sign=-1)
    off = distances(bundled("ORES1002"), found)
    edge = found[:, 0] > 59.9e-3
    assert off[~edge].max() < tol.MANCHESTER_WHEEL < tol.INDEPENDENT_PROFILE
    assert off[edge].max() < tol.BROKEN_EDGE < tol.INDEPENDENT_PROFILE


def test_rail_of_the_manchester_benchmark():
    off = distances(on_top(inclined("UIC60", 40), math.atan(1 / 40)), points("mbench_uic60_1in40.csv"))
    assert off.max() < tol.INDEPENDENT_PROFILE


def test_manchester_rail_is_the_same_construction():
    """Its R80 is 51.976 mm wide, so R13 ends where the head is 72 mm wide; its origin is 6 micrometres off the top."""
    head = np.array(generator().rail_head(21.0, 51.97605))
    r13_end = np.flatnonzero(head[:, 2] < -generator().SIDE + 1e-9)[-1]
    assert_allclose(head[r13_end, 0], -36.0, atol=1e-4)
    rail = Profile("72 mm", "rail", head[:, 0] / 1e3, head[:, 1] / 1e3, head[:, 2]).rotated(-math.atan(1 / 40))
    rail = on_top(rail, math.atan(1 / 40)).translated(6.0e-6, 0.0)
    assert distances(rail, points("mbench_uic60_1in40.csv")).max() < tol.MANCHESTER_RAIL


def test_rail_a_of_en_15302():
    """Aligned by the gauge its source states and by its top; its last millimetre towards the field side waves."""
    found = points("en15302_rail_a_1in20.csv", z_sign=-1)
    rail = inclined("UIC60", 20)
    y_gauge, z_top = rail.gauge_point()
    rail = rail.translated((1435.16 - 1500) / 2 * 1e-3 - y_gauge, found[:, 1].min() - z_top)
    off = distances(rail, found)
    y = found[:, 0]
    assert off[y < 38e-3].max() < tol.INDEPENDENT_PROFILE
    assert off[(y > -28e-3) & (y < 29e-3)].max() < tol.EN15302_RAIL_TOP
