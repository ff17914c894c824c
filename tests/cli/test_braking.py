"""Scenarios with brakes and drives, guests, and `railcli validate braking`, as a user runs them."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from railcli.analysis.braking_check import LOAD, PATCH
from railcli.analysis.longitudinal import model_of, stop
from railcli.cli import main
from railcli.files import tables
from railcli.files.scenario import load
from railcli.kernels.layout import new_data
from railcli.kernels.longitudinal import coast
from railcli.runtime.guest import invited, load_guest

EXAMPLE = Path(__file__).parents[2] / "examples/guest/slide_protection.py"
BRAKE = """
[run]
speed_kmh = 60
step_ms = 1
output_interval_ms = 10

[[track]]
kind = "straight"
length_m = 600

[contact]
creep_law = "polach"
normal = "hertz"
table = "TABLE"

[driver]
kind = "demand"
time_s = [0, 1]
brake = [1, 1]

[brake]
kind = "torque"
torque_Nm = 5359
apply_s = 1.0

[brake.valves]

[adhesion]
[[adhesion.stretch]]
set = "dry"

[[adhesion.stretch]]
from_m = 40
set = "low"
blend_m = 5
"""
PROTECTED = BRAKE + "\n[slide_protection]\n"


@pytest.fixture(scope="module")
def table_file(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("brake") / "table.h5"
    tables.save(table, path)
    return path


@pytest.fixture
def written(tmp_path, table_file):
    def write(text, name="my-brake.toml"):
        path = tmp_path / name
        path.write_text(text.replace("TABLE", str(table_file)))
        return str(path)

    return write


def railcli(*arguments):
    return CliRunner().invoke(main, list(arguments))


def test_a_stop_is_told_drawn_and_recorded(written, tmp_path):
    folder = tmp_path / "out"
    result = railcli("run", "scenario", written(PROTECTED), "-o", str(folder))
    assert result.exit_code == 0, result.output
    assert re.search(r"Stopped from 16\.6667 m/s \(60 km/h\) after \d+\.\d m, \d+\.\d\d s", result.stdout)
    assert "dry, low from 40 m" in result.stdout and "not accounted for" in result.stdout
    summary = json.loads((folder / "summary.json").read_text())
    told = summary["subsystems"]
    assert told["stopped"] and abs(told["unbooked_share"]) < 1e-3
    assert len(told["axles"]) == 4 and sum(axle["vents"] for axle in told["axles"]) > 0
    assert {"braking.png", "energy.png"} <= set(summary["files"])
    with h5py.File(folder / "timeseries.h5") as file:
        assert file["axles/W1/valve"][:].max() == 2
        assert file["wheels/W1_right/friction"][0] == pytest.approx(0.55)
        assert file["energy/brake"][-1] > 0.0
        assert file["axles/W4/brake_pressure"].attrs["units"] == "Pa"
        assert 0.5 < file["time"][-1] - told["stop_time_s"] < 5.0
    page = railcli("report", str(folder), "-o", str(tmp_path / "page"), "-q")
    assert page.exit_code == 0, page.output
    assert (tmp_path / "page/braking-1.png").exists() and "no assessment: " in page.output


def test_a_guest_controls_the_valves(written, tmp_path):
    folder = tmp_path / "out"
    result = railcli("run", "scenario", written(BRAKE), "--guest", str(EXAMPLE), "-o", str(folder), "--no-figures")
    assert result.exit_code == 0, result.output
    summary = json.loads((folder / "summary.json").read_text())
    assert sum(axle["vents"] for axle in summary["subsystems"]["axles"]) > 0
    assert len(summary["provenance"]["guest"]["sha256"]) == 16


@dataclass(frozen=True)
class Bare:
    """What of a system a guest needs."""

    model: object
    guest: object = None


def guest_stop(path):
    """Distance and locked time of the published case L160 with a guest at its valves, by the reduced model."""
    case = load("brake-low-true").model_copy(update={"slide_protection": None})
    model, start = model_of(case)
    system = invited(Bare(model), load_guest(path), 1e-3)
    data = new_data(system.model, start.q, 0)
    data.v[...], data.rate[...] = start.v, start.rate
    assert coast(system.model, data, PATCH.packed(), LOAD, 400_000) > 0
    return float(data.train[0]["stop_place"]), data.port["locked"].copy()


def test_the_guest_sinks_with_its_axles_as_published():
    """With a reference speed from the axles alone the published wagon stops in 3914 m, all axles locked for 128 s."""
    distance, locked = guest_stop(EXAMPLE)
    assert distance == pytest.approx(3914.0, rel=0.01)
    np.testing.assert_allclose(locked, 128.0, rtol=0.03)


def test_the_built_in_protection_does_not():
    found = stop(load("brake-low-protected"), PATCH, LOAD)
    best = stop(load("brake-low-true"), PATCH, LOAD)
    assert found.locked_speed < 1.4  # below which it is not active
    assert found.distance < 1.05 * best.distance


BAD = {
    "missing": (None, "cannot be read: No such file"),
    "no function": ("x = 1\n", r"must define a function control\(time, axles, state, out\)"),
    "other arguments": ("def control(a, b):\n    pass\n", "must define a function control"),
    "broken": ("def control(:\n", "cannot be run: SyntaxError"),
    "allocates": (
        "import numpy as np\ndef control(time, axles, state, out):\n    out[0, 0] = np.zeros(3)[0]\n",
        "cannot be compiled: No implementation of function",
    ),
    "does not compile": ("def control(time, axles, state, out):\n    out[0, 0] = 'fill'\n", "cannot be compiled"),
    "period": ("PERIOD_MS = 3.5\ndef control(time, axles, state, out):\n    out[0, 0] = 0.0\n", "acts every 3.5 ms"),
}
ASTRAY = {
    "beyond its arrays": "def control(time, axles, state, out):\n    out[7, 0] = 0.0\n",
    "axle 2 a command that is none": "def control(time, axles, state, out):\n    out[1, 0] = 3.0\n",
    "axle 1 a command that is none": "def control(time, axles, state, out):\n    out[0, 1] = axles[0, 0] / 0.0\n",
}


@pytest.mark.parametrize("text, message", BAD.values(), ids=BAD)
def test_a_bad_guest_is_one_line(written, tmp_path, text, message):
    path = str(tmp_path / "guest.py") if text is None else written(text, "guest.py")
    result = railcli("run", "scenario", written(BRAKE), "--guest", path, "-o", str(tmp_path / "out"))
    assert result.exit_code == 2
    assert re.search(message, result.stderr)
    assert len(result.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("message", ASTRAY)
def test_a_guest_that_goes_astray_ends_the_run(written, tmp_path, message):
    path = written(ASTRAY[message], "guest.py")
    result = railcli("run", "scenario", written(BRAKE), "--guest", path, "-o", str(tmp_path / "out"), "--quiet")
    assert result.exit_code == 3
    assert message in result.stderr


def test_a_guest_needs_something_to_control(tmp_path):
    result = railcli("run", "scenario", "curve-1200-45", "--guest", str(EXAMPLE), "-o", str(tmp_path / "out"))
    assert result.exit_code == 2
    assert "nothing to control: neither [brake.valves] nor [traction]" in result.stderr


def test_validate_braking(tmp_path):
    folder = tmp_path / "out"
    result = railcli("validate", "braking", "-o", str(folder), "--format", "json")
    assert result.exit_code == 0, result.output
    record = json.loads(result.stdout)
    assert record["verdict"] == "accepted"
    low = record["stops"]["brake-low"]
    assert low["reduced_m"] == pytest.approx(4000.5, rel=1e-3)
    names = {"validation.json", "validation.md", "validation.csv", "stops.png", "creep-force.png", "load-transfer.png"}
    assert names <= {path.name for path in folder.iterdir()}
