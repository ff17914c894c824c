"""`railcli assess`: judge results of runs."""

from pathlib import Path

import click

from .options import results_options


@click.command(short_help="Judge results: forces, ride, comfort, wear, stability.")
@click.argument("results", nargs=-1, required=True, metavar="RESULTS...", type=click.Path(path_type=Path))
@click.option("--limits", type=click.Path(path_type=Path), metavar="FILE", help="TOML file with other limits.")
@click.option("--check", is_flag=True, help="End with exit code 4 when a figure fails or a run broke off.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def assess(results, limits, check, no_figures, output_format, output, overwrite, quiet):
    """Judge one or more results folders of `railcli run scenario`.

    Forms Y/Q, sums of guiding forces, wheel loads and unloading, accelerations on the floor, comfort (N_MV, Sperling),
    wear numbers and stability, prints them against their limits, and writes assessment.json, sections.csv and a figure.
    What a run is too short or too coarsely recorded for is said, not guessed. docs/assessment.md defines every figure.

    \b
    Examples:
      railcli assess railcli-out/run-curve-300-1
      railcli assess before after --limits my-limits.toml --check
    """
    from railcli.analysis.assess import assess as judge
    from railcli.files.limits import load_limits
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.progress import Progress
    from railcli.files.read_results import Results
    from railcli.model.assessment import Limits
    from railcli.report import assess as report

    bounds = load_limits(limits) if limits else Limits()
    names = _names(results)
    for path in results:  # all of them can be read before anything is written
        with Results(path) as source:
            source.scenario, source.summary  # noqa: B018
    lines, records, judged = [], [], []
    with results_folder("assess", names[0], output, overwrite) as folder:
        for name, path in zip(names, results, strict=True):
            with Results(path) as source, Progress(f"Assess {name}", 100, "%", quiet) as progress:
                scenario = source.scenario
                outcome = judge(source, bounds, progress=lambda share, to=progress: to.update(round(100 * share)))
                record = {
                    "results": source.folder,
                    "scenario": scenario.name,
                    **report.as_json(outcome),
                    "limits": bounds.model_dump(mode="json"),
                    "provenance": source.provenance,
                }
            place = folder if len(results) == 1 else folder / name
            write_json(place / "assessment.json", record)
            write_text(place / "sections.csv", report.sections_csv(outcome))
            if not no_figures:
                report.figure(scenario.name, scenario, outcome, place / "assessment.png")
            lines += [*report.report(name, scenario, outcome), ""]
            records.append(record)
            judged.append(outcome)
    if len(results) > 1:
        lines += [*report.side_by_side(names, judged), ""]
    lines.append(f"Written to {folder}")
    click.echo(json_text({"results": records}) if output_format == "json" else "\n".join(lines))
    failed = [name for name, outcome in zip(names, judged, strict=True) if not outcome.accepted]
    if check and failed:
        from railcli.errors import CheckError

        raise CheckError(f"over the limits, or broken off: {', '.join(failed)}")


def _names(results):
    """A name for each results folder, each once."""
    from railcli.files.output import file_name

    names = []
    for path in results:
        path = path.resolve()
        name = file_name((path.parent if path.suffix == ".h5" else path).name)
        same = sum(other == name or other.rpartition("-")[0] == name for other in names)
        names.append(f"{name}-{same + 1}" if same else name)
    return names
