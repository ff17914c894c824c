"""Registry of the interchangeable sub-models: name in files and options, what it stands for, where it comes from."""

from typing import NamedTuple

import numpy as np

from railcli.errors import InputError
from railcli.kernels.layout import Creep

from .checks import hint

TRANSITION_CUBICS = 32  # of the shapes that are no polynomials; sine within 6.2e-7 of its rise, cosine within 1.3e-7


class Choice(NamedTuple):
    """One sub-model."""

    value: object  # what the packed arrays hold
    summary: str
    source: str


CREEP_LAWS = {
    "hard": Choice(
        Creep.HARD,
        "linear creep force, cut off at friction times normal force",
        "Kalker's linear theory, saturated at the adhesion limit",
    ),
    "smooth": Choice(
        Creep.SMOOTH,
        "linear creep force, bent towards the limit by a cubic law, spin in the resultant",
        "Shen, Hedrick and Elkins (1983), 8th IAVSD symposium, 591-605",
    ),
    "polach": Choice(
        Creep.POLACH,
        "closed form of the slip, with a force of spin; meant for traction and braking on the tread",
        "Polach (1999), Vehicle System Dynamics 33 (supplement), 728-739; reduction factors (2005), Wear 258, 992-1000",
    ),
    "fastsim": Choice(
        Creep.FASTSIM,
        "simplified theory, integrated over the patch at every step; slow",
        "Kalker (1982), Vehicle System Dynamics 11, 1-13, parabolic bound, three flexibilities",
    ),
    "table": Choice(
        Creep.TABLE,
        "the simplified theory from a table; recommended",
        "as fastsim, extrapolated to elements of no length",
    ),
    "fastrip": Choice(
        Creep.FASTRIP,
        "strip theory in adhesion, simplified theory in slip, from a table; nearest to the full solution",
        "after Sichani, Enblom and Berg (2016), Vehicle System Dynamics 54, 748-764; theory.md 7.10",
    ),
}

NORMAL_LAWS = {  # value: what the contact table holds beside rigid contact points
    "hertz": Choice(
        "",
        "Hertz's ellipse from the curvatures at each rigid contact point; where points join or end, as at the flange "
        "root, its force makes or loses energy: there use overlap",
        "Hertz (1882); Johnson (1985); theory.md 6.4",
    ),
    "overlap": Choice(
        "heights",
        "strips of the rail under the wheel's overlap: the gradient of one elastic energy, so that contact makes none",
        "theory.md 6.7; the idea of strips: Ayasse and Chollet (2005), Sichani, Enblom and Berg (2014)",
    ),
}


ADHESION_SETS = {  # value: mu0, A, B [s/m], k_A, k_S of Polach (2005), as kernels/assembly_layout.Grip
    "dry": Choice(
        (0.55, 0.40, 0.60, 1.00, 0.40), "dry rail",
        "Polach (2005), Wear 258, 992-1000; recovered from the fits of a public simulator",
    ),
    "wet": Choice((0.30, 0.40, 0.20, 0.30, 0.10), "wet rail", "as dry"),
    "low": Choice(
        (0.06, 0.40, 0.20, 1.00, 0.40), "leaves, moisture or a thin film",
        "from knowledge of published Huddersfield work, not read",
    ),
    "very-low": Choice(
        (0.03, 0.10, 0.20, 1.00, 0.40), "a thick film: a locked wheel hardly brakes",
        "from knowledge of published Huddersfield work, not read",
    ),
}  # fmt: skip


class Shape(NamedTuple):
    """Rise from 0 to 1 over 0 to 1, cubic by cubic."""

    start: np.ndarray  # (n,) where each cubic begins
    coefficients: np.ndarray  # (n, 4) in the distance from there

    def __call__(self, x):
        """Values at x (m,), between 0 and 1."""
        piece = np.clip(np.searchsorted(self.start, x, side="right") - 1, 0, None)
        u, c = x - self.start[piece], self.coefficients[piece].T
        return c[0] + u * (c[1] + u * (c[2] + u * c[3]))


def _cubics(*rows):
    """Shape of rows (start, c0, c1, c2, c3)."""
    rows = np.array(rows)
    return Shape(rows[:, 0], rows[:, 1:])


def _joined(value, slope, count=TRANSITION_CUBICS):
    """Shape of `count` equal cubics that have value and slope of a function where they meet (Hermite)."""
    x, h = np.linspace(0.0, 1.0, count + 1), 1.0 / count
    v, d = value(x), slope(x)
    rise = np.diff(v) / h
    square = (3.0 * rise - 2.0 * d[:-1] - d[1:]) / h
    cube = (d[:-1] + d[1:] - 2.0 * rise) / h**2
    return Shape(x[:-1], np.column_stack([v[:-1], d[:-1], square, cube]))


# A transition goes from its first to its last value of curvature, cant and gauge as its shape does from 0 to 1.
TRANSITIONS = {
    "clothoid": Choice(_cubics((0.0, 0.0, 1.0, 0.0, 0.0)), "linear in length", "EN 13803"),
    "bloss": Choice(
        _cubics((0.0, 0.0, 0.0, 3.0, -2.0)), "3 x^2 - 2 x^3 of the length travelled", "Bloss (1936); EN 13803"
    ),
    "helmert": Choice(
        _cubics((0.0, 0.0, 0.0, 2.0, 0.0), (0.5, 0.5, 2.0, -2.0, 0.0)),
        "two parabolas, 2 x^2 and 1 - 2 (1 - x)^2 (Schramm)",
        "EN 13803",
    ),
    "cosine": Choice(
        _joined(lambda x: 0.5 - 0.5 * np.cos(np.pi * x), lambda x: 0.5 * np.pi * np.sin(np.pi * x)),
        "(1 - cos pi x) / 2",
        "EN 13803",
    ),
    "sine": Choice(
        _joined(lambda x: x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi), lambda x: 1.0 - np.cos(2.0 * np.pi * x)),
        "x - sin(2 pi x) / 2 pi (Klein)",
        "EN 13803",
    ),
}


def choose(table, where, name):
    """Entry `name` of a registry.

    Parameters
    ----------
    table : dict of str to Choice
    where : str
        Option or key that gave the name, for the message.
    name : str

    Raises
    ------
    InputError
        The name is unknown; the message says which one is near.
    """
    if name not in table:
        raise InputError(where, f"unknown name {name!r}; {hint(name, table)}")
    return table[name]
