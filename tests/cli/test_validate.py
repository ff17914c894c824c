"""`railcli validate manchester` from the outside."""

import csv
import json

import numpy as np
import pytest
import tolerances as tol
from click.testing import CliRunner

from railcli.analysis import disturbance, validate
from railcli.analysis.validate import READINGS, Curving, Scan, Validation, deviations
from railcli.cli import main
from railcli.files import benchmark
from railcli.report import disturbance as report

FILES = {"validation.md", "validation.json", "validation.csv"}
FIGURES = {"displacements.png", "friction.png", "forces.png"}
MASS = 44_482.0  # of the wagon [kg]


def run(*arguments):
    arguments = ["validate", "manchester", "-q", *(str(item) for item in arguments)]
    return CliRunner().invoke(main, arguments, prog_name="railcli")


def names(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def curving(speed, outwards):
    """A run with balanced forces."""
    y = MASS * (9.81 * 0.06 - speed**2 / 1200.0 * np.sqrt(1.0 - 0.06**2))
    q = MASS * (9.81 * np.sqrt(1.0 - 0.06**2) + speed**2 / 1200.0 * 0.06)
    return Curving(
        speed=speed, outwards_mm=outwards, peak_to_peak_mm=np.zeros(4), yaw=np.zeros(4), q_outer=np.full(4, q / 8),
        q_inner=np.full(4, q / 8), y_outwards=np.full(4, y / 4), expected_y=y, expected_q=q, hold=300.0,
    )  # fmt: skip


def invented(reference, criteria, *_):
    """A comparison without a run: 0.1 mm beside the mean of both codes as the second reading has them."""
    ours = np.mean(reference.read("exchanged"), axis=0) + 0.1
    runs = [curving(speed, row) for speed, row in zip(reference.speeds, ours, strict=True)]
    found = deviations(ours, *reference.read("exchanged"))
    friction = np.array([0.1, 0.2, 0.3])
    return Validation(
        reference=reference, nominal=runs, identified=runs, friction=(0.2, 0.1, 0.3, False),
        scan=Scan(friction, np.array([ours, ours, ours])), variants={"friction 0.40": ours},
        holding={reading: [np.zeros((3, 2)), np.full((3, 2), np.nan)] for reading in READINGS},
        static_q=np.full(8, MASS * 9.81 / 8), weight=MASS * 9.81,
        rows=validate.judge(criteria, found, found, 0.2, 0.0),
    )  # fmt: skip


@pytest.fixture
def quick(monkeypatch, table):
    """The command with an invented comparison, in no time."""
    monkeypatch.setattr("railcli.studies.tables.tables_for", lambda *_: [table])
    monkeypatch.setattr(validate, "compare_manchester", invented)


def rms(ours, theirs):
    return float(np.sqrt(np.mean((np.asarray(ours) - theirs) ** 2)))


def check_cells(record):
    """Twelve cells; the readings follow from them."""
    cells = record["cells"]
    assert [(cell["speed_ms"], cell["wheelset"]) for cell in cells] == [
        (speed, wheelset) for speed in (45.0, 30.0, 15.0) for wheelset in (1, 2, 3, 4)
    ]
    inside = np.where(np.arange(4) % 2, -1.0, 1.0)
    changes = {
        "as_printed": lambda code: code,
        "exchanged": lambda code: code[::-1],
        "trailing_inside": lambda code: code * inside,
    }
    codes = {name: np.array([cell[f"{name}_mm"] for cell in cells]).reshape(3, 4) for name in ("simulink", "adams")}
    for column, readings in (("railcli_mm", "readings"), ("railcli_identified_mm", "readings_identified")):
        ours = np.array([cell[column] for cell in cells]).reshape(3, 4)
        assert set(record[readings]) == set(changes)
        for reading, change in changes.items():
            found = record[readings][reading]
            for name, code in codes.items():
                assert found[f"rms_{name}_mm"] == pytest.approx(rms(ours, change(code)), rel=tol.ROUNDING)
            largest = max(np.abs(ours - change(code)).max() for code in codes.values())
            assert found["max_mm"] == pytest.approx(largest, rel=tol.ROUNDING)


def check_balances(record):
    """Wheels add up to the sums, and the sums to mass times acceleration."""
    limit = benchmark.manchester_criteria()["balance"]["force_kN"]
    assert [balance["speed_ms"] for balance in record["balance"]] == [45.0, 30.0, 15.0]
    for balance in record["balance"]:
        assert len(balance["Q_outer_kN"]) == len(balance["Q_inner_kN"]) == len(balance["Y_wheelsets_kN"]) == 4
        assert sum(balance["Q_outer_kN"]) + sum(balance["Q_inner_kN"]) == pytest.approx(balance["sum_Q_kN"])
        assert sum(balance["Y_wheelsets_kN"]) == pytest.approx(balance["sum_Y_kN"])
        expected = curving(balance["speed_ms"], None)
        assert balance["expected_Y_kN"] == pytest.approx(1e-3 * expected.expected_y)
        assert balance["expected_Q_kN"] == pytest.approx(1e-3 * expected.expected_q)
        assert balance["sum_Y_kN"] == pytest.approx(balance["expected_Y_kN"], abs=limit)
        assert balance["sum_Q_kN"] == pytest.approx(balance["expected_Q_kN"], abs=limit)
    static = record["static"]
    assert sum(static["wheel_loads_kN"]) == pytest.approx(static["weight_kN"], abs=1e-3 * tol.WEIGHT)
    assert static["weight_kN"] == pytest.approx(MASS * 9.81e-3)


def check_criteria(record):
    """What the criteria found is what stands elsewhere; the verdict rests on those that count."""
    found = {row["name"]: row["found"] for row in record["criteria"]}
    for case, readings in (("nominal", "readings"), ("identified", "readings_identified")):
        supported = record[readings][record["supported_reading"]]
        assert found[f"{case}, rms from Simulink"] == supported["rms_simulink_mm"]
        assert found[f"{case}, rms from ADAMS"] == supported["rms_adams_mm"]
        assert found[f"{case}, largest of one cell"] == supported["max_mm"]
    assert all(row["met"] == (row["found"] <= row["limit"]) for row in record["criteria"])
    accepted = all(row["met"] for row in record["criteria"] if row["counts"])
    assert record["verdict"] == ("accepted" if accepted else "rejected")


def test_whole_comparison(tmp_path, monkeypatch):
    """The real thing, tables included."""
    monkeypatch.setenv("RAILCLI_CACHE_DIR", str(tmp_path / "cache"))
    folder = tmp_path / "out"
    result = run("--no-figures", "--format", "json", "-o", folder)
    assert result.exit_code == 0, result.stderr
    record = json.loads(result.stdout)
    assert json.loads((folder / "validation.json").read_text(encoding="utf-8")) == record
    assert names(folder) == FILES
    check_cells(record)
    check_balances(record)
    check_criteria(record)
    friction = record["identified_friction"]
    assert 0.05 <= friction["low"] <= friction["value"] <= friction["high"] <= 0.60
    assert record["supported_reading"] == "exchanged" and record["verdict"] == "accepted"
    assert "not a measurement of friction" in record["assumptions"]["identified"]
    assert {"friction 0.40", "creep law smooth", "inclination 1:40"} <= set(record["variants"])
    columns = list(csv.DictReader((folder / "validation.csv").read_text(encoding="utf-8").splitlines()))
    for row, cell in zip(columns, record["cells"], strict=True):
        assert {key: float(value) for key, value in row.items()} == pytest.approx(cell, rel=tol.SIX_DIGITS)
    text = (folder / "validation.md").read_text(encoding="utf-8")
    assert "Verdict: accepted" in text and "rows 45 and 15 m/s exchanged" in text


def test_arithmetic_of_an_invented_comparison(quick, tmp_path):
    record = json.loads(run("--no-figures", "--format", "json", "-o", tmp_path / "out").stdout)
    check_cells(record)
    check_balances(record)
    check_criteria(record)


def quiet_trace(n, wheels=8, bodies=7):
    time = np.linspace(0.0, 1.0, n)
    zeros = np.zeros((n, wheels))
    return disturbance.Trace(time, zeros + 5e4, zeros, np.zeros((n, bodies, 3)), np.zeros((n, bodies)), zeros + 1.0)


def disturbed(force_error):
    """A comparison of disturbances whose wheel forces differ by a given share."""

    def compare(scenario, tables, criteria, progress):
        progress(0.5, "half")
        time = np.linspace(0.0, 1.0, 50)
        wave = np.sin(20.0 * time)
        force = 1e3 * np.repeat(wave[:, None], 4, axis=1)
        bumps = [
            disturbance.SmallBump(3.0, 3e-4, step, time, (1.0 + force_error) * force, force, wave, wave, 0.02)
            for step in disturbance.STEPS
        ]
        f = np.array([1.0, 10.0, 100.0])
        response = np.array([[1e6 + 1e5j] * 4] * 3)
        found = disturbance.Waves(f, response, response, response[:, 0], response[:, 0], f, np.ones((3, 5)))
        large = [
            disturbance.LargeBump(height, time, force[:, 0], force[:, 0], 0.0, 1e3, 0.1, 0.1)
            for height in disturbance.LARGE
        ]
        aside = [disturbance.Lateral(shape, quiet_trace(50), 0.0) for shape in disturbance.LATERAL]
        rows = disturbance.judge(criteria, bumps, found)
        return disturbance.Disturbance(5e4, bumps, found, large, aside, rows)

    return compare


def test_disturbance_is_reported_with_the_rest(quick, monkeypatch, tmp_path):
    """Sections, figures, JSON and criteria stand beside those of the curve."""
    monkeypatch.setattr(disturbance, "compare_disturbance", disturbed(0.002))
    folder = tmp_path / "out"
    result = run("--disturbance", "-o", folder)
    assert result.exit_code == 0, result.stderr
    assert names(folder) == FILES | FIGURES | {f"{name}.png" for name in report.FIGURES}
    assert "Verdict: accepted (8 of 8" in result.stdout and "against the linear vertical model" in result.stdout
    record = json.loads((folder / "validation.json").read_text(encoding="utf-8"))
    check_criteria(record)
    assert record["disturbance"]["small_bumps"][0]["force_error"] == pytest.approx(0.002)
    assert "(disturbance-lift.png)" in (folder / "validation.md").read_text(encoding="utf-8")


def test_disturbance_counts_for_the_verdict(quick, monkeypatch, tmp_path):
    """A wheel force 2 % off rejects, with exit code 4; without the option it is not asked."""
    monkeypatch.setattr(disturbance, "compare_disturbance", disturbed(0.02))
    result = run("--disturbance", "--no-figures", "-o", tmp_path / "out")
    assert result.exit_code == 4
    assert "disturbance: bump of 3 m, wheel force" in result.stderr.splitlines()[-1]
    assert run("--no-figures", "-o", tmp_path / "two").exit_code == 0


def test_text_and_figures(quick, tmp_path):
    folder = tmp_path / "out"
    result = run("--sensitivity", "-o", folder)
    assert result.exit_code == 0, result.stderr
    assert names(folder) == FILES | FIGURES
    assert all((folder / name).read_bytes().startswith(b"\x89PNG") for name in FIGURES)
    assert "Verdict: accepted (4 of 4" in result.stdout and str(folder) in result.stdout
    assert "friction 0.20" in result.stdout and "friction 0.40" in result.stdout
    assert "nan" not in result.stdout
    text = (folder / "validation.md").read_text(encoding="utf-8")
    assert all(f"({name})" in text for name in FIGURES)
    assert all(line in text for line in result.stdout.splitlines() if line.startswith("  "))


def test_rejected_is_exit_code_4_with_all_files(quick, tmp_path, monkeypatch):
    criteria = benchmark.manchester_criteria()
    criteria["nominal"]["max_mm"] = 0.1
    monkeypatch.setattr(benchmark, "manchester_criteria", lambda: criteria)
    folder = tmp_path / "out"
    result = run("--no-figures", "--format", "json", "-o", folder)
    assert result.exit_code == 4
    record = json.loads(result.stdout)
    assert record["verdict"] == "rejected"
    check_criteria(record)
    assert result.stderr == "Error: validate manchester: rejected (nominal, largest of one cell)\n"
    assert names(folder) == FILES


def test_criterion_that_is_only_shown_does_not_reject(quick, tmp_path, monkeypatch):
    criteria = benchmark.manchester_criteria()
    criteria["leading"]["max_mm"] = criteria["identified"]["max_mm"] = 0.0
    monkeypatch.setattr(benchmark, "manchester_criteria", lambda: criteria)
    result = run("--no-figures", "-o", tmp_path / "out")
    assert result.exit_code == 0
    assert result.stdout.count("NOT MET") == 2


def test_existing_folder_is_refused_and_left_alone(quick, tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    for arguments in (["-o", folder], ["-o", folder, "--overwrite"]):
        result = run("--no-figures", *arguments)
        assert (result.exit_code, result.stdout) == (2, "")
        assert str(folder) in result.stderr and result.stderr.count("\n") == 1
    assert names(folder) == {"notes.txt"}


def test_overwrite_replaces_an_earlier_comparison(quick, tmp_path):
    folder = tmp_path / "out"
    assert run("-o", folder).exit_code == 0
    assert run("--no-figures", "-o", folder).exit_code == 2
    assert run("--no-figures", "-o", folder, "--overwrite").exit_code == 0
    assert names(folder) == FILES


def test_ctrl_c_leaves_nothing(quick, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(validate, "compare_manchester", interrupted)
    result = run("-o", tmp_path / "out")
    assert result.exit_code == 130
    assert not (tmp_path / "out").exists()


PRINTED = benchmark.resource("benchmarks/manchester/reference/lateral_displacement.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "name, text",
    [
        ("lateral_displacement.csv", PRINTED.replace("45,2,3.1,3.2", "45,2,3.1 mm,3.2")),
        ("lateral_displacement.csv", PRINTED.replace("45,2,3.1,3.2\n", "")),
        ("lateral_displacement.csv", PRINTED.replace("45,2,3.1,3.2", "45,2,3.1")),
        ("lateral_displacement.csv", ""),
        ("accept.toml", "[nominal]\nrms_mm = \n"),
    ],
    ids=["unit in a cell", "row missing", "column missing", "empty", "criteria malformed"],
)
def test_broken_reference_is_one_line(tmp_path, monkeypatch, name, text):
    bundled = benchmark.resource

    def resource(relative):
        if not relative.endswith(name):
            return bundled(relative)
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    monkeypatch.setattr(benchmark, "resource", resource)
    result = run("-o", tmp_path / "out")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"Error: {tmp_path / name}: is not the file that came with railcli")
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
