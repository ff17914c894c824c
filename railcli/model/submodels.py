"""Registry of the interchangeable sub-models: name in files and options, what it stands for, where it comes from."""

from typing import NamedTuple

from railcli.errors import InputError
from railcli.kernels.layout import Creep

from .checks import hint


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
}

NORMAL_LAWS = {  # value: whether the contact table holds patches
    "hertz": Choice(
        False, "Hertz's ellipse from the curvatures at the rigid contact point", "Hertz (1882); Johnson (1985)"
    ),
    "kp": Choice(
        True,
        "virtual penetration: patch, place and stiffness follow the profiles over the whole patch",
        "Kik and Piotrowski (2008), Vehicle System Dynamics 46, 27-48; corrected to be Hertz's for constant curvature",
    ),
}

# A transition goes from its first to its last value of curvature and cant as this polynomial does from 0 to 1.
TRANSITIONS = {
    "clothoid": Choice((0.0, 1.0, 0.0, 0.0), "linear in length", "EN 13803"),
    "bloss": Choice((0.0, 0.0, 3.0, -2.0), "3 x^2 - 2 x^3 of the length travelled", "Bloss (1936); EN 13803"),
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
