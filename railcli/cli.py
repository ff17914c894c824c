"""The command `railcli`: its commands, and the one place where an error becomes a line and an exit code."""

import sys
from contextlib import contextmanager, suppress

import click

from railcli import __version__, interruption
from railcli.commands.assess import assess
from railcli.commands.build_lut import build_lut
from railcli.commands.cache import cache
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
from railcli.errors import RailcliError, RailcliWarning, harmless

PURPOSES = {  # which commands belong together, in the order of use
    "Contact and track": (profile, build_lut, contact, conicity, track),
    "Vehicles and runs": (vehicle, scenario, run, sweep, modes, critical_speed),
    "Results": (assess, report, diff, export),
    "Trust and speed": (validate, rt_bench, cache),
}


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
        130 for Ctrl-C (143 for SIGTERM, 129 for SIGHUP), whatever it made fail; that of the class for errors of
        railcli; 2 for an output that cannot be written; else 1.
    """
    if isinstance(error, KeyboardInterrupt) or interruption.heard():
        told = error.args if isinstance(error, KeyboardInterrupt) else ()
        return " ".join([interruption.sentence(), *map(str, told)]).strip(), interruption.exit_code()
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
    """A group that lists its commands by purpose and lets no traceback out unasked."""

    def list_commands(self, ctx):
        return list(self.commands)

    def format_commands(self, ctx, formatter):
        width = max(len(name) for name in self.commands)
        for purpose, commands in PURPOSES.items():
            with formatter.section(purpose):
                rows = [(each.name.ljust(width), each.get_short_help_str(formatter.width)) for each in commands]
                formatter.write_dl(rows)

    def make_context(self, *args, **extra):
        try:
            return super().make_context(*args, **extra)
        except KeyboardInterrupt as error:
            message, exit_code = explain(error)
            _tell(message)
            sys.exit(exit_code)

    def invoke(self, ctx):
        import warnings

        with warnings.catch_warnings():
            warnings.filterwarnings("always", category=RailcliWarning)
            warnings.showwarning = lambda message, *_: _tell(f"Warning: {' '.join(str(message).split())}")
            with _heard_announcements():
                return self._invoke(ctx)

    def _invoke(self, ctx):
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
            return result
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except BrokenPipeError:
            if not interruption.heard():
                raise
            ctx.exit(interruption.exit_code())
        except (Exception, KeyboardInterrupt) as error:
            if ctx.params["debug"]:
                import traceback

                traceback.print_exc()
            message, exit_code = explain(error)
            _tell(message)
            ctx.exit(exit_code)


def _tell(message):
    """A line on stderr, if anyone is left there to read it."""
    with suppress(OSError, ValueError):
        click.echo(harmless(message), err=True)


@contextmanager
def _heard_announcements():
    """Tell on stderr what readers of files tell to the logger of railcli."""
    import logging

    logger, handler = logging.getLogger("railcli"), logging.Handler()
    handler.emit = lambda record: _tell(record.getMessage())
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)


@click.group(cls=RailGroup)
@click.version_option(__version__, message="%(prog)s %(version)s")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
def main(debug):
    """Railway vehicle dynamics in real time: contact tables, runs, benchmarks, validation."""


for _commands in PURPOSES.values():
    for _command in _commands:
        main.add_command(_command)
