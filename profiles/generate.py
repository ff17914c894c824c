"""Write the bundled profiles from their published section definitions.

    python profiles/generate.py [FOLDER]

writes UIC60/UIC60.csv, UIC60/60E1.csv and ORES1002/ORES1002.csv below FOLDER (default: the folder of this script) and
prints their SHA-256. Only the standard library is used, so that the bytes do not depend on a numpy version.

A profile is a chain of arcs and of graphs z(y) that meet with a common tangent. Every join is a point of the file, and
the points between lie on the exact curve. Axes: right-hand rail and wheel, y [mm] to the field side, z [mm] down; the
tangent angle is atan2(dz, dy) walking from the gauge side to the field side. Sources: SOURCE.md beside each file.
"""

import hashlib
import math
import sys
from pathlib import Path

COARSE, FINE = 0.25, 0.1  # largest arc length between points [mm]; the fine one for radii up to FINE_RADIUS
FINE_RADIUS = 20.5
TURN = 0.1  # largest turn between points [rad]


def arc(centre, k, start, end):
    """Arc of signed radius k [mm] (curvature 1/k) between two tangent angles [rad]: a list of (y, z, angle)."""
    spacing = FINE if abs(k) <= FINE_RADIUS else COARSE
    n = math.ceil(abs(end - start) / min(TURN, spacing / abs(k)))
    angles = [start + (end - start) * i / n for i in range(n + 1)]
    return [(centre[0] + k * math.sin(a), centre[1] - k * math.cos(a), a) for a in angles]


def graph(function, start, end, steepest, spacing=COARSE):
    """Curve z(y) between two y [mm]; `function` gives (z, dz/dy), `steepest` bounds |dz/dy|."""
    n = math.ceil((end - start) * math.hypot(1.0, steepest) / spacing)
    points = []
    for i in range(n + 1):
        y = round(start + (end - start) * i / n, 9)
        z, slope = function(y)
        points.append((y, z, math.atan(slope)))
    return points


def chain(sections):
    """One list of points from sections that meet; a join takes the mean of both sides."""
    points = list(sections[0])
    for section in sections[1:]:
        before, after = points.pop(), section[0]
        if max(abs(b - a) for b, a in zip(before, after, strict=True)) > 1e-6:
            raise ValueError(f"sections do not meet: {before} and {after}")
        points.append(tuple((b + a) / 2 for b, a in zip(before, after, strict=True)))
        points.extend(section[1:])
    return points


# rail head 60E1: R300 | R80 | R13 | side 1:20, tangent to one another, symmetric

SIDE = math.atan(20.0)
SIDE_END = 37.5  # z [mm]


def rail_head(width_300, width_80):
    """Head of the 60 kg rail [mm] from the full widths of its R300 and R80 parts; origin at the crown.

    The side runs down to z = 37.5 mm, about its corner with the underside; the R3 that rounds this corner from
    z = 35.3 mm on is left out, no wheel reaches it.
    """
    end_300 = math.asin(width_300 / 2 / 300)
    centre_80 = (220 * math.sin(end_300), 300 - 220 * math.cos(end_300))
    end_80 = math.asin((width_80 / 2 - centre_80[0]) / 80)
    centre_13 = (centre_80[0] + 67 * math.sin(end_80), centre_80[1] - 67 * math.cos(end_80))
    crown = arc((0.0, 300.0), 300, 0.0, end_300)
    shoulder = arc(centre_80, 80, end_300, end_80)
    corner = arc(centre_13, 13, end_80, SIDE)
    y0, z0, _ = corner[-1]
    n = math.ceil((SIDE_END - z0) / math.sin(SIDE) / COARSE)
    depths = [(SIDE_END - z0) * i / n for i in range(n + 1)]
    side = [(y0 + depth / 20, z0 + depth, SIDE) for depth in depths]
    right = chain([crown, shoulder, corner, side])
    return [(-y, z, -a) for y, z, a in reversed(right[1:])] + right


# wheel S1002, flange height 28 mm, flange thickness 32.5 mm

TREAD_LINE = (1.364323640, -0.066666667)
TREAD = (0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8,
         -1.562379023e-8, 5.309217349e-15, -5.957839843e-12, 2.646656573e-13)  # fmt: skip
ROOT = (-4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875,
        -2.054332446e-1, -4.169739389e-3, -4.687195829e-5, -2.252755540e-7)  # fmt: skip
FLANK = (-93.576667419, -2.747477419)
# signed radius, centre; negative: convex
ROOT_ARC = (13.0, (-26.210665, 16.446))
FLANK_ARC = (-20.0, (-58.558326413, 8.834924130))
TIP_ARC = (-12.0, (-55.0, 16.0))
BACK_ARC = (-20.5, (-49.5, 9.519259302))
# y where the sections meet, from the flange back to the face of the rim
BACK, TIP_BACK, TIP_FLANK, FLANK_TOP, FLANK_END, ROOT_START, TREAD_START, LINE_START, CHAMFER, FACE = (
    -70.0, -62.764705882, -49.662510381, -39.764473993, -38.426669071, -35.0, -26.0, 32.15796, 60.0, 65.0,
)  # fmt: skip
CHAMFER_EDGE = 0.1  # radius [mm] that breaks the edge between tread and chamfer


def polynomial(coefficients):
    """Function giving value and slope of a polynomial by Horner's scheme."""

    def evaluate(y):
        value = slope = 0.0
        for c in reversed(coefficients):
            slope = slope * y + value
            value = value * y + c
        return value, slope

    return evaluate


def closing(function, start, end, start_to, end_to):
    """`function` plus the cubic that gives it the value and slope `start_to` at `start` and `end_to` at `end`."""
    at_start, at_end, length = function(start), function(end), end - start
    p0, m0 = (to - found for to, found in zip(start_to, at_start, strict=True))
    p1, m1 = (to - found for to, found in zip(end_to, at_end, strict=True))

    def evaluate(y):
        t = (y - start) / length
        value, slope = function(y)
        value += (1 + 2 * t) * (1 - t) ** 2 * p0 + t * t * (3 - 2 * t) * p1
        value += length * t * (1 - t) * ((1 - t) * m0 - t * m1)
        slope += 6 * t * (1 - t) * (p1 - p0) / length + (1 - t) * (1 - 3 * t) * m0 + t * (3 * t - 2) * m1
        return value, slope

    return evaluate


def arc_angle(k, centre, y):
    """Tangent angle of an arc at y; the half of the circle with |angle| <= 90 degrees."""
    return math.asin(max(-1.0, min(1.0, (y - centre[0]) / k)))


def wheel():
    """S1002 from the flange back to the outer end of the chamfer [mm]; origin on the tape circle."""

    def part(k, centre, start, end):
        return arc(centre, k, arc_angle(k, centre, start), arc_angle(k, centre, end))

    root_arc = part(*ROOT_ARC, FLANK_END, ROOT_START)
    _, z, angle = root_arc[-1]
    root = closing(polynomial(ROOT), ROOT_START, TREAD_START, (z, math.tan(angle)), polynomial(TREAD)(TREAD_START))
    line = polynomial(TREAD_LINE)
    line_angle, chamfer_angle = math.atan(TREAD_LINE[1]), math.atan(-1.0)
    reach = CHAMFER_EDGE * math.tan((line_angle - chamfer_angle) / 2)
    edge_start, edge_end = CHAMFER - reach * math.cos(line_angle), CHAMFER + reach * math.cos(chamfer_angle)
    edge_centre = (edge_start + CHAMFER_EDGE * math.sin(line_angle),
                   line(edge_start)[0] - CHAMFER_EDGE * math.cos(line_angle))  # fmt: skip
    chamfer = polynomial((line(CHAMFER)[0] + CHAMFER, -1.0))
    return chain([
        part(*BACK_ARC, BACK, TIP_BACK),
        part(*TIP_ARC, TIP_BACK, TIP_FLANK),
        part(*FLANK_ARC, TIP_FLANK, FLANK_TOP),
        graph(polynomial(FLANK), FLANK_TOP, FLANK_END, 2.75),
        root_arc,
        graph(root, ROOT_START, TREAD_START, 0.92, FINE),
        graph(polynomial(TREAD), TREAD_START, LINE_START, 0.25),
        graph(line, LINE_START, edge_start, 0.07),
        arc(edge_centre, -CHAMFER_EDGE, line_angle, chamfer_angle),
        graph(chamfer, edge_end, FACE, 1.0),
    ])  # fmt: skip


RAIL_AXES = "right-hand rail, y to the field side, z down, origin at the crown of the symmetric, uninclined head"
WHEEL_AXES = "right-hand wheel, y to the field side, z down, origin on the tape circle"
FILES = {
    "UIC60/UIC60.csv": ("UIC60", "rail", RAIL_AXES, "UIC 60, older drawing: R300 width 21 mm, R80 width 52 mm",
                        lambda: rail_head(21.0, 52.0)),
    "UIC60/60E1.csv": ("60E1", "rail", RAIL_AXES, "EN 13674-1:2017: R300 width 20.456 mm, R80 width 52.053 mm",
                       lambda: rail_head(20.456, 52.053)),
    "ORES1002/ORES1002.csv": ("ORES1002", "wheel", WHEEL_AXES, "UIC 510-2, S1002 h28 e32.5", wheel),
}  # fmt: skip


def text(name, kind, axes, source, points):
    """Content of one profile file."""
    word = {"rail": "inclination: upright", "wheel": "tape circle: 70 mm from the flange back"}[kind]
    lines = [f"# name: {name}", f"# kind: {kind}", f"# {word}", f"# axes: {axes}", f"# source: {source}; see SOURCE.md"]
    lines.append("y_mm,z_mm,angle_rad")
    lines.extend(f"{round(y, 9) + 0.0:.9f},{round(z, 9) + 0.0:.9f},{a:.12f}" for y, z, a in points)
    return "\n".join(lines) + "\n"


def main(folder):
    for relative, (name, kind, axes, source, build) in FILES.items():
        content = text(name, kind, axes, source, build()).encode("ascii")
        path = folder / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        print(f"{hashlib.sha256(content).hexdigest()}  {relative}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
