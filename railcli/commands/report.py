"""`railcli report`: results as a page for people."""

from contextlib import ExitStack
from pathlib import Path

import click

from .options import results_options

MOST = 6  # results, as many as there are colours


@click.command(short_help="Results as one page with figures, assessment and animation.")
@click.argument("results", nargs=-1, required=True, metavar="RESULTS...", type=click.Path(path_type=Path))
@click.option("--limits", type=click.Path(path_type=Path), metavar="FILE", help="TOML file with other limits.")
@click.option("--no-assessment", is_flag=True, help="Do not judge the results.")
@click.option("--picture", type=click.Choice(["png", "svg"]), default="png", show_default=True, help="Of the figures.")
@click.option("--animate", is_flag=True, help="Show each run as a moving picture too.")
@click.option("--film", type=click.Choice(["page", "gif", "mp4"]), help="Its form; implies --animate  [default: page]")
@click.option("--frames", type=click.IntRange(2, 2000), default=200, show_default=True, metavar="N", help="Of it.")
@click.option("--magnify", type=click.FloatRange(0.0, 1e5, min_open=True), metavar="X", help="Of its displacements.")
@click.option("--wheelset", type=click.IntRange(1), default=1, show_default=True, metavar="N", help="In its close-ups.")
@results_options
def report(
    results, limits, no_assessment, picture, animate, film, frames, magnify, wheelset,
    output_format, output, overwrite, quiet,
):  # fmt: skip
    """Make one self-contained HTML page of one or several results folders, and a folder of its figures.

    Track, motions of the wheelsets, forces, creepages, contact, accelerations, spectra, assessment, largest and steady
    values, settings that differ and provenance. Several results (at most six) stand side by side in the tables and over
    one another in the figures.

    \b
    Examples:
      railcli report railcli-out/run-curve-300-1
      railcli report before after --picture svg -o comparison
      railcli report railcli-out/run-curve-300-1 --animate
    """
    from datetime import UTC, datetime

    from railcli import __version__
    from railcli.analysis.assess import assess
    from railcli.files.embed import data_uri
    from railcli.files.limits import load_limits
    from railcli.files.output import json_text, results_folder, write_text
    from railcli.files.progress import Progress
    from railcli.files.read_results import Results
    from railcli.model.assessment import Limits
    from railcli.report import page
    from railcli.report.assess import as_json
    from railcli.report.curves import Curves
    from railcli.report.result_figures import figure_of_assessment, figures

    if len(results) > MOST:
        raise click.BadParameter(f"{len(results)} results: at most {MOST} fit on a page", param_hint="'RESULTS'")
    page.template()
    film = film or ("page" if animate else None)
    bounds = load_limits(limits) if limits else Limits()
    with ExitStack() as stack:
        several = [
            Curves(stack.enter_context(Results(path)), label)
            for path, label in zip(results, labels(results), strict=True)
        ]
        for one in several:  # all can be read before anything is written
            one.results.summary, one.results.settings  # noqa: B018
        if film:
            from railcli.report import animation

            animation.check(several, film, wheelset)
        folder = stack.enter_context(results_folder("report", several[0].label, output, overwrite))
        wanted, outcomes, pictures = figures(several), [], []
        with Progress("Report", 2 * len(several) + len(wanted), "parts", quiet) as progress:
            for one in several:
                outcomes.append(None if no_assessment or one.scenario is None else assess(one.results, bounds))
                wanted += figure_of_assessment(one, outcomes[-1], several)
                progress.update(len(outcomes), f"assessed {one.label}")
            for name, title, caption, write in wanted:
                path = folder / f"{name}.{picture}"
                write(path)
                pictures.append(
                    {"name": name, "title": title, "caption": caption, "file": path.name, "uri": data_uri(path)}
                )
                progress.update(len(outcomes) + len(pictures), f"drew {path.name}")
        films = [
            _film(one, k, folder, film, (frames, magnify, wheelset), quiet)
            for k, one in enumerate(several, start=1)
            if film and one.scenario is not None
        ]
        judged = [outcome and as_json(outcome) for outcome in outcomes]
        found = page.tables(several)
        date = datetime.now(UTC).isoformat(timespec="seconds")
        write_text(folder / "report.html", page.render(several, found, judged, pictures, films, __version__, date))
    files = ["report.html", *(one["file"] for one in (*pictures, *films) if one["file"])]
    record = {
        "folder": folder,
        "files": files,
        "results": [one.results.folder for one in several],
        "tables": {key: {"columns": table.head[1:], "rows": table.rows} for key, table in found.items()},
        "assessment": [outcome and outcome["figures"] for outcome in judged],
        "notes": {one.label: one.notes for one in several if one.notes},
    }
    lines = [f"{one.label}: {verdict}" for one, verdict in zip(several, page.verdicts(judged), strict=True) if verdict]
    lines += [f"{label}: {note}" for label, notes in record["notes"].items() for note in notes]
    lines.append(f"Written to {folder}: {', '.join(files)}")
    click.echo(json_text(record) if output_format == "json" else "\n".join(lines))


def labels(results):
    """A name for each results folder: its own, or its whole path where two have the same."""
    names = [(path.parent if path.suffix == ".h5" else path).resolve().name for path in results]
    return [
        name if names.count(name) == 1 else f"{chr(65 + k)} {path}"
        for k, (name, path) in enumerate(zip(names, results, strict=True))
    ]


def _film(one, number, folder, kind, choices, quiet):
    """Make the moving picture of a result; what the page shows of it."""
    from railcli.files.embed import data_uri
    from railcli.files.progress import Progress
    from railcli.report.animation import RATE, Film

    film = Film(one, *choices)
    with Progress(f"Animation {one.label}", len(film), "frames", quiet) as progress:
        if kind == "page":
            file, uris = "", film.data_uris(progress.update)
        else:
            path = folder / f"animation-{number}.{kind}"
            film.write(path, kind, progress.update)
            file, uris = path.name, [data_uri(path)]
    return {"label": one.label, "caption": film.caption, "kind": kind, "rate": RATE, "file": file, "uris": uris}
