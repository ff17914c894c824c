"""`railcli vehicle` and `railcli scenario`: a vehicle shown before it runs; built-in files copied to begin with."""

from pathlib import Path

import click

from railcli.errors import harmless

from .completion import SCENARIOS, VEHICLES
from .options import format_option, output_option, overwrite_option, quiet_option
from .terminal import Terminal, show
from .vehicle_contact import one_thread


@click.group(short_help="Show a vehicle before it runs; copy a built-in one.")
def vehicle():
    """Show a vehicle before it runs; copy a built-in one."""


@vehicle.command("show", short_help="Masses, axle loads, preloads, frequencies and a drawing.")
@click.argument("name", metavar="NAME|FILE", type=VEHICLES)
@click.option("--no-modes", is_flag=True, help="Find no suspension frequencies.")
@output_option("vehicle.png in a new folder in railcli-out")
@overwrite_option
@quiet_option
@format_option
def show_(name, no_modes, output, overwrite, quiet, output_format):
    """Masses, centre of gravity, axle loads and preloads at rest, suspension frequencies, and a drawing of a vehicle.

    NAME is a built-in vehicle (manchester, y25-empty, y25-laden, locomotive), FILE a TOML file. The frequencies are
    those of `railcli modes` at 20 m/s on straight track with ORES1002 on UIC60. The drawing shows it from the side,
    from above and from behind; only wheels, axles and the places of bodies are true to scale.

    \b
    Examples:
      railcli vehicle show y25-laden
      railcli vehicle show my.toml -o my.svg
    """
    one_thread()
    from railcli.files.output import output_file, results_folder
    from railcli.files.scenario import load_vehicle
    from railcli.report.figures import check_format
    from railcli.studies.vehicle import show as study

    if output is not None:
        check_format(output_file(output, overwrite))
    found, voice = load_vehicle(name), Terminal(quiet)
    if output is not None:
        answer = study(found, output, not no_modes, voice)
    else:
        with results_folder("vehicle", Path(name).stem) as folder:
            answer = study(found, folder / "vehicle.png", not no_modes, voice)
    show(answer, output_format)


@vehicle.command("copy", short_help="Copy the file of a built-in vehicle.")
@click.argument("name", metavar="NAME", type=VEHICLES)
@click.argument("file", type=click.Path(path_type=Path))
@overwrite_option
def copy_vehicle(name, file, overwrite):
    """Copy the file of a built-in vehicle, to begin your own with.

    \b
    Example:
      railcli vehicle copy manchester my.toml
    """
    _copy("vehicle", name, file, overwrite)


@click.group(short_help="Copy a built-in scenario.")
def scenario():
    """Copy a built-in scenario; `railcli run scenario` runs one."""


@scenario.command("copy", short_help="Copy the file of a built-in scenario.")
@click.argument("name", metavar="NAME", type=SCENARIOS)
@click.argument("file", type=click.Path(path_type=Path))
@overwrite_option
def copy_scenario(name, file, overwrite):
    """Copy the file of a built-in scenario, to begin your own with; it names its vehicle.

    \b
    Example:
      railcli scenario copy curve-300 my-curve.toml
    """
    _copy("scenario", name, file, overwrite)


def _copy(kind, name, file, overwrite):
    from railcli.files.output import output_file
    from railcli.studies.vehicle import copied

    copied(kind, name, output_file(file, overwrite))
    click.echo(harmless(f"Written: {file}"))
