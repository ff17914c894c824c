"""`railcli report`: results as a page for people."""

from pathlib import Path

import click

from .options import results_options
from .terminal import Terminal, show

MOST = 6  # results, as many as there are colours


@click.command(short_help="Results as one page with figures, assessment and animation.")
@click.argument("results", nargs=-1, required=True, metavar="RESULTS...", type=click.Path(path_type=Path))
@click.option("--limits", type=click.Path(path_type=Path), metavar="FILE", help="TOML file with other limits.")
@click.option("--no-assessment", is_flag=True, help="Do not judge the results.")
@click.option("--picture", type=click.Choice(["png", "svg"]), default="png", show_default=True, help="Of the figures.")
@click.option("--animate", is_flag=True, help="Show each run as a moving picture too.")
@click.option("--film", type=click.Choice(["page", "gif", "mp4"]), help="Its form; implies --animate  [default: page]")
@click.option("--frames", type=click.IntRange(2, 2000), default=200, show_default=True, metavar="N", help="Of it.")
@click.option("--magnify", type=click.FloatRange(0.0, 1e5, min_open=True), metavar="X", help="Of its displacements.")
@click.option("--wheelset", type=click.IntRange(1), default=1, show_default=True, metavar="N", help="In its close-ups.")
@results_options
def report(
    results, limits, no_assessment, picture, animate, film, frames, magnify, wheelset,
    output_format, output, overwrite, quiet,
):  # fmt: skip
    """Make one self-contained HTML page of one or several results folders, and a folder of its figures.

    Track, motions of the wheelsets, forces, creepages, contact, accelerations, spectra, assessment, largest and steady
    values, settings that differ and provenance. Several results (at most six) stand side by side in the tables and over
    one another in the figures.

    \b
    Examples:
      railcli report railcli-out/run-curve-300-1
      railcli report before after --picture svg -o comparison
      railcli report railcli-out/run-curve-300-1 --animate
    """
    from functools import partial

    from railcli.files.limits import load_limits
    from railcli.files.output import results_folder
    from railcli.studies.report import Film
    from railcli.studies.report import report as study

    if len(results) > MOST:
        raise click.BadParameter(f"{len(results)} results: at most {MOST} fit on a page", param_hint="'RESULTS'")
    bounds = load_limits(limits) if limits else None
    shown = Film(film or "page", frames, magnify, wheelset) if film or animate else None
    place = partial(results_folder, "report", output=output, overwrite=overwrite, reads=results)
    answer = study(results, place, bounds, not no_assessment, picture, shown, Terminal(quiet))
    show(answer, output_format)
