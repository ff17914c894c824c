"""Sensors of the axles' speed: ideal, or a phonic wheel whose edges pass at exact angles (docs/subsystems.md, 6)."""

from math import floor, pi

import numpy as np

from .assembly_layout import Sensor
from .jit import kernel, seldom


@seldom
def sense(model, data):
    """The speed of each axle's tread as its sensor has it at this instant, one sample of the controller."""
    assembly, time = model.assembly[0], data.clock[0]
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        spin, radius = data.v[axle["wheelset"], 4], axle["sensed_radius"]
        if assembly["sensor"] == Sensor.IDEAL:
            port["speed"] = abs(radius * spin)
        else:
            tooth = 2.0 * pi / assembly["teeth"]
            place = abs(data.q[axle["wheelset"], 4]) / tooth
            listen(port, place, abs(spin) / tooth, tooth * radius, assembly, time)
        if assembly["noise"] > 0.0:
            port["speed"] = max(port["speed"] + assembly["noise"] * noise(data.train[0]), 0.0)


@kernel
def noise(train):
    """A random number of variance 1: twelve uniform ones from xorshift64 (Marsaglia 2003) less their mean."""
    total = 0.0
    for _ in range(12):
        x = np.uint64(train["seed"])
        x ^= x << np.uint64(13)
        x ^= x >> np.uint64(7)
        x ^= x << np.uint64(17)
        train["seed"] = x
        total += (x >> np.uint64(11)) * 2.0**-53
    return total - 6.0


@kernel
def listen(port, place, rate, way, assembly, time):
    """Speed by the edges of a phonic wheel; place : edges passed, with the fraction of the next; rate : of it [1/s].

    way : of the tread between two edges [m]. COUNTING: edges since the sample before, over the period. TIMING: edges
    between the last ones of both samples, over the time between these; without a new edge, no more than one since.
    """
    edge = floor(place)
    passed = edge - port["edge"]
    if assembly["sensor"] == Sensor.COUNTING:
        port["speed"] = passed * way / assembly["period"] if port["edge_time"] >= 0.0 else 0.0
        port["edge"], port["edge_time"] = edge, time
        return
    if port["edge_time"] < 0.0:
        port["edge"], port["edge_time"], port["speed"] = edge, time, way * rate
        return
    if passed < 1.0:
        port["speed"] = min(port["speed"], way / max(time - port["edge_time"], 1e-9))
        return
    at = time - (place - edge) / rate if rate > 0.0 else time
    if assembly["clock"] > 0.0:
        at = floor(at / assembly["clock"]) * assembly["clock"]
    port["speed"] = passed * way / max(at - port["edge_time"], 1e-9)
    port["edge"], port["edge_time"] = edge, at
