"""`railcli critical-speed`: where a vehicle begins to hunt, and where it ceases to."""

import re

import click

from .conicity import amplitudes
from .options import results_options
from .vehicle_contact import one_thread, quasi_linear_contact, scenario_of

DEFAULT_SCENARIO = "stability"
SLOWEST, FASTEST = 2.0, 150.0  # [m/s]
ABOVE = 1.1  # start of the ramp over the highest linear critical speed
ASIDE = 5e-3  # lateral displacement of a ramp whose scenario has none [m]


def speed_span(text):
    """Speeds [m/s] of `10-150:5`: lowest, highest, step."""
    span = re.fullmatch(r"\s*([\d.]+)\s*-\s*([\d.]+)\s*:\s*([\d.]+)\s*", text)
    try:
        low, high, step = map(float, span.groups())
    except (AttributeError, ValueError):
        low = high = step = 0.0
    if not (SLOWEST <= low < high <= FASTEST and 0.5 <= step <= high - low):
        raise click.BadParameter(
            f"{text!r}: give LOW-HIGH:STEP such as 10-150:5; {SLOWEST:g} to {FASTEST:g} m/s, steps of 0.5 or more",
            param_hint="'--speeds'",
        )
    return low, high, step


@click.command("critical-speed", short_help="Critical speed and limit cycles of a vehicle.")
@click.argument("scenario", required=False, metavar="[NAME|FILE]")
@click.option(
    "--amplitude", default="0.5,1,2,3,4,5,6", show_default=True, metavar="MM",
    help="Of the linear part, as 1-6:0.5 or 2,3.",
)  # fmt: skip
@click.option("--speeds", default="10-150:5", show_default=True, metavar="M/S", help="Range of speeds and their step.")
@click.option(
    "--from", "start", type=click.FloatRange(SLOWEST, FASTEST), metavar="M/S",
    help="Speed from which the ramp falls  [default: 10 % above the highest linear critical speed]",
)  # fmt: skip
@click.option(
    "--resolution", type=click.FloatRange(0.05, 10.0), default=0.5, show_default=True, metavar="M/S",
    help="Of the speed at which the hunting ends.",
)  # fmt: skip
@click.option(
    "--threshold", type=click.FloatRange(0.02, 10.0), default=0.1, show_default=True, metavar="MM",
    help="Lateral amplitude up to which a wheelset does not hunt.",
)  # fmt: skip
@click.option("--no-ramp", is_flag=True, help="Linear part only.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def critical_speed(
    scenario, amplitude, speeds, start, resolution, threshold, no_ramp, no_figures, output_format, output, overwrite,
    quiet,
):  # fmt: skip
    """Critical speed of a vehicle on straight level track, linear and non-linear.

    Linear: roots over speed with quasi-linear contact, for each lateral amplitude. Non-linear: time runs of the
    compiled model whose speed falls step by step from a limit cycle until the hunting dies. Writes
    critical_speed.json, linear.csv, root_locus.csv, limit_cycles.csv and figures.

    \b
    Examples:
      railcli critical-speed
      railcli critical-speed my-vehicle.toml --amplitude 1-6:0.5 --speeds 20-120:5
      railcli critical-speed straight-60 --from 140 -o hunting
    """
    one_thread()
    from railcli.analysis.warm import warm
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.provenance import provenance
    from railcli.files.tables import tables_for

    def announce(text):
        if not quiet:
            click.echo(text, err=True)

    wanted, span = amplitudes(amplitude), speed_span(speeds)
    case = scenario_of(scenario, DEFAULT_SCENARIO)
    with results_folder("critical-speed", case.name, output, overwrite) as folder:
        warm(announce)
        tables = () if no_ramp else tables_for(case, quiet, announce)
        lines = quasi_linear_contact(case, wanted, quiet)
        loci = _linear(case, lines, span, quiet)

        from railcli.report import stability as report  # only now: drawing libraries take half a second to load

        cycles, interrupted, fault = [], False, None
        if not no_ramp:
            begin = start or report.start_of_ramp(loci, span, ABOVE)
            interrupted, fault = _ramp(case, tables, begin, span, (resolution, 1e-3 * threshold), cycles, quiet)
        written = ["critical_speed.json", "linear.csv", "root_locus.csv"]
        write_text(folder / "linear.csv", report.linear_csv(lines, loci))
        write_text(folder / "root_locus.csv", report.locus_csv(loci))
        if cycles:
            written.append("limit_cycles.csv")
            write_text(folder / "limit_cycles.csv", report.cycles_csv(cycles))
        if not no_figures:
            written += report.figures(case, loci, cycles, folder)
        record = report.as_json(case, lines, loci, cycles, 1e-3 * threshold, provenance(case, tables), written)
        record["folder"] = folder
        write_json(folder / "critical_speed.json", record)
    if interrupted:
        raise KeyboardInterrupt(f"The limit cycles down to {cycles[-1].speed:g} m/s are in {folder}." if cycles else "")
    if output_format == "json":
        click.echo(json_text(record))
    else:
        text = report.report(case, lines, loci, cycles, not no_ramp)
        click.echo("\n".join([*text, "", f"Written to {folder}: {', '.join(written)}"]))
    if fault:
        raise fault


def _linear(case, lines, span, quiet):
    import numpy as np

    from railcli.analysis.quasi_linear import quasi_linear_system
    from railcli.analysis.stability import locus
    from railcli.files.progress import Progress

    low, high, step = span
    speeds = low + step * np.arange(int((high - low) / step + 1e-9) + 1)
    loci, done = [], 0

    def one_more():
        nonlocal done
        done += 1
        progress.update(done)

    with Progress("Roots", len(lines) * speeds.size, "speeds", quiet) as progress:
        for line in lines:
            if line[0].flange:
                loci.append(None)
            else:
                loci.append(locus(quasi_linear_system(case, line), line[0].amplitude, speeds, one_more))
    return loci


def _ramp(case, tables, start, span, limits, cycles, quiet):
    """Gather limit cycles; returns whether Ctrl-C stopped it and what fault did."""
    from railcli.analysis.stability import ramp
    from railcli.analysis.step_choice import with_step
    from railcli.errors import SimulationError
    from railcli.files.progress import Progress
    from railcli.model.system import assemble

    low, _, step = span
    system = with_step(case, assemble(case, tables), (low, start)).system
    try:
        with Progress("Limit cycles", start - low, "m/s", quiet) as progress:
            for cycle in ramp(system, start, step, low, case.start.lateral or ASIDE, *limits):
                cycles.append(cycle)
                progress.update(start - cycle.speed, f"{cycle.speed:g} m/s, {cycle.largest * 1e3:.2f} mm")
    except KeyboardInterrupt:
        return True, None
    except SimulationError as error:
        return False, error
    return False, None
