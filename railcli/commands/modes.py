"""`railcli modes`: eigenvalues and mode shapes of a vehicle."""

import click

from .options import results_options
from .vehicle_contact import one_thread, quasi_linear_contact, scenario_of

DEFAULT_SCENARIO = "stability"
LARGEST_AMPLITUDE = 15.0  # [mm]


@click.command(short_help="Eigenmodes of a vehicle.")
@click.argument("scenario", required=False, metavar="[NAME|FILE]")
@click.option("--speed", type=float, metavar="M/S", help="Another speed  [default: the scenario's]")
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
    from railcli.analysis.linear import linearise
    from railcli.analysis.linear import modes as modes_of
    from railcli.analysis.mode_shapes import describe
    from railcli.analysis.quasi_linear import quasi_linear_system
    from railcli.analysis.warm import warm
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.provenance import provenance
    from railcli.files.tables import tables_for
    from railcli.model.system import assemble

    def announce(text):
        if not quiet:
            click.echo(text, err=True)

    case = scenario_of(scenario, DEFAULT_SCENARIO, speed)
    with results_folder("modes", case.name, output, overwrite) as folder:
        warm(announce)
        lines, tables = None, ()
        if amplitude > 0.0:
            lines = quasi_linear_contact(case, [amplitude], quiet)[0]
            system = quasi_linear_system(case, lines)
        else:
            tables = tables_for(case, quiet, announce)
            system = assemble(case, tables)
        found = modes_of(linearise(system, contact=response))
        change = found.shift(linearise(system, scale=2.0))
        shapes = [describe(found, k) for k in range(found.value.size)]

        from railcli.report import modes as report  # only now: drawing libraries take half a second to load

        written = ["modes.json", "modes.csv", "shapes.csv"]
        if not no_figures:
            written += report.figures(case, found, shapes, folder)
        if response:
            from railcli.analysis.response import responses
            from railcli.report import response as picture

            answers = responses(found.linear)
            written.append("response.csv")
            write_text(folder / "response.csv", picture.response_csv(found.linear, answers))
            if not no_figures:
                written += picture.figures(case, found.linear, answers, folder)
        record = report.as_json(case, lines, found, change, shapes, provenance(case, tables), written)
        record["folder"] = folder
        write_json(folder / "modes.json", record)
        write_text(folder / "modes.csv", report.modes_csv(found, shapes))
        write_text(folder / "shapes.csv", report.shapes_csv(found, shapes))
    if output_format == "json":
        click.echo(json_text(record))
        return
    text = report.report(case, lines, found, change, shapes, everything)
    click.echo("\n".join([*text, "", f"Written to {folder}: {', '.join(written)}"]))
