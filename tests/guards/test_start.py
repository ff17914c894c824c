"""`railcli --help` starts at once: no heavy library is imported before a command runs."""

import pytest

HEAVY = {"numpy", "numba", "scipy", "pandas", "matplotlib", "pydantic", "h5py", "rich"}

START = f"""
import sys
from railcli.cli import main
main(sys.argv[1:], standalone_mode=False)
print("loaded:", sorted({HEAVY!r} & set(sys.modules)))
"""


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["build-lut", "--help"], ["run", "scenario", "--help"], ["run", "--help"]]
)
def test_start_is_light(run_python, arguments):
    result = run_python(START, *arguments)
    assert result.stdout.splitlines()[-1:] == ["loaded: []"], result.stderr
