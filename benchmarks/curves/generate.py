"""Write wheel.csv, the wheel of the Cooperrider wagon, from the contact table that the published model reads.

    python benchmarks/curves/generate.py [FOLDER]

The table (reference/contact_table.csv) gives the rolling radius r over the lateral position y of the wheelset, but no
profile. Its contact angles are those of UIC60 at 1:40 on a gauge of 1435 mm at the place of contact, within 0.001 rad
but at y of 4 mm and more. So the rail is known, and the wheel follows: it touches at s where its slope is that of the
rail at x = s + y, and its radius changes with the slope, dr = -slope ds. With slope(x) of the rail that is

    dx/dy = 1 - r'(y) / slope(x),    x(0) from the table,

whose solution gives the wheel's slope at s = x - y. Outside of what the table's motions within 6 mm touch, the wheel is
ours: field side with the table's angles at y = -17 mm, flange of S1002 where it has the same slope.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import UnivariateSpline

from railcli.analysis.rigid_contact import contact_at, wheelset_on
from railcli.files.profiles import load_profile
from railcli.model.contact_table import TableSettings

HERE = Path(__file__).resolve().parent
REACH = -4.3, 6.05  # positions of the wheelset from which the wheel is found [mm]
RADIUS_ERROR = 0.2e-3  # of the table's radii about a smooth curve [mm]
SLOPE_ERROR = 4e-5  # of the wheel's slopes about a smooth curve [rad]
SPACING = 0.25  # of the points [mm]
END = 60.0  # of the wheel on the field side [mm]
TAPE = 750.0  # of the tape circles from the middle of the wheelset [mm]


def rail_slope(settings, wheel, rail):
    """Slope of the inclined rail, positive down to the gauge side, at x [mm] from the middle of the track."""
    wheelset = wheelset_on(settings, wheel, rail)
    on_wheel, _, on_rail = contact_at(wheelset)(0.0)[:3]
    graph, start, step = wheelset.right.rail, wheelset.right.rail_start, wheelset.right.rail_step
    place = TAPE + 1e3 * (on_wheel - on_rail + start + step * np.arange(graph.shape[0]))
    return lambda x: -np.interp(x, place, graph[:, 1])


def wheel_slopes(table, slope):
    """Places s [mm], falling, and slopes of the wheel that rolls on the table's radii."""
    y, on_wheel, radius = table[:, :3].T
    used = y > -10.0
    curve = UnivariateSpline(y[used], radius[used], np.full(used.sum(), 1.0 / RADIUS_ERROR), k=4, s=used.sum())
    begin = TAPE + on_wheel[y == 0.0]
    sides = [
        solve_ivp(lambda y, x: 1.0 - curve.derivative()(y) / slope(x), (0.0, end), begin, max_step=0.01, rtol=1e-8)
        for end in REACH
    ]
    places = np.concatenate([sides[0].t[:0:-1], sides[1].t])
    x = np.concatenate([sides[0].y[0][:0:-1], sides[1].y[0]])
    return x - TAPE - places, slope(x)


def wheel_points(table, slope, other):
    """Points (y, z, angle) of the wheel [mm, rad]; other : the profile whose flange it takes."""
    s, steep = wheel_slopes(table, slope)
    s, steep = s[::-8], steep[::-8]
    outside = table[table[:, 0] < -10.0]
    places = np.concatenate([s, outside[::-1, 1]])
    values = np.concatenate([steep, np.tan(outside[::-1, 3])])
    curve = UnivariateSpline(places, values, np.full(places.size, 1.0 / SLOPE_ERROR), k=3, s=places.size)
    y = np.arange(s[0], outside[:, 1].max(), SPACING)
    z = -curve.antiderivative()(y) + curve.antiderivative()(0.0)
    middle = np.column_stack([y, z, -np.arctan(curve(y))])
    flange = np.column_stack([1e3 * other.y, 1e3 * other.z, other.angle])
    near = np.abs(flange[:, 0] - y[0]) < 10.0
    k = int(np.flatnonzero(near)[np.argmin(np.abs(flange[near, 2] - middle[0, 2]))])
    flange = flange[:k] + np.array([*(middle[0, :2] - flange[k, :2]), 0.0])
    tail = np.arange(y[-1] + 2.0, END + 1.0, 2.0)
    drop = middle[-1, 1] + np.tan(middle[-1, 2]) * (tail - y[-1])
    field = np.column_stack([tail, drop, np.full_like(tail, middle[-1, 2])])
    return np.vstack([flange[flange[:, 0] >= -70.0], middle, field])


def main(folder):
    table = np.loadtxt(HERE / "reference/contact_table.csv", delimiter=",", skiprows=4)
    wheel, rail = load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail")
    settings = TableSettings(radius=0.425, inclination=40.0)
    points = wheel_points(table, rail_slope(settings, wheel, rail), wheel)
    lines = [
        "# name: wheel of the Cooperrider wagon",
        "# kind: wheel",
        "# tape circle: 70 mm from the flange back",
        "# axes: right-hand wheel, y to the field side, z down, origin on the tape circle",
        "# source: made by generate.py from reference/contact_table.csv; see SOURCES.md",
        "y_mm,z_mm,angle_rad",
    ]
    lines += [",".join(f"{value:.6f}" for value in point) for point in points]
    (Path(folder) / "wheel.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else HERE)
