"""A vehicle in numbers: masses, centre of gravity, axle loads; rows of tables, the first one their head."""

import textwrap

import numpy as np

from .text import columns, facts

LINE = 118  # characters of a description


def centre_of_gravity(vehicle):
    """Of the whole vehicle: x, y, height above the rails [m]."""
    mass = np.array([body.mass for body in vehicle.bodies])
    return mass @ np.array([body.centre for body in vehicle.bodies]) / mass.sum()


def total_rows(vehicle, loads, gravity):
    """loads : static wheel loads as model.vehicle gives them [N]."""
    sprung = sum(body.mass for body in vehicle.bodies if not body.is_wheelset)
    mass = sum(body.mass for body in vehicle.bodies)
    x, y, height = centre_of_gravity(vehicle).round(6) + 0.0
    axle = loads.sum(axis=1) / gravity * 1e-3
    return [
        ("", ""),
        ("mass", f"{mass * 1e-3:.4g} t, {(mass - sprung) * 1e-3:.4g} t of that in wheelsets"),
        ("centre of gravity", f"x {x:.3f} m, y {y:.3f} m, {height:.3f} m above the rails"),
        ("axle loads", f"{axle.min():.4g} to {axle.max():.4g} t"),
    ]


def body_rows(vehicle):
    rows = [("body", "mass [t]", "x [m]", "y [m]", "height [m]", "Ix, Iy, Iz [t m^2]")]
    for body in vehicle.bodies:
        x, y, height = body.centre
        inertia = ", ".join(f"{value * 1e-3:.4g}" for value in body.inertia)
        rows.append((body.name, f"{body.mass * 1e-3:.4g}", f"{x:.3f}", f"{y:.3f}", f"{height:.3f}", inertia))
    return rows


def axle_rows(vehicle, loads):
    """loads : static wheel loads as model.vehicle gives them [N]."""
    rows = [("wheelset", "x [m]", "Q right [kN]", "Q left [kN]", "radius [mm]")]
    for k, (i, pair, radii) in enumerate(zip(vehicle.wheelsets, loads, vehicle.wheel_radii, strict=True), start=1):
        right, left = radii
        radius = f"{right * 1e3:.6g}" if right == left else f"{right * 1e3:.6g} | {left * 1e3:.6g}"
        rows.append((f"W{k}", f"{vehicle.bodies[i].x:.3f}", *(f"{load * 1e-3:.2f}" for load in pair), radius))
    return rows


def preload_rows(preloads):
    """preloads : list of (Place, force) as model.vehicle.carried [N]; equal ones of one element once."""
    found = {}
    for place, load in preloads:
        key = place.element.name, f"{load * 1e-3:.3f}"
        found[key] = found.get(key, 0) + 1
    rows = [(name, str(count), load) for (name, load), count in found.items()]
    return [("carries weight", "places", "each [kN]"), *rows]


def lines(vehicle, loads, preloads, gravity):
    """All but its modes, for the terminal."""
    tables = body_rows(vehicle), axle_rows(vehicle, loads), preload_rows(preloads)
    text = [vehicle.name, *textwrap.wrap(vehicle.description, LINE, initial_indent="  ", subsequent_indent="  ")]
    text += facts(total_rows(vehicle, loads, gravity)[1:])
    for rows in tables:
        text += ["", *columns(rows[1:], rows[0])]
    return text


def mode_lines(modes, absent, speed):
    """How it swings; absent : why nothing is known of that."""
    if absent:
        return ["", f"No suspension frequencies: {absent}"]
    rows = [(mode["shape"], f"{mode['frequency_hz']:.2f}", f"{100 * mode['damping_ratio']:.1f}") for mode in modes]
    return ["", *columns(rows, (f"swings, at {speed:g} m/s", "f [Hz]", "damping [%]"))]


def as_json(vehicle, loads, preloads, gravity):
    """All but its modes, for a machine; units in the names."""
    bodies = [
        {"name": body.name, "mass_kg": body.mass, "inertia_kg_m2": body.inertia, "centre_m": body.centre}
        for body in vehicle.bodies
    ]
    return {
        "vehicle": vehicle.name,
        "mass_kg": sum(body.mass for body in vehicle.bodies),
        "centre_of_gravity_m": centre_of_gravity(vehicle),
        "bodies": bodies,
        "axle_load_t": loads.sum(axis=1) / gravity * 1e-3,
        "wheel_loads_kN": loads * 1e-3,
        "preloads": [
            {"element": place.element.name, "between": [vehicle.names[place.lower], vehicle.names[place.upper]],
             "force_kN": load * 1e-3}
            for place, load in preloads
        ],
    }  # fmt: skip
