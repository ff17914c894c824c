"""Contact tables on disk: what is read is what was saved, and anything else is refused."""

import dataclasses
import hashlib
import shlex
from pathlib import Path

import numpy as np
import pytest

from railcli.analysis.build_table import build_table
from railcli.commands.build_lut import build_lut
from railcli.errors import InputError
from railcli.files import tables
from railcli.files.tables import Expected, check_expected, load, read, save
from railcli.kernels import jit
from railcli.model.contact_table import TableSettings

ROOT = Path(__file__).parents[2]
COARSE = TableSettings(normal="hertz", y_step=0.5e-3, roll_step=5e-3, yaw_count=3)
CERTIFICATE = {"poses": 100, "gap_um": {"p99": 1.5}}


@pytest.fixture(scope="module")
def coarse(profiles):
    return build_table(*profiles, COARSE)[0]


@pytest.fixture(scope="module")
def file(coarse, tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "table.h5"
    save(coarse, path, CERTIFICATE)
    return path


def same(one, other):
    arrays = all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in tables.ARRAYS)
    return arrays and one.key == other.key and one.settings == other.settings


def expected(profiles, settings=COARSE, **options):
    return Expected(*profiles, settings, **options)


def test_what_was_saved_is_read(coarse, file):
    stored = read(file)
    assert same(stored.table, coarse)
    assert stored.certificate == CERTIFICATE and stored.kernels == jit.source_digest()
    assert not any(getattr(stored.table, name).flags.writeable for name in tables.ARRAYS)


def test_other_programs_can_read_it(coarse, file):
    import h5py

    assert h5py.is_hdf5(file)
    with h5py.File(file) as content:
        assert np.array_equal(content["node"], coarse.node)
        assert len(content["node"].attrs["channels"].split(",")) == len(content["node"].attrs["units"].split(","))


def test_a_flipped_bit_is_found_wherever_it_is(file, tmp_path):
    """Title, checksum, padding of the head; superblock and attributes of HDF5; arrays; last byte."""
    content = file.read_bytes()
    places = [0, 5, 30, 60, 90, 100, 511, *range(512, 4096, 251), *range(4096, len(content), 9973), len(content) - 1]
    for place in places:
        damaged = bytearray(content)
        damaged[place] ^= 1 << place % 8
        (tmp_path / "bad.h5").write_bytes(damaged)
        with pytest.raises(InputError, match="build it again"):
            read(tmp_path / "bad.h5")


@pytest.mark.parametrize("length", [0, 1, 511, 512, 1000, -1])
def test_a_truncated_file_is_refused(file, tmp_path, length):
    (tmp_path / "cut.h5").write_bytes(file.read_bytes()[:length])
    with pytest.raises(InputError, match="cut.h5: is (not a contact table|truncated)"):
        load(tmp_path / "cut.h5")


def test_sealed_rubbish_is_refused(tmp_path):
    rubbish = bytes(range(256)) * 40
    head = tables._head_of(hashlib.sha256(rubbish).hexdigest(), len(rubbish))
    (tmp_path / "rubbish.h5").write_bytes(head + rubbish)
    with pytest.raises(InputError, match="does not hold a contact table"):
        load(tmp_path / "rubbish.h5")


@pytest.mark.parametrize(
    "name, change",
    [
        ("branch", lambda array: np.where(array == array.max(), array.max() + 1, array).astype(np.int32)),
        ("branch", lambda array: np.where(array == array.max(), -2, array).astype(np.int32)),
        ("branch", lambda array: array.astype(np.int64)),
        ("branch", lambda array: array[:, :7]),
        ("cell", lambda array: array[::-1].copy()),
        ("cell", lambda array: array[:-1]),
        ("cell", lambda array: array + np.int32(1)),
        ("node", lambda array: np.where(array == array.max(), np.nan, array)),
        ("node", lambda array: array[:, :15]),
        ("node", lambda array: array[:-1]),
    ],
)
def test_a_sealed_table_through_which_the_core_would_read_elsewhere_is_refused(coarse, tmp_path, name, change):
    save(dataclasses.replace(coarse, **{name: change(getattr(coarse, name))}), tmp_path / "bad.h5")
    with pytest.raises(InputError, match=f"does not hold a contact table .*{name}"):
        load(tmp_path / "bad.h5")


def test_a_table_for_other_settings_says_which_and_how_to_build_the_right_one(coarse, file, profiles):
    wanted = expected(profiles, dataclasses.replace(COARSE, gauge=1.432))
    with pytest.raises(InputError) as caught:
        load(file, wanted)
    message, _, command = str(caught.value).partition("build it again: ")
    assert "gauge 1435 mm" in message and "1432 mm" in message
    words = shlex.split(command)
    assert words[:2] == ["railcli", "build-lut"]
    given = build_lut.make_context("build-lut", words[2:]).params
    settings = {key: value for key, value in given.items() if key in tables.OPTIONS and value is not None}
    assert TableSettings(**settings) == wanted.settings


def test_a_table_for_another_profile_is_refused(file, profiles):
    wheel, rail = profiles
    moved = rail.translated(1e-6, 0.0)
    with pytest.raises(InputError, match="rail profile another one of this name, needed: UIC60"):
        load(file, Expected(wheel, moved, COARSE))


def test_the_grid_of_a_named_table_is_free(coarse, profiles):
    check_expected(coarse, "t.h5", expected(profiles, TableSettings(normal="hertz"), matters=tables.OF_A_SCENARIO))
    with pytest.raises(InputError, match="y-step"):
        check_expected(coarse, "t.h5", expected(profiles, TableSettings(normal="hertz")))


def test_every_setting_has_its_option():
    options = {option.name: option.opts[0] for option in build_lut.params}
    fields = [field.name for field in dataclasses.fields(TableSettings)]
    assert list(tables.OPTIONS) == fields
    assert {key: options[key] for key in fields} == {key: tables.OPTIONS[key][0] for key in fields}
