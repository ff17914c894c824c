"""`railcli critical-speed`: where a vehicle begins to hunt, and where it ceases to."""

import re
from pathlib import Path

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
    help="Of the speeds at which hunting ends, ceases to count and keeps the limit of sum Y.",
)  # fmt: skip
@click.option(
    "--threshold", type=click.FloatRange(0.02, 10.0), default=0.1, show_default=True, metavar="MM",
    help="Lateral amplitude up to which a wheelset does not hunt.",
)  # fmt: skip
@click.option(
    "--counts", type=click.FloatRange(0.02, 20.0), default=1.0, show_default=True, metavar="MM",
    help="Lateral amplitude of a wheelset from which on a limit cycle counts.",
)  # fmt: skip
@click.option("--limits", type=click.Path(path_type=Path), metavar="FILE",
              help="TOML file with other limits, as of railcli assess (sum_Y_factor, stability_share).")  # fmt: skip
@click.option("--no-ramp", is_flag=True, help="Linear part only.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def critical_speed(
    scenario, amplitude, speeds, start, resolution, threshold, counts, limits, no_ramp, no_figures, output_format,
    output, overwrite, quiet,
):  # fmt: skip
    """Critical speed of a vehicle on straight level track, linear and non-linear.

    Linear: roots over speed with quasi-linear contact, for each lateral amplitude. Non-linear: time runs of the
    compiled model whose speed falls step by step from a limit cycle until the hunting dies. Tells where the smallest
    limit cycle ends, where one that counts does, where sum Y passes the limit of its rms (EN 14363), and the linear
    speed at 3 mm. Writes critical_speed.json, linear.csv, root_locus.csv, limit_cycles.csv and figures.

    \b
    Examples:
      railcli critical-speed
      railcli critical-speed my-vehicle.toml --amplitude 1-6:0.5 --speeds 20-120:5
      railcli critical-speed straight-60 --from 140 -o hunting
    """
    one_thread()
    from railcli.analysis.stability import USUAL, Measures
    from railcli.analysis.warm import warm
    from railcli.files.limits import load_limits
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.provenance import provenance
    from railcli.files.tables import tables_for
    from railcli.model.assessment import Limits

    def announce(text):
        if not quiet:
            click.echo(text, err=True)

    if counts < threshold:
        raise click.BadParameter(
            f"{counts:g} mm is below the {threshold:g} mm up to which nothing hunts (--threshold); give at least that",
            param_hint="'--counts'",
        )
    wanted, span = sorted({*amplitudes(amplitude), 1e3 * USUAL}), speed_span(speeds)
    bounds = load_limits(limits) if limits else Limits()
    case = scenario_of(scenario, DEFAULT_SCENARIO)
    measures = Measures.of(case, 1e-3 * counts, bounds)
    with results_folder("critical-speed", case.name, output, overwrite) as folder:
        warm(announce)
        tables = () if no_ramp else tables_for(case, quiet, announce)
        lines = quasi_linear_contact(case, wanted, quiet)
        loci = _linear(case, lines, span, quiet)

        from railcli.report import stability as report  # only now: drawing libraries take half a second to load

        cycles, interrupted, fault, time_step = [], False, None, None
        if not no_ramp:
            begin = start or report.start_of_ramp(loci, span, ABOVE)
            ends = resolution, 1e-3 * threshold, measures
            system = _hunting(case, tables, (span[0], begin))
            time_step = float(system.model.param[0]["step"])
            interrupted, fault = _ramp(case, system, begin, span, ends, cycles, quiet)
        written = ["critical_speed.json", "linear.csv", "root_locus.csv"]
        write_text(folder / "linear.csv", report.linear_csv(lines, loci))
        write_text(folder / "root_locus.csv", report.locus_csv(loci))
        if cycles:
            written.append("limit_cycles.csv")
            write_text(folder / "limit_cycles.csv", report.cycles_csv(cycles))
        if not no_figures:
            written += report.figures(case, loci, cycles, measures, folder)
        record = report.as_json(
            case, lines, loci, cycles, 1e-3 * threshold, measures, time_step, provenance(case, tables), written
        )  # fmt: skip
        record["folder"] = folder
        write_json(folder / "critical_speed.json", record)
    if interrupted:
        raise KeyboardInterrupt(f"The limit cycles down to {cycles[-1].speed:g} m/s are in {folder}." if cycles else "")
    if output_format == "json":
        click.echo(json_text(record))
    else:
        text = report.report(case, lines, loci, cycles, measures, time_step)
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


def _hunting(case, tables, speeds):
    """The system whose hunting is looked at, with half of the step that a usual run would take unless one is given.

    A wheelset that is thrown aside at high speed strikes its flange harder than the choice of a step reckons with.
    """
    from railcli.analysis.step_choice import with_step
    from railcli.model.system import assemble

    _, system, choice = with_step(case, assemble(case, tables), speeds)
    return system.stepped(0.5 * choice.step) if choice.chosen else system


def _ramp(case, system, start, span, ends, cycles, quiet):
    """Gather limit cycles; returns whether Ctrl-C stopped it and what fault did."""
    from railcli.analysis.stability import ramp
    from railcli.errors import SimulationError
    from railcli.files.progress import Progress

    low, _, step = span
    try:
        with Progress("Limit cycles", start - low, "m/s", quiet) as progress:
            for cycle in ramp(system, start, step, low, case.start.lateral or ASIDE, *ends):
                cycles.append(cycle)
                progress.update(start - cycle.speed, f"{cycle.speed:g} m/s, {cycle.largest * 1e3:.2f} mm")
    except KeyboardInterrupt:
        return True, None
    except SimulationError as error:
        return False, error
    return False, None
