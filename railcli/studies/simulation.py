"""A run step by step: advance, read, go back."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railcli.analysis.faults import copied, verdict
from railcli.analysis.simulate import BLOCK_TIME, KEPT, start_of_run
from railcli.errors import InputError, SimulationError
from railcli.files import state as state_files
from railcli.files.results import BODY_CHANNELS, Recorded, recorded
from railcli.kernels.layout import Data
from railcli.kernels.recording import new_rows, new_stream
from railcli.kernels.step import record_rows
from railcli.model.checks import hint
from railcli.model.scenario import Scenario, divides

from .run import prepare
from .voice import SILENT, Voice

AT_THE_START = ("time", *BODY_CHANNELS)  # channels that are known before the first step
LONGEST = 3600.0  # that one call advances [s]
ROW = "row_"  # before the names of the arrays of the row at hand


class State:
    """What a simulation is at an instant: hand it to `Simulation.restore`."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self.arrays = MappingProxyType({name: array.copy() for name, array in arrays.items()})

    @property
    def time(self) -> float:
        """[s]"""
        return float(self.arrays["clock"][0])

    def __eq__(self, other: object) -> bool:
        """Whether two states are the same bit by bit."""
        return isinstance(other, State) and self._bits() == other._bits()

    def __hash__(self) -> int:
        return hash(self.time)

    def _bits(self) -> dict[str, bytes]:
        return {name: array.tobytes() for name, array in self.arrays.items()}

    def __repr__(self) -> str:
        return f"<State at {self.time:g} s>"


class Simulation:
    """A scenario that is advanced by hand, from where `railcli run` begins.

    Parameters
    ----------
    scenario : Scenario
    voice : Voice, optional

    Raises
    ------
    InputError, SimulationError
        As a run.

    Notes
    -----
    What is read is a row of a run whose output interval is the last advance: coordinates and velocities at its end,
    forces and accelerations as means over its steps, with their extremes in ``..._least`` and ``..._greatest``.
    """

    def __init__(self, scenario: Scenario, voice: Voice = SILENT) -> None:
        prepared = prepare(scenario, voice)
        self.scenario, system = prepared.scenario, prepared.system
        if self.scenario.run.course is not None:
            system = system.following(*self.scenario.run.course.knots())
        self._system = system
        self._data = start_of_run(self.scenario, system)
        self._rows = new_rows(system.model, 1)
        self._advanced = False
        self._begin()

    def _begin(self) -> None:
        self._channels: dict[str, Recorded] = {one.name: one for one in recorded(self._system)}
        self._stream = new_stream(self._system.model)
        self._kept: deque[Data] = deque(maxlen=KEPT)
        self._fault = ""

    @property
    def step(self) -> float:
        """Time step [s]."""
        return float(self._system.model.param[0]["step"])

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._data.clock[0])

    @property
    def distance(self) -> float:
        """Arc length of the first body [m]."""
        return float(self._data.q[0, 0])

    @property
    def speed(self) -> float:
        """Of the first body along the track [m/s]."""
        return float(self._data.v[0, 0])

    @property
    def channels(self) -> dict[str, str]:
        """Unit of every channel by its name."""
        return {name: one.units for name, one in self._channels.items()}

    def advance(self, seconds: float) -> None:
        """Go on for a time.

        Parameters
        ----------
        seconds : float
            A whole number of steps.

        Raises
        ------
        SimulationError
            The motion cannot go on; earlier states can be restored.
        """
        if self._fault:
            raise SimulationError(f"{self._fault}; restore an earlier state")
        if not 0.0 < seconds <= LONGEST or not divides(self.step, seconds):
            raise InputError(
                "advance", f"{seconds:g} s is no whole number of steps of {self.step:g} s, or not above 0 and at most "
                f"{LONGEST:g} s"
            )  # fmt: skip
        data = self._data
        if not self._kept or data.clock[0] - self._kept[-1].clock[0] > (1.0 - 1e-9) * BLOCK_TIME:
            self._kept.append(copied(data))
        _, status = record_rows(self._system.model, data, self._rows, self._stream, round(seconds / self.step))
        self._advanced = True
        if status:
            self._fault = verdict(self._system, data, status, self._kept[0])
            raise SimulationError(self._fault)

    def read(self, name: str) -> Any:
        """A channel as the last advance left it.

        Parameters
        ----------
        name : str
            Such as ``wheels/W1_right/Q`` or ``bodies/car body/position``: the names of results
            (docs/nomenclature.md); `channels` lists them.

        Returns
        -------
        float or numpy.ndarray
            A number, or those of x, y and z or of every contact patch; SI.
        """
        if name not in self._channels:
            raise InputError(f"channel {name!r}", f"there is none; {hint(name, self._channels)}")
        if not self._advanced:
            if name.rpartition("/")[2] not in AT_THE_START:
                raise InputError(f"channel {name!r}", "is known after the first advance only")
            rows = self._rows
            rows.time[0], rows.q[0], rows.v[0] = self._data.clock[0], self._data.q, self._data.v
        value = self._channels[name].source(self._rows)[0]
        return value.copy() if np.ndim(value) else float(value)

    @property
    def inputs(self) -> dict[str, str]:
        """What can be commanded by hand: name and what it is. Nothing that a driver or controller already commands."""
        scenario, found = self.scenario, {}
        if scenario.brake is not None and scenario.driver.kind == "coast":
            found["train/brake_demand"] = "0 to 1"
        if scenario.traction is not None and scenario.driver.kind == "coast":
            found["train/traction_demand"] = "0 to 1"
        for a in range(self._system.model.axle.size):
            if scenario.brake is not None and scenario.brake.valves is not None and scenario.slide_protection is None:
                found[f"axles/W{a + 1}/valve"] = "0 fill, 1 hold, 2 vent"
            if scenario.traction is not None and scenario.anti_slip is None:
                found[f"axles/W{a + 1}/torque_share"] = "0 to 1: of the demanded traction torque"
        return found

    def command(self, name: str, value: float) -> None:
        """Set an input of brake or traction; it stands until it is set again.

        Parameters
        ----------
        name : str
            One of `inputs`.
        value : float

        Raises
        ------
        InputError
            There is no such input, or the value is out of its range.
        """
        if name not in self.inputs:
            none = 'this scenario leaves none to you; driver kind "coast" does'
            what = hint(name, self.inputs) if self.inputs else none
            raise InputError(f"input {name!r}", f"there is none; {what}")
        group, _, port = name.rpartition("/")
        allowed = (0, 1, 2) if port == "valve" else None
        if not (value in allowed if allowed else 0.0 <= value <= 1.0):
            raise InputError(f"input {name!r}", f"must be {self.inputs[name]}, got {value!r}")
        record = self._data.train[0] if group == "train" else self._data.port[int(group.rpartition("W")[2]) - 1]
        record[port] = value

    def state(self) -> State:
        """The state of this instant."""
        return State(self._arrays())

    def _arrays(self) -> dict[str, NDArray[Any]]:
        rows = {ROW + name: array for name, array in self._rows._asdict().items()}
        more = {"past": self._stream.past, "advanced": np.array([self._advanced])}
        return {**self._data._asdict(), **rows, **more}

    def restore(self, state: State) -> None:
        """Go back, or on, to a state of a simulation of this scenario; what follows is the same bit by bit."""
        self._begin()
        arrays = self._arrays()
        other = {name: array.shape for name, array in state.arrays.items()}
        if other != {name: array.shape for name, array in arrays.items()}:
            raise InputError("restore", "the state belongs to another scenario")
        for name, array in arrays.items():
            array[...] = state.arrays[name]
        self._advanced = bool(state.arrays["advanced"][0])

    def copy(self) -> Simulation:
        """Another simulation in the same state, which goes its own way."""
        other = object.__new__(type(self))
        other.scenario, other._system, other._advanced = self.scenario, self._system, self._advanced
        other._data = copied(self._data)
        other._rows = type(self._rows)(*(array.copy() for array in self._rows))
        other._begin()
        other._stream.past[...], other._fault = self._stream.past, self._fault
        return other

    def save(self, path: str | PathLike[str]) -> None:
        """Write the state to a file."""
        state_files.save(Path(path), self._arrays(), self.scenario.digest())

    def restore_from(self, path: str | PathLike[str]) -> None:
        """Restore the state that a file holds.

        Raises
        ------
        InputError
            It is missing, damaged, or of another scenario or version.
        """
        self.restore(State(state_files.read(path, self.scenario.digest())))

    def __repr__(self) -> str:
        return f"<Simulation of {self.scenario.name} at {self.time:g} s, {self.distance:.6g} m>"
