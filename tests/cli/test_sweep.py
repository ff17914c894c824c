"""railcli sweep: rows for all runs, whatever happens, and the same ones however they are made."""

import csv
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import pandas
import pytest
import scenes
from click.testing import CliRunner

from railcli.cli import main
from railcli.files import tables
from railcli.files.sweep import frame

STUDY = """
title = "Friction <and> speed"
scenario = "curve.toml"
limits = "limits.toml"
figures = ["assessment.Y_Q", "steady.W1_y_mm"]

[[vary]]
key = "run.speed_kmh"
values = [60, 72]

[[vary]]
key = "contact.friction"
values = [0.2, 0.3, 2.0]

[[channel]]
channel = "wheels/W1_*/Q"
statistics = ["max", "p99.85", "mean", "rms", "std"]
from_m = 20

"""
OUTPUTS = 'outputs = ["steady.*", "end.*", "assessment.*"]\n'
TIMES = ["cpu_s", "time_s"]


@pytest.fixture(scope="module")
def place(table, tmp_path_factory):
    """A folder with the short curve on its table, and the study."""
    folder = tmp_path_factory.mktemp("sweep")
    tables.save(table, folder / "table.h5")
    text = scenes.SHORT_CURVE.format(table="table.h5", friction=0.3, interval=10.0)
    (folder / "curve.toml").write_text(text)
    (folder / "limits.toml").write_text("run_in_s = 0.5\nrun_out_s = 0.3\nsection_length_m = 10\n")
    (folder / "study.toml").write_text(STUDY.replace("figures", OUTPUTS + "figures"))
    return folder


def invoke(*arguments):
    return CliRunner().invoke(main, ["sweep", *map(str, arguments), "-q", "--no-figures"])


def made(*arguments):
    result = invoke(*arguments)
    assert result.exit_code == 0, result.stderr
    return result.stdout


def rows(folder):
    """The table of a study without the times."""
    return pandas.read_parquet(folder / "rows.parquet").drop(columns=TIMES)


@pytest.fixture(scope="module")
def done(place):
    """The study made in this process."""
    made(place / "study.toml", "-o", place / "done", "--workers", 0)
    return place / "done"


def test_every_run_is_a_row_with_inputs_outputs_and_cause(done):
    table = rows(done)
    assert list(table["run"]) == [0, 1, 2, 3, 4, 5]
    assert list(table["run.speed_kmh"]) == [60, 60, 60, 72, 72, 72]
    assert list(table["contact.friction"]) == [0.2, 0.3, 2.0] * 2
    assert list(table["status"]) == ["done", "done", "failed"] * 2
    failed = table[table["status"] == "failed"]
    assert failed["cause"].str.contains("contact.friction: must be <= 1, got 2").all()
    assert failed.filter(regex="steady|end|assessment|wheels").isna().all(axis=None)
    assert table["steady.W1_y_mm"][:2].notna().all()


def test_a_row_holds_what_the_commands_say_of_such_a_run(place, done):
    """Bit by bit, by `run` and `assess` and `steady` of the scenario with those values."""
    import railcli

    case = railcli.load(place / "curve.toml").replace({"run.speed_kmh": 72.0, "contact.friction": 0.2})
    row = pandas.read_parquet(done / "rows.parquet").iloc[3]
    assert list(row["steady.W1_y_mm":"steady.W1_yaw_mrad"]) == [
        railcli.steady(case)["lateral_mm"][0], railcli.steady(case)["yaw_mrad"][0]
    ]  # fmt: skip
    results = railcli.run(case, place / "single")
    mean = results.summary["steady"]["mean"]
    assert row["end.W2_y_mm"] == mean["lateral_mm"][1] and row["end.W1_Q_outer_kN"] == mean["Q_kN"][0][0]
    figures = railcli.assess(results, place / "limits.toml")["figures"]
    compared = 0
    for key, figure in figures.items():
        (name,) = {f"assessment.{key}{unit}" for unit in ("", "_kN", "_N", "_m_per_s2")} & set(row.index)
        if figure["value"] is None:
            assert pandas.isna(row[name])
        else:
            assert row[name] == figure["value"]
            compared += 1
    assert compared > 5
    q, s = results.read("wheels/W1_left/Q"), results.read("bodies/car body/position")[:, 0]
    assert row["wheels/W1_left/Q.max [N]"] == q[s >= 20.0].max()


def test_any_number_of_workers_gives_the_same_rows(place, done):
    made(place / "study.toml", "-o", place / "two", "--workers", 2)
    pandas.testing.assert_frame_equal(rows(place / "two"), rows(done), check_exact=True)


def test_csv_holds_the_numbers_of_parquet(done):
    with open(done / "rows.csv", encoding="utf-8", newline="") as file:
        found = list(csv.DictReader(file))
    table = rows(done)
    for name in table:
        for text, value in zip((row[name] for row in found), table[name], strict=True):
            if isinstance(value, float):
                assert float(text or "nan") == value or pandas.isna(value) and text == ""
            else:
                assert text == str(value)


def test_a_study_goes_on_where_it_was(place, done):
    """Rows that were cut off and rows that are missing are made again, no others."""
    folder = place / "begun"
    shutil.copytree(done, folder)
    lines = (done / "rows.jsonl").read_bytes().splitlines(keepends=True)
    marked = lines[0].replace(b'"cpu_s": ', b'"cpu_s": 77')
    (folder / "rows.jsonl").write_bytes(marked + lines[2] + lines[4][:40])
    result = CliRunner().invoke(main, ["sweep", str(place / "study.toml"), "-o", str(folder), "--workers", "0"])
    assert result.exit_code == 0 and "2 of 6 runs are there; going on with 4." in result.stderr
    pandas.testing.assert_frame_equal(rows(folder), rows(done), check_exact=True)
    assert pandas.read_csv(folder / "rows.csv")["cpu_s"][0] > 70
    before = (folder / "rows.jsonl").read_bytes()
    made(place / "study.toml", "-o", folder)
    assert (folder / "rows.jsonl").read_bytes() == before


def test_another_study_does_not_go_on_there(place, done):
    for more, words in [(["--vary", "contact.friction=0.25"], "study, points differ"), (["--seeds", "3"], "a seed")]:
        result = invoke(place / "study.toml", "-o", done, *more)
        assert result.exit_code == 2 and words in result.stderr and len(result.stderr.splitlines()) == 1
    (place / "other.toml").write_text((place / "curve.toml").read_text().replace("radius_m = 600", "radius_m = 601"))
    text = (place / "study.toml").read_text().replace("curve.toml", "other.toml")
    (place / "study-of-other.toml").write_text(text)
    result = invoke(place / "study-of-other.toml", "-o", done)
    assert result.exit_code == 2 and "holds another study (scenario differ" in result.stderr


def begun(place, folder, least):
    """A process that makes the study, with at least some rows in its folder."""
    code = "from railcli.cli import main; import sys; main(sys.argv[1:], prog_name='railcli')"
    words = ["sweep", str(place / "long.toml"), "-o", str(folder), "--workers", "1", "-q", "--no-figures"]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    journal = folder / "rows.jsonl"
    until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= least, process)
    return process


def until(happens, process=None):
    """Wait for something, which must come before a process ends."""
    for _ in range(10_000):
        if happens():
            return
        assert process is None or process.poll() is None, process.communicate()
        time.sleep(0.01)
    raise AssertionError("it does not come")


def children(pid):
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True)
    return [int(text) for text in found.stdout.split()]


@pytest.fixture(scope="module")
def long(place):
    """A study of more runs, and its rows."""
    text = STUDY.replace("values = [60, 72]", "from = 60\nto = 72\ncount = 8")
    (place / "long.toml").write_text(text)
    made(place / "long.toml", "-o", place / "long", "--workers", 0)
    return rows(place / "long")


def test_ctrl_c_leaves_what_is_made(place, long, monkeypatch):
    from railcli.studies.sweep.one_run import Runner

    folder, row = place / "stopped", Runner.row

    def interrupted(runner, number, *rest):
        if number == 5:
            raise KeyboardInterrupt
        return row(runner, number, *rest)

    monkeypatch.setattr(Runner, "row", interrupted)
    result = invoke(place / "long.toml", "-o", folder, "--workers", 0)
    assert result.exit_code == 130
    assert f"Interrupted. 5 of 24 runs are kept in {folder / 'rows.jsonl'}; the same command with" in result.stderr
    assert f"-o {folder} goes on." in result.stderr
    monkeypatch.undo()
    made(place / "long.toml", "-o", folder, "--workers", 0)
    pandas.testing.assert_frame_equal(rows(folder), long, check_exact=True)


def test_a_worker_is_killed_and_the_study_is_terminated(place, long):
    """The worker's place is taken; none is left alone; the study goes on. Meanwhile no one else may write there."""
    folder = place / "terminated"
    process = begun(place, folder, 1)
    result = invoke(place / "long.toml", "-o", folder)
    assert result.exit_code == 2 and "another process works on this study" in result.stderr
    (child,) = children(process.pid)
    os.kill(child, signal.SIGKILL)
    until(lambda: (folder / "rows.jsonl").read_bytes().count(b"\n") >= 3, process)
    (other,) = children(process.pid)
    assert other != child
    process.terminate()
    said = process.communicate()[1]
    kept = (folder / "rows.jsonl").read_bytes().count(b"\n")
    assert process.returncode == 130 and 3 <= kept < 24 and f"{kept} of 24 runs are kept in" in said
    assert subprocess.run(["ps", "-p", str(other)], capture_output=True).returncode != 0
    made(place / "long.toml", "-o", folder, "--workers", 0)
    pandas.testing.assert_frame_equal(rows(folder), long, check_exact=True)


def test_a_study_that_is_killed_goes_on(place, long):
    folder = place / "killed"
    process = begun(place, folder, 1)
    (child,) = children(process.pid)
    process.kill()
    process.communicate()
    made(place / "long.toml", "-o", folder, "--workers", 0)
    pandas.testing.assert_frame_equal(rows(folder), long, check_exact=True)
    until(lambda: subprocess.run(["ps", "-p", str(child)], capture_output=True).returncode != 0)


def test_a_disk_that_fills_loses_nothing(place, long):
    """The journal may not grow beyond some kB."""
    folder = place / "full"
    (place / "wide.toml").write_text((place / "long.toml").read_text().replace("W1_*/Q", "*/[QY]"))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (58_000, before[1]))
    try:
        result = invoke(place / "wide.toml", "-o", folder, "--workers", 0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    (line,) = result.stderr.splitlines()
    assert result.exit_code == 2 and "rows.jsonl: cannot be written" in line and "runs before are kept" in line
    kept = (folder / "rows.jsonl").read_bytes()
    assert kept.endswith(b"\n") and 1 < kept.count(b"\n") < 24
    made(place / "wide.toml", "-o", folder, "--workers", 0)
    assert (folder / "rows.jsonl").read_bytes().startswith(kept) and len(rows(folder)) == 24


class Frail:
    """Processes whose workers end at a run, the first one or all of them."""

    SCRIPT = """
import json, os, sys
for line in sys.stdin:
    number, inputs, changes = json.loads(line)
    if number == 3 and (sys.argv[1] == "all" or not os.path.exists(sys.argv[2])):
        open(sys.argv[2], "w").close()
        os.kill(os.getpid(), 9)
    print(json.dumps({"row": {"run": number}}), flush=True)
"""


@pytest.mark.parametrize("which", ["first", "all"])
def test_a_process_that_ends_loses_no_run(tmp_path, monkeypatch, which):
    from railcli.studies.sweep import processes
    from railcli.studies.voice import SILENT

    popen = subprocess.Popen
    monkeypatch.setattr(
        processes.subprocess, "Popen",
        lambda words, **options: popen([words[0], "-c", Frail.SCRIPT, which, str(tmp_path / "once")], **options),
    )  # fmt: skip
    tasks = [(number, {"x": number}, {}) for number in range(8)]
    with processes.Processes(tmp_path, 2, SILENT) as hands:
        found = {row["run"]: row for row in hands.rows(iter(tasks))}
    assert sorted(found) == list(range(8))
    if which == "all":
        assert found[3]["status"] == "failed" and "2 processes ended at this run (signal 9)" in found[3]["cause"]
    else:
        assert found[3] == {"run": 3}


def test_options_make_the_same_study_as_a_file(place, done):
    made(
        place / "curve.toml", "-o", place / "options", "--workers", 0, "--vary", "run.speed_kmh=60,72",
        "--vary", "contact.friction=0.2:0.3:2", "--quasi-static",
    )  # fmt: skip
    found = rows(place / "options")
    same = rows(done)[lambda table: table["status"] == "done"].reset_index(drop=True)
    for name in ("run.speed_kmh", "contact.friction", "steady.W1_y_mm", "steady.Y_Q_largest"):
        assert list(found[name]) == list(same[name])
    assert not [name for name in found if name.startswith(("end.", "assessment.", "wheels/"))]


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["curve.toml"], "names no key to vary; give a table [[vary]] with key and values, or --vary KEY=VALUES"),
        (["no-such-study"], "no study, scenario or .toml file of this name"),
        (["curve.toml", "--vary", "contact.frictoin=0.1,0.2"], "contact.frictoin: unknown key; did you mean"),
        (["curve.toml", "--vary", "contact.friction=2,3"], "contact.friction: must be <= 1, got 2"),
        (["curve.toml", "--vary", "contact.friction"], "give KEY=VALUES"),
        (["curve.toml", "--vary", "contact.friction=normal(0.3,0.1)"], "needs its bounds too: normal(mean, sd, min"),
        (["curve.toml", "--vary", "contact.friction=gauss(0.3,0.1)"], "no such distribution"),
        (["curve.toml", "--vary", "contact.friction=uniform(0.1,0.3)"], "give [sample] with count, or --sample COUNT"),
        (["curve.toml", "--vary", "contact.friction=uniform(0.1,0.3)", "--sample", "9", "--method", "sobol"],
         "give 8 or 16, got 9"),
        (["curve.toml", "--vary", "contact.friction=0.1:0.3:3.5"], "whole number of values"),
        (["curve.toml", "--vary", "contact.friction=0.1,0.2", "--outputs", "stedy.*"], "begins with no group"),
        (["curve.toml", "--vary", "contact.friction=0.1,0.2", "--outputs", "steady.W9_y_mm"], "did you mean"),
        (["curve.toml", "--vary", "contact.friction=0.1,0.2", "--seeds", "3"], "has no [[irregularity]] with a seed"),
        (["curve.toml", "--vary", "contact.friction=0.1:0.3:10000000", "--quasi-static"], "asks for 10,000,000 runs"),
        (["curve.toml", "--vary", "vehicle=manchester,no.toml"], "no.toml"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(place, monkeypatch, arguments, words):
    monkeypatch.chdir(place)
    result = invoke(*arguments, "-o", "never")
    assert result.exit_code == 2 and words in result.stderr, result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (place / "never").exists()


def test_ten_million_runs_say_how_long(place, monkeypatch):
    monkeypatch.chdir(place)
    words = ["curve.toml", "--vary", "contact.friction=0.1:0.3:10000000", "--quasi-static", "--workers", "4"]
    line = invoke(*words).stderr
    assert " s each, as the first one took, " in line and "with 4 processes; add --yes if that is meant" in line


def test_a_vehicle_or_profile_is_varied_by_file(place, monkeypatch):
    """Their files are read once, at the beginning, beside the study."""
    monkeypatch.chdir(place)
    subprocess_free = CliRunner().invoke(main, ["vehicle", "copy", "manchester", str(place / "mine.toml")])
    assert subprocess_free.exit_code == 0, subprocess_free.stderr
    made("curve.toml", "-o", "vehicles", "--vary", "vehicle=manchester,mine.toml", "--quasi-static", "--workers", 0)
    table = rows(place / "vehicles")
    assert list(table["vehicle"]) == ["manchester", "mine.toml"]
    assert table["steady.W1_y_mm"][0] == table["steady.W1_y_mm"][1]


def test_rows_make_one_table_whatever_they_hold():
    """Columns of runs that differ are joined; lists and tables among inputs are JSON."""
    common = {"status": "done", "verdict": "", "cause": "", "cpu_s": 1.0, "time_s": 1.0}
    found = frame({
        1: {"run": 1, "inputs": {"k": [1, 2]}, "outputs": {"a": 1.5, "b": None}, **common},
        0: {"run": 0, "inputs": {"k": "x"}, "outputs": {"a": 0.1}, **common},
    })  # fmt: skip
    assert list(found["run"]) == [0, 1] and list(found["k"]) == ["x", "[1, 2]"]
    assert found["a"].tolist() == [0.1, 1.5] and found["b"].isna().all()


def test_json_is_what_the_text_says(place, done):
    record = json.loads(made(place / "study.toml", "-o", done, "--format", "json"))
    assert record["runs"] == 6 and record["done"] == 4 and record["failed"] == 2
    outputs = record["outputs"]["steady.W1_y_mm"]
    assert outputs["least"] == rows(done)["steady.W1_y_mm"].min()
    assert list(record["causes"].values()) == [2]
