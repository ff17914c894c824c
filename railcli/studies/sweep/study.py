"""A parameter study from its file to its table: planned, made by workers, kept row by row, told."""

import os
import signal
import threading
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import NamedTuple

from railcli import __version__
from railcli.analysis.design import SEED, Design, seeds_of, spread
from railcli.analysis.warm import is_warm, warm
from railcli.errors import InputError
from railcli.files.changes import changed
from railcli.files.embed import data_uri
from railcli.files.limits import load_limits
from railcli.files.output import write_json, write_text
from railcli.files.study import vehicles
from railcli.files.sweep import JOURNAL, STUDY, Journal, frame, keep, study_folder, write_tables
from railcli.kernels import jit
from railcli.model.assessment import Limits
from railcli.studies.tables import tables_for
from railcli.studies.voice import SILENT

from . import outputs
from .answer import Swept
from .one_run import FAILED, Given, Runner
from .processes import Processes

UNASKED = 10_000  # runs that are made without a question
TRIED = 20  # points of a study that are looked at before it begins
SUMMARY = "summary.json"


class Plan(NamedTuple):
    """A study ready to be made."""

    given: Given
    design: Design
    vehicles: dict  # what the files hold that name vehicles among the values

    def task(self, number):
        """Number, inputs and changes of a run."""
        point = self.design.point(number)
        return number, point, self.changes(point)

    def changes(self, point):
        """Values by dotted key of a point."""
        found = {key: point[one.name] for one in self.given.study.parameters for key in one.keys}
        if isinstance(name := found.get("vehicle"), str):
            found["vehicle"] = self.vehicles.get(name, name)
        return found | (seeds_of(self.given.scenario, point[SEED]) if SEED in point else {})


def sweep(study, scenario, folder=None, workers=None, scheduler=None, sure=False, overwrite=False, figures=True,
          voice=SILENT):  # fmt: skip
    """Make every run of a study that is not yet made, and put its rows into tables.

    Parameters
    ----------
    study : Study
    scenario : Scenario
        That it varies.
    folder : path-like, optional
        One in which the same study was begun is taken up; a new one in ``railcli-out`` by default.
    workers : int, optional
        Processes; as many as there are processors by default. 0: in this process.
    scheduler : str, optional
        Address of a dask scheduler whose workers make the runs.
    sure : bool
        However many runs there are.
    overwrite : bool
        Begin anew in a folder in which there is a study.
    figures : bool
        Draw, and make the page.
    voice : Voice

    Returns
    -------
    Swept

    Raises
    ------
    InputError
        Something that is given cannot be used; more than UNASKED runs, and nobody is sure.
    """
    plan = planned(study, scenario)
    _look_twice(plan, sure, workers)
    record = record_of(plan)
    with study_folder(study.name, record, folder, overwrite) as place, Journal(place) as journal:
        if not (place / STUDY).is_file():
            keep(place, record, scenario)
        if len(journal.rows) < plan.design.count:
            with _terminable():
                _make(plan, place, journal, workers, scheduler, voice)
        return _told(plan, place, journal.rows, figures, voice)


def planned(study, scenario):
    """The Plan of a study; an InputError when no run of it can be made."""
    limits = load_limits(study.limits) if study.limits else Limits()
    plan = Plan(Given(study, scenario, limits), Design(study), vehicles(study))
    outputs.check(study, outputs.names(len(scenario.vehicle.wheelsets)))
    first = None
    for number in spread(plan.design.count, TRIED) if plan.design.count <= UNASKED else [0]:
        try:
            changed(scenario, plan.task(number)[2])
            return plan
        except InputError as error:
            first = first or error
    raise first


def _look_twice(plan, sure, workers):
    """Ask before very many runs, with how long they take."""
    count = plan.design.count
    if sure or count <= UNASKED:
        return
    few = plan.given.study.model_copy(update={"sample": plan.given.study.sample and _smallest(plan.given.study.sample)})
    trial = planned(few, plan.given.scenario)
    row = Runner(trial.given).row(*trial.task(0))
    row = Runner(trial.given).row(*trial.task(0)) if row["time_s"] else row
    hands = workers or os.cpu_count() or 1
    raise InputError(
        plan.given.study.name, f"asks for {count:,} runs: at {row['time_s']:.2g} s each, as the first one took, "
        f"{_long(count * row['time_s'] / hands)} with {hands} processes; add --yes if that is meant"
    )  # fmt: skip


def _smallest(sample):
    return sample.model_copy(update={"count": 2})


def _long(seconds):
    """A time in the unit that suits it."""
    for unit, length in (("years", 365.25 * 86400), ("days", 86400), ("hours", 3600), ("minutes", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:,.0f} {unit}"
    return f"{seconds:.0f} s"


def record_of(plan):
    """What study.json holds of a study."""
    study, scenario, limits = plan.given
    described = study.model_dump(mode="json", by_alias=True, exclude_none=True)
    matters = {key: value for key, value in described.items() if key not in ("name", "title", "description", "figures")}
    return {
        "study": described,
        "scenario": {"name": scenario.name, "title": scenario.title},
        "runs": plan.design.count,
        "identity": {
            "study": {key: value for key, value in matters.items() if key not in ("scenario", "limits")},
            "scenario": scenario.digest(),
            "points": plan.design.digest(),
            "files": {place: content if isinstance(content, str) else content.digest()
                      for place, content in scenario.contents.items()},
            "vehicles": plan.vehicles,
            "limits": limits.model_dump(mode="json"),
            "railcli": __version__,
            "kernels": jit.source_digest(),
        },
    }  # fmt: skip


@contextmanager
def _terminable():
    """SIGTERM ends a study as Ctrl-C does: what is finished stays."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "SIGTERM"):
        yield
        return

    def end(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _make(plan, place, journal, workers, scheduler, voice):
    """Make the runs that the journal lacks."""
    missing = [number for number in range(plan.design.count) if number not in journal.rows]
    total, failed = plan.design.count, sum(row["status"] == FAILED for row in journal.rows.values())
    if journal.rows:
        voice.announce(f"{len(journal.rows):,} of {total:,} runs are there; going on with {len(missing):,}.")
    try:
        with _hands(plan, place, len(missing), workers, scheduler, voice) as hands:
            with voice.job("Sweep", len(missing), "runs") as job:
                for done, row in enumerate(hands.rows(map(plan.task, missing)), start=1):
                    journal.add(row)
                    failed += row["status"] == FAILED
                    job.update(done, f"{failed:,} failed" if failed else "")
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"{len(journal.rows):,} of {total:,} runs are kept in {place / JOURNAL}; the same command with "
            f"-o {place} goes on."
        ) from None


def _hands(plan, place, count, workers, scheduler, voice):
    """What makes the runs: processes, a cluster, or this process."""
    if scheduler is not None:
        from .cluster import Cluster

        return Cluster(scheduler, place, voice)
    if not is_warm():
        warm(voice.announce)
    _build_tables(plan, voice)
    if workers == 0:
        return _Here(plan, voice)
    return Processes(place, min(workers or os.cpu_count() or 1, count), voice)


def _build_tables(plan, voice):
    """Have the tables of the first run built before many ask for them at once."""
    try:
        tables_for(changed(plan.given.scenario, plan.task(0)[2]), voice)
    except InputError:
        pass  # that run says so in its row


class _Here:
    """This process as the only worker."""

    def __init__(self, plan, voice):
        self._plan, self._voice = plan, voice
        self.about = "this process"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def rows(self, tasks):
        runner = Runner(self._plan.given, self._voice)
        for task in tasks:
            yield runner.row(*task)


def _told(plan, place, rows, figures, voice):
    """Tables, figures and the Answer of a study whose runs are made."""
    from railcli.report import sweep as report

    study, scenario, design = plan.given.study, plan.given.scenario, plan.design
    table = frame(rows)
    files = [STUDY, JOURNAL, *write_tables(table, place)]
    found, notes = _indices(study, design, table)
    if figures:
        more, said = _drawn(plan, place, table, found, files, voice)
        files, notes = files + more, notes + said
    record = report.summary(study, scenario, design, table, found)
    write_json(place / SUMMARY, record)
    lines = report.lines(study, scenario, design, table, found)
    record["folder"] = place
    told = [*lines, "", *notes, f"Written to {place}: {', '.join([*files, SUMMARY])}"]
    return Swept(record, told, place, table)


def _indices(study, design, table):
    """Sobol indices of a sample, and what must be said where there can be none."""
    from railcli.report import sensitivity
    from railcli.report.sweep import shown

    try:
        return sensitivity.indices(study, design, table, shown(study, design, table)), []
    except InputError as error:
        return {}, [f"No {error}"]


def _drawn(plan, place, table, found, files, voice):
    """Draw the figures and write the page; names of the files, and what must be said."""
    from railcli.report import sweep_figures, sweep_page

    given, pictures = plan.given, []
    wanted = sweep_figures.figures(given.study, plan.design, table, found)
    with voice.job("Figures", max(len(wanted), 1), "figures") as job:
        for done, one in enumerate(wanted, start=1):
            path = place / f"{one.name}.png"
            one.write(path)
            pictures.append({"name": one.name, "title": one.title, "caption": one.caption, "file": path.name,
                             "uri": data_uri(path)})  # fmt: skip
            job.update(done)
    names = [picture["file"] for picture in pictures]
    date = datetime.now(UTC).isoformat(timespec="seconds")
    try:
        page = sweep_page.render(
            given.study, given.scenario, plan.design, table, found, pictures, files, __version__, date
        )
    except InputError as error:
        return names, [f"No page: {error}"]
    write_text(place / sweep_page.NAME, page)
    return [*names, sweep_page.NAME], []
