"""Wheel slide protection: reference speed, slide and acceleration of each axle, commands to its dump valve.

docs/subsystems.md, 5. A controller sees what sensors sampled, at its own period, and nothing else; but for the
reference speed `TRUE`, which is there to compare with.
"""

from .assembly_layout import WINDOW, Reference, Valve
from .jit import kernel, seldom

LET_GO = 0.4  # time for which a pilot axle is let go at least [s]
GIVEN_UP = 3.0  # and at most [s]
BACK = 0.5  # acceleration below which it has come back to the speed of the vehicle [m/s^2]
SUSPECT = 0.1  # time for which no axle keeps up with the reference before one is let go [s]
STALE = 10.0  # age beyond which what a pilot told does not count [s]
SLOWEST_FALL = 0.05  # of the reference speed [m/s^2]
FILL, HOLD, VENT = Valve.FILL.value, Valve.HOLD.value, Valve.VENT.value


@kernel
def sample(model, data):
    """Speeds and accelerations of the axles as a controller sees them at its period."""
    assembly = model.assembly[0]
    for a in range(model.axle.size):
        port = data.port[a]
        speed, count = port["speed"], port["kept_count"]
        if count >= WINDOW:
            port["acceleration"] = (speed - port["kept"][(count - WINDOW + 1) % WINDOW]) / (
                (WINDOW - 1) * assembly["period"]
            )
        port["kept"][count % WINDOW] = speed
        port["kept_count"] = count + 1


@kernel
def reference_speed(model, data):
    """Reference speed of this sample [m/s]."""
    if model.assembly[0]["reference"] == Reference.TRUE:
        return abs(data.rate[0, 0])
    return reference_from_axles(model, data)


@seldom
def reference_from_axles(model, data):
    """The fastest axle, and a pilot axle that is let go now and then; our own rule.

    A braked axle turns no faster than the vehicle runs, so the fastest one is a lower bound, and where all slide
    together nothing tells more. The reference therefore falls no faster than a given rate. When no axle keeps up with
    it, one in turn is vented until it is back at the speed of the vehicle: that sets the reference, and two such
    readings the rate at which it falls from then on.
    """
    assembly, train, time = model.assembly[0], data.train[0], data.clock[0]
    if time == 0.0:
        train["reference_rate"] = assembly["reference_fall"]
    fastest = 0.0
    for a in range(model.axle.size):
        fastest = max(fastest, data.port[a]["speed"])
    found = max(train["reference"] - train["reference_rate"] * assembly["period"], 0.0)
    train["alone"] += assembly["period"]
    if fastest >= found:
        found, train["alone"] = fastest, 0.0
    since = time - train["pilot_since"]
    if train["pilot"] < 0:
        waited = train["known_time"] < 0.0 or since > assembly["pilot_every"]
        if train["alone"] > SUSPECT and waited and found > assembly["active_above"]:
            train["pilot"], train["pilot_since"] = train["pilot_next"], time
            train["pilot_next"] = (train["pilot_next"] + 1) % model.axle.size
        return found
    pilot = data.port[train["pilot"]]
    if (since > LET_GO and abs(pilot["acceleration"]) < BACK) or since > GIVEN_UP:
        found = max(fastest, pilot["speed"])
        apart = time - train["known_time"]
        if train["known_time"] >= 0.0 and apart < STALE:
            rate = (train["known_speed"] - found) / apart
            train["reference_rate"] = min(max(rate, SLOWEST_FALL), assembly["reference_fall"])
        train["known_speed"], train["known_time"] = found, time
        train["pilot"], train["pilot_since"] = -1, time
    return found


@seldom
def protect(model, data):
    """Command every valve by fixed limits of slide and acceleration."""
    assembly, train = model.assembly[0], data.train[0]
    reference = train["reference"]
    for a in range(model.axle.size):
        port = data.port[a]
        valve = FILL
        if reference > assembly["active_above"]:
            slide = (reference - port["speed"]) / reference
            falls = port["acceleration"] < assembly["fall"] and slide > assembly["slide_watch"]
            if a == train["pilot"]:
                valve = VENT
            elif slide > assembly["slide_vent"] or falls:
                valve = HOLD if port["acceleration"] >= assembly["regain"] else VENT
            elif slide > assembly["slide_hold"]:
                valve = HOLD
        port["valve"] = valve
