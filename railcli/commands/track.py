"""`railcli track`: alignment and irregularity, imported, drawn and judged before a run."""

import click

from .completion import SCENARIOS
from .options import Speed, format_option, output_option, overwrite_option
from .terminal import tell
from .track_import import import_
from .track_irregularity import irregularity


@click.group(short_help="Import, draw and judge a track.")
def track():
    """Import, draw and judge a track before a run: its alignment, its irregularity."""


@track.command("show", short_help="Draw an alignment and judge it by EN 13803.")
@click.argument("source", metavar="NAME|FILE", type=SCENARIOS)
@click.option("--speed", type=Speed(0.0, 150.0), metavar="M/S",
              help="Speed at which it is judged, in m/s or as 72kmh  [default: the scenario's]")  # fmt: skip
@output_option("track.png in a new folder in railcli-out")
@overwrite_option
@format_option
def show(source, speed, output, overwrite, output_format):
    """Draw the alignment of a scenario, or of a measured table (CSV), and judge it by EN 13803.

    Draws curvature, cant, gradient, gauge and irregularity along s, prints a table of the sections, and warns where
    cant, cant deficiency or excess, their rates of change, twist or the acceleration in a vertical curve is beyond the
    standard's limits or those of [limits] in the scenario. A table has no speed: give one with --speed.

    \b
    Examples:
      railcli track show s-curve
      railcli track show my-line.toml --speed 40 -o line.svg
      railcli track show measured.csv --speed 30
    """
    from railcli.analysis.alignment import judge
    from railcli.files.output import output_file, results_folder
    from railcli.files.scenario import load_alignment
    from railcli.report import track as report
    from railcli.report.figures import check_format

    if output is not None:
        check_format(output_file(output, overwrite))
    case = load_alignment(source)
    speed = speed or case.speed
    judged = judge(case.track, case.pieces, case.limits, case.cant_base, case.gauge, case.gravity, speed)
    if output is not None:
        report.plot(case.title, case, judged, speed, output)
    else:
        with results_folder("track", case.name) as folder:
            output = folder / "track.png"
            report.plot(case.title, case, judged, speed, output)
    lines = [*report.report(case.title, case, judged, speed), f"Figure: {output}"]
    tell({**report.summary(case.title, case, judged, speed), "figure": output}, lines, output_format)


track.add_command(import_)
track.add_command(irregularity)
