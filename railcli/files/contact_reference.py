"""What `railcli validate contact` compares with, in railcli's units and signs, and its criteria."""

import tomllib

import numpy as np

from railcli.analysis.contact_benchmark import SETTINGS, States, across
from railcli.analysis.contact_check import CreepStates, HertzCases, Published
from railcli.analysis.normal_check import NormalStates
from railcli.analysis.rigid_contact import wheelset_on
from railcli.errors import InputError

from .profile_import import ImportSettings, import_profile
from .resources import resource

FOLDER = "benchmarks/contact"
WHEEL, RAIL = "MBench_S1002_v3.prw", "MBench_UIC60_v3.prr"
MIRRORED = np.array([1.0, -1.0])  # right, left: what counts to the right, to the field side of either wheel
# Of the benchmark's columns: stem, unit in the file, factor to SI, and sign in railcli (for right and left).
# CONTACT lists the slip of rail over wheel; angles are about x, so a right wheel's is negative towards the flange.
BENCHMARK_COLUMNS = {
    "on_rail": ("yr", "mm", 1e-3, MIRRORED),
    "on_wheel": ("yw", "mm", 1e-3, MIRRORED),
    "z_wheel": ("zw", "mm", 1e-3, 1.0),
    "angle": ("delta", "deg", np.pi / 180.0, -MIRRORED),
    "area": ("area", "mm2", 1e-6, 1.0),
    "pressure": ("pmax", "MPa", 1e6, 1.0),
    "approach": ("approach", "um", 1e-6, 1.0),
    "normal": ("fn", "N", 1.0, 1.0),
    "x_force": ("fx", "N", 1.0, 1.0),
    "y_force": ("fy", "N", 1.0, 1.0),
    "xi": ("xi", "1e3", 1e-3, -1.0),
    "eta": ("eta", "1e3", 1e-3, -1.0),
    "phi": ("phi", "per_m", 1.0, -1.0),
}

# Of the own normal states: column and factor to SI.
NORMAL_COLUMNS = {
    "sink": ("sink_um", 1e-6),
    "normal": ("normal_N", 1.0),
    "pressure": ("pmax_MPa", 1e6),
    "area": ("area_mm2", 1e-6),
    "rail": ("rail_mm", 1e-3),
    "wheel": ("wheel_mm", 1e-3),
    "patches": ("patches", 1.0),
    "share": ("share", 1.0),
}


def contact_criteria():
    """Criteria of the comparison: group -> name -> limit, units in the names."""
    path = resource(f"{FOLDER}/accept.toml")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise _not_ours(path, error) from None


def published():
    """All reference values.

    Returns
    -------
    Published

    Raises
    ------
    InputError
        A file is not the one that came with railcli.
    """
    return Published(*(_read(name, read) for name, read in READERS.items()))


def benchmark_profiles():
    """Wheel and rail of the benchmark, the rail inclined as in its file."""
    folder = resource(f"{FOLDER}/profiles")
    return tuple(import_profile(folder / name, ImportSettings()).profile for name in (WHEEL, RAIL))


def benchmark_wheelset():
    """The benchmark's wheelset over its track.

    Returns
    -------
    Wheelset
    """
    return wheelset_on(SETTINGS, *benchmark_profiles())


def _read(name, read):
    """What `read` makes of the columns of a reference file: name -> list of str."""
    path = resource(f"{FOLDER}/reference/{name}.csv")
    lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    try:
        return read(dict(zip(lines[0], map(list, zip(*lines[1:], strict=True)), strict=True)))
    except (ValueError, IndexError) as error:
        raise _not_ours(path, error) from None
    except KeyError as error:
        raise _not_ours(path, f"column {error} is missing") from None


def _numbers(columns, *names):
    """Columns as arrays of numbers; all unless some are named."""
    return {key: np.array(columns[key], dtype=float) for key in names or columns}


def _hertz(columns):
    axes = [f"R{body}_{axis}" for axis in ("x", "y") for body in ("wheel", "rail")]
    n = _numbers(columns, *axes, "N_N", "E_MPa", "nu", "a_mm", "b_mm", "p0_MPa", "delta_mm")
    along, lateral = (500.0 * (1.0 / n[f"Rwheel_{axis}"] + 1.0 / n[f"Rrail_{axis}"]) for axis in ("x", "y"))
    expected = np.transpose([n["a_mm"] * 1e-3, n["b_mm"] * 1e-3, n["p0_MPa"] * 1e6, n["delta_mm"] * 1e-3])
    return HertzCases(columns["case"], along, lateral, n["N_N"], n["E_MPa"] * 1e6, n["nu"], expected)


def _kalker(columns):
    """Semi-axes ratios above 1 are printed with six decimals; the ratio g that they stand for is exact."""
    n = _numbers(columns)
    ratio, g = n.pop("a_over_b"), n.pop("g")
    return np.column_stack([np.where(ratio > 1.0, 1.0 / g, g), *n.values()])


def _creep(columns):
    n = _numbers(columns)
    contact, fastsim = (
        np.column_stack([n[f"{name}_{part}"] for part in ("fx", "fy", "mz")]) for name in ("contact", "fastsim")
    )
    slip = np.column_stack([n["xi"], n["eta"], n["phi_per_mm"] * 1e3])
    return CreepStates(n["a_mm"] * 1e-3, n["b_mm"] * 1e-3, slip, contact, fastsim)


def _benchmark(columns):
    n = _numbers(columns)
    values = {
        name: factor * sign * np.column_stack([n[f"{stem}_{side}_{unit}"] for side in ("right", "left")])
        for name, (stem, unit, factor, sign) in BENCHMARK_COLUMNS.items()
    }
    values["creep_x"], values["creep_t"] = values["x_force"], across(values["y_force"], values["angle"])
    motion = n["y_mm"] * 1e-3, n["yaw_mrad"] * 1e-3, n["roll_mrad"] * 1e-3, n["pitch_rate_rad_per_s"]
    return States(*motion, values)


def _normal(columns):
    n = _numbers(columns)
    pose = n["y_mm"] * 1e-3, n["yaw_mrad"] * 1e-3, n["roll_mrad"] * 1e-3
    values = {name: factor * n[column] for name, (column, factor) in NORMAL_COLUMNS.items()}
    return NormalStates(*pose, n["load_kN"] * 1e3, n["touch_um"] * 1e-6, values)


def _not_ours(path, error):
    return InputError(path, f"is not the file that came with railcli ({error}); install railcli again")


# in the order of `Published`
READERS = {"hertz": _hertz, "kalker": _kalker, "creep": _creep, "a22": _benchmark, "normal": _normal}
