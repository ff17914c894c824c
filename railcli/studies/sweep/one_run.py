"""One run of a parameter study: values in, a row out, whatever happens."""

import threading
import time
from collections import OrderedDict
from typing import NamedTuple

from railcli.analysis import steady_values
from railcli.analysis.simulate import SteadyWindow, simulate
from railcli.analysis.step_choice import speeds_of, with_step
from railcli.analysis.step_limit import fingerprint, step_limit
from railcli.analysis.warm import warm
from railcli.errors import InputError, RailcliError
from railcli.files.changes import changed
from railcli.files.memory_series import FilteredRows
from railcli.model.assessment import FIGURES, Limits
from railcli.model.scenario import Scenario
from railcli.model.study import Study
from railcli.model.system import assemble
from railcli.report.run import sides_of
from railcli.studies.steady import motion_of
from railcli.studies.tables import tables_for
from railcli.studies.voice import SILENT

from . import outputs

DONE, FAILED = "done", "failed"
LIMITS = 100  # step limits that a process remembers
SHELF = 200e6  # bytes of contact tables that a process keeps at hand


class Given(NamedTuple):
    """What all runs of a study have in common."""

    study: Study
    scenario: Scenario
    limits: Limits


class Shelf:
    """Contact tables that a process keeps at hand from run to run, the last used ones within SHELF bytes."""

    def __init__(self):
        self._tables, self._lock = OrderedDict(), threading.Lock()

    def get(self, key, make):
        """The table of a key, made when it is not there; threads that want it wait for it."""
        with self._lock:
            table = self._tables.pop(key, None) or make()
            self._tables[key] = table
            while len(self._tables) > 1 and sum(one.bytes for one in self._tables.values()) > SHELF:
                self._tables.popitem(last=False)
            return table


class Runner:
    """Makes runs of a study, one after the other, in this process.

    Parameters
    ----------
    given : Given
    voice : Voice
    """

    def __init__(self, given, voice=SILENT):
        self._given, self._voice = given, voice
        self._shelf, self._limits = Shelf(), {}
        warm(voice.announce)

    def row(self, number, inputs, changes):
        """The row of a run.

        Parameters
        ----------
        number : int
        inputs : dict
            Values by name, as the row tells them.
        changes : dict
            Values by dotted key, as `files.changes.changed` takes them.

        Returns
        -------
        dict
            run, inputs, outputs, status, verdict, cause, cpu_s and time_s; JSON.

        Raises
        ------
        InputError
            Nothing that belongs to the run: a file cannot be written.
        """
        cpu, clock = time.thread_time(), time.perf_counter()
        found, verdict, cause = {}, "", ""
        try:
            found, verdict, cause = self._run(changes)
            status = DONE
        except RailcliError as error:
            if isinstance(error.__cause__, OSError):
                raise
            status, cause = FAILED, str(error)
        except Exception as error:
            status, cause = FAILED, f"{type(error).__name__}: {' '.join(str(error).split())}; a fault of railcli"
        kept = {name: _number(value) for name, value in found.items()}
        return {
            "run": number, "inputs": inputs, "outputs": kept, "status": status, "verdict": verdict, "cause": cause,
            "cpu_s": round(time.thread_time() - cpu, 6), "time_s": round(time.perf_counter() - clock, 6),
        }  # fmt: skip

    def _run(self, changes):
        """Outputs by name, verdict and its cause."""
        study = self._given.study
        case = changed(self._given.scenario, changes)
        tables = tables_for(case, self._voice, self._shelf)
        system = assemble(case, tables)
        stretch = steady_values.final_stretch(case)
        found, verdict, cause = {}, "", ""
        if study.wants("steady"):
            found |= _steady(case, system, stretch)
        if study.runs_in_time:
            limit = self._limit(case, system, tables)
            more, verdict, cause = self._in_time(*with_step(case, system, limit=limit)[:2], stretch)
            found |= more
        every = outputs.wanted(found, study)
        return {name: value for name, value in found.items() if name in every or "[" in name}, verdict, cause

    def _limit(self, case, system, tables):
        """The longest step; runs that differ by their track or irregularity alone share it."""
        key = fingerprint(system, speeds_of(case)), tuple(table.key for table in tables)
        if key not in self._limits:
            while len(self._limits) >= LIMITS:
                self._limits.pop(next(iter(self._limits)), None)
            self._limits[key] = step_limit(system, speeds_of(case))
        return self._limits[key]

    def _in_time(self, case, system, stretch):
        study = self._given.study
        window = SteadyWindow(case.distance - case.average_over)
        rows = round(case.duration / case.run.output_interval)
        gathered = outputs.Gathered(study.channels, system, rows) if study.channels else None
        filtered = FilteredRows(case, system) if study.wants("assessment") else None

        def sink(block):
            window(block)
            if gathered:
                gathered(block)

        outcome = simulate(case, system, sink, None, filtered)
        if outcome.fault:
            raise BrokenOff(outcome.fault)
        found = gathered.values() if gathered else {}
        if study.wants("end") and stretch is not None and window.count:
            found |= outputs.of_motion("end", steady_values.means(system, stretch, window), sides_of(stretch))
            found |= outputs.of_swing(steady_values.peaks_to_peaks(system, stretch, window))
        if filtered is None:
            return found, "", ""
        filtered.finish()
        judged, verdict, cause = _judged(filtered, self._given.limits)
        return found | judged, verdict, cause


class BrokenOff(RailcliError):
    """A run ended before its time."""


def _steady(case, system, stretch):
    if stretch is None or not case.final_speed:
        raise InputError(
            case.name, f"has no steady motion: its last {case.average_over:g} m are not one straight or curve at one "
            "speed; ask for end, assessment or, of a stop, statistics of channels (docs/sweep.md)"
        )  # fmt: skip
    return outputs.of_motion("steady", motion_of(case, system, stretch), sides_of(stretch))


def _judged(filtered, limits):
    """Figures by name; verdict: the worst of them; what fails."""
    from railcli.analysis.assess import assess  # SciPy's filters take a second to load
    from railcli.report.assess import SHOWN

    if filtered.filtered is None:
        return {}, "", ""
    outcome = assess(filtered, limits, fault="")
    found, over = {}, []
    for one in outcome.values:
        factor = SHOWN.get(FIGURES[one.key].unit, 1.0)
        found[outputs.figure_name(one.key)] = None if one.value is None else one.value * factor
        if one.status == "fail":
            over.append(f"{FIGURES[one.key].title} at {100.0 * one.value / one.limit:.0f} % of its limit")
    verdict = next((word for word in ("fail", "warn", "pass") if outcome.count(word)), "")
    return found, verdict, "; ".join(over)


def _number(value):
    """A finite number, else None."""
    if value is None:
        return None
    value = float(value)
    return value if value - value == 0.0 else None
