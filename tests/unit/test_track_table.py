"""Measured alignment tables: what is read, and the one line that says what is wrong."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.errors import InputError
from railcli.files.scenario import load
from railcli.files.track_table import read_alignment

HEAD = "position_m,curvature_1_per_km,cant_mm"


@pytest.fixture
def written(tmp_path):
    """Function that writes a table and returns its path."""

    def write(text):
        path = tmp_path / "line.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_units_in_the_names(written):
    table = read_alignment(
        written(
            "# measured on a Sunday\n"
            "position_km, remark, curvature_1_per_km, cant_mm, gradient_permille, gauge_mm\n\n"
            "12.5, start, 0, 0, -5, 1435\n"
            "12.6, end, 2.5, 100, 10, 1440\n"
        )
    )
    assert_allclose(table.position, (12500.0, 12600.0), rtol=tol.ROUNDING)
    assert_allclose(table.curvature, (0.0, 2.5e-3), rtol=tol.ROUNDING)
    assert_allclose(table.cant, (0.0, 0.1), rtol=tol.ROUNDING)
    assert_allclose(table.gradient, (-0.005, 0.01), rtol=tol.ROUNDING)
    assert_allclose(table.gauge, (1.435, 1.44), rtol=tol.ROUNDING)


def test_radius_with_decimal_commas(written):
    """Radius 0, infinite or empty is straight track; its sign is the hand."""
    table = read_alignment(written("s_m;radius_m\n0,5;0\n1,5;inf\n2,5;\n3,5;-400,0\n4,5;800\n"))
    assert_allclose(table.position, np.arange(5) + 0.5)
    assert_allclose(table.curvature, (0.0, 0.0, 0.0, -1 / 400, 1 / 800), rtol=tol.ROUNDING)
    assert table.cant is table.gradient is table.gauge is None


REGULAR = "\n".join(f"{k},0,0" for k in range(40))
BAD = [
    ("", "is empty"),
    (f"{HEAD}\n0,0,0\n", "has 1 positions; at least 2 are needed"),
    ("km,x\n0,0\n1,1\n", "line 1: found 'km, x'; needed are position (position_m) and curvature"),
    ("position_m,curvature_1_per_km,cant\n0,0,0\n1,0,0\n", "line 1: column 'cant' does not end with a unit of cant"),
    ("position_m,curvature_mm\n0,0\n1,0\n", "write one of: curvature_1_per_m, curvature_1_per_km"),
    ("position_m,radius_m,curvature_1_per_m\n0,0,0\n1,0,0\n", "curvature and radius are both given"),
    ("position_m,s_m,radius_m\n0,0,0\n1,1,0\n", "column 's_m': position is given twice"),
    (f"{HEAD}\n0,0,0\n1,0,nan\n", "line 3: cant 'nan' is not a number"),
    (f"{HEAD}\n0,0,0\n1,,0\n", "line 3: curvature is empty; fill it in or remove the line"),
    (f"{HEAD}\n0,0,0\n1,0\n", "line 3: 2 values, but 3 columns are named"),
    (f"{HEAD}\n0,0,0\n1,0,\n", "line 3: cant is empty"),
    (f"{HEAD}\n0,0,0\n1,0,0\n\n1,0,0\n", "line 5: position 1 m repeats the one before; positions must rise"),
    (f"{HEAD}\n0,0,0\n5,0,0\n4,0,0\n", "line 4: position 4 m falls below 5 m before"),
    (f"{HEAD}\n{REGULAR}\n70,0,0\n71,0,0\n", "line 42: a gap from 39 to 70 m in a table with a step of 1 m"),
    ("position_m,curvature_1_per_km,cant_m\n0,0,0\n1,0,5\n", "cant 5000 mm at 1 m: must be -300 to 300 mm"),
    ("position_m,radius_m\n0,0\n1,0.8\n", "line 3: radius of 0.8 m: must be at least 10 m, or 0 for straight track"),
    (f"{HEAD},gauge_m\n0,0,0,1435\n1,0,0,1435\n", "gauge 1.435e+06 mm at 0 m"),
]


@pytest.mark.parametrize(("text", "message"), BAD)
def test_bad_table(text, message, written):
    path = written(text)
    with pytest.raises(InputError) as error:
        read_alignment(path)
    assert str(path) in str(error.value) and message in str(error.value) and "\n" not in str(error.value)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_alignment(tmp_path / "absent.csv")


SCENARIO = """
[run]
speed_m_per_s = 20
distance_m = {distance}
[[track]]
kind = "measured"
{keys}
"""


def scenario(tmp_path, keys, distance=100, more=""):
    path = tmp_path / "case.toml"
    path.write_text(SCENARIO.format(keys=keys, distance=distance) + more)
    return path


def test_scenario_on_a_measured_table(written, tmp_path):
    """Beside the scenario file; or with its columns in the scenario itself."""
    written(f"{HEAD}\n0,0,0\n60,2,50\n100,2,50\n")
    one = load(scenario(tmp_path, 'file = "line.csv"'))
    keys = "position_m = [0, 60, 100]\ncurvature_1_per_km = [0, 2, 2]\ncant_mm = [0, 50, 50]"
    other = load(scenario(tmp_path, keys))
    assert one.track == other.track
    assert one.digest() == other.digest()


BAD_SCENARIOS = [
    ({"keys": 'file = "line.csv"', "distance": 200}, "track shorter than the run: 100 m of track, 200 m to run"),
    ({"keys": "file = 3"}, "track[1].file: must be a text in quotes, got 3"),
    ({"keys": 'file = "line.csv"\nlength_m = 3'}, "track[1]: 'length_m' beside 'file'"),
    ({"keys": 'file = "no.csv"'}, "no.csv: no such file"),
    (
        {"keys": 'file = "line.csv"', "more": "[contact]\ngauge_mm = 1520"},
        "measured gauge of 1435 mm is more than 60 mm from the nominal 1520 mm",
    ),
    (
        {"keys": 'file = "line.csv"', "more": "[[gradient]]\ngradient_permille = 1"},
        "a measured table has gradients already; give one or the other",
    ),
]


@pytest.mark.parametrize(("given", "message"), BAD_SCENARIOS)
def test_bad_scenario_with_a_table(given, message, written, tmp_path):
    written(f"{HEAD},gauge_mm,gradient_permille\n0,0,0,1435,1\n60,2,50,1435,1\n100,2,50,1435,1\n")
    with pytest.raises(InputError) as error:
        load(scenario(tmp_path, **given))
    assert message in str(error.value)
