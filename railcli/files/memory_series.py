"""The low-passed rows of a run in memory: what an assessment reads, without a results folder.

Values are those that a file would hold, its single precision included.
"""

import numpy as np

from .columns import VALUES
from .filtered_series import FilteredSeries, wheel_group
from .read_results import Channel, components_of


class FilteredRows:
    """A sink of low-passed blocks, then what `analysis.assess` takes in place of results.

    Parameters
    ----------
    scenario : Scenario
        As it is run.
    system : System
    """

    fault = ""

    def __init__(self, scenario, system):
        self.scenario = scenario
        self.bodies = system.bodies
        self.wheelsets = tuple(system.bodies[i] for i in system.wheelsets)
        self.wheels = tuple(wheel_group(system, w) for w in range(system.model.wheel.size))
        self._group = _Group()
        self._series = FilteredSeries(system, self._group)
        self.channels, self.rows = {}, 0

    def __call__(self, block):
        for _, write in self._series.take(block):
            write()

    def finish(self):
        """Take in what is held back; nothing comes any more."""
        for _, write in self._series.rest():
            write()
        self.channels = {
            name: Channel(name, one.attrs["units"], one.attrs["description"], components_of(name, one.shape))
            for name, one in self._group.datasets.items()
        }
        self.rows = self._group.datasets["time"].shape[0] if self._group.datasets else 0

    @property
    def filtered(self):
        return self if self.rows else None

    def read(self, name, start=0, stop=None):
        """Rows of a channel, as files.read_results.Rows."""
        return self._group.datasets[name].values[start:stop]

    def pieces(self, *names, size=VALUES):
        """Yield tuples of arrays, some rows of each channel at a time."""
        for start in range(0, self.rows, size):
            yield tuple(self.read(name, start, start + size) for name in names)


class _Group:
    """As much of a group of HDF5 as FilteredSeries knows."""

    def __init__(self):
        self.datasets = {}

    def create_group(self, name):
        return self

    def create_dataset(self, name, dtype, shape, **form):
        self.datasets[name] = _Dataset(np.empty(shape, dtype))
        return self.datasets[name]


class _Dataset:
    def __init__(self, values):
        self.values, self.attrs = values, {}

    @property
    def shape(self):
        return self.values.shape

    def resize(self, rows, axis):
        grown = np.empty((rows, *self.values.shape[1:]), self.values.dtype)
        grown[: len(self.values)] = self.values
        self.values = grown

    def __setitem__(self, where, values):
        self.values[where] = values
