"""`railcli run`: run a scenario."""

import click

from .options import results_options

DEFAULT_SCENARIO = "curve-1200-45"


@click.group(short_help="Run a scenario.")
def run():
    """Run a scenario and write a results folder."""


@run.command(short_help="Run a built-in or a TOML scenario.")
@click.argument("scenario", required=False, metavar="[NAME|FILE]")
@click.option("--list", "only_list", is_flag=True, help="List the built-in scenarios and stop.")
@click.option("--speed", type=float, metavar="M/S", help="Another speed  [default: the scenario's]")
@click.option("--friction", type=float, metavar="NUMBER", help="Another friction  [default: the scenario's]")
@click.option("--step", type=float, metavar="MS", help="Another time step  [default: the scenario's, or chosen]")
@click.option("--contact", multiple=True, default=("*",), metavar="GLOB",
              help="Channels of contact patches to record, such as '*/normal'; none: none  [default: all]")  # fmt: skip
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@click.option("--no-assessment", is_flag=True, help="Leave the assessment out.")
@results_options
def scenario(
    scenario, only_list, speed, friction, step, contact, no_figures, no_assessment, output_format, output, overwrite,
    quiet,
):  # fmt: skip
    """Run a scenario: a built-in one or a TOML file; without it, the 1200 m curve at 45 m/s.

    Writes time series (HDF5), the main channels (CSV), summary.json, scenario.json and figures, and prints the steady
    values of the wheelsets over the last metres and a short assessment (`railcli assess` gives the whole one).

    \b
    Examples:
      railcli run scenario
      railcli run scenario curve-300 -o tight-curve
      railcli run scenario my-curve.toml --speed 30
    """
    from railcli.files.scenario import builtin_scenarios, load, varied

    if only_list:
        scenarios = builtin_scenarios()
        width = max(len(name) for name in scenarios)
        for name, title in scenarios.items():
            click.echo(f"{name.ljust(width)}  {title}")
        return
    changes = {"speed_m_per_s": ("run", speed), "step_ms": ("run", step), "friction": ("contact", friction)}
    case = load(scenario or DEFAULT_SCENARIO)
    for key, (group, value) in changes.items():
        if value is not None:
            case = varied(case, group, key, value)
    record, lines, fault = _run(case, contact, not no_figures, not no_assessment, output, overwrite, quiet)
    if output_format == "json":
        from railcli.files.output import json_text

        click.echo(json_text(record))
    else:
        click.echo("\n".join(lines))
    if fault:
        from railcli.errors import SimulationError

        raise SimulationError(f"{case.name}: {fault}; what was computed is in {record['folder']}")


def _run(case, contact_channels, with_figures, with_assessment, output, overwrite, quiet):
    from railcli.analysis import steady_values
    from railcli.analysis.simulate import SteadyWindow, simulate
    from railcli.analysis.step_choice import with_step
    from railcli.analysis.vibration import Listener, vibration
    from railcli.analysis.warm import warm
    from railcli.analysis.watch import Watch
    from railcli.files import inputs, results
    from railcli.files.output import results_folder, write_json
    from railcli.files.progress import Progress
    from railcli.files.provenance import provenance
    from railcli.files.tables import tables_for
    from railcli.model.system import assemble

    def announce(text):
        if not quiet:
            click.echo(text, err=True)

    with results_folder("run", case.name, output, overwrite) as folder:
        warm(announce)
        tables = tables_for(case, quiet, announce)
        case, system, choice = with_step(case, assemble(case, tables))
        window = SteadyWindow(case.distance - case.average_over)
        listener = Listener(system.model.wheel.size, window.start)
        watch = Watch(system)
        series = results.TimeSeries(folder / results.TIME_SERIES, system, contact_channels)
        inputs.save(case, folder / inputs.INPUTS)
        write_json(folder / inputs.SCENARIO, case.as_dict())

        def sink(rows):
            series(rows)
            window(rows)
            watch(rows)

        def filtered_sink(block):
            series.filtered(block)
            listener(block)

        try:
            with series, Progress("Run", case.duration, "s", quiet) as progress:
                outcome = simulate(
                    case,
                    system,
                    sink,
                    lambda time, factor: progress.update(time, f"{factor:.0f} x real time"),
                    filtered_sink,
                )
        except KeyboardInterrupt:
            raise KeyboardInterrupt(series.kept()) from None

        from railcli.report import run as report  # only now: drawing libraries take half a second to load
        from railcli.report import step

        stretch = steady_values.final_stretch(case)
        steady = None
        if stretch is not None and window.count and not outcome.fault:
            steady = steady_values.End(
                mean=steady_values.means(system, stretch, window),
                swing=steady_values.peaks_to_peaks(system, stretch, window),
                newton=steady_values.solved(system, stretch, case.final_speed),
                balance=steady_values.expected_forces(case, stretch),
                traction=float(window.mean("traction")),
                weight_along=steady_values.weight_along(case, stretch),
                vibration=None if case.irregularity else vibration(system, window, listener),
            )
        files = [inputs.SCENARIO, inputs.INPUTS]
        if outcome.rows:
            results.write_main_channels(results.pieces(folder / results.TIME_SERIES), folder / results.MAIN_CHANNELS)
            files += [results.TIME_SERIES, results.MAIN_CHANNELS]
            if with_figures:
                files += report.figures(case, results.envelope(folder / results.TIME_SERIES), folder)
        record = report.summary(case, outcome, stretch, steady, provenance(case, tables), files, step.as_json(choice))
        record["alternation"] = watch.warning
        lines = report.report(case, outcome, stretch, steady, step.words(choice))
        if case.irregularity:
            from railcli.analysis.irregularity_spectrum import bands, of_scenario
            from railcli.report import irregularity

            rails = of_scenario(case)
            rows = bands(rails)
            record["irregularity"] = irregularity.as_json(rails, rows)
            lines += ["", *irregularity.in_a_run(rails, rows)]
        if watch.warning:
            lines += ["", f"Warning: {watch.warning}"]
        record["folder"] = folder
        if with_assessment and outcome.rows:
            record["assessment"], judged = _assessment(folder, outcome.fault)
            lines += ["", *judged]
        write_json(folder / "summary.json", record)
    written = f"Written to {folder}: {', '.join(files)}, summary.json"
    return record, [*lines, "", written], outcome.fault


def _assessment(folder, fault):
    """Of the results as they are written: what summary.json holds of it, and lines for the terminal."""
    from railcli.analysis.assess import assess
    from railcli.errors import InputError
    from railcli.files.read_results import Results
    from railcli.report import assess as report

    try:
        with Results(folder) as results:
            outcome = assess(results, fault=fault)
    except InputError as error:
        return {"error": str(error)}, [f"No assessment: {error}"]
    return report.for_summary(outcome), report.short(outcome, f"railcli assess {folder}")
