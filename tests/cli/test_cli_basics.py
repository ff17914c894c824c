"""The command line before any command: help, version, and how errors leave."""

import errno
import json

import click
import pytest
from click.testing import CliRunner

import railcli
from railcli import errors
from railcli.cli import main


@pytest.fixture
def fail(monkeypatch):
    """Function that runs `railcli [OPTIONS] fail`, a command that raises the given exception."""

    def run(error, *options):
        @click.command()
        def command():
            raise error

        monkeypatch.setitem(main.commands, "fail", command)
        return CliRunner().invoke(main, [*options, "fail"], prog_name="railcli")

    return run


def test_help_lists_the_commands_in_order_of_use():
    result = CliRunner().invoke(main, ["--help"])
    assert result.exit_code == 0
    lines = result.stdout.partition("Contact and track:\n")[2].splitlines()
    assert [line.split()[0] for line in lines if line.startswith("  ")] == list(main.commands) == [
        "profile", "build-lut", "contact", "conicity", "track", "vehicle", "scenario", "run", "sweep", "modes",
        "critical-speed", "assess", "report", "diff", "export", "validate", "rt-bench", "cache",
    ]  # fmt: skip


@pytest.mark.parametrize("arguments", [["run", "scenario"], ["validate", "manchester"], ["build-lut"], ["rt-bench"]])
def test_each_command_has_help(arguments):
    result = CliRunner().invoke(main, [*arguments, "--help"])
    assert result.exit_code == 0
    assert "Usage:" in result.stdout


def test_version():
    result = CliRunner().invoke(main, ["--version"], prog_name="railcli")
    assert (result.exit_code, result.stdout) == (0, f"railcli {railcli.__version__}\n")


def test_misspelt_command_gets_the_near_one():
    result = CliRunner().invoke(main, ["bild-lut"])
    assert (result.exit_code, result.stdout) == (2, "")
    assert "build-lut" in result.stderr


def test_misspelt_option_is_a_usage_error():
    result = CliRunner().invoke(main, ["--versoin"])
    assert (result.exit_code, result.stdout) == (2, "")


@pytest.mark.parametrize(
    "error, exit_code, line",
    [
        (errors.RailcliError("no"), 1, "Error: no"),
        (errors.InputError("curve.toml: mass_kg", "-3"), 2, "Error: curve.toml: mass_kg: -3"),
        (errors.SimulationError("t = 1.2 s: W1 left"), 3, "Error: t = 1.2 s: W1 left"),
        (errors.CheckError("row 3"), 4, "Error: row 3"),
        (KeyboardInterrupt(), 130, "Interrupted."),
    ],
)
def test_error_is_one_line_and_an_exit_code(fail, error, exit_code, line):
    result = fail(error)
    assert (result.exit_code, result.stdout, result.stderr) == (exit_code, "", line + "\n")


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EACCES, errno.EROFS, errno.EPERM])
def test_output_that_cannot_be_written_is_named(fail, number):
    result = fail(OSError(number, "text of the system", "out/summary.json"))
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("Error: out/summary.json: cannot be written: ")
    assert result.stderr.count("\n") == 1


def test_fault_of_railcli_is_one_line_that_says_so(fail):
    result = fail(ZeroDivisionError("division\nby zero"))
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr.startswith("Error: ZeroDivisionError: division by zero")
    assert "fault of railcli" in result.stderr and "--debug" in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("error, exit_code", [(ZeroDivisionError("zero"), 1), (errors.InputError("a", "b"), 2)])
def test_debug_shows_the_traceback_and_keeps_the_exit_code(fail, error, exit_code):
    result = fail(error, "--debug")
    assert (result.exit_code, result.stdout) == (exit_code, "")
    assert "Traceback" in result.stderr and "raise error" in result.stderr


def test_results_before_an_error_stay_valid_json(monkeypatch):
    @click.command()
    def command():
        click.echo(json.dumps({"accepted": False}))
        raise errors.CheckError("row 3")

    monkeypatch.setitem(main.commands, "check", command)
    result = CliRunner().invoke(main, ["check"])
    assert result.exit_code == 4
    assert json.loads(result.stdout) == {"accepted": False}


PROCESS = """
import signal
import click
from railcli.cli import main

@main.command()
def interrupted():
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.raise_signal(signal.SIGINT)

@main.command()
def closed():
    raise BrokenPipeError(32, "Broken pipe")

main(prog_name="railcli")
"""


def test_ctrl_c_ends_the_process_with_130(run_python):
    result = run_python(PROCESS, "interrupted")
    assert (result.returncode, result.stdout, result.stderr) == (130, "", "Interrupted.\n")


def test_closed_pipe_is_silent(run_python):
    assert run_python(PROCESS, "closed").stderr == ""
