"""A contact table as accurate as asked for: its grid refined where its error comes from.

Accuracy is one number, the 99.9 % error of the contact angle on the tread [mrad], of a table of heights that of the
normal force [%]; what else must hold follows from it in fixed proportion (GOALS; AIMS of the certificate of forces).
Errors are those of the certificate: contacts near the end of a branch are counted apart in geometry, not in forces.
"""

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from railcli.errors import CheckError
from railcli.kernels.contact import look_up_all
from railcli.kernels.layout import NODE_CHANNELS, SAMPLE_ROWS
from railcli.model.contact_table import LIMITS

from .certify_forces import AIMS

GOALS = {  # 99.9 % errors at an accuracy of 1 mrad
    "tread": {"angle_mrad": 1.0, "radius_um": 10.0},
    "root": {"angle_mrad": 6.0, "radius_um": 50.0},
    "flank": {"angle_mrad": 6.0, "radius_um": 50.0},
    "tip": {"angle_mrad": 6.0, "radius_um": 50.0},
}
AXES = ("y", "roll", "yaw")
FINER = (1.25, 2.0)  # least and greatest factor by which one axis is refined at a time
NEARLY = 0.7  # an axis whose own error is below this share of the goal is left alone
ROUNDS = 12
LOOK_UPS = 20_000
KNOTS = 3.0  # power of the fineness with which a table of heights grows
STALLED = 0.9  # a finer grid that leaves more than this share of the error will not do
SWING = (8e-3, 3e-3, 8e-3)  # amplitudes of the motion for which look-ups are timed [m], [rad], [rad]


@dataclass(frozen=True)
class Stage:
    """One grid on the way.

    Attributes
    ----------
    settings : TableSettings
    bytes : int
        Of the table in memory.
    cpu_s, look_up_ns : float
        Processor time of building it and of one look-up; of a table of heights the first only.
    excess : float
        Largest error over what is allowed.
    worst : tuple of str
        Region, or quantile over all, and quantity of this error.
    """

    settings: object
    bytes: int
    cpu_s: float
    look_up_ns: float | None
    excess: float
    worst: tuple


def excess(certificate, accuracy):
    """Largest 99.9 % error over its goal, and its region and quantity.

    Parameters
    ----------
    certificate : dict
        As `certify` gives it.
    accuracy : float
        Wanted of the contact angle on the tread [mrad].
    """
    ratios = {
        (region, key): certificate[key]["by_region"][region]["p999"] / (accuracy * goal)
        for region in certificate.get("contacts", {})
        for key, goal in GOALS[region].items()
    }
    if not ratios:
        return math.inf, ("", "")
    worst = max(ratios, key=ratios.get)
    return ratios[worst], worst


def finer(settings, axis, factor):
    """The same settings with one axis (0 y, 1 roll, 2 yaw) refined by about a factor, at least by one node."""
    if axis == 2:
        return replace(settings, yaw_count=max(math.ceil((settings.yaw_count - 1) * factor), settings.yaw_count) + 1)
    name = AXES[axis]
    half = getattr(settings, f"{name}_count") // 2
    return replace(
        settings, **{f"{name}_step": getattr(settings, f"{name}_range") / max(math.ceil(half * factor), half + 1)}
    )


def look_up_time(table):
    """Processor time of one look-up while a wheel swings through the table [ns]; least of five."""
    s = table.settings
    turn = np.linspace(0.0, 2.0 * np.pi, LOOK_UPS)[:, None] * [3.0, 7.0, 5.0]
    poses = np.minimum(SWING, 0.99 * np.array([s.y_range, s.roll_range, s.yaw_range])) * np.sin(turn)
    sample = np.zeros((SAMPLE_ROWS, NODE_CHANNELS))
    times = []
    for _ in range(6):
        began = time.thread_time_ns()
        look_up_all(table.record[0], table.node, table.cell, table.branch, poses, 1e-3, sample)
        times.append((time.thread_time_ns() - began) / LOOK_UPS)
    return min(times[1:])


def refine(settings, accuracy, most_bytes, build, measure, say=None):
    """Refine a grid until its table is accurate.

    Parameters
    ----------
    settings : TableSettings
        The grid to begin with.
    accuracy : float
        Wanted of the contact angle on the tread, 99.9 % [mrad].
    most_bytes : float
        No table larger than this is built.
    build : callable
        Of settings: table, facts and certificate.
    measure : callable
        Of a table and an axis: certificate along that axis alone.
    say : callable, optional
        Called with each Stage.

    Returns
    -------
    table, facts, certificate
        Of the last stage.
    stages : list of Stage

    Raises
    ------
    CheckError
        It would be larger than most_bytes, or no grid within the limits of the settings does it.
    """
    stages = []
    while True:
        table, facts, certificate = build(settings)
        ratio, worst = excess(certificate, accuracy)
        stages.append(Stage(settings, table.bytes, facts["cpu_s"], look_up_time(table), ratio, worst))
        if say:
            say(stages[-1])
        if ratio <= 1.0:
            return table, facts, certificate, stages
        along = [excess(measure(table, axis), accuracy)[0] for axis in range(len(AXES))]
        after = settings
        for axis in range(len(AXES)):
            share = along[axis] if along[axis] < math.inf else FINER[1] ** 2
            if share > NEARLY or along[axis] == max(along):
                after = finer(after, axis, min(max(math.sqrt(share), FINER[0]), FINER[1]))
        size = table.bytes * after.positions / settings.positions
        if size > most_bytes:
            raise CheckError(
                f"accuracy {accuracy:g} mrad cannot be had within {most_bytes / 1e6:.0f} MB: the next grid would take "
                f"{size / 1e6:.0f} MB; {table.bytes / 1e6:.0f} MB give {accuracy * ratio:.2g} mrad (worst: "
                f"{worst[1].partition('_')[0]} on the {worst[0]}); ask for that, or allow more with --largest"
            )
        if len(stages) == ROUNDS or not all(
            low <= getattr(after, key) <= high for key, (low, high, _) in LIMITS.items()
        ):
            raise CheckError(
                f"accuracy {accuracy:g} mrad cannot be had: after {len(stages)} grids the error is still "
                f"{accuracy * ratio:.2g} mrad (worst: {worst[1].partition('_')[0]} on the {worst[0]})"
            )
        settings = after


def excess_of_forces(forces, accuracy):
    """Largest 99 % or 99.9 % error over its aim, all poses together, and its quantile and quantity.

    Parameters
    ----------
    forces : dict
        As `certify_forces` gives it.
    accuracy : float
        Wanted of the normal force, 99.9 % [%].
    """
    ratios = {
        (size, key): forces[key][size] / (accuracy * aim)
        for key, aims in AIMS.items() if key in forces
        for size, aim in zip(("p99", "p999"), aims[:2], strict=True)
    }  # fmt: skip
    if not ratios:
        return math.inf, ("", "")
    worst = max(ratios, key=ratios.get)
    return ratios[worst], worst


def refine_knots(settings, accuracy, most_bytes, build, say=None):
    """As `refine`, for a table of heights, whose knots all come closer together; accuracy of the normal force [%]."""
    stages = []
    while True:
        table, facts, certificate = build(settings)
        ratio, worst = excess_of_forces(certificate["forces"], accuracy)
        stages.append(Stage(settings, table.bytes, facts["cpu_s"], None, ratio, worst))
        if say:
            say(stages[-1])
        if ratio <= 1.0:
            return table, facts, certificate, stages
        reached = f"fineness {settings.fineness:.3g} ({table.bytes / 1e6:.3g} MB) gives {accuracy * ratio:.2g} %"
        if len(stages) > 1 and ratio > STALLED * stages[-2].excess:
            raise CheckError(
                f"accuracy {accuracy:g} % cannot be had with closer knots: {reached}, "
                f"fineness {stages[-2].settings.fineness:.3g} gave {accuracy * stages[-2].excess:.2g} %"
            )
        factor = min(max(math.sqrt(ratio), FINER[0]), FINER[1])
        size = table.bytes * factor**KNOTS
        fineness = settings.fineness * factor
        if fineness > LIMITS["fineness"][1]:
            raise CheckError(
                f"accuracy {accuracy:g} % cannot be had with a fineness of at most {LIMITS['fineness'][1]:g}: {reached}"
            )
        if size > most_bytes:
            raise CheckError(
                f"accuracy {accuracy:g} % cannot be had within {most_bytes / 1e6:.3g} MB: the next grid would take "
                f"{size / 1e6:.3g} MB; {reached}; ask for that, or allow more with --largest"
            )
        settings = replace(settings, fineness=fineness)
