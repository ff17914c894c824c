"""A run: a scenario becomes a results folder, a record and lines."""

from pathlib import Path
from typing import NamedTuple

from railcli.analysis import steady_values
from railcli.analysis.simulate import SteadyWindow, simulate
from railcli.analysis.step_choice import StepChoice, with_step
from railcli.analysis.vibration import Listener, vibration
from railcli.analysis.warm import warm
from railcli.analysis.watch import Watch
from railcli.errors import InputError
from railcli.files import inputs, results
from railcli.files.output import write_json
from railcli.files.provenance import provenance
from railcli.files.read_results import SUMMARY
from railcli.model.scenario import Scenario
from railcli.model.system import System, assemble
from railcli.runtime.guest import invited, welcome

from .answer import Answer
from .tables import tables_for
from .voice import SILENT


class Prepared(NamedTuple):
    """A scenario ready to run: with its step, assembled, and the contact tables that it took."""

    scenario: Scenario
    system: System
    choice: StepChoice
    tables: list


class Observed(NamedTuple):
    """What was seen of a run as it went: its end averaged, what vibrates and what alternates."""

    window: SteadyWindow
    listener: Listener
    watch: Watch


def prepare(scenario, voice=SILENT, guest=None):
    """Compile what is not, get or build the contact tables, assemble, settle the time step.

    guest : path-like of a user's own controller, or None.

    Returns
    -------
    Prepared

    Raises
    ------
    InputError
        The given step is longer than the model bears, or a table is for something else.
    """
    controller = None if guest is None else welcome(scenario, guest)
    warm(voice.announce)
    tables = tables_for(scenario, voice)
    settled = with_step(scenario, assemble(scenario, tables))
    if controller is not None:
        settled = settled._replace(system=invited(settled.system, controller, settled.choice.step))
    return Prepared(*settled, tables)


def run(scenario, folder, contact_channels=("*",), figures=True, assessment=True, voice=SILENT, guest=None):
    """Run a scenario and fill its results folder.

    Parameters
    ----------
    scenario : Scenario
    folder : pathlib.Path
        That files.output.results_folder gave.
    contact_channels : sequence of str
        Globs, as files.results.TimeSeries.
    figures, assessment : bool
        Draw the time series; judge them.
    voice : Voice
    guest : path-like, optional
        Of a user's own controller (docs/subsystems.md, 10).

    Returns
    -------
    Answer
        Its ``fault`` says what broke the run off, and is empty when it reached its end.
    """
    prepared = prepare(scenario, voice, guest)
    outcome, observed = _simulated(prepared, folder, contact_channels, voice)

    from railcli.report import run as report  # only now: drawing libraries take half a second to load
    from railcli.report import step

    case, choice = prepared.scenario, prepared.choice
    stretch = steady_values.final_stretch(case)
    steady = None if outcome.fault else _end(prepared, stretch, observed)
    files = [inputs.SCENARIO, inputs.INPUTS]
    if outcome.rows:
        files += _main_channels(folder) + (_drawn(case, folder) if figures else [])
    origin = provenance(case, prepared.tables)
    if prepared.system.guest is not None:
        origin["guest"] = {"file": str(prepared.system.guest.path), "sha256": prepared.system.guest.digest}
    record = report.summary(case, outcome, stretch, steady, origin, files, step.as_json(choice))
    lines = report.report(case, outcome, stretch, steady, step.words(choice))
    record["alternation"] = observed.watch.warning
    if case.irregularity:
        record["irregularity"], rough = _irregularity(case)
        lines += rough
    if prepared.system.model.axle.size and outcome.rows:
        record["subsystems"], told = _subsystems(prepared, outcome, folder, files, figures)
        lines += told
    if observed.watch.warning:
        lines += ["", f"Warning: {observed.watch.warning}"]
    record["folder"] = folder
    if assessment and outcome.rows:
        record["assessment"], judged = _assessment(folder, outcome.fault)
        lines += ["", *judged]
    write_json(folder / SUMMARY, record)
    return Answer(record, [*lines, "", f"Written to {folder}: {', '.join(files)}, {SUMMARY}"], folder)


def _simulated(prepared, folder: Path, contact_channels, voice):
    """The Outcome of the time steps, whose rows are written as they come, and what was Observed."""
    case, system = prepared.scenario, prepared.system
    window = SteadyWindow(case.distance - case.average_over)
    observed = Observed(window, Listener(system.model.wheel.size, window.start), Watch(system))
    series = results.TimeSeries(folder / results.TIME_SERIES, system, contact_channels)
    inputs.save(case, folder / inputs.INPUTS)
    write_json(folder / inputs.SCENARIO, case.as_dict())

    def sink(rows):
        for each in (series, window, observed.watch):
            each(rows)

    def filtered_sink(block):
        series.filtered(block)
        observed.listener(block)

    try:
        with series, voice.job("Run", case.duration, "s") as job:
            outcome = simulate(
                case, system, sink, lambda time, factor: job.update(time, f"{factor:.0f} x real time"), filtered_sink
            )
    except KeyboardInterrupt:
        raise KeyboardInterrupt(series.kept()) from None
    return outcome, observed


def _end(prepared, stretch, observed):
    """The steady end of a run, steady_values.End; None when it has none."""
    case, system, window = prepared.scenario, prepared.system, observed.window
    if stretch is None or not window.count:
        return None
    return steady_values.End(
        mean=steady_values.means(system, stretch, window),
        swing=steady_values.peaks_to_peaks(system, stretch, window),
        newton=steady_values.solved(system, stretch, case.final_speed),
        balance=steady_values.expected_forces(case, stretch),
        traction=float(window.mean("traction")),
        weight_along=steady_values.weight_along(case, stretch),
        vibration=None if case.irregularity else vibration(system, window, observed.listener),
    )


def _main_channels(folder):
    """Write the main channels of a run that is over; the names of its files of channels."""
    results.write_main_channels(results.pieces(folder / results.TIME_SERIES), folder / results.MAIN_CHANNELS)
    return [results.TIME_SERIES, results.MAIN_CHANNELS]


def _drawn(case, folder):
    from railcli.report import run as report

    return report.figures(case, results.envelope(folder / results.TIME_SERIES), folder)


def _subsystems(prepared, outcome, folder, files, figures):
    """Of brakes, traction and adhesion: what the record of a run holds, and lines; draws into the folder."""
    from railcli.report import braking

    if figures:
        files += braking.figures(prepared.scenario, outcome, prepared.system, folder)
    told = braking.as_json(prepared.scenario, prepared.system, outcome)
    return told, braking.lines(prepared.scenario, prepared.system, outcome)


def _irregularity(case):
    """Of the rails of a run: what its record holds, and lines."""
    from railcli.analysis.irregularity_spectrum import bands, of_scenario
    from railcli.report import irregularity

    rails = of_scenario(case)
    rows = bands(rails)
    return irregularity.as_json(rails, rows), ["", *irregularity.in_a_run(rails, rows)]


def _assessment(folder, fault):
    """Of the results as they are written: what the record holds of it, and lines."""
    from railcli.analysis.assess import assess
    from railcli.files.read_results import Results
    from railcli.report import assess as report

    try:
        with Results(folder) as found:
            outcome = assess(found, fault=fault)
    except InputError as error:
        return {"error": str(error)}, [f"No assessment: {error}"]
    return report.for_summary(outcome), report.short(outcome, f"railcli assess {folder}")
