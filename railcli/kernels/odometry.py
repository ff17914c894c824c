"""Odometry: speed and distance from the sensors of the axles (docs/subsystems.md, 6)."""

from .assembly_layout import Odometry
from .jit import kernel, seldom
from .vec3 import cross, get, scale

GATE = 3.0  # standard deviations beyond which an axle does not agree with the accelerometer
CONE_METRES, CONE_SHARE = 5.0, 0.05  # SUBSET-041, 5.3.1: error of the distance that is granted


@seldom
def tell(model, data):
    """Move odometer speed and distance on by a sample."""
    assembly, train = model.assembly[0], data.train[0]
    before, period = train["odometer_speed"], assembly["period"]
    if data.clock[0] == 0.0:
        train["odometer_speed"] = mean_speed(data)
        train["odometer_variance"] = assembly["speed_noise"] ** 2
        return
    if assembly["odometry"] == Odometry.KALMAN:
        filtered(model, data)
    else:
        limited(model, data)
    train["odometer"] += 0.5 * period * (before + train["odometer_speed"])


@kernel
def mean_speed(data):
    """Of all axles [m/s]."""
    total = 0.0
    for a in range(data.port.size):
        total += data.port[a]["speed"]
    return total / data.port.size


@kernel
def limited(model, data):
    """The fastest axle while the brake acts, the slowest in traction, else their mean; within limits of the rate."""
    assembly, train = model.assembly[0], data.train[0]
    slowest, fastest = 1e300, 0.0
    for a in range(data.port.size):
        slowest, fastest = min(slowest, data.port[a]["speed"]), max(fastest, data.port[a]["speed"])
    if train["brake_demand"] > 0.0:
        found = fastest
    elif train["traction_demand"] > 0.0:
        found = slowest
    else:
        found = mean_speed(data)
    before, period = train["odometer_speed"], assembly["period"]
    low, high = before - period * assembly["odometer_fall"], before + period * assembly["odometer_rise"]
    train["odometer_speed"] = max(min(max(found, low), high), 0.0)


@kernel
def sensed_acceleration(model, data):
    """What an accelerometer along the first body shows; on a gradient it feels a part of gravity [m/s^2]."""
    frame, speed = data.frame[0], data.rate[0, 0]
    carried = cross(scale(speed, get(frame["rate"])), (data.v[0, 0], data.v[0, 1], data.v[0, 2]))
    return data.dv[0, 0] + carried[0] - model.param[0]["gravity"] * frame["track"][2, 0] + model.assembly[0]["bias"]


@kernel
def filtered(model, data):
    """A Kalman filter of the speed: the accelerometer predicts, axles within GATE correct, one after the other."""
    assembly, train = model.assembly[0], data.train[0]
    period = assembly["period"]
    speed = train["odometer_speed"] + period * sensed_acceleration(model, data)
    variance = train["odometer_variance"] + (period * assembly["acceleration_noise"]) ** 2
    noise = assembly["speed_noise"] ** 2
    for a in range(data.port.size):
        lack = data.port[a]["speed"] - speed
        if lack * lack > GATE * GATE * (variance + noise):
            continue
        gain = variance / (variance + noise)
        speed += gain * lack
        variance *= 1.0 - gain
    train["odometer_speed"], train["odometer_variance"] = max(speed, 0.0), variance


@kernel
def judge(model, data, start):
    """Note the largest error of the distance over what is granted; start : arc length at which the run began [m]."""
    train = data.train[0]
    run = data.q[0, 0] - start
    train["odometer_cone"] = max(
        train["odometer_cone"], abs(train["odometer"] - run) / (CONE_METRES + CONE_SHARE * abs(run))
    )
