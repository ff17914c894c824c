"""`railcli track`: look at a track before a run."""

import click

from .track_irregularity import irregularity


@click.group(short_help="Look at a track: irregularity.")
def track():
    """Look at a track before a run."""


track.add_command(irregularity)
