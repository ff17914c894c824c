"""The core against its twins: the same state to both, the largest difference over the largest value of each result."""

import numpy as np

from railcli.kernels.layout import Creep, Data
from railcli.kernels.stages import Stage, repeat
from railcli.kernels.step import evaluate

from . import numpy_twin

TWIN = 1e-9  # demanded of both twins; rounding in stretches of stiff springs leaves 3e-12
STATES = 12
HALF_STEP = 0.25e-3  # [s]
LAWS = (Creep.HARD, Creep.SMOOTH)  # that the twins know; the others have twins of their own in the tests
RESULTS = {  # what a stage fills, and in which order the stages need each other
    Stage.SUSPENSION: ("frame", "damper_rate"),
    Stage.CONTACT: ("contact", "rail"),
    Stage.CREEP: ("contact", "rail", "load", "creep_damping"),
}


def shaken(system, rng, place):
    """The vehicle pushed about at an arc length [m]: springs, dampers, both creep regimes, several contact patches."""
    data = system.start(place)
    spins = system.model.body["spins"] == 1
    reach = np.where(spins[:, None], [0.02, 1e-3, 0.0, 1e-3, 1.0, 4e-3], [0.05, 20e-3, 20e-3, 30e-3, 30e-3, 30e-3])
    data.q[:] += rng.uniform(-1, 1, data.q.shape) * reach
    data.q[spins, 1] += rng.choice([-6e-3, 0.0, 6e-3], spins.sum())
    data.q[spins, 2] += 0.4e-3
    data.v[:] += rng.uniform(-1, 1, data.v.shape) * np.where(spins[:, None], 0.05, 0.5)
    data.damper[:] += rng.uniform(-1, 1, data.damper.size) * 3e-3
    return data


def copied(data):
    """The same state in arrays of its own."""
    return Data(*(array.copy() for array in data))


def difference(found, wanted):
    """Largest difference over the largest value; of records, the worst field."""
    if found.dtype.names:
        return max(difference(found[name], wanted[name]) for name in found.dtype.names)
    size, apart = np.abs(wanted).max(initial=0.0), np.abs(found - wanted).max(initial=0.0)
    return float(apart / size) if size > 0.0 else float(apart)


def states(system, count=STATES, seed=3):
    """States along the track of a system, evaluated: poses, velocities, contacts and loads belong together."""
    rng = np.random.default_rng(seed)
    for place in np.linspace(5.0, 600.0, count):
        data = shaken(system, rng, place)
        if (status := evaluate(system.model, data, HALF_STEP)) != 0:
            raise RuntimeError(f"a shaken state at {place:g} m cannot be evaluated: status {status}")
        yield data


def against_c(system, data, c_repeat):
    """Difference of each stage of the C twin from the core's at a state: dict of Stage to number."""
    found = {}
    for stage, names in RESULTS.items():
        core, twin = copied(data), copied(data)
        if (both := (repeat(system.model, core, stage, 1), c_repeat(system.model, twin, stage, 1))) != (0, 0):
            raise RuntimeError(f"{stage.name} of core and C twin ended with status {both}")
        pairs = [(getattr(core, name), getattr(twin, name)) for name in names]
        found[stage] = max(difference(mine, theirs) for mine, theirs in pairs)
    return found


def against_numpy(system, data):
    """Difference of the NumPy twin's loads, rates and wheel forces from the core's at a state."""
    twin = numpy_twin.evaluate(system.model, data.q, data.v, data.damper, HALF_STEP)
    held = copied(data)
    evaluate(system.model, held, HALF_STEP)
    reaction = np.stack([held.rail["x"], held.rail["y"], held.rail["q"]], axis=1)
    columns = [difference(held.load[:, k], twin.load[:, k]) for k in range(6)]
    return max(
        *columns,
        difference(held.rate, twin.bodies.rate),
        difference(held.damper_rate, twin.damper_rate),
        difference(held.contact["normal"], twin.patches.normal),
        difference(reaction, -twin.patches.force.sum(axis=1)),
    )
