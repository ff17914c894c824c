"""Comparisons with published results."""

from railcli.errors import CheckError

from .answer import Answer
from .tables import benchmark_tables, tables_for
from .voice import SILENT, Voice


def validate(name, folder=None, figures=True, voice=SILENT, **options):
    """Compare railcli with published results.

    Parameters
    ----------
    name : {"manchester", "curves", "conicity", "contact", "braking"}
    folder : pathlib.Path, optional
        Results folder for files.
    figures : bool
        Draw into it.
    voice : Voice
    **options
        Of one comparison, as ``railcli validate`` has them: sensitivity, disturbance; creep_law, normal.

    Returns
    -------
    answer : Answer
    rejection : CheckError or None
        Says which criteria were missed.
    """
    record, lines, missed = COMPARISONS[name](folder, figures, voice, **options)
    rejection = CheckError(f"validate {name}: rejected ({'; '.join(missed)})") if missed else None
    return Answer(record, [*lines, f"Written to {folder}"] if folder else lines, folder), rejection


def _missed(result):
    return [row.name for row in result.rows if row.counts and not row.kept]


def _write(folder, record, table, text=None):
    from railcli.files.output import write_json, write_text

    write_json(folder / "validation.json", record)
    write_text(folder / "validation.csv", table)
    if text is not None:
        write_text(folder / "validation.md", text)


def _manchester(folder, figures, voice, sensitivity=False, disturbance=False):
    from railcli.analysis.validate import compare_manchester
    from railcli.analysis.warm import warm
    from railcli.files.benchmark import manchester_criteria, manchester_reference
    from railcli.files.provenance import provenance
    from railcli.files.scenario import load
    from railcli.report import validation

    reference, criteria = manchester_reference(), manchester_criteria()
    scenarios = [load(f"curve-1200-{speed:g}") for speed in reference.speeds]
    other = scenarios[0].varied(contact={"inclination": 40.0})
    warm(voice.announce)
    tables = tables_for(scenarios[0], voice)
    others = other, tables_for(other, voice)
    with voice.job("Validate", 30, "steps") as job:
        result = compare_manchester(reference, criteria, scenarios, tables, others, job.update)
    record = validation.as_json(scenarios[0], result, provenance(scenarios[0], tables))
    sections = validation.report(scenarios[0], result, sensitivity)
    rows, names = result.rows, validation.FIGURES
    if disturbance:
        response, more = _disturbance(scenarios[0], tables, criteria, record, sections, voice)
        rows, names = rows + response.rows, names + more
    validation.judged(record, sections, rows)
    if folder:
        _write(folder, record, validation.csv(result), validation.markdown(sections, record, names if figures else ()))
        if figures:
            validation.figures(result, folder)
            if disturbance:
                from railcli.report import disturbance as disturbances

                disturbances.figures(response, folder)
    return record, [validation.terminal(sections, record)], [row[0] for row in rows if row[5] and not row[4]]


def _disturbance(scenario, tables, criteria, record, sections, voice):
    """Compare disturbances, add them to record and sections; the outcome and the names of its figures."""
    from railcli.analysis.disturbance import compare_disturbance
    from railcli.report import disturbance as disturbances

    with voice.job("Disturbance", 100, "%") as job:
        response = compare_disturbance(
            scenario, tables, criteria, lambda share, text: job.update(round(100 * share), text)
        )
    record["disturbance"] = disturbances.as_json(response)
    sections[-1:-1] = disturbances.sections(response)
    return response, disturbances.FIGURES


def _curves(folder, figures, voice, creep_law=None, normal=None):
    from railcli.analysis.curves_check import compare_curves
    from railcli.analysis.curving_check import NOMINAL
    from railcli.analysis.warm import warm
    from railcli.files.curves_reference import curves_criteria, curves_reference, curves_scenarios, wheelset_of
    from railcli.files.provenance import provenance
    from railcli.report import curves_validation as report

    reference, criteria = curves_reference(), curves_criteria()
    laws = {key: name for key, name in (("creep_law", creep_law), ("normal", normal)) if name is not None}
    curve, wagon, wide = curves_scenarios(laws)
    warm(voice.announce)
    quiet = Doubts(voice)
    with voice.job("Validate", 100, "%") as job:
        result = compare_curves(
            reference, criteria, curve, wagon, wheelset_of(wagon), wide, lambda case: tables_for(case, quiet),
            lambda share, text: job.update(round(100 * share), text),
        )  # fmt: skip
    origin = provenance(result.curves[NOMINAL].scenario)
    record, sections = report.as_json(result, origin), report.report(result)
    if folder:
        _write(folder, record, report.csv(result), report.markdown(sections, result, origin, figures=figures))
        if figures:
            report.figures(result, folder)
    return record, [report.terminal(sections, result)], _missed(result)


class Doubts(Voice):
    """Passes warnings on and nothing else: for jobs within a job."""

    def __init__(self, voice):
        self.warn = voice.warn


def _conicity(folder, figures, voice):
    from railcli.analysis.conicity_check import compare_conicity
    from railcli.files.conicity_reference import conicity_criteria, reference_profiles, reference_tables
    from railcli.report import conicity as report

    with voice.job("Validate", 100, "%") as job:
        result = compare_conicity(
            reference_profiles(), reference_profiles(digitised=True), reference_tables(), conicity_criteria(),
            lambda share: job.update(round(100 * share)),
        )  # fmt: skip
    record = report.validation_json(result)
    if folder:
        _write(folder, record, report.validation_csv(result))
        if figures:
            report.validation_plot(result, folder / "conicity.png")
    return record, report.validation_lines(result), _missed(result)


def _contact(folder, figures, voice):
    from railcli.analysis.contact_check import compare_contact
    from railcli.analysis.warm import warm
    from railcli.files.contact_reference import benchmark_wheelset, contact_criteria, published
    from railcli.files.provenance import provenance
    from railcli.report import contact_figures
    from railcli.report import contact_validation as report

    reference, criteria = published(), contact_criteria()
    warm(voice.announce)
    tables = benchmark_tables(voice)
    with voice.job("Validate", 100, "%") as job:
        result = compare_contact(
            reference, criteria, benchmark_wheelset(), tables,
            lambda share, text: job.update(round(100 * share), text),
        )  # fmt: skip
    origin = provenance(tables=tuple(tables.values()))
    record, sections = report.as_json(result, origin), report.report(result)
    if folder:
        _write(folder, record, report.csv(result), report.markdown(sections, result, origin, figures=figures))
        if figures:
            contact_figures.figures(result, folder)
    return record, [report.terminal(sections, result)], _missed(result)


def _braking(folder, figures, voice):
    from railcli.analysis.braking_check import DRY, compare_braking
    from railcli.analysis.warm import warm
    from railcli.files.braking_reference import braking_criteria, braking_reference, braking_scenarios
    from railcli.files.provenance import provenance
    from railcli.report import braking_validation as report

    reference, criteria = braking_reference(), braking_criteria()
    scenarios = braking_scenarios(reference)
    warm(voice.announce)
    tables = tables_for(scenarios[DRY], voice)
    quiet = Doubts(voice)
    with voice.job("Validate", 100, "%") as job:
        result = compare_braking(
            reference, criteria, scenarios, lambda case: tables_for(case, quiet),
            lambda share, text: job.update(round(100 * share), text),
        )  # fmt: skip
    origin = provenance(scenarios[DRY], tables)
    record, sections = report.as_json(result, origin), report.sections_of(result)
    if folder:
        _write(folder, record, report.csv(result), report.markdown(sections, result, origin, figures))
        if figures:
            report.figures(result, folder)
    return record, [report.terminal(sections, result)], _missed(result)


COMPARISONS = {
    "manchester": _manchester, "curves": _curves, "conicity": _conicity, "contact": _contact, "braking": _braking,
}  # fmt: skip
