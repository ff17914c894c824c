"""Profile files: what is read, and what is refused with which words."""

import os
import re

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.errors import InputError
from railcli.files import profiles, resources
from railcli.files.profiles import BUNDLED, load_profile
from railcli.files.resources import resource

RAIL, WHEEL = load_profile("UIC60", "rail"), load_profile("ORES1002", "wheel")


def table(profile, every=4, y=1.0, z=1.0):
    """Points in mm, thinned out, the axes scaled."""
    pick = np.unique(np.r_[np.arange(0, profile.y.size, every), profile.y.size - 1])
    return np.column_stack([profile.y[pick] * y, profile.z[pick] * z]) * 1e3


def text(rows, separator=","):
    return "".join(separator.join(f"{value:.9g}" for value in row) + "\n" for row in rows)


@pytest.fixture
def write(tmp_path):
    def write(content, name="given.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def refusal(path, kind):
    with pytest.raises(InputError) as caught:
        load_profile(path, kind)
    message = str(caught.value).partition("; or convert it: ")[0]
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2
    return message


# What is read


@pytest.mark.parametrize("given", ["UIC60", "uic60", "60e1", "ORES1002", "Ores1002"])
def test_bundled_by_name(given):
    name = next(name for name in BUNDLED if name.lower() == given.lower())
    profile = load_profile(given, BUNDLED[name][0])
    assert (profile.name, profile.kind) == (name, BUNDLED[name][0])


def test_a_bundled_file_is_a_file_too():
    assert load_profile(resource("profiles/UIC60/UIC60.csv"), "rail").digest() == RAIL.digest()


@pytest.mark.parametrize("separator", [",", ";", " ", "\t", ", ", " ; ", "   "])
@pytest.mark.parametrize("profile", [RAIL, WHEEL], ids=["rail", "wheel"])
def test_separators(write, separator, profile):
    found = load_profile(write(text(table(profile), separator)), profile.kind)
    assert found.name == "given"
    assert_allclose(found.y, table(profile)[:, 0] / 1e3, atol=tol.PROFILE_GRID * 100)
    assert_allclose(found.z, table(profile)[:, 1] / 1e3, atol=tol.PROFILE_GRID * 100)


def test_comments_blank_lines_and_byte_order_mark(write):
    rows = text(table(RAIL)).splitlines()
    content = "\ufeff# made by hand\n! so\n%so\n\n" + rows[0] + "\n  # within\n" + "\r\n".join(rows[1:]) + "\n\n"
    assert load_profile(write(content), "rail").digest() == load_profile(write(text(table(RAIL))), "rail").digest()


def test_header_names_columns_in_any_order(write):
    rows = table(RAIL)
    plain = load_profile(write(text(rows)), "rail")
    swapped = load_profile(write("z_mm;Y_MM\n" + text(rows[:, ::-1], ";")), "rail")
    metres = load_profile(write('"y_m" "z_m"\n' + text(rows / 1e3, " ")), "rail")
    assert swapped.digest() == plain.digest()
    assert_allclose(metres.y, plain.y, atol=tol.PROFILE_GRID * 100)


@pytest.mark.parametrize("header", ["", "y_mm,z_mm,angle_rad\n"])
def test_third_column_is_the_tangent(write, header):
    rows = np.column_stack([WHEEL.y * 1e3, WHEEL.z * 1e3, WHEEL.angle])
    assert_allclose(load_profile(write(header + text(rows)), "wheel").angle, WHEEL.angle, atol=1e-8)


def test_points_may_run_from_the_field_side(write):
    rows = np.column_stack([WHEEL.y * 1e3, WHEEL.z * 1e3, WHEEL.angle])
    rows[:, 2] += np.pi
    found = load_profile(write(text(rows[::-1])), "wheel")
    assert_allclose(found.y, WHEEL.y, atol=1e-9)
    assert_allclose(found.angle, WHEEL.angle, atol=1e-8)


def test_repeated_points_are_passed_over(write):
    rows = table(RAIL)
    twice = np.repeat(rows, 2, axis=0)
    assert load_profile(write(text(twice)), "rail").digest() == load_profile(write(text(rows)), "rail").digest()


def test_inclined_and_steep_faces_pass(write):
    """A face that overhangs, as at 1:10, is no way back."""
    tilted = RAIL.rotated(-0.1)
    found = load_profile(write(text(table(tilted))), "rail")
    assert np.diff(found.y).min() < 0.0


def test_wheel_with_its_flange_back(write):
    rows = np.vstack([[[-70, z] for z in range(-5, 9)], table(WHEEL)])
    assert_allclose(load_profile(write(text(rows)), "wheel").flange_dimensions().thickness, 32.5e-3, atol=1e-6)


# What is refused: the file


def test_missing(tmp_path):
    path = tmp_path / "none.csv"
    assert refusal(path, "rail") == f"{path}: there is no such file or bundled rail profile; give UIC60, 60E1 or a file"


@pytest.mark.parametrize("given, kind, near", [("UIC6", "rail", "UIC60"), ("60E2", "rail", "60E1")])
def test_nearly_a_name(given, kind, near):
    assert refusal(given, kind) == f"{given}: there is no such file or bundled {kind} profile; did you mean {near}?"


def test_name_of_the_other_kind():
    assert refusal("ores1002", "rail") == (
        "ORES1002: this is a wheel profile, but a rail is needed: give UIC60, 60E1 or a file"
    )
    assert refusal("60E1", "wheel") == "60E1: this is a rail profile, but a wheel is needed: give ORES1002 or a file"


def test_folder(tmp_path):
    assert refusal(tmp_path, "wheel") == f"{tmp_path}: is a folder, not a profile file"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes with names")
def test_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "not a regular file" in refusal(tmp_path / "pipe", "rail")


def test_name_too_long_for_the_system():
    assert "cannot be read" in refusal("x" * 5000, "rail")


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="the superuser may read everything")
def test_no_permission(write):
    path = write(text(table(RAIL)))
    path.chmod(0)
    assert "cannot be read: Permission denied" in refusal(path, "rail")


def test_huge(write, tmp_path):
    path = write(b"")
    with path.open("wb") as file:
        file.truncate(11_000_000)
    assert refusal(path, "rail") == f"{path}: 11.0 MB; a profile file may have at most 10 MB"


@pytest.mark.parametrize("content", ["", "# only a comment\n\n", "y_mm,z_mm\n"])
def test_empty(write, content):
    path = write(content)
    assert refusal(path, "rail") == f"{path}: the file is empty: it has no points"


@pytest.mark.parametrize("content", [b"\x89PNG\r\n\x1a\n\x00\x00", b"1,2\n\x07"])
def test_binary(write, content):
    assert "this is a binary file" in refusal(write(content), "rail")


def test_too_few_points(write):
    path = write(text(table(RAIL)[:9]))
    assert refusal(path, "rail") == f"{path}: only 9 points; a profile needs at least 10"


def test_too_many_points(write):
    rows = np.column_stack([np.linspace(-36, 36, 20_001), np.linspace(-36, 36, 20_001) ** 2 / 100])
    path = write(text(rows))
    assert refusal(path, "rail") == f"{path}: more than 20000 points; thin them out"


# What is refused: a line


@pytest.mark.parametrize(
    "row, found",
    [
        ("1.0,abc", "found '1.0,abc'; 2 numbers (y_mm, z_mm) are needed"),
        ("1.0", "found '1.0'; 2 numbers"),
        ("1.0,2.0,3.0", "found '1.0,2.0,3.0'; 2 numbers"),
        ("1.0,", "found '1.0,'; 2 numbers"),
        ("1,5;2,5", "found '1,5;2,5'; 2 numbers"),
        ("<td>1</td>", "found '<td>1</td>'"),
        ("1.0,nan", "found '1.0,nan'; every number must be finite"),
        ("inf,1.0", "found 'inf,1.0'; every number must be finite"),
        ("1e999,1.0", "every number must be finite"),
        ("\udcff".encode("utf-8", "surrogatepass").decode("latin-1") + ",1", "2 numbers"),
    ],
)
def test_malformed_line(write, row, found):
    lines = text(table(RAIL)).splitlines()
    lines.insert(20, row)
    path = write("# comment\n" + "\n".join(lines))
    message = refusal(path, "rail")
    assert message.startswith(f"{path}, line 22: ")
    assert found in message


def test_long_line_is_cut(write):
    assert len(refusal(write("1 2\n" + "9" * 1000 + "x\n"), "rail")) < 400


@pytest.mark.parametrize("row", ["1", "1,2,3,4"])
def test_number_of_columns(write, row):
    path = write(f"{row}\n")
    columns = row.count(",") + 1
    assert refusal(path, "rail") == f"{path}, line 1: {columns} columns; needed: y and z, or y, z and angle"


@pytest.mark.parametrize("header", ["y,z", "y_mm,y_mm", "y_mm,z_mm,weight", "y_mm", "y_in,z_in", "time,speed"])
def test_unknown_columns(write, header):
    path = write(f"{header}\n" + text(table(RAIL)))
    found = ", ".join(header.split(","))
    assert refusal(path, "rail") == (
        f"{path}, line 1: found columns {found!r}; allowed: y_mm or y_m, z_mm or z_m, and angle_rad if known"
    )


# What is refused: the curve


@pytest.mark.parametrize("profile", [RAIL, WHEEL], ids=["rail", "wheel"])
@pytest.mark.parametrize(
    "factor, unit", [(1 / 25.4, "inches"), (1e-3, "metres"), (0.1, "centimetres"), (1e3, "micrometres")]
)
def test_units(write, profile, factor, unit):
    path = write(text(table(profile) * factor))
    message = refusal(path, profile.kind)
    width = 1e3 * np.ptp(profile.y) * factor
    low, high = {"rail": (57, 87), "wheel": (60, 200)}[profile.kind]
    assert message == (
        f"{path}: y extends over {width:.4g} mm, but a {profile.kind} profile is {low} to {high} mm wide "
        f"(the numbers look like {unit}); give mm, or metres in columns named y_m, z_m"
    )


def test_millimetres_called_metres(write):
    message = refusal(write("y_m,z_m\n" + text(table(RAIL))), "rail")
    assert "y extends over 7.434e+04 mm" in message and "(the numbers look like mm)" in message


def test_wheel_for_a_rail(write):
    message = refusal(write(text(table(WHEEL))), "rail")
    assert "y extends over 135 mm, but a rail profile is 57 to 87 mm wide (is it a wheel?)" in message


@pytest.mark.parametrize(
    "y, z, axes, at", [(-1, 1, "y", "54.96"), (1, -1, "z", "-54.96"), (-1, -1, "y and z", "54.96")]
)
def test_mirrored_wheel(write, y, z, axes, at):
    path = write(text(table(WHEEL, every=1, y=y, z=z)))
    message = refusal(path, "wheel")
    assert message.startswith(f"{path}: the flange tip is at y = {at} mm, z = {28 * z} mm;")
    assert "flange at negative y and positive z (y to the field side, z down)" in message
    assert message.endswith(f": multiply {axes} by -1")


def test_rail_upside_down(write):
    path = write(text(table(RAIL, z=-1)))
    assert refusal(path, "rail") == (
        f"{path}: z at mid-width is 0 mm, at the sides -37.5 and -37.5 mm: the rail is upside down; "
        "z must point down: multiply z by -1"
    )


def test_half_a_rail(write):
    rows = np.array([[y, max(0, y - 5) ** 2 / 20] for y in np.linspace(-40, 30, 141)])
    rows[:20, 1] = -2.0
    assert "not a rail's head, whose sides both lie below its middle" in refusal(write(text(rows)), "rail")


def test_wheel_without_a_flange(write):
    rows = np.column_stack([np.linspace(-70, 65, 100), np.linspace(2, -2, 100)])
    message = refusal(write(text(rows)), "wheel")
    assert re.search(r"what reaches furthest from the tread is 2 mm .*; a flange of 15 to 45 mm is needed", message)


def test_wheel_counted_from_the_flange_back(write):
    message = refusal(write(text(table(WHEEL) + [70, 0])), "wheel")
    assert "the flange tip is at y = " in message and "allowed: -70 to -35 mm" in message
    assert "y must count from the tape circle, usually 70 mm from the flange back" in message


def test_wheel_with_another_zero_of_z(write):
    message = refusal(write(text(table(WHEEL) + [0, 3])), "wheel")
    assert "z at the tape circle (y = 0) is 3 mm, allowed: -0.5 to 0.5 mm; shift z so that it is 0 there" in message


def test_points_out_of_order(write):
    rows = table(RAIL)
    rows[[60, 80]] = rows[[80, 60]]
    path = write(text(rows))
    message = refusal(path, "rail")
    assert message.startswith(f"{path}, line 62: y goes back from {rows[60, 0]:.4g} to {rows[61, 0]:.4g} mm")
    assert "points must follow the curve from one side to the other: sort them" in message


def test_head_with_its_underside(write):
    rows = table(RAIL)
    under = [[y, 38.5 + (37.1 - y) / 2.75] for y in np.linspace(36.8, 10, 30)]
    path = write(text(np.vstack([rows, under])))
    message = refusal(path, "rail")
    assert f"line {len(rows) + 1}: y goes back from 37.17" in message and "cut off what lies below the sides" in message


def test_fold_on_a_vertical_face(write):
    rows = np.vstack([[[-70, z] for z in (0, 1, 2, 3, 2.5, 2, 1.5, 4, 5, 6)], table(WHEEL)])
    path = write(text(rows))
    message = refusal(path, "wheel")
    assert message.startswith(f"{path}, line 4: the curve turns by 180 degrees; at most 120 are allowed")


def test_crossing_itself(write):
    """A loop on the flange back, so steep that no point goes back in y by more than a face may."""
    y = [-70, -69.9, -70.9, -71.1, -71.3, -70.1, -69.9, -69.8, -69.7]
    loop = np.column_stack([y, [-1, 0, 5, 5.2, 5, 3, 2.9, 4, 9]])
    rows = np.vstack([loop, table(WHEEL)[table(WHEEL)[:, 0] > -69.6]])
    path = write(text(rows))
    assert refusal(path, "wheel") == (
        f"{path}, line 5: the curve crosses itself: this part meets the part at line 2; points must follow the curve"
    )


def test_curve_too_long(write):
    y = np.linspace(-36, 36, 5000)
    message = refusal(write(text(np.column_stack([y, 3 * np.sin(y * 6)]))), "rail")
    assert re.search(r"the curve is [0-9.]+ mm long; allowed: 5 to 500 mm", message)


@pytest.mark.parametrize("factor", [180 / np.pi, -1.0])
def test_third_column_is_no_tangent(write, factor):
    path = write(text(np.column_stack([RAIL.y * 1e3, RAIL.z * 1e3, RAIL.angle * factor])))
    message = refusal(path, "rail")
    assert message.startswith(f"{path}, line 1: angle {RAIL.angle[0] * factor:.4g} is ")
    assert message.endswith("the third column must be the tangent angle atan2(dz, dy) in rad")


def test_point_repeated_with_another_tangent(write):
    rows = np.column_stack([RAIL.y * 1e3, RAIL.z * 1e3, RAIL.angle])
    rows = np.insert(rows, 100, rows[100] + [0, 0, 0.1], axis=0)
    path = write(text(rows))
    assert refusal(path, "rail") == f"{path}, line 102: the point before is repeated with another angle"


def test_crossing_search_against_all_pairs():
    """Random walks: the sweep finds a pair exactly when trying all pairs does."""
    random = np.random.default_rng(7)
    found = 0
    for _ in range(300):
        y, z = np.cumsum(random.normal(0.6, 1, 25)), np.cumsum(random.normal(0.4, 1, 25))
        pairs = [
            (i, j)
            for i in range(24)
            for j in range(i + 2, 24)
            if _cross(y[i : i + 2], z[i : i + 2], y[j : j + 2], z[j : j + 2])
        ]
        pair = profiles._meeting(y, z)
        assert (pair is None) == (not pairs)
        assert pair is None or tuple(sorted(pair)) in pairs
        found += pair is not None
    assert 30 < found < 270


def _cross(y, z, other_y, other_z):
    """Segments meet: solve for the parameters of their lines."""
    matrix = np.array([[y[1] - y[0], other_y[0] - other_y[1]], [z[1] - z[0], other_z[0] - other_z[1]]])
    t = np.linalg.solve(matrix, [other_y[0] - y[0], other_z[0] - z[0]])
    return bool((t >= 0).all() and (t <= 1).all())


# Where bundled files are


def test_resource_in_a_checkout_and_in_a_package(tmp_path, monkeypatch):
    package, beside = tmp_path / "railcli" / "_data", tmp_path
    monkeypatch.setattr(resources, "_ROOTS", (package, beside))
    (beside / "profiles").mkdir()
    assert resource("profiles") == beside / "profiles"
    (package / "profiles").mkdir(parents=True)
    assert resource("profiles") == package / "profiles"


def test_resource_that_is_not_there():
    with pytest.raises(InputError, match="profiles/none.csv: this file comes with railcli but is missing here"):
        resource("profiles/none.csv")
