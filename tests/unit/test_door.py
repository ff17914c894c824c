"""What `import railcli` gives: the same numbers, units and errors as files and commands."""

import json
import math
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import scenes
from click.testing import CliRunner
from numpy.testing import assert_allclose

import railcli
from railcli.cli import main
from railcli.files import tables

EXAMPLE = next((Path(__file__).parents[2] / "examples/recording").glob("*.toml"))
HEAVY = {"numpy", "numba", "scipy", "pandas", "matplotlib", "pydantic", "h5py", "rich", "click", "typing"}


@pytest.fixture(scope="module")
def scenario(recorded):
    """The short curve of the fixture `recorded`, as its file says it."""
    return railcli.load(recorded().parent / "curve-0.3-10.toml")


@pytest.fixture(scope="module")
def results(scenario):
    return railcli.run(scenario)


def command(*arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def plain(record, *without):
    """A record as JSON has it, without provenance, which holds the time of day."""
    from railcli.files.output import json_text

    values = json.loads(json_text(dict(record)))
    return {key: value for key, value in values.items() if key not in ("provenance", "folder", *without)}


def test_import_is_light_and_names_what_there_is(run_python):
    code = f"""
import sys
before = set(sys.modules)
import railcli
print(sorted({HEAVY!r} & (set(sys.modules) - before)), set(railcli.__all__) <= set(dir(railcli)))
print(all(getattr(railcli, name) is not None for name in railcli.__all__))
"""
    result = run_python(code)
    assert result.stdout.splitlines() == ["[] True", "True"], result.stderr


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="sweeep"):
        railcli.sweeep  # noqa: B018


@pytest.mark.parametrize(
    "changes, key, field, si",
    [
        ({"speed_kmh": 90}, "speed_m_per_s", lambda model: model.run.speed, 25.0),
        ({"run.speed_m_per_s": 25}, "speed_kmh", lambda model: 3.6 * model.run.speed, 90.0),
        ({"friction": 0.2}, "contact.friction", lambda model: model.contact.friction, 0.2),
        ({"contact.gauge_mm": 1440}, "gauge_m", lambda model: model.contact.gauge, 1.440),
        ({"track[3].radius_km": 0.5}, "track[3].radius_m", lambda model: model.track.sections[2].radius, 500.0),
        (
            {"vehicle.body[car body].mass_t": 30}, "vehicle.body[1].mass_kg",
            lambda model: model.vehicle.bodies[0].mass, 30_000.0,
        ),
    ],
)  # fmt: skip
def test_values_are_given_and_read_in_the_units_of_their_keys(scenario, changes, key, field, si):
    before = scenario.digest()
    other = scenario.replace(changes)
    assert field(other.model) == pytest.approx(si, rel=1e-15) and other[key] == pytest.approx(si, rel=1e-15)
    assert scenario.digest() == before != other.digest()
    (name,) = changes
    assert other.replace({name: scenario[name]}).model.track == scenario.model.track


def test_a_copy_is_what_a_file_with_these_values_is(scenario, recorded):
    other = railcli.load(recorded(0.2, 5.0).parent / "curve-0.2-5.toml")
    copy = scenario.replace(friction=0.2, output_interval_ms=5)
    assert copy == other != scenario and hash(copy) == hash(other)
    assert copy.title.endswith("[friction 0.2, not 0.3; output_interval 5 ms, not 10 ms]")


def test_a_scenario_comes_from_a_dictionary_too():
    table = {"run": {"speed_kmh": 72}, "track": [{"kind": "straight", "length_m": 200}], "vehicle": "y25-empty"}
    found = railcli.load(table)
    assert found["speed_m_per_s"] == 20.0 and found.vehicle == railcli.load_vehicle("y25-empty")
    assert table == {"run": {"speed_kmh": 72}, "track": [{"kind": "straight", "length_m": 200}], "vehicle": "y25-empty"}


def test_what_a_scenario_has_read_stays_with_its_copies(tmp_path, monkeypatch):
    """Recordings and profiles beside its file, which nobody could find from the working directory."""
    monkeypatch.chdir(tmp_path)
    case = railcli.load(EXAMPLE)
    other = case.replace(friction=0.123)
    assert other != case == other.replace(friction=case["friction"])
    assert other.replace(name="x") == other


def test_what_excludes_another_value_takes_its_place(scenario):
    timed = scenario.replace(duration_s=2.0, average_over_m=5)
    assert timed.replace(distance_m=30.0).model.run.duration is None
    course = timed.replace({"run.speed_course": {"time_s": [0, 2], "speed_kmh": [36, 72]}})
    assert course.model.run.speed == 20.0 and course.model.distance == pytest.approx(30.0)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"frictoin": 0.2}, ["frictoin: unknown key", "'friction'"]),
        ({"contact.frictoin": 0.2}, ["contact.frictoin: unknown key", "'friction'"]),
        ({"speed_km": 1}, ["speed_km: unknown key", "'speed_kmh'"]),
        ({"friction": 2}, ["contact.friction: must be <= 1, got 2"]),
        ({"speed_kmh": -3}, ["run.speed_kmh: must be > 0 km/h, got -3"]),
        ({"speed_m_per_s": "fast"}, ["run.speed_m_per_s: must be a number, got 'fast'"]),
        ({"track[9].length_m": 1}, ["no entry [9]"]),
        ({"vehicle.body[car bdy].mass_t": 1}, ["no entry [car bdy]", "'car body'"]),
        ({"vehicle": "y25-ladn"}, ["did you mean 'y25-laden'"]),
        ({"run.speed_m_per_s.x": 1}, ["run.speed_m_per_s.x: ", "no table"]),
        ({"run..speed": 1}, ["'run..speed': no key"]),
        ({"irregularity[1].chord_m": 10}, ["irregularity[1].chord_m: goes with the file", "all of irregularity[1]"]),
        ({"duration_s": 1.0, "distance_m": 10.0}, ["either distance_m or duration_s"]),
    ],
)
def test_wrong_changes_are_one_line(scenario, changes, words):
    with pytest.raises(railcli.InputError) as caught:
        scenario.replace(changes)
    (line,) = str(caught.value).splitlines()
    assert line.startswith("curve-0.3-10: ") and all(word in line for word in words), line


def test_a_run_is_the_command_s_bit_by_bit(results, recorded):
    with railcli_results(recorded()) as theirs, railcli_results(results.folder) as ours:
        assert ours.channels == theirs.channels
        for name in ours.channels:
            assert ours.read(name).tobytes() == theirs.read(name).tobytes(), name
    theirs = json.loads((recorded() / "summary.json").read_text())
    times = "cpu_s", "real_time_factor", "files", "folder"
    assert plain(results.summary, *times) == plain(theirs, *times)
    assert results.frame("wheels/*/Q").equals(railcli.open_results(recorded(), "wheels/*/Q"))
    assert results.scenario.digest() == railcli.Results(recorded()).scenario.digest()


def railcli_results(folder):
    from railcli.files.read_results import Results

    return Results(folder)


def test_a_temporary_folder_lives_as_long_as_its_results(scenario):
    told = []
    found = railcli.run(scenario.replace(duration_s=0.5, average_over_m=5), progress=lambda *what: told.append(what))
    assert found.folder.is_dir() and {title for title, *_ in told} >= {"Run"}
    assert all(0.0 <= share <= 1.0 for _, share, _ in told) and told[-1][1] == 1.0
    folder = found.folder
    del found
    assert not folder.exists()


def test_a_given_folder_stays_and_is_spared(scenario, tmp_path):
    short = scenario.replace(duration_s=0.5, average_over_m=5)
    railcli.run(short, tmp_path / "out")
    with pytest.raises(railcli.InputError, match="exists"):
        railcli.run(short, tmp_path / "out")
    assert railcli.run(short, tmp_path / "out", overwrite=True).summary["finished"]


def test_a_run_that_breaks_off_keeps_what_was_computed(scenario):
    fast = scenario.replace({"speed_m_per_s": 60, "track[3].radius_m": 120, "friction": 0.6})
    with pytest.raises(railcli.SimulationError, match="wheel W") as caught:
        railcli.run(fast)
    kept = caught.value.results
    assert kept.fault and kept.summary["rows"] == kept.read("time").size > 0
    with pytest.raises(railcli.SimulationError, match="wheel W"):
        railcli.Simulation(fast).advance(5.0)


def test_steady_is_newton_s_motion_at_the_end_of_the_run(scenario, results):
    found, newton = railcli.steady(scenario), results.summary["steady"]["newton"]
    for key in ("lateral_mm", "yaw_mrad", "Y_kN", "Q_kN"):
        assert plain(found)[key] == newton[key]
    assert "towards the outer rail" in str(found)
    with pytest.raises(railcli.InputError, match="average_over_m"):
        railcli.steady(scenario.replace(average_over_m=60.0))


def test_an_assessment_is_the_command_s(results, recorded, tmp_path):
    theirs = command("assess", recorded(), "-o", tmp_path / "out", "--no-figures", "--format", "json")["results"][0]
    assert plain(railcli.assess(results), "results") == plain(theirs, "results")
    tight = railcli.assess(results, {"sum_Y_factor": 1e-3})
    assert tight["limits"]["sum_Y_factor"] == 1e-3 and tight["conditions"] == plain(theirs)["conditions"]
    with pytest.raises(railcli.InputError, match="limits: sum_Y_facto: unknown key; did you mean 'sum_Y_factor'"):
        railcli.assess(results, {"sum_Y_facto": 0.01})


def test_conicity_and_modes_are_the_commands_own(tmp_path):
    case = railcli.load("straight-60")
    theirs = command("conicity", "--amplitude", "2,3", "--format", "json")
    assert plain(railcli.conicity(case, amplitudes_mm=(2, 3))) == plain(theirs)
    theirs = command("modes", "straight-60", "--no-figures", "-o", tmp_path / "modes", "--format", "json", "-q")
    assert plain(railcli.modes(case), "files") == plain(theirs, "files")


def test_validate_names_what_there_is():
    with pytest.raises(railcli.InputError, match="did you mean 'manchester'"):
        railcli.validate("manchster")


@pytest.fixture(scope="module")
def start(scenario):
    return railcli.Simulation(scenario)


def test_a_simulation_advanced_in_pieces_is_a_run(start, results):
    """Coordinates, forces, means and extremes of every row."""
    simulation = start.copy()
    interval = results.summary["time_s"] / results.summary["rows"]
    found = {name: [] for name in simulation.channels}
    for _ in range(results.summary["rows"]):
        simulation.advance(interval)
        for name, values in found.items():
            values.append(simulation.read(name))
    assert set(found) == set(results.channels) and simulation.channels == results.channels
    with railcli_results(results.folder) as rows:
        for name, values in found.items():
            assert np.array(values).tobytes() == rows.read(name).tobytes(), name
    assert (simulation.time, simulation.distance) == (results.summary["time_s"], results.summary["distance_m"])


def test_a_state_put_back_continues_bit_by_bit(start, scenario, tmp_path):
    simulation = start.copy()
    simulation.advance(0.2)
    kept = simulation.state()
    simulation.save(tmp_path / "state.h5")
    other = simulation.copy()
    simulation.advance(0.3)
    end = simulation.state()
    assert end != kept and kept.time == pytest.approx(0.2)
    simulation.restore(kept)
    assert simulation.state() == kept
    for one in (simulation, other, railcli.Simulation(scenario)):
        if one.time == 0.0:
            one.restore_from(tmp_path / "state.h5")
        one.advance(0.3)
        assert one.state() == end
    assert start.time == 0.0


def test_a_broken_off_simulation_goes_on_from_an_earlier_state(scenario):
    simulation = railcli.Simulation(scenario.replace({"speed_m_per_s": 60, "track[3].radius_m": 120}))
    before = simulation.state()
    for _ in range(2):
        with pytest.raises(railcli.SimulationError, match="wheel W|numerically"):
            simulation.advance(5.0)
    simulation.restore(before)
    simulation.advance(0.1)
    assert simulation.time == pytest.approx(0.1)


def test_a_simulation_says_what_it_cannot_do(start, scenario, tmp_path):
    simulation = start.copy()
    assert simulation.read("time") == 0.0 and simulation.read("bodies/car body/velocity")[0] == simulation.speed
    with pytest.raises(railcli.InputError, match="after the first advance"):
        simulation.read("wheels/W1_right/Q")
    with pytest.raises(railcli.InputError, match="did you mean 'wheels/W1_right/Q'"):
        simulation.read("wheels/W1_rigth/Q")
    for seconds in (0.0, -1.0, 1.5 * simulation.step, float("nan"), 1e9):
        with pytest.raises(railcli.InputError, match="whole number of steps"):
            simulation.advance(seconds)
    simulation.save(tmp_path / "state.h5")
    with pytest.raises(railcli.InputError, match="another scenario"):
        railcli.Simulation(scenario.replace(friction=0.2)).restore_from(tmp_path / "state.h5")
    (tmp_path / "state.h5").write_bytes((tmp_path / "state.h5").read_bytes()[:-1])
    with pytest.raises(railcli.InputError, match="truncated"):
        simulation.restore_from(tmp_path / "state.h5")


class _Balanced(HTMLParser):
    """Checks that tags close in the order in which they open; counts them."""

    def __init__(self):
        super().__init__()
        self.open, self.count = [], {}

    def handle_starttag(self, tag, attrs):
        self.count[tag] = self.count.get(tag, 0) + 1
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_objects_show_themselves_in_a_notebook(scenario, results):
    for thing, words in (
        (scenario, ["A short &lt;curve&gt; &amp; its end", "creep table"]),
        (scenario.vehicle, ["car body", "centre of gravity", "W4"]),
        (results, ["A short &lt;curve&gt; &amp; its end", "W4", "lateral_mm"]),
    ):
        text = thing._repr_html_()
        page = _Balanced()
        page.feed(text)
        assert not page.open and page.count["img"] == 1 and page.count["table"] >= 1
        assert all(word in text for word in words)


def test_axle_loads_shown_add_up_to_the_weight():
    from railcli.model.vehicle import static_wheel_loads
    from railcli.report.vehicle_facts import axle_rows, centre_of_gravity

    vehicle = railcli.load_vehicle("locomotive").model
    loads = static_wheel_loads(vehicle, 9.81, 0.75)
    shown = sum(float(cell) for row in axle_rows(vehicle, loads)[1:] for cell in row[2:4])
    mass = sum(body.mass for body in vehicle.bodies)
    assert shown == pytest.approx(9.81 * mass * 1e-3, abs=0.005 * 2 * len(loads))
    places = np.array([vehicle.bodies[i].x for i in vehicle.wheelsets])
    assert_allclose(centre_of_gravity(vehicle)[0], loads.sum(axis=1) @ places / loads.sum(), atol=1e-9)


def test_a_scenario_that_a_user_has_can_be_replaced_by_a_table(table, tmp_path, monkeypatch):
    """Files beside the working directory, as everywhere in Python."""
    tables.save(table, tmp_path / "own.h5")
    monkeypatch.chdir(tmp_path)
    case = railcli.load("curve-300").replace({"contact.table": "own.h5", "contact.normal": "hertz"})
    assert case.model.contents["own.h5"] == tables.identity(tmp_path / "own.h5")
    assert [one.key for one in railcli.build_table(case)] == [table.key]
    assert scenes.SMALL == table.settings


def test_a_simulation_is_commanded_by_hand_within_its_ranges(table, tmp_path):
    tables.save(table, tmp_path / "table.h5")
    brake = {"kind": "torque", "torque_Nm": 5000.0, "apply_s": 0.0, "valves": {}}
    contact = {"normal": "hertz", "creep_law": "polach", "table": str(tmp_path / "table.h5")}
    simulation = railcli.Simulation(railcli.load({
        "run": {"speed_m_per_s": 5.0, "step_ms": 1.0, "duration_s": 10.0}, "contact": contact,
        "track": [{"kind": "straight", "length_m": 100.0}], "driver": {"kind": "coast"}, "brake": brake,
    }))  # fmt: skip
    simulation.command("train/brake_demand", 1.0)
    simulation.command("axles/W2/valve", 2)
    simulation.advance(1.0)
    assert simulation.read("axles/W1/brake_pressure") > 3e5
    assert simulation.read("axles/W2/brake_pressure") == 0.0
    for name, value in (("axles/W1/valve", 3), ("axles/W1/valve", 0.5), ("train/brake_demand", math.nan)):
        with pytest.raises(railcli.InputError, match=f"input '{name}': must be"):
            simulation.command(name, value)
    with pytest.raises(railcli.InputError, match="there is none; did you mean 'train/brake_demand'"):
        simulation.command("train/brake_demnd", 0.1)
    assert "train/traction_demand" not in simulation.inputs
