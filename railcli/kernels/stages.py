"""One stage of the step at a time, from a frozen state, for the benchmark."""

from enum import IntEnum

from numba import types

from .body import drift, drift_on, frames, inertia_loads
from .jit import entry
from .layout import DATA_TYPE, MODEL_TYPE
from .step import THETA, accelerate, core, hold_speed
from .support import press, slip
from .suspension import suspension


class Stage(IntEnum):
    """Parts of one step."""

    TRACK = 0  # track frames, poses and velocities of the bodies
    SUSPENSION = 1
    CONTACT = 2  # table look-up and normal forces
    CREEP = 3  # creepages and creep forces
    INTEGRATION = 4  # weight and moving axes, accelerations, coordinates' rates
    STEP = 5  # the whole, moving on


@entry(types.int64(MODEL_TYPE, DATA_TYPE, types.int64, types.int64))
def repeat(model, data, stage, times):
    """Run one stage `times` times on what data holds; returns a Status. Leaves sums in data that mean nothing."""
    step = model.param[0]["step"]
    half_step = 0.5 * step
    status = 0
    for _ in range(times):
        if stage == Stage.TRACK:
            status = frames(model, data)
        elif stage == Stage.SUSPENSION:
            status = suspension(model, data, half_step, True)
        elif stage == Stage.CONTACT:
            status = press(model, data, THETA * step, (THETA - 0.5) * step)
        elif stage == Stage.CREEP:
            slip(model, data, 0.0)
        elif stage == Stage.INTEGRATION:
            drift(model, data)
            inertia_loads(model, data)
            hold_speed(model, data)
            accelerate(model, data, THETA * step)
            drift_on(model, data)
        else:
            status = core(model, data, 1)
        if status != 0:
            return status
    return status
