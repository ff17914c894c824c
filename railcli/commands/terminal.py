"""What a study tells, on stderr."""

import click

from railcli.errors import harmless
from railcli.studies.voice import Voice


class Terminal(Voice):
    """Announcements and progress unless quiet; warnings always."""

    def __init__(self, quiet=False):
        self._quiet = quiet

    def announce(self, text):
        if not self._quiet:
            click.echo(harmless(text), err=True)

    def warn(self, text):
        click.echo(harmless(f"Warning: {text}"), err=True)

    def job(self, title, total, unit):
        from railcli.files.progress import Progress

        return Progress(title, total, unit, self._quiet)


def show(answer, output_format):
    """Print an Answer for a reader or for a machine."""
    tell(answer.record, answer.lines, output_format)


def tell(record, lines, output_format):
    """Print a record for a machine, or lines for a reader."""
    from railcli.files.output import json_text

    click.echo(json_text(record) if output_format == "json" else harmless("\n".join(lines)))
