"""What all tests share."""

import importlib
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WARM = "railcli.analysis.warm"


def pytest_sessionstart(session):
    """Compile the kernels once, here, before xdist starts workers that would all compile at the same time."""
    is_worker = hasattr(session.config, "workerinput")
    if not is_worker and not session.config.option.collectonly and find_spec(WARM):
        importlib.import_module(WARM).warm()


@pytest.fixture
def run_python(tmp_path):
    """Function that runs Python code in a process of its own, in an empty folder."""

    def run(code, *arguments, **environment):
        return subprocess.run(
            [sys.executable, "-c", code, *arguments],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
            capture_output=True,
            text=True,
            timeout=300,
        )

    return run


@pytest.fixture(scope="session")
def profiles():
    """S1002 wheel and UIC60 rail."""
    from railcli.files.profiles import load_profile

    return load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail")


@pytest.fixture(scope="session")
def table(profiles):
    """Contact table of S1002 on UIC60 with the usual steps over a small range."""
    import scenes

    from railcli.analysis.build_table import build_table

    return build_table(*profiles, scenes.SMALL)[0]


@pytest.fixture(scope="session")
def wagon(table):
    """The Manchester wagon in its curve at 45 m/s, on the small table."""
    import scenes

    return scenes.wagon(table)
