"""Whatever ends a command, what is worth something stays, and nothing else does."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
from click.testing import CliRunner

from railcli.cli import main
from railcli.files import kept_tables, tables
from railcli.files.output import LIST, parts
from railcli.files.read_results import Results
from railcli.kernels import kept

LONG = """
[run]
speed_m_per_s = 20
[contact]
table = "table.h5"
normal = "hertz"
[[track]]
kind = "straight"
length_m = 100000
"""
LARGE = range(5_000_000, 1 << 40)  # bytes of a file that has got room for rows
needs_unix = pytest.mark.skipif(os.name != "posix", reason="signals of Unix")


def railcli(*arguments):
    return CliRunner().invoke(main, [str(word) for word in arguments], prog_name="railcli")


@needs_unix
@pytest.mark.parametrize("name, code", [("SIGTERM", 143), ("SIGHUP", 129), ("SIGKILL", -9)])
def test_rows_of_a_run_that_is_stopped_are_kept(table, tmp_path, name, code):
    tables.save(table, tmp_path / "table.h5")
    (tmp_path / "case.toml").write_text(LONG)
    words = ["run", "scenario", "./case.toml", "-q", "-o", "out"]
    process = subprocess.Popen(
        [sys.executable, "-m", "railcli", *words], cwd=tmp_path, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),  # below nohup it is ignored, and stays so
    )  # fmt: skip
    sizes, ends = set(), time.monotonic() + 200  # when there is room for the second rows, the first are written
    while len(sizes) < 2 and time.monotonic() < ends and process.poll() is None:
        time.sleep(0.02)
        found = [path.stat().st_size for path in parts(tmp_path / "out", "timeseries.h5")]
        sizes.update(size for size in found if size in LARGE)
    if name == "SIGKILL":
        busy = railcli("assess", tmp_path / "out", "-q", "-o", tmp_path / "a")
        assert busy.exit_code == 2 and "its run goes on" in busy.stderr
    process.send_signal(getattr(signal, name))
    said = process.communicate()[1].decode()
    assert process.returncode == code, said
    with Results(tmp_path / "out") as results:
        assert results.rows > 100 and ("killed" if name == "SIGKILL" else "interrupted") in results.fault
        assert len(results.read("wheels/W1_right/Q")) == results.rows
    assert railcli("assess", tmp_path / "out", "-q", "-o", tmp_path / "b", "--no-figures").exit_code == 0
    if name == "SIGKILL":
        assert said == "" and parts(tmp_path / "out")
    else:
        (line,) = said.splitlines()
        assert "What was computed until t = " in line and not parts(tmp_path / "out")


def test_results_are_not_overwritten_by_who_reads_them(recorded, tmp_path):
    shutil.copytree(recorded(), tmp_path / "out")
    for command in ("assess", "report"):
        result = railcli(command, tmp_path / "out", "-q", "-o", tmp_path / "out", "--overwrite")
        assert result.exit_code == 2 and "holds what this command reads" in result.stderr
    with Results(tmp_path / "out") as results:
        assert results.summary


def test_every_file_of_results_has_its_checksum(recorded):
    lines = [line for line in (recorded() / LIST).read_text().splitlines() if not line.startswith("#")]
    listed = {line[66:]: line[:64] for line in lines}
    assert set(listed) == {path.name for path in recorded().iterdir()} - {LIST}
    assert all(len(digest) == 64 and int(digest, 16) for digest in listed.values())


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache with four tables of 1 MB, the first of which was used last."""
    monkeypatch.setenv("RAILCLI_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(kept, "_FOLDER", tmp_path / "code/railcli-0123456789abcdef")
    (tmp_path / "tables").mkdir()
    places = [tmp_path / f"tables/{k:032x}.h5" for k in range(4)]
    for k, path in enumerate(places):
        path.write_bytes(bytes(1_000_000))
        os.utime(path, (1e9 - k, 1e9 - k))
    (tmp_path / "tables/mine.h5").write_bytes(bytes(1_000_000))
    return places


def test_tables_used_longest_ago_go_first(cache, monkeypatch):
    monkeypatch.setenv("RAILCLI_CACHE_GB", "0.0025")
    kept_tables.used(cache[3])
    kept_tables.make_room(cache[2])
    assert [path.exists() for path in cache] == [True, False, True, True]
    assert (cache[0].parent / "mine.h5").exists()


def test_cache_is_shown_and_emptied(cache):
    shown = json.loads(railcli("cache", "--format", "json").stdout)
    assert [table["file"] for table in shown["tables"]] == [str(path) for path in cache]
    assert "damaged" in railcli("cache").stdout
    assert railcli("cache", "--empty").exit_code == 0
    assert [path.name for path in cache[0].parent.iterdir()] == ["mine.h5"]


@pytest.mark.parametrize("value", ["", "lots", "-1", "nan"])
def test_bound_of_the_cache(cache, monkeypatch, value):
    monkeypatch.setenv("RAILCLI_CACHE_GB", value)
    result = railcli("cache")
    assert result.exit_code == (0 if value == "" else 2)
    assert value == "" or "give a number of GB" in result.stderr
