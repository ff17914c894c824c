"""Repairs of measured points and smoothing, against profiles whose true shape is known."""

import math

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.spatial import cKDTree

from railcli.errors import InputError
from railcli.files.profiles import load_profile
from railcli.model.curation import Curation
from railcli.model.polyline import turns
from railcli.model.profile import Profile
from railcli.model.smoothing import change, mean_curvature, resample, smooth

RAIL, WHEEL = load_profile("UIC60", "rail"), load_profile("ORES1002", "wheel")
TRUE = {"rail": RAIL, "wheel": WHEEL}


def curated(kind, rows):
    rows = np.asarray(rows)
    return Curation("file", kind, rows[:, 0], rows[:, 1], np.arange(1, len(rows) + 1)).run()


def nodes(profile):
    return np.column_stack([profile.y, profile.z])


def off(curation, kind):
    """Largest distance of the repaired points from the true curve, across it [m]."""
    true = TRUE[kind]
    y, z, angle, _ = true.at(np.linspace(0.0, true.arc[-1], 100_001))
    away, near = cKDTree(np.column_stack([y, z])).query(np.column_stack([curation.y, curation.z]))
    assert away.max() < 2e-3
    across = (curation.z - z[near]) * np.cos(angle[near]) - (curation.y - y[near]) * np.sin(angle[near])
    return np.abs(across).max()


# Faults, put into clean profiles


@pytest.mark.parametrize("kind", ["rail", "wheel"])
def test_clean_points_stay(kind):
    found = curated(kind, nodes(TRUE[kind]))
    assert found.faults == {}
    assert_allclose(np.column_stack([found.y, found.z]), nodes(TRUE[kind]), atol=0)


@pytest.mark.parametrize("kind", ["rail", "wheel"])
def test_duplicates(kind):
    rows = np.repeat(nodes(TRUE[kind]), 2, axis=0)
    rows[1::2] += 3e-8
    found = curated(kind, rows)
    assert found.faults["duplicate"].points == len(TRUE[kind].y)
    assert off(found, kind) < 1e-7


@pytest.mark.parametrize("kind", ["rail", "wheel"])
@pytest.mark.parametrize("at", [0.2, 0.35, 0.5, 0.8])
@pytest.mark.parametrize("points", [1, 2, 3])
@pytest.mark.parametrize("height", [0.6e-3, -0.6e-3])
def test_spikes(kind, at, points, height):
    rows = nodes(TRUE[kind])
    first = int(at * len(rows))
    angle = TRUE[kind].angle[first]
    rows[first : first + points] += height * np.array([-math.sin(angle), math.cos(angle)])
    found = curated(kind, rows)
    assert found.faults["spike"].points == points
    assert found.faults["spike"].lines == list(range(first + 1, first + 1 + points))
    assert found.faults["spike"].largest == pytest.approx(abs(height), rel=0.05)
    assert off(found, kind) < 1e-7


@pytest.mark.parametrize("at", [0.3, 0.6])
def test_stitching_that_goes_back(at):
    """Two passes overlap by one point distance: the file runs forward, jumps back, and runs forward again."""
    rows = nodes(WHEEL)
    i = int(at * len(rows))
    step = rows[i + 1] - rows[i]
    stitched = np.vstack([rows[: i + 1], rows[i] - 0.4 * step, rows[i + 1 :]])
    found = curated("wheel", stitched)
    assert found.faults["zigzag"].points == 2
    assert found.y.size == len(rows)
    assert off(found, "wheel") < tol.STITCHED
    assert np.abs(turns(found.y, found.z)).max() < math.radians(60)


def test_loop():
    rows = nodes(WHEEL)
    i = 300
    turn = np.linspace(0, 2 * np.pi, 25)[1:-1]
    circle = rows[i] + 0.8e-3 * np.column_stack([np.sin(turn), 1 - np.cos(turn)])
    found = curated("wheel", np.vstack([rows[: i + 1], circle, rows[i + 1 :]]))
    assert 20 <= found.faults["loop"].points <= 26
    assert off(found, "wheel") < 5e-5


def test_large_loop_is_refused():
    rows = nodes(WHEEL)
    rows[200:400] = rows[200:400][::-1]
    with pytest.raises(InputError, match="file, line [0-9]+: the curve crosses itself|of 1063 points are faulty"):
        curated("wheel", rows)


def test_head_with_its_underside():
    rows = nodes(RAIL)
    under = np.array([[y, 38.5 + (37.1 - y) / 2.75] for y in np.linspace(36.8, 10, 30)]) / 1e3
    left = under[::-1] * [-1, 1]
    found = curated("rail", np.vstack([left, rows, under]))
    assert found.faults["undercut"].points >= 58
    assert off(found, "rail") < 1e-7


def test_gauge_face_that_ends_at_a_lip_goes_on():
    """What lies behind the lip goes, and the gauge, taken to 14 mm below the top, is that of the lip."""
    rows = nodes(RAIL)[(RAIL.z < 11e-3)]
    lip = np.vstack([[rows[0] + [3e-3, 2e-3]], [rows[0] + [2e-3, 1e-3]], rows])
    found = curated("rail", lip)
    assert found.faults["undercut"].points == 2
    assert found.faults["face"].points > 0
    profile = Profile.from_points("lip", "rail", found.y, found.z)
    assert profile.gauge_point()[0] == pytest.approx(rows[0, 0], abs=tol.LIP)


def test_faces_of_a_wheel_are_cut():
    back = np.column_stack([np.full(60, -0.07), np.linspace(-0.03, 0.009, 60)])
    rim = np.column_stack([np.full(40, 0.065), np.linspace(-0.008, -0.03, 40)])
    found = curated("wheel", np.vstack([back, nodes(WHEEL), rim]))
    assert found.faults["end"].points > 50
    assert found.z.min() >= -10e-3
    assert found.y[0] == -0.07 and found.y[-1] == 0.065


def test_mostly_faulty_is_refused():
    random = np.random.default_rng(3)
    rows = nodes(WHEEL)
    rows[:, 1] += 2e-3 * random.standard_normal(len(rows))
    with pytest.raises(InputError, match="points are faulty|of which fewer than 10 are usable|crosses itself"):
        curated("wheel", rows)


def test_corners_are_kept_and_named():
    y = np.linspace(-36e-3, 36e-3, 145)
    z = np.maximum(np.abs(y) - 20e-3, 0.0) * math.tan(math.radians(50))
    found = curated("rail", np.column_stack([y, z]))
    assert_allclose(np.abs(found.y[found.kinks()]), 20e-3, atol=1e-9)


# Smoothing


@pytest.mark.parametrize(
    "wavelength, cutoff", [(2.5e-3, 5e-3), (5e-3, 5e-3), (10e-3, 5e-3), (20e-3, 5e-3), (4e-3, 2e-3)]
)
@pytest.mark.parametrize("slope", [0.0, 70.0, 180.0])
def test_gain_of_the_cutoff_wavelength(wavelength, cutoff, slope):
    """Half of a wave of the cut-off length remains, 1 / (1 + (C / L)^4) of others, at any slope and uneven spacing."""
    random = np.random.default_rng(1)
    s = np.sort(np.r_[0.0, random.uniform(0, 80e-3, 700), 80e-3])
    s = s[np.r_[True, np.diff(s) > 1e-5]]
    c, d = math.cos(math.radians(slope)), math.sin(math.radians(slope))
    wave = 5e-6 * np.sin(2 * np.pi * s / wavelength)
    found = smooth("wave", "rail", c * s - d * wave, d * s + c * wave, cutoff)
    along, across = c * found.y + d * found.z, c * found.z - d * found.y
    inner = (along > 20e-3) & (along < 60e-3)
    phase = 2 * np.pi * along[inner] / wavelength
    amplitude = np.linalg.lstsq(np.column_stack([np.sin(phase), np.cos(phase)]), across[inner], rcond=None)[0]
    assert_allclose(np.hypot(*amplitude) / 5e-6, 1 / (1 + (cutoff / wavelength) ** 4), atol=tol.CUTOFF_GAIN)


def test_arc_shrinks_by_the_formula():
    radius, cutoff = 13e-3, 5e-3
    turn = np.linspace(0.0, 3.0, 200)
    found = smooth("arc", "rail", -radius * np.cos(turn), -radius * np.sin(turn), cutoff)
    radii = np.hypot(found.y, found.z)
    assert_allclose(radius - radii[80:120], (cutoff / (2 * np.pi * radius)) ** 4 * radius, atol=tol.SHRINK)
    assert np.abs(radii - radius).max() < 2e-6  # at the ends too, where a natural spline would lose its curvature
    tangent = np.arctan2(-np.cos(turn), np.sin(turn))
    assert np.abs(np.sin(found.angle - tangent)).max() < 2e-3


def test_smoothing_has_no_axes():
    rows = nodes(WHEEL)
    rows += 5e-6 * np.random.default_rng(5).standard_normal(rows.shape)
    angle = 0.7
    c, s = math.cos(angle), math.sin(angle)
    plain = smooth("a", "wheel", *rows.T, 4e-3).rotated(angle)
    turned = smooth("b", "wheel", c * rows[:, 0] - s * rows[:, 1], s * rows[:, 0] + c * rows[:, 1], 4e-3)
    assert_allclose([turned.y, turned.z], [plain.y, plain.z], atol=tol.ROTATED_SMOOTHING)


def test_smoothing_finds_the_profile_under_noise():
    """Noise of 10 micrometres: what remains is below the part that the cut-off lets pass, and curvature is usable."""
    random = np.random.default_rng(11)
    rows = nodes(WHEEL)[20:-60]
    true = Profile("true", "wheel", WHEEL.y[20:-60], WHEEL.z[20:-60], WHEEL.angle[20:-60])
    noise = 10e-6 * random.standard_normal(len(rows))
    normal = np.column_stack([-np.sin(true.angle), np.cos(true.angle)])
    noisy = rows + noise[:, None] * normal
    found = smooth("noisy", "wheel", *noisy.T, 6e-3)
    across = np.sum((nodes(found) - rows) * normal, axis=1)
    assert np.sqrt(np.mean(across**2)) < 4e-6
    tread = slice(300, 800)
    raw = Profile.from_points("raw", "wheel", *noisy.T)
    error = mean_curvature(found, found.arc)[tread] - mean_curvature(true, true.arc)[tread]
    worse = mean_curvature(raw, raw.arc)[tread] - mean_curvature(true, true.arc)[tread]
    assert np.abs(error).std() < 0.2 * np.abs(worse).std()


def test_corners_stay_when_smoothed():
    y = np.linspace(-36e-3, 36e-3, 289)
    z = np.maximum(np.abs(y) - 20e-3, 0.0) * math.tan(math.radians(50))
    corners = np.flatnonzero(np.abs(np.abs(y) - 20e-3) < 1e-9)
    kept = smooth("chamfers", "rail", y, z, 4e-3, corners)
    assert np.hypot(kept.y - y, kept.z - z).max() < 1e-8
    rounded = smooth("chamfers", "rail", y, z, 4e-3)
    assert np.hypot(rounded.y - y, rounded.z - z).max() > 1e-4


def test_change_is_told():
    z = WHEEL.z.copy()
    z[500] += 20e-6
    bumped = Profile("bumped", "wheel", WHEEL.y, z, WHEEL.angle)
    found = change(WHEEL, bumped)
    assert found["position_mm"] == pytest.approx(20e-3 * math.cos(WHEEL.angle[500]), rel=1e-3)
    assert found["position_at_mm"][0] == pytest.approx(WHEEL.y[500] * 1e3)
    turn = np.linspace(-0.1, 0.1, 101)
    one, other = (Profile("arc", "rail", r * np.sin(turn), r - r * np.cos(turn), turn) for r in (0.30, 0.25))
    assert change(one, other)["curvature_per_m"] == pytest.approx(1 / 0.25 - 1 / 0.30, rel=1e-4)


@pytest.mark.parametrize("kind", ["rail", "wheel"])
def test_resampling(kind):
    found = resample(TRUE[kind], 0.4e-3)
    unequal = np.abs(np.diff(found.arc) - found.arc[1])
    assert np.sort(unequal)[-3] < 1e-9  # but for the edge of 0.1 mm radius
    assert found.arc[1] <= 0.4e-3 + 1e-7
    assert off(found, kind) < 1e-7


@pytest.mark.parametrize("call", [lambda: smooth("a", "wheel", WHEEL.y, WHEEL.z, 1.0), lambda: resample(WHEEL, 1e-6)])
def test_lengths_out_of_range(call):
    with pytest.raises(InputError, match="^--(smooth|resample): the .*; allowed: "):
        call()
