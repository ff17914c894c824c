"""Mode shapes in words: who moves, how, and in which phase (docs/stability.md, section 3)."""

from dataclasses import dataclass

import numpy as np

from railcli.kernels.layout import Kind

PLANES = {"vertical": (0, 2, 4), "lateral": (1, 3, 5)}  # coordinates that a vehicle with like sides keeps apart
WORDS = ("surge", "lateral", "bounce", "roll", "pitch", "yaw")
GROUPS = ("car body", "bogie", "hung part", "wheelset")
MIXED = 0.05  # share of the lesser plane from which a mode belongs to neither
ROLLING = 0.35  # slip of a rolling wheelset, 0 none ... 1, up to which its motion is kinematic
INVOLVED = 0.25  # share of the kinetic energy from which a group is named
CARRIED = 0.5  # share of the largest lateral displacement that a hunting wheelset has at least


@dataclass(frozen=True)
class Shape:
    """One mode in words and numbers.

    Attributes
    ----------
    words : str
        Such as ``car body lower sway`` or ``bogie hunting, in phase``.
    plane : str
        A key of PLANES, or ``mixed``.
    shares : dict
        Kinetic energy by group [-].
    pole : float
        Height of the point about which a car body sways, over the rails [m]; NaN for another mode.
    """

    words: str
    plane: str
    shares: dict
    pole: float


def groups(model):
    """Group of each body: wheelsets spin, car bodies stand on others and carry none, bogies are what is between.

    What stands on none, such as a motor on its frame, is a hung part. Torques carry nothing.
    """
    joints = [j for j in model.joint if (_kinds(model, j) != Kind.TORQUE).any() or j["turn"].any()]
    lower, upper = ({int(j[end]) for j in joints} for end in ("lower", "upper"))
    named = []
    for i, body in enumerate(model.body):
        if body["spins"]:
            named.append("wheelset")
        else:
            named.append(("bogie" if i in lower else "car body") if i in upper or i not in lower else "hung part")
    return np.array(named)


def _kinds(model, joint):
    return model.element["kind"][joint["first"] : joint["first"] + joint["count"]]


def kinetic_shares(model, q):
    """Share of the kinetic energy of each body and coordinate in a mode with displacements q, (n_body, 6)."""
    mass = np.column_stack([*[model.body["mass"]] * 3, model.body["inertia"]])
    energy = mass * np.abs(q) ** 2
    total = energy.sum()
    return energy / total if total > 0.0 else energy


def families(model):
    """Bodies of each group in sets that follow each other along the vehicle: wheelsets by the bogie they carry."""
    of = groups(model)
    bogies = np.flatnonzero(of == "bogie").tolist()
    axles = [[int(j["lower"]) for j in model.joint if j["upper"] == i and of[j["lower"]] == "wheelset"] for i in bogies]
    wheelsets = axles if bogies else [[int(i)] for i in np.flatnonzero(of == "wheelset")]
    alone = {name: [[int(i)] for i in np.flatnonzero(of == name)] for name in ("car body", "hung part")}
    return {**alone, "bogie": [[i] for i in bogies], "wheelset": [list(dict.fromkeys(one)) for one in wheelsets]}


def describe(modes, k):
    """Describe mode k.

    Parameters
    ----------
    modes : analysis.linear.Modes
    k : int

    Returns
    -------
    Shape
    """
    linear = modes.linear
    model, q = linear.system.model, linear.coordinates(modes.right[k])
    of = groups(model)
    share = kinetic_shares(model, q)
    shares = {name: float(share[of == name].sum()) for name in GROUPS if (of == name).any()}
    halves = {name: float(share[:, list(columns)].sum()) for name, columns in PLANES.items()}
    plane = "mixed" if min(halves.values()) > MIXED else max(halves, key=halves.get)
    if plane == "lateral" and _hunts(linear, modes.value[k], q):
        group = "bogie" if "bogie" in shares else "wheelset"
        return Shape(f"{group} hunting{_phase(q, families(model), 'wheelset', 1, False)}", plane, shares, np.nan)
    movers = [name for name, value in shares.items() if value > INVOLVED]
    coordinate = int(np.argmax(share[np.isin(of, movers)].sum(axis=0)))
    first = max(movers, key=shares.get)
    words, pole = f"{' and '.join(movers)} {WORDS[coordinate]}", np.nan
    if movers == ["car body"] and coordinate in (1, 3):
        body = np.flatnonzero(of == first)[np.argmax(share[of == first].sum(axis=1))]
        above = _pole_above(q[body])
        pole = float(above - linear.data.q[body, 2])
        words = f"car body {'lower' if above < 0.0 else 'upper'} sway"
    return Shape(words + _phase(q, families(model), first, coordinate), plane, shares, pole)


def _hunts(linear, value, q):
    """True when the wheelsets swing sideways at least as far as half of all else and roll with little slip.

    A wheelset that rolls without lateral slip has dy/dt = speed * yaw.
    """
    wheelsets = np.flatnonzero(linear.system.model.body["spins"])
    y, yaw = q[wheelsets, 1], q[wheelsets, 5]
    if value.imag <= 0.0 or np.abs(y).max(initial=0.0) < CARRIED * np.abs(q[:, 1]).max():
        return False
    drift, steer = value * y, linear.speed * yaw
    return np.linalg.norm(drift - steer) < ROLLING * (np.linalg.norm(drift) + np.linalg.norm(steer))


def _pole_above(q):
    """How far above the body's centre the point lies that stays at rest in a sway: y + height * roll = 0 [m]."""
    y, roll = q[1], q[3]
    return -(y * np.conj(roll)).real / max(abs(roll) ** 2, 1e-30)


def _phase(q, families, group, coordinate, within=True):
    """Words for who moves together and who opposes; within : of the wheelsets of a bogie too."""
    sets = families[group]
    size = max(np.abs(q[one, coordinate]).max() for one in sets)
    leaders = [q[one[0], coordinate] for one in sets if np.abs(q[one, coordinate]).max() > 0.1 * size]
    words = ""
    if within and any(_opposed(q[one[0], coordinate], q[one[-1], coordinate]) for one in sets):
        words = ", axles opposed"
    if len(leaders) > 1:
        what = "" if group == "bogie" else "wheelsets " if all(len(one) == 1 for one in sets) else "bogies "
        words += f", {what}in {'antiphase' if _opposed(leaders[0], leaders[-1]) else 'phase'}"
    return words


def _opposed(one, other):
    return (one * np.conj(other)).real < 0.0
