"""`python benchmarks/sweep/run.py`: what the runs of a parameter study cost.

Four aims: 200 quasi-static runs in 20 s of processor time, all processes and their start included; time runs for at
most 1.3 times the processor time of their steps; two processes 1.8 times as fast as one; a process below 400 MB.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from railcli.files.study import load_study  # noqa: E402
from railcli.files.sweep import keep  # noqa: E402
from railcli.studies.sweep import one_run  # noqa: E402
from railcli.studies.sweep.processes import Processes  # noqa: E402
from railcli.studies.sweep.study import planned, record_of  # noqa: E402
from railcli.studies.voice import SILENT  # noqa: E402

AIMS = {"quasi-static": 20.0, "time runs": 1.3, "two processes": 1.8, "memory": 400.0}
Q = [{"channel": "wheels/*/Q"}]
FRICTION = [{"key": "contact.friction", "from": 0.2, "to": 0.4, "count": 12}]
LENGTH = [{"key": "run.distance_m", "values": [1000.0]}]
KINDS = {  # study of time runs on random track, 1000 m at 50 m/s
    "seeds, wheel loads": {"vary": LENGTH, "seeds": 12, "channel": Q},
    "friction, wheel loads": {"vary": FRICTION, "channel": Q},
    "seeds, assessment": {"vary": LENGTH, "seeds": 12, "outputs": ["assessment.*"]},
    "friction, assessment": {"vary": FRICTION, "outputs": ["assessment.*"]},
}
CODE = "from railcli.cli import main; import sys; main(sys.argv[1:], prog_name='railcli')"


def quasi_static(scenario, runs):
    """Processor time of a whole command [s], largest memory of one of its processes [MB]."""
    vary = [f"--vary=contact.friction=0.2:0.4:{runs // 10}", "--vary=run.speed_m_per_s=18:22:10"]
    if scenario != "curve-300":
        vary[1] = "--vary=run.speed_m_per_s=35:45:10"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        words = ["sweep", scenario, *vary, "--quasi-static", "--workers=1", "-q", "--no-figures", "-o", folder + "/s"]
        subprocess.run([sys.executable, "-c", CODE, *words], check=True, stdout=subprocess.DEVNULL)
        rows = [json.loads(line) for line in open(f"{folder}/s/rows.jsonl", encoding="utf-8")]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {
        "runs": len(rows), "failed": sum(row["status"] == "failed" for row in rows), "cpu_s": cpu,
        "run_s": statistics.median(row["cpu_s"] for row in rows), "memory_MB": after.ru_maxrss / 1e3,
    }  # fmt: skip


def time_runs(kind):
    """Processor time of runs over that of their steps, the least and the median, of all but the first run."""
    plan = planned(*load_study("random-track", KINDS[kind]))
    runner, steps, simulate = one_run.Runner(plan.given), [], one_run.simulate

    def told(*arguments):
        outcome = simulate(*arguments)
        steps.append(outcome.cpu_s)
        return outcome

    one_run.simulate = told
    try:
        spent = [runner.row(*plan.task(number))["cpu_s"] for number in range(plan.design.count)]
    finally:
        one_run.simulate = simulate
    ratios = [run / step for run, step in zip(spent[1:], steps[1:], strict=True)]
    return {"least": min(ratios), "median": statistics.median(ratios), "steps_s": statistics.median(steps)}


def rate(count, runs):
    """Runs in a second by so many processes, from when each has made some; own processor time of a run [s]."""
    plan = planned(*load_study("random-track", {"vary": LENGTH, "seeds": runs, "channel": Q}))
    with tempfile.TemporaryDirectory() as folder:
        keep(Path(folder), record_of(plan), plan.given.scenario)
        with Processes(Path(folder), count, SILENT) as hands:
            seen, began = 0, None
            for _ in hands.rows(map(plan.task, range(runs))):
                seen += 1
                if seen == 2 * count:
                    began, own = time.perf_counter(), time.process_time()
            spent, own = time.perf_counter() - began, time.process_time() - own
    return (runs - 2 * count) / spent, own / (runs - 2 * count)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=200, help="quasi-static ones")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    found = {"load_average": os.getloadavg()[0], "processors": os.cpu_count(), "aims": AIMS}
    for scenario in ("curve-1200-45", "curve-300"):
        each = [quasi_static(scenario, options.runs) for _ in range(options.repeats)]
        found[f"quasi-static, {scenario}"] = min(each, key=lambda one: one["cpu_s"])
    for kind in KINDS:
        found[f"time runs, {kind}"] = time_runs(kind)
    pairs = [(rate(1, 40), rate(2, 40)) for _ in range(options.repeats)]
    found["two processes over one"] = {
        "best": max(two[0] / one[0] for one, two in pairs), "runs_per_s": [(one[0], two[0]) for one, two in pairs],
        "handing_out_s": min(two[1] for _, two in pairs),
    }  # fmt: skip
    found["load_average_after"] = os.getloadavg()[0]
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
