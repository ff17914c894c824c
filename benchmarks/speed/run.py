"""`python benchmarks/speed/run.py [--json]`: what the core costs, against plain C and against NumPy, in one run.

Processor time of this thread throughout; the two sides of a ratio are timed in turn. Needs the `railcli` package; the C
twin also gcc, and is left out where there is none.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from benchmarks.speed import c_twin, equality, numpy_twin  # noqa: E402
from railcli.analysis.build_table import build_table  # noqa: E402
from railcli.analysis.warm import warm_tables  # noqa: E402
from railcli.files.profiles import load_profile  # noqa: E402
from railcli.files.provenance import provenance  # noqa: E402
from railcli.files.scenario import load  # noqa: E402
from railcli.kernels.stages import Stage, repeat  # noqa: E402
from railcli.model.contact_table import TableSettings  # noqa: E402
from railcli.model.submodels import CREEP_LAWS  # noqa: E402
from railcli.model.system import assemble  # noqa: E402
from railcli.runtime import timing  # noqa: E402
from railcli.studies.tables import tables_for  # noqa: E402

SCENARIO = "curve-1200-45"
ROUNDS = 15
PASS = 5e6  # processor time of one measurement [ns], about
COMPARED = (Stage.SUSPENSION, Stage.CONTACT, Stage.CREEP)
NUMPY_CALLS = 20
STARTS = 5
HELP = "import sys; sys.argv = ['railcli', '--help']; from railcli.cli import main; main()"
FIRST_STEP = f"""
from railcli.files.scenario import load
from railcli.studies.tables import tables_for
from railcli.kernels.step import advance
from railcli.model.system import assemble
scenario = load("{SCENARIO}")
system = assemble(scenario, tables_for(scenario))
raise SystemExit(int(advance(system.model, system.start(), 1)))
"""


def cpu_ns(call):
    """Processor time of a call [ns]."""
    began = time.thread_time_ns()
    call()
    return time.thread_time_ns() - began


def figures(values, factor=1.0):
    """Least and median of measured values, in another unit."""
    return {"min": min(values) * factor, "median": statistics.median(values) * factor}


def ratio(above, below):
    """Least over least, and the median over rounds."""
    rounds = [a / b for a, b in zip(above, below, strict=True)]
    return {"min": min(above) / min(below), "median": statistics.median(rounds)}


def stage_times(course, runners):
    """Processor time of one pass [ns] of each stage by each runner, over ROUNDS in turn.

    Parameters
    ----------
    course : Course
        Whose kept state every measurement starts from.
    runners : dict
        Name to function (model, data, stage, times), and the stages it knows.
    """
    model, data = course.system.model, course.data

    def lasts(run, stage, times):
        course.rewind()
        course.check(run(model, data, stage, 1))
        return cpu_ns(lambda: run(model, data, stage, times)) / times

    tasks = [(name, run, stage) for name, (run, stages) in runners.items() for stage in stages]
    most = course.calls * course.steps - 1
    times = {}
    for name, run, stage in tasks:
        count = round(PASS / max(lasts(run, stage, 500), 10.0))
        times[name, stage] = min(count, most) if stage == Stage.STEP else count
    found = {name: {stage: [] for stage in stages} for name, (_, stages) in runners.items()}
    for _ in range(ROUNDS):
        for name, run, stage in tasks:
            found[name][stage].append(lasts(run, stage, times[name, stage]))
    return found


def law_times(course, scenario, tables):
    """Processor time of one pass [ns] of the creep stage with each creep law at the kept state, over ROUNDS in turn."""
    run, data = repeat.compiled(), course.data
    models = {law: assemble(scenario.varied(contact={"creep_law": law}), tables).model for law in CREEP_LAWS}
    models["fastsim, 50"] = assemble(
        scenario.varied(contact={"creep_law": "fastsim", "fastsim_grid": 50}), tables
    ).model  # fmt: skip

    def lasts(model, times):
        course.rewind()
        course.check(run(model, data, Stage.CREEP, 1))
        return cpu_ns(lambda: run(model, data, Stage.CREEP, times)) / times

    count = {law: round(PASS / lasts(model, 20)) for law, model in models.items()}
    found = {law: [] for law in models}
    for _ in range(ROUNDS):
        for law, model in models.items():
            found[law].append(lasts(model, count[law]))
    return found


def numpy_times(course):
    """Processor time [ns] of one call of the NumPy twin: suspension, and contact with creep."""
    course.rewind()
    model, data = course.system.model, course.kept
    bodies = numpy_twin.kinematics(model, data.q, data.v)
    calls = {
        "suspension": lambda: numpy_twin.suspension(model, bodies, data.damper, equality.HALF_STEP),
        "contact_and_creep": lambda: numpy_twin.contact(model, bodies, data.q, data.v),
    }
    for call in calls.values():
        call()
    return {
        name: [cpu_ns(lambda call=call: [call() for _ in range(NUMPY_CALLS)]) / NUMPY_CALLS for _ in range(ROUNDS)]
        for name, call in calls.items()
    }


def start_times(code):
    """Wall and processor time of a Python process that runs code [s], after one run to warm up.

    Processor time is None where the system does not count that of finished processes.
    """
    wall, cpu = [], []
    for _ in range(1 + STARTS):
        before, began = os.times(), time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
        wall.append(time.perf_counter() - began)
        after = os.times()
        cpu.append(after.children_user + after.children_system - before.children_user - before.children_system)
    return {"wall": figures(wall[1:]), "cpu": figures(cpu[1:]) if any(cpu) else None}


def table_build():
    """Cost of the default contact table, compilation and certificate not counted."""
    wheel, rail = load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail")
    settings = TableSettings(normal="hertz")
    warm_tables(wheel, rail, settings)
    _, facts = build_table(wheel, rail, settings)
    return {
        "positions": facts["positions"],
        "cpu_s": facts["cpu_s"],
        "positions_per_s": facts["positions"] / facts["cpu_s"],
    }


def checked(name, worst):
    """The largest difference from a twin; an error when it is more than rounding."""
    if not worst <= equality.TWIN:
        raise SystemExit(f"error: the core differs from its {name} twin by {worst:.2g}, allowed {equality.TWIN:g}")
    return worst


def measure(folder, say):
    """Everything, ready for JSON."""
    scenario = load(SCENARIO)
    say("contact table ...")
    tables = tables_for(scenario, quiet=True, announce=say)
    timing.prepare(say)
    system = assemble(scenario, tables)
    found = {"scenario": SCENARIO, "equality": {}, "ratio_to_c": None}
    say("equality with the twins ...")
    states = list(equality.states(system))
    found["equality"]["numpy"] = checked("NumPy", max(equality.against_numpy(system, data) for data in states))
    course = timing.run_up(scenario, system, round(1e-3 / float(system.model.param[0]["step"])))
    runners = {"core": (repeat.compiled(), tuple(Stage))}
    if c_twin.compiler():
        c_repeat = c_twin.build(system.model, course.data, folder)
        worst = [max(equality.against_c(system, data, c_repeat).values()) for data in (*states, course.kept)]
        found["equality"]["c"] = checked("C", max(worst))
        runners["c"] = (c_repeat, COMPARED)
    say("stages ...")
    with timing.undisturbed():
        times, slow = stage_times(course, runners), numpy_times(course)
        laws = law_times(course, scenario, tables)
    core = times["core"]
    found["patches"] = course.patches.tolist()
    found["step_ms"] = course.step * 1e3
    found["us_per_simulated_ms"] = figures(core[Stage.STEP], 1e-3 * course.steps)
    found["stages_us"] = {stage.name.lower(): figures(core[stage], 1e-3) for stage in Stage}
    if "c" in times:
        found["c_stages_us"] = {stage.name.lower(): figures(times["c"][stage], 1e-3) for stage in COMPARED}
        found["ratio_to_c"] = {stage.name.lower(): ratio(core[stage], times["c"][stage]) for stage in COMPARED}
    both = [a + b for a, b in zip(core[Stage.CONTACT], core[Stage.CREEP], strict=True)]
    found["numpy_us"] = {name: figures(values, 1e-3) for name, values in slow.items()}
    found["ratio_of_numpy"] = {
        "suspension": ratio(slow["suspension"], core[Stage.SUSPENSION]),
        "contact_and_creep": ratio(slow["contact_and_creep"], both),
    }
    patches = sum(found["patches"])
    first = laws[scenario.contact.creep_law]
    found["creep_law_ns_per_contact"] = {law: figures(values, 1.0 / patches) for law, values in laws.items()}
    found["step_over_first_law"] = {
        law: {key: 1.0 + (value - figures(first)[key]) / figures(core[Stage.STEP])[key]
              for key, value in figures(values).items()}
        for law, values in laws.items()
    }  # fmt: skip
    say("table build ...")
    found["table_build"] = table_build()
    say("start-up ...")
    found["start_s"] = {"help": start_times(HELP), "first_step": start_times(FIRST_STEP)}
    found["machine"] = {**timing.occupation(), **provenance(), "compiler": c_twin.compiler()}
    return found


def table_text(found):
    """The figures for readers."""

    def line(name, value, unit, digits=2):
        return f"  {name:<34}{value['min']:>9.{digits}f}{value['median']:>9.{digits}f}  {unit}"

    machine = found["machine"]
    load_average = machine["load_average"]
    busy = f", load average {load_average[0]:.1f}" if load_average else ""
    rows = [
        f"{machine['cpu']}, {machine['cores']} cores{busy}; Python {machine['python']}, numba {machine['numba']}, "
        f"numpy {machine['numpy']}, {machine['compiler'] or 'no gcc: no C twin'}",
        f"{found['scenario']}, step {found['step_ms']:g} ms, contact patches {found['patches']}",
        *(f"largest difference from the {name} twin: {worst:.1e}" for name, worst in found["equality"].items()),
        f"  {'processor time':<34}{'min':>9}{'median':>9}",
        line("one simulated ms", found["us_per_simulated_ms"], "us"),
        *(line(f"stage {name}", value, "us") for name, value in found["stages_us"].items()),
    ]
    if found["ratio_to_c"]:
        rows += [line(f"{name} in C", value, "us") for name, value in found["c_stages_us"].items()]
        rows += [line(f"{name}: core over C", value, "") for name, value in found["ratio_to_c"].items()]
    rows += [line(f"{name} in NumPy", value, "us", 0) for name, value in found["numpy_us"].items()]
    rows += [line(f"{name}: NumPy over core", value, "", 0) for name, value in found["ratio_of_numpy"].items()]
    rows += [
        line(f"creep stage per contact, {law}", value, "ns", 0)
        for law, value in found["creep_law_ns_per_contact"].items()
    ]
    rows += [line(f"step over the default's, {law}", value, "") for law, value in found["step_over_first_law"].items()]
    build, start = found["table_build"], found["start_s"]
    rows += [
        f"contact table: {build['positions']:,} positions in {build['cpu_s']:.2f} s, {build['positions_per_s']:,.0f}/s",
    ]
    for name, key in (("railcli --help", "help"), ("process to first step, warm", "first_step")):
        rows += [line(f"{name}: {clock}", value, "s", 3) for clock, value in start[key].items() if value]
    return "\n".join(rows)


def main():
    """Measure and print: a table, then one line of JSON; with --json the line alone."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="only the line of JSON")
    only_json = parser.parse_args().json
    with tempfile.TemporaryDirectory() as folder:
        found = measure(folder, lambda text: print(text, file=sys.stderr))
    if not only_json:
        print(table_text(found))
    print(json.dumps(found))


if __name__ == "__main__":
    main()
