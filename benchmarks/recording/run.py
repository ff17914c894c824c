"""`python benchmarks/recording/run.py [SCENARIO]`: what it costs to gather every step (docs/benchmarks.md).

Steps alone, with rows every 10 ms, and with the low-passed stream besides, in turn from one state of the end of a run;
processor time of the thread, ratios of the least values and the median of the rounds' ratios. Needs the `railcli`
package; takes half a minute.
"""

import os
import sys
import time
from pathlib import Path

for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402

sys.path.insert(0, str(Path(__file__).parents[2]))

from railcli.analysis.faults import copied  # noqa: E402
from railcli.analysis.simulate import settled_start  # noqa: E402
from railcli.analysis.step_choice import with_step  # noqa: E402
from railcli.files.scenario import DEFAULT_SCENARIO, load  # noqa: E402
from railcli.kernels.recording import forget_done, new_rows, new_stream  # noqa: E402
from railcli.kernels.step import advance, record_rows  # noqa: E402
from railcli.model.low_pass import low_pass  # noqa: E402
from railcli.model.system import assemble  # noqa: E402
from railcli.studies.tables import tables_for  # noqa: E402

INTERVAL = 10e-3  # of rows [s]
ROWS, ROUNDS = 50, 300
RUN_IN = 10.0  # [s]


def main():
    """Print the table."""
    case = load(sys.argv[1] if len(sys.argv) > 1 else DEFAULT_SCENARIO)
    case, system, choice = with_step(case, assemble(case, tables_for(case)))
    model, stride = system.model, round(INTERVAL / choice.step)
    start = settled_start(system)
    advance(model, start, round(RUN_IN / choice.step))
    rows, none = new_rows(model, ROWS), new_stream(model)
    stream = new_stream(model, *low_pass(choice.step)[::-1], ROWS * stride)

    def streamed(data):
        forget_done(stream)
        record_rows(model, data, rows, stream, stride)

    ways = {
        "steps alone": lambda data: advance(model, data, ROWS * stride),
        "rows": lambda data: record_rows(model, data, rows, none, stride),
        "rows and stream": streamed,
    }
    taken = {name: [] for name in ways}
    for _ in range(ROUNDS):
        for name, way in ways.items():
            data = copied(start)
            began = time.thread_time_ns()
            way(data)
            taken[name].append(1e-3 * (time.thread_time_ns() - began) / (ROWS * stride))
    alone = np.array(taken["steps alone"])
    print(f"{case.name}, step {1e3 * choice.step:g} ms, rows every {1e3 * INTERVAL:g} ms\n")
    print("| | us per step, least | ratio of the least | median of ratios |\n|---|---|---|---|")
    for name, values in taken.items():
        values = np.array(values)
        ratio, median = values.min() / alone.min(), np.median(values / alone)
        print(f"| {name} | {values.min():.2f} | {ratio:.3f} | {median:.3f} |")


if __name__ == "__main__":
    main()
