"""`railcli rt-bench`: time the compiled model against a real-time budget."""

import click

from railcli.errors import InputError

from .completion import SCENARIOS
from .options import results_options
from .terminal import Terminal, tell

FEWEST_CALLS = 1000  # so that p99.9 is a measured value
MOST_CALLS = 10_000_000  # whose times fit into memory
STEPS = (1e-3, 2.0)  # shortest and longest [ms]


@click.command("rt-bench", short_help="Time the model against a real-time budget.")
@click.argument("scenario", required=False, metavar="[NAME|FILE]", type=SCENARIOS)
@click.option("--step", type=float, metavar="MS", help="Time step.  [default: the scenario's, or chosen]")
@click.option(
    "--budget",
    type=float,
    default=1.0,
    show_default=True,
    metavar="MS",
    help="Simulated time that each call advances, and wall time that it may take; a multiple of the step.",
)
@click.option(
    "--duration", type=float, default=10.0, show_default=True, metavar="S", help="Simulated time of the timed calls."
)
@click.option(
    "--warmup", type=float, default=1.0, show_default=True, metavar="S", help="Simulated time of the calls before them."
)
@click.option(
    "--paced/--back-to-back",
    default=False,
    help="Begin each call when the clock says so, or as soon as the last one ended.  [default: back to back]",
)
@click.option(
    "--spin",
    type=float,
    default=0.0,
    show_default=True,
    metavar="US",
    help="Paced: sleep only until so long before a call is due, then watch the clock.",
)
@click.option(
    "--realtime", is_flag=True, help="Ask for real-time scheduling and locked memory; says what the system grants."
)
@click.option("--figures/--no-figures", default=True, help="Draw the histogram and the stages.  [default: figures]")
@results_options
def rt_bench(
    scenario, step, budget, duration, warmup, paced, spin, realtime, figures, output, overwrite, quiet, output_format
):
    """Time the compiled model, all contacts loaded, against a real-time budget.

    The vehicle of a built-in scenario or a TOML file (default: the curve of 1200 m radius at 45 m/s) runs up until all
    of it stands in the curve. From there on the wall time of each call is taken. Where the scenario ends, the calls go
    on from the state before the first one.

    \b
    Examples:
      railcli rt-bench
      railcli rt-bench curve-300 --step 0.25 --duration 60
      railcli rt-bench --paced --realtime --format json
    """
    from railcli.files.output import results_folder
    from railcli.files.scenario import DEFAULT_SCENARIO, load
    from railcli.report.timing import summary
    from railcli.runtime.timing import steps_per_call
    scenario = load(scenario or DEFAULT_SCENARIO)
    run = scenario.duration * 1e3
    _check_range("--budget", budget, 0.0 < budget <= run, f"above 0 and at most the {run:.4g} ms of the run")
    if step is not None:
        _check_range("--step", step, STEPS[0] <= step <= STEPS[1], "from {:g} to {:g} ms".format(*STEPS))
        scenario = scenario.varied(run={"step": step * 1e-3, "output_interval": step * 1e-3})
    if scenario.run.step is not None:
        steps_per_call(budget * 1e-3, scenario.run.step)
    count = _calls("--duration", duration, budget, FEWEST_CALLS)
    warm_up = _calls("--warmup", warmup, budget, 0)
    _check_range("--spin", spin, 0.0 <= spin <= budget * 1e3, f"from 0 to the {budget * 1e3:g} us of the budget")
    if spin and not paced:
        raise InputError("--spin", "is for calls paced by the clock; add --paced")
    with results_folder("rt-bench", scenario.name, output, overwrite) as folder:
        found, samples = _measure(scenario, budget * 1e-3, count, warm_up, spin if paced else None, realtime, quiet)
        found = {"folder": folder, **found}
        _write(found, samples, folder, figures)
    tell(found, [*summary(found), f"Results: {folder}"], output_format)


def _check_range(option, value, fits, allowed):
    if not fits:
        raise InputError(option, f"must be {allowed}, got {value:g}")


def _calls(option, seconds, budget, fewest):
    """How many calls last so long."""
    shortest, longest = fewest * budget * 1e-3, MOST_CALLS * budget * 1e-3
    allowed = f"from {shortest:g} s ({fewest:,} calls of {budget:g} ms) to {longest:g} s ({MOST_CALLS:,} calls)"
    _check_range(option, seconds, shortest * (1.0 - 1e-9) <= seconds <= longest * (1.0 + 1e-9), allowed)
    return round(seconds / (budget * 1e-3))


def _measure(scenario, budget, count, warm_up, spin, realtime, quiet):
    """Everything that is measured: the facts, and the times of the calls [us] for histograms."""
    from railcli.analysis.step_choice import with_step
    from railcli.files.progress import Progress
    from railcli.files.provenance import provenance
    from railcli.model.system import assemble
    from railcli.report.step import as_json
    from railcli.report.text import conditions_json
    from railcli.runtime import pacing, timing
    from railcli.studies.tables import tables_for

    voice = Terminal(quiet)
    tables = tables_for(scenario, voice)
    timing.prepare(voice.announce)
    scenario, system, choice = with_step(scenario, assemble(scenario, tables), interval=budget)
    steps = timing.steps_per_call(budget, scenario.run.step)
    begin, _ = timing.stretch(scenario, system.rest)
    with Progress("Run up", float(begin), "m", quiet) as progress:
        course = timing.run_up(scenario, system, steps, progress.update)
    metronome = None if spin is None else pacing.Metronome(round(course.period * 1e9), round(spin * 1e3))
    occupation = timing.occupation()
    with pacing.real_time(realtime) as granted:
        cost = timing.describe_cost(course)
        if metronome:
            voice.announce(f"Paced by the clock: this takes {(warm_up + count) * course.period:.3g} s ...")
        timing.time_calls(course, warm_up, metronome)
        with Progress("Calls", count, "calls", quiet or metronome is not None) as progress:
            calls = timing.time_calls(course, count, metronome, progress.update)
        found = {
            **timing.describe_calls(calls, course.period),
            **cost,
            "warm_up_calls": warm_up,
            "real_time": {"asked": realtime, "scheduling": granted.scheduling, "memory": granted.memory},
            "machine": occupation,
            "clocks": timing.clocks(),
        }
    found = {
        "scenario": scenario.name,
        "title": scenario.title,
        "speed_ms": scenario.run.speed,
        **conditions_json(scenario),
        **found,
        **timing.describe_course(course, count),
        "step": as_json(choice),
        "provenance": provenance(scenario, tables),
    }
    samples = {"call": calls.compute / 1e3}
    if calls.paced:
        samples |= {"wake_up": calls.wake_up / 1e3, "wake_up_and_call": calls.response / 1e3}
    return found, samples


def _write(found, samples, folder, figures):
    from railcli.files.output import write_json, write_text
    from railcli.report import timing

    write_text(folder / "histogram.csv", timing.histogram_csv(samples))
    if figures:
        timing.plot_histogram(found, samples, folder / "histogram.png")
        timing.plot_stages(found, folder / "stages.png")
    write_json(folder / "rt-bench.json", found)
