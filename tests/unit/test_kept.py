"""Compiled code on disk saves time and nothing else: it is never stale, never damaged, never needed."""

import os
import re

import pytest

from railcli.kernels import kept

TWICE = """
import sys, warnings
warnings.simplefilter("always")
sys.path.insert(0, ".")
from twice import twice
print(twice(4.0), sum(twice.compiled().stats.cache_hits.values()) if hasattr(twice.compiled(), "stats") else "plain")
"""
SOURCE = """
from railcli.kernels import jit
from numba import types

@jit.entry(types.float64(types.float64))
def twice(x):
    return {factor} * x
"""


@pytest.fixture
def twice(run_python, tmp_path):
    """Function that runs `twice` in a new process: result, how often kept code was taken, warnings."""

    def run(factor=2.0, **environment):
        (tmp_path / "twice.py").write_text(SOURCE.format(factor=factor))
        done = run_python(TWICE, **{"NUMBA_CACHE_DIR": str(tmp_path / "code"), **environment})
        assert done.returncode == 0, done.stderr
        value, hits = done.stdout.split()
        return float(value), hits == "1", done.stderr

    return run


def code(tmp_path):
    return sorted((tmp_path / "code").rglob("*.code"))


def test_code_is_compiled_once_and_never_stale(twice, tmp_path):
    assert twice() == (8.0, False, "")
    assert twice() == (8.0, True, "")
    assert twice(3.0) == (12.0, False, "")
    assert twice(NUMBA_BOUNDSCHECK="1") == (8.0, False, "")
    assert len(code(tmp_path)) == 3


def test_damaged_code_is_compiled_again_with_a_warning(twice, tmp_path):
    twice()
    (path,) = code(tmp_path)
    whole = path.read_bytes()
    for damage in (whole[:-1], b"", whole[: len(whole) // 2] + b"x" + whole[len(whole) // 2 + 1 :], whole + b"x"):
        path.write_bytes(damage)
        value, hit, told = twice()
        assert (value, hit) == (8.0, False) and "is damaged" in told and told.count("Warning") == 1
        assert path.read_bytes() != damage and twice() == (8.0, True, "")


def test_a_cache_that_cannot_be_written_costs_time_only(twice, tmp_path):
    (tmp_path / "file").touch()
    value, hit, told = twice(NUMBA_CACHE_DIR=str(tmp_path / "file"))
    assert (value, hit) == (8.0, False)
    assert "cannot be kept" in told and "RAILCLI_CACHE_DIR" in told and told.count("Warning") == 1
    assert not list(tmp_path.rglob("*.code")) and not list(kept.PACKAGE.rglob("*.nbc"))


@pytest.mark.skipif(os.name != "posix", reason="needs a limit that the system sets on files")
def test_a_full_disk_costs_time_only(run_python, tmp_path):
    (tmp_path / "twice.py").write_text(SOURCE.format(factor=2.0))
    limit = "import resource, signal\nresource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
    done = run_python(limit + TWICE, NUMBA_CACHE_DIR=str(tmp_path / "code"), PYTHONDONTWRITEBYTECODE="1")
    assert done.stdout.split()[0] == "8.0" and "cannot be kept" in done.stderr
    assert not list((tmp_path / "code").rglob("*.*"))


def test_without_compiler(twice, tmp_path):
    value, _, told = twice(NUMBA_DISABLE_JIT="1")
    assert (value, told) == (8.0, "") and code(tmp_path) == []


def test_only_folders_of_code_are_forgotten(tmp_path, monkeypatch):
    """Others with such names are the user's, wherever NUMBA_CACHE_DIR or RAILCLI_CACHE_DIR point."""
    ours = [tmp_path / f"railcli-{k:016x}" for k in range(5)]
    theirs = [tmp_path / "railcli-1.2", tmp_path / "railcli-results", tmp_path / "railcli-00112233445566778"]
    for k, folder in enumerate([*ours, *theirs]):
        (folder / "sub").mkdir(parents=True)
        (folder / "thesis.txt").touch()
        for name in ("a.code", "sub/step.advance-1.py311.1.nbc", "a.nbi"):
            (folder / name).touch()
        os.utime(folder, (k, k))
    monkeypatch.setattr(kept, "_FOLDER", ours[1])
    kept.forget_old_code()
    forgotten = [folder for folder in (*ours, *theirs) if not (folder / "a.code").exists()]
    assert forgotten == [ours[0], ours[2]]  # the one in use was used last
    assert [path.name for path in ours[0].rglob("*")] == ["thesis.txt"]
    assert len(list(theirs[0].rglob("*"))) == 5


def test_file_names_are_the_same_in_every_process(run_python):
    """A key that holds an address of memory would never be found again."""
    code = """
from railcli.kernels import contact, jit, step, tabulate
import railcli.kernels.strips, railcli.kernels.branches, railcli.kernels.heights
from railcli.kernels.kept import KeptCode
import gc
print(sorted(repr(item._own) for item in gc.get_objects() if isinstance(item, KeptCode)))
"""
    first = run_python(code).stdout
    assert first.count("'") > 100 and not re.search(r" at 0x", first)
