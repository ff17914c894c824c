"""A user's own controller: a Python file named on the command line, compiled into the guest slot of the core.

The file defines ``control(time, axles, state, out)`` (docs/subsystems.md, 10). It is the one file of a user that is
code. It may not allocate, and every access to its arrays is checked.
"""

import hashlib
import inspect
import runpy
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from numba import carray, types
from numba.core.errors import NumbaError

from railcli.errors import InputError
from railcli.kernels.assembly_layout import GUEST_INPUTS, GUEST_OUTPUTS, GUEST_STATE
from railcli.kernels.jit import guest, outward
from railcli.kernels.layout import freeze
from railcli.model.controls import SpeedSensor
from railcli.model.subsystems import is_multiple

NAME, ARGUMENTS = "control", ("time", "axles", "state", "out")
_TABLE, _ROW = types.Array(types.float64, 2, "C"), types.Array(types.float64, 1, "C")
_SIGNATURE = types.int64(types.float64, types.int64, types.CPointer(types.float64))


class Guest(NamedTuple):
    """A compiled controller; the core calls it as long as this object lives."""

    path: Path
    digest: str  # of the file, 16 digits
    period: float | None  # at which it acts [s]; None: the scenario's
    code: object

    @property
    def address(self):
        return int(self.code.address)


def load_guest(path):
    """Compile a guest.

    Raises
    ------
    InputError
        The file cannot be read or run, defines no such function, or the function does not compile or allocates.
    """
    path = Path(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from None
    try:
        names = runpy.run_path(str(path))
    except Exception as error:
        raise InputError(path, f"cannot be run: {type(error).__name__}: {_first_line(error)}") from None
    function, period = names.get(NAME), names.get("PERIOD_MS")
    if not inspect.isfunction(function) or tuple(inspect.signature(function).parameters) != ARGUMENTS:
        raise InputError(path, f"must define a function {NAME}({', '.join(ARGUMENTS)})")
    if period is not None and not (isinstance(period, int | float) and 0.1 <= period <= 1000.0):
        raise InputError(path, f"PERIOD_MS: must be a number from 0.1 to 1000, got {period!r}")
    return Guest(path, hashlib.sha256(text).hexdigest()[:16], None if period is None else 1e-3 * period,
                 _compiled(function, path))  # fmt: skip


def _compiled(function, path):
    try:
        own = guest(function, (types.float64, _TABLE, _ROW, _TABLE))
    except NumbaError as error:
        raise InputError(
            path, f"{NAME} cannot be compiled: {_reason(error)}; numbers, loops and its own arrays are what it may use"
        ) from None
    inputs, outputs, state = GUEST_INPUTS, GUEST_OUTPUTS, GUEST_STATE

    def called(time, n, room):
        whole = carray(room, (state + n * (inputs + outputs),))
        kept = whole[:state]
        axles = whole[state : state + n * inputs].reshape((n, inputs))
        out = whole[state + n * inputs :].reshape((n, outputs))
        try:
            own(time, axles, kept, out)
        except Exception:
            return 1
        return 0

    return outward(called, _SIGNATURE)


def welcome(scenario, path):
    """The guest of a scenario that has something for it to control.

    Raises
    ------
    InputError
        As `load_guest`; or the scenario has a controller of its own, or neither dump valves nor motors.
    """
    if scenario.slide_protection is not None or scenario.anti_slip is not None:
        raise InputError(
            path, f"a guest controls in place of [slide_protection] and [anti_slip]; take them out of {scenario.name}"
        )
    if (scenario.brake is None or scenario.brake.valves is None) and scenario.traction is None:
        raise InputError(path, f"{scenario.name} has nothing to control: neither [brake.valves] nor [traction]")
    return load_guest(path)


def invited(system, controller, step):
    """The system with a Guest in its slot; step : of the run [s]."""
    assembly = system.model.assembly.copy()
    assembly["guest"] = controller.address
    if controller.period is not None:
        assembly["period"] = controller.period
    elif not assembly[0]["period"]:
        assembly["period"] = SpeedSensor().period
    every = float(assembly[0]["period"])
    if not is_multiple(every, step):
        raise InputError(
            controller.path, f"acts every {every * 1e3:g} ms, which is no whole number of steps of {step * 1e3:g} ms"
        )
    return replace(system, model=freeze(system.model._replace(assembly=assembly)), guest=controller)


def _reason(error):
    """What of a compiler's message helps: its first line that tells of the user's code."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    for line in lines:
        if line.startswith(("No implementation of function", "Cannot", "Untyped", "NameError", "Unknown attribute")):
            return line[:160]
    return lines[0][:160] if lines else type(error).__name__


def _first_line(error):
    return (str(error).splitlines() or [""])[0][:200]


