"""Sources of irregularity: signs, shapes, files, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose
from pydantic import ValidationError

from railcli.errors import InputError
from railcli.files import irregularity as files
from railcli.files.scenario import load
from railcli.kernels.layout import NO_SHIFT
from railcli.model import rails
from railcli.model.irregularity import CORNERS, SHAPES, Course, Defect, Spectrum, channels, fade
from railcli.model.irregularity import rails as to_rails
from railcli.model.spectra import CHANNELS
from railcli.model.track import Straight, Track

FRONT = 10.78  # of the Manchester wagon
LEVEL = 1.0
HEAD = "[run]\nspeed_m_per_s = 20\ndistance_m = 200\n[[track]]\nkind = 'straight'\nlength_m = 220\n"
MEASURED = "[[irregularity]]\nkind = 'measured'\nfile = 'track.csv'\n"


def scenario(*sources, length=220.0):
    """The wagon on straight track with sources of irregularity."""
    return load("straight-60").varied(
        run={"distance": length - 20.0}, track=Track((Straight(length=length),)), irregularity=sources
    )


@pytest.mark.parametrize(
    "name, right, left",
    [
        ("vertical", (0, -1), (0, -1)),  # up is minus z
        ("alignment", (1, 0), (1, 0)),
        ("cross_level", (0, 0.5), (0, -0.5)),  # left over right
        ("gauge", (0.5, 0), (-0.5, 0)),
        ("right_vertical", (0, -1), (0, 0)),
        ("left_vertical", (0, 0), (0, -1)),
        ("right_alignment", (1, 0), (0, 0)),
        ("left_alignment", (0, 0), (1, 0)),
    ],
)
def test_signs_of_channels(name, right, left):
    moved = to_rails({name: np.array([2e-3])}, LEVEL)
    assert_allclose(moved[:, :, 0], 2e-3 * np.array([right, left]))


def test_channels_and_rails_are_inverse():
    rng = np.random.default_rng(1)
    wanted = {name: rng.normal(size=5) for name in CHANNELS}
    found = channels(to_rails(wanted, 0.97), 0.97)
    for name in CHANNELS:
        assert_allclose(found[name], wanted[name], atol=tol.ROUNDING)


@pytest.mark.parametrize("shape", SHAPES)
def test_shapes(shape):
    """Height of the shape, its slope as difference quotient, and how it ends."""
    u = np.linspace(-1.0, 5.0, 60_001)
    value, slope = SHAPES[shape](u, 3.0, 0.1)
    extreme = {"dip": -1.0}.get(shape, 1.0)
    assert value[np.abs(value).argmax()] == pytest.approx(extreme, abs=0.1 if shape in CORNERS else 1e-6)
    assert value[0] == 0.0 and value[-1] == pytest.approx({"ramp": 1.0, "step": 1.0}.get(shape, 0.0), abs=tol.ROUNDING)
    assert_allclose(np.gradient(value, u)[1:-1], slope[1:-1], atol=tol.SHAPE_SLOPE)


def test_dip_is_a_low_joint():
    """Two parabolas of slope 4 A / L at the joint, 1 - (2 x / L)^2 beside it, away from its rounding."""
    value, slope = SHAPES["dip"](np.array([0.5, 1.4, 1.6]), 3.0, 1e-3)
    assert_allclose(value, [-((1 / 3) ** 2), -((2.8 / 3) ** 2), -((2.8 / 3) ** 2)], atol=1e-6)
    assert_allclose(slope, [-8 / 9 * 0.5, -8 / 9 * 1.4, 8 / 9 * 1.4], atol=1e-6)


def test_sources_add_up():
    """Two bumps on one rail, one on the other, in both directions; the perfect rest is zero."""
    up = Defect(shape="bump", begin=50.0, length=2.0, amplitude=3e-3, rail="right")
    aside = Defect(shape="bump", begin=50.0, length=2.0, amplitude=1e-3, direction="lateral", rail="left")
    s = np.array([20.0, 51.0, 90.0])
    value, slope = rails.displacement(scenario(up, up, aside), s)
    assert_allclose(value[:, :, 1], [[0.0, -6e-3], [1e-3, 0.0]], atol=tol.ROUNDING)
    assert not value[:, :, [0, 2]].any() and not slope[:, :, [0, 2]].any()


def test_packed_rows():
    """The core's rows hold the sum at equal distances over the whole track, its margins included."""
    case = scenario(Spectrum(spectrum="fra-5", seed=3))
    shift, start, step = rails.pack(case)
    s = start + step * np.arange(shift.shape[0])
    assert s[0] == -50.0 and s[-1] == pytest.approx(270.0)
    value, slope = rails.displacement(case, s)
    assert_allclose(shift[:, 0], value[0, 0], atol=tol.ROUNDING)
    assert_allclose(shift[:, 7], slope[1, 1], atol=tol.ROUNDING)
    assert rails.pack(scenario())[0] is NO_SHIFT
    assert not shift[s <= FRONT].any() and shift[s > FRONT + 10.0].any(axis=1).all()


def test_slopes_belong_to_values():
    """Fade-in and channels: slopes are those of the values."""
    case = scenario(Spectrum(spectrum="b176-high", seed=2, begin=15.0, fade=8.0, shortest=4.0, longest=50.0))
    s = np.linspace(10.0, 200.0, 40_001)
    value, slope = rails.displacement(case, s)
    assert_allclose(np.gradient(value, s, axis=2)[..., 1:-1], slope[..., 1:-1], atol=tol.SAMPLED_SLOPE)
    factor, _ = fade(np.array([15.0, 19.0, 23.0]), 15.0, 8.0)
    assert_allclose(factor, [0.0, 0.5, 1.0], atol=tol.ROUNDING)


def test_realisation_does_not_depend_on_the_other_sources():
    """A defect that asks for a finer grid leaves the random track as it is."""
    random = Spectrum(spectrum="b176-low", seed=9)
    bump = Defect(shape="bump", begin=100.0, length=0.5, amplitude=1e-4)
    s = np.linspace(20.0, 95.0, 400)
    one, both = (rails.displacement(scenario(*sources), s)[0] for sources in ((random,), (random, bump)))
    assert np.array_equal(one, both)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"shortest": 3.0, "longest": 2.0}, "shortest_m must be below longest_m"),
        ({"longest": 500.0}, "longest_m = 500 m is longer than the 200 m of the run"),
        ({"begin": 5.0}, "begin_m must be at least that"),
        ({"spectrum": "b176-lo"}, "did you mean 'b176-low'?"),
        ({"channels": ("vertical", "vertical")}, "names a channel twice"),
    ],
)
def test_refused_spectra(changes, words):
    with pytest.raises(ValidationError, match=words.replace("?", "\\?")):
        scenario(Spectrum(**{"spectrum": "b176-low", **changes}))


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"amplitude": 5.0}, "less than or equal to 0.1"),
        ({"begin": 3.0}, "place it ahead of that"),
        ({"begin": 500.0}, "beyond the 210.78 m"),
        ({"repeat": 3}, "repeat needs every_m"),
        ({"shape": "ramp", "rounding": 2.0}, "at most half of length_m"),
    ],
)
def test_refused_defects(changes, words):
    with pytest.raises(ValidationError, match=words):
        scenario(Defect(**{"shape": "bump", "begin": 50.0, "length": 2.0, "amplitude": 2e-3, **changes}))


def test_too_sharp_for_a_wheel():
    with pytest.raises(InputError, match="bends vertically with a radius of .* a wheel of radius 0.46 m"):
        rails.pack(scenario(Defect(shape="step", begin=50.0, length=0.02, amplitude=2e-3)))


def test_too_many_nodes():
    with pytest.raises(InputError, match="of at most 4,000,000"):
        rails.pack(scenario(Defect(shape="bump", begin=50.0, length=2.0, amplitude=1e-3), length=50_000.0))


def written(tmp_path, text, **changes):
    """A scenario file beside a track file of this text."""
    (tmp_path / "track.csv").write_text(text)
    extra = "".join(f"{key} = {value}\n" for key, value in changes.items())
    path = tmp_path / "case.toml"
    path.write_text(HEAD + MEASURED + extra)
    return path


def samples(end=260.0, spacing=0.25, columns="vertical_mm,cross_level_mm"):
    position = np.arange(0.0, end, spacing)
    lines = [f"{s:g},{2 * np.sin(s / 3):.6f},{np.cos(s / 5):.6f}" for s in position]
    return "\n".join(["# a car's record", f"position_m,{columns}", *lines]) + "\n"


def test_measured_track(tmp_path):
    """Values between the samples, in their signs; what is measured is counted up and left over right."""
    case = load(written(tmp_path, samples()))
    s = np.linspace(30.0, 150.0, 1001)
    value, _ = rails.displacement(case, s)
    found = channels(value, 1.0)
    assert_allclose(found["vertical"], 2e-3 * np.sin(s / 3), atol=tol.MEASURED)
    assert_allclose(found["cross_level"], 1e-3 * np.cos(s / 5), atol=tol.MEASURED)
    down = load(written(tmp_path, samples(), vertical_positive="'down'", offset_m=12.0))
    assert_allclose(
        channels(rails.displacement(down, s)[0], 1.0)["vertical"], -2e-3 * np.sin((s + 12.0) / 3), atol=tol.MEASURED
    )
    assert case.digest() != down.digest()


def test_content_of_a_measured_track_decides_the_digest(tmp_path):
    one = load(written(tmp_path, samples())).digest()
    assert load(written(tmp_path, samples().replace("0,0.000000", "0,0.000100", 1))).digest() != one


def test_written_and_read_back(tmp_path):
    """What `write` writes is read as the same displacement."""
    s = np.linspace(0.0, 200.0, 801)
    case = scenario(Spectrum(spectrum="fra-6", seed=1))
    value, _ = rails.displacement(case, s)
    files.write(tmp_path / "made.csv", s, value, ["a comment"])
    found = files.read(tmp_path / "made.csv")
    assert_allclose(to_rails(found.channels, LEVEL), value, atol=tol.WRITTEN)
    assert_allclose(found.position, s, atol=1e-9)


def lines_changed(change):
    lines = samples().splitlines()
    change(lines)
    return "\n".join(lines)


def swap(lines):
    lines[10], lines[11] = lines[11], lines[10]


@pytest.mark.parametrize(
    "text, words",
    [
        ("", "is empty"),
        (lines_changed(lambda lines: lines.insert(10, lines[10])), "line 12: position 2 m repeats the one before"),
        (lines_changed(swap), "line 12: position 2 m falls below"),
        (lines_changed(lambda lines: lines.__delitem__(slice(40, 80))), "line 41: a gap from 9.25 to 19.5 m"),
        (lines_changed(lambda lines: lines.__setitem__(20, "4.5,nan,0")), "line 21: vertical_mm is 'nan', not"),
        (lines_changed(lambda lines: lines.__setitem__(20, "4.5,x,0")), "line 21: vertical_mm: 'x' is not a number"),
        (lines_changed(lambda lines: lines.__setitem__(20, "4.5,1")), "line 21: 2 values, but 3 columns"),
        (samples(columns="vertical_m,cross_level_mm"), "m; at most 0.1 m can be meant: check the unit"),
        (samples(columns="verticl_mm,cross_level_mm"), "unknown column 'verticl_mm'; did you mean 'vertical_mm'?"),
        (samples(columns="right_vertical_mm,cross_level_mm"), "right_vertical and cross_level say the same"),
        (samples(columns="vertical_mm,level_mm"), "vertical is given twice, by 'vertical_mm' and 'level_mm'"),
        (samples(end=150.0), "covers 0 to 149.75 m, but the run needs 10.78 to 210.78 m of it"),
        ("\x00\x01", "binary"),
    ],
)  # fmt: skip
def test_refused_tracks(tmp_path, text, words):
    """One line that says where and what."""
    with pytest.raises(InputError) as error:
        load(written(tmp_path, text))
    assert words in str(error.value) and "\n" not in str(error.value)


def test_missing_track(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(HEAD + MEASURED)
    with pytest.raises(InputError, match="track.csv: there is no such file"):
        load(path)


def test_toml_units(tmp_path):
    """Keys carry any unit of a length, as everywhere."""
    path = Path(tmp_path / "case.toml")
    path.write_text(
        HEAD + "[[irregularity]]\nkind = 'defect'\nshape = 'bump'\nbegin_km = 0.05\nlength_mm = 3000\n"
        "amplitude_mm = 5\n"
    )
    (defect,) = load(path).irregularity
    assert (defect.begin, defect.length, defect.amplitude) == (50.0, 3.0, 5e-3)
    path.write_text(path.read_text().replace("amplitude_mm", "amplitude"))
    with pytest.raises(InputError, match="irregularity\\[1\\].amplitude: unknown key; did you mean 'amplitude_m"):
        load(path)


def test_course():
    assert rails.course(scenario()) == Course(pytest.approx(FRONT), pytest.approx(200.0 + FRONT), 270.0, 1.0)
