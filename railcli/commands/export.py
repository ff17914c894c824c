"""`railcli export`: a result for other programs."""

from pathlib import Path

import click

from .options import format_option, output_option, overwrite_option, quiet_option
from .terminal import tell

CHOICES = ("csv", "parquet", "mat")


def kind_of(to, output):
    """Format to write: the one asked for, else that of the file's ending, else CSV."""
    ending = output.suffix[1:].lower() if output else ""
    if output and ending not in CHOICES and not to:
        raise click.BadParameter(f"{output}: end it with .csv, .parquet or .mat, or say --to", param_hint="'-o'")
    return to or ending or "csv"


@click.command(short_help="A result as CSV, Parquet or MAT.")
@click.argument("results", metavar="RESULTS", type=click.Path(path_type=Path))
@click.option("--to", type=click.Choice(CHOICES), help="Format  [default: the output's ending, else csv]")
@click.option("--channel", "patterns", multiple=True, metavar="GLOB", help="Channels to write; may be repeated.")
@click.option("--filtered", is_flag=True, help="The low-passed rows that are assessed, instead of the recorded ones.")
@click.option("--list", "only_list", is_flag=True, help="List the channels with unit and meaning, and stop.")
@output_option("a new folder in railcli-out")
@overwrite_option
@format_option
@quiet_option
def export(results, to, patterns, filtered, only_list, output, overwrite, output_format, quiet):
    """Write the time series of a results folder as CSV, Parquet or MAT, with units.

    Columns are named like `wheels/W1_right/Q [N]`. --channel takes globs, whose * crosses slashes too.

    \b
    Examples:
      railcli export results --list
      railcli export results --channel 'wheels/*/[YQ]' --channel 'bodies/car body/*' -o forces.parquet
      railcli export results --to mat
      railcli export results --filtered --channel '*/Q' -o q.csv
    """
    from railcli.files.columns import chosen_rows, columns
    from railcli.files.export import export as write
    from railcli.files.output import output_file, results_folder
    from railcli.files.progress import Progress
    from railcli.files.read_results import Results
    from railcli.report.export import listing

    kind = kind_of(to, output)
    with Results(results) as opened:
        run = chosen_rows(opened, filtered)
        chosen = columns(run, patterns)
        record = {
            "results": run.folder,
            "rows": run.rows,
            "columns": [{"name": one.name, "unit": one.units, "meaning": one.description} for one in chosen],
        }
        if only_list:
            tell(record, listing(run, chosen), output_format)
            return

        def fill(path):
            with Progress("Export", run.rows, "rows", quiet) as progress:
                write(run, chosen, path, kind, progress.update)
            return path

        if output:
            path = fill(output_file(output, overwrite))
        else:
            name = run.folder.resolve().name
            with results_folder("export", name) as folder:
                path = fill(folder / f"{name}.{kind}")
    record |= {"file": path, "bytes": path.stat().st_size}
    summary = f"{run.rows:,} rows of {len(chosen)} columns, {record['bytes'] / 1e6:.1f} MB, written to {path}"
    tell(record, [summary], output_format)
