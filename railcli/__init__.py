"""railcli: three-dimensional railway vehicle dynamics in real time, open and checkable.

What a Python user needs stands here and is imported when it is asked for; docs/python.md shows it.
"""

__version__ = "0.1.0"
TYPE_CHECKING = False  # what type checkers take as true; the module `typing` is not needed for it

if TYPE_CHECKING:
    from railcli.door import (
        Answer,
        CheckError,
        InputError,
        RailcliError,
        Results,
        Scenario,
        Simulation,
        SimulationError,
        State,
        Swept,
        Vehicle,
        assess,
        build_table,
        conicity,
        critical_speed,
        load,
        load_vehicle,
        modes,
        open_results,
        run,
        steady,
        sweep,
        validate,
    )

__all__ = [
    "Answer",
    "CheckError",
    "InputError",
    "RailcliError",
    "Results",
    "Scenario",
    "Simulation",
    "SimulationError",
    "State",
    "Swept",
    "Vehicle",
    "assess",
    "build_table",
    "conicity",
    "critical_speed",
    "load",
    "load_vehicle",
    "modes",
    "open_results",
    "run",
    "steady",
    "sweep",
    "validate",
]


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from railcli import door

    return getattr(door, name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
