"""The comparison of the contact with published references as text, JSON and CSV."""

import numpy as np

from railcli.analysis.contact_benchmark import deviations
from railcli.analysis.contact_check import COEFFICIENTS, PUBLISHED

from . import normal_validation
from .criteria import criteria_json, document, verdict, verdict_line, words
from .text import columns, sectioned

TITLE = "Wheel-rail contact against published references"
FIGURES = ("benchmark", "forces", "creep", "normal")
SIDES = ("right", "left")
GROUPS = ("no spin", "light spin", "medium spin", "heavy spin", "spin alone", "full slip", "all")
LIMITS = ("no slip", "full slip", "direction", "pure spin", "bound")
QUANTITIES = {  # of the benchmark: name for readers, unit, units per SI unit, decimals
    "on_rail": ("position on the rail", "mm", 1e3, 2),
    "on_wheel": ("position on the wheel", "mm", 1e3, 2),
    "z_wheel": ("height on the wheel", "mm", 1e3, 3),
    "angle": ("contact angle", "deg", 180.0 / np.pi, 2),
    "area": ("patch area", "mm2", 1e6, 1),
    "pressure": ("greatest pressure", "MPa", 1e-6, 0),
    "approach": ("approach", "um", 1e6, 1),
    "normal": ("normal force", "N", 1.0, 0),
    "x_force": ("longitudinal force on the rail", "N", 1.0, 0),
    "y_force": ("lateral force on the rail", "N", 1.0, 0),
    "creep_x": ("creep force on the rail along x", "N", 1.0, 0),
    "creep_t": ("creep force on the rail across", "N", 1.0, 0),
    "xi": ("longitudinal creepage", "1e-3", 1e3, 3),
    "eta": ("lateral creepage", "1e-3", 1e3, 3),
    "phi": ("spin creepage", "1/m", 1.0, 3),
}
WHEELSET = {  # of the whole wheelset
    "roll": ("roll", "mrad", 1e3, 3),
    "delta_r": ("delta-r from the height on the wheel", "mm", 1e3, 3),
    "spin": ("spin of the wheelset", "rad/s", 1.0, 5),
}
SPREAD = {  # deviations beside a known spread: name, units per number of `deviations`, format
    "on_rail": ("position on the rail [mm]", 1e3, "+.2f"),
    "area": ("patch area", 1.0, "+.0%"),
    "pressure": ("greatest pressure", 1.0, "+.0%"),
    "approach": ("approach", 1.0, "+.0%"),
    "normal": ("normal force", 1.0, "+.1%"),
    "creep_x": ("creep force along x over mu N", 1.0, "+.3f"),
    "creep_t": ("creep force across over mu N", 1.0, "+.3f"),
}
OF_THE_NORMAL_LAW = ("on_rail", "area", "pressure", "approach", "normal")
OF_BOTH_LAWS = ("creep_x", "creep_t")


def closed_forms(result):
    """Hertz and Kalker: largest relative deviations."""
    rows = [("Hertz", "20 wheel-rail pairs", *(f"{value:.1e}" for value in np.abs(result.hertz).max(axis=0)))]
    lines = columns(rows, ("largest relative deviation", "", "a", "b", "pressure", "approach"))
    rows = []
    for name, values in result.kalker.items():
        rows.append((f"Kalker: {name}", *(f"{value:.1e}" for value in values), *("" for _ in range(4 - len(values)))))
    return lines + columns(rows, ("", *COEFFICIENTS))


def creep_text(result):
    """Distance of every creep law from the full solution, from converged FASTSIM, and its limits."""
    lines = []
    for other in PUBLISHED:
        rows = []
        for law, found in result.laws.items():
            cells = (found.distances[group, other] for group in GROUPS)
            rows.append((law, *(f"{mean:.3f} / {largest:.2f}" for mean, largest in cells)))
        lines += columns(rows, (f"from {other}: mean / largest", *GROUPS))
    rows = [(law, *(f"{found.limits[key]:.1g}" for key in LIMITS)) for law, found in result.laws.items()]
    header = ("in the limits", "no slip", "size, full slip", "direction, full slip", "fx, spin alone", "over mu N")
    return lines + columns(rows, header)


def geometry_text(result, normal):
    """Contact of one normal law over y, railcli's beside the reference."""
    (_, law), states = next((key, states) for key, states in result.states.items() if key[0] == normal)
    ours, other = states.values, result.reference.values
    rows = []
    for i, y in enumerate(result.reference.y):
        pairs = [
            *((1e3 * states_values["on_rail"][i, k], 2) for k in (1, 0) for states_values in (ours, other)),
            (1e3 * states.delta_r[i], 3), (1e3 * result.reference.delta_r[i], 3),
            *((np.degrees(source["angle"][i, 0]), 2) for source in (ours, other)),
        ]  # fmt: skip
        off = [ours[key][i, k] / other[key][i, k] - 1.0 for key in ("area", "pressure", "normal") for k in (1, 0)]
        rows.append(
            (f"{y * 1e3:g}", *(f"{value:.{digits}f}" for value, digits in pairs), *(f"{value:+.1%}" for value in off))
        )
    header = (
        "y", "rail L", "ref.", "rail R", "ref.", "delta-r", "ref.", "angle R", "ref.", "area L", "R", "pmax L", "R",
        "N L", "R",
    )  # fmt: skip
    places = ", ".join(f"{place * 1e3:.3f}" for place in result.jumps[normal, law])
    return [*columns(rows, header), f"  mm, degrees; relative deviations. Jumps of the right wheel at y = {places} mm."]


def two_patches(result, normal):
    """States in which a wheel bears on more than one patch: places on the rail [mm]."""
    states = next(states for key, states in result.states.items() if key[0] == normal)
    rows = []
    for i, k in zip(*np.nonzero(states.values["patches"] > 1), strict=True):
        share, *places = (states.values[key][i, k] for key in ("share", "on_rail", "other_on_rail", "centre"))
        places = [f"{place * 1e3:.2f}" for place in (*places, result.reference.values["on_rail"][i, k])]
        rows.append((f"{states.y[i] * 1e3:g} mm, {SIDES[k]}", f"{share:.1%}", *places))
    header = ("y, wheel", "greatest share of the load", "at", "next patch at", "mean by load", "CONTACT, one patch")
    return columns(rows, header) if rows else ["  none"]


def forces_text(result):
    """Creep forces over y: deviation of every combination over mu N, that of the wheel which is further off."""
    lines = []
    header = [f"{y * 1e3:g}" for y in result.reference.y]
    for key, name in (("creep_x", "along x, at y [mm]"), ("creep_t", "across, at y [mm]")):
        rows = []
        for (normal, law), states in result.states.items():
            off = deviations(states, result.reference)[key]
            worst = off[np.arange(off.shape[0]), np.abs(off).argmax(axis=1)]
            rows.append((f"{normal}, {law}", *(f"{value:+.3f}" for value in worst)))
        lines += columns(rows, (name, *header))
    return lines


def spread_text(result):
    """Lowest and highest deviations beside what is known of other fast methods."""
    first = {}
    for key in result.extremes:
        first.setdefault(key[0], key)
    rows = []
    for quantity in OF_THE_NORMAL_LAW:
        ends = [result.known[quantity], *(result.extremes[key][quantity] for key in first.values())]
        rows.append((SPREAD[quantity][0], *(_range(quantity, pair) for pair in ends)))
    lines = columns(rows, ("from y = 1 mm on", "other fast methods", *first))
    rows = [("other fast methods", *(_range(quantity, result.known[quantity]) for quantity in OF_BOTH_LAWS))]
    for (normal, law), found in result.extremes.items():
        rows.append((f"{normal}, {law}", *(_range(quantity, found[quantity]) for quantity in OF_BOTH_LAWS)))
    return lines + columns(rows, ("", *(SPREAD[quantity][0] for quantity in OF_BOTH_LAWS)))


def _range(quantity, ends):
    _, factor, form = SPREAD[quantity]
    return " to ".join(format(factor * end, form) for end in ends)


def criteria_text(result):
    """Every criterion with what was found; those of the benchmark over all combinations of laws."""
    rows, combined = [], {}
    for row in result.rows:
        title, _, name = row.name.partition(": ")
        if title.startswith("A-2.2"):
            combined.setdefault(name, []).append((title.removeprefix("A-2.2, "), row))
        else:
            rows.append((row.name, f"{row.found:.2g}", f"{row.limit:g}", words(row)))
    every = {_creep_law(title) for group in combined.values() for title, _ in group}
    for name, group in combined.items():
        for counts in (True, False):
            chosen = [(title, row) for title, row in group if row.counts is counts]
            if chosen:
                found = sorted({f"{row.found:.2g}" for _, row in chosen}, key=float)
                missed = [title for title, row in chosen if not row.kept]
                told = words(chosen[0][1]) if not missed or len(missed) == len(chosen) else "MISSED by some"
                cells = " to ".join(found[:: max(len(found) - 1, 1)]), f"{chosen[0][1].limit:g}", told
                laws = sorted({_creep_law(title) for title, _ in chosen})
                whose = "all combinations" if set(laws) == every else ", ".join(laws)
                rows.append((f"A-2.2, {whose}: {name}", *cells))
                if 0 < len(missed) < len(chosen):
                    rows.append((f"    missed by {', '.join(missed)}", "", "", ""))
    return columns(rows, ("criterion", "found", "limit", ""))


def _creep_law(title):
    return title.rpartition(" and ")[2]


def report(result):
    """Titles and lines of the whole report, for the terminal and for validation.md."""
    sections = [
        ("Closed forms", closed_forms(result)),
        ("Creep laws: distance of the force vectors over mu N", creep_text(result)),
    ]
    for normal in dict.fromkeys(key[0] for key in result.states):
        sections += [
            (f"Manchester contact benchmark, A-2.2: contact, normal law {normal}", geometry_text(result, normal)),
            (f"More than one patch on a wheel, normal law {normal}", two_patches(result, normal)),
        ]
    sections += [
        ("A-2.2: creep forces less those of CONTACT over mu N, the wheel that is further off", forces_text(result)),
        ("A-2.2: deviations from CONTACT beside the known spread", spread_text(result)),
        *normal_validation.sections(result),
        ("Criteria", criteria_text(result)),
    ]
    return sections


def records(result):
    """One record for each compared value of the benchmark."""
    found = []
    for (normal, law), states in result.states.items():
        for i, y in enumerate(result.reference.y):
            entry = {"normal_law": normal, "creep_law": law, "y_mm": round(y * 1e3, 6)}
            for key, (_, unit, factor, _) in WHEELSET.items():
                found.append(entry | _compared("", key, unit, factor, getattr(states, key)[i],
                                               getattr(result.reference, key)[i]))  # fmt: skip
            for k, side in enumerate(SIDES):
                for key, (_, unit, factor, _) in QUANTITIES.items():
                    ours, other = states.values[key][i, k], result.reference.values[key][i, k]
                    found.append(entry | _compared(side, key, unit, factor, ours, other))
    return found


def _compared(side, quantity, unit, factor, ours, other):
    return {
        "wheel": side, "quantity": quantity, "unit": unit, "railcli": float(factor * ours),
        "contact": float(factor * other), "deviation": float(factor * (ours - other)),
    }  # fmt: skip


def csv(result):
    """Every compared value of the benchmark as CSV."""
    rows = records(result)
    lines = [",".join(rows[0])]
    lines += [",".join(value if isinstance(value, str) else f"{value:.6g}" for value in row.values()) for row in rows]
    return "\n".join(lines) + "\n"


def as_json(result, provenance):
    """The whole comparison as one object."""
    return {
        "verdict": verdict(result.rows),
        "criteria": criteria_json(result.rows),
        "hertz": dict(zip(("semi_x", "semi_y", "pressure", "approach"), np.abs(result.hertz).max(axis=0), strict=True)),
        "kalker": {name: dict(zip(COEFFICIENTS, values, strict=False)) for name, values in result.kalker.items()},
        "creep_laws": {
            law: {
                "limits": found.limits,
                "distances": {
                    other: {
                        group: dict(zip(("mean", "max"), found.distances[group, other], strict=True))
                        for group in GROUPS
                    }
                    for other in PUBLISHED
                },
            }
            for law, found in result.laws.items()
        },
        "benchmark": records(result),
        "jumps_mm": [
            {"normal_law": normal, "creep_law": law, "places": [place * 1e3 for place in places]}
            for (normal, law), places in result.jumps.items()
        ],
        "spread": [
            {"normal_law": normal, "creep_law": law, **found} for (normal, law), found in result.extremes.items()
        ],
        "known_spread": result.known,
        "normal_states": normal_validation.records(result),
        "provenance": provenance,
    }


def terminal(sections, result):
    """The report for a terminal."""
    return sectioned(TITLE, sections, verdict_line(result.rows))


def markdown(sections, result, origin, figures=True):
    """The report as validation.md."""
    return document(TITLE, verdict_line(result.rows), sections, FIGURES if figures else (), origin)
