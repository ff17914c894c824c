"""`railcli validate`: compare railcli with published results."""

import click

from .options import results_options
from .terminal import Terminal, show


@click.group(short_help="Compare with published results.")
def validate():
    """Compare railcli with published results."""


@validate.command(short_help="The curve of the Manchester wagon against Simulink and ADAMS.")
@click.option("--sensitivity", is_flag=True, help="Also print the deviations over friction from 0.1 to 0.5.")
@click.option("--disturbance", is_flag=True, help="Also compare track disturbances with a linear vertical model.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def manchester(sensitivity, disturbance, no_figures, output_format, output, overwrite, quiet):
    """Run the published curve of the Manchester wagon (R = 1200 m, cant 90 mm; 45, 30 and 15 m/s).

    Builds or reuses the contact table, prints the twelve published displacements beside railcli's, the force balances
    and the verdict, and writes validation.md, .json, .csv and figures. Exit code 0: accepted, 4: not.

    With --disturbance it also runs the wagon over small bumps and waves and compares wheel forces and the car body's
    acceleration with a linear vertical model, in time and frequency; then over bumps at which wheels lift, and over
    lateral disturbances. These criteria count too.

    Example: railcli validate manchester --disturbance -o my-validation
    """
    more = {"sensitivity": sensitivity, "disturbance": disturbance}
    _compare("manchester", no_figures, output_format, output, overwrite, quiet, **more)


@validate.command(short_help="A curve of 150 m and a hunting wagon against other programs.")
@click.option("--creep-law", metavar="NAME", help="Creep law of both comparisons  [default: of their scenarios]")
@click.option("--normal", metavar="NAME", help="Normal law of both comparisons  [default: of their scenarios]")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def curves(creep_law, normal, no_figures, output_format, output, overwrite, quiet):
    """Compare steady curving at R = 150 m with ADAMS and Universal Mechanism, and the Cooperrider wagon's hunting.

    The Manchester wagon in a curve of 150 m, by Newton's method, with what the published table leaves open varied one
    by one; decay and hunting of the Cooperrider wagon on straight track; the curve of 1200 m beside them. Builds or
    reuses contact tables, prints values, deviations, criteria and the verdict, and writes validation.md, .json, .csv
    and figures. Exit code 0: accepted, 4: not.

    \b
    Examples:
      railcli validate curves -o my-validation
      railcli validate curves --normal hertz --creep-law fastrip
    """
    from railcli.model.submodels import CREEP_LAWS, NORMAL_LAWS, choose

    for option, registry, given in (("--creep-law", CREEP_LAWS, creep_law), ("--normal", NORMAL_LAWS, normal)):
        if given is not None:
            choose(registry, option, given)
    _compare("curves", no_figures, output_format, output, overwrite, quiet, creep_law=creep_law, normal=normal)


@validate.command(short_help="Equivalent conicity against the tables of EN 15302.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def conicity(no_figures, output_format, output, overwrite, quiet):
    """Compare equivalent conicity with the reference wheels A and H on rail A of EN 15302, and with cones.

    Prints conicity beside the tables of both editions, criteria and the verdict, and writes validation.json, .csv and a
    figure. Exit code 0: accepted, 4: not.

    Example: railcli validate conicity -o my-validation
    """
    _compare("conicity", no_figures, output_format, output, overwrite, quiet)


@validate.command(short_help="Brakes, adhesion, slide protection against closed forms and tables.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def braking(no_figures, output_format, output, overwrite, quiet):
    """Compare stops of the Manchester wagon with closed forms, a table of stops and the ETCS conversion model.

    Stops on dry, wet and low adhesion with and without slide protection, by a reduced model that has what the table has
    and by the whole wagon; where the energy went; the creep force of the adhesion sets; load transfer; braking in a
    curve. Prints values, criteria and the verdict, and writes validation.md, .json, .csv and figures. Exit code 0:
    accepted, 4: not.

    Example: railcli validate braking -o my-validation
    """
    _compare("braking", no_figures, output_format, output, overwrite, quiet)


@validate.command(short_help="Hertz, Kalker, creep laws and the Manchester contact benchmark.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def contact(no_figures, output_format, output, overwrite, quiet):
    """Compare the wheel-rail contact with closed forms, with CONTACT and with the Manchester contact benchmark.

    Hertz's solution, Kalker's coefficients, every creep law, case A-2.2 of the benchmark with every combination of
    normal and creep law, and every normal law against half spaces on elements. Builds or reuses the benchmark's contact
    tables, prints deviations beside the spread that is known of other methods, criteria and the verdict, and writes
    validation.md, .json, .csv and figures. Exit code 0: accepted, 4: not.

    Example: railcli validate contact -o my-validation
    """
    _compare("contact", no_figures, output_format, output, overwrite, quiet)


def _compare(name, no_figures, output_format, output, overwrite, quiet, **options):
    from railcli.files.output import results_folder
    from railcli.studies.validate import validate as study

    with results_folder("validate", name, output, overwrite) as folder:
        answer, rejection = study(name, folder, not no_figures, Terminal(quiet), **options)
    show(answer, output_format)
    if rejection:
        raise rejection
