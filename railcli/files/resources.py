"""Where the files that come with railcli are."""

from pathlib import Path

from railcli.errors import InputError

CASES = ("benchmarks/manchester/cases", "benchmarks/braking/cases", "vehicles/y25/cases", "vehicles/locomotive/cases")
VEHICLES = {
    "manchester": "benchmarks/manchester/vehicle.toml",
    "y25-empty": "vehicles/y25/empty.toml",
    "y25-laden": "vehicles/y25/laden.toml",
    "locomotive": "vehicles/locomotive/vehicle.toml",
}
BUNDLED = {
    "UIC60": ("rail", "profiles/UIC60/UIC60.csv"),
    "60E1": ("rail", "profiles/UIC60/60E1.csv"),
    "ORES1002": ("wheel", "profiles/ORES1002/ORES1002.csv"),
}
_PACKAGE = Path(__file__).resolve().parents[1]
_ROOTS = (_PACKAGE / "_data", _PACKAGE.parent)  # in an installed package; beside the package in a checkout


def resource(relative):
    """Path of a bundled file or folder, for example ``profiles/UIC60/UIC60.csv``."""
    for root in _ROOTS:
        if (root / relative).exists():
            return root / relative
    raise InputError(relative, "this file comes with railcli but is missing here; install railcli again")


def scenario_files():
    """File of each scenario that railcli brings along, by name."""
    return {path.stem: path for folder in CASES for path in sorted(resource(folder).glob("*.toml"))}
