"""Write the EN 15302 reference profiles beside this script from their section definitions.

    python benchmarks/conicity/generate.py [FOLDER]

Axes: right-hand wheel and rail, y to the field side, z down; y counts from the tape circle, 750 mm from the wheelset's
centre, or from a line 750 mm beside the track's centre. The rail is inclined 1:20 already. Sections: SOURCES.md. Every
join is a point and takes the mean of both sides; the largest step there is printed.
"""

import math
import sys
from pathlib import Path

SPACING = 0.2  # largest distance of points along an arc or line [mm]
FINE = 0.1  # the same on radii up to FINE_RADIUS
FINE_RADIUS = 20.5
CORNER = 0.02  # a corner is rounded over this distance to both sides [mm]
SMOOTH = 1e-3  # two sections that meet at a larger angle make a corner [rad]

ABOVE, BELOW = 1.0, -1.0  # its centre


def arc(start, end, centre_y, centre_z, radius, side):
    """Points (y, z, angle) of z = centre_z - side * sqrt(radius^2 - (y - centre_y)^2) from one y to another [mm]."""
    first, last = (math.asin(min(max((y - centre_y) / radius, -1.0), 1.0)) for y in (start, end))
    count = math.ceil(radius * (last - first) / (FINE if radius <= FINE_RADIUS else SPACING))
    turns = [first + (last - first) * i / count for i in range(count + 1)]
    return [(centre_y + radius * math.sin(t), centre_z - side * radius * math.cos(t), side * t) for t in turns]


def line(start, end, height, slope):
    """Points of z = height + slope * y from one y to another [mm]."""
    count = math.ceil((end - start) * math.hypot(1.0, slope) / SPACING)
    places = [start + (end - start) * i / count for i in range(count + 1)]
    return [(y, height + slope * y, math.atan(slope)) for y in places]


PROFILES = {
    "wheel_a": [
        arc(-70.0, -62.7647, -49.5, 9.51926, 20.5, BELOW),
        arc(-62.7647, -49.6625, -55.0, 16.00065, 12.0, BELOW),
        arc(-49.6625, -39.7645, -58.5583, 8.83556, 20.0, BELOW),
        line(-39.7645, -38.7372, -93.57685, -2.7475),
        arc(-38.7372, -29.4591, -25.5816, 17.64215, 14.0, ABOVE),
        arc(-29.4591, -10.8749, -2.6594, 97.16493, 96.76055, ABOVE),
        arc(-10.8749, 18.4173, 18.4173, 344.50806, 345.0, ABOVE),
        line(18.4173, 30.0, -0.49194, 0.0),
        line(30.0, 60.0, 1.50804, -0.066666),
        line(60.0, 65.0, 57.50808, -1.0),
    ],
    "wheel_h": [
        arc(-70.0, -62.7647, -49.5, 9.5193, 20.5, BELOW),
        arc(-62.7647, -49.6625, -55.0, 16.0, 12.0, BELOW),
        arc(-49.6625, -39.7645, -58.5583, 8.8349, 20.0, BELOW),
        line(-39.7645, -38.7220, -93.5767, -2.7475),
        arc(-38.7220, -28.3119, -25.5663, 17.6003, 14.0, ABOVE),
        line(-28.3119, -10.2297, -1.7902, -0.2),
        line(-10.2297, 30.0, 0.0, -0.025),
        line(30.0, 60.0, 1.251, -0.0667),
        line(60.0, 65.0, 57.249, -1.0),
    ],
    "rail_a": [
        arc(-32.6340, -23.2401, -19.63949, 15.899044, 13.0, ABOVE),
        arc(-23.2401, -7.87490, -1.08250, 80.277908, 80.0, ABOVE),
        arc(-7.87490, 13.09890, 17.59660, 299.483490, 300.0, ABOVE),
        arc(13.09890, 28.67090, 14.29829, 79.508225, 80.0, ABOVE),
        arc(28.67090, 39.27050, 26.33535, 13.598369, 13.0, ABOVE),
    ],
}


def joined(sections):
    """One list of points, and the largest step [mm] between two sections that meet."""
    points, largest = [], 0.0
    for section in sections:
        if points:
            before, after = points.pop(), section[0]
            largest = max(largest, abs(after[1] - before[1]))
            y, z = after[0], (before[1] + after[1]) / 2.0
            if abs(after[2] - before[2]) > SMOOTH:
                points.append((y - CORNER, z - CORNER * math.tan(before[2]), before[2]))
                points.append((y + CORNER, z + CORNER * math.tan(after[2]), after[2]))
            else:
                points.append((y, z, (before[2] + after[2]) / 2.0))
            section = section[1:]
        points.extend(section)
    return points, largest


def main(folder):
    for name, sections in PROFILES.items():
        points, largest = joined(sections)
        rows = "".join(f"{y:.6f},{z:.6f},{angle:.9f}\n" for y, z, angle in points)
        head = f"# EN 15302:2021 {name.replace('_', ' ')}; see SOURCES.md\ny_mm,z_mm,angle_rad\n"
        (folder / f"{name}.csv").write_text(head + rows, encoding="utf-8", newline="\n")
        print(f"{name}: {len(points)} points, largest step between sections {largest * 1e3:.3f} micrometres")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
