"""What the rails lend the wheels: friction along the line, and films that wheels clean away.

docs/subsystems.md, 4. A wheel's work on its rail is W = T w / V per metre, T the creep force, w the slip velocity, V
the speed. A film of degraded adhesion recovers with the work that counts by the share 1 - exp(-tau W); each number of
`Grip` goes with it.
"""

from math import exp, floor

from .assembly_layout import GRIPS, Grip, Memory
from .jit import kernel, seldom

FRICTION, RATIO, DECAY = Grip.FRICTION.value, Grip.RATIO.value, Grip.DECAY.value
ADHESION, SLIP = Grip.ADHESION.value, Grip.SLIP.value
SLOWEST = 0.1  # speed that counts for a wheel's work per metre where it runs slower [m/s]


@kernel
def plain_grip(model, wheel, rail):
    """The grip of a wheel where no line is given: that of its scenario."""
    param, grip = model.param[0], rail["grip"]
    grip[FRICTION], grip[RATIO], grip[DECAY] = wheel["friction"], param["friction_ratio"], param["friction_decay"]
    grip[ADHESION], grip[SLIP] = param["adhesion_reduction"], param["slip_reduction"]


@kernel
def find_stretch(line, near, s):
    """Number of the stretch of the line on which s lies, from one nearby."""
    at = near
    while at + 1 < line.shape[0] and s >= line[at + 1]["start"]:
        at += 1
    while at > 0 and s < line[at]["start"]:
        at -= 1
    return at


@kernel
def grip_of(line, at, side, s, cleaned, c):
    """Number c of `Grip` on stretch `at`; side : 0 right, 1 left; cleaned : share of its film that is gone."""
    here = line[at]
    value = here["grip"][side, c]
    if here["films"]:
        value += cleaned * (here["clean"][side, c] - value)
    if at > 0 and s < here["start"] + here["blend"]:
        before = line[at - 1]
        old = before["grip"][side, c]
        if before["films"]:
            old += cleaned * (before["clean"][side, c] - old)
        value = old + (s - here["start"]) / here["blend"] * (value - old)
    return value


@seldom
def lend(model, data, step):
    """Fill the grip of every wheel at its place; take in the work of the step before where contacts remember."""
    assembly = model.assembly[0]
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        s = data.q[axle["wheelset"], 0]
        port["piece"] = find_stretch(model.line, port["piece"], s)
        for side in range(2):
            w = axle["first"] + side
            cleaned = 0.0
            if assembly["memory"] != Memory.NONE:
                clean(model, data, a, side, s, step)
                cleaned = 1.0 - exp(-assembly["cleaning"] * port["work"][side])
            grip = data.rail[w]["grip"]
            for c in range(GRIPS):
                grip[c] = grip_of(model.line, port["piece"], side, s, cleaned, c)


@kernel
def rubbing(data, w):
    """Power of the creep forces of wheel w at its last evaluation, without spin [W]."""
    rail, found = data.rail[w], 0.0
    for j in range(int(rail["patches"])):
        patch = data.contact[w, j]
        found -= patch["creep_x"] * patch["slip_x"] + patch["creep_t"] * patch["slip_t"]
    return max(found, 0.0)


@kernel
def clean(model, data, a, side, s, step):
    """Move the memory of one wheel on by a step; fill the work that counts for it.

    OWN: its work per metre, a mean over the length of a cell. RAIL: what wheels before it have done to the cell under
    it; its own part is handed over when it leaves.
    """
    assembly, axle, port = model.assembly[0], model.axle[a], data.port[a]
    speed = abs(data.v[axle["wheelset"], 0])
    power = rubbing(data, axle["first"] + side)
    if assembly["memory"] == Memory.OWN:
        share = 1.0 - exp(-speed * step / assembly["cell"])
        port["work"][side] += share * (power / max(speed, SLOWEST) - port["work"][side])
        return
    memory = data.memory
    cell = min(max(int(floor((s - assembly["cell_start"]) / assembly["cell"])), 0), memory.shape[1] - 1)
    if cell != port["place"][side]:
        memory[side, port["place"][side]] += port["pending"][side]
        port["place"][side], port["pending"][side] = cell, 0.0
    port["pending"][side] += power * step / assembly["cell"]
    port["work"][side] = memory[side, cell]
