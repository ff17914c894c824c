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
            timeout=1200,
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
def heights(profiles):
    """Table of heights of S1002 on UIC60 over a small range."""
    import scenes

    from railcli.analysis.build_table import build_table

    return build_table(*profiles, scenes.STRIPS)[0]


@pytest.fixture(scope="session")
def wagon(table):
    """The Manchester wagon in its curve at 45 m/s, on the small table."""
    import scenes

    return scenes.wagon(table)


@pytest.fixture(scope="session")
def recorded(table, tmp_path_factory):
    """Function that runs a short curve at a friction and an interval [ms], and gives its results folder."""
    import scenes
    from click.testing import CliRunner

    from railcli.cli import main
    from railcli.files import tables

    place = tmp_path_factory.mktemp("recorded")
    tables.save(table, place / "table.h5")
    done = {}

    def folder(friction=0.3, interval=10.0):
        if (friction, interval) not in done:
            text = scenes.SHORT_CURVE.format(friction=friction, interval=interval, table=place / "table.h5")
            name = f"curve-{friction:g}-{interval:g}"
            (place / f"{name}.toml").write_text(text)
            arguments = ["run", "scenario", str(place / f"{name}.toml"), "-o", str(place / name), "-q", "--no-figures"]
            result = CliRunner().invoke(main, arguments)
            assert result.exit_code == 0, result.stderr
            done[friction, interval] = place / name
        return done[friction, interval]

    return folder
