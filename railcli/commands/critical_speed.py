"""`railcli critical-speed`: where a vehicle begins to hunt, and where it ceases to."""

import re
from pathlib import Path

import click

from .completion import SCENARIOS
from .conicity import amplitudes
from .options import Speed, results_options
from .terminal import Terminal, show
from .vehicle_contact import one_thread, scenario_of

DEFAULT_SCENARIO = "stability"
SLOWEST, FASTEST = 2.0, 150.0  # [m/s]


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
@click.argument("scenario", required=False, metavar="[NAME|FILE]", type=SCENARIOS)
@click.option(
    "--amplitude", default="0.5,1,2,3,4,5,6", show_default=True, metavar="MM",
    help="Of the linear part, as 1-6:0.5 or 2,3.",
)  # fmt: skip
@click.option("--speeds", default="10-150:5", show_default=True, metavar="M/S", help="Range of speeds and their step.")
@click.option(
    "--from", "start", type=Speed(SLOWEST, FASTEST), metavar="M/S",
    help="Speed from which the ramp falls, or as 288kmh  [default: 10 % above the highest linear critical speed]",
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
    from railcli.files.limits import load_limits
    from railcli.files.output import results_folder
    from railcli.model.assessment import Limits
    from railcli.studies.critical_speed import Ramp, Span
    from railcli.studies.critical_speed import critical_speed as study

    if counts < threshold:
        raise click.BadParameter(
            f"{counts:g} mm is below the {threshold:g} mm up to which nothing hunts (--threshold); give at least that",
            param_hint="'--counts'",
        )
    wanted, span = amplitudes(amplitude), Span(*speed_span(speeds))
    how = Ramp(start, resolution, 1e-3 * threshold, 1e-3 * counts, load_limits(limits) if limits else Limits())
    case = scenario_of(scenario, DEFAULT_SCENARIO)
    with results_folder("critical-speed", case.name, output, overwrite) as folder:
        answer, fault = study(case, wanted, span, how, no_ramp, folder, not no_figures, Terminal(quiet))
    show(answer, output_format)
    if fault:
        raise fault
