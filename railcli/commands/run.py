"""`railcli run`: run a scenario."""

import click

from .completion import SCENARIOS
from .options import Speed, results_options
from .terminal import Terminal, show, tell

DEFAULT_SCENARIO = "curve-1200-45"


@click.group(short_help="Run a scenario.")
def run():
    """Run a scenario and write a results folder."""


@run.command(short_help="Run a built-in or a TOML scenario.")
@click.argument("scenario", required=False, metavar="[NAME|FILE]", type=SCENARIOS)
@click.option("--list", "only_list", is_flag=True, help="List the built-in scenarios and stop.")
@click.option(
    "--speed", type=Speed(), metavar="M/S", help="Another speed, in m/s or as 72kmh  [default: the scenario's]"
)
@click.option("--friction", type=float, metavar="NUMBER", help="Another friction  [default: the scenario's]")
@click.option("--step", type=float, metavar="MS", help="Another time step  [default: the scenario's, or chosen]")
@click.option("--guest", type=click.Path(), metavar="FILE",
              help="A controller of yours for valves and motors: a Python file (docs/subsystems.md, 10)")  # fmt: skip
@click.option("--contact", multiple=True, default=("*",), metavar="GLOB",
              help="Channels of contact patches to record, such as '*/normal'; none: none  [default: all]")  # fmt: skip
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@click.option("--no-assessment", is_flag=True, help="Leave the assessment out.")
@results_options
def scenario(
    scenario, only_list, speed, friction, step, guest, contact, no_figures, no_assessment, output_format, output,
    overwrite, quiet,
):  # fmt: skip
    """Run a scenario: a built-in one or a TOML file; without it, the 1200 m curve at 45 m/s.

    Writes time series (HDF5), the main channels (CSV), summary.json, scenario.json and figures, and prints the steady
    values of the wheelsets over the last metres and a short assessment (`railcli assess` gives the whole one).

    \b
    Examples:
      railcli run scenario
      railcli run scenario curve-300 -o tight-curve
      railcli run scenario my-curve.toml --speed 108kmh
      railcli run scenario my-brake.toml --guest my_protection.py
    """
    from railcli.files.scenario import builtin_scenarios, load

    if only_list:
        scenarios = builtin_scenarios()
        width = max(len(name) for name in scenarios)
        tell(scenarios, [f"{name.ljust(width)}  {title}" for name, title in scenarios.items()], output_format)
        return
    from railcli.errors import SimulationError
    from railcli.files.changes import changed
    from railcli.files.output import results_folder
    from railcli.studies.run import run as run_scenario

    given = {"run.speed_m_per_s": speed, "run.step_ms": step, "contact.friction": friction}
    changes = {key: value for key, value in given.items() if value is not None}
    case = load(scenario or DEFAULT_SCENARIO)
    case = changed(case, changes) if changes else case
    with results_folder("run", case.name, output, overwrite) as folder:
        answer = run_scenario(case, folder, contact, not no_figures, not no_assessment, Terminal(quiet), guest)
    show(answer, output_format)
    if answer["fault"]:
        raise SimulationError(f"{case.name}: {answer['fault']}; what was computed is in {folder}")
