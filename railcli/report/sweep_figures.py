"""Figures of a parameter study: response over one input, map over two, scatter of samples, Sobol indices."""

import math
import re

import numpy as np

from .figures import BLUE, GREY, SERIES, VERMILION, draw, plain
from .result_figures import Figure
from .sweep import numbers, shown

MOST = 6  # outputs drawn
MOST_LINES = 6
PANEL = (4.2, 2.9)  # [inch]
SMALL = (2.3, 1.9)  # a panel of many [inch]
MOST_INPUTS = 6  # of a scatter


class Axis:
    """An input as an axis: numbers, or texts in the order in which they come."""

    def __init__(self, table, name):
        self.name = name
        values = table[name].tolist()
        self.at = numbers(table, name)
        self.texts = None
        if self.at is None:
            self.texts = list(dict.fromkeys(map(str, values)))
            self.at = np.array([self.texts.index(str(value)) for value in values], float)
        self.values = np.unique(self.at)

    def label(self, value):
        return self.texts[int(value)] if self.texts else f"{value:g}"

    def put(self, axis, which="x"):
        """Name it, and its texts, on an axis of matplotlib."""
        getattr(axis, f"set_{which}label")(plain(_short(self.name)))
        if self.texts:
            getattr(axis, f"set_{which}ticks")(range(len(self.texts)), [plain(text[-20:]) for text in self.texts])


def figures(study, design, table, found):
    """The figures of a study.

    Parameters
    ----------
    study : Study
    design : Design
    table : DataFrame
    found : dict
        As `sensitivity.indices`.

    Returns
    -------
    list of result_figures.Figure
    """
    outputs = shown(study, design, table, MOST)
    axes = [Axis(table, one.name) for one in study.parameters]
    axes = [axis for axis in axes if axis.values.size > 1]
    if not outputs or not axes:
        return []
    seeds = "" if study.seeds is None else " Points: means over the seeds; bars: their least and greatest values."
    sampled = any(one.is_sampled for one in study.parameters)
    made = []
    if len(axes) <= 2 and not sampled:
        made.append(_figure("response", "Response", f"Outputs over {_short(axes[0].name)}.{seeds}", outputs,
                            lambda panel, name: _response(panel, table, name, axes)))  # fmt: skip
        if len(axes) == 2:
            about = f"Outputs over {_short(axes[0].name)} and {_short(axes[1].name)}; hatched: failed runs."
            made.append(_figure("map", "Map", about, outputs, lambda panel, name: _map(panel, table, name, axes)))
    else:
        axes = axes[:MOST_INPUTS]
        size = SMALL[0] * len(axes) + 0.6, SMALL[1] * len(outputs) + 0.4
        about = "A point for each run; vermilion: a figure of the assessment failed."
        made.append(Figure("scatter", "Scatter", about, lambda path: draw(
            lambda figure: _scatter(figure, table, outputs, axes), path, size)))  # fmt: skip
    if found:
        inputs = [one.name for one in study.parameters if one.is_sampled]
        about = "Share of the variance of an output: S1 of an input alone, ST with all others; bars: 95 % intervals."
        made.append(_figure("indices", "Sobol indices", about, list(found)[:MOST],
                            lambda panel, name: _indices(panel, inputs, found[name])))  # fmt: skip
    return made


def _figure(name, title, caption, outputs, paint):
    """A Figure with a panel for each output, which `paint(panel, output)` fills."""
    columns = min(2, len(outputs))
    lines = math.ceil(len(outputs) / columns)

    def every(figure):
        panels = figure.subplots(lines, columns, squeeze=False).ravel()
        for panel, output in zip(panels, outputs, strict=False):
            panel.set_title(plain(output))
            paint(panel, output)
        for panel in panels[len(outputs) :]:
            panel.set_visible(False)

    return Figure(name, title, caption, lambda path: draw(every, path, (PANEL[0] * columns + 0.5, PANEL[1] * lines)))


def _short(name):
    """The key of an input without the group that says nothing more."""
    return re.sub(r"^(run|contact|vehicle)\.", "", name)


def _gathered(axis, y, here):
    """Places of an input, and mean, least and greatest value of an output there."""
    x, found = [], []
    for value in axis.values:
        some = y[here & (axis.at == value)]
        some = some[np.isfinite(some)]
        if some.size:
            x.append(value)
            found.append((some.mean(), some.min(), some.max()))
    return np.array(x), np.array(found).reshape(-1, 3)


def _response(panel, table, name, axes):
    """Lines over the first input, one for each value of the second, or for some of them."""
    y, first = numbers(table, name), axes[0]
    others = axes[1].values if len(axes) > 1 else [None]
    if len(others) > MOST_LINES:
        others = others[np.round(np.linspace(0, len(others) - 1, MOST_LINES)).astype(int)]
    for k, other in enumerate(others):
        here = np.full(y.size, True) if other is None else axes[1].at == other
        x, values = _gathered(first, y, here)
        if not x.size:
            continue
        mean, low, high = values.T
        label = None if other is None else plain(f"{_short(axes[1].name)} {axes[1].label(other)}")
        bars = [mean - low, high - mean] if (high > low).any() else None
        panel.errorbar(x, mean, bars, marker="o", markersize=3, capsize=2, color=SERIES[k % len(SERIES)], label=label)
    first.put(panel)
    if len(axes) > 1:
        panel.legend()


def _map(panel, table, name, axes):
    """Colours over two inputs, means over what else varies."""
    y = numbers(table, name)
    grid = np.full((axes[1].values.size, axes[0].values.size), np.nan)
    for i, other in enumerate(axes[1].values):
        x, values = _gathered(axes[0], y, axes[1].at == other)
        grid[i, np.searchsorted(axes[0].values, x)] = values[:, 0]
    panel.patch.set(hatch="///", edgecolor=GREY)
    panel.grid(visible=False)
    mesh = panel.pcolormesh(axes[0].values, axes[1].values, np.ma.masked_invalid(grid), shading="nearest")
    panel.figure.colorbar(mesh, ax=panel)
    axes[0].put(panel)
    axes[1].put(panel, "y")


def _scatter(figure, table, outputs, axes):
    panels = figure.subplots(len(outputs), len(axes), squeeze=False, sharex="col", sharey="row")
    colours = np.where(table["verdict"] == "fail", VERMILION, BLUE)
    size = 12.0 if len(table) < 300 else 3.0
    for line, name in zip(panels, outputs, strict=True):
        y = numbers(table, name)
        for panel, axis in zip(line, axes, strict=True):
            panel.scatter(axis.at, y, s=size, c=colours, linewidths=0.0, alpha=0.7)
        group, _, rest = name.rpartition(".") if "[" not in name else ("", "", name)
        line[0].set_ylabel(plain(f"{group}\n{rest}" if group else rest[-28:]))
    for panel, axis in zip(panels[-1], axes, strict=True):
        axis.put(panel)


def _indices(panel, inputs, one):
    places = np.arange(len(inputs))
    width = 0.8 if one.total is None else 0.4
    panel.bar(places - (0.0 if one.total is None else 0.2), one.first, width, yerr=one.first_within, color=BLUE,
              label="S1", capsize=2)  # fmt: skip
    if one.total is not None:
        panel.bar(places + 0.2, one.total, width, yerr=one.total_within, color=SERIES[3], label="ST", capsize=2)
    panel.set_xticks(places, [plain(_short(name)[-24:]) for name in inputs], rotation=20, ha="right")
    panel.set_ylim(min(0.0, panel.get_ylim()[0]), None)
    panel.legend()
