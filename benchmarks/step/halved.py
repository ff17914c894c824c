"""`python benchmarks/step/halved.py [SCENARIO ...]`: what the chosen step changes against half of it.

Runs built-in scenarios (all of them when none is named) at the step that railcli chooses and at half of it, and prints
as Markdown the largest difference of a steady value and of a figure of the assessment. Needs the `railcli` package.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from click.testing import CliRunner  # noqa: E402

from railcli.cli import main as railcli  # noqa: E402
from railcli.files.scenario import builtin_scenarios  # noqa: E402

SMALL = 0.01  # of its limit: what no one looks at
STEADY = {"lateral_mm": "mm", "Y_kN": "kN", "Q_kN": "kN"}


def ran(name, folder, *options):
    """summary.json of a run."""
    arguments = ["run", "scenario", name, "-q", "--no-figures", "-o", str(folder), "--format", "json", *options]
    result = CliRunner().invoke(railcli, arguments)
    if result.exit_code:
        raise SystemExit(f"{name} {options}: {result.stderr or result.exception!r}")
    return json.loads(result.stdout)


def flat(value):
    """Numbers of nested lists."""
    return [number for one in value for number in flat(one)] if isinstance(value, list) else [value]


def steady(one, other):
    """Largest difference of each kind of steady value; None without steady values."""
    if "steady" not in one or "steady" not in other:
        return None
    means = [record["steady"]["mean"] for record in (one, other)]
    return {key: max(abs(a - b) for a, b in zip(*(flat(mean[key]) for mean in means), strict=True)) for key in STEADY}


def assessed(one, other):
    """Figure of the assessment that differs most, its share and name; None without an assessment."""
    figures = [record.get("assessment", {}).get("figures") for record in (one, other)]
    if not all(figures):
        return None
    values = [{key: one["value"] for key, one in some.items() if _counts(**one)} for some in figures]
    common = values[0].keys() & values[1].keys()
    return max(((abs(values[0][key] / values[1][key] - 1.0), key) for key in common), default=None)


def _counts(value, limit, **_):
    return bool(value) and value > SMALL * (limit or 0.0)


def main():
    """Print the table row by row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", help="built-in names; all by default")
    names = parser.parse_args().scenarios or list(builtin_scenarios())
    print("| scenario | steps, ms | y, mm | Y, kN | Q, kN | figure of the assessment that changes most |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as place:
        for name in names:
            one = ran(name, Path(place) / f"{name}-chosen")
            step = one["step"]["step_ms"]
            other = ran(name, Path(place) / f"{name}-half", "--step", f"{0.5 * step:.10g}")
            means, figure = steady(one, other), assessed(one, other)
            cells = ["", "", ""] if means is None else [f"{means[key]:.4f}" for key in STEADY]
            last = "" if figure is None else f"{figure[1]}, {figure[0]:.2%}"
            print(f"| {name} | {step:g}, {0.5 * step:g} | {' | '.join(cells)} | {last} |", flush=True)


if __name__ == "__main__":
    main()
