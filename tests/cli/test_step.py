"""The time step as a user meets it: chosen, told, refused; what it did wrong is no derailment."""

import json
import re

import pytest
import scenes
import tolerances as tol
from click.testing import CliRunner

from railcli.analysis.simulate import SteadyWindow, simulate
from railcli.analysis.step_choice import longest_usual, milliseconds, with_step
from railcli.cli import main
from railcli.errors import InputError
from railcli.files import tables
from railcli.files.resources import resource
from railcli.files.scenario import load
from railcli.model.system import assemble

STRAIGHT = """
vehicle = "{vehicle}"
[run]
speed_m_per_s = 20
distance_m = 40
{run}
[contact]
table = "{table}"
normal = "hertz"
creep_law = "table"
[[track]]
kind = "straight"
length_m = 100
"""


@pytest.fixture
def run(table, tmp_path):
    """Function that runs the wagon over 40 m of straight track: lines in [run], an edit of its vehicle, options."""
    tables.save(table, tmp_path / "table.h5")

    def run(lines="", edit=None, options=()):
        vehicle = "manchester"
        if edit:
            text = resource("benchmarks/manchester/vehicle.toml").read_text(encoding="utf-8")
            (tmp_path / "wagon.toml").write_text(edit(text), encoding="utf-8")
            vehicle = "./wagon.toml"
        scenario = STRAIGHT.format(vehicle=vehicle, run=lines, table=(tmp_path / "table.h5").as_posix())
        (tmp_path / "case.toml").write_text(scenario)
        arguments = ["run", "scenario", tmp_path / "case.toml", "-o", tmp_path / "out", "-q", "--no-figures", *options]
        return CliRunner().invoke(main, list(map(str, arguments)), prog_name="railcli")

    return run


def series_times(factor):
    """Edit of a vehicle file: every series stiffness times a factor."""
    return lambda text: re.sub(
        r"(series_stiffness_N_per_m = )([\d.e]+)", lambda found: f"{found[1]}{float(found[2]) * factor:g}", text
    )


def refused(result):
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert "derail" not in line
    return line


def test_chosen_step_is_told_and_kept(run, tmp_path):
    result = run(options=["--format", "json"])
    assert result.exit_code == 0, result.stderr
    step = json.loads(result.stdout)["step"]
    assert (step["step_ms"], step["chosen"], step["margin"]) == (1.0, True, 1.2)
    assert step["stable_up_to_ms"] == pytest.approx(1.2 * step["longest_ms"], rel=tol.STEP_PRINTED)
    assert step["limited_by"].startswith("W1 on its rails 6")
    assert json.loads((tmp_path / "out" / "scenario.json").read_text())["run"]["step_s"] == 1e-3


def test_report_names_the_step(run):
    text = run("step_ms = 0.5").stdout
    assert re.search(r"step +0\.5 ms, given; at most 1\.0\d ms \(stable up to 1\.2\d ms, over a margin of 1\.2\)", text)
    assert re.search(r"limited by +W1 on its rails 6\.\d mm to the right, on 3 patches right and 1 left", text)


@pytest.mark.parametrize(
    ("lines", "options"), [("step_ms = 1.7\noutput_interval_ms = 8.5", []), ("", ["--step", "2"])]
)
def test_step_that_is_too_long_is_refused(run, tmp_path, lines, options):
    """With 1.7 ms wheel forces swing on smooth track, with 2 ms wheels seem to derail."""
    line = refused(run(lines, options=options))
    assert re.search(
        r"run\.step_ms: (1\.7|2) ms is too long for this vehicle: at most 1\.0\d ms \(stable up to 1\.2\d ms, .*"
        r"limited by W1 on its rails 6\.\d mm to the right.*leave step_ms out for 1 ms$",
        line,
    )
    assert not (tmp_path / "out").exists()


def test_stiff_series_springs(run):
    """All of them times 3000: refused at 0.5 ms with the damper's name; at the chosen step the wheels carry 54.5 kN."""
    line = refused(run("step_ms = 0.5", edit=series_times(3000)))
    assert "limited by secondary vertical damper between bogie" in line and "leave step_ms out for 0.125 ms" in line
    result = run(edit=series_times(3000), options=["--format", "json"])
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert record["step"]["step_ms"] == 0.125
    forces = [q for wheelset in record["steady"]["mean"]["Q_kN"] for q in wheelset]
    assert forces == pytest.approx([54.55] * 8, abs=tol.BALANCE_KN)
    swings = [q for wheelset in record["steady"]["peak_to_peak"]["Q_kN"] for q in wheelset]
    assert max(swings) < tol.BALANCE_KN


@pytest.mark.parametrize(
    ("allowed", "interval", "step"),
    [
        (1.02, 10.0, 1.0),
        (0.99, 10.0, 0.5),
        (2.0, 10.0, 1.0),
        (1.0, 10.0, 1.0),
        (0.13, 10.0, 0.125),
        (0.12, 10.0, 0.0625),
        (1.02, 2.5, 0.5),  # 1 ms is no part of it, its half is
        (1.02, 0.3, 0.3),
        (1.02, 3.3, 0.825),
        (0.3, 3.3, 3.3 / 14),  # at most 0.25
    ],
)
def test_longest_usual_step(allowed, interval, step):
    """All in ms."""
    assert longest_usual(allowed * 1e-3, interval * 1e-3) == pytest.approx(step * 1e-3, rel=tol.ROUNDING)


def test_printed_limits_may_be_given_back():
    for limit in (1.0299e-3, 0.99999e-3, 1e-3, 0.24849e-3, 12.3e-6):
        assert 0.99 * limit < milliseconds(limit) * 1e-3 <= limit * (1.0 + tol.ROUNDING)


def test_step_follows_what_it_has_to_divide(table):
    case = load("straight-60").varied(run={"output_interval": 2.5e-3})
    scenario, system, choice = with_step(case, assemble(case, [table]))
    assert scenario.run.step == choice.step == system.model.param[0]["step"] == 0.5e-3
    scenario, *_ = with_step(case, assemble(case, [table]), interval=0.2e-3)
    assert scenario.run.step == scenario.run.output_interval == 0.2e-3


def test_digest_holds_the_step(table):
    """A chosen step counts as the same step given."""
    case = load("straight-60")
    chosen = with_step(case, assemble(case, [table])).scenario
    assert chosen.digest() == case.varied(run={"step": 1e-3}).digest() != case.varied(run={"step": 0.5e-3}).digest()


def test_what_a_finer_step_does_not_know_is_no_derailment(table):
    """Run in spite of the refusal: it ends as numerically unstable, with a step that works, which it does."""
    case = load("straight-60").varied(run={"speed": 20.0, "distance": 60.0, "average_over": 20.0, "step": 2e-3})
    system = assemble(case, [table])
    with pytest.raises(InputError):
        with_step(case, system)
    outcome = simulate(case, system, SteadyWindow(0.0))
    assert outcome.distance < 60.0 and "derailed" not in outcome.fault
    assert "numerically unstable, use step_ms <= 0.5;" in outcome.fault
    case = case.varied(run={"step": 0.5e-3})
    assert not simulate(case, assemble(case, [table]), SteadyWindow(0.0)).fault


def test_derailment_stays_one(table):
    case = scenes.load("curve-150").varied(run={"speed": 40.0})
    scenario, system, _ = with_step(case, assemble(case, [table]))
    outcome = simulate(scenario, system, SteadyWindow(0.0))
    assert "wheel W" in outcome.fault and "unstable" not in outcome.fault
