"""Judging results of runs."""

from railcli.analysis.assess import assess as judge
from railcli.files.output import file_name, write_json, write_text
from railcli.files.read_results import Results
from railcli.model.assessment import Limits

from .answer import Answer
from .voice import SILENT


def assess(results, limits=None, folder=None, figures=True, voice=SILENT):
    """Judge one or more results folders.

    Parameters
    ----------
    results : sequence of pathlib.Path
    limits : Limits, optional
    folder : pathlib.Path, optional
        Results folder for files; of several results each has a folder in it.
    figures : bool
        Draw into it.
    voice : Voice

    Returns
    -------
    answer : Answer
        Its ``results`` hold a record for each.
    failed : list of str
        Names of those that are over the limits, or broke off.
    """
    from railcli.report import assess as report

    limits, names = limits or Limits(), names_of(results)
    for path in results:  # all of them can be read before anything is written
        with Results(path) as source:
            source.scenario, source.summary  # noqa: B018
    lines, records, judged = [], [], []
    for name, path in zip(names, results, strict=True):
        with Results(path) as source, voice.job(f"Assess {name}", 100, "%") as job:
            scenario = source.scenario
            outcome = judge(source, limits, progress=lambda share, job=job: job.update(round(100 * share)))
            records.append(_record(source, outcome, limits))
        if folder:
            _write(folder if len(results) == 1 else folder / name, scenario, outcome, records[-1], figures)
        lines += [*report.report(name, scenario, outcome), ""]
        judged.append(outcome)
    if len(results) > 1:
        lines += [*report.side_by_side(names, judged), ""]
    lines = [*lines, f"Written to {folder}"] if folder else lines[:-1]
    failed = [name for name, outcome in zip(names, judged, strict=True) if not outcome.accepted]
    return Answer({"results": records}, lines, folder), failed


def _record(source, outcome, limits):
    from railcli.report import assess as report

    return {
        "results": source.folder,
        "scenario": source.scenario.name,
        **report.as_json(outcome),
        "limits": limits.model_dump(mode="json"),
        "provenance": source.provenance,
    }


def _write(place, scenario, outcome, record, figures):
    from railcli.report import assess as report

    write_json(place / "assessment.json", record)
    write_text(place / "sections.csv", report.sections_csv(outcome))
    if figures:
        report.figure(scenario.name, scenario, outcome, place / "assessment.png")


def names_of(results):
    """A name for each results folder, each once."""
    names = []
    for path in results:
        path = path.resolve()
        name = file_name((path.parent if path.suffix == ".h5" else path).name)
        same = sum(other == name or other.rpartition("-")[0] == name for other in names)
        names.append(f"{name}-{same + 1}" if same else name)
    return names
