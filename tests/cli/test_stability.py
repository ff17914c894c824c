"""`railcli modes` and `railcli critical-speed` as a user sees them."""

import csv
import json

import pytest
from click.testing import CliRunner

from railcli.analysis import stability
from railcli.cli import main
from railcli.files import tables

SCENARIO = """
[run]
speed_m_per_s = 30
[contact]
creep_law = "hard"
table = "{table}"
normal = "hertz"
[[track]]
kind = "straight"
length_m = 100
"""


def run(*arguments):
    return CliRunner().invoke(main, [*map(str, arguments)], prog_name="railcli")


@pytest.fixture(scope="module")
def scenario(table, tmp_path_factory):
    """A scenario on rails at 1:20 with its table in a file."""
    folder = tmp_path_factory.mktemp("stability")
    tables.save(table, folder / "table.h5")
    path = folder / "case.toml"
    path.write_text(SCENARIO.format(table=folder / "table.h5"))
    return path


def test_modes_for_people_and_machines(tmp_path):
    out = tmp_path / "out"
    result = run("modes", "-q", "-o", out)
    assert result.exit_code == 0, result.stderr
    for words in ("car body bounce", "car body lower sway about 1.0 m below the rails", "bogie hunting", "Stable"):
        assert words in result.stdout
    record = json.loads((out / "modes.json").read_text())
    bounce = next(mode for mode in record["modes"] if mode["shape"] == "car body bounce")
    assert bounce["frequency_hz"] == pytest.approx(1.07, abs=0.01) and bounce["plane"] == "vertical"
    assert bounce["displacement"]["car body"]["z_m"] == pytest.approx([1.0, 0.0])
    assert record["stable"] and record["contact"][0]["amplitude_m"] == 0.003
    with open(out / "modes.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(record["modes"])
    assert float(rows[0]["frequency_hz"]) == pytest.approx(record["modes"][0]["frequency_hz"], abs=1e-5)
    with open(out / "shapes.csv", newline="") as file:
        assert {row["body"] for row in csv.DictReader(file)} >= {"car body", "bogie 1", "wheelset 4"}
    assert (out / "eigenvalues.png").stat().st_size > 1e4 and (out / "mode_shapes.png").stat().st_size > 1e4


def test_modes_of_the_own_table_and_other_speeds(scenario, tmp_path):
    records = []
    for k, extra in enumerate(([], ["--speed", 60])):
        out = tmp_path / str(k)
        result = run("modes", scenario, "--amplitude", 0, *extra, "--format", "json", "-q", "--no-figures", "-o", out)
        assert result.exit_code == 0, result.stderr
        records.append(json.loads(result.stdout))
        assert not list(out.glob("*.png"))
    assert [record["speed_m_per_s"] for record in records] == [30.0, 60.0]
    assert records[0]["contact"] is None and records[0]["step_dependence"] < 1e-4
    hunting = [next(m for m in record["modes"] if "hunting" in m["shape"]) for record in records]
    assert hunting[0]["damping_ratio"] > hunting[1]["damping_ratio"] > 0.0


def test_modes_says_when_it_is_unstable(tmp_path):
    result = run("modes", "--speed", 100, "-q", "--no-figures", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert "Unstable: bogie hunting, bogies in phase grows" in result.stdout
    assert json.loads((tmp_path / "out/modes.json").read_text())["stable"] is False


def test_linear_critical_speed(tmp_path):
    out = tmp_path / "out"
    result = run(
        "critical-speed", "--no-ramp", "--amplitude", "3,10", "--speeds", "60-100:20", "-q", "-o", out
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert "beyond the flange" in result.stdout and "Non-linear" not in result.stdout
    record = json.loads((out / "critical_speed.json").read_text())
    three, ten = record["linear"]
    assert 80.0 < three["critical_m_per_s"] < 83.0 and three["mode"] == "bogie hunting, bogies in phase"
    assert ten["critical_m_per_s"] is None and record["limit_cycles"] == []
    with open(out / "root_locus.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["speed_m_per_s"] for row in rows} == {"60", "80", "100"}
    grows = {row["speed_m_per_s"] for row in rows if float(row["real_per_s"]) > 0.0}
    assert grows == {"100"}
    assert (out / "bifurcation.png").exists() and (out / "root_locus.png").exists()


def test_ramp_that_finds_no_hunting(scenario, tmp_path):
    out = tmp_path / "out"
    arguments = ["--amplitude", 2, "--speeds", "20-40:10", "--from", 30, "-q", "-o", out]
    result = run("critical-speed", scenario, *arguments)
    assert result.exit_code == 0, result.stderr
    assert "> 40" in result.stdout and "No hunting: the disturbance dies at 30 m/s (108 km/h) already" in result.stdout
    with open(out / "limit_cycles.csv", newline="") as file:
        (row,) = csv.DictReader(file)
    assert float(row["speed_m_per_s"]) == 30.0 and float(row["W1_mm"]) < 0.1
    assert "linear, swing of 3 mm" in result.stdout and "Below the first speed every swing dies" in result.stdout
    speeds = json.loads((out / "critical_speed.json").read_text())["critical_speeds"]
    for name in ("smallest_cycle", "counted_cycle", "sum_Y_rms"):
        assert speeds[name]["lives_m_per_s"] is None and speeds[name]["died_m_per_s"] == 30.0
    assert speeds["counted_cycle"]["counted_from_mm"] == 1.0 and speeds["linear"]["critical"] == "> 40"
    assert speeds["sum_Y_rms"]["limit_kN"] == pytest.approx([23.182] * 4, abs=1e-3)


def test_ctrl_c_keeps_the_cycles_so_far(scenario, tmp_path, monkeypatch):
    whole = stability.ramp

    def cut_short(*arguments):
        yield next(whole(*arguments))
        raise KeyboardInterrupt

    monkeypatch.setattr("railcli.studies.critical_speed.ramp", cut_short)
    out = tmp_path / "out"
    arguments = ["--amplitude", 2, "--speeds", "20-40:10", "--from", 30, "-q", "--no-figures", "-o", out]
    result = run("critical-speed", scenario, *arguments)
    assert result.exit_code == 130
    assert f"down to 30 m/s are in {out}" in result.stderr
    assert len((out / "limit_cycles.csv").read_text().splitlines()) == 2
    assert json.loads((out / "critical_speed.json").read_text())["limit_cycles"][0]["speed_m_per_s"] == 30.0


@pytest.mark.parametrize(
    "arguments, word",
    [
        (["modes", "stabilty"], "did you mean 'stability'"),
        (["modes", "--amplitude", "-1"], "--amplitude"),
        (["modes", "--speed", "0"], "run.speed_m_per_s"),
        (["critical-speed", "--speeds", "50"], "10-150:5"),
        (["critical-speed", "--speeds", "80-20:5"], "10-150:5"),
        (["critical-speed", "--amplitude", "3,x"], "2,3,4.5"),
        (["critical-speed", "--from", "900"], "--from"),
        (["critical-speed", "--counts", "0.05"], "--threshold"),
        (["critical-speed", "--limits", "none.toml"], "none.toml"),
    ],
)
def test_bad_input_is_one_line(arguments, word, tmp_path):
    result = run(*arguments, "-q", "-o", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert result.stdout == "" and word in result.stderr and "Traceback" not in result.stderr
    assert not (tmp_path / "out").exists()
