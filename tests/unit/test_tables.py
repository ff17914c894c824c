"""Contact tables on disk: what is read is what was saved, and anything else is refused."""

import dataclasses
import hashlib
import math
import os
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from railcli.analysis.build_table import build_table
from railcli.commands.build_lut import build_lut
from railcli.errors import InputError
from railcli.files import scenario, tables
from railcli.files.tables import Expected, check_expected, load, read, save, table_for
from railcli.kernels import jit
from railcli.model.contact_table import TableSettings, mount
from railcli.model.system import assemble

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


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("RAILCLI_CACHE_DIR", str(tmp_path))
    return tmp_path / "tables"


@pytest.fixture
def built(monkeypatch):
    """List that grows with every table built."""
    calls = []

    def make(*arguments, honest=tables.make, **options):
        calls.append(arguments)
        return honest(*arguments, **options)

    monkeypatch.setattr(tables, "make", make)
    return calls


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


def test_a_table_is_built_once_and_then_reused(coarse, profiles, cache, built):
    first = table_for(COARSE, *profiles, quiet=True)
    second = table_for(COARSE, *profiles, quiet=True)
    assert len(built) == 1 and same(first, second) and same(first, coarse)
    table_for(dataclasses.replace(COARSE, gauge=1.436), *profiles, quiet=True)
    assert len(built) == 2 and len(list(cache.iterdir())) == 2


def test_every_pairing_of_a_scenario_gets_its_table(profiles, cache, built, monkeypatch):
    """Wheels 1 mm smaller on the left of one wheelset, another rail on all of the left: three tables, no more."""

    def coarse_settings(_, radius):
        return dataclasses.replace(COARSE, radius=radius)

    monkeypatch.setattr(tables, "table_settings", coarse_settings)
    case = scenario.load("curve-1200-45")
    bodies = list(case.vehicle.bodies)
    bodies[3] = bodies[3].model_copy(update={"left_wheel_radius": 0.459})
    vehicle = type(case.vehicle)(**{**dict(case.vehicle), "bodies": tuple(bodies)})
    case = case.varied(vehicle=vehicle, contact={"left_rail_profile": "60E1"})
    found = tables.tables_for(case, quiet=True)
    assert [(table.rail_name, table.settings.radius) for table in found] == [
        ("UIC60", 0.46), ("60E1", 0.459), ("60E1", 0.46)
    ]  # fmt: skip
    assert len(built) == 3
    assert assemble(case, found).model.wheel["table"].tolist() == [0, 1, 0, 2, 0, 2, 0, 2]


def test_a_rail_that_includes_its_inclination_is_not_inclined_again(profiles, cache, monkeypatch, capsys):
    wheel, rail = profiles
    leaning = dataclasses.replace(rail.rotated(-math.atan(1 / 40)), inclined=None)
    included = dataclasses.replace(leaning, inclined=True)
    assert included.digest() != leaning.digest()
    for at in (20.0, 0.0):
        found = mount(wheel, included, TableSettings(inclination=at))
        wanted = mount(wheel, leaning, TableSettings(inclination=0.0))
        assert (found.seat, found.rail.tobytes()) == (wanted.seat, wanted.rail.tobytes())
    case = scenario.load("straight-60")
    monkeypatch.setattr(tables, "table_for", lambda settings, *_: settings)
    for item, inclination, warnings in ((included, 0.0, 0), (leaning, 20.0, 1), (rail, 20.0, 0)):
        known = dataclasses.replace(item)
        monkeypatch.setattr(tables, "profile_of", lambda _, place, kind, known=known: {"rail": known}.get(kind, wheel))
        assert {settings.inclination for settings in tables.tables_for(case)} == {inclination}
        assert capsys.readouterr().err.count("Warning") == warnings


def test_a_named_table_of_the_left_side_must_be_for_it(coarse, file, profiles, tmp_path):
    case = scenario.load("curve-1200-45")
    names = {"table": str(file), "left_table": str(file)}
    assert [same(table, coarse) for table in tables.tables_for(case.varied(contact=names), quiet=True)] == [True]
    left = tmp_path / "left.h5"
    save(coarse, left)
    case = case.varied(contact={**names, "left_rail_profile": "60E1", "left_table": str(left)})
    with pytest.raises(InputError, match="left.h5: was built for rail profile UIC60, needed: 60E1"):
        tables.tables_for(case, quiet=True)


def test_a_broken_table_in_the_cache_is_built_again_with_a_warning(profiles, cache, built, capsys):
    table_for(COARSE, *profiles, quiet=True)
    (path,) = cache.iterdir()
    path.write_bytes(path.read_bytes()[:-1])
    table_for(COARSE, *profiles, quiet=True)
    assert len(built) == 2
    first, line, second = capsys.readouterr().err.splitlines()
    assert first == second and first.startswith("Warning: contact table of ORES1002 on UIC60: p99 of ")  # it is coarse
    assert line.startswith(f"Warning: {path}: is truncated")
    table_for(COARSE, *profiles, quiet=True)
    assert len(built) == 2


def test_a_table_in_the_cache_that_other_kernels_built_is_replaced(profiles, cache, built, monkeypatch, capsys):
    with monkeypatch.context() as before:
        before.setattr(jit, "source_digest", lambda: "0123456789abcdef")
        table_for(COARSE, *profiles, quiet=True)
    table_for(COARSE, *profiles, quiet=True)
    assert len(built) == 2 and "built again" not in capsys.readouterr().err


def test_two_processes_that_build_at_once_do_not_disturb_each_other(coarse, profiles, tmp_path):
    code = (
        "from railcli.files.tables import *; from railcli.model.contact_table import TableSettings; "
        "table_for(TableSettings(normal='hertz', y_step=0.5e-3, roll_step=5e-3, yaw_count=3), "
        "load_profile('ORES1002', 'wheel'), load_profile('UIC60', 'rail'), quiet=True)"
    )
    places = {"PYTHONPATH": str(ROOT), "RAILCLI_CACHE_DIR": str(tmp_path)}
    code_cache = os.environ.get("NUMBA_CACHE_DIR") or str(jit.cache_root() / "code")
    environment = {**os.environ, **places, "NUMBA_CACHE_DIR": code_cache}
    both = [subprocess.Popen([sys.executable, "-c", code], env=environment) for _ in range(2)]
    assert [process.wait(timeout=600) for process in both] == [0, 0]
    (path,) = (tmp_path / "tables").iterdir()
    assert same(read(path).table, coarse)
