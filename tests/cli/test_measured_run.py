"""A run over measured tracks and profiles from files: its results folder alone tells everything, wherever it lies."""

import json
import shutil

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_array_equal

from railcli.cli import main
from railcli.files import tables
from railcli.files.profiles import BUNDLED
from railcli.files.read_results import Results
from railcli.files.resources import resource
from railcli.files.scenario import load
from railcli.model import rails
from railcli.report.curves import Curves

SCENARIO = """
[run]
speed_m_per_s = 30
[contact]
wheel_profile = "wheel.csv"
rail_profile = "rail.csv"
table = "table.h5"
normal = "hertz"
creep_law = "table"
[[track]]
kind = "measured"
file = "alignment.csv"
[[irregularity]]
kind = "measured"
file = "track.csv"
"""
LIMITS = "run_in_s = 0.5\nrun_out_s = 0.2\n"


def railcli(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def inputs(folder, table):
    """Everything that the run is made from, in a folder of its own."""
    folder.mkdir()
    tables.save(table, folder / "table.h5")
    for name, bundled in (("wheel", "ORES1002"), ("rail", "UIC60")):
        shutil.copy(resource(BUNDLED[bundled][1]), folder / f"{name}.csv")
    s = np.arange(0.0, 260.0, 0.5)
    lines = [f"{at:g},{0.5 * np.sin(at / 3):.6f},{0.3 * np.cos(at / 5):.6f}" for at in s]
    (folder / "track.csv").write_text("\n".join(["position_m,vertical_mm,alignment_mm", *lines]) + "\n")
    line = "position_m,curvature_1_per_km,cant_mm\n0,0,0\n60,0,0\n120,0.5,20\n240,0.5,20\n"
    (folder / "alignment.csv").write_text(line)
    (folder / "case.toml").write_text(SCENARIO)
    (folder / "limits.toml").write_text(LIMITS)
    return folder / "case.toml"


@pytest.fixture(scope="module")
def finished(table, tmp_path_factory):
    """Place of the inputs and of the results, and the scenario as it was read."""
    place = tmp_path_factory.mktemp("measured")
    case = inputs(place / "inputs", table)
    result = railcli("run", "scenario", case, "-o", place / "out", "-q", "--no-figures")
    assert result.exit_code == 0, result.stderr
    with Results(place / "out") as found:
        step = found.scenario.run.step  # chosen by the run
    return place, load(case).varied(run={"step": step})


def changed(folder):
    """Every input holds something else now."""
    for name in ("wheel", "rail", "track", "alignment"):
        lines = (folder / f"{name}.csv").read_text().splitlines()
        (folder / f"{name}.csv").write_text("\n".join([*lines[:-3], lines[-1]]) + "\n")
    (folder / "case.toml").write_text(SCENARIO.replace("= 30", "= 20"))
    (folder / "table.h5").write_bytes(b"another")


@pytest.mark.parametrize("happened", ["nothing", "moved", "inputs deleted", "inputs changed"])
def test_results_tell_everything(finished, tmp_path, happened):
    place, scenario = finished
    shutil.copytree(place, tmp_path / "all")
    source, results = tmp_path / "all" / "inputs", tmp_path / "all" / "out"
    limits = tmp_path / "limits.toml"
    shutil.copy(source / "limits.toml", limits)
    if happened != "nothing":
        results = shutil.move(results, tmp_path / "elsewhere")
    if happened == "inputs deleted":
        shutil.rmtree(source)
    if happened == "inputs changed":
        changed(source)
    with Results(results) as found:
        assert found.scenario == scenario and found.scenario.digest() == scenario.digest()
        assert found.provenance["scenario"]["digest"] == scenario.digest()
        s = np.linspace(0.0, 240.0, 500)
        assert_array_equal(rails.displacement(found.scenario, s), rails.displacement(scenario, s))
    options = ("-q", "--no-figures", "--limits", limits, "-o", tmp_path / "a", "--format", "json")
    result = railcli("assess", results, *options)
    assert result.exit_code == 0, result.stderr
    figures = json.loads(result.stdout)["results"][0]["figures"]
    assert figures["sum_Y"]["value"] > 0.0 and figures["Y_Q"]["status"] == "pass"
    result = railcli("diff", place / "out", results, "-q", "--format", "json")
    assert result.exit_code == 0 and json.loads(result.stdout)["settings"] == []
    assert railcli("export", results, "-q", "-o", tmp_path / "e.csv", "--channel", "time").exit_code == 0
    if happened == "inputs deleted":
        result = railcli("report", results, "-q", "-o", tmp_path / "r", "--animate", "--frames", 2, "--format", "json")
        assert result.exit_code == 0, result.stderr
        record = json.loads(result.stdout)
        assert record["notes"] == {} and "track.png" in record["files"] and record["assessment"][0]


def flip(folder):
    data = bytearray((folder / "inputs.h5").read_bytes())
    data[len(data) // 2] ^= 1
    (folder / "inputs.h5").write_bytes(data)


def of_another_run(folder):
    values = json.loads((folder / "scenario.json").read_text())
    values["irregularity"][0]["digest"] = "0123456789abcdef"
    (folder / "scenario.json").write_text(json.dumps(values))
    (folder / ".railcli").unlink()  # which has its checksum


@pytest.mark.parametrize(
    "spoil, words",
    [
        (lambda folder: (folder / "inputs.h5").unlink(), "inputs.h5: is missing"),
        (lambda folder: (folder / "inputs.h5").write_bytes(b""), "inputs.h5: is not a file of inputs"),
        (lambda folder: (folder / "inputs.h5").write_bytes((folder / "inputs.h5").read_bytes()[:-9]), "truncated"),
        (flip, "inputs.h5: is damaged"),
        (of_another_run, "belongs to another run"),
    ],
)
def test_damaged_inputs_are_one_line_and_the_rest_is_read(finished, tmp_path, spoil, words):
    place, _ = finished
    shutil.copytree(place / "out", tmp_path / "out")
    spoil(tmp_path / "out")
    result = railcli("assess", tmp_path / "out", "-q", "-o", tmp_path / "a")
    assert result.exit_code == 2 and not (tmp_path / "a").exists()
    (line,) = result.stderr.splitlines()
    assert words in line and str(tmp_path / "out") in line
    assert railcli("export", tmp_path / "out", "-q", "-o", tmp_path / "e.csv", "--channel", "time").exit_code == 0
    assert railcli("diff", place / "out", tmp_path / "out", "-q").exit_code == 0
    with Results(tmp_path / "out") as results:
        curves = Curves(results, "out")
        assert curves.scenario is None and words in curves.notes[0]
        assert np.isfinite(curves.single("wheels/W1_left/Q")).all()


def test_results_of_the_version_before_are_read(finished, tmp_path):
    """It kept no inputs: all but the displacement of the rails is there."""
    place, _ = finished
    shutil.copytree(place / "out", tmp_path / "out")
    (tmp_path / "out/inputs.h5").unlink()
    values = json.loads((tmp_path / "out/scenario.json").read_text())
    del values["contact"]["digests"], values["irregularity"][0]["digest"]
    values["irregularity"][0]["sha256"] = 64 * "0"  # of the text of the file
    (tmp_path / "out/scenario.json").write_text(json.dumps(values))
    (tmp_path / "out/.railcli").unlink()  # which has its checksum
    (tmp_path / "limits.toml").write_text(LIMITS)
    limits = tmp_path / "limits.toml"
    result = railcli("assess", tmp_path / "out", "-q", "--no-figures", "--limits", limits, "-o", tmp_path / "a")
    assert result.exit_code == 0 and " 0 pass" not in result.stdout
    with Results(tmp_path / "out") as results:
        curves = Curves(results, "out")
        assert curves.track is not None and curves.rails is None and "samples" in curves.notes[0]


def test_digest_covers_what_files_hold_and_not_their_names(table, tmp_path):
    case = inputs(tmp_path / "one", table)
    digest = load(case).digest()
    shutil.copytree(tmp_path / "one", tmp_path / "two")
    text = SCENARIO
    for name in ("wheel.csv", "rail.csv", "table.h5", "track.csv"):
        (tmp_path / "two" / name).rename(tmp_path / "two" / f"other-{name}")
        text = text.replace(name, f"other-{name}")
    (tmp_path / "two/case.toml").write_text(text)
    assert load(tmp_path / "two/case.toml").digest() == digest
    assert load(tmp_path / "two/case.toml").varied(run={"speed": 20.0}).digest() != digest
    for name in ("wheel.csv", "rail.csv", "track.csv"):
        content = (tmp_path / "one" / name).read_text()
        end = content.index("\n", len(content) // 2)
        last = "2" if content[end - 1] == "1" else "1"  # digit of one point in the middle
        (tmp_path / "one" / name).write_text(content[: end - 1] + last + content[end:])
        assert load(case).digest() != digest, name
        (tmp_path / "one" / name).write_text(content)
    assert load(case).digest() == digest
    other = type(table)(**{**vars(table), "method": "another"})
    tables.save(other, tmp_path / "one/table.h5")
    assert load(case).digest() != digest
