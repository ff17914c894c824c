"""Dry friction, damper tables behind a series spring, and leaf springs (theory.md, 5.5, 5.7 and 5.8).

All have states in Data.damper. `half_step` is half the integrator's step, over which a state moves: it was left at the
middle of the last step and is carried on to the middle of this one. At 0 a state stands still and what slides only
shows its force; beyond SETTLED no friction is left, and state + half_step * rate is the state that belongs to that.
"""

from math import exp, expm1, sqrt

from .curve import read_curve, solve_curve
from .jit import kernel

SETTLED = 1e6  # [s]


@kernel
def series_damper(model, data, element, k, length, half_step):
    """Tension of a spring ks with damper k of the element behind it, beside which a spring kr may stand.

    T = ks (l - x), the damper bears T - kr x at the rate dx/dt; fills its damper_rate. x moves by the implicit midpoint
    rule. Where the table has a flat part, from middle to middle instead: a midpoint rule would let x swing about the
    length that belongs to the plateau.
    """
    state, series, beside = element["state"], element["series"], element["reservoir"]
    before = data.damper[state]
    stretch = length - before
    if half_step > SETTLED:
        move = stretch - beside * length / (series + beside)
        data.damper_rate[state] = move / half_step
        return beside * (before + move)
    way = 2.0 * half_step if element["dry"] else half_step
    weight, trial = way * (series + beside), series * stretch - beside * before
    table = element["damper_curve"][k]
    if table >= 0:
        rate, tension = solve_curve(model.curve[table], weight, trial)
    else:
        rate = trial / (element["c"][k] + weight)
        tension = element["c"][k] * rate
    data.damper_rate[state] = rate
    return tension + beside * (before + way * rate)


@kernel
def friction_limit(data, element):
    """Largest friction force [N]: a constant, and in proportion to what another element carries."""
    limit = element["limit"]
    source = element["source"]
    if source >= 0:
        limit += element["coefficient"] * max(data.carried[source], 0.0)
    return limit


@kernel
def slide(element, trial, limit, half_step):
    """What is left of a trial force of this size, and the rate of sliding over the trial force.

    Beyond the limit the force is the limit and its end slides by (trial - limit) h / (ks h + c), the backward Euler
    step of a spring ks and a damper c side by side, both in series with the friction.
    """
    if trial <= limit:
        return 1.0, 0.0
    excess = 1.0 - limit / trial
    if half_step == 0.0:
        return 1.0 - excess, 0.0
    return 1.0 - excess, excess / (2.0 * half_step * element["series"] + element["c"][0])


@kernel
def dry_link(data, element, length, length_rate, half_step):
    """Tension of dry friction along a line."""
    state = element["state"]
    stretch = length - data.damper[state]
    if half_step > SETTLED:
        data.damper_rate[state] = stretch / half_step
        return 0.0
    trial = element["series"] * stretch + element["c"][0] * length_rate
    left, sliding = slide(element, abs(trial), friction_limit(data, element), half_step)
    data.damper_rate[state] = sliding * trial
    return left * trial


@kernel
def dry_force(data, element, d, rate, half_step):
    """Force on the upper body of dry friction along those axes of the joint where k is not 0, one circle for all.

    d, rate : upper end less lower end [m], [m/s].
    """
    state, series, c, along = element["state"], element["series"], element["c"][0], element["k"]
    trial_x = trial_y = trial_z = 0.0
    place = state
    if along[0] > 0.0:
        trial_x = series * (d[0] - data.damper[place]) + c * rate[0]
        place += 1
    if along[1] > 0.0:
        trial_y = series * (d[1] - data.damper[place]) + c * rate[1]
        place += 1
    if along[2] > 0.0:
        trial_z = series * (d[2] - data.damper[place]) + c * rate[2]
    size = sqrt(trial_x * trial_x + trial_y * trial_y + trial_z * trial_z)
    left, sliding = slide(element, size, friction_limit(data, element), half_step)
    settled = half_step > SETTLED
    if settled:
        left = 0.0
    if along[0] > 0.0:
        data.damper_rate[state] = (d[0] - data.damper[state]) / half_step if settled else sliding * trial_x
        state += 1
    if along[1] > 0.0:
        data.damper_rate[state] = (d[1] - data.damper[state]) / half_step if settled else sliding * trial_y
        state += 1
    if along[2] > 0.0:
        data.damper_rate[state] = (d[2] - data.damper[state]) / half_step if settled else sliding * trial_z
    return -left * trial_x, -left * trial_y, -left * trial_z


@kernel
def leaf_force(model, data, element, d, half_step):
    """Force of a leaf spring against its deflection d [m], downwards positive.

    It fades towards the upper envelope while d grows and towards the lower one while d falls, over the distance
    `decay`: dF/d|d| = (envelope - F) / decay, integrated exactly along the chord of the envelope.
    """
    state = element["state"]
    before, force = data.damper[state], data.damper[state + 1]
    upper, lower = model.curve[element["spring_curve"][0]], model.curve[element["spring_curve"][1]]
    move = d - before
    if half_step > SETTLED:
        middle = 0.5 * (read_curve(upper, d)[0] + read_curve(lower, d)[0])
        data.damper_rate[state] = move / half_step
        data.damper_rate[state + 1] = (middle - force) / half_step
        return middle
    data.damper_rate[state] = data.damper_rate[state + 1] = 0.0
    if move == 0.0:
        return force
    envelope = upper if move > 0.0 else lower
    start, end = read_curve(envelope, before)[0], read_curve(envelope, d)[0]
    way = abs(move) / element["decay"]
    after = end + (force - start) * exp(-way) + (end - start) * expm1(-way) / way
    if half_step > 0.0:
        data.damper_rate[state] = move / (2.0 * half_step)
        data.damper_rate[state + 1] = (after - force) / (2.0 * half_step)
    return after
