"""Critical speed of a vehicle: roots over speed with quasi-linear contact, and limit cycles that die."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from railcli.analysis.quasi_linear import quasi_linear_system
from railcli.analysis.stability import USUAL, Measures, locus, ramp
from railcli.analysis.step_choice import with_step
from railcli.analysis.warm import warm
from railcli.errors import SimulationError
from railcli.files.output import write_json, write_text
from railcli.files.provenance import provenance
from railcli.model.assessment import Limits
from railcli.model.system import assemble

from .answer import Answer
from .modes import quasi_linear_contact
from .tables import tables_for
from .voice import SILENT

ABOVE = 1.1  # start of the ramp over the highest linear critical speed
ASIDE = 5e-3  # lateral displacement of a ramp whose scenario has none [m]


class Span(NamedTuple):
    """Speeds of the linear part, and the step of both parts [m/s]."""

    low: float = 10.0
    high: float = 150.0
    step: float = 5.0


@dataclass(frozen=True)
class Ramp:
    """How limit cycles are followed down.

    Attributes
    ----------
    start : float or None
        Speed from which the ramp falls [m/s]; None: above the highest linear critical speed.
    resolution : float
        Of the speeds at which hunting ends [m/s].
    threshold, counts : float
        Lateral amplitude up to which a wheelset does not hunt, and from which on a limit cycle counts [m].
    limits : Limits
        Of sum Y.
    """

    start: float | None = None
    resolution: float = 0.5
    threshold: float = 0.1e-3
    counts: float = 1.0e-3
    limits: Limits = field(default_factory=Limits)


@dataclass
class Followed:
    """Limit cycles as they come, the step of their runs [s], and what ended them early."""

    cycles: list = field(default_factory=list)
    step: float | None = None
    interrupted: bool = False
    fault: SimulationError | None = None


def critical_speed(
    scenario, amplitudes_mm, span=None, how=None, linear_only=False, folder=None, figures=True, voice=SILENT
):  # fmt: skip
    """Critical speed on straight level track, linear and non-linear.

    Parameters
    ----------
    scenario : Scenario
    amplitudes_mm : sequence of float
        Of the linear part [mm]; the usual 3 mm are always among them.
    span : Span, optional
    how : Ramp, optional
    linear_only : bool
        Follow no limit cycles.
    folder : pathlib.Path, optional
        Results folder for files.
    figures : bool
        Draw into it.
    voice : Voice

    Returns
    -------
    answer : Answer
    fault : SimulationError or None
        What ended the limit cycles early.

    Raises
    ------
    KeyboardInterrupt
        Ctrl-C during the limit cycles; those until then are in the folder.
    """
    span, how = span or Span(), how or Ramp()
    measures = Measures.of(scenario, how.counts, how.limits)
    warm(voice.announce)
    tables = () if linear_only else tables_for(scenario, voice)
    lines = quasi_linear_contact(scenario, sorted({*amplitudes_mm, 1e3 * USUAL}), voice)
    loci = _linear(scenario, lines, span, voice)

    from railcli.report import stability as report  # only now: drawing libraries take half a second to load

    followed = Followed()
    if not linear_only:
        begin = how.start or report.start_of_ramp(loci, span, ABOVE)
        system = _hunting(scenario, tables, (span.low, begin))
        followed.step = float(system.model.param[0]["step"])
        _follow(followed, scenario, system, begin, span, how, measures, voice)
    cycles = followed.cycles
    written = _written(scenario, lines, loci, cycles, measures, folder, figures) if folder else []
    record = report.as_json(
        scenario, lines, loci, cycles, how.threshold, measures, followed.step, provenance(scenario, tables), written
    )  # fmt: skip
    text = report.report(scenario, lines, loci, cycles, measures, followed.step)
    if folder:
        record["folder"] = folder
        write_json(folder / "critical_speed.json", record)
        text = [*text, "", f"Written to {folder}: {', '.join(written)}"]
    if followed.interrupted:
        kept = f"The limit cycles down to {cycles[-1].speed:g} m/s are in {folder}." if cycles and folder else ""
        raise KeyboardInterrupt(kept)
    return Answer(record, text, folder), followed.fault


def _linear(scenario, lines, span, voice):
    speeds = span.low + span.step * np.arange(int((span.high - span.low) / span.step + 1e-9) + 1)
    loci, done = [], 0

    def one_more():
        nonlocal done
        done += 1
        job.update(done)

    with voice.job("Roots", len(lines) * speeds.size, "speeds") as job:
        for line in lines:
            if line[0].flange:
                loci.append(None)
            else:
                loci.append(locus(quasi_linear_system(scenario, line), line[0].amplitude, speeds, one_more))
    return loci


def _hunting(scenario, tables, speeds):
    """The system whose hunting is looked at, with half of the step that a usual run would take unless one is given.

    A wheelset that is thrown aside at high speed strikes its flange harder than the choice of a step reckons with.
    """
    _, system, choice = with_step(scenario, assemble(scenario, tables), speeds)
    return system.stepped(0.5 * choice.step) if choice.chosen else system


def _follow(followed, scenario, system, start, span, how, measures, voice):
    """Gather limit cycles into `followed`, and what stopped them."""
    lateral = scenario.start.lateral or ASIDE
    ends = how.resolution, how.threshold, measures
    try:
        with voice.job("Limit cycles", start - span.low, "m/s") as job:
            for cycle in ramp(system, start, span.step, span.low, lateral, *ends):
                followed.cycles.append(cycle)
                job.update(start - cycle.speed, f"{cycle.speed:g} m/s, {cycle.largest * 1e3:.2f} mm")
    except KeyboardInterrupt:
        followed.interrupted = True
    except SimulationError as error:
        followed.fault = error


def _written(scenario, lines, loci, cycles, measures, folder, figures):
    """Names of the files of a critical speed, all written but the record."""
    from railcli.report import stability as report

    written = ["critical_speed.json", "linear.csv", "root_locus.csv"]
    write_text(folder / "linear.csv", report.linear_csv(lines, loci))
    write_text(folder / "root_locus.csv", report.locus_csv(loci))
    if cycles:
        written.append("limit_cycles.csv")
        write_text(folder / "limit_cycles.csv", report.cycles_csv(cycles))
    if figures:
        written += report.figures(scenario, loci, cycles, measures, folder)
    return written
