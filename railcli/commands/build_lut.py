"""`railcli build-lut`: build or check a contact table."""

import click

from railcli.errors import RailcliError


@click.command("build-lut", short_help="Build a wheel-rail contact table.")
def build_lut():
    """Build a wheel-rail contact table by minimising the distance of wheel and rail."""
    raise RailcliError("build-lut: not available yet")
