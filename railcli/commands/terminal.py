"""What a study tells, on stderr."""

import click

from railcli.studies.voice import Voice


class Terminal(Voice):
    """Announcements and progress unless quiet; warnings always."""

    def __init__(self, quiet=False):
        self._quiet = quiet

    def announce(self, text):
        if not self._quiet:
            click.echo(text, err=True)

    def warn(self, text):
        click.echo(f"Warning: {text}", err=True)

    def job(self, title, total, unit):
        from railcli.files.progress import Progress

        return Progress(title, total, unit, self._quiet)


def show(answer, output_format):
    """Print an Answer for a reader or for a machine."""
    from railcli.files.output import json_text

    click.echo(json_text(answer.record) if output_format == "json" else "\n".join(answer.lines))
