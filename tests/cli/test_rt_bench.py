"""`railcli rt-bench` as a user sees it. No test asserts a time."""

import csv
import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from railcli.cli import main
from railcli.files import tables
from railcli.runtime import timing

SCENARIO = """
[run]
speed_m_per_s = {speed}
[contact]
table = "{table}"
normal = "hertz"
creep_law = "table"
[[track]]
kind = "straight"
length_m = 10
[[track]]
kind = "transition"
length_m = 60
[[track]]
kind = "curve"
length_m = 60
radius_m = {radius}
hand = "right"
cant_mm = 90
"""
STAGES = ["track", "suspension", "contact", "creep", "integration"]


@pytest.fixture(scope="module")
def table_file(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("rt-bench") / "table.h5"
    tables.save(table, path)
    return path


@pytest.fixture
def bench(tmp_path, monkeypatch, table_file):
    """Function that runs `railcli rt-bench` on a short curve, in an empty folder but for its scenario file."""
    monkeypatch.chdir(tmp_path)

    def run(*options, scenario="short.toml", speed=45, radius=1200):
        text = SCENARIO.format(speed=speed, radius=radius, table=table_file.as_posix())
        (tmp_path / "short.toml").write_text(text, encoding="utf-8")
        return CliRunner().invoke(main, ["rt-bench", scenario, *options], prog_name="railcli")

    return run


def left(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.name != "short.toml")


def test_report_and_files(bench, tmp_path):
    result = bench("--duration", "3", "-o", "out")
    assert (result.exit_code, result.stderr) == (0, "")
    assert re.search(r"Verdict: \d+ of 3,000 calls over the budget of 1 ms\n", result.stdout)
    for word in ("p99.9", "load average", "numba", "smallest step seen", "whole step"):
        assert word in result.stdout
    assert "not asked for" in result.stdout
    assert "the stages do not add up" in result.stdout.lower()
    assert left(tmp_path / "out") == [".railcli", "histogram.csv", "histogram.png", "rt-bench.json", "stages.png"]
    assert all((tmp_path / "out" / name).read_bytes()[:4] == b"\x89PNG" for name in ("histogram.png", "stages.png"))


def test_json_is_what_the_file_holds_and_its_numbers_fit_together(bench, tmp_path):
    result = bench("--duration", "3", "--format", "json", "--no-figures")
    found = json.loads(result.stdout)
    folder = tmp_path / "railcli-out/rt-bench-short-1"
    assert found == json.loads((folder / "rt-bench.json").read_text(encoding="utf-8"))
    assert left(folder) == [".railcli", "histogram.csv", "rt-bench.json"]
    assert list(found["step_us"]) == ["p50", "p95", "p99", "p999", "max"]
    assert sorted(found["step_us"].values()) == list(found["step_us"].values())
    assert list(found["stages_us"]) == STAGES
    assert found["real_time_factor"] > 0.0
    assert found["over_budget_share"] == found["over_budget"] / found["calls"]
    assert (found["calls"], found["steps_per_call"], found["step_ms"], found["budget_ms"]) == (3000, 1, 1.0, 1.0)
    assert found["rewinds"] == 2 and found["lap_s"] < 1.5  # 60 m at 45 m/s less the vehicle's half
    assert sum(found["kept_state"]["patches"]) >= 8
    with open(folder / "histogram.csv", newline="", encoding="utf-8") as file:
        assert sum(int(row["call"]) for row in csv.DictReader(file)) == 3000


def test_step_and_budget_are_the_users(bench):
    found = json.loads(
        bench("--step", "0.25", "--budget", "0.75", "--duration", "0.9", "--warmup", "0", "--format", "json").stdout
    )
    assert (found["calls"], found["steps_per_call"], found["step_ms"]) == (1200, 3, 0.25)
    assert found["budget_ms"] == pytest.approx(0.75)
    assert found["warm_up_calls"] == 0


def test_paced_run_with_real_time_scheduling_says_what_was_granted(bench, tmp_path):
    result = bench("--paced", "--realtime", "--spin", "100", "--duration", "1", "--warmup", "0.1", "--format", "json")
    assert result.exit_code == 0
    assert "this takes 1.1 s" in result.stderr
    found = json.loads(result.stdout)
    paced = found["paced"]
    assert list(paced["wake_up_us"]) == list(paced["response_us"]) == list(found["step_us"])
    assert paced["late_share"] == paced["late"] / 1000
    assert paced["late"] >= found["over_budget"]
    assert found["real_time"]["asked"] is True
    for answer in (found["real_time"]["scheduling"], found["real_time"]["memory"]):
        assert answer.startswith(("granted", "not granted (", "not available on this system"))
    header = (tmp_path / "railcli-out/rt-bench-short-1/histogram.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header == "from_us,to_us,call,wake_up,wake_up_and_call"


def test_missed_budget_is_a_result_not_an_error(bench, monkeypatch):
    def slow(course, count, *_):
        compute = np.full(count, 900_000)
        compute[-7:] = 1_100_000
        return timing.Calls(np.zeros(count, int), compute, paced=False)

    monkeypatch.setattr(timing, "time_calls", slow)
    result = bench("--duration", "2")
    assert result.exit_code == 0
    assert "Verdict: 7 of 2,000 calls over the budget of 1 ms\n" in result.stdout
    assert re.search(r"call +900 +900 +900 +1,100 +1,100\n", result.stdout)


@pytest.mark.parametrize(
    "options, message",
    [
        (["--step", "0"], "--step: must be from 0.001 to 2 ms, got 0"),
        (["--step", "-0.5"], "--step: must be from 0.001 to 2 ms, got -0.5"),
        (["--step", "nan"], "--step: must be from 0.001 to 2 ms, got nan"),
        (["--step", "0.3"], "--budget: must be a multiple of the step, got 1 ms with a step of 0.3 ms"),
        (["--step", "2"], "--budget: must be a multiple of the step, got 1 ms with a step of 2 ms"),
        (["--budget", "0"], "--budget: must be above 0"),
        (["--budget", "inf"], "--budget: must be above 0"),
        (["--step", "0.5", "--budget", "1.25"], "--budget: must be a multiple of the step"),
        (["--budget", "2000", "--duration", "2000"], "--budget: is longer than the part of short that is timed"),
        (["--duration", "0.5"], "--duration: must be from 1 s (1,000 calls of 1 ms) to 10000 s"),
        (["--duration", "nan"], "--duration: must be from 1 s"),
        (["--duration", "1e9"], "--duration: must be from 1 s"),
        (["--warmup", "-1"], "--warmup: must be from 0 s"),
        (["--spin", "50"], "--spin: is for calls paced by the clock; add --paced"),
        (["--paced", "--spin", "2000"], "--spin: must be from 0 to the 1000 us of the budget, got 2000"),
    ],
)
def test_bad_option_is_one_line_and_writes_nothing(bench, tmp_path, options, message):
    result = bench(*options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"Error: {message}")
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "railcli-out").exists() or left(tmp_path / "railcli-out") == []


def test_unknown_scenario_gets_the_near_one(bench):
    result = bench(scenario="curve-1200-44")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "curve-1200-45" in result.stderr and result.stderr.count("\n") == 1


def test_folder_that_exists_is_left_alone(bench, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/mine.txt").write_text("mine")
    result = bench("-o", "out")
    assert result.exit_code == 2 and result.stderr.startswith("Error: out: exists already")
    assert left(tmp_path) == ["out", "out/mine.txt"]


def test_wheel_that_leaves_its_rail_ends_the_benchmark(bench, tmp_path):
    result = bench("--duration", "3", speed=60, radius=150)
    assert (result.exit_code, result.stdout) == (3, "")
    assert re.fullmatch(r"Error: short: t = .* s, s = .* m: wheel W\d (left|right) .*\n", result.stderr)
    assert left(tmp_path / "railcli-out") == []


def test_ctrl_c_leaves_nothing(bench, tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(timing, "time_calls", interrupt)
    result = bench("-o", "out")
    assert (result.exit_code, result.stdout, result.stderr) == (130, "", "Interrupted.\n")
    assert left(tmp_path) == []
