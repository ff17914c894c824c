"""Reading a results folder: what was written comes back, and what cannot be read is one line."""

import json

import h5py
import numpy as np
import pytest
import scenes

from railcli.errors import InputError
from railcli.files.output import write_json
from railcli.files.read_results import Results
from railcli.files.results import TimeSeries
from railcli.files.scenario import load
from railcli.kernels.recording import averaged, new_rows

SEED = 2
ROWS = 2300


@pytest.fixture
def folder(wagon, tmp_path):
    """Random rows of the wagon, its scenario and a summary."""
    random = np.random.default_rng(SEED)
    rows = new_rows(wagon.model, ROWS)
    rows.time[:] = 0.01 * np.arange(1, ROWS + 1)
    rows.q[...] = random.normal(size=rows.q.shape)
    rows.mean[...] = random.normal(size=rows.mean.shape)
    rows.contact["depth"][...] = random.normal(size=rows.contact["depth"].shape)
    with TimeSeries(tmp_path / "timeseries.h5", wagon) as series:
        series(rows)
    write_json(tmp_path / "scenario.json", load("curve-300").as_dict())
    write_json(tmp_path / "summary.json", {"provenance": {"railcli": "0.0"}})
    return tmp_path, rows


def test_what_was_written_is_read(folder, wagon):
    path, rows = folder
    for place in (path, path / "timeseries.h5"):
        with Results(place) as results:
            assert results.rows == ROWS and results.folder == path
            assert results.bodies == tuple(wagon.bodies)
            assert results.wheels[:3] == ("W1_right", "W1_left", "W2_right")
            assert np.array_equal(results.time, rows.time)
            assert np.array_equal(results.s, rows.q[:, 0, 0])
            assert np.array_equal(results.read("wheels/W2_left/Y"), rows.mean[:, averaged(8, 7).y][:, 3])
            assert np.array_equal(results.read("bodies/bogie 1/rotation", 5, 9), rows.q[5:9, 1, 3:])
            assert results.scenario == load("curve-300")
            assert results.provenance == {"railcli": "0.0"} and results.fault == ""


def test_pieces_join_to_the_whole(folder):
    path, _ = folder
    with Results(path) as results:
        pieces = list(results.pieces("time", "wheels/W1_left/contact/depth", size=700))
        assert [len(time) for time, _ in pieces] == [700, 700, 700, 200]
        whole = results.read("wheels/W1_left/contact/depth")
        assert np.array_equal(np.concatenate([depth for _, depth in pieces]), whole, equal_nan=True)


def test_channels_carry_units_and_columns(folder):
    path, _ = folder
    with Results(path) as results:
        assert next(iter(results.channels)) == "time"
        assert results.channels["wheels/W3_left/Q"].units == "N"
        assert results.channels["bodies/car body/position"].components == ("s", "y", "z")
        assert results.channels["bodies/car body/acceleration"].components == ("x", "y", "z")
        assert results.channels["wheels/W1_right/contact/xi"].components == tuple("123456")
        assert results.channels["traction"].components == ()
        assert all(channel.units and channel.description for channel in results.channels.values())


def test_a_run_that_broke_off_has_no_summary(folder):
    path, _ = folder
    (path / "summary.json").unlink()
    with Results(path) as results:
        assert results.summary == {} and results.provenance == {}
        assert "interrupted" in results.fault


def cut(path):
    data = (path / "timeseries.h5").read_bytes()
    (path / "timeseries.h5").write_bytes(data[: len(data) // 2])


def flip(path):
    """Damage inside a compressed chunk."""
    with h5py.File(path / "timeseries.h5") as file:
        place = file["wheels/W1_right/Y"].id.get_chunk_info(1)
    data = bytearray((path / "timeseries.h5").read_bytes())
    data[place.byte_offset + 20 : place.byte_offset + 60] = bytes(40)
    (path / "timeseries.h5").write_bytes(data)


def flip_of_another_program(path):
    """The same in a file that was sealed thereafter: the checksum of the chunk finds it."""
    flip(path)
    scenes.reseal(path / "timeseries.h5")


def beheaded(path):
    """Copied by a program that knows HDF5 alone."""
    (path / "timeseries.h5").write_bytes((path / "timeseries.h5").read_bytes()[512:])


def foreign(path):
    with h5py.File(path / "timeseries.h5", "w") as file:
        file["time"] = [1.0]


def other_version(path):
    with h5py.File(path / "timeseries.h5", "r+") as file:
        file.attrs["version"] = 99
    scenes.reseal(path / "timeseries.h5")


def shortened(path):
    with h5py.File(path / "timeseries.h5", "r+") as file:
        file["wheels/W1_right/Y"].resize(7, axis=0)
    scenes.reseal(path / "timeseries.h5")


def emptied(path):
    with h5py.File(path / "timeseries.h5", "r+") as file:
        file.visititems(lambda _, item: item.resize(0, axis=0) if isinstance(item, h5py.Dataset) else None)
    scenes.reseal(path / "timeseries.h5")


def without_speed(path):
    values = json.loads((path / "scenario.json").read_text())
    del values["run"]["speed_m_per_s"]
    (path / "scenario.json").write_text(json.dumps(values))


@pytest.mark.parametrize(
    "spoil, words",
    [
        (cut, "is truncated"),
        (flip, "checksum does not fit"),
        (flip_of_another_program, "'wheels/W1_right/Y' is damaged"),
        (beheaded, "its head is gone"),
        (foreign, "not of time series"),
        (other_version, "version 99"),
        (shortened, "cut off"),
        (emptied, "no rows"),
        (lambda path: (path / "timeseries.h5").unlink(), "no timeseries.h5"),
        (lambda path: (path / "timeseries.h5").write_bytes(b""), "is not a file of time series"),
        (lambda path: (path / "scenario.json").unlink(), "scenario.json: is missing"),
        (lambda path: (path / "scenario.json").write_text("{"), "no JSON"),
        (lambda path: (path / "scenario.json").write_text("[1]"), "no table"),
        (lambda path: (path / "summary.json").write_text("nonsense"), "no JSON"),
        (without_speed, "run.speed_m_per_s"),
    ],
)
def test_what_cannot_be_read_is_one_line(folder, spoil, words):
    path, _ = folder
    spoil(path)
    with pytest.raises(InputError) as error, Results(path) as results:
        for name in results.channels:
            results.read(name)
        assert results.scenario and results.provenance
    assert words in str(error.value) and "\n" not in str(error.value)
    assert str(path) in str(error.value)


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        Results(tmp_path / "nowhere")
