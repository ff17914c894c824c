"""`railcli modes`: eigenvalues and mode shapes of a vehicle."""

import click

from .completion import SCENARIOS
from .options import Speed, results_options
from .terminal import Terminal, show
from .vehicle_contact import one_thread, scenario_of

DEFAULT_SCENARIO = "stability"
LARGEST_AMPLITUDE = 15.0  # [mm]


@click.command(short_help="Eigenmodes of a vehicle.")
@click.argument("scenario", required=False, metavar="[NAME|FILE]", type=SCENARIOS)
@click.option(
    "--speed", type=Speed(), metavar="M/S", help="Another speed, in m/s or as 72kmh  [default: the scenario's]"
)
@click.option(
    "--amplitude",
    type=click.FloatRange(0.0, LARGEST_AMPLITUDE),
    default=3.0,
    show_default=True,
    metavar="MM",
    help="Lateral amplitude over which the contact is made linear; 0: differences of the contact table at y = 0.",
)
@click.option("--all", "everything", is_flag=True, help="Print strongly damped modes and those above 50 Hz too.")
@click.option("--response", is_flag=True, help="Frequency response to displaced rails too: response.csv and a figure.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def modes(scenario, speed, amplitude, everything, response, no_figures, output_format, output, overwrite, quiet):
    """Eigenfrequencies, damping ratios and mode shapes of a vehicle that rolls on straight level track.

    The compiled model is linearised about its steady motion by differences of its state, with quasi-linear contact of
    one lateral amplitude. Writes modes.json, modes.csv, shapes.csv and figures.

    \b
    Examples:
      railcli modes
      railcli modes straight-60 --speed 40 --response
      railcli modes my-vehicle.toml --amplitude 0 --all -o modes
    """
    one_thread()
    from railcli.files.output import results_folder
    from railcli.studies.modes import modes as study

    case = scenario_of(scenario, DEFAULT_SCENARIO, speed)
    with results_folder("modes", case.name, output, overwrite) as folder:
        answer = study(case, amplitude, response, everything, folder, not no_figures, Terminal(quiet))
    show(answer, output_format)
