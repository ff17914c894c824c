"""What every step gave, as a group of the time series at a rate of its own: forces and accelerations low-passed.

Single precision, but for arc lengths: 4 mN of a wheel force.
"""

from functools import partial

import numpy as np

from railcli.analysis.faults import wheel_name
from railcli.kernels.layout import Region
from railcli.kernels.recording import averaged, instants

FILTERED = "filtered"  # the group
OF_INTERVAL = "of_interval"  # attribute of a dataset
FELT = "what an accelerometer at the centre of mass shows, x, y, z of the track frame, gravity taken from z"
CHUNK = 1000  # rows kept in memory, and in one chunk of the file
FILTERED_CHUNK = 5000  # likewise of this group: ten seconds
COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
PARTS = ("tread", "root", "flank", "tip")  # components of T_gamma
assert len(PARTS) == len(Region)


def wheel_group(system, wheel):
    """`W2_left` for the left wheel of the second wheelset."""
    return wheel_name(system, wheel).replace(" ", "_")


def grown(file, name, shape, units, description, kind="f8", of_interval=False, chunk=CHUNK):
    """A new dataset without rows, that can grow.

    shape : that of a row; of_interval : its values depend on how long the interval between two rows is.
    """
    form = {"shape": (0, *shape), "maxshape": (None, *shape), "chunks": (chunk, *shape)}
    dataset = file.create_dataset(name, dtype=kind, **form, **COMPRESSION)
    dataset.attrs["units"] = units
    dataset.attrs["description"] = description
    if of_interval:
        dataset.attrs[OF_INTERVAL] = True
    return dataset


class FilteredSeries:
    """Datasets of the group, made when the first rows are written.

    `take` and `rest` yield what is to write: how many bytes it may need, and a function that does it.
    """

    def __init__(self, system, file):
        self._system, self._file, self._sources = system, file, None
        self._held, self._count, self._rows = None, 0, 0

    def take(self, block):
        """Hold a block of Filtered; yields when what is held fills a chunk."""
        if self._held is None:
            self._held = type(block)(*(np.empty((FILTERED_CHUNK, *part.shape[1:]), part.dtype) for part in block))
        start = 0
        while start < block.time.size:
            count = min(FILTERED_CHUNK - self._count, block.time.size - start)
            for held, new in zip(self._held, block, strict=True):
                held[self._count : self._count + count] = new[start : start + count]
            self._count += count
            start += count
            if self._count == FILTERED_CHUNK:
                yield from self.rest()

    def rest(self):
        """Yields what is held."""
        if self._count:
            block = type(self._held)(*(part[: self._count] for part in self._held))
            self._count = 0
            yield sum(part.nbytes for part in block), lambda: self._write(block)

    def _write(self, block):
        if self._sources is None:
            self._sources = dict(self._create(self._file.create_group(FILTERED)))
        for dataset, source in self._sources.items():
            dataset.resize(self._rows + block.time.size, axis=0)
            dataset[self._rows :] = source(block)
        self._rows += block.time.size

    def _create(self, group):
        """Make every dataset; yields each with the function that reads its values from a block."""
        dataset = partial(grown, group, chunk=FILTERED_CHUNK)
        system, body = self._system, self._system.model.body
        spans = averaged(system.model.wheel.size, body.size)
        still = instants(system.model.wheel.size, body.size)

        def three(part, start):
            return lambda block: getattr(block, part)[:, start : start + 3]

        yield dataset("time", (), "s", "simulated time"), lambda block: block.time
        turning = spans.acceleration.stop
        for i, name in enumerate(system.bodies):
            path = f"bodies/{name}"
            yield dataset(f"{path}/s", (), "m", "arc length"), lambda block, i=i: block.place[:, i]
            y = dataset(f"{path}/lateral", (), "m", "lateral position", "f4")
            yield y, lambda block, i=i: block.still[:, still.lateral.start + i]
            channels = [
                ("rotation", "rad", "roll, pitch, yaw against the track frame", "still", still.rotation.start + 3 * i),
                ("angular_velocity", "rad/s", "about the body's own axes", "still", still.omega.start + 3 * i),
                ("acceleration", "m/s^2", f"{FELT}, low-passed", "filtered", spans.acceleration.start + 3 * i),
            ]
            if not body[i]["spins"]:
                about = "about the body's own axes, low-passed"
                channels.append(("angular_acceleration", "rad/s^2", about, "filtered", turning))
                turning += 3
            for channel, units, about, part, start in channels:
                yield dataset(f"{path}/{channel}", (3,), units, about, "f4"), three(part, start)
        for w in range(system.model.wheel.size):
            path = f"wheels/{wheel_group(system, w)}"
            for channel, span in (("X", spans.x), ("Y", spans.y), ("Q", spans.q)):
                force = dataset(f"{path}/{channel}", (), "N", "force on the rail, low-passed", "f4")
                yield force, lambda block, at=span.start + w: block.filtered[:, at]
            start = still.t_gamma.start + len(PARTS) * w
            about = f"wear number of the contacts on each part of the profile: {', '.join(PARTS)}; mean of the steps"
            wear = dataset(f"{path}/T_gamma", (len(PARTS),), "N", about, "f4")
            yield wear, lambda block, start=start: block.still[:, start : start + len(PARTS)]
