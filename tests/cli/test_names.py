"""Names are words: whatever stands in a name or the surroundings, a command does its work and says so plainly."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from railcli import errors
from railcli.cli import main
from railcli.files import tables
from railcli.files.output import cell, json_text

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-m", "railcli"]
STRANGE = {  # names of the car body, the two bogies, and of the scenario
    "mathematics and formulas": ("a $x^{$ b", "=cmd|' /C calc'!A0", "_b"),
    "codes": ("\x1b]0;x\x07", "\x9b31m", "\u202eabc"),
    "signs": ('a,"b";c', "x\ty", "x y"),
}
SCENARIO = """
name = {name}
title = {name}
vehicle = "vehicle.toml"
[run]
speed_m_per_s = 20
distance_m = 12
[contact]
table = "table.h5"
normal = "hertz"
[[track]]
kind = "straight"
length_m = 200
"""


@pytest.fixture
def named(tmp_path, table, monkeypatch):
    """Function that writes a scenario whose bodies have such names, here."""
    monkeypatch.chdir(tmp_path)
    tables.save(table, tmp_path / "table.h5")
    text = (ROOT / "benchmarks/manchester/vehicle.toml").read_text(encoding="utf-8")

    def write(names):
        changed = text
        for old, new in zip(("car body", "bogie 1", "bogie 2"), names, strict=True):
            changed = changed.replace(json.dumps(old), json.dumps(new))
        Path("vehicle.toml").write_text(changed, encoding="utf-8")
        Path("case.toml").write_text(SCENARIO.format(name=json.dumps(names[0])), encoding="utf-8")

    return write


def harmless(text):
    return errors.harmless(text) == text


@pytest.mark.parametrize("names", STRANGE.values(), ids=STRANGE)
def test_any_name_of_bodies_and_scenarios(named, names):
    named(names)
    runner, figures = CliRunner(), [] if "$" in names[0] else ["--no-figures"]
    result = runner.invoke(main, ["run", "scenario", "./case.toml", "-q", "-o", "out", *figures])
    if result.exit_code == 2:  # a name may be refused, in one line, before anything is written
        assert harmless(result.stderr) and result.stderr.count("\n") == 1 and not Path("out").exists()
        return
    assert result.exit_code == 0 and harmless(result.output), result.output
    with open("out/main.csv", newline="", encoding="utf-8") as file:
        head = next(csv.reader(file))
    assert sum(name.endswith("_per_s2") for name in head) == 9 and len(set(head)) == len(head)
    assert not any(name.startswith(("=", "+", "-", "@")) for name in head)
    if "$" in names[0]:
        result = runner.invoke(main, ["report", "out", "-o", "page", "-q"])
        assert result.exit_code == 0 and harmless(result.output), result.output


def test_letters_of_any_script(named):
    named(("车体", "转向架", "架构"))
    result = CliRunner().invoke(main, ["run", "scenario", "./case.toml", "-q", "-o", "out"])
    assert result.exit_code == 0 and len(result.stderr.splitlines()) <= 2
    assert "车体_ax_m_per_s2" in Path("out/main.csv").read_text(encoding="utf-8").splitlines()[0]


@pytest.mark.parametrize(
    "text, wanted",
    [("a b", "a b"), ("=1+1", "'=1+1"), ('a,"b"', '"a,""b"""'), ("a\nb", "a b"), ("-", "'-"), ("车;体", '"车;体"')],
)
def test_cell(text, wanted):
    assert cell(text) == wanted


def test_json_holds_no_codes():
    text = json_text({"a\x9b": "\x1b[31m \udcf6 \u202e 车"})
    assert harmless(text) and "车" in text
    assert json.loads(text) == {"a\x9b": "\x1b[31m \udcf6 \u202e 车"}


needs_unix = pytest.mark.skipif(os.name != "posix", reason="names and streams of Unix")


def shell(line, **environment):
    done = subprocess.run(
        ["sh", "-c", line.replace("railcli", f"'{sys.executable}' -m railcli")], capture_output=True, timeout=600,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@needs_unix
def test_a_file_whose_name_is_no_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sample = next((ROOT / "tests/data/samples").glob("avg_wheel.whl"))
    Path(os.fsdecode(b"Rad_gr\xf6sse.whl")).write_bytes(sample.read_bytes())
    code, out, said = shell("railcli profile import Rad_gr*.whl -o $(printf 'w\\366.csv')")
    assert (code, said) == (0, b"") and b"Fit for a contact table" in out
    small = "--normal hertz --y-range 2 --roll-range 5 --yaw-range 5 --poses 0"
    code, _, said = shell(f"railcli build-lut {small} --wheel $(printf 'w\\366.csv') -o $(printf 't\\366.h5') -q")
    assert code in (0, 2) and b"fault" not in said, said


@needs_unix
@pytest.mark.parametrize("closed", ["2>&-", ">&- 2>&- <&-", "| true"])
def test_closed_streams(recorded, tmp_path, monkeypatch, closed):
    """What is said goes nowhere; files are as ever."""
    monkeypatch.chdir(tmp_path)
    code, _, said = shell(f"railcli export {recorded()} --channel time -o a.csv {closed}")
    assert code == 0 and b"fault" not in said and b"Traceback" not in said
    assert Path("a.csv").read_text().startswith("time")


@needs_unix
def test_a_terminal_that_lacks_letters():
    code, out, said = shell(
        "railcli run scenario ./$(printf '\\350\\275\\246').toml", PYTHONIOENCODING="ascii", LC_ALL="C"
    )
    assert code == 2 and said.startswith(b"Error: ") and said.count(b"\n") == 1
