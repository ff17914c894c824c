"""`railcli rt-bench`: time the compiled model against a real-time budget."""

import click

from railcli.errors import RailcliError


@click.command("rt-bench", short_help="Time the model against a real-time budget.")
def rt_bench():
    """Time the compiled model against a real-time budget."""
    raise RailcliError("rt-bench: not available yet")
