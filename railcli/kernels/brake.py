"""The friction brake: demand, distributor, cylinders behind dump valves, pads or blocks, torque.

docs/subsystems.md, 2. All pressures are relative to that of a cylinder at full demand. The torque is a limit: at rest
against the frame it holds what comes up to it.
"""

from math import exp, log

from .assembly_layout import DELAYED, EVENTS, Pad, Rise, Valve
from .curve import read_curve
from .jit import kernel, seldom
from .traction import electric_share

TO_95_PERCENT = log(20.0)  # time constants
ATMOSPHERE = 1.013e5  # at which air is counted [Pa]
FILL, HOLD, VENT = Valve.FILL.value, Valve.HOLD.value, Valve.VENT.value


@kernel
def delayed(samples, train, demand, delay, time, step):
    """The demand that arrives behind a delay: samples of it, straight between them; none came before the run."""
    if delay <= step:
        return demand
    between = delay / (DELAYED - 2)
    at = int(time / between)
    if time == 0.0:
        train["delayed_at"] = -1
    while train["delayed_at"] < at:
        train["delayed_at"] += 1
        samples[train["delayed_at"] % DELAYED] = demand
    then = (time - delay) / between
    if then < 0.0:
        return 0.0
    k = int(then)
    before, after = samples[k % DELAYED], samples[(k + 1) % DELAYED]
    return before + (then - k) * (after - before)


@kernel
def distribute(assembly, applied, demand, step):
    """Pressure of the distributor a step on, as it follows the demand."""
    rises = demand > applied
    time = assembly["apply"] if rises else assembly["release"]
    if time <= 0.0:
        return demand
    if assembly["rise"] == Rise.EXPONENTIAL:
        return demand + (applied - demand) * exp(-TO_95_PERCENT * step / time)
    rate = 1.0 / time
    if rises and assembly["rise"] == Rise.STEPPED:
        share, quick = assembly["inshot"], assembly["inshot_time"]
        rate = share / quick if applied < share else (1.0 - share) / (time - quick)
    move = rate * step
    return applied + min(max(demand - applied, -move), move)


@kernel
def switch(port, wanted, dead, time):
    """The valve after its dead time; a command that finds no room takes the place of the last one on its way."""
    n = port["events"]
    last = port["event_valve"][n - 1] if n > 0 else port["valve_now"]
    if wanted != last:
        n = min(n + 1, EVENTS)
        port["event_time"][n - 1], port["event_valve"][n - 1] = time + dead, wanted
    gone = 0
    while gone < n and port["event_time"][gone] <= time + 1e-9:
        if port["event_valve"][gone] == VENT and port["valve_now"] != VENT:
            port["vents"] += 1
        port["valve_now"] = port["event_valve"][gone]
        gone += 1
    for k in range(n - gone):
        port["event_time"][k], port["event_valve"][k] = port["event_time"][k + gone], port["event_valve"][k + gone]
    port["events"] = n - gone


@kernel
def fill_cylinder(assembly, valve, relative, before, after, step):
    """Pressure of a cylinder a step on; before, after : of the distributor in the meantime."""
    if assembly["fill"] <= 0.0:
        return after
    if valve == HOLD:
        return relative
    if valve == VENT:
        return relative * exp(-step / assembly["vent"])
    target = 0.5 * (before + after)
    return target + (relative - target) * exp(-step / assembly["fill"])


@kernel
def cast_iron(force, speed):
    """Friction of a block of cast iron P10; force of the block [N], speed of the tread [m/s].

    Karwatzki's law in a public form, force in kN and speed in km/h: 0.6 (1.6 N + 100) / (8 N + 100) (V + 100) /
    (5 V + 100).
    """
    n, v = 1e-3 * force, 3.6 * speed
    return 0.6 * (1.6 * n + 100.0) / (8.0 * n + 100.0) * (v + 100.0) / (5.0 * v + 100.0)


@kernel
def brake_limit(model, axle, relative, speed):
    """Largest torque of an axle's brake [N m] and the friction of its pads [-]; speed : of its tread [m/s]."""
    assembly = model.assembly[0]
    pad = assembly["pad"]
    if pad == Pad.NOMINAL:
        return axle["brake_torque"] * relative, 0.0
    if pad == Pad.CAST_IRON:
        friction = cast_iron(axle["block_force"] * relative, speed)
    elif pad == Pad.TABLE:
        friction = read_curve(model.curve[assembly["pad_curve"]], speed)[0]
    else:
        friction = assembly["pad_friction"]
    return axle["brake_force"] * relative * friction * axle["brake_radius"], friction


@seldom
def brake(model, data, step):
    """Move the brake on by a step: from the driver's demand and the valves to the largest torques, means over it."""
    assembly, train, time = model.assembly[0], data.train[0], data.clock[0]
    arrived = delayed(data.delayed, train, train["brake_demand"], assembly["delay"], time, step)
    before = train["applied"]
    if assembly["electric"] >= 0:
        arrived = max(arrived - electric_share(model, data), 0.0)
    after = distribute(assembly, before, arrived, step)
    train["arrived"], train["applied"] = arrived, after
    for a in range(model.axle.size):
        axle, port = model.axle[a], data.port[a]
        switch(port, port["valve"], assembly["dead"], time)
        old = port["relative"]
        new = fill_cylinder(assembly, port["valve_now"], old, before, after, step)
        mean = 0.5 * (old + new)
        speed = abs(axle["radius"] * data.v[axle["wheelset"], 4])
        limit, friction = brake_limit(model, axle, mean, speed)
        port["relative"], port["pressure"] = new, new * assembly["pressure"]
        port["brake_limit"], port["pad_friction"] = limit, friction
        port["air"] += assembly["volume"] * max(new - old, 0.0) * assembly["pressure"] / ATMOSPHERE
