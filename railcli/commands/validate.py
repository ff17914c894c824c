"""`railcli validate`: compare the model with published results."""

import click

from railcli.errors import RailcliError


@click.group(short_help="Compare the model with published results.")
def validate():
    """Compare the model with published results."""


@validate.command(short_help="The Manchester wagon in a curve, three speeds.")
def manchester():
    """Run the Manchester passenger wagon in a 1200 m curve at three speeds and compare its wheelset positions."""
    raise RailcliError("validate manchester: not available yet")
