"""Scalar forces and torques that are implicit in their rate: stiff dampers and dry friction (theory.md section 8.7).

Each has a tension T that resists the rate r at which its ends part. Data.tension keeps T from step to step.
"""

from .block import block, raise_diagonal, solve
from .curve import solve_curve
from .jit import kernel, seldom
from .vec3 import get, inward, scale

SWEEPS = 200  # over all of them, at most; from step to step a few will do
SETTLED = 1e-16  # of sum(W T^2): what the last sweep may have changed
CREEP_RATE = 1e-3  # rate below which dry friction is not full where no step is taken [rad/s]


@kernel
def slip_torque(friction, rate):
    """Dry friction at a rate where no step is taken: full beyond CREEP_RATE, none at rest."""
    return friction * min(max(rate / CREEP_RATE, -1.0), 1.0)


@seldom
def write_line(data, joint, row, pull, upper_moment, lower_moment, rate):
    """Fill Data.stiff[row] with bodies, rate and loads per tension.

    pull : minus the force on the upper body per tension, its reaction on the lower one.  upper_moment, lower_moment :
    minus the moments on them about their centres.  All in ground axes.
    """
    line = data.stiff[row]
    upper, lower = data.frame[joint["upper"]], data.frame[joint["lower"]]
    f, m = inward(upper["track"], pull), inward(upper["axes"], upper_moment)
    g, n = inward(lower["track"], pull), inward(lower["axes"], lower_moment)
    on_upper, on_lower = line["upper_pull"], line["lower_pull"]
    for a in range(3):
        on_upper[a], on_upper[3 + a] = -f[a], -m[a]
        on_lower[a], on_lower[3 + a] = g[a], -n[a]
    line["upper"], line["lower"], line["rate"] = joint["upper"], joint["lower"], rate


@kernel
def answer(model, data, i, reach, force, moment):
    """(M + reach C)^-1 of a force and moment on wheelset i, C = -d load / d v of its creep forces."""
    c, body = data.creep_damping, model.body[i]
    mass = body["mass"]
    p, q = block(c, i, 0, 0, reach), block(c, i, 0, 3, reach)
    r, s = block(c, i, 3, 0, reach), block(c, i, 3, 3, reach)
    return solve(raise_diagonal(p, (mass, mass, mass)), q, r, raise_diagonal(s, get(body["inertia"])), force, moment)


@kernel
def answer_line(model, data, i, pull, found, reach):
    """Accelerations of body i under the loads `pull` of a tension of 1, into `found`; returns pull . found."""
    body = model.body[i]
    f, g = (pull[0], pull[1], pull[2]), (pull[3], pull[4], pull[5])
    if body["spins"]:
        u, w = answer(model, data, i, reach, f, g)
    else:
        inertia = body["inertia"]
        u, w = scale(1.0 / body["mass"], f), (g[0] / inertia[0], g[1] / inertia[1], g[2] / inertia[2])
    work = 0.0
    for a in range(3):
        found[a], found[3 + a] = u[a], w[a]
        work += pull[a] * u[a] + pull[3 + a] * w[a]
    return work


@kernel
def bear(model, line, rate, tension):
    """Tension of one element where its curve meets the line rate - give (T - tension)."""
    give, friction = line["give"], line["friction"]
    shift = 0.0
    if friction > 0.0:
        sticking = tension + rate / give
        if abs(sticking) <= friction:
            return sticking
        shift = friction if sticking > 0.0 else -friction
    if line["curve"] >= 0:
        return shift + solve_curve(model.curve[line["curve"]], 1.0 / give, rate / give + tension - shift)[1]
    return shift + line["damping"] * (rate + give * (tension - shift)) / (1.0 + line["damping"] * give)


@seldom
def settle_tensions(model, data, reach):
    """Correct data.dv and data.tension so that every implicit element bears the tension of its own rate.

    reach : share of the step after which the velocity counts [s]. In turns over the elements (Gauss and Seidel).
    data.dv has been found with the present tensions; data.dv_start is the acceleration at which rates were taken.
    """
    dv, before = data.dv, data.dv_start
    for row in range(data.stiff.size):
        line = data.stiff[row]
        line["change"] = 0.0
        if line["slides"]:
            continue
        work = answer_line(model, data, line["upper"], line["upper_pull"], line["upper_answer"], reach)
        work += answer_line(model, data, line["lower"], line["lower_pull"], line["lower_answer"], reach)
        line["give"] = reach * work
    for _ in range(SWEEPS):
        moved = total = 0.0
        for row in range(data.stiff.size):
            line = data.stiff[row]
            if line["slides"]:
                continue
            up, low = line["upper"], line["lower"]
            change = 0.0
            for a in range(6):
                change += line["upper_pull"][a] * (dv[up, a] - before[up, a])
                change += line["lower_pull"][a] * (dv[low, a] - before[low, a])
            tension = bear(model, line, line["rate"] - reach * change, data.tension[row])
            more = tension - data.tension[row]
            data.tension[row] = tension
            line["change"] += more
            for a in range(6):
                dv[up, a] += more * line["upper_answer"][a]
                dv[low, a] += more * line["lower_answer"][a]
            moved += line["give"] * more * more
            total += line["give"] * tension * tension
        if moved <= SETTLED * total:
            break
