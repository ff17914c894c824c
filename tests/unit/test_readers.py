"""Whatever stands in a user's file, a reader gives a result or an InputError of one line; seeds are fixed.

Files are real ones, changed as accidents, editors and other programs change them, and some at random.
"""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from accidents import (
    KEYS,
    LINE,
    NO_NUMBERS,
    RECORDING,
    RUN,
    VALUES,
    VEHICLE,
    add_line,
    changed,
    closed,
    cut,
    encoded,
    exchanged,
    flipped,
    lines_changed,
    noisy,
    replace_key,
    replace_number,
    replace_value,
    scaled,
)  # fmt: skip
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from railcli.analysis.build_table import build_table
from railcli.analysis.parts import parts
from railcli.errors import InputError
from railcli.files import scenario, tables
from railcli.files.irregularity import Asked, recording
from railcli.files.profile_import import ImportSettings, canonical_text, import_profile
from railcli.files.profiles import load_profile
from railcli.files.resources import resource
from railcli.files.track_table import alignment
from railcli.model import track
from railcli.model.contact_table import TableSettings
from railcli.model.system import needed, parameters, table_settings
from railcli.model.vehicle import pack

SAMPLES = sorted((Path(__file__).parents[1] / "data" / "samples").glob("*.[bwp]*"))
CANONICAL = [resource("profiles/UIC60/UIC60.csv"), resource("profiles/ORES1002/ORES1002.csv")]
FUZZ = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
PLACE = st.floats(0.0, 1.0)


def survives(read):
    """The result of a reader, or None after an InputError of one line."""
    try:
        return read()
    except InputError as error:
        message = str(error)
        assert message.isprintable() and len(message) < 1500, message
        return None


# How files change


CHANGES = st.one_of(
    st.tuples(st.just(replace_number), PLACE, st.sampled_from(NO_NUMBERS)),
    st.tuples(
        st.just(lines_changed),
        PLACE,
        st.sampled_from([1, 2, 3, 50, 1000]),
        st.sampled_from(["repeat", "drop", "reverse", "shuffle"]),
    ),
    st.tuples(st.just(closed), PLACE),
    st.tuples(st.just(scaled), st.sampled_from([-1.0, 1e-3, 1e3, 25.4, 0.0, 1e300])),
    st.tuples(st.just(noisy), st.sampled_from([1e-5, 1e-3, 0.02, 0.3]), st.integers(0, 9)),
    st.tuples(st.just(flipped), PLACE, st.integers(0, 7)),
    st.tuples(st.just(encoded), st.sampled_from(["utf-16", "utf-16-le", "utf-8-sig", "latin-1"])),
    st.tuples(st.just(cut), PLACE),
    st.tuples(st.just(exchanged), st.sampled_from([b"\n", b",", b".", b" ", b"="]),
              st.sampled_from([b"\r\n", b"\r", b";", b",", b" ", b"\t", b"\n\n", b"\xe2\x80\xa8"])),
)  # fmt: skip


# Profiles


@FUZZ
@given(
    source=st.sampled_from(SAMPLES + CANONICAL),
    ending=st.sampled_from(["same"] * 4 + [".txt", ".csv", ".ban", ".whl", ".mpt", ".prr", ".prw", ".rail", ".wheel"]),
    changes=st.lists(CHANGES, min_size=1, max_size=3),
    options=st.fixed_dictionaries(
        {
            "kind": st.sampled_from([None, "rail", "wheel"]),
            "units": st.sampled_from([None, None, "mm", "m", "inch"]),
            "mirror_y": st.sampled_from(["auto", "auto", "yes", "no"]),
            "shift_y": st.sampled_from([0.0, 0.0, 1e-3, 1e9, float("nan")]),
            "smooth": st.sampled_from([None, 0.5e-3, 4e-3, 40e-3, float("nan")]),
            "resample": st.sampled_from([None, 0.5e-3, 5e-3]),
        }
    ),
)
def test_changed_profiles(tmp_path, source, ending, changes, options):
    """An import that succeeds gives finite numbers and a canonical file that is read again."""
    path = tmp_path / f"a{source.suffix if ending == 'same' else ending}"
    path.write_bytes(changed(source.read_bytes(), changes))
    survives(lambda: load_profile(path, "rail"))
    chosen = ImportSettings(**options)
    imported = survives(lambda: import_profile(path, chosen))
    if imported is not None:
        assert np.isfinite([imported.profile.y, imported.profile.z, imported.profile.angle]).all()
        json.dumps(imported.account, allow_nan=False)
        written = tmp_path / "canonical.csv"
        written.write_text(canonical_text(imported, chosen))
        load_profile(written, imported.profile.kind)


@FUZZ
@given(source=st.sampled_from(CANONICAL), changes=st.lists(CHANGES, min_size=1, max_size=3))
def test_changed_canonical_profiles(tmp_path, source, changes):
    path = tmp_path / "a.csv"
    path.write_bytes(changed(source.read_bytes(), changes))
    for kind in ("rail", "wheel"):
        profile = survives(lambda kind=kind: load_profile(path, kind))
        assert profile is None or np.isfinite([profile.y, profile.z, profile.angle]).all()


@FUZZ
@given(
    text=st.sampled_from([RECORDING, RECORDING.replace(";", "\t"), LINE, LINE.replace(",", ";").replace(".", ",")]),
    changes=st.lists(CHANGES, min_size=1, max_size=3),
    bridge=st.sampled_from([0.0, 5.0]),
)
def test_changed_recordings(tmp_path, text, changes, bridge):
    path = tmp_path / "track.csv"
    path.write_bytes(changed(text.encode(), changes))
    found = survives(lambda: recording(path, Asked(bridge=bridge)))
    if found is not None:
        assert (np.diff(found.samples.position) > 0.0).all()
        assert all(np.isfinite(values).all() for values in found.samples.channels.values())
    line = survives(lambda: alignment(path)[0])
    if line is not None:
        assert survives(lambda: track.pack(track.Track((line,)))) is None or len(parts(line)) >= 1


@pytest.mark.parametrize("name", ["a.ban", "a.mpt", "a.prw", "a.rail", "a.csv"])
@pytest.mark.parametrize("content", ["one line", "short lines", "points", "keys", "blank"])
def test_ten_megabytes(tmp_path, name, content):
    """Files of the largest size allowed end in one line too."""
    unit = {
        "one line": b"1.5 ",
        "short lines": b"1\n",
        "points": b"1.25 -3.5\n",
        "keys": b"MPD7=L 1 2 3 4\nkey=value\n",
        "blank": b"\n\n \n",
    }[content]
    path = tmp_path / name
    path.write_bytes(unit * (10_000_000 // len(unit)))
    assert survives(lambda: import_profile(path, ImportSettings(kind="rail"))) is None
    assert survives(lambda: load_profile(path, "rail")) is None


# Scenarios and vehicles

TOML_CHANGES = st.one_of(
    st.tuples(st.just(replace_number), PLACE, st.sampled_from(VALUES)),
    st.tuples(st.just(replace_value), PLACE, st.sampled_from(VALUES)),
    st.tuples(st.just(replace_key), PLACE, st.sampled_from(KEYS)),
    st.tuples(st.just(add_line), PLACE, st.sampled_from(KEYS), st.sampled_from(VALUES)),
    CHANGES,
)


@settings(FUZZ, max_examples=200)
@given(run=st.lists(TOML_CHANGES, max_size=3), vehicle=st.lists(TOML_CHANGES, max_size=2))
def test_changed_scenarios_and_vehicles(tmp_path, run, vehicle):
    """What passes can be packed, digested and told which tables it needs."""
    (tmp_path / "case.toml").write_bytes(changed(RUN, run))
    (tmp_path / "vehicle.toml").write_bytes(changed(VEHICLE, vehicle))
    survives(lambda: scenario.load_vehicle(tmp_path / "vehicle.toml"))
    case = survives(lambda: scenario.load(tmp_path / "case.toml"))
    if case is not None:
        json.dumps(case.as_dict(), allow_nan=False)
        assert len(case.digest()) == 16
        assert all(np.isfinite(value).all() for value in parameters(case)[0])
        packed = pack(case.vehicle, case.run.gravity, case.contact.tape_circle, case.contact.friction)
        assert np.isfinite(packed.rest).all()
        assert np.isfinite(track.pack(case.track)["curvature"]).all()
        for pairing in needed(case):
            survives(lambda pairing=pairing: table_settings(case, pairing.radius))


# Contact tables


@pytest.fixture(scope="module")
def table_bytes(profiles, tmp_path_factory):
    tiny = TableSettings(
        normal="hertz", y_range=4e-3, y_step=1e-3, roll_range=5e-3, roll_step=5e-3, yaw_range=5e-3, yaw_count=2
    )  # fmt: skip
    path = tmp_path_factory.mktemp("tiny") / "table.h5"
    tables.save(build_table(*profiles, tiny)[0], path)
    return path.read_bytes()


@FUZZ
@given(changes=st.lists(CHANGES, min_size=1, max_size=2))
def test_changed_tables(tmp_path, table_bytes, changes):
    path = tmp_path / "table.h5"
    path.write_bytes(data := changed(table_bytes, changes))
    assert (survives(lambda: tables.read(path)) is None) == (data != table_bytes)


SETTINGS = [
    "", "{}", "[]", "null", "NaN", '{"gauge": 1}', '{"gauge": "a"}', '{"y_step": 1e-30}', '{"y_range": 1e308}',
    '{"normal": "kp"}', '{"normal": 3}', '{"yaw_count": 1.5}', '{"gauge": NaN}', '{"y_count": 3}', 1.5, b"\xff",
]  # fmt: skip
ARRAYS = [
    1, "text", np.zeros(0), np.zeros((0, 8), np.int32), np.zeros((3, 16)), np.array([b"a"]), np.zeros(3, complex),
    np.zeros((2, 2), np.int32), np.array([0], np.int32), h5py.Empty("f8"), h5py.SoftLink("/nothing"),
    h5py.SoftLink("/"),
]  # fmt: skip
DATASETS = ["node", "cell", "branch"]
ATTRIBUTES = ["version", "settings", "wheel_name", "rail_sha256", "method", "certificate", "kernels"]


@FUZZ
@given(
    attributes=st.dictionaries(st.sampled_from(ATTRIBUTES), st.sampled_from([*SETTINGS, None]), max_size=2),
    arrays=st.dictionaries(st.sampled_from(DATASETS), st.sampled_from(range(len(ARRAYS) + 1)), max_size=1),
)
def test_sealed_tables_of_other_programs(tmp_path, table_bytes, attributes, arrays):
    """A whole HDF5 file with a right seal, in which attributes and datasets are missing or something else."""
    path = tmp_path / "table.h5"
    image = tmp_path / "image.h5"
    image.write_bytes(table_bytes)
    with h5py.File(image, "r+") as file:
        for key, value in attributes.items():
            del file.attrs[key]
            if value is not None:
                file.attrs[key] = value
        for key, index in arrays.items():
            del file[key]
            if index < len(ARRAYS):
                file[key] = ARRAYS[index]
    content = image.read_bytes()[tables.HEAD_SIZE :]
    path.write_bytes(tables._head(content) + content)
    stored = survives(lambda: tables.read(path))
    assert stored is None or not arrays
