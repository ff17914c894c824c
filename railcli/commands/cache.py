"""`railcli cache`: what is kept to save time, and how to be rid of it."""

import click

from .options import format_option


@click.command(short_help="Show and empty what is kept to save time.")
@click.option("--empty", is_flag=True, help="Delete contact tables, compiled code and what killed commands left there.")
@format_option
def cache(empty, output_format):
    """Show the contact tables and the compiled code that railcli keeps to save time; --empty deletes them.

    Nothing is lost with them but the time to make them again. Of contact tables those that were used last are kept, up
    to 4 GB or what RAILCLI_CACHE_GB says. RAILCLI_CACHE_DIR names another place.
    """
    from railcli.studies import cache as study

    from .terminal import show

    show(study.emptied() if empty else study.shown(), output_format)
