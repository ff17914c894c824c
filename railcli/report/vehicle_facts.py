"""A vehicle in numbers: masses, centre of gravity, axle loads; rows of tables, the first one their head."""

import numpy as np


def centre_of_gravity(vehicle):
    """Of the whole vehicle: x, y, height above the rails [m]."""
    mass = np.array([body.mass for body in vehicle.bodies])
    return mass @ np.array([body.centre for body in vehicle.bodies]) / mass.sum()


def total_rows(vehicle, loads, gravity):
    """loads : static wheel loads as model.vehicle gives them [N]."""
    sprung = sum(body.mass for body in vehicle.bodies if not body.is_wheelset)
    mass = sum(body.mass for body in vehicle.bodies)
    x, y, height = centre_of_gravity(vehicle)
    axle = loads.sum(axis=1) / gravity * 1e-3
    return [
        ("", ""),
        ("mass", f"{mass * 1e-3:.4g} t, of it {(mass - sprung) * 1e-3:.4g} t in wheelsets"),
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
