"""Profile files as users have them, read and converted; what cannot be read or converted leaves as an InputError."""

import math
from pathlib import Path

import numpy as np
import pytest
import tolerances as tol
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from railcli.analysis.rigid_contact import COLUMNS, contact_at, wheelset_on
from railcli.errors import InputError
from railcli.files.formats import read_points
from railcli.files.profile_import import ImportSettings, canonical_text, import_profile
from railcli.files.profiles import load_profile
from railcli.model.contact_table import TableSettings, mount

SAMPLES = Path(__file__).parents[1] / "data" / "samples"
RAIL, WHEEL = load_profile("UIC60", "rail"), load_profile("ORES1002", "wheel")
TAPE = np.array([70.0, 0.0])
WHOLE = [path for path in sorted(SAMPLES.glob("*.[bwp]*")) if path.name != "final_clean.prw"]
AUTO = ImportSettings()


def points(profile, every=2):
    pick = np.unique(np.r_[np.arange(0, profile.y.size, every), profile.y.size - 1])
    return np.column_stack([profile.y[pick], profile.z[pick]]) * 1e3


def text(rows, separator=" ", form="{:.9g}"):
    return "".join(separator.join(form.format(value) for value in row) + "\n" for row in rows)


def miniprof(rows, header="ColumnDef=X,Y\n"):
    return header + "\n" + text(rows)


def simpack(rows, keys="", kind=1):
    return (
        f"header.begin\n type = {kind} ! kind\nheader.end\nspline.begin\n comment = 'a ! b % c'\n{keys}\n"
        f" point.begin\n{text(rows)} point.end\nspline.end\n"
    )


@pytest.fixture
def write(tmp_path):
    def write(content, name="given.txt"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def refusal(path, **given):
    with pytest.raises(InputError) as caught:
        import_profile(path, ImportSettings(**given))
    message = str(caught.value)
    assert "\n" not in message and message.startswith(str(path))
    return message


def height_over(profile, y):
    """z of a profile at y, from a dense polyline [m]."""
    sigma = np.linspace(0.0, profile.arc[-1], 200_001)
    found_y, found_z, *_ = profile.at(sigma)
    return np.interp(y, np.maximum.accumulate(found_y), found_z)


def decisions(imported):
    return {item["subject"]: item["choice"] for item in imported.account["decisions"]}


# Samples


def test_simpack_wheel_is_the_bundled_s1002():
    found = import_profile(SAMPLES / "MBench_S1002_v3.prw", AUTO).profile
    inside = (found.y > -0.069) & (found.y < 0.0599)
    assert_allclose(found.z[inside], height_over(WHEEL, found.y[inside]), atol=tol.IMPORTED_WHEEL)


def test_simpack_rail_is_the_bundled_uic60_inclined():
    found = import_profile(SAMPLES / "MBench_UIC60_v3.prr", AUTO).profile
    inclined = RAIL.rotated(-math.atan(1 / 40))
    gauge, top = inclined.gauge_point()
    moved = inclined.translated(found.gauge_point()[0] - gauge, -top)
    inside = (found.z < 0.012) & (np.abs(found.angle) < 1.2)
    across = (found.z - height_over(moved, found.y)) * np.cos(found.angle)
    assert np.abs(across[inside]).max() < tol.INDEPENDENT_PROFILE


def test_miniprof_and_simpack_files_of_one_rail_agree():
    one = import_profile(SAMPLES / "MBench_UIC60_v3.ban", AUTO).profile
    other = import_profile(SAMPLES / "MBench_UIC60_v3.prr", AUTO).profile
    distance = np.hypot(one.y[:, None] - other.y, one.z[:, None] - other.z).min(axis=1)
    assert np.sort(distance)[-4] <= tol.IMPORTED_ROUNDING  # 3 points of the one are duplicates in the other
    assert distance.max() <= 1e-7


@pytest.mark.parametrize("name", ["left-wheel-v1-pre-dry.whl", "whl_left_iter288.whl"])
def test_flange_is_what_the_instrument_measured(name):
    """Sd, Sh and qR in the header are the instrument's own: they fix unit, origin, mirror and scale."""
    imported = import_profile(SAMPLES / name, AUTO)
    header = dict(note.split(" in ")[0].split(" = ") for note in imported.account["notes"])
    flange = imported.profile.flange_dimensions()
    measured = [flange.thickness * 1e3, flange.height * 1e3, flange.qr * 1e3]
    assert_allclose(measured, [float(header[key]) for key in ("Sd", "Sh", "qR")], atol=tol.INSTRUMENT_MM)


@pytest.mark.parametrize("path", WHOLE, ids=lambda path: path.name)
@pytest.mark.parametrize("cutoff", [None, 4e-3])
def test_whole_samples_become_canonical_files(path, cutoff, write):
    asked = ImportSettings(smooth=cutoff)
    imported = import_profile(path, asked)
    assert imported.account["unfit"] == []
    again = load_profile(write(canonical_text(imported, asked), "canonical.csv"), imported.account["kind"])
    assert_allclose([again.y, again.z], [imported.profile.y, imported.profile.z], atol=tol.IMPORTED_ROUNDING)
    assert imported.account["points_read"] >= imported.account["points"] - 20


def test_part_of_a_wheel_is_refused():
    assert "y extends over 15.96 mm, but a wheel profile is 60 to 200 mm wide" in refusal(SAMPLES / "final_clean.prw")


def test_smoothing_tells_what_it_does_to_the_running_surface():
    """Seams of this measurement lie at the flange tip: large changes there, small ones where wheels run."""
    account = import_profile(SAMPLES / "Car7216_0001r.whl", ImportSettings(smooth=4e-3)).account
    anywhere = account["smoothing"]["largest_change"]
    running = account["smoothing"]["largest_change_on_running_surface"]
    assert anywhere["position_at_mm"][0] < -50.0 and anywhere["curvature_at_mm"][0] < -50.0
    assert running["position_at_mm"][0] > -40.0 and running["curvature_at_mm"][0] > -40.0
    assert running["position_mm"] < 0.3 * anywhere["position_mm"]
    assert running["curvature_per_m"] < 0.3 * anywhere["curvature_per_m"]


def test_nothing_is_smoothed_unless_asked():
    imported = import_profile(SAMPLES / "whl_left_iter288.whl", AUTO)
    measured = read_points(SAMPLES / "whl_left_iter288.whl")
    kept = measured.y[(measured.y - 70 >= imported.profile.y[0] * 1e3 - 1e-6)] - 70
    assert imported.account["smoothing"] is None
    assert np.isin(np.round(imported.profile.y * 1e3, 6), np.round(kept, 6)).all()


# Unit, mirror, order, origin


@pytest.mark.parametrize("unit, mm", [("mm", 1.0), ("m", 1e3), ("inch", 25.4)])
@pytest.mark.parametrize("y, z", [(1, 1), (-1, 1), (1, -1), (-1, -1)])
@pytest.mark.parametrize("order", [1, -1])
def test_wheel_in_any_axes_and_unit(write, unit, mm, y, z, order):
    rows = (points(WHEEL) * [y, z])[::order] / mm
    imported = import_profile(write(text(rows, form="{:.12g}")), AUTO)
    assert decisions(imported)["units"] == unit
    assert decisions(imported)["kind"] == "wheel"
    assert_allclose(np.column_stack([imported.profile.y, imported.profile.z]) * 1e3, points(WHEEL), atol=1e-6)


@pytest.mark.parametrize("y, z", [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_rail_in_any_axes_needs_a_word_on_its_gauge_side(write, y, z):
    rail = RAIL.rotated(-math.atan(1 / 20))
    path = write(text(points(rail) * [y, z]))
    told = import_profile(path, ImportSettings(mirror_y="yes" if y < 0 else "no")).profile
    distance = points(rail) / 1e3 - np.column_stack([told.y, told.z])
    assert_allclose(np.ptp(distance, axis=0), 0.0, atol=tol.IMPORTED_ROUNDING)
    assert_allclose(told.gauge_point()[1], 0.0, atol=tol.IMPORTED_ROUNDING)
    untold = decisions(import_profile(path, AUTO))
    assert ("warning" in untold) == (y < 0)  # the head leans the wrong way


def test_gensys_rail_counts_towards_the_track_centre(write):
    rail = RAIL.rotated(-math.atan(1 / 40))
    found = import_profile(write("# gensys\n" + text(points(rail) * [-1, 1]), "uic60i40.rail"), AUTO)
    assert decisions(found)["mirror y"] == "yes"
    assert found.profile.gauge_point()[0] < 0
    assert_allclose(np.ptp(found.profile.y), np.ptp(points(rail)[:, 0]) / 1e3, atol=tol.IMPORTED_ROUNDING)


@pytest.mark.parametrize("offset", [0.0, 70.0, 66.0])
def test_wheel_origin_from_its_flange_back(write, offset):
    """The back face is in the file: wherever y counts from, the tape circle is 70 mm away."""
    face = np.column_stack([np.full(20, -70.0), np.linspace(-0.5, 9.0, 20)])
    rows = np.vstack([face, points(WHEEL)]) + [offset, 0.0 if offset == 0 else 3.0]
    assert_allclose(import_profile(write(text(rows)), AUTO).profile.flange_dimensions().thickness, 32.5e-3, atol=1e-6)


def test_wheel_without_flange_back_is_assumed_and_can_be_shifted(write):
    rows = points(WHEEL)[points(WHEEL)[:, 0] > -66.0] + [200.0, 5.0]
    imported = import_profile(write(text(rows)), AUTO)
    origin = next(item for item in imported.account["decisions"] if item["subject"] == "origin")
    assert "assumed" in origin["reason"] and "--shift-y" in origin["reason"]
    thickness = imported.profile.flange_dimensions().thickness
    shifted = import_profile(write(text(rows)), ImportSettings(shift_y=-0.5e-3)).profile
    assert_allclose(np.ptp(shifted.y), np.ptp(imported.profile.y), atol=1e-12)
    assert thickness == pytest.approx(32.5e-3, abs=0.2e-3)
    assert shifted.flange_dimensions().thickness == pytest.approx(thickness - 0.5e-3, abs=0.1e-3)


def test_rail_is_not_shifted(write):
    with pytest.raises(InputError, match="--shift-y: is for wheels"):
        import_profile(write(text(points(RAIL))), ImportSettings(shift_y=1e-3))


# Formats


def test_simpack_operations_in_their_order(write):
    """Against the same operations by hand, with keys for which another order gives other points."""
    keys = {
        "point.dist.min": 0.2,
        "shift.y": 3.0,
        "shift.z": -2.0,
        "rotate": 1.0,
        "units.ang.f": 57.29577951308232,
        "bound.y.min": -60.0,
        "bound.y.max": 58.0,
        "bound.z.min": -3.0,
        "bound.z.max": 26.0,
        "mirror.y": 1,
        "mirror.z": 0,
        "units.len.f": 500.0,
        "inversion": 1,
    }
    rows = points(WHEEL, every=1) * [-1, 1]
    found = read_points(write(simpack(rows, "".join(f"{key} = {value}\n" for key, value in keys.items())), "a.prw"))
    kept = [rows[0]]
    for row in rows[1:]:
        if math.dist(row, kept[-1]) >= 0.2:
            kept.append(row)
    y, z = (np.array(kept) + [3.0, -2.0]).T
    c, s = math.cos(math.radians(1.0)), math.sin(math.radians(1.0))
    y, z = c * y - s * z, s * y + c * z
    inside = (y >= -60) & (y <= 58)
    y, z = -y[inside][::-1], np.clip(z[inside], -3, 26)[::-1]
    assert found.unit_mm == 2.0 and found.kind == "wheel"
    assert_allclose([found.y, found.z], [y, z], atol=1e-6)


def test_simpack_unit(write):
    path = write(simpack(points(WHEEL) / 1e3, "units.len.f = 1"), "metres.prw")
    assert_allclose(import_profile(path, AUTO).profile.flange_dimensions().height, 28e-3, atol=1e-7)


def test_simpack_inactive_bounds_and_comments(write):
    rows = points(WHEEL)
    content = simpack(rows, "bound.y.min = 1\nbound.y.max = 0 ! off").replace(
        "point.begin\n", "point.begin\n!1 2\n% 3 4\n"
    )
    assert_allclose(read_points(write(content, "a.prw")).y, rows[:, 0], atol=1e-6)


@pytest.mark.parametrize(
    "header",
    [
        "ColumnDef=X,Y\nXoffset=-1.5\nYOffset=2\n",
        "MPTypeNo=1\nXOffset=-1.5\nYoffset=2\n",
        '"XOffset=9"\n#XOffset=7\nXOffset=-1.5\nYOffset=2.0\nEmpty=\n',
    ],
)
def test_miniprof_offsets_are_added(write, header):
    rows = points(WHEEL) * [1, 1] + TAPE - [-1.5, 2]
    found = read_points(write(miniprof(rows, header), "a.whl"))
    assert_allclose(np.column_stack([found.y, found.z]), points(WHEEL) + TAPE, atol=1e-6)


def test_miniprof_columns(write):
    rows = points(WHEEL) + TAPE
    table = np.column_stack([np.zeros(len(rows)), rows[:, 1], np.ones(len(rows)), rows[:, 0]])
    found = read_points(write(miniprof(table, "ColumnDef=N,Y,A,X\n"), "a.whl"))
    assert_allclose(np.column_stack([found.y, found.z]), rows, atol=1e-6)


@pytest.mark.parametrize(
    "content",
    [
        "#MINIWHEELPROF\nStock.......:\n 32.58 37.11 14.71 (Sd)\n\n{}",
        "Date=1\nTime=2\n{}",
        "Date=1\n\nTime=2\n\n{}",
        "{}",
    ],
)
def test_miniprof_headers_of_all_ages(write, content):
    rows = points(WHEEL) + TAPE
    found = read_points(write(content.format(text(rows, ", ")), "a.whl"))
    assert_allclose(np.column_stack([found.y, found.z]), rows, atol=1e-6)


def test_miniprof_reference_profile(write):
    rows = points(WHEEL, every=1) + TAPE
    pieces = [
        f"MPD{k}=L {a:.6f} {b:.6f} {c:.6f} {d:.6f}\n"
        for k, ((a, b), (c, d)) in enumerate(zip(rows, rows[1:], strict=False), 1)
    ]
    path = write(f"[Drawing]\nMPDC={len(pieces)}\nMPDN=S1002\n" + "".join(pieces), "s1002.mpt")
    found = import_profile(path, AUTO)
    assert found.account["format"] == "MiniProf reference"
    assert_allclose(np.column_stack([found.profile.y, found.profile.z]) * 1e3, rows - TAPE, atol=2e-6)


@pytest.mark.parametrize(
    "content",
    [
        lambda rows: text(rows, ","),
        lambda rows: text(rows, ";"),
        lambda rows: text(rows, "\t"),
        lambda rows: "# comment\n! one\n\n" + text(rows, "   "),
        lambda rows: text(rows, ";").replace(".", ","),
        lambda rows: text(rows, "\t").replace(".", ","),
        lambda rows: "y [mm]; z [mm]\n" + text(rows, ";"),
        lambda rows: "z_mm,y_mm\n" + text(rows[:, ::-1], ","),
        lambda rows: "no,y_m,z_m\n" + text(np.column_stack([np.arange(len(rows)), rows / 1e3]), ","),
        lambda rows: "X Y\r\n" + text(rows).replace("\n", "\r\n"),
        lambda rows: "lateral height\n" + text(rows),
        lambda rows: "\ufeff" + text(np.column_stack([rows, np.ones(len(rows))]), ","),
    ],
)
def test_columns_as_people_write_them(write, content):
    rows = np.round(points(WHEEL), 5) + 0.0
    rows[:, 0] += 1e-5 * (rows[:, 0] == np.round(rows[:, 0]))  # no whole numbers, which would have no decimal comma
    found = import_profile(write(content(rows), "given.csv"), AUTO).profile
    assert_allclose(np.column_stack([found.y, found.z]) * 1e3, rows, atol=2e-5)


# What is refused


def test_missing_folder_and_huge(tmp_path, write):
    assert refusal(tmp_path / "none.ban").endswith("there is no such file")
    assert refusal(tmp_path).endswith("is a folder, not a profile file")
    path = write(b"1 2\n" * 2_600_000, "huge.ban")
    assert refusal(path).endswith("10.4 MB; a profile file may have at most 10 MB")
    path.write_bytes(b"1 2\n" * 2_400_000)
    assert "2400000 lines; a profile file may have at most 100000" in refusal(path)
    path.write_bytes(b"1 2\n" * 90_000)
    assert refusal(path).endswith("more than 20000 points; thin them out")


@pytest.mark.parametrize("name", ["a.ban", "a.whl", "a.mpt", "a.prr", "a.prw", "a.txt", "a.csv"])
@pytest.mark.parametrize(
    "content", [b"\x89PNG\r\n\x1a\n\x00", b"", b"\n\n", b"hello world\nthis is a letter\n", b"1 2\n3 4\n"]
)
def test_no_profile_at_all(write, name, content):
    refusal(write(content, name))


@pytest.mark.parametrize("path", WHOLE, ids=lambda path: path.name)
@pytest.mark.parametrize("share", [0.02, 0.4])
def test_truncated(path, share, write):
    """Cut off in the middle of a line: refused, whether the header promised more or not."""
    data = path.read_bytes()
    cut = data[: int(len(data) * share)].rstrip(b"0123456789")
    refusal(write(cut, path.name))


def test_cut_off_files_are_told_so(write):
    whole = miniprof(points(WHEEL) + TAPE, f"XYPoints={len(points(WHEEL))}\nColumnDef=X,Y\n")
    assert "it was cut off" in refusal(write(whole[: len(whole) // 2].rpartition("\n")[0] + "\n", "a.whl"))
    assert "seems to be cut off here" in refusal(write(whole[:-8].rstrip() + "\n1.0\n", "a.whl"))
    assert "does not end: the file was cut off" in refusal(
        write(simpack(points(WHEEL)).partition(" point.end")[0], "a.prw")
    )


@pytest.mark.parametrize(
    "profile, units, found", [(WHEEL, "m", "mm"), (RAIL, "inch", "mm"), (RAIL, "m", "mm")], ids=["wheel", "rail", "m"]
)
def test_wrong_unit(write, profile, units, found):
    message = refusal(write(text(points(profile))), kind=profile.kind, units=units)
    assert f"the numbers look like {found}: --units {found}" in message


def test_declared_unit_is_wrong(write):
    message = refusal(write(simpack(points(WHEEL), "units.len.f = 1"), "a.prw"))
    assert "the numbers look like mm: --units mm" in message


def test_mirrored_by_the_user(write):
    assert "--mirror-y must be no or auto, not yes" in refusal(write(text(points(WHEEL))), mirror_y="yes")
    assert "--mirror-z must be no or auto, not yes" in refusal(write(text(points(RAIL))), mirror_z="yes")
    assert "--mirror-z must be yes or auto, not no" in refusal(write(text(points(WHEEL) * [1, -1])), mirror_z="no")


def test_closed_outline(write):
    rows = points(RAIL)
    foot = [[y, 37.5] for y in np.linspace(37, -37, 50)]
    assert "the curve closes on itself" in refusal(write(text(np.vstack([rows, foot, rows[:1]]))))


def test_kind_that_cannot_be_told(write):
    assert "say which with --kind" in refusal(write(text(points(WHEEL) * 0.7)))


@pytest.mark.parametrize(
    "content, name, part",
    [
        ("ColumnDef=A,B\n\n1 2\n", "a.ban", "line 1: ColumnDef is 'A,B'; columns X and Y are needed"),
        ("XOffset=abc\n\n" + text(points(WHEEL)), "a.whl", "line 1: found 'abc'; the offset must be a number"),
        ("\n" + text(points(WHEEL)) + "1 nan\n2 3\n", "a.whl", "found '1 nan'; numbers for X, Y are needed"),
        ("MPD1=A 1 2 3 4\n", "a.mpt", "line 1: found 'A 1 2 3 4'; a straight piece L x1 y1 x2 y2 is needed"),
        ("MPD1=L 1 2 3 4\nMPD2=L 5 5 6 6\n", "a.mpt", "line 2: this piece does not begin where the one before ends"),
        (simpack(points(WHEEL), "mirror.y = 2"), "a.prw", "mirror.y is '2'; 0 or 1 is needed"),
        (simpack(points(WHEEL), "units.len.f = 0"), "a.prw", "units.len.f is '0'; a positive number is needed"),
        (simpack(points(WHEEL), kind=3), "a.prw", "type is '3'; 0 (rail) or 1 (wheel) is needed"),
        (simpack(points(WHEEL), "spline.end\nspline.begin"), "a.prw", "a second block spline"),
        (simpack([[1, 2, 3, 4]]), "a.prw", "found '1 2 3 4'; y, z and perhaps a weight are needed"),
        ("y_mm,z_m\n1,2\n", "a.csv", "line 1: found 'y_mm, z_m'; y and z must have the same unit"),
        (text(points(WHEEL)) + "3 x\n", "a.txt", "found '3 x'; finite numbers for y and z are needed"),
        ("[MDI_HEADER]\nFILE_TYPE = 'wpf'\n", "a.wpf", "this is a TeimOrbit file"),
    ],
)
def test_malformed(write, content, name, part):
    assert part in refusal(write(content, name))


# Whatever comes in, only an InputError comes out

NAMES = st.sampled_from(["a.ban", "a.whl", "a.mpt", "a.prr", "a.prw", "a.rail", "a.txt", "a.csv"])
WORDS = st.sampled_from(
    ["1", "-2.5", "1e5", "nan", "inf", "1e999", ",", ";", "=", "\n", "\n\n", " ", "\t", "!", "#", '"', "'", "XOffset"]
    + ["ColumnDef=X,Y", "XYPoints=9", "MPD1=L 0 0 1 1", "MPDC=3", "header.begin", "header.end", "spline.begin"]
    + ["point.begin", "point.end", "spline.end", "type = 1", "mirror.y=1", "units.len.f = 1000", "y_mm,z_mm", "\xe9"]
)
QUICK = settings(
    max_examples=100, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def survives(path):
    for kind in ("rail", "wheel"):
        try:
            import_profile(path, ImportSettings(kind=kind))
        except InputError as error:
            assert "\n" not in str(error)


@QUICK
@given(
    name=NAMES, content=st.one_of(st.binary(max_size=300), st.lists(WORDS, max_size=60).map("".join).map(str.encode))
)
def test_any_bytes(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    survives(path)


@settings(QUICK, max_examples=60)
@given(
    sample=st.sampled_from(sorted(SAMPLES.glob("*.[bwp]*"))),
    places=st.lists(
        st.tuples(
            st.floats(0, 1),
            st.sampled_from([b"", b"-", b"9", b"e5", b"\n", b"\n\n", b" ", b".", b"=", b"!"]),
            st.integers(0, 40),
        ),
        max_size=8,
    ),
    cut=st.floats(0.1, 1.0),
)
def test_damaged_samples(tmp_path, sample, places, cut):
    data = sample.read_bytes()
    for place, new, length in places:
        at = int(place * len(data))
        data = data[:at] + new + data[at + length :]
    path = tmp_path / sample.name
    path.write_bytes(data[: int(cut * len(data))])
    survives(path)


@settings(QUICK, max_examples=60)
@given(
    kind=st.sampled_from(["rail", "wheel"]),
    swaps=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 10**6)), max_size=5),
    moves=st.lists(st.tuples(st.integers(0, 10**6), st.floats(-80, 80), st.floats(-80, 80)), max_size=12),
    scale=st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
)
def test_distorted_shapes(tmp_path, kind, swaps, moves, scale):
    rows = points(WHEEL if kind == "wheel" else RAIL, every=4)
    for i, dy, dz in moves:
        rows[i % len(rows)] += [dy, dz]
    for i, j in swaps:
        rows[[i % len(rows), j % len(rows)]] = rows[[j % len(rows), i % len(rows)]]
    path = tmp_path / "shape.txt"
    path.write_text(text(rows * scale))
    survives(path)


# Inclination


def worn_to_a_lean(slope, at=0.030):
    """UIC60 worn down to a plane that falls to the gauge side from y = at [m]: points [mm]."""
    y, z = RAIL.y, np.maximum(RAIL.z, np.interp(at, RAIL.y, RAIL.z) + slope * (at - RAIL.y))
    return np.column_stack([y, z]) * 1e3


@pytest.mark.parametrize("word", ["included", "upright", None])
def test_word_on_the_inclination_goes_with_the_rail(write, word):
    inclined = RAIL.rotated(-math.atan(1 / 40))
    given = write(text(points(inclined)), "rail.csv")
    found = import_profile(given, ImportSettings(inclination=word))
    expected = {"included": True, "upright": False, None: None}[word]
    assert found.profile.inclined is expected
    canonical = write(canonical_text(found, AUTO), "canonical.csv")
    assert load_profile(canonical, "rail").inclined is expected
    assert import_profile(canonical, AUTO).profile.inclined is expected
    assert any("--inclination included" in advice for advice in found.account["advice"]) == (word is None)


def test_word_on_the_inclination_must_be_known(write):
    path = write("# Inclination: 1:40\n" + text(points(RAIL)), "rail.csv")
    with pytest.raises(InputError, match=r"line 1: says inclination: '1:40'; allowed: included .* or upright"):
        load_profile(path, "rail")


def test_wheel_has_no_inclination(write):
    with pytest.raises(InputError, match="--inclination: is for rails"):
        import_profile(write(text(points(WHEEL))), ImportSettings(inclination="included"))


def test_rail_worn_to_a_lean_is_fit_and_its_short_field_side_is_told(write):
    slope = math.tan(math.radians(8.0))
    account = import_profile(write(text(worn_to_a_lean(slope))), ImportSettings(kind="rail")).account
    assert account["unfit"] == []
    assert account["dimensions"]["lean_degrees"] == pytest.approx(8.0, abs=0.01)
    assert any("no rail is beyond it" in advice for advice in account["advice"])
    other_way = import_profile(write(text(worn_to_a_lean(slope) * [-1, 1])), ImportSettings(kind="rail")).account
    assert len(other_way["unfit"]) == 1


# Tape circle


def test_same_wheel_rolls_alike_from_whichever_tape_circle_it_counts(write):
    """The tape circle is a name for one of a wheel's radii: delta-r over y does not change with it."""
    face = np.column_stack([np.full(20, -70.0), np.linspace(-0.5, 9.0, 20)])
    given = text(np.vstack([face, points(WHEEL, 1)]) + [66.0, 3.0])  # both origins from the back face
    radii, first = [], None
    for tape in (70.0, 73.8):
        imported = import_profile(write(given), ImportSettings(tape_to_back=tape * 1e-3))
        wheel = load_profile(write(canonical_text(imported, AUTO)), "wheel")
        assert wheel.tape_to_back == pytest.approx(tape * 1e-3, abs=1e-12)
        assert wheel.flange_dimensions().thickness == pytest.approx(32.5e-3, abs=tol.TAPE_THICKNESS)
        first = first or wheel
        radius = 0.46 + float(height_over(first, tape * 1e-3 - 70e-3))
        pair = wheelset_on(TableSettings(tape_to_back=tape * 1e-3, radius=radius, inclination=40.0), wheel, RAIL)
        assert pair.base == pytest.approx(1.36 + 2e-3 * tape)
        contact = contact_at(pair)
        radii.append([contact(y)[k] for y in (1e-3, 3e-3) for k in map(COLUMNS.index, ("r_right", "r_left"))])
    assert np.ptp(radii[0]) > 0.5e-3
    assert_allclose(radii[1], radii[0], rtol=0.0, atol=tol.TAPE_RADIUS)


def test_wheel_of_another_tape_circle_is_refused(write):
    wheel = load_profile(write("# tape circle: 73.8 mm from the flange back\n" + text(points(WHEEL))), "wheel")
    with pytest.raises(InputError, match=r"73.8 mm from the flange back, needed: 70 mm; give --tape-to-back 73.8"):
        mount(wheel, RAIL, TableSettings())
    with pytest.raises(InputError, match="line 1: tape circle 700 mm from the flange back; allowed: 55 to 85 mm"):
        load_profile(write("# tape circle: 700 mm from the flange back\n" + text(points(WHEEL))), "wheel")
    with pytest.raises(InputError, match="--tape-to-back: is for wheels"):
        import_profile(write(text(points(RAIL))), ImportSettings(tape_to_back=0.0738))
