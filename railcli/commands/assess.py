"""`railcli assess`: judge results of runs."""

from pathlib import Path

import click

from .options import results_options
from .terminal import Terminal, show


@click.command(short_help="Judge results: forces, ride, comfort, wear, stability.")
@click.argument("results", nargs=-1, required=True, metavar="RESULTS...", type=click.Path(path_type=Path))
@click.option("--limits", type=click.Path(path_type=Path), metavar="FILE", help="TOML file with other limits.")
@click.option("--check", is_flag=True, help="End with exit code 4 when a figure fails or a run broke off.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def assess(results, limits, check, no_figures, output_format, output, overwrite, quiet):
    """Judge one or more results folders of `railcli run scenario`.

    Forms Y/Q, sums of guiding forces, wheel loads and unloading, accelerations on the floor, comfort (N_MV, Sperling),
    wear numbers and stability, prints them against their limits, and writes assessment.json, sections.csv and a figure.
    What a run is too short or too coarsely recorded for is said, not guessed. docs/assessment.md defines every figure.

    \b
    Examples:
      railcli assess railcli-out/run-curve-300-1
      railcli assess before after --limits my-limits.toml --check
    """
    from railcli.errors import CheckError
    from railcli.files.limits import load_limits
    from railcli.files.output import results_folder
    from railcli.studies.assess import assess as study
    from railcli.studies.assess import names_of

    bounds = load_limits(limits) if limits else None
    with results_folder("assess", names_of(results)[0], output, overwrite, results) as folder:
        answer, failed = study(results, bounds, folder, not no_figures, Terminal(quiet))
    show(answer, output_format)
    if check and failed:
        raise CheckError(f"over the limits, or broken off: {', '.join(failed)}")
