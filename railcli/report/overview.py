"""The contact overview for readers: tables, sentences, JSON, CSV and the one picture."""

import math
import textwrap
from itertools import pairwise

import numpy as np
from matplotlib.patches import Polygon

from railcli.analysis.build_table import wheel_regions

from . import wheelset
from .conicity import conicity_curves
from .figures import BLUE, GREEN, GREY, draw
from .text import columns
from .wheelset import SIGN

REGIONS = ("tip", "flank", "root", "tread")  # of a wheel profile from the flange to the field side
WIDTH = 7.5  # of the picture: fits A4 upright with margins of 10 mm [inch]
PANEL = 3.0  # width of the axes of one side in it [inch]
CURVES = 1.95, 1.2  # height of a row of curves, as much as the page leaves of this or at least that [inch]
PAGE = 10.9  # height [inch]
HEADS = (0.45, 0.75, 0.65, 0.65)  # titles and labels of the rows [inch]
DPI = 250
CAPTION = 120  # letters in a line
LINE = 116  # likewise of printed text
HEADLINE = 84
LABEL_HEIGHT, LABEL_WIDTH = 17.0, 16.0  # of the numbers at a patch, in its scale [mm]
NAME_HEIGHT = 8.0  # of the names of the regions, likewise [mm]
READ_OFF = 3e-3  # amplitude at which the conicity is written into the picture [m]
CONVENTIONS = (
    "y of the wheelset's centre at axle height, to the right; seen from behind, rolling away from the reader; "
    "delta-r = right less left rolling radius; contact positions count to the field side; contact angles are positive "
    "towards the flange; roll is positive when the right wheel goes down"
)
LEGEND = (
    f"Wheels are drawn {wheelset.LIFT:g} mm above their rails, lines join what touches at each mm of y (numbers); "
    "patches are drawn to the same scale in their contact planes, rolling direction up, with normal force [kN] and "
    "greatest pressure [MPa]"
)


def summary(title, contact, motions, level, patches, loading):
    """Lines of what touches where, conicity, patches, and what a reader must know.

    Parameters
    ----------
    title : str
    contact : Rolling
    motions, level : list of Swing
        Of the contact, and of the level wheelset without yaw; the same list when that is what the contact is.
    patches : list of Standing
    loading : str
        As `loading_text`.
    """
    lines = [title, *_wrapped(f"Conventions: {CONVENTIONS}.")]
    for side in ("right",) if contact.wheelset.alike else ("right", "left"):
        lines.append(f"Contact of the {side} wheel [mm, mrad, degrees]:")
        rows = [
            (
                f"{row['y_mm']:.0f}", f"{row['roll_mrad']:.3f}", f"{row['delta_r_mm']:.3f}",
                f"{row[side]['on_wheel_mm']:.2f}", f"{row[side]['on_rail_mm']:.2f}", f"{row[side]['angle_deg']:.2f}",
                f"{row[side]['radius_mm']:.3f}", row[side]["region"],
            )
            for row in positions(contact)
        ]  # fmt: skip
        lines += columns(rows, ("y", "roll", "delta-r", "on wheel", "on rail", "angle", "radius", "region"))
    if contact.wheelset.alike:
        lines.append("  left wheel: as the right one at -y")
    lines.append("Equivalent conicity tan gamma_e:")
    header = ("amplitude [mm]", "as shown", "level, no yaw (EN 15302)")
    rows = [
        (f"{one.amplitude * 1e3:g}", _number(one.conicity), _number(other.conicity))
        for one, other in zip(motions, level, strict=True)
    ]
    if motions is level:
        rows, header = [row[:2] for row in rows], (header[0], "level (EN 15302)")
    lines += columns(rows, header)
    lines += _wrapped(f"Patches, {loading}:")
    rows = [
        (
            f"{one.y * 1e3:g}", patch.side, patch.region, f"{patch.on_wheel * 1e3:.2f}",
            f"{math.degrees(patch.angle):.2f}", f"{patch.normal / 1e3:.2f}", f"{patch.half_length * 1e3:.2f}",
            f"{patch.half_width * 1e3:.2f}", f"{patch.area * 1e6:.1f}", f"{patch.pressure / 1e6:.0f}",
            f"{patch.approach * 1e6:.1f}",
        )
        for one in patches
        for patch in one.patches
    ]  # fmt: skip
    header = ("y", "wheel", "region", "on wheel", "angle", "N [kN]", "a", "b", "area [mm2]", "p max [MPa]", "d [um]")
    lines += columns(rows, header)
    return [*lines, *sentences(contact, patches)]


def _wrapped(text):
    return textwrap.wrap(text, LINE, subsequent_indent="  ")


def sentences(contact, patches):
    """What a reader must know: jumps of delta-r, flange contact, several patches at once, conformal contact."""
    found = []
    for i in contact.jumps:
        if contact.y[i] < 0.0 and contact.wheelset.alike:
            continue
        before, after = contact.radius_difference[[i, i + 1]] * 1e3
        found.append(
            f"delta-r jumps by {after - before:+.3f} mm at y = {contact.y[i] * 1e3:.3f} mm, from {before:.3f} to "
            f"{after:.3f} mm: {' and '.join(_hops(contact, i))}."
        )
    left, right = (place * 1e3 for place in contact.clearance)
    for wheel, place in (("right", right), ("left", left)):
        if math.isfinite(place):
            found.append(f"The flank of the {wheel} wheel touches from y = {place:.2f} mm on.")
    if not math.isfinite(left) and not math.isfinite(right):
        found.append(f"No flank touches up to y = {contact.y[-1] * 1e3:g} mm.")
    for one in patches:
        for side in ("right", "left"):
            parts = [f"{patch.normal / 1e3:.1f} kN on the {patch.region}" for patch in one.of(side)]
            if len(parts) > 1:
                found.append(f"At y = {one.y * 1e3:g} mm the {side} wheel bears on {len(parts)}: {', '.join(parts)}.")
            if _crowded(one.of(side)):
                found.append(
                    f"At y = {one.y * 1e3:g} mm patches of the {side} wheel meet: they are one that is no ellipse, and "
                    "pressures there are estimates."
                )
    return [*(["Jumps of delta-r: none."] if contact.jumps.size == 0 else []), *found]


def _crowded(patches):
    """True when two patches of one wheel reach as far as each other."""
    return any(
        abs(b.on_wheel - a.on_wheel) < a.half_width * math.cos(a.angle) + b.half_width * math.cos(b.angle)
        for a, b in pairwise(patches)
    )


def _hops(contact, i):
    """Which wheels jump between positions i and i + 1, from where to where."""
    for side in ("right", "left"):
        mounting = getattr(contact.wheelset, side)
        before, after = contact.values[f"s_{side}"][[i, i + 1]]
        if abs(after - before) > 1e-4:
            start, end = (f"{s * 1e3:.1f} mm ({region(mounting, s)})" for s in (before, after))
            yield f"the {side} wheel hops from {start} to {end}"


def region(mounting, s):
    """Part of the wheel profile at profile coordinate s [m]."""
    return REGIONS[int(np.searchsorted(wheel_regions(mounting), s, side="right"))]


def _number(value):
    return f"{value:.4f}" if math.isfinite(value) else "-"


def loading_text(load, settings, with_roll, normal="hertz"):
    """The assumptions under which patches were computed, as a phrase."""
    law = {
        "hertz": f"Hertz's ellipse with curvatures averaged over {settings.curvature_window * 1e3:g} mm",
        "overlap": "strips of the rail under the overlap of the profiles",
    }[normal]
    return (
        f"{load / 1e3:g} kN of vertical force on each wheel, normal forces only, E = {settings.young / 1e9:g} GPa, "
        f"nu = {settings.poisson:g}, {law}, elastic; the wheelset "
        f"{'rolls until both wheels bear it' if with_roll else 'stays level'}"
    )


def positions(contact):
    """Contact at whole mm of y: dicts with units in their names."""
    rows = []
    for i in wheelset.whole_positions(contact):
        row = {
            "y_mm": round(contact.y[i] * 1e3, 6),
            "roll_mrad": contact.values["roll"][i] * 1e3,
            "delta_r_mm": contact.radius_difference[i] * 1e3,
        }
        for side in ("right", "left"):
            v = {name: contact.values[f"{name}_{side}"][i] for name in ("s", "rail", "angle", "r")}
            row[side] = {
                "on_wheel_mm": v["s"] * 1e3,
                "on_rail_mm": v["rail"] * 1e3,
                "angle_deg": math.degrees(v["angle"]),
                "radius_mm": v["r"] * 1e3,
                "region": region(getattr(contact.wheelset, side), v["s"]),
            }
        rows.append(row)
    return rows


def patch_rows(patches):
    """Patches as flat dicts with units in their names."""
    return [
        {
            "y_mm": one.y * 1e3,
            "wheel": patch.side,
            "region": patch.region,
            "roll_mrad": one.roll * 1e3,
            "on_wheel_mm": patch.on_wheel * 1e3,
            "on_rail_mm": patch.on_rail * 1e3,
            "angle_deg": math.degrees(patch.angle),
            "radius_mm": patch.radius * 1e3,
            "normal_kN": patch.normal / 1e3,
            "a_mm": patch.half_length * 1e3,
            "b_mm": patch.half_width * 1e3,
            "area_mm2": patch.area * 1e6,
            "pressure_MPa": patch.pressure / 1e6,
            "approach_um": patch.approach * 1e6,
        }
        for one in patches
        for patch in one.patches
    ]


def as_json(names, settings, choices, contact, motions, level, patches, loading):
    """Everything `railcli contact` prints, for a machine; units in the names.

    Parameters
    ----------
    choices : dict
        Other options to be told with it.
    """
    return {
        "profiles": names,
        "settings": settings,
        **choices,
        "conventions": CONVENTIONS,
        "loading": loading,
        "flank_from_mm": [place * 1e3 for place in contact.clearance],
        "jumps": [
            {"y_mm": contact.y[i] * 1e3, "delta_r_mm": (contact.radius_difference[[i, i + 1]] * 1e3).tolist()}
            for i in contact.jumps
        ],
        "contact": positions(contact),
        "conicity": [
            {"amplitude_mm": one.amplitude * 1e3, "conicity": one.conicity, "level": other.conicity}
            for one, other in zip(motions, level, strict=True)
        ],
        "patches": patch_rows(patches),
        "sentences": sentences(contact, patches),
    }


def contact_csv(contact):
    """Contact at whole mm of y as CSV, right and left wheel side by side."""
    rows = []
    for row in positions(contact):
        both = {f"{key}_{side}": value for side in ("right", "left") for key, value in row[side].items()}
        rows.append({**{key: row[key] for key in ("y_mm", "roll_mrad", "delta_r_mm")}, **both})
    return _csv(rows)


def patches_csv(patches):
    """Patches as CSV."""
    return _csv(patch_rows(patches))


def _csv(rows):
    cells = [[value if isinstance(value, str) else f"{value + 0.0:.6f}" for value in row.values()] for row in rows]
    return "\n".join(map(",".join, [rows[0], *cells])) + "\n"


def plot(title, contact, motions, level, patches, loading, path):
    """Draw profiles with contact lines, patches, delta-r, contact angles, positions on the wheel and conicity.

    Parameters as of `summary`; motions and level over many amplitudes make smooth curves.
    """
    extents = [wheelset.frame(mounting) for mounting in contact.wheelset.mountings]
    scale = PANEL / max(high - low for (low, high), _ in extents)
    rows, bottom = _rows(patches)
    caption = f"{CONVENTIONS}. {LEGEND}; {loading}.".replace("delta-r", "\N{GREEK CAPITAL LETTER DELTA}r")
    caption = textwrap.fill(caption, CAPTION)
    fixed = [scale * max(high - low for _, (low, high) in extents), -scale * bottom]
    rest = sum(HEADS) + 0.5 + 0.15 * caption.count("\n") + sum(fixed)
    curves = max(min(CURVES[0], 0.5 * (PAGE - rest)), CURVES[1])
    ratios = [height + head for height, head in zip([*fixed, curves, curves], HEADS, strict=True)]

    def paint(figure):
        figure.suptitle(textwrap.fill(title, HEADLINE), fontsize=10, fontweight="bold")
        figure.supxlabel(caption, fontsize=8)
        grid = figure.add_gridspec(4, 2, height_ratios=ratios)
        for column, side in enumerate(("left", "right")):
            above = figure.add_subplot(grid[0, column])
            wheelset.profiles(above, contact, side, labels=True)
            above.set_title(f"{side.capitalize()} wheel and rail")
            axis = figure.add_subplot(grid[1, column], sharex=above)
            _patches(axis, contact, patches, side, rows, bottom)
            axis.set_xlabel(above.get_xlabel())
            above.set_xlabel("")
        wheelset.radius_difference(figure.add_subplot(grid[2, 0]), contact)
        axis = figure.add_subplot(grid[2, 1])
        wheelset.over_y(axis, contact, "Contact angles", "contact angle [degrees]")
        wheelset.both_sides(axis, contact, "angle", np.degrees)
        axis = figure.add_subplot(grid[3, 0])
        wheelset.over_y(axis, contact, "Contact positions on the wheels", "to the field side [mm]")
        wheelset.both_sides(axis, contact, "s", lambda s: s * 1e3)
        _conicity(figure.add_subplot(grid[3, 1]), contact, motions, level)

    draw(paint, path, (WIDTH, rest + 2.0 * curves), DPI)


def _rows(patches):
    """Heights of the rows of patches below the top of their axes, and of its bottom [mm]."""
    rows, bottom = [], 0.0
    for one in patches:
        reach = 1e3 * max(patch.half_length for patch in one.patches)
        rows.append(bottom - LABEL_HEIGHT - reach)
        bottom = rows[-1] - reach
    return rows, bottom - NAME_HEIGHT


def _patches(axis, contact, patches, side, rows, bottom):
    """Patches of one wheel, to scale in their contact planes, below their places on the profile; a row for each y."""
    sign, colours = SIGN[side], wheelset.colours_of(contact)
    for row, one in zip(rows, patches, strict=True):
        free = -math.inf
        for patch in sorted(one.of(side), key=lambda patch: sign * patch.on_wheel):
            across = sign * patch.on_wheel * 1e3
            shape = (across, row) + 1e3 * patch.outline[:, ::-1] * (sign, 1.0)
            axis.add_patch(Polygon(shape, facecolor=colours.to_rgba(one.y * 1e3), edgecolor="black", linewidth=0.8))
            free = max(across, free + LABEL_WIDTH)
            text = f"{patch.normal / 1e3:.1f}\n{patch.pressure / 1e6:.0f}"
            axis.text(free, shape[:, 1].max() + 1.0, text, fontsize=8, ha="center", va="bottom", linespacing=1.0)
    axis.set_yticks(rows, [wheelset.signed(one.y * 1e3) for one in patches])
    axis.set_ylim(bottom, 0.0)
    _name_regions(axis, getattr(contact.wheelset, side), sign)
    axis.set_aspect("equal")
    axis.grid(visible=False)
    axis.set_ylabel("patches at y [mm]")


def _name_regions(axis, mounting, sign):
    """Parts of the wheel profile: dotted borders and names; flank and tip together are the flange."""
    tip, root, tread = wheel_regions(mounting) * 1e3
    (low, high), _ = wheelset.frame(mounting)
    for edge in (tip, root, tread):
        axis.axvline(sign * edge, color=GREY, linewidth=0.7, linestyle=":")
    for name, start, end in (("flange", low, root), ("root", root, tread), ("tread", tread, high)):
        place = 0.5 * sign * (start + end)
        axis.text(place, 0.01, name, fontsize=8, ha="center", style="italic", transform=axis.get_xaxis_transform())


def _conicity(axis, contact, motions, level):
    amplitudes = [motion.amplitude for motion in motions]
    at = int(np.argmin(np.abs(np.array(amplitudes) - READ_OFF)))

    def label(name, found):
        return f"{name}: {_number(found[at].conicity)} at {READ_OFF * 1e3:g} mm"

    if motions is level:
        curves = [(level, "conicity", label("level (EN 15302)", level), BLUE, "-")]
    else:
        curves = [
            (motions, "conicity", label("as shown", motions), BLUE, "-"),
            (level, "conicity", label("level (EN 15302)", level), GREEN, "--"),
        ]
    conicity_curves(axis, contact, amplitudes, curves)
