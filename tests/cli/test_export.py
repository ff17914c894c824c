"""`railcli export` and `railcli.open_results`: every value, name and unit comes back from each format."""

import json
import shutil

import h5py
import numpy as np
import pandas
import pytest
from click.testing import CliRunner
from scipy.io import loadmat, whosmat

import railcli
from railcli.cli import main
from railcli.errors import InputError
from railcli.files import columns, export

FORCE = "wheels/W1_right/Q"
PATCH = "wheels/W2_left/contact/eta"


def run(*arguments):
    return CliRunner().invoke(main, ["export", *map(str, arguments)], prog_name="railcli")


@pytest.fixture
def expected(recorded):
    """What HDF5 itself reads: label -> values."""
    found = {}
    with h5py.File(recorded() / "timeseries.h5") as file:

        def visit(name, item):
            if not isinstance(item, h5py.Dataset) or name.startswith("filtered/"):
                return
            values, unit = item[()], item.attrs["units"]
            parts = {"position": ["s", "y", "z"], "rotation": ["roll", "pitch", "yaw"]}.get(name.split("/")[-1])
            if values.ndim == 1:
                found[f"{name} [{unit}]"] = values
            else:
                for k, part in enumerate(parts or ("xyz" if values.shape[1] == 3 else "123456")):
                    found[f"{name}/{part} [{unit}]"] = values[:, k]

        file.visititems(visit)
    return found


def in_small_pieces(monkeypatch):
    """Let only some rows into memory at once, so that each format is written in several pieces."""
    monkeypatch.setattr(columns, "VALUES", 50_000)
    monkeypatch.setattr(columns, "CHUNK", 100)


def test_csv_gives_back_every_value(recorded, expected, tmp_path, monkeypatch):
    in_small_pieces(monkeypatch)
    result = run(recorded(), "-o", tmp_path / "a.csv", "-q")
    assert result.exit_code == 0, result.stderr
    frame = pandas.read_csv(tmp_path / "a.csv", dtype=str).astype(float)  # exact whatever reader pandas has for numbers
    assert set(frame) == set(expected) and frame.columns[0] == "time [s]"
    for label, values in expected.items():
        assert np.array_equal(frame[label], values, equal_nan=True), label


def test_filtered_rows_are_given_back(recorded, tmp_path):
    """Those of the file's group, at a rate of their own."""
    result = run(recorded(), "--filtered", "--channel", FORCE, "-o", tmp_path / "a.csv", "-q")
    assert result.exit_code == 0, result.stderr
    frame = pandas.read_csv(tmp_path / "a.csv", dtype=str).astype(float)
    with h5py.File(recorded() / "timeseries.h5") as file:
        time, force = file["filtered/time"][:], file[f"filtered/{FORCE}"][:]
    assert np.array_equal(frame["time [s]"], time) and np.array_equal(frame[f"{FORCE} [N]"].astype("f4"), force)
    opened = railcli.open_results(recorded(), FORCE, filtered=True)
    assert np.array_equal(opened[f"{FORCE} [N]"], force) and np.array_equal(opened.index, time)


def test_parquet_gives_back_every_value(recorded, expected, tmp_path, monkeypatch):
    parquet = pytest.importorskip("pyarrow.parquet")
    in_small_pieces(monkeypatch)
    result = run(recorded(), "-o", tmp_path / "a.parquet", "-q")
    assert result.exit_code == 0, result.stderr
    frame = pandas.read_parquet(tmp_path / "a.parquet")
    assert set(frame) == set(expected)
    for label, values in expected.items():
        assert np.array_equal(frame[label], values, equal_nan=True), label
    file = parquet.ParquetFile(tmp_path / "a.parquet")
    assert file.num_row_groups > 1
    assert file.schema_arrow.field(f"{FORCE} [N]").metadata[b"units"] == b"N"
    assert json.loads(file.schema_arrow.metadata[b"railcli"])["provenance"]["railcli"] == railcli.__version__


def test_mat_gives_back_every_value(recorded, expected, tmp_path):
    result = run(recorded(), "-o", tmp_path / "a.mat", "-q")
    assert result.exit_code == 0, result.stderr
    content = loadmat(tmp_path / "a.mat", simplify_cells=True)
    names = content["channels"]
    assert {f"{name} [{content['units'][key]}]" for key, name in names.items()} == set(expected)
    for key, name in names.items():
        assert np.array_equal(content[key], expected[f"{name} [{content['units'][key]}]"], equal_nan=True), key
    assert names["wheels_W1_right_Q"] == FORCE
    shapes = {name: shape for name, shape, _ in whosmat(tmp_path / "a.mat")}
    assert shapes["wheels_W1_right_Q"] == (content["time"].size, 1)


def test_names_of_a_mat_file_are_ones_that_matlab_takes():
    """Long, alike and odd names stay apart, begin with a letter and have at most 63 letters."""
    odd = ["9 lives/y", "a b/c", "a_b/c", "units", "x" * 80 + "/1", "x" * 80 + "/2", "µ/%", "€/$"]
    names = export._mat_names([columns.Column(name, "m", "", name, None) for name in odd])
    assert len(set(names)) == len(names) and "units" not in names
    assert all(name.isidentifier() and name[0].isalpha() and len(name) <= 63 and name.isascii() for name in names)


def test_mat_says_what_it_cannot_hold(recorded, tmp_path, monkeypatch):
    monkeypatch.setattr(export, "MAT_BYTES", 800)
    result = run(recorded(), "-o", tmp_path / "a.mat", "-q")
    assert result.exit_code == 2 and not (tmp_path / "a.mat").exists()
    (line,) = result.stderr.splitlines()
    assert "at most 100 rows" in line and "Parquet" in line


@pytest.mark.parametrize(
    ("patterns", "found"),
    [
        (["wheels/W1_*/Q"], {"time", "wheels/W1_right/Q", "wheels/W1_left/Q"}),
        (["bodies/car body/position", PATCH + "/1"],
         {"time", PATCH + "/1", *(f"bodies/car body/position/{axis}" for axis in "syz")}),
        (["time"], {"time"}),
    ],
)  # fmt: skip
def test_channels_are_chosen_by_glob(recorded, tmp_path, patterns, found):
    options = [part for pattern in patterns for part in ("--channel", pattern)]
    result = run(recorded(), *options, "-o", tmp_path / "a.csv", "-q", "--format", "json")
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert {one["name"] for one in record["columns"]} == found
    header = (tmp_path / "a.csv").read_text().splitlines()[0].split(",")
    assert header == [f"{one['name']} [{one['unit']}]" for one in record["columns"]]


def test_list_names_every_channel(recorded, expected):
    result = run(recorded(), "--list")
    assert result.exit_code == 0
    assert "wheels/W1_right/Q " in result.stdout and "[N]  force of the wheel on the rail, down; mean" in result.stdout
    assert "bodies/car body/position/{s,y,z}" in result.stdout


def test_without_a_place_a_new_folder_takes_the_file(recorded, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(recorded(), "--to", "mat", "--channel", "time", "-q")
    assert result.exit_code == 0, result.stderr
    (file,) = tmp_path.glob("railcli-out/export-*-1/*.mat")
    assert str(file.relative_to(tmp_path)) in result.stdout


def test_pandas_opens_a_result_with_one_call(recorded, expected):
    frame = railcli.open_results(recorded(), "wheels/*/Q", PATCH)
    assert frame.index.name == "time [s]" and np.array_equal(frame.index, expected["time [s]"])
    assert len(frame.columns) == 8 + 6
    for label in frame:
        assert np.array_equal(frame[label], expected[label], equal_nan=True)
    assert set(railcli.open_results(recorded()).reset_index()) == set(expected)
    with pytest.raises(InputError, match="wheels/W1_right/Q"):
        railcli.open_results(recorded(), "wheels/W1_rigth/Q")


def test_a_result_opens_beside_h5py(recorded, expected):
    """In a notebook the same file may be open with h5py, which locks it by default."""
    with h5py.File(recorded() / "timeseries.h5") as file:
        frame = railcli.open_results(recorded(), FORCE)
        assert np.array_equal(frame[f"{FORCE} [N]"], file[FORCE][:])


def test_import_is_light(run_python):
    heavy = "{'numpy', 'numba', 'scipy', 'pandas', 'matplotlib', 'pydantic', 'h5py', 'click'}"
    result = run_python(f"import sys, railcli; print('open_results' in dir(railcli), {heavy} & set(sys.modules))")
    assert result.stdout.strip() == "True set()", result.stderr


def test_missing_extra_is_named(recorded, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    result = run(recorded(), "-o", tmp_path / "a.parquet", "-q")
    assert result.exit_code == 2 and not (tmp_path / "a.parquet").exists()
    (line,) = result.stderr.splitlines()
    assert "railcli[parquet]" in line


def test_bad_input_is_one_line(recorded, tmp_path):
    (tmp_path / "there.csv").write_text("mine")
    broken = tmp_path / "broken"
    shutil.copytree(recorded(), broken)
    with open(broken / "timeseries.h5", "r+b") as file:
        file.truncate(5000)
    for arguments, words in [
        ((tmp_path / "nowhere",), ["no such folder"]),
        ((broken,), ["timeseries.h5", "run the scenario again"]),
        ((recorded(), "--channel", "wheels/W1_right/patch"), ["did you mean 'wheels/W1_right/patches'"]),
        ((recorded(), "-o", tmp_path / "there.csv"), ["exists already"]),
        ((recorded(), "-o", tmp_path / "a.xlsx"), [".parquet"]),
    ]:
        result = run(*arguments, "-q")
        assert result.exit_code == 2, arguments
        assert all(word in result.stderr for word in words), result.stderr
    assert (tmp_path / "there.csv").read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {"there.csv", "broken"}
