"""The subsystems of a vehicle in their order: line, driver, sensors, controllers that are due, actuators.

docs/subsystems.md, 9. They act at the beginning of a step, from its state, and what they hand to the vehicle stands
until the next one.
"""

from .adhesion import lend
from .assembly_layout import Driver, Odometry, Protection
from .brake import brake
from .driver import STANDS, ask
from .guest import invite
from .implicit import CREEP_RATE
from .jit import kernel, seldom
from .layout import Status
from .odometry import judge, tell
from .sensor import sense
from .slide_protection import protect, reference_speed, sample
from .traction import drive, regulate
from .vec3 import accumulate, dot, get, inward, scale, sub

STOOD = 0.5  # time after which a run that ends with it is over [s]
RESISTS = 0.05  # speed from which on running resistance is full [m/s]
SURE = 2.0  # how many times over a brake must be unable to stop its axle within a step to count as sliding
DUE = 1e-9  # a sample is due this much before its time [s]


@seldom
def act(model, data):
    """Everything that happens at the beginning of a step. Returns a status."""
    assembly, train = model.assembly[0], data.train[0]
    step, time = model.param[0]["step"], data.clock[0]
    if model.line.shape[0] > 0:
        lend(model, data, step)
    ask(model, data, step)
    if assembly["period"] > 0.0 and time >= train["due"] - DUE:
        train["due"] += assembly["period"]
        fault = control(model, data)
        if fault != 0:
            data.fault[0] = fault - 1
            return Status.GUEST.value
    drive(model, data, step)
    brake(model, data, step)
    return 0


@seldom
def control(model, data):
    """Read the sensors; let every controller act. Returns the guest's fault."""
    assembly, train = model.assembly[0], data.train[0]
    sense(model, data)
    sample(model, data)
    if assembly["protection"] != Protection.NONE:
        train["reference"] = reference_speed(model, data)
        protect(model, data)
    if assembly["antislip"]:
        regulate(model, data)
    if assembly["odometry"] != Odometry.NONE:
        tell(model, data)
        if data.clock[0] == 0.0:
            train["began"] = data.q[0, 0]
        judge(model, data, train["began"])
    return invite(model, data) if assembly["guest"] != 0 else 0


@seldom
def torques(model, data, reach, moving):
    """Add the torques of brakes and traction to data.frame; fill their lines of data.stiff.

    reach : share of the step after which velocities count [s].  moving : whether a step is taken.
    A brake that cannot stop its axle within the step bears its limit; else it acts implicitly, as dry friction does.
    """
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        i, k = axle["wheelset"], axle["frame"]
        wheelset, frame = data.frame[i], data.frame[k]
        axes = wheelset["axes"]
        about = (axes[0, 1], axes[1, 1], axes[2, 1])
        rate = dot(about, sub(get(frame["omega_frame"]), get(wheelset["omega"])))
        limit, row = port["brake_limit"], axle["row"]
        line = data.stiff[row]
        inertia = model.body[i]["inertia"][1]
        line["upper"], line["lower"], line["curve"] = k, i, -1
        line["damping"], line["friction"], line["rate"] = 0.0, limit, rate
        rolling = axle["radius"] * abs(data.rail[axle["first"]]["x"] + data.rail[axle["first"] + 1]["x"])
        line["slides"] = not moving or limit == 0.0 or abs(rate) * inertia > SURE * reach * (limit + rolling)
        if line["slides"]:
            data.tension[row] = limit if rate > 0.0 else -limit
            if not moving:
                data.tension[row] *= min(abs(rate) / CREEP_RATE, 1.0)
        on_wheelset, on_frame = inward(axes, about), inward(frame["axes"], about)
        for c in range(3):
            line["upper_pull"][c], line["lower_pull"][c] = 0.0, 0.0
            line["upper_pull"][3 + c], line["lower_pull"][3 + c] = -on_frame[c], on_wheelset[c]
        turn = scale(data.tension[row] - port["traction_torque"], about)
        accumulate(wheelset["moment"], turn)
        accumulate(frame["moment"], scale(-1.0, turn))


@kernel
def resist(model, data):
    """Running resistance A + B V + C V^2 on the first body, against its motion; it fades towards standstill."""
    resistance = model.assembly[0]["resistance"]
    v = data.rate[0, 0]
    size = abs(v)
    force = (resistance[0] + size * (resistance[1] + size * resistance[2])) * min(max(v / RESISTS, -1.0), 1.0)
    data.train[0]["resistance"] = force
    data.load[0, 0] -= force


@kernel
def over(model, data):
    """Whether the run has reached its end: a place, the last stop of the driver's plan, standstill under the brake."""
    assembly, train = model.assembly[0], data.train[0]
    if data.q[0, 0] >= assembly["end_place"]:
        return True
    if assembly["driver"] == Driver.LINE:
        return bool(train["next"] >= model.plan.shape[0] and model.plan[model.plan.shape[0] - 1]["dwell"] > 0.0)
    return bool(assembly["ends"] and train["standing"] >= STOOD)


@kernel
def watch_standing(data, step):
    """Note where and when the vehicle comes to stand under its brake."""
    train = data.train[0]
    if abs(data.v[0, 0]) >= STANDS or train["brake_demand"] == 0.0:
        train["standing"] = 0.0
        if abs(data.v[0, 0]) >= 10.0 * STANDS:
            train["stop_time"] = -1.0
        return
    if train["stop_time"] < 0.0:
        train["stop_time"], train["stop_place"] = data.clock[0], data.q[0, 0]
    train["standing"] += step
