"""The reader of text tables: the same numbers however they are written, and one line for what cannot be read."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.errors import InputError
from railcli.files.irregularity import Asked, recording
from railcli.files.text_table import name_of, split_of

S = 12400.0 + 0.25 * np.arange(400)
LEFT, RIGHT = 2e-3 * np.sin(S / 3.0), 1e-3 * np.cos(S / 5.0)


def rows(separator=";", comma=False, km=5):
    """Rows of position [km] and both levels [mm]."""
    lines = (separator.join((f"{s / 1e3:.{km}f}", f"{1e3 * a:.3f}", f"{1e3 * b:.3f}"))
             for s, a, b in zip(S, LEFT, RIGHT, strict=True))  # fmt: skip
    text = "\n".join(lines) + "\n"
    return text.replace(".", ",") if comma else text


def read(tmp_path, text, encoding="utf-8", **asked):
    path = tmp_path / "coach.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return recording(path, Asked(**asked))


def refusal(tmp_path, text, **asked):
    with pytest.raises(InputError) as error:
        read(tmp_path, text, **asked)
    assert "\n" not in str(error.value)
    return str(error.value)


WAYS = {
    "semicolons": ("km;level_left [mm];level_right [mm]\n" + rows(), "utf-8"),
    "decimal commas": ("position_km;left_vertical_mm;right_vertical_mm\n" + rows(comma=True), "utf-8"),
    "tabs": ("s_km\tLevel left (mm)\tLevel right (mm)\n" + rows("\t", comma=True), "utf-8"),
    "commas": ('"chainage [km]","level left, mm","level right"\n'.replace("left, mm", "left / mm").replace(
        'right"', 'right [mm]"') + rows(","), "utf-8"),
    "blanks": ("km level_left_mm level_right_mm\n" + rows(" "), "utf-8"),
    "blanks, decimal commas": ("km level_left_mm level_right_mm\n" + rows("  ", comma=True), "utf-8"),
    "German, Latin-1": ("km;L\u00e4ngsh\u00f6he links [mm];L\u00e4ngsh\u00f6he rechts [mm]\n" + rows(), "cp1252"),
    "byte order mark": ("km;level_left [mm];level_right [mm]\n" + rows(), "utf-8-sig"),
    "UTF-16 of a spreadsheet": ("km\tlevel_left [mm]\tlevel_right [mm]\n" + rows("\t"), "utf-16"),
    "comments": ("# coach 7\n! Sunday\nkm;level_left [mm];level_right [mm]\n% run 3\n\n" + rows(), "utf-8"),
    "a line of units": ("km;level_left;level_right\n[km];mm;mm\n" + rows(), "utf-8"),
    "another order and more columns": (
        "remark;" + "level_right [mm];km;level_left [mm];speed [km/h]\n"
        + "\n".join(";".join(("x, y", cells[2], cells[0], cells[1], "80,5"))
                    for cells in (line.split(";") for line in rows().splitlines())), "utf-8"),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_one_table_in_many_ways(tmp_path, way):
    text, encoding = WAYS[way]
    samples = read(tmp_path, text, encoding).samples
    assert_allclose(samples.position, S, atol=tol.GRID_ROUNDING * 1e5)
    assert_allclose(samples.channels["left_vertical"], LEFT, atol=tol.THREE_DECIMALS)
    assert_allclose(samples.channels["right_vertical"], RIGHT, atol=tol.THREE_DECIMALS)


HEAD = "km;level_left [mm];level_right [mm]\n"
BAD = [
    ("", "is empty"),
    ("1;2;3\n" + rows(), "line 1: found '1;2;3'; the first line must name the columns"),
    (HEAD.replace("km", "x") + rows(), "no column is the position"),
    (HEAD.replace("[mm]", "", 1) + rows(), "column 'level_left' does not say its unit; write left_vertical_mm,"),
    (HEAD.replace("[mm]", "[kN]", 1) + rows(), "says 'kN', no unit of length"),
    ("km;levl_left_mm;level_right_mm\n" + rows(), "unknown column 'levl_left_mm'; did you mean 'level_left_mm'?"),
    (HEAD + rows().replace("12.40000;", "12.40000;1;", 1), "line 2: 4 values, but 3 columns are named"),
    (HEAD + rows().replace(";", ";x", 1), "line 2: level_left [mm]: 'x"),
    (HEAD + rows().replace(".", ",", 1), "has decimal points (km) and commas (km) in its numbers"),
    (HEAD + "12.4;1e400;0\n" + rows(), "is not a number"),
    (HEAD + "12.4;1_0;0\n" + rows(), "'1_0' is not a number"),
    (HEAD + "12.3;\uff11;0\n" + rows(), "is not a number"),
    (HEAD + "\n".join(reversed(rows().splitlines())), "line 3: positions fall from 12499.75 to 12400 m"),
    (HEAD.encode() + b"1;2;\x00", "this is a binary file (it contains byte 0)"),
    (HEAD + "x" * 200_000, "line 2: 200000 bytes in one line"),
    (HEAD + "12.4;" + "y" * 5000 + ";0\n" + rows(), "is not a number"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "words"), BAD, ids=range(len(BAD)))
def test_one_line_for_what_cannot_be_read(tmp_path, text, words):
    message = refusal(tmp_path, text)
    assert str(tmp_path / "coach.csv") in message and words in message and len(message) < 1000


@pytest.mark.parametrize(
    ("name", "stem", "symbol"),
    [
        ("level_left [mm]", "level_left", "mm"),
        ("Level left in mm", "level_left", "mm"),
        ("km", "km", "km"),
        ("km [km]", "km", "km"),
        ("curvature_1_per_km", "curvature", "1/km"),
        ("Kr\u00fcmmung [1/m]", "krummung", "1/m"),
        ("gradient (\u2030)", "gradient", "per mille"),
        ("cant/mm", "cant", "mm"),
    ],
)
def test_names_and_their_units(name, stem, symbol):
    found = name_of(name)
    assert (found.stem, found.unit.symbol) == (stem, symbol)


@pytest.mark.parametrize(
    ("row", "separator"),
    [("1;2", ";"), ("1,5\t2,5", "\t"), ("1,5 2,5", None), ("1.5, 2.5", ","), ("1,2", ","), ("1.5 2", None)],
)
def test_separators(row, separator):
    assert split_of(row).separator == separator


# Positions


def test_rounded_positions_are_taken_at_equal_distances(tmp_path):
    """Kilometres to the metre, a sample every 25 cm: each position is written four times."""
    found = read(tmp_path, HEAD + rows(km=3))
    assert np.abs(found.samples.position - S).max() < 0.5  # half of the last decimal
    assert_allclose(np.diff(found.samples.position), 0.25, rtol=tol.FITTED_STEP)
    assert any("rounded to 1 m" in one.reason for one in found.decisions)


def test_jittering_positions_are_taken_at_equal_distances(tmp_path):
    """An odometer that scatters by more than half a step, so that positions fall."""
    off = 0.15 * np.random.default_rng(3).normal(size=S.size)
    lines = [f"{s:.3f};{1e3 * a:.3f}" for s, a in zip(S + off, LEFT, strict=True)]
    found = read(tmp_path, "s_m;vertical_mm\n" + "\n".join(lines))
    assert np.abs(found.samples.position - S).max() < 4.0 * 0.15 / np.sqrt(S.size)  # of a straight line through all
    assert any("jitter" in one.reason for one in found.decisions)


def test_positions_at_unlike_distances_stay(tmp_path):
    position = np.cumsum(0.2 + 0.1 * np.random.default_rng(1).random(200))
    lines = [f"{s:.6f};1.5" for s in position]
    assert_allclose(read(tmp_path, "s_m;vertical_mm\n" + "\n".join(lines)).samples.position, position, atol=1e-6)


@pytest.mark.parametrize("change", [lambda s: np.insert(s, 40, s[40]), lambda s: np.r_[s[:200], s[200:] - 0.5]])
def test_a_slip_is_no_jitter(tmp_path, change):
    lines = [f"{s:.3f};1.5" for s in change(S)]
    assert "positions must rise" in refusal(tmp_path, "s_m;vertical_mm\n" + "\n".join(lines))


# Dropouts


def dropped(word, first=100, count=8):
    lines = rows().splitlines()
    for k in range(first, first + count):
        cells = lines[k].split(";")
        lines[k] = ";".join((cells[0], word, cells[2]))
    return HEAD + "\n".join(lines)


@pytest.mark.parametrize("word", ["-99", "-99.0", "", "nan", "NaN", "9999", "n/a", "-"])
def test_dropouts_are_found_and_said(tmp_path, word):
    message = refusal(tmp_path, dropped(word))
    assert "line 102: level_left [mm] is" in message and "not measured: 8 of 400 values in 1 place(s)" in message
    assert "the longest 2.25 m at 12425 m" in message and "bridge_m = 2.3 draws" in message
    assert "bridge_m = 1 is too short" in refusal(tmp_path, dropped(word), bridge=1.0)


def test_dropouts_are_bridged_where_asked(tmp_path):
    """A smooth curve between the values beside, which does not swing beyond them; told."""
    found = read(tmp_path, dropped("-99", count=8), bridge=2.3)
    bridge = found.samples.channels["left_vertical"][99:109]
    assert bridge.min() >= min(bridge[0], bridge[-1]) and bridge.max() <= max(bridge[0], bridge[-1])
    assert_allclose(np.delete(found.samples.channels["left_vertical"], np.s_[100:108]),
                    np.delete(LEFT, np.s_[100:108]), atol=tol.THREE_DECIMALS)  # fmt: skip
    assert any("bridged" in one.choice and "8 values" in one.reason for one in found.decisions)


def test_dropouts_at_an_end_are_cut(tmp_path):
    found = read(tmp_path, dropped("", first=0, count=20), bridge=1.0)
    assert_allclose(found.samples.position, S[20:])


def test_a_value_of_99_among_others_is_no_dropout(tmp_path):
    """A cross-level in a curve of 100 mm cant."""
    lines = [f"{s / 1e3:.5f};{-99.0 + 0.1 * np.sin(s):.3f}" for s in S]
    lines[50] = f"{S[50] / 1e3:.5f};-99"
    found = read(tmp_path, "km;cross_level [mm]\n" + "\n".join(lines))
    assert found.absolute and np.isfinite(found.samples.channels["cross_level"]).all()


# Absolute values, and what is given twice


def test_absolute_gauge_and_cross_level(tmp_path):
    lines = [f"{s:.2f};1437.5;{60.0 + 1e3 * a:.3f}" for s, a in zip(S, LEFT, strict=True)]
    found = read(tmp_path, "s_m;gauge_mm;superelevation_mm\n" + "\n".join(lines), gauge=1.435)
    assert found.absolute
    assert_allclose(found.samples.channels["gauge"], 2.5e-3, atol=tol.ROUNDING)
    assert_allclose(found.samples.channels["cross_level"], 0.06 + LEFT, atol=tol.THREE_DECIMALS)
    relative = read(tmp_path, "s_m;gauge_mm;cross_level_mm\n" + "\n".join(lines), cross_level="relative")
    assert not relative.absolute


def test_rails_win_over_what_follows_from_them(tmp_path):
    lines = [f"{line};1;2" for line in rows().splitlines()]
    found = read(tmp_path, HEAD.strip() + ";cross_level [mm];twist [mm/m]\n" + "\n".join(lines))
    assert set(found.samples.channels) == {"left_vertical", "right_vertical"}
    (over,) = [one for one in found.decisions if one.subject == "passed over"]
    assert "cross_level [mm]" in over.choice and "twist [mm/m]" in over.choice


def test_filtered_columns_are_told(tmp_path):
    found = read(tmp_path, HEAD.replace("level_left", "level_left_D1") + rows())
    assert any("waves of 3 to 25 m only" in one.reason for one in found.decisions)
