"""Full disks, caches that cannot be written, cold starts at the same time: a run goes on, or one line says why not."""

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from railcli.files import tables
from railcli.files.output import parts
from railcli.files.read_results import Results

pytestmark = [pytest.mark.campaign, pytest.mark.skipif(os.name != "posix", reason="limits of Unix")]
COMMAND = [sys.executable, "-m", "railcli"]
RUN = """
[run]
speed_m_per_s = 20
[contact]
table = "{table}"
normal = "hertz"
[[track]]
kind = "straight"
length_m = 300
"""


@pytest.fixture
def case(table, tmp_path):
    tables.save(table, tmp_path / "table.h5")
    (tmp_path / "case.toml").write_text(RUN.format(table=tmp_path / "table.h5"))
    return tmp_path / "case.toml"


def command(words, folder, most=None, **environment):
    limit = None if most is None else lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    return subprocess.run(
        [*COMMAND, *map(str, words)], cwd=folder, preexec_fn=limit, env={**os.environ, **environment},
        capture_output=True, text=True, timeout=1800,
    )  # fmt: skip


def test_files_that_may_not_grow(case, recorded, many, random, counts, tmp_path):
    """A limit on the size of files stands for a disk that fills up at any moment."""
    for number in range(many(12)):
        most = int(10 ** random.uniform(2.0, 7.0))
        words = [["run", "scenario", case, "-q"], ["assess", recorded(), "-q"], ["export", recorded(), "-q"]][
            number % 3
        ]
        folder = tmp_path / f"full-{number}"
        folder.mkdir()
        output = folder / ("out.csv" if words[0] == "export" else "out")
        done = command([*words, "-o", output], folder, most)
        what = f"{words[0]}, files of at most {most} bytes: {done.returncode}\n{done.stderr}"
        assert done.returncode in (0, 2) and "Traceback" not in done.stderr and "fault" not in done.stderr, what
        assert parts(folder) == [] and parts(folder / "out") == [], what
        if done.returncode == 2:
            assert len([line for line in done.stderr.splitlines() if line.startswith("Error: ")]) == 1, what
        if (folder / "out/timeseries.h5").exists():
            with Results(folder / "out") as results:
                assert results.rows > 0
        counts[f"ended with {done.returncode}"] += 1
        shutil.rmtree(folder)


@pytest.mark.parametrize("cache", ["file", "full"])
def test_caches_that_keep_nothing(case, tmp_path, counts, cache):
    """All is compiled and built anew, with one warning for each of both, and the results are the same."""
    (tmp_path / "file").touch()
    small = ["conicity", "--amplitude", "3", "-q", "--format", "json", "-o"]
    usual = command([*small, "a"], tmp_path)
    if cache == "file":
        done = command([*small, "b"], tmp_path, RAILCLI_CACHE_DIR=str(tmp_path / "file"))
    else:
        done = command([*small, "b"], tmp_path, 300_000, RAILCLI_CACHE_DIR=str(tmp_path / "cache"))
    assert done.returncode == usual.returncode == 0, done.stderr
    assert done.stderr.count("compiled code cannot be kept") == 1
    first, second = json.loads(usual.stdout), json.loads(done.stdout)
    assert first["amplitudes"] == second["amplitudes"] if "amplitudes" in first else first.keys() == second.keys()
    counts[cache] += 1


def test_cold_starts_at_the_same_time(many, counts, tmp_path):
    """Several processes compile at once into an empty cache: all end well, and the next one takes what they kept."""
    for number in range(many(1)):
        place = {**os.environ, "RAILCLI_CACHE_DIR": str(tmp_path / f"cache-{number}")}
        words = [*COMMAND, "conicity", "--amplitude", "3", "-q"]
        started = [
            subprocess.Popen([*words, "-o", f"out-{number}-{k}"], cwd=tmp_path, env=place, stderr=subprocess.PIPE)
            for k in range(3)
        ]
        said = [one.communicate()[1] for one in started]
        assert [one.returncode for one in started] == [0, 0, 0] and said == 3 * [b""], said
        before = sorted(Path(place["RAILCLI_CACHE_DIR"]).rglob("*.code"))
        assert before and not list(Path(place["RAILCLI_CACHE_DIR"]).rglob("*.code.*"))
        assert subprocess.run([*words, "-o", f"again-{number}"], cwd=tmp_path, env=place).returncode == 0
        assert sorted(Path(place["RAILCLI_CACHE_DIR"]).rglob("*.code")) == before
        counts["starts"] += 4
