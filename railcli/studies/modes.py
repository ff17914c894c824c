"""Modes of a vehicle, and what they share with its critical speed: quasi-linear contact."""

from railcli.analysis.linear import linearise
from railcli.analysis.linear import modes as modes_of
from railcli.analysis.mode_shapes import describe
from railcli.analysis.quasi_linear import lines_of, quasi_linear_system
from railcli.analysis.warm import warm
from railcli.files.output import write_json, write_text
from railcli.files.profiles import profile_of
from railcli.files.provenance import provenance
from railcli.model.system import assemble

from .answer import Answer
from .tables import tables_for
from .voice import SILENT


def quasi_linear_contact(scenario, amplitudes_mm, voice=SILENT):
    """Quasi-linear contact of a scenario for each amplitude [mm]: one QuasiLinear for each wheel radius."""
    wheel = profile_of(scenario, scenario.contact.wheel_profile, "wheel")
    rail = profile_of(scenario, scenario.contact.rail_profile, "rail")
    amplitudes = [value * 1e-3 for value in amplitudes_mm]
    with voice.job("Contact", 100, "%") as job:
        return lines_of(scenario, wheel, rail, amplitudes, lambda share: job.update(round(100 * share)))


def modes(scenario, amplitude_mm, response=False, everything=False, folder=None, figures=True, voice=SILENT):
    """Eigenmodes of a scenario's vehicle that rolls on straight level track.

    Parameters
    ----------
    scenario : Scenario
    amplitude_mm : float
        Lateral amplitude over which the contact is made linear [mm]; 0: differences of the contact table at y = 0.
    response : bool
        Frequency response to displaced rails too; it goes into the folder.
    everything : bool
        Strongly damped modes and those above 50 Hz stand in the lines too.
    folder : pathlib.Path, optional
        Results folder for files.
    figures : bool
        Draw into it.
    voice : Voice

    Returns
    -------
    Answer
    """
    warm(voice.announce)
    lines, tables = None, ()
    if amplitude_mm > 0.0:
        lines = quasi_linear_contact(scenario, [amplitude_mm], voice)[0]
        system = quasi_linear_system(scenario, lines)
    else:
        tables = tables_for(scenario, voice)
        system = assemble(scenario, tables)
    found = modes_of(linearise(system, contact=response))
    change = found.shift(linearise(system, scale=2.0))
    shapes = [describe(found, k) for k in range(found.value.size)]

    from railcli.report import modes as report  # only now: drawing libraries take half a second to load

    written = _written(scenario, found, shapes, response, folder, figures) if folder else []
    record = report.as_json(scenario, lines, found, change, shapes, provenance(scenario, tables), written)
    text = report.report(scenario, lines, found, change, shapes, everything)
    if folder:
        record["folder"] = folder
        write_json(folder / "modes.json", record)
        text = [*text, "", f"Written to {folder}: {', '.join(written)}"]
    return Answer(record, text, folder)


def _written(scenario, found, shapes, response, folder, figures):
    """Names of the files of modes, all written but the record."""
    from railcli.report import modes as report

    write_text(folder / "modes.csv", report.modes_csv(found, shapes))
    write_text(folder / "shapes.csv", report.shapes_csv(found, shapes))
    written = ["modes.json", "modes.csv", "shapes.csv"]
    if figures:
        written += report.figures(scenario, found, shapes, folder)
    if response:
        from railcli.analysis.response import responses
        from railcli.report import response as picture

        answers = responses(found.linear)
        written.append("response.csv")
        write_text(folder / "response.csv", picture.response_csv(found.linear, answers))
        if figures:
            written += picture.figures(scenario, found.linear, answers, folder)
    return written
