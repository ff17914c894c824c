"""The door for Python users: what `import railcli` gives (docs/python.md).

Objects are changed by copies; keys are those of files, with their units. Errors are the one-line errors of the command.
"""

from __future__ import annotations

import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from railcli.errors import CheckError, InputError, RailcliError, SimulationError
from railcli.files import changes as file_changes
from railcli.files import columns as file_columns
from railcli.files import output, read_results
from railcli.files import scenario as scenario_files
from railcli.files.limits import load_limits
from railcli.model import scenario as scenario_model
from railcli.model import vehicle as vehicle_model
from railcli.model.assessment import Limits
from railcli.model.checks import hint
from railcli.studies.answer import Answer
from railcli.studies.simulation import Simulation as SimulationStudy
from railcli.studies.simulation import State
from railcli.studies.sweep.answer import Swept
from railcli.studies.voice import SILENT, Told, Voice

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = [
    "Answer", "CheckError", "InputError", "RailcliError", "Results", "Scenario", "Simulation", "SimulationError",
    "State", "Swept", "Vehicle", "assess", "build_table", "conicity", "critical_speed", "load", "load_vehicle", "modes",
    "open_results", "run", "steady", "sweep", "validate",
]  # fmt: skip

Place = str | PathLike[str]
Progress = Callable[[str, float, str], None]


class Vehicle:
    """A vehicle; changed by copies.

    Parameters
    ----------
    model : railcli.model.vehicle.Vehicle
        The validated description, SI; `load_vehicle` reads one.
    """

    def __init__(self, model: vehicle_model.Vehicle) -> None:
        self.model = model

    @property
    def name(self) -> str:
        return self.model.name

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Vehicle:
        """The same vehicle with other values: ``vehicle.replace({"body[car body].mass_t": 20})``."""
        return Vehicle(file_changes.changed(self.model, {**(changes or {}), **more}))

    def __getitem__(self, key: str) -> Any:
        """A value by its key in a file, in the unit that the key names."""
        return file_changes.value_of(self.model, key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Vehicle) and bool(self.model == other.model)

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"<Vehicle {self.name!r}: {len(self.model.bodies)} bodies, {len(self.model.wheelsets)} wheelsets>"

    def _repr_html_(self) -> str:
        from railcli.report import notebook

        return notebook.vehicle(self.model)


class Scenario:
    """A scenario; changed by copies.

    Parameters
    ----------
    model : railcli.model.scenario.Scenario
        The validated description, SI; `load` reads one.
    """

    def __init__(self, model: scenario_model.Scenario) -> None:
        self.model = model

    @property
    def name(self) -> str:
        return self.model.name

    @property
    def title(self) -> str:
        return self.model.title

    @property
    def vehicle(self) -> Vehicle:
        return Vehicle(self.model.vehicle)

    def replace(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Scenario:
        """The same scenario with other values, validated.

        Parameters
        ----------
        changes : dict, optional
            Value by dotted key as in a file, with its unit: ``{"contact.friction": 0.2, "track[2].length_m": 50}``.
            None: the default again.
        **more
            Keys of the scenario itself and of its tables run, contact, start, limits and track_support, which need no
            dot: ``scenario.replace(speed_kmh=90, friction=0.2)``.

        Raises
        ------
        InputError
            The first thing that is wrong.
        """
        every = {**(changes or {}), **more}
        inside = {key: value.model if isinstance(value, Vehicle) else value for key, value in every.items()}
        return Scenario(file_changes.changed(self.model, inside))

    def __getitem__(self, key: str) -> Any:
        """A value by its key in a file, in the unit that the key names: ``scenario["speed_kmh"]``."""
        return file_changes.value_of(self.model, key)

    def digest(self) -> str:
        """Of all that decides the results, 16 digits."""
        return str(self.model.digest())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scenario) and self.digest() == other.digest()

    def __hash__(self) -> int:
        return hash(self.digest())

    def __repr__(self) -> str:
        return f"<Scenario {self.name!r}: {self.title}>" if self.title else f"<Scenario {self.name!r}>"

    def _repr_html_(self) -> str:
        from railcli.report import notebook

        return notebook.scenario(self.model)


AnyScenario = Scenario | str | PathLike[str] | Mapping[str, Any]


class Results:
    """Results of a run, read when they are asked for.

    Parameters
    ----------
    path : path-like
        Folder that a run wrote.

    Raises
    ------
    InputError
        There is no result, or it is damaged.
    """

    def __init__(self, path: Place) -> None:
        with read_results.Results(path) as found:
            self.folder: Path = found.folder
            self.summary: dict[str, Any] = found.summary
            self.fault: str = found.fault
            self.channels: dict[str, str] = {name: one.units for name, one in found.channels.items()}

    @property
    def scenario(self) -> Scenario:
        """What was run."""
        with read_results.Results(self.folder) as found:
            return Scenario(found.scenario)

    def read(self, name: str) -> NDArray[Any]:
        """A channel, all rows: (n,) or (n, components), SI, track axes."""
        with read_results.Results(self.folder) as found:
            if name not in found.channels:
                raise InputError(f"channel {name!r}", f"no such channel in {self.folder}; {hint(name, found.channels)}")
            values: NDArray[Any] = found.read(name)
            return values

    def frame(self, *channels: str, filtered: bool = False) -> DataFrame:
        """Channels by globs as a DataFrame; as `open_results`."""
        return open_results(self.folder, *channels, filtered=filtered)

    def __repr__(self) -> str:
        return f"<Results in {self.folder}{': broken off' if self.fault else ''}>"

    def _repr_html_(self) -> str:
        from railcli.report import notebook

        return notebook.results(self.folder, self.summary)


class Simulation(SimulationStudy):
    """A scenario that is advanced by hand: `advance`, `read`, `state` and `restore`, `copy`, `save`.

    Parameters
    ----------
    scenario : Scenario, name, file or dict
    progress : callable, optional
        As of `run`.
    """

    def __init__(self, scenario: AnyScenario, progress: Progress | None = None) -> None:
        super().__init__(_model(scenario), _voice(progress))


def load(scenario: str | PathLike[str] | Mapping[str, Any]) -> Scenario:
    """A scenario by its name, from its file, or from a dictionary that holds what a file would.

    Raises
    ------
    InputError
        One line: file, key, what was found, what is allowed.
    """
    return Scenario(scenario_files.load(_given(scenario)))


def load_vehicle(vehicle: str | PathLike[str] | Mapping[str, Any]) -> Vehicle:
    """A vehicle by its name, from its file, or from a dictionary that holds what a file would."""
    return Vehicle(scenario_files.load_vehicle(_given(vehicle)))


def build_table(scenario: AnyScenario, progress: Progress | None = None) -> list[Any]:
    """Have the contact tables of a scenario built where the cache does not hold them; the ContactTables."""
    from railcli.studies.tables import tables_for

    return list(tables_for(_model(scenario), _voice(progress)))


def run(
    scenario: AnyScenario,
    folder: Place | None = None,
    progress: Progress | None = None,
    *,
    overwrite: bool = False,
    figures: bool = False,
    assessment: bool = True,
    contact: Sequence[str] = ("*",),
) -> Results:
    """Run a scenario, as `railcli run scenario`.

    Parameters
    ----------
    scenario : Scenario, name, file or dict
    folder : path-like, optional
        Results folder; without it one that vanishes with the Results.
    progress : callable, optional
        Called with the title of a job, the share of it that is done, and a text.
    overwrite : bool
        Replace what railcli wrote into the folder before.
    figures, assessment : bool
        Draw the time series into the folder; judge them.
    contact : sequence of str
        Globs of the channels of contact patches to record.

    Raises
    ------
    InputError
        Something given cannot be used.
    SimulationError
        The run broke off; its attribute `results` holds what was computed.
    """
    from railcli.studies.run import run as study

    model, voice = _model(scenario), _voice(progress)
    temporary = tempfile.mkdtemp(prefix="railcli-") if folder is None else None
    try:
        with output.results_folder("run", model.name, folder or f"{temporary}/results", overwrite) as into:
            answer = study(model, into, contact, figures, assessment, voice)
        results = Results(into) if answer["rows"] else None
    except KeyboardInterrupt as stop:
        _vanish(temporary)
        raise KeyboardInterrupt(*(() if temporary else stop.args)) from None
    except BaseException:
        _vanish(temporary)
        raise
    if results is None:
        _vanish(temporary)
    elif temporary:
        weakref.finalize(results, _vanish, temporary)
    if results is None or answer["fault"]:
        error = SimulationError(f"{model.name}: {answer['fault']}")
        error.results = results
        raise error
    return results


def _vanish(folder: str | None) -> None:
    if folder:
        shutil.rmtree(folder, ignore_errors=True)


def steady(scenario: AnyScenario, progress: Progress | None = None) -> Answer:
    """The steady motion in which a run would end, by Newton's method, in no time."""
    from railcli.studies.steady import steady as study

    return study(_model(scenario), _voice(progress))


def modes(
    scenario: AnyScenario,
    folder: Place | None = None,
    progress: Progress | None = None,
    *,
    amplitude_mm: float = 3.0,
    response: bool = False,
    overwrite: bool = False,
) -> Answer:
    """Eigenmodes, as `railcli modes`."""
    from railcli.studies.modes import modes as study

    model, voice = _model(scenario), _voice(progress)
    return _into("modes", model.name, folder, overwrite,
                 lambda into: study(model, amplitude_mm, response, folder=into, voice=voice))  # fmt: skip


def critical_speed(
    scenario: AnyScenario,
    folder: Place | None = None,
    progress: Progress | None = None,
    *,
    amplitudes_mm: Iterable[float] = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
    speeds_m_per_s: tuple[float, float, float] = (10.0, 150.0, 5.0),
    linear_only: bool = False,
    overwrite: bool = False,
) -> Answer:
    """Critical speed, as `railcli critical-speed`; speeds_m_per_s: lowest, highest, step."""
    from railcli.studies.critical_speed import Span
    from railcli.studies.critical_speed import critical_speed as study

    model, voice, span = _model(scenario), _voice(progress), Span(*speeds_m_per_s)
    wanted = list(amplitudes_mm)
    answer, fault = _into("critical-speed", model.name, folder, overwrite,
                          lambda into: study(model, wanted, span, None, linear_only, into, voice=voice))  # fmt: skip
    if fault is not None:
        raise fault
    return answer


def conicity(
    scenario: AnyScenario,
    folder: Place | None = None,
    progress: Progress | None = None,
    *,
    amplitudes_mm: Iterable[float] = tuple(range(1, 11)),
    curves_m: Iterable[float] = (300.0, 500.0, 1000.0),
    roll: bool = False,
    overwrite: bool = False,
) -> Answer:
    """Equivalent conicity of the first wheelset of a scenario on its track, as `railcli conicity`."""
    from railcli.studies.conicity import conicity as study
    from railcli.studies.conicity import mounted_of

    model, voice = _model(scenario), _voice(progress)
    wheelset, amplitudes, radii = mounted_of(model), sorted(amplitudes_mm), list(curves_m)
    given = wheelset, amplitudes, radii, roll, None
    return _into("conicity", model.name, folder, overwrite,
                 lambda into: study(*given, into, into is not None, voice))  # fmt: skip


def assess(
    results: Results | Place,
    limits: Mapping[str, Any] | Place | None = None,
    folder: Place | None = None,
    *,
    overwrite: bool = False,
) -> Answer:
    """Judge results, as `railcli assess`; limits: a TOML file or what it would hold."""
    from railcli.files import toml
    from railcli.studies.assess import assess as study

    if isinstance(limits, Mapping):
        bounds = toml.build(Limits, dict(limits), "limits")
    else:
        bounds = Limits() if limits is None else load_limits(limits)
    path = results.folder if isinstance(results, Results) else Path(results)
    answer, _ = _into("assess", path.name, folder, overwrite, lambda into: study([path], bounds, into))
    return Answer(answer["results"][0], answer.lines, answer.folder)


def validate(
    name: str,
    folder: Place | None = None,
    progress: Progress | None = None,
    *,
    overwrite: bool = False,
    **options: Any,
) -> Answer:
    """Compare with published results, as `railcli validate NAME`.

    Raises
    ------
    CheckError
        A criterion is missed; its attribute `answer` holds the comparison.
    """
    from railcli.studies.validate import COMPARISONS
    from railcli.studies.validate import validate as study

    if name not in COMPARISONS:
        raise InputError(f"validate {name!r}", f"no such comparison; {hint(name, COMPARISONS)}")
    answer, rejection = _into("validate", name, folder, overwrite,
                              lambda into: study(name, into, voice=_voice(progress), **options))  # fmt: skip
    if rejection is not None:
        rejection.answer = answer
        raise rejection
    found: Answer = answer
    return found


def sweep(
    study: AnyScenario,
    folder: Place | None = None,
    progress: Progress | None = None,
    *,
    vary: Mapping[str, Any] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    sure: bool = False,
    overwrite: bool = False,
    figures: bool = False,
    **more: Any,
) -> Swept:
    """Make the runs of a study, as `railcli sweep` (docs/sweep.md): an Answer whose `frame` holds a row for each.

    Parameters
    ----------
    study : a study's name, file or dict, or a scenario
    vary : dict
        Values by key: a list, or a dict that holds what an entry of ``vary`` in a file would.
    workers, scheduler, sure, overwrite, figures
        Of `studies.sweep.study.sweep`.
    **more
        Further keys of a study: ``sample={"count": 64}``, ``seeds=5``, ``outputs=["steady.*"]``, ``channel=[...]``.
    """
    from railcli.studies.sweep.call import call

    source = study.model if isinstance(study, Scenario) else _given(study)
    place = None if folder is None else Path(folder)
    return call(source, place, dict(vary or {}), more, workers, scheduler, sure, overwrite, figures, _voice(progress))


def open_results(path: Place, *channels: str, filtered: bool = False) -> DataFrame:
    """Time series of a results folder as a pandas DataFrame.

    Parameters
    ----------
    path : path-like
        Folder that `railcli run` wrote, or the file of time series in it.
    *channels : str
        Globs of the channels to read, such as ``"wheels/*/Q"``; all without any.
    filtered : bool
        The low-passed rows at a fixed rate, of which an assessment is made, instead of those of the output interval.

    Returns
    -------
    pandas.DataFrame
        A row for each recorded instant, its index the time [s]. Columns are named by channel, component and unit, such
        as ``wheels/W1_right/Q [N]`` and ``bodies/car body/position/y [m]``; SI, in track axes: x forward, y to the
        right, z down; forces of a wheel act on its rail.

    Raises
    ------
    InputError
        There is no result, it is damaged, or holds no such channel.
    """
    with read_results.Results(path) as results:
        rows = file_columns.chosen_rows(results, filtered)
        return file_columns.data_frame(rows, file_columns.columns(rows, channels))


def _given(source: str | PathLike[str] | Mapping[str, Any]) -> str | dict[str, Any]:
    return dict(source) if isinstance(source, Mapping) else fspath(source)


def _model(scenario: AnyScenario) -> scenario_model.Scenario:
    return (scenario if isinstance(scenario, Scenario) else load(scenario)).model


def _voice(progress: Progress | None) -> Voice:
    return SILENT if progress is None else Told(progress)


def _into(command: str, name: str, folder: Place | None, overwrite: bool, study: Callable[[Path | None], Any]) -> Any:
    """What a study gives that writes into a folder, or nowhere."""
    if folder is None:
        return study(None)
    with output.results_folder(command, name, folder, overwrite) as into:
        return study(into)
