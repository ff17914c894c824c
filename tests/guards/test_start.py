"""Nothing heavy is imported before it is needed: `railcli --help` starts at once, a plain run loads no scipy."""

import pytest
import scenes

from railcli.files import tables

HEAVY = {"numpy", "numba", "scipy", "pandas", "matplotlib", "pydantic", "h5py", "rich"}
# of these a run needs none; scipy.linalg is absent here because numba itself looks there for a BLAS
NOT_FOR_A_RUN = {"scipy.fft", "scipy.interpolate", "scipy.optimize", "scipy.signal", "pandas", "matplotlib"}

START = """
import sys
from railcli.cli import main
main(sys.argv[1:], standalone_mode=False)
print("loaded:", sorted({names!r} & set(sys.modules)))
"""


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["build-lut", "--help"], ["run", "scenario", "--help"], ["run", "--help"]]
)
def test_start_is_light(run_python, arguments):
    result = run_python(START.format(names=HEAVY), *arguments)
    assert result.stdout.splitlines()[-1:] == ["loaded: []"], result.stderr


def test_a_plain_run_loads_only_what_it_needs(run_python, table, tmp_path):
    tables.save(table, tmp_path / "table.h5")
    text = scenes.SHORT_CURVE.format(table="table.h5", friction=0.3, interval=10.0)
    (tmp_path / "curve.toml").write_text(text)
    plain = ["run", "scenario", "curve.toml", "--no-figures", "--no-assessment", "-q", "-o", "out"]
    result = run_python(START.format(names=NOT_FOR_A_RUN), *plain)
    assert result.stdout.splitlines()[-1:] == ["loaded: []"], result.stderr
