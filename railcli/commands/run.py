"""`railcli run`: run a scenario."""

import click

from railcli.errors import RailcliError


@click.group(short_help="Run a scenario.")
def run():
    """Run a scenario and write a results folder."""


@run.command(short_help="Run a built-in or a TOML scenario.")
@click.argument("scenario", required=False)
def scenario(scenario):
    """Run SCENARIO, the name of a built-in one or a TOML file."""
    raise RailcliError("run scenario: not available yet")
