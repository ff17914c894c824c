"""Time series: every row that came is in the file, however the run ends."""

import os
import signal

import h5py
import numpy as np
import pytest
import scenes

from railcli.errors import InputError, SimulationError
from railcli.files.growing_hdf5 import GrowingHdf5
from railcli.files.results import CHUNK, TimeSeries, envelope, main_channels, pieces, write_main_channels
from railcli.interruption import uninterrupted
from railcli.kernels.recording import averaged, new_rows

SEED = 1

UNTIL_FULL = """
import resource, sys
from railcli.files.growing_hdf5 import GrowingHdf5
resource.setrlimit(resource.RLIMIT_FSIZE, (6_000_000, 6_000_000))
growing = GrowingHdf5("a.h5", "title")
with growing.growing(0):
    x = growing.file.create_dataset("x", (0,), "f8", maxshape=(None,), chunks=(10_000,))
rows = 0
try:
    while True:
        with growing.growing(80_000):
            x.resize(rows + 10_000, axis=0)
            x[rows:] = range(rows, rows + 10_000)
            rows += 10_000
except OSError as error:
    print(type(error).__name__, rows)
growing.close()
"""


def blocks(system, count, size=50):
    """Rows of random numbers, and the same as one block after the other."""
    random = np.random.default_rng(SEED)
    rows = new_rows(system.model, count)
    for array in rows:
        if array.dtype.names is None:
            array[...] = random.normal(size=array.shape)
        else:
            for name in array.dtype.names:
                array[name][...] = random.normal(size=array[name].shape)
    rows.time[:] = 0.01 * np.arange(1, count + 1)
    parts = [type(rows)(*(array[k : k + size] for array in rows)) for k in range(0, count, size)]
    return rows, parts


@pytest.mark.parametrize("count", [1, 50, CHUNK, 2 * CHUNK + 70])
def test_rows_are_read_as_they_came(wagon, tmp_path, count):
    rows, parts = blocks(wagon, count)
    with TimeSeries(tmp_path / "a.h5", wagon) as series:
        for part in parts:
            series(part)
    assert os.listdir(tmp_path) == ["a.h5"]
    spans = averaged(8, 7)
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["time"], rows.time)
        for i, name in enumerate(wagon.bodies):
            body = file[f"bodies/{name}"]
            assert np.array_equal(body["position"], rows.q[:, i, :3])
            assert np.array_equal(body["rotation"], rows.q[:, i, 3:])
            felt = slice(spans.acceleration.start + 3 * i, spans.acceleration.start + 3 * i + 3)
            for end, values in (("", rows.mean), ("_least", rows.least), ("_greatest", rows.greatest)):
                assert np.array_equal(body[f"acceleration{end}"], values[:, felt])
        right = file["wheels/W1_right"]
        assert np.array_equal(right["X"], rows.mean[:, spans.x][:, 0])
        assert np.array_equal(right["Y"], rows.mean[:, spans.y][:, 0])
        for end, values in (("", rows.mean), ("_least", rows.least), ("_greatest", rows.greatest)):
            assert np.array_equal(file[f"wheels/W4_left/Q{end}"], values[:, spans.q][:, 7])
        there = rows.contact["depth"][:, 0] > 0.0
        assert np.array_equal(right["contact/normal"], np.where(there, rows.contact["normal"][:, 0], 0.0))
        assert np.array_equal(right["contact/xi"], np.where(there, rows.contact["xi"][:, 0], np.nan), equal_nan=True)


def test_rails_that_give_way_have_channels(wagon, tmp_path):
    """And rigid ones have none."""
    soft = scenes.tuned(wagon, rail_stiffness=(2e7, 5e7), rail_damping=(4e4, 1e5))
    rows, (part,) = blocks(soft, 20)
    for name, system in (("rigid.h5", wagon), ("soft.h5", soft)):
        with TimeSeries(tmp_path / name, system) as series:
            series(part)
    with h5py.File(tmp_path / "rigid.h5") as rigid, h5py.File(tmp_path / "soft.h5") as file:
        more = set(file["wheels/W2_left"]) - set(rigid["wheels/W2_left"])
        assert more == {"give_y", "give_z", "seat_Y", "seat_Q"}
        for name, channels in (("give", ("give_y", "give_z")), ("seat", ("seat_Y", "seat_Q"))):
            for c, channel in enumerate(channels):
                assert np.array_equal(file[f"wheels/W2_left/{channel}"], rows.rail[name][:, 3, c])


@pytest.mark.parametrize("failure", [KeyboardInterrupt(), SimulationError("derailed"), ZeroDivisionError()], ids=repr)
def test_a_run_that_breaks_off_keeps_its_rows(wagon, tmp_path, failure):
    rows, parts = blocks(wagon, CHUNK + 130)
    with pytest.raises(type(failure)), TimeSeries(tmp_path / "a.h5", wagon) as series:
        for part in parts:
            series(part)
        raise failure
    assert "until t = 11.30 s is kept" in series.kept()
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["time"], rows.time)


def test_a_run_without_rows_leaves_no_file(wagon, tmp_path):
    with pytest.raises(KeyboardInterrupt), TimeSeries(tmp_path / "a.h5", wagon) as series:
        raise KeyboardInterrupt
    assert os.listdir(tmp_path) == [] and series.kept() == ""


def test_ctrl_c_waits_until_the_rows_are_written(tmp_path):
    growing = GrowingHdf5(tmp_path / "a.h5", "title")
    with pytest.raises(KeyboardInterrupt), growing.growing(1000):
        signal.raise_signal(signal.SIGINT)
        growing.file["x"] = np.arange(3.0)
    growing.close()
    with h5py.File(tmp_path / "a.h5") as file:
        assert list(file["x"]) == [0.0, 1.0, 2.0]


def test_handler_of_ctrl_c_is_put_back():
    before = signal.getsignal(signal.SIGINT)
    with uninterrupted():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.skipif(os.name != "posix", reason="needs a limit that the system sets on files")
def test_a_file_that_the_system_stops_from_growing_is_readable(run_python, tmp_path):
    """The system itself refuses to let the file grow beyond 6 MB: all rows until then are kept, the process lives."""
    result = run_python(UNTIL_FULL)
    assert result.returncode == 0, result.stderr
    name, rows = result.stdout.split()
    assert name == "OSError" and int(rows) > 0
    with h5py.File(tmp_path / "a.h5") as file:
        assert np.array_equal(file["x"], np.arange(float(rows)))


def test_csv_has_a_column_for_each_main_channel(wagon, tmp_path):
    rows, parts = blocks(wagon, 70)
    with TimeSeries(tmp_path / "a.h5", wagon) as series:
        for part in parts:
            series(part)
    main = main_channels(tmp_path / "a.h5")
    write_main_channels([main], tmp_path / "main.csv")
    header, *lines = (tmp_path / "main.csv").read_text().splitlines()
    values = dict(zip(header.split(","), np.array([line.split(",") for line in lines], float).T, strict=True))
    wheelset, spans = wagon.wheelsets[1], averaged(8, 7)
    expected = {
        "time_s": rows.time,
        "s_m": rows.q[:, 0, 0],
        "W2_y_mm": 1e3 * rows.q[:, wheelset, 1],
        "W2_yaw_mrad": 1e3 * rows.q[:, wheelset, 5],
        "W2_left_Y_kN": 1e-3 * rows.mean[:, spans.y][:, 3],
        "W2_left_Q_kN": 1e-3 * rows.mean[:, spans.q][:, 3],
        "car_body_ay_m_per_s2": rows.mean[:, spans.acceleration][:, 1],
    }
    for name, column in expected.items():
        np.testing.assert_allclose(values[name], column, rtol=1e-8)


def test_csv_in_pieces_is_that_of_the_whole(wagon, tmp_path):
    with TimeSeries(tmp_path / "a.h5", wagon) as series:
        for part in blocks(wagon, 70)[1]:
            series(part)
    write_main_channels([main_channels(tmp_path / "a.h5")], tmp_path / "whole.csv")
    write_main_channels(pieces(tmp_path / "a.h5", 16), tmp_path / "pieces.csv")
    assert (tmp_path / "whole.csv").read_text() == (tmp_path / "pieces.csv").read_text()


@pytest.mark.parametrize("most", [20, 41])
def test_envelope_of_a_long_run_keeps_every_peak(wagon, tmp_path, most):
    with TimeSeries(tmp_path / "a.h5", wagon) as series:
        for part in blocks(wagon, 70)[1]:
            series(part)
    whole, drawn = main_channels(tmp_path / "a.h5"), envelope(tmp_path / "a.h5", most)
    assert drawn.time.size <= most
    assert (drawn.time[[0, -1]] == whole.time[[0, -1]]).all() and (np.diff(drawn.time) >= 0.0).all()
    for key in ("lateral", "yaw", "y_force", "q_force", "acceleration"):
        few, all_of_it = getattr(drawn, key), getattr(whole, key)
        assert (few.max(axis=0) == all_of_it.max(axis=0)).all() and (few.min(axis=0) == all_of_it.min(axis=0)).all()
    assert envelope(tmp_path / "a.h5", 70).time.size == 70


@pytest.mark.parametrize("patterns, count", [(("none",), 0), (("*/normal", "*/W2_left/contact/xi"), 9)])
def test_only_the_contact_channels_asked_for(wagon, tmp_path, patterns, count):
    with TimeSeries(tmp_path / "a.h5", wagon, patterns) as series:
        for part in blocks(wagon, 5)[1]:
            series(part)
    found = []
    with h5py.File(tmp_path / "a.h5") as file:
        file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
        assert "Q" in file["wheels/W1_right"]
    assert len([name for name in found if "/contact/" in name]) == count


def test_contact_channels_that_do_not_exist(wagon, tmp_path):
    with pytest.raises(InputError, match="'\\*/Normal' fits none.*known: normal"):
        TimeSeries(tmp_path / "a.h5", wagon, ("*/Normal",))
    assert list(tmp_path.iterdir()) == []
