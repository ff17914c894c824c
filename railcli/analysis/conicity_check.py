"""The comparison of equivalent conicity with the reference tables of EN 15302 and with cones."""

from dataclasses import dataclass, replace

import numpy as np

from railcli.model.contact_table import TableSettings
from railcli.model.profile import Profile

from .conicity import Rolling, conicity, rolling, swing
from .rigid_contact import Wheelset, wheelset_on

COMBINATIONS = {"A/A": ("wheel_a", "rail_a"), "H/A": ("wheel_h", "rail_a")}
LATERAL = 0.750  # origins of the standard's profiles from the middle [m]
RADIUS = 0.460  # [m]
CONES = (1.0 / 40.0, 1.0 / 20.0, 1.0 / 10.0)
CONE_WIDTH = 60e-3  # to both sides of the tape circle [m]
REACH = 8e-3  # beyond the largest amplitude of the tables [m]


@dataclass(frozen=True)
class Tables:
    """What one edition prints of one combination: delta-r over y, conicity over amplitude (arrays) [m, -]."""

    y: np.ndarray
    difference: np.ndarray
    amplitude: np.ndarray
    conicity: np.ndarray


@dataclass(frozen=True)
class Comparison:
    """One combination against one edition.

    Attributes
    ----------
    edition, combination, profiles : str
        `profiles`: "sections" or "digitised".
    amplitude, ours, table, tolerance : arrays (n,)
        [m], conicity of railcli and of the table [-], and what the standard tolerates [-].
    near_jump : bool array (n,)
        Amplitudes near a jump of delta-r.
    """

    edition: str
    combination: str
    profiles: str
    amplitude: np.ndarray
    ours: np.ndarray
    table: np.ndarray
    tolerance: np.ndarray
    near_jump: np.ndarray

    @property
    def away(self):
        """Largest deviation away from jumps [-]."""
        return float(np.abs(self.ours - self.table)[~self.near_jump].max())

    @property
    def largest(self):
        """Largest deviation [-]."""
        return float(np.abs(self.ours - self.table).max())

    @property
    def share(self):
        """Largest deviation as a share of the tolerance [-]."""
        return float((np.abs(self.ours - self.table) / self.tolerance).max())


@dataclass(frozen=True)
class Row:
    """One criterion: what it is about, what was found, its limit, and whether it counts for the verdict."""

    name: str
    found: float
    limit: float
    counts: bool = True

    @property
    def kept(self):
        return bool(self.found <= self.limit)


@dataclass(frozen=True)
class Outcome:
    """Everything that `railcli validate conicity` reports.

    Attributes
    ----------
    rows : list of Row
    comparisons : list of Comparison
    contact : dict
        combination -> Rolling, from the sections.
    tables : dict
        (edition, combination) -> Tables.
    """

    rows: list
    comparisons: list
    contact: dict
    tables: dict

    @property
    def accepted(self):
        return all(row.kept for row in self.rows if row.counts)


def reference_wheelset(wheel, rail):
    """A wheelset over a track in the standard's convention: both profiles' origins 750 mm from the middle."""
    pair = wheelset_on(TableSettings(inclination=0.0, radius=RADIUS), wheel, rail)
    mounting = replace(pair.right, seat=0.0)
    return Wheelset(mounting, mounting, LATERAL)


def cone(slope):
    """A wheel that is a cone; its larger radius on the flange side."""
    y = np.linspace(-CONE_WIDTH, CONE_WIDTH, 241)
    return Profile("cone", "wheel", y, -slope * y, np.full(y.size, -np.arctan(slope)))


def near_jumps(contact, amplitude, window):
    """True where an amplitude lies within `window` [m] of a jump of delta-r."""
    jumps = np.abs(contact.y[contact.jumps])
    return np.array([np.abs(jumps - a).min(initial=np.inf) <= window for a in amplitude], dtype=bool)


def compare(edition, combination, profiles, contact, tables, criteria):
    """Conicity of a contact against a table.

    Returns
    -------
    Comparison
    """
    limits = criteria["conicity"]
    ours = np.array([motion.conicity for motion in conicity(contact, tables.amplitude)])
    tolerance = np.minimum(limits["tolerance"], limits["tolerance_share"] * tables.conicity)
    near = near_jumps(contact, tables.amplitude, limits["jump_window_mm"] * 1e-3)
    return Comparison(edition, combination, profiles, tables.amplitude, ours, tables.conicity, tolerance, near)


def delta_r_errors(contact: Rolling, tables, criteria, combination):
    """How far the table's delta-r lies from ours, jumps and misprints left out [m].

    Returns
    -------
    median : float
        Of the deviations at the same y.
    largest : float
        Largest distance from what ours takes within the allowed shift in y.
    """
    limits = criteria["delta_r"]
    shift = limits["shift_mm"] * 1e-3
    misprints = [y * 1e-3 for name, y in limits["misprints"] if name == combination]
    near = near_jumps(contact, np.abs(tables.y), criteria["conicity"]["jump_window_mm"] * 1e-3)
    deviations, distances = [], []
    for y, value, skip in zip(tables.y, tables.difference, near, strict=True):
        if skip or any(abs(y - place) < 1e-6 for place in misprints):
            continue
        around = np.interp([y - shift, y, y + shift], contact.y, contact.radius_difference)
        deviations.append(abs(around[1] - value))
        distances.append(max(around.min() - value, value - around.max(), 0.0))
    return float(np.median(deviations)), max(distances)


def quadrature_error(tables):
    """Largest deviation of the quadrature of a table's own delta-r, taken straight between its values [-]."""
    inside = tables.amplitude <= tables.y[-1]
    ours = [swing(tables.y, tables.difference, 2.0 * LATERAL, RADIUS, a).conicity for a in tables.amplitude[inside]]
    return float(np.abs(np.array(ours) - tables.conicity[inside]).max())


def compare_conicity(profiles, digitised, tables, criteria, progress=None):
    """Compare with both editions, with the digitised points, and with cones.

    Parameters
    ----------
    profiles, digitised : dict
        name -> Profile.
    tables : dict
        (edition, combination) -> Tables.
    criteria : dict
    progress : callable, optional
        Called with the share done, 0 ... 1.

    Returns
    -------
    Outcome
    """
    rows, comparisons, contacts = [], [], {}
    limits, shift = criteria["conicity"], criteria["delta_r"]["shift_mm"]
    for number, (combination, (wheel, rail)) in enumerate(COMBINATIONS.items()):
        contact = contacts[combination] = rolling(reference_wheelset(profiles[wheel], profiles[rail]), REACH)
        found = compare("2021", combination, "sections", contact, tables["2021", combination], criteria)
        old = compare("2008", combination, "sections", contact, tables["2008", combination], criteria)
        raw = rolling(reference_wheelset(digitised[wheel], digitised[rail]), REACH)
        points = compare("2021", combination, "digitised", raw, tables["2021", combination], criteria)
        comparisons += [found, old, points]
        median, furthest = delta_r_errors(contact, tables["2021", combination], criteria, combination)
        own_error = quadrature_error(tables["2008", combination])
        rows += [
            Row(f"{combination}: conicity away from jumps, 2021 edition", found.away, limits["away_from_jumps"]),
            Row(f"{combination}: conicity over the standard's tolerance, 2021 edition", found.share, 1.0),
            Row(f"{combination}: conicity over the standard's tolerance, 2008 edition", old.share, 1.0),
            Row(f"{combination}: delta-r away from jumps, median [mm]", median * 1e3, criteria["delta_r"]["median_mm"]),
            Row(
                f"{combination}: delta-r away from jumps, largest beyond {shift:g} mm in y [mm]",
                furthest * 1e3, criteria["delta_r"]["largest_mm"],
            ),
            Row(
                f"{combination}: conicity of the 2008 edition from its own delta-r",
                own_error, criteria["quadrature"]["own_table"],
            ),
            Row(f"{combination}: the same from digitised points", points.share, 1.0, counts=False),
        ]  # fmt: skip
        if progress:
            progress(0.4 * (number + 1))
    for slope in CONES:
        contact = rolling(reference_wheelset(cone(slope), profiles["rail_a"]), REACH)
        motions = conicity(contact, np.arange(1, 8) * 1e-3)
        error = max(abs(motion.conicity - slope) for motion in motions)
        name = f"cone 1:{1 / slope:g}: conicity against its slope, 1 to 7 mm"
        rows.append(Row(name, error, criteria["cone"]["slope"]))
    if progress:
        progress(1.0)
    return Outcome(rows, comparisons, contacts, tables)
