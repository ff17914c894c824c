"""railcli sweep on a dask cluster: a real scheduler and workers in processes of their own on this machine."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas
import pytest
import scenes
from click.testing import CliRunner

from railcli.cli import main
from railcli.files import tables

pytestmark = [
    pytest.mark.skipif(
        importlib.util.find_spec("distributed") is None, reason="needs distributed: pip install 'railcli[cluster]'"
    ),
    pytest.mark.filterwarnings("default"),  # of dask and tornado
]
ROOT = Path(__file__).parents[2]
STUDY = """
scenario = "curve.toml"
outputs = ["steady.*"]
[[channel]]
channel = "wheels/W1_*/Q"
[[vary]]
key = "run.speed_kmh"
from = 60
to = 72
count = 8
[[vary]]
key = "contact.friction"
values = [0.2, 0.3, 2.0]
"""
TIMES = ["cpu_s", "time_s"]


@pytest.fixture(scope="module")
def place(table, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cluster")
    tables.save(table, folder / "table.h5")
    text = scenes.SHORT_CURVE.format(table=folder / "table.h5", friction=0.3, interval=10.0)
    (folder / "curve.toml").write_text(text)
    (folder / "study.toml").write_text(STUDY)
    return folder


class Cluster:
    """A scheduler and two workers of one thread each."""

    def __init__(self, folder):
        self.folder = folder
        self.scheduler = self._start("dask_scheduler", "--port", "0", "--scheduler-file", "scheduler.json")
        self.address = json.loads(self._wait_for(folder / "scheduler.json"))["address"]
        self.workers = [self.worker() for _ in range(2)]

    def worker(self):
        return self._start("dask_worker", self.address, "--nthreads", "1", "--no-nanny", "--memory-limit", "0")

    def _start(self, module, *words):
        command = [sys.executable, "-m", f"distributed.cli.{module}", *words, "--host", "127.0.0.1", "--no-dashboard"]
        with open(self.folder / f"{module}.log", "a") as log:
            return subprocess.Popen(
                command, cwd=self.folder, stdout=log, stderr=log, env={**os.environ, "PYTHONPATH": str(ROOT)}
            )

    @staticmethod
    def _wait_for(path):
        for _ in range(6000):
            if path.exists() and path.stat().st_size:
                return path.read_text()
            time.sleep(0.01)
        raise AssertionError(f"no {path}")

    def close(self):
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    made = Cluster(tmp_path_factory.mktemp("dask"))
    yield made
    made.close()


def invoke(*arguments):
    return CliRunner().invoke(main, ["sweep", *map(str, arguments), "--no-figures"])


def rows(folder):
    return pandas.read_parquet(folder / "rows.parquet").drop(columns=TIMES)


@pytest.fixture(scope="module")
def local(place):
    result = invoke(place / "study.toml", "-o", place / "local", "--workers", 0, "-q")
    assert result.exit_code == 0, result.stderr
    return rows(place / "local")


def test_a_scheduler_that_is_not_there_is_one_line(place, monkeypatch):
    from railcli.studies.sweep import cluster as module

    monkeypatch.setattr(module, "PATIENCE", 0.5)
    result = invoke(place / "study.toml", "-o", place / "nowhere", "--scheduler", "tcp://127.0.0.1:9", "-q")
    assert result.exit_code == 2 and "no scheduler answers there" in result.stderr
    assert len(result.stderr.splitlines()) == 1


def test_workers_of_another_version_are_refused(place, cluster, monkeypatch):
    from railcli.studies.sweep import cluster_task

    monkeypatch.setattr(cluster_task, "__version__", "99.0")
    result = invoke(place / "study.toml", "-o", place / "other", "--scheduler", cluster.address, "-q")
    (line,) = result.stderr.splitlines()
    assert result.exit_code == 2 and "is of another version: railcli" in line and "not 99.0" in line


def begun(place, folder, cluster, least):
    """A process that makes the study there, with at least some rows made."""
    words = ["sweep", str(place / "study.toml"), "-o", str(folder), "--scheduler", cluster.address, "--no-figures"]
    code = "from railcli.cli import main; import sys; main(sys.argv[1:], prog_name='railcli')"
    process = subprocess.Popen([sys.executable, "-c", code, *words], stderr=subprocess.PIPE, text=True)
    journal = folder / "rows.jsonl"
    while process.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= least):
        time.sleep(0.01)
    return process


def test_a_worker_that_is_killed_loses_nothing_and_rows_are_the_same(place, cluster, local):
    """While the study goes on one of both workers is killed, another one joins."""
    process = begun(place, place / "far", cluster, 3)
    os.kill(cluster.workers[0].pid, signal.SIGKILL)
    cluster.workers.append(cluster.worker())
    said = process.communicate()[1]
    assert process.returncode == 0, said
    assert "2 workers with 2 threads" in said
    assert (place / "far/rows.jsonl").read_bytes().count(b"\n") == 24
    pandas.testing.assert_frame_equal(rows(place / "far"), local, check_exact=True)


def test_a_scheduler_that_goes_away_loses_nothing(place, cluster, local):
    process = begun(place, place / "lost", cluster, 2)
    cluster.scheduler.kill()
    said = process.communicate(timeout=120)[1]
    assert process.returncode == 3 and "the scheduler went away" in said and "goes on" in said, said
    result = invoke(place / "study.toml", "-o", place / "lost", "--workers", 0, "-q")
    assert result.exit_code == 0, result.stderr
    pandas.testing.assert_frame_equal(rows(place / "lost"), local, check_exact=True)
