"""`railcli vehicle` and `railcli scenario copy`."""

import json

import pytest
from click.testing import CliRunner

from railcli.cli import main
from railcli.files.scenario import VEHICLES, load, load_vehicle
from railcli.model.vehicle import STANDARD_GRAVITY


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """The Manchester wagon as JSON, and its drawing."""
    picture = tmp_path_factory.mktemp("vehicle") / "wagon.svg"
    result = run("vehicle", "show", "manchester", "-o", picture, "--format", "json", "-q")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout), picture


def test_springs_carry_what_stands_on_them(shown):
    """Secondary springs the car body, primary ones the bogies too, wheels all of it."""
    record, _ = shown
    mass = {body["name"]: body["mass_kg"] for body in record["bodies"]}
    bogies = [name for name in mass if name.startswith("bogie")]
    above = {upper: 0.0 for upper in ("car body", *bogies)}
    for preload in record["preloads"]:
        above[preload["between"][1]] += preload["force_kN"]
    weight = STANDARD_GRAVITY * 1e-3
    assert above["car body"] == pytest.approx(weight * mass["car body"])
    sprung = mass["car body"] + sum(mass[name] for name in bogies)
    assert sum(above[name] for name in bogies) == pytest.approx(weight * sprung)
    assert sum(map(sum, record["wheel_loads_kN"])) == pytest.approx(weight * record["mass_kg"])
    assert record["axle_load_t"] == pytest.approx([record["mass_kg"] / 4e3] * 4)


def test_suspension_frequencies_are_those_of_modes(shown, tmp_path):
    record, _ = shown
    modes = run("modes", "straight-60", "--speed", 20, "-o", tmp_path / "out", "--no-figures", "-q", "--format", "json")
    known = {mode["frequency_hz"]: mode["damping_ratio"] for mode in json.loads(modes.stdout)["modes"]}
    assert record["modes"] and all(known[mode["frequency_hz"]] == mode["damping_ratio"] for mode in record["modes"])


def test_the_drawing_shows_every_axis(shown):
    text = shown[1].read_text()
    assert all(label in text for label in ("height [m]", "x, forward [m]", "y, to the right [m]"))


@pytest.mark.parametrize("name", VEHICLES)
def test_every_built_in_vehicle_is_shown_and_copied(name, tmp_path):
    result = run("vehicle", "show", name, "--no-modes", "-o", tmp_path / "v.png", "-q")
    assert result.exit_code == 0 and "centre of gravity" in result.stdout and (tmp_path / "v.png").stat().st_size > 0
    assert run("vehicle", "copy", name, tmp_path / "my.toml").exit_code == 0
    assert load_vehicle(tmp_path / "my.toml") == load_vehicle(name)


def test_a_copied_scenario_is_the_same(tmp_path):
    assert run("scenario", "copy", "curve-300", tmp_path / "my.toml").exit_code == 0
    assert load(tmp_path / "my.toml").digest() == load("curve-300").digest()


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["vehicle", "show", "manchestr"], ["did you mean 'manchester'"]),
        (["vehicle", "copy", "y25", "my.toml"], ["no built-in vehicle", "'y25-"]),
        (["scenario", "copy", "curve-30", "my.toml"], ["no built-in scenario", "'curve-300'"]),
        (["scenario", "copy", "curve-300", "my.txt"], [".toml"]),
        (["vehicle", "show", "manchester", "-o", "v.jpg"], [".png"]),
        (["vehicle", "copy", "manchester", "there.toml"], ["exists already", "--overwrite"]),
    ],
)
def test_what_cannot_be_done_is_one_line(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.toml").write_text("mine")
    result = run(*arguments)
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert all(word in line for word in words), line
    (left,) = tmp_path.iterdir()
    assert left.name == "there.toml" and left.read_text() == "mine"
