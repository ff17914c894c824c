"""`railcli validate`: compare railcli with published results."""

import click

from .options import results_options
from .terminal import Terminal


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
    from railcli.analysis.disturbance import compare_disturbance
    from railcli.analysis.validate import compare_manchester
    from railcli.analysis.warm import warm
    from railcli.errors import CheckError
    from railcli.files.benchmark import manchester_criteria, manchester_reference
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.progress import Progress
    from railcli.files.provenance import provenance
    from railcli.files.scenario import load
    from railcli.report import disturbance as disturbances
    from railcli.report import validation
    from railcli.studies.tables import tables_for

    voice = Terminal(quiet)

    reference, criteria = manchester_reference(), manchester_criteria()
    scenarios = [load(f"curve-1200-{speed:g}") for speed in reference.speeds]
    other = scenarios[0].varied(contact={"inclination": 40.0})
    with results_folder("validate", "manchester", output, overwrite) as folder:
        warm(voice.announce)
        tables = tables_for(scenarios[0], voice)
        other_tables = tables_for(other, voice)
        with Progress("Validate", 30, "steps", quiet) as progress:
            result = compare_manchester(
                reference, criteria, scenarios, tables, (other, other_tables), progress.update
            )
        record = validation.as_json(scenarios[0], result, provenance(scenarios[0], tables))
        sections = validation.report(scenarios[0], result, sensitivity)
        rows, names = result.rows, validation.FIGURES
        if disturbance:
            with Progress("Disturbance", 100, "%", quiet) as progress:
                response = compare_disturbance(
                    scenarios[0], tables, criteria, lambda share, text: progress.update(round(100 * share), text)
                )
            rows, names = rows + response.rows, names + disturbances.FIGURES
            record["disturbance"] = disturbances.as_json(response)
            sections[-1:-1] = disturbances.sections(response)
        validation.judged(record, sections, rows)
        write_json(folder / "validation.json", record)
        write_text(folder / "validation.csv", validation.csv(result))
        write_text(folder / "validation.md", validation.markdown(sections, record, () if no_figures else names))
        if not no_figures:
            validation.figures(result, folder)
            if disturbance:
                disturbances.figures(response, folder)
    if output_format == "json":
        click.echo(json_text(record))
    else:
        click.echo(validation.terminal(sections, record))
        click.echo(f"Written to {folder}")
    missed = [row[0] for row in rows if row[5] and not row[4]]
    if missed:
        raise CheckError(f"validate manchester: rejected ({'; '.join(missed)})")


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
    from railcli.analysis.curves_check import compare_curves
    from railcli.analysis.curving_check import NOMINAL
    from railcli.analysis.warm import warm
    from railcli.errors import CheckError
    from railcli.files.curves_reference import curves_criteria, curves_reference, curves_scenarios, wheelset_of
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.progress import Progress
    from railcli.files.provenance import provenance
    from railcli.model.submodels import CREEP_LAWS, NORMAL_LAWS, choose
    from railcli.report import curves_validation as report
    from railcli.studies.tables import tables_for

    voice = Terminal(quiet)

    laws = {}
    for key, option, registry, name in (
        ("creep_law", "--creep-law", CREEP_LAWS, creep_law), ("normal", "--normal", NORMAL_LAWS, normal)
    ):  # fmt: skip
        if name is not None:
            choose(registry, option, name)
            laws[key] = name
    reference, criteria = curves_reference(), curves_criteria()
    curve, wagon, wide = curves_scenarios(laws)
    with results_folder("validate", "curves", output, overwrite) as folder:
        warm(voice.announce)
        with Progress("Validate", 100, "%", quiet) as progress:
            result = compare_curves(
                reference, criteria, curve, wagon, wheelset_of(wagon), wide,
                lambda case: tables_for(case, Terminal(quiet=True)),
                lambda share, text: progress.update(round(100 * share), text),
            )  # fmt: skip
        origin = provenance(result.curves[NOMINAL].scenario)
        record, sections = report.as_json(result, origin), report.report(result)
        write_json(folder / "validation.json", record)
        write_text(folder / "validation.csv", report.csv(result))
        write_text(folder / "validation.md", report.markdown(sections, result, origin, figures=not no_figures))
        if not no_figures:
            report.figures(result, folder)
    if output_format == "json":
        click.echo(json_text(record))
    else:
        click.echo(report.terminal(sections, result))
        click.echo(f"Written to {folder}")
    if not result.accepted:
        missed = [row.name for row in result.rows if row.counts and not row.kept]
        raise CheckError(f"validate curves: rejected ({'; '.join(missed)})")


@validate.command(short_help="Equivalent conicity against the tables of EN 15302.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def conicity(no_figures, output_format, output, overwrite, quiet):
    """Compare equivalent conicity with the reference wheels A and H on rail A of EN 15302, and with cones.

    Prints conicity beside the tables of both editions, criteria and the verdict, and writes validation.json, .csv and a
    figure. Exit code 0: accepted, 4: not.

    Example: railcli validate conicity -o my-validation
    """
    from railcli.analysis.conicity_check import compare_conicity
    from railcli.errors import CheckError
    from railcli.files.conicity_reference import conicity_criteria, reference_profiles, reference_tables
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.progress import Progress
    from railcli.report import conicity as report

    with results_folder("validate", "conicity", output, overwrite) as folder:
        with Progress("Validate", 100, "%", quiet) as progress:
            result = compare_conicity(
                reference_profiles(), reference_profiles(digitised=True), reference_tables(), conicity_criteria(),
                lambda share: progress.update(round(100 * share)),
            )  # fmt: skip
        record = report.validation_json(result)
        write_json(folder / "validation.json", record)
        write_text(folder / "validation.csv", report.validation_csv(result))
        if not no_figures:
            report.validation_plot(result, folder / "conicity.png")
    if output_format == "json":
        click.echo(json_text(record))
    else:
        click.echo("\n".join(report.validation_lines(result)))
        click.echo(f"Written to {folder}")
    if not result.accepted:
        missed = [row.name for row in result.rows if row.counts and not row.kept]
        raise CheckError(f"validate conicity: rejected ({'; '.join(missed)})")


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
    from railcli.analysis.contact_check import compare_contact
    from railcli.analysis.warm import warm
    from railcli.errors import CheckError
    from railcli.files.contact_reference import benchmark_wheelset, contact_criteria, published
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.progress import Progress
    from railcli.files.provenance import provenance
    from railcli.report import contact_figures
    from railcli.report import contact_validation as report
    from railcli.studies.tables import benchmark_tables

    voice = Terminal(quiet)

    reference, criteria = published(), contact_criteria()
    with results_folder("validate", "contact", output, overwrite) as folder:
        warm(voice.announce)
        tables = benchmark_tables(voice)
        with Progress("Validate", 100, "%", quiet) as progress:
            result = compare_contact(
                reference, criteria, benchmark_wheelset(), tables,
                lambda share, text: progress.update(round(100 * share), text),
            )  # fmt: skip
        origin = provenance(tables=tuple(tables.values()))
        record, sections = report.as_json(result, origin), report.report(result)
        write_json(folder / "validation.json", record)
        write_text(folder / "validation.csv", report.csv(result))
        write_text(folder / "validation.md", report.markdown(sections, result, origin, figures=not no_figures))
        if not no_figures:
            contact_figures.figures(result, folder)
    if output_format == "json":
        click.echo(json_text(record))
    else:
        click.echo(report.terminal(sections, result))
        click.echo(f"Written to {folder}")
    if not result.accepted:
        missed = [row.name for row in result.rows if row.counts and not row.kept]
        raise CheckError(f"validate contact: rejected ({'; '.join(missed)})")
