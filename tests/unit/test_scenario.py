"""Scenario files: built-in ones, units, defaults, every kind of mistake, and the documentation of the keys."""

import math
import re
import tomllib
from datetime import date
from pathlib import Path

import pytest
import tolerances as tol

from railcli.errors import InputError
from railcli.files import toml
from railcli.files.resources import resource
from railcli.files.scenario import builtin_scenarios, load
from railcli.kernels.layout import Creep
from railcli.model import (
    adhesion,
    air,
    controls,
    driving,
    elements,
    friction_elements,
    limits,
    moments,
    scenario,
    sections,
    tables,
    track_support,
    vehicle,
)
from railcli.model.checks import Description
from railcli.model.submodels import CREEP_LAWS, choose
from railcli.model.system import table_settings

DOCS = Path(__file__).parents[2] / "docs" / "scenario.md"

SHORT = """
[run]
speed_m_per_s = 20

[[track]]
kind = "straight"
length_m = 200
"""


def manchester_text():
    return resource("benchmarks/manchester/vehicle.toml").read_text(encoding="utf-8")


@pytest.fixture
def load_text(tmp_path):
    def load_text(text, name="test.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return load(path)

    return load_text


def test_builtin_scenarios_load():
    names = builtin_scenarios()
    assert {"curve-1200-45", "curve-1200-30", "curve-1200-15", "straight-60", "curve-300"} <= set(names)
    for name, title in names.items():
        assert title and load(name).title == title and load(name).name == name


@pytest.mark.parametrize("speed", [15.0, 30.0, 45.0])
def test_published_curve(speed):
    """What the paper fixes: R = 1200 m, cant 90 mm, the three speeds."""
    case = load(f"curve-1200-{speed:g}")
    straight, transition, curve = case.track.sections
    assert (case.run.speed, curve.radius, curve.hand, curve.cant) == (speed, 1200.0, "right", 0.09)
    assert (straight.length, transition.length, transition.shape) == (100.0, 100.0, "clothoid")
    assert case.distance == case.track.length and case.average_over == 100.0
    assert (case.contact.gauge, case.contact.flange_back, case.contact.tape_circle) == (1.435, 1.36, 0.75)
    other = case.varied(contact={"tape_to_back": 0.0738})
    assert other.contact.tape_circle == pytest.approx(0.7538)
    assert table_settings(other, 0.46).lateral == other.contact.tape_circle and other.digest() != case.digest()
    assert (case.contact.wheel_profile, case.contact.rail_profile) == ("ORES1002", "UIC60")
    assert case.vehicle.name == "Manchester passenger wagon"


def test_bare_load_is_the_curve_at_45():
    assert load().name == "curve-1200-45"


def test_short_file(load_text):
    case = load_text(SHORT)
    assert case.name == "test" and case.vehicle.name == "Manchester passenger wagon"
    assert (case.run.step, case.run.output_interval, case.run.gravity) == (None, 10e-3, 9.81)
    assert case.varied(run={"step": 0.5e-3}).run.steps_per_output == 20
    assert (case.distance, case.duration) == (200.0, 10.0)


def test_any_unit_of_the_same_quantity(load_text):
    one = load_text(SHORT + "[contact]\ngauge_mm = 1432\nyoung_GPa = 206")
    two = load_text(
        SHORT.replace("speed_m_per_s = 20", "speed_kmh = 72").replace("length_m = 200", "length_km = 0.2")
        + "[contact]\ngauge_m = 1.432\nyoung_Pa = 206e9"
    )
    assert one.as_dict() == two.as_dict() and one.digest() == two.digest()
    assert one.contact.gauge == 1.432 and one.contact.young == 206e9


def test_duration_instead_of_distance(load_text):
    case = load_text(SHORT.replace("= 20", "= 20\nduration_s = 4", 1))
    assert (case.distance, case.duration) == (80.0, 4.0)
    assert case.average_over == 80.0  # the default of 100 m gives way


def test_files_are_beside_the_scenario(load_text, tmp_path):
    wagon = manchester_text()
    (tmp_path / "wagons").mkdir()
    (tmp_path / "wagons" / "own.toml").write_text(wagon.replace("Manchester passenger wagon", "own"))
    case = load_text('vehicle = "wagons/own.toml"\n' + SHORT + '[contact]\nrail_profile = "worn.csv"\ntable = "t.h5"')
    assert case.vehicle.name == "own"
    assert case.contact.rail_profile == str(tmp_path / "worn.csv")
    assert case.contact.table == str(tmp_path / "t.h5")
    assert case.contact.wheel_profile == "ORES1002"


def test_left_side(load_text, tmp_path):
    """Files of the left side stand beside the scenario too, however long their names; what is not given is as right."""
    long = "/".join(["a folder with a long name"] * 5)
    case = load_text(
        SHORT + f'[contact]\nwheel_profile = "worn.csv"\nleft_rail_profile = "{long}/rail.csv"\nleft_table = "l.h5"'
    )
    worn = str(tmp_path / "worn.csv")
    assert case.contact.sides == (
        (worn, "UIC60", None),
        (worn, str(tmp_path / long / "rail.csv"), str(tmp_path / "l.h5")),
    )


def test_varied_is_validated():
    case = load("curve-1200-45")
    other = case.varied(run={"speed": 30.0}, contact={"friction": 0.4, "creep_law": "smooth"}, name="other")
    assert (other.run.speed, other.contact.friction, other.contact.creep_law) == (30.0, 0.4, "smooth")
    assert (other.name, other.contact.gauge, other.track) == ("other", 1.435, case.track)
    assert (case.run.speed, case.contact.friction) == (45.0, 0.3)
    assert other.digest() != case.digest()
    with pytest.raises(ValueError, match="greater than 0"):
        case.varied(run={"speed": 0.0})


def test_digest_names_what_decides_the_results(load_text):
    case = load_text(SHORT)
    assert load_text('title = "words"\n' + SHORT, "renamed.toml").digest() == case.digest()
    assert load_text(SHORT + "[contact]\nfriction = 0.3").digest() == case.digest()
    assert load_text(SHORT + "[contact]\nfriction = 0.31").digest() != case.digest()


def test_track_support(load_text):
    """Rigid unless asked for; a named track, with a value replaced; digests tell what gives way."""
    rigid = load_text(SHORT)
    assert rigid.track_support.packed() == ((0.0, 0.0), (0.0, 0.0))
    assert load_text(SHORT + '[track_support]\nkind = "rigid"').digest() == rigid.digest()
    soft = load_text(SHORT + '[track_support]\nkind = "ballasted-soft"')
    other = load_text(SHORT + '[track_support]\nkind = "ballasted-soft"\nvertical_stiffness_MN_per_m = 80')
    (lateral, vertical), damping = soft.track_support.packed()
    assert other.track_support.packed() == ((lateral, 80e6), damping) and vertical < 80e6
    assert len({case.digest() for case in (rigid, soft, other)}) == 3
    text = "kind = 'own'\nvertical_stiffness_N_per_m = 5e7\nvertical_damping_Ns_per_m = 1e5"
    own = text + "\nlateral_stiffness_N_per_m = 2e7\nlateral_damping_Ns_per_m = 4e4"
    assert load_text(f"{SHORT}[track_support]\n{own}").track_support.packed() == ((2e7, 5e7), (4e4, 1e5))
    with pytest.raises(InputError, match="needs lateral_stiffness and lateral_damping as well"):
        load_text(f"{SHORT}[track_support]\n{text}")
    with pytest.raises(InputError, match="vertical_damping belongs to a track that gives way"):
        load_text(f"{SHORT}[track_support]\nvertical_damping_Ns_per_m = 1e5")
    with pytest.raises(InputError, match="unknown name 'slap'; did you mean 'slab'"):
        load_text(f"{SHORT}[track_support]\nkind = 'slap'")
    with pytest.raises(InputError, match=r"vertical_stiffness_N_per_m: must be >= 1e\+?0?6"):
        load_text(f"{SHORT}[track_support]\nkind = 'slab'\nvertical_stiffness_N_per_m = 5")


def test_as_dict_says_units():
    values = load("curve-1200-45").as_dict()
    assert values["run"]["speed_m_per_s"] == 45.0 and values["contact"]["gauge_m"] == 1.435
    assert values["track"][2] == {
        "kind": "curve",
        "length_m": 500.0,
        "radius_m": 1200.0,
        "hand": "right",
        "cant_m": 0.09,
        "gauge_widening_m": 0.0,
    }
    assert values["vehicle"]["body"][0]["mass_kg"] == 32000.0


def test_frozen():
    with pytest.raises(ValueError, match="frozen"):
        load().run.speed = 3.0


WEIRD = [-1, 0, 1e308, 10**400, math.nan, math.inf, "", "x", True, [], {}, [[]], [1, "a"], [{}], date(2024, 1, 1)]


def places(node):
    """Every table and list within a file, with each of its keys or indices."""
    if isinstance(node, dict | list):
        for key in list(node) if isinstance(node, dict) else range(len(node)):
            yield node, key
            yield from places(node[key])


@pytest.mark.parametrize("description", [scenario.Scenario, vehicle.Vehicle])
def test_no_value_gets_past_with_a_traceback(description):
    """Each value of two complete files in turn is replaced by things that do not belong there."""
    table = tomllib.loads(manchester_text())
    if description is scenario.Scenario:
        own = toml.build(vehicle.Vehicle, table, "wagon.toml")
        table = tomllib.loads(resource("benchmarks/manchester/cases/curve-300.toml").read_text(encoding="utf-8"))
        table |= {
            "name": "x",
            "vehicle": own,
            "contact": {"gauge_mm": 1435, "creep_law": "hard"},
            "start": {"lateral_mm": 1},
        }
    refused = 0
    for node, key in list(places(table)):
        good = node[key]
        for bad in WEIRD:
            node[key] = bad
            try:
                toml.build(description, table, "file.toml")
            except InputError as error:
                assert re.fullmatch(r"file\.toml: [^\n]{8,250}", str(error)), error
                refused += 1
        node[key] = good
    assert refused > 100


SECTION = "[[track]]\nkind = "
BAD = [
    ("speed_m_per_s = 20", "speed_m_per_s = 0", "run.speed_m_per_s: must be > 0 m/s, got 0"),
    ("speed_m_per_s = 20", "speed_kmh = 720", "run.speed_kmh: must be <= 540 km/h, got 720"),
    ("speed_m_per_s = 20", "sped_kmh = 72", "run.sped_kmh: unknown key; did you mean 'speed_kmh'?"),
    ("speed_m_per_s = 20", "speed = 72", "run.speed: unknown key; did you mean 'speed_m_per_s' or 'speed_kmh' or "),
    ("speed_m_per_s = 20", "", "run: key 'speed_m_per_s' is missing"),
    ("= 20", "= 20\nstep_ms = 0", "run.step_ms: must be >= 0.001 ms, got 0"),
    ("= 20", "= 20\nstep_ms = 3", "run.step_ms: must be <= 2 ms, got 3"),
    ("= 20", "= 20\nstep_ms = 0.3", "run: output interval must be a multiple of the step, got 10 ms and 0.3 ms"),
    ("= 20", "= 20\nstep_ms = 0.5\noutput_interval_ms = 0.1", "run: output interval must be a multiple of the step"),
    ("= 20", "= 20\noutput_interval_ms = 1e-4", "run.output_interval_ms: must be >= 0.001 ms, got 0.0001"),
    ("= 20", "= 20\ndistance_m = 300", "track shorter than the run: 200 m of track, 300 m to run"),
    ("= 20", "= 20\nduration_s = 11", "track shorter than the run: 200 m of track, 220 m to run"),
    ("= 20", "= 20\nduration_s = 1\ndistance_m = 9", "run: give either distance_m or duration_s"),
    ("= 20", "= 20\naverage_over_m = 201", "run.average_over_m: must be at most the 200 m of the run, got 201 m"),
    ("= 20", "= 20\naverage_over_m = 5\ndistance_m = 20\noutput_interval_ms = 2000",
     "run.output_interval_ms: must be at most 1000 ms, the length of the run, got 2000 ms"),
    ("= 20", "= 20\nspeed_kmh = 72", "run.speed_kmh: 'speed_m_per_s' says the same"),
    ("[run]", '"a\\nb" = 1\n[run]', "a\\nb: unknown key"),
    ("[run]", "[runs]", "runs: unknown key; did you mean 'run'?"),
    ("[run]", "[contact]\nfrictoin = 0.3\n[run]", "contact.frictoin: unknown key; did you mean 'friction'?"),
    ("[run]", "[contact]\nfriction = -0.1\n[run]", "contact.friction: must be >= 0, got -0.1"),
    ("[run]", "[contact]\nfriction = inf\n[run]", "contact.friction: must be a finite number, got inf"),
    ("[run]", "[contact]\ncreep_law = 'hrad'\n[run]", "contact.creep_law: unknown name 'hrad'; did you mean 'hard'?"),
    (
        "[run]",
        "[contact]\ninclination = 0.05\n[run]",
        "inclination means 1 in ...: must be 0 (as in the profile) or >= 5, got 0.05",
    ),
    ("[run]", "[contact]\ngauge_mm = 1350\n[run]", "contact: no wheelset fits: flange back 1360 mm, gauge 1350 mm"),
    ("[run]", "[contact]\ngauge_m = 1435\n[run]", "contact.gauge_m: must be <= 2 m, got 1435"),
    (
        "[run]",
        "[contact]\ngauge_kg = 1435\n[run]",
        "contact.gauge_kg: unknown key; did you mean 'gauge_m' or 'gauge_mm'",
    ),
    ("[run]", "[contact]\nwheel_profile = 3\n[run]", "contact.wheel_profile: must be a text in quotes, got 3"),
    (
        "[run]",
        "[contact]\ntable = 't.h5'\nleft_wheel_profile = '60E1'\n[run]",
        "contact.table: is for one side, and the sides differ; give contact.left_table as well",
    ),
    ("[run]", "contact = 3\n[run]", "contact: must be a table, got 3"),
    ("[run]", "[start]\nlateral_mm = 30\n[run]", "start.lateral_mm: must be <= 10 mm, got 30"),
    ("[run]", "vehicle = 'mancester'\n[run]", "vehicle: mancester: no built-in vehicle"),
    ("[run]", "vehicle = 'no/such.toml'\n[run]", "no/such.toml: no such file"),
    ("[run]", "vehicle = 3\n[run]", "vehicle: must be a table, got 3"),
    ("[run]", "[run", "is not valid TOML"),
    (
        'kind = "straight"',
        'kind = "strait"',
        "track[1].kind: must be one of 'straight', 'curve', 'transition', 'measured', got 'strait'",
    ),
    ('kind = "straight"', 'kind = "strait"', "did you mean 'straight'?"),
    ('kind = "straight"', "", "track[1]: key 'kind' is missing"),
    ('kind = "straight"', 'kind = "curve"', "track[1]: key 'radius_m' is missing (and 1 more)"),
    (
        'kind = "straight"',
        'kind = "straight"\nradius_m = 3',
        "track[1].radius_m: unknown key; known: 'kind', 'length_m'",
    ),
    ("length_m = 200", "length_m = -200", "track[1].length_m: must be >= 0.001 m, got -200"),
    ("[[track]]", "[track]", "track: must be a list, got a table"),
    (
        "length_m = 200",
        f'length_m = 200\n{SECTION}"transition"\nlength_m = 9',
        "track: begins or ends with a transition",
    ),
    (
        "length_m = 200",
        f'length_m = 200\n{SECTION}"curve"\nlength_m = 9\nradius_m = 300\nhand = "right"\ncant_mm = 90',
        "track: curvature or cant jumps between sections 1 and 2 (straight, curve); put a section of kind 'transition'",
    ),
    (
        "length_m = 200",
        f'length_m = 200\n{SECTION}"transition"\nlength_m = 9\nshape = "blos"\n{SECTION}"straight"\nlength_m = 9',
        "track[2].shape: unknown name 'blos'; did you mean 'bloss'?",
    ),
    (
        "[[track]]",
        f'{SECTION}"curve"\nlength_m = 9\nradius_m = 300\nhand = "outside"\n[[track]]',
        "track[1].hand: must be 'left' or 'right', got 'outside'",
    ),
    (
        "[[track]]",
        f'{SECTION}"curve"\nlength_m = 9\nradius_m = 300\nhand = "left"\ncant_mm = 400\n[[track]]',
        "track[1].cant_mm: must be <= 300 mm, got 400",
    ),
]


@pytest.mark.parametrize(("old", "new", "message"), BAD)
def test_bad_scenario(old, new, message, load_text):
    assert old in SHORT
    with pytest.raises(InputError) as error:
        load_text(SHORT.replace(old, new, 1))
    assert message in str(error.value) and "test.toml: " in str(error.value)
    assert "\n" not in str(error.value)


def test_a_vehicle_too_long_for_the_margin(load_text, tmp_path):
    wagon = manchester_text().replace("9.5", "59.5").replace("8.22", "58.22")
    (tmp_path / "long.toml").write_text(wagon.replace("10.78", "60.78"))
    with pytest.raises(InputError, match="a body stands 60.78 m from the first one; at most 50 m fit"):
        load_text('vehicle = "long.toml"\n' + SHORT)


def test_a_fault_in_the_vehicle_names_both_files(load_text, tmp_path):
    (tmp_path / "own.toml").write_text(manchester_text().replace("mass_kg = 2615", "mass_kg = -1"))
    with pytest.raises(
        InputError, match=r"test\.toml: vehicle: .*own\.toml: body\[2\]\.mass_kg: must be > 0 kg, got -1"
    ):
        load_text('vehicle = "own.toml"\n' + SHORT)


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"\xff\xfe\x00", "not a text file in UTF-8"), (b"x = ", "not valid TOML"), (b"", "key 'run' is missing")],
)
def test_unreadable_file(content, message, tmp_path):
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        load(path)


def test_missing_file_folder_and_name(tmp_path):
    with pytest.raises(InputError, match=r"absent\.toml: no such file"):
        load(tmp_path / "absent.toml")
    with pytest.raises(InputError, match="is a folder"):
        load(f"{tmp_path}/")
    with pytest.raises(InputError, match="curve-1200-46: no built-in scenario .* did you mean 'curve-1200-45'"):
        load("curve-1200-46")


def test_registry_gives_a_near_name():
    assert choose(CREEP_LAWS, "--creep-law", "smooth").value == Creep.SMOOTH
    with pytest.raises(InputError, match="--creep-law: unknown name 'smoth'; did you mean 'smooth'"):
        choose(CREEP_LAWS, "--creep-law", "smoth")


def descriptions():
    modules = (
        scenario, sections, limits, vehicle, elements, friction_elements, tables, moments, air, track_support,
        driving, controls, adhesion,
    )  # fmt: skip
    for module in modules:
        for item in vars(module).values():
            if isinstance(item, type) and issubclass(item, Description) and item.__module__ == module.__name__:
                if not item.__name__.startswith("_"):
                    yield item


def documented_rows():
    """Stem and SI unit of each documented key with the cells beside it."""
    for line in DOCS.read_text().partition("### `[driver]`")[0].splitlines():
        if line.startswith("| `"):
            first, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            for key in re.findall(r"`(\w+)`", first):
                yield key, cells


def test_every_key_is_documented():
    text = DOCS.read_text()
    documented = {split(key)[:2] for key in re.findall(r"`(\w+)`", text)}
    for description in descriptions():
        for name, field in description.model_fields.items():
            alias = field.alias or name
            heading = f"[{alias}]" in text or f".{alias}]" in text
            assert split(alias)[:2] in documented or heading, f"{description.__name__}: {alias}"


def split(key):
    stem, unit = toml.split_unit(key)
    return stem, unit.si if unit else "", unit


def test_documented_defaults_of_scenarios():
    checked = 0
    for key, cells in documented_rows():
        stem, si, unit = split(key)
        for description in (scenario.Scenario, scenario.Run, scenario.Contact, scenario.Start):
            for name, field in description.model_fields.items():
                if split(field.alias or name)[:2] == (stem, si) and isinstance(field.default, float):
                    told = tomllib.loads(f"x = {cells[0].split(',')[0]}")["x"]
                    told = told * unit.times / unit.over if unit else told
                    assert told == pytest.approx(field.default, rel=tol.ROUNDING), key
                    checked += 1
    assert checked == 17


def test_documented_example_loads(load_text):
    (example,) = re.findall(r"```toml\n(\[run\].*?)```", DOCS.read_text(), re.DOTALL)
    assert load_text(example).distance == 200.0
