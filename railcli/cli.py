"""The command `railcli`: its commands, and the one place where an error becomes a line and an exit code."""

import sys

import click

from railcli import __version__
from railcli.commands.assess import assess
from railcli.commands.build_lut import build_lut
from railcli.commands.conicity import conicity
from railcli.commands.contact import contact
from railcli.commands.critical_speed import critical_speed
from railcli.commands.diff import diff
from railcli.commands.export import export
from railcli.commands.modes import modes
from railcli.commands.profile import profile
from railcli.commands.report import report
from railcli.commands.rt_bench import rt_bench
from railcli.commands.run import run
from railcli.commands.sweep import sweep
from railcli.commands.track import track
from railcli.commands.validate import validate
from railcli.commands.vehicle import scenario, vehicle
from railcli.errors import RailcliError

INTERRUPTED = 130


def explain(error):
    """Return the one line and the exit code with which an exception leaves the command.

    Parameters
    ----------
    error : BaseException
        What ended the command.

    Returns
    -------
    message : str
        One line for stderr.
    exit_code : int
        130 for Ctrl-C, that of the class for errors of railcli, 2 for an output that cannot be written, else 1.
    """
    if isinstance(error, KeyboardInterrupt):
        return " ".join(["Interrupted.", *map(str, error.args)]).strip(), INTERRUPTED
    if isinstance(error, OSError):
        from railcli.files.output import is_refusal, refusal

        if is_refusal(error):
            error = refusal(error.filename or "output", error)
    if isinstance(error, RailcliError):
        return f"Error: {error}", error.exit_code
    text = " ".join(str(error).split())
    return (
        f"Error: {type(error).__name__}: {text} - this is a fault of railcli; "
        "`railcli --debug COMMAND ...` shows the traceback",
        RailcliError.exit_code,
    )


class RailGroup(click.Group):
    """A group that lists its commands in the order of use and lets no traceback out unasked."""

    def list_commands(self, ctx):
        return list(self.commands)

    def invoke(self, ctx):
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
            return result
        except (click.ClickException, click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except (Exception, KeyboardInterrupt) as error:
            if ctx.params["debug"]:
                import traceback

                traceback.print_exc()
            message, exit_code = explain(error)
            click.echo(message, err=True)
            ctx.exit(exit_code)


@click.group(cls=RailGroup)
@click.version_option(__version__, message="%(prog)s %(version)s")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
def main(debug):
    """Railway vehicle dynamics in real time: contact tables, runs, benchmarks, validation."""


for _command in (
    profile, build_lut, contact, conicity, track, vehicle, scenario, run, sweep, assess, report, diff, export, modes,
    critical_speed, rt_bench, validate,
):  # fmt: skip
    main.add_command(_command)
