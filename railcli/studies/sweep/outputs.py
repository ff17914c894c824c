"""What a parameter study keeps of a run: names, units and values of its outputs."""

from fnmatch import fnmatchcase

import numpy as np

from railcli.errors import InputError
from railcli.files.columns import Column, columns_of_channel
from railcli.files.read_results import Channel, components_of
from railcli.files.results import recorded
from railcli.model.assessment import FIGURES
from railcli.model.checks import nearest
from railcli.model.study import percentage

MOST_VALUES = 50_000_000  # numbers of channels that a run may keep until it is over


def wanted(names, study):
    """Those of some names that the study keeps."""
    return [name for name in names if any(fnmatchcase(name, pattern) for pattern in study.patterns)]


def check(study, known):
    """Raise an InputError when an output pattern fits none of the names that a run of the study can have."""
    for pattern in (*study.patterns, *study.figures):
        if study.outputs is None and pattern in study.patterns:
            continue
        if not any(fnmatchcase(name, pattern) for name in known) and "[" not in pattern:
            near = nearest(pattern, known)
            hint = f"did you mean {near!r}?" if near else f"known: {', '.join(known[:6])} ..."
            raise InputError(f"{study.name}: outputs", f"{pattern!r} fits no output; {hint}")


def names(wheelsets):
    """Names of all outputs but those of channels, of a vehicle with so many wheelsets."""
    found = []
    for group in ("steady", "end"):
        for sides in (("outer", "inner"), ("right", "left")):
            found += list(_of_wheelsets(group, sides, np.zeros(wheelsets), np.zeros(wheelsets),
                                        np.zeros((wheelsets, 2)), np.ones((wheelsets, 2))))  # fmt: skip
    found += [f"end.W{k + 1}_y_range_mm" for k in range(wheelsets)]
    return [*dict.fromkeys(found), *(figure_name(key) for key in FIGURES)]


def figure_name(key):
    """Of a figure of the assessment, with its unit."""
    unit = FIGURES[key].unit.replace("/s^2", "_per_s2")
    return f"assessment.{key}_{unit}" if unit else f"assessment.{key}"


def of_motion(group, values, sides):
    """Values by name of analysis.steady_values.SteadyValues."""
    return _of_wheelsets(group, sides, values.lateral, values.yaw, values.y_force, values.q_force)


def _of_wheelsets(group, sides, lateral, yaw, y_force, q_force):
    found = {}
    for k in range(lateral.size):
        name = f"{group}.W{k + 1}"
        found[f"{name}_y_mm"] = 1e3 * lateral[k]
        found[f"{name}_yaw_mrad"] = 1e3 * yaw[k]
        for force, pair in (("Q", q_force[k]), ("Y", y_force[k])):
            found |= {f"{name}_{force}_{side}_kN": 1e-3 * one for side, one in zip(sides, pair, strict=True)}
        found[f"{name}_sum_Y_kN"] = 1e-3 * y_force[k].sum()
    ratio = np.abs(np.divide(y_force, q_force, out=np.full_like(y_force, np.inf), where=q_force > 0.0))
    found[f"{group}.Y_Q_largest"] = ratio.max()
    return found


def of_swing(values):
    """How far the wheelsets move at the end of a run, largest less smallest value."""
    return {f"end.W{k + 1}_y_range_mm": 1e3 * value for k, value in enumerate(values.lateral)}


class Gathered:
    """A sink that keeps the channels of which a study wants statistics.

    Parameters
    ----------
    asked : sequence of ChannelOutput
    system : System
    rows : int
        That will come.

    Raises
    ------
    InputError
        A channel is none, or so many rows of so many channels fit in no memory.
    """

    def __init__(self, asked, system, rows):
        every = {one.name: one for one in recorded(system)}
        self._chosen = []
        for one in asked:
            fit = [column for column in _columns(every) if _fits(column, one.channel)]
            if not fit:
                near = nearest(one.channel, list(every))
                hint = f"did you mean {near!r}?" if near else "docs/nomenclature.md names them"
                raise InputError(f"channel {one.channel!r}", f"no such channel; {hint}")
            self._chosen.append((one, fit))
        self._sources = {
            column.channel: every[column.channel].source for _, columns in self._chosen for column in columns
        }
        if len(self._sources) * rows > MOST_VALUES:
            raise InputError(
                "channel", f"{rows:,} rows of {len(self._sources)} channels are too many; choose fewer channels or a "
                "longer output interval"
            )  # fmt: skip
        self._held = {name: [] for name in self._sources}
        self._places = []

    def __call__(self, rows):
        self._places.append(rows.q[:, 0, 0].copy())
        for name, source in self._sources.items():
            self._held[name].append(np.array(source(rows)))

    def values(self):
        """Statistics by name, such as ``wheels/W1_right/Q.max [N]``; those of rows that are no numbers are left out."""
        s = np.concatenate(self._places)
        series = {name: np.concatenate(parts) for name, parts in self._held.items()}
        found = {}
        for one, columns in self._chosen:
            inside = (s >= one.start) & (s <= (np.inf if one.end is None else one.end))
            for column in columns:
                x = column.of(series[column.channel])[inside]
                x = x[np.isfinite(x)]
                for text in one.statistics:
                    found[f"{column.name}.{text} [{column.units}]"] = statistic(text, x)
        return found


def statistic(text, x):
    """A statistic (model.study.STATISTICS, or a percentile) of values; None without any."""
    if not x.size:
        return None
    if (share := percentage(text)) is not None:
        return float(np.percentile(x, share))
    return float(
        {
            "mean": np.mean,
            "min": np.min,
            "max": np.max,
            "std": np.std,
            "rms": lambda x: np.sqrt(np.mean(x * x)),
            "range": np.ptp,
            "last": lambda x: x[-1],
        }[text](x)
    )


def _columns(every):
    for one in every.values():
        components = components_of(one.name, (0, *one.shape))
        yield from columns_of_channel(Channel(one.name, one.units, one.description, components, one.of_interval))


def _fits(column: Column, pattern):
    return fnmatchcase(column.name, pattern) or fnmatchcase(column.channel, pattern)
