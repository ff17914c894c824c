"""Results of runs as one page for people."""

from contextlib import ExitStack
from datetime import UTC, datetime
from typing import NamedTuple

from railcli import __version__
from railcli.analysis.assess import assess
from railcli.errors import InputError
from railcli.files.embed import data_uri
from railcli.files.output import write_text
from railcli.files.read_results import Results

from .answer import Answer
from .voice import SILENT


class Film(NamedTuple):
    """How runs are shown as moving pictures."""

    kind: str = "page"  # or gif, mp4
    frames: int = 200
    magnify: float | None = None  # displacements
    wheelset: int = 1  # in close-ups


def report(results, place, limits=None, assessment=True, picture="png", film=None, voice=SILENT):
    """Make one self-contained HTML page of one or several results folders, and a folder of its figures.

    Parameters
    ----------
    results : sequence of pathlib.Path
    place : callable
        Called with the label of the first result, once all can be read; a context manager that gives the results
        folder.
    limits : Limits, optional
    assessment : bool
        Judge the results.
    picture : {"png", "svg"}
        Format of the figures.
    film : Film, optional
        Show each run as a moving picture too.
    voice : Voice

    Returns
    -------
    Answer
    """
    from railcli.report import page
    from railcli.report.assess import as_json
    from railcli.report.curves import Curves

    page.template()
    with ExitStack() as stack:
        several = [
            Curves(stack.enter_context(Results(path)), label)
            for path, label in zip(results, labels(results), strict=True)
        ]
        for one in several:  # all can be read before anything is written
            one.results.summary, one.results.settings  # noqa: B018
        if film:
            from railcli.report import animation

            animation.check(several, film.kind, film.wheelset)
        folder = stack.enter_context(place(several[0].label))
        outcomes, pictures = _drawn(several, folder, limits, assessment, picture, voice)
        films = [
            _film(one, k, folder, film, voice)
            for k, one in enumerate(several, start=1)
            if film and one.scenario is not None
        ]
        judged = [outcome and as_json(outcome) for outcome in outcomes]
        found = page.tables(several)
        date = datetime.now(UTC).isoformat(timespec="seconds")
        write_text(folder / "report.html", page.render(several, found, judged, pictures, films, __version__, date))
    files = ["report.html", *(one["file"] for one in (*pictures, *films) if one["file"])]
    return _answer(several, folder, files, found, judged)


def _drawn(several, folder, limits, assessment, picture, voice):
    """Assessments of results, None where there is none, and their pictures as the page shows them."""
    from railcli.report.result_figures import figure_of_assessment, figure_of_braking, figures

    wanted, outcomes, pictures = figures(several), [], []
    with voice.job("Report", 2 * len(several) + len(wanted), "parts") as job:
        for one in several:
            outcomes.append(_assessed(one, limits) if assessment and one.scenario is not None else None)
            wanted += figure_of_assessment(one, outcomes[-1], several)
            wanted += figure_of_braking(one, several)
            job.update(len(outcomes), f"assessed {one.label}")
        for name, title, caption, write in wanted:
            path = folder / f"{name}.{picture}"
            write(path)
            pictures.append(
                {"name": name, "title": title, "caption": caption, "file": path.name, "uri": data_uri(path)}
            )
            job.update(len(outcomes) + len(pictures), f"drew {path.name}")
    return outcomes, pictures


def _assessed(one, limits):
    """The assessment of a result; None, with a note, where its motion allows none, as that of a stop."""
    try:
        return assess(one.results, limits)
    except InputError as error:
        one.notes.append(f"no assessment: {error}")
        return None


def _answer(several, folder, files, found, judged):
    from railcli.report import page

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
    return Answer(record, [*lines, f"Written to {folder}: {', '.join(files)}"], folder)


def labels(results):
    """A name for each results folder: its own, or its whole path where two have the same."""
    names = [(path.parent if path.suffix == ".h5" else path).resolve().name for path in results]
    return [
        name if names.count(name) == 1 else f"{chr(65 + k)} {path}"
        for k, (name, path) in enumerate(zip(names, results, strict=True))
    ]


def _film(one, number, folder, film, voice):
    """Make the moving picture of a result; what the page shows of it."""
    from railcli.report import animation

    made = animation.Film(one, film.frames, film.magnify, film.wheelset)
    with voice.job(f"Animation {one.label}", len(made), "frames") as job:
        if film.kind == "page":
            file, uris = "", made.data_uris(job.update)
        else:
            path = folder / f"animation-{number}.{film.kind}"
            made.write(path, film.kind, job.update)
            file, uris = path.name, [data_uri(path)]
    return {
        "label": one.label, "caption": made.caption, "kind": film.kind, "rate": animation.RATE, "file": file,
        "uris": uris,
    }  # fmt: skip
