"""Where the energy of a run goes: work of each family of forces, step by step (docs/subsystems.md, 7).

A step changes the kinetic energy by h M dv . (v0 + v1) / 2 exactly. Forces are booked with that mean velocity:
tensions as the implicit step ended with them, creep forces patch by patch at their own slip, as the step evaluated
them last. What is left unbooked is by how much that differs from what moved the vehicle: it tells of steps that are
too long, of a pair of force and reaction that does not close, of slip that is not the motion of the wheel. Whatever
acts between bodies is booked on both.
"""

from math import exp, sqrt

from .adhesion import DECAY, FRICTION, RATIO
from .jit import kernel, seldom
from .shift import rail_axes, turned
from .vec3 import add, cross, dot, get, inward, outward

RUNS = 5.0 / 3.6  # speed of the vehicle above which an axle that stands is locked [m/s]
RUNS_FAST = 5.0  # speed above which the largest slide counts [m/s]
LOCKED = 0.05  # of it: speed of the tread below which the axle stands [-]


@kernel
def middle(data, i):
    """Mean of the velocities of body i at both ends of the step: of its centre in track axes, angular in own axes."""
    a, b = data.v_start, data.v
    return (
        (0.5 * (a[i, 0] + b[i, 0]), 0.5 * (a[i, 1] + b[i, 1]), 0.5 * (a[i, 2] + b[i, 2])),
        (0.5 * (a[i, 3] + b[i, 3]), 0.5 * (a[i, 4] + b[i, 4]), 0.5 * (a[i, 5] + b[i, 5])),
    )


@kernel
def pulled(pull, v, w):
    """Power of loads (6,) at a velocity."""
    return pull[0] * v[0] + pull[1] * v[1] + pull[2] * v[2] + pull[3] * w[0] + pull[4] * w[1] + pull[5] * w[2]


@kernel
def on_rails(model, data, w, v, omega):
    """Power of normal forces of wheel w at a velocity of its wheelset, and of its creep forces at their slip.

    omega : in track axes. The couple of a table of heights belongs to the normal forces.
    """
    rail, pressing, creeping = data.rail[w], 0.0, 0.0
    shifted = model.shift.shape[0] > 0
    for j in range(int(rail["patches"])):
        contact = data.contact[w, j]
        slope = contact["slope"]
        cosine = 1.0 / sqrt(1.0 + slope * slope)
        normal = (0.0, -slope * cosine, cosine)
        if shifted:
            normal = turned(rail_axes(rail), normal)
        arm = get(contact["arm"])
        pressing -= contact["normal"] * dot(normal, add(v, cross(omega, arm)))
        creeping += contact["creep_x"] * contact["slip_x"] + contact["creep_t"] * contact["slip_t"]
        creeping += contact["spin_moment"] * dot(normal, omega)
    return pressing + dot(get(rail["couple"]), omega), creeping


@seldom
def book(model, data, step):
    """Book the work of the step that was just made; describe every axle."""
    train, gravity = data.train[0], model.param[0]["gravity"]
    weights = suspended = 0.0
    for i in range(model.body.size):
        v, w = middle(data, i)
        frame = data.frame[i]
        weights += model.body[i]["mass"] * gravity * outward(frame["track"], v)[2]
        suspended += dot(inward(frame["track"], get(frame["force"])), v)
        suspended += dot(inward(frame["axes"], get(frame["moment"])), w)
    for row in range(data.stiff.size):
        line = data.stiff[row]
        if line["change"] != 0.0:
            suspended += line["change"] * parted(data, line)
    braked = driven = pressing = creeping = 0.0
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        rate = -parted(data, data.stiff[axle["row"]])
        tension = data.tension[axle["row"]]
        braked += tension * rate
        driven += port["traction_torque"] * rate
        port["brake_torque"] = tension
        describe_axle(model, data, a, step)
        i = axle["wheelset"]
        v, w = middle(data, i)
        omega = inward(data.frame[i]["track"], outward(data.frame[i]["axes"], w))
        for wheel in range(axle["first"], axle["first"] + 2):
            pressed, crept = on_rails(model, data, wheel, v, omega)
            pressing, creeping = pressing + pressed, creeping + crept
    speed = middle(data, 0)[0][0]
    train["gravity_work"] += step * weights
    train["suspension_loss"] -= step * (suspended + braked - driven)
    train["brake_loss"] += step * braked
    train["traction_work"] += step * driven
    train["normal_loss"] -= step * pressing
    train["creep_loss"] -= step * creeping
    train["resistance_loss"] += step * train["resistance"] * speed
    train["holding_work"] += step * data.traction[0] * speed


@kernel
def parted(data, line):
    """Power of a tension of 1 of an implicit line."""
    v, w = middle(data, line["upper"])
    found = pulled(line["upper_pull"], v, w)
    v, w = middle(data, line["lower"])
    return found + pulled(line["lower_pull"], v, w)


@kernel
def describe_axle(model, data, a, step):
    """Slide, adhesion used and offered, and time and work of an axle that is locked."""
    axle, port = model.axle[a], data.port[a]
    first, i = axle["first"], axle["wheelset"]
    run = data.v[i, 0]
    tread = -axle["radius"] * data.v[i, 4]
    port["slide"] = (run - tread) / run if abs(run) > 1e-3 else 0.0
    if abs(run) > RUNS_FAST:
        port["largest_slide"] = max(port["largest_slide"], port["slide"])
    along = down = offered = work = 0.0
    for w in range(first, first + 2):
        rail = data.rail[w]
        along, down = along + rail["x"], down + rail["q"]
        grip = rail["grip"]
        slid = 0.0
        for j in range(int(rail["patches"])):
            patch = data.contact[w, j]
            slid = max(slid, sqrt(patch["slip_x"] * patch["slip_x"] + patch["slip_t"] * patch["slip_t"]))
            work -= patch["creep_x"] * patch["slip_x"] + patch["creep_t"] * patch["slip_t"]
        offered += 0.5 * grip[FRICTION] * ((1.0 - grip[RATIO]) * exp(-grip[DECAY] * slid) + grip[RATIO])
    port["used"] = along / down if down > 0.0 else 0.0
    port["offered"] = offered
    if abs(run) > RUNS and abs(tread) < LOCKED * abs(run):
        port["locked"] += step
        port["flat_work"] += step * work
