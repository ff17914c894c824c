"""Options that several commands share, each with one name, one meaning and one help text."""

from pathlib import Path

import click

format_option = click.option(
    "--format",
    "output_format",
    type=click.Choice(["text", "json"]),
    default="text",
    show_default=True,
    help="Print for a reader or, as one JSON object, for a machine.",
)

overwrite_option = click.option(
    "--overwrite", is_flag=True, help="Replace what railcli wrote there before; other files stay."
)

quiet_option = click.option("-q", "--quiet", is_flag=True, help="No progress on stderr.")


def output_option(default):
    """Decorator for ``-o/--output``.

    Parameters
    ----------
    default : str
        Where the command writes when no place is given, as the help text names it.
    """
    return click.option(
        "-o", "--output", type=click.Path(path_type=Path), metavar="PATH", help=f"Where to write  [default: {default}]"
    )


def results_options(command):
    """Decorator of a command that fills a results folder: format, output, overwrite, quiet."""
    for option in (quiet_option, overwrite_option, output_option("a new folder in railcli-out"), format_option):
        command = option(command)
    return command
