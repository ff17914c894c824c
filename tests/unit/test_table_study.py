"""Contact tables that a study needs: built once, kept, checked when they are used again."""

import dataclasses
import math
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from railcli.analysis.build_table import build_table
from railcli.errors import InputError
from railcli.files import scenario
from railcli.files.tables import ARRAYS, read, save
from railcli.kernels import jit, place
from railcli.model.contact_table import TableSettings, mount
from railcli.model.system import assemble
from railcli.studies import tables
from railcli.studies.tables import table_for
from railcli.studies.voice import Voice

ROOT = Path(__file__).parents[2]
COARSE = TableSettings(normal="hertz", y_step=0.5e-3, roll_step=5e-3, yaw_count=3)


class Heard(Voice):
    """Keeps what it hears."""

    def __init__(self):
        self.announced, self.warned = [], []

    def announce(self, text):
        self.announced.append(text)

    def warn(self, text):
        self.warned.append(text)


@pytest.fixture
def voice():
    return Heard()


@pytest.fixture(scope="module")
def coarse(profiles):
    return build_table(*profiles, COARSE)[0]


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
    arrays = all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in ARRAYS)
    return arrays and one.key == other.key and one.settings == other.settings


def test_a_table_is_built_once_and_then_reused(coarse, profiles, cache, built, voice):
    first = table_for(COARSE, *profiles, voice)
    second = table_for(COARSE, *profiles, voice)
    assert len(built) == 1 and same(first, second) and same(first, coarse)
    table_for(dataclasses.replace(COARSE, gauge=1.436), *profiles, voice)
    assert len(built) == 2 and len(list(cache.iterdir())) == 2


def test_every_pairing_of_a_scenario_gets_its_table(profiles, cache, built, monkeypatch, voice):
    """Wheels 1 mm smaller on the left of one wheelset, another rail on all of the left: three tables, no more."""

    def coarse_settings(_, radius):
        return dataclasses.replace(COARSE, radius=radius)

    monkeypatch.setattr(tables, "table_settings", coarse_settings)
    case = scenario.load("curve-1200-45")
    bodies = list(case.vehicle.bodies)
    bodies[3] = bodies[3].model_copy(update={"left_wheel_radius": 0.459})
    vehicle = type(case.vehicle)(**{**dict(case.vehicle), "bodies": tuple(bodies)})
    case = case.varied(vehicle=vehicle, contact={"left_rail_profile": "60E1"})
    found = tables.tables_for(case, voice)
    assert [(table.rail_name, table.settings.radius) for table in found] == [
        ("UIC60", 0.46), ("60E1", 0.459), ("60E1", 0.46)
    ]  # fmt: skip
    assert len(built) == 3
    assert assemble(case, found).model.wheel["table"].tolist() == [0, 1, 0, 2, 0, 2, 0, 2]


def test_a_rail_that_includes_its_inclination_is_not_inclined_again(profiles, cache, monkeypatch, recwarn, voice):
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
        assert {settings.inclination for settings in tables.tables_for(case, voice)} == {inclination}
        assert len(recwarn.list) == warnings
        recwarn.clear()


def test_a_named_table_of_the_left_side_must_be_for_it(coarse, tmp_path, voice):
    case = scenario.load("curve-1200-45")
    file, left = tmp_path / "table.h5", tmp_path / "left.h5"
    save(coarse, file)
    names = {"table": str(file), "left_table": str(file)}
    assert [same(table, coarse) for table in tables.tables_for(case.varied(contact=names), voice)] == [True]
    save(coarse, left)
    case = case.varied(contact={**names, "left_rail_profile": "60E1", "left_table": str(left)})
    with pytest.raises(InputError, match="left.h5: was built for rail profile UIC60, needed: 60E1"):
        tables.tables_for(case, voice)


def test_a_broken_table_in_the_cache_is_built_again_with_a_warning(profiles, cache, built, voice):
    table_for(COARSE, *profiles, voice)
    (path,) = cache.iterdir()
    path.write_bytes(path.read_bytes()[:-1])
    table_for(COARSE, *profiles, voice)
    assert len(built) == 2
    first, second, third = voice.warned
    assert first == third and first.startswith("contact table of ORES1002 on UIC60: p99 of ")  # it is coarse
    assert second.startswith(f"{path}: is truncated")
    table_for(COARSE, *profiles, voice)
    assert len(built) == 2


def test_a_table_in_the_cache_that_other_kernels_built_is_replaced(profiles, cache, built, monkeypatch, voice):
    with monkeypatch.context() as before:
        before.setattr(jit, "source_digest", lambda: "0123456789abcdef")
        table_for(COARSE, *profiles, voice)
    table_for(COARSE, *profiles, voice)
    assert len(built) == 2 and not any("built again" in text for text in voice.warned)


def test_without_another_voice_a_doubt_is_a_python_warning(profiles, cache):
    with pytest.warns(RuntimeWarning, match="contact table of ORES1002 on UIC60: p99 of "):
        table_for(COARSE, *profiles)


BUILDS = """
import sys
from railcli.files.profiles import load_profile
from railcli.model.contact_table import TableSettings
from railcli.studies import tables
from railcli.studies.voice import Voice

class Loud(Voice):
    def announce(self, text):
        print(text, flush=True)
    def warn(self, text):
        print("built", flush=True)

settings = TableSettings(normal="hertz", y_step=0.5e-3, roll_step=5e-3, yaw_count=3)
profiles = load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail")
{before}
tables.table_for(settings, *profiles, Loud())
"""
DIES = """
from railcli.files.lock import alone
import os, signal
place = tables.cached_path(settings, *profiles)
place.parent.mkdir(parents=True, exist_ok=True)
with alone(place):
    print("holds", flush=True)
    sys.stdin.readline()
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def process(tmp_path):
    """Function that starts Python code which knows the cache in `tmp_path`, and compiled code where it is kept."""
    places = {"PYTHONPATH": str(ROOT), "RAILCLI_CACHE_DIR": str(tmp_path)}
    code_cache = os.environ.get("NUMBA_CACHE_DIR") or str(place.cache_root() / "code")
    environment = {**os.environ, **places, "NUMBA_CACHE_DIR": code_cache}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    return lambda code: subprocess.Popen([sys.executable, "-c", code], env=environment, **pipes)


needs_locks = pytest.mark.skipif(find_spec("fcntl") is None, reason="the system has no such locks")


@needs_locks
def test_of_two_processes_that_need_a_table_one_builds_it(coarse, process, tmp_path):
    both = [process(BUILDS.format(before="")) for _ in range(2)]
    said = [one.communicate(timeout=600)[0] for one in both]
    assert [one.returncode for one in both] == [0, 0]
    assert sum(text.count("built") for text in said) == 1
    (path,) = (tmp_path / "tables").iterdir()
    assert same(read(path).table, coarse)


@needs_locks
def test_who_waits_for_a_process_that_is_killed_builds_the_table_itself(coarse, process, tmp_path):
    doomed = process(BUILDS.format(before=DIES))
    assert doomed.stdout.readline() == "holds\n"
    waiting = process(BUILDS.format(before=""))
    assert waiting.stdout.readline().startswith("Another process builds the contact table of ORES1002 on UIC60")
    doomed.communicate("now\n", timeout=60)
    assert "built" in waiting.communicate(timeout=600)[0] and (doomed.returncode, waiting.returncode) == (-9, 0)
    (path,) = (tmp_path / "tables").iterdir()
    assert same(read(path).table, coarse)
