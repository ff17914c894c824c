"""Equivalent conicity for readers: tables, JSON, CSV, pictures, and the comparison with EN 15302."""

import math

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from .figures import BLUE, GREEN, GREY, ORANGE, VERMILION, draw
from .text import columns, facts

SIDES = (("right", BLUE, "-"), ("left", VERMILION, "--"))
LIFT = 20.0  # the wheel is drawn this far above its rail [mm]
SHOWN = 2.0  # conicity beyond this is cut off in the picture [-]
MOST_JUMPS = 8  # printed
TABLE_MM = (2.0, 3.0, 4.0, 5.0, 6.0, 7.0)  # amplitudes of the comparison that are printed


def title(names, inclination, settings, left_radius, with_roll):
    """`ORES1002 on UIC60, inclination 1:40, ...`"""
    radius = f"{settings.radius * 1e3:g}"
    if left_radius is not None:
        radius += f" (left {left_radius * 1e3:g})"
    left = [names[key] for key in ("left_wheel", "left_rail") if key in names]
    return (
        f"{names['wheel']} on {names['rail']}{', left ' + ' on '.join(left) if left else ''}, "
        f"inclination {inclination}, gauge {settings.gauge * 1e3:g} mm, flange-back {settings.flange_back * 1e3:g} mm, "
        f"radius {radius} mm, {'with' if with_roll else 'without'} roll"
    )


def summary(title, contact, motions, curves):
    """Lines of the conicity over amplitude, the jumps of delta-r and the steering.

    Parameters
    ----------
    title : str
    contact : Rolling
    motions : list of Swing
    curves : list of Steering
    """
    rows = [
        (
            f"{motion.amplitude * 1e3:g}", _number(motion.conicity, 4), _number(motion.linearised, 4),
            _number(motion.wavelength, 2), f"{motion.centre * 1e3:.2f}" if math.isfinite(motion.centre) else "-",
            remark(contact, motion),
        )
        for motion in motions
    ]  # fmt: skip
    lines = [title, "Equivalent conicity over amplitude:"]
    header = ("amplitude [mm]", "tan gamma_e", "linearised", "wavelength [m]", "centre y [mm]", "")
    lines += columns(rows, header)
    flanks = [place for place in contact.clearance if math.isfinite(place)]
    places = " and ".join(f"{place * 1e3:.2f}" for place in flanks)
    pairs = [("flange", f"the flank touches from y = {places} mm" if flanks else "not reached")]
    jumps = [_jump(contact, i) for i in contact.jumps if contact.y[i] >= 0.0 or not contact.wheelset.alike]
    pairs += [("jumps" if k == 0 else "", text) for k, text in enumerate(jumps[:MOST_JUMPS] or ["none"])]
    if len(jumps) > MOST_JUMPS:
        pairs.append(("", f"and {len(jumps) - MOST_JUMPS} more: functions.csv"))
    lines += facts(pairs)
    if curves:
        lines.append("Radial steering of a free wheelset, outwards to the right, until the flank touches:")
        rows = [
            (
                f"{row.curve:g}", f"{row.needed * 1e3:.2f}", _number(row.outwards * 1e3, 2),
                _number(row.index, 2), "steers" if row.outwards >= 0.0 else "slips",
            )
            for row in curves
        ]  # fmt: skip
        lines += columns(rows, ("R [m]", "delta-r needed [mm]", "at y [mm]", "index", ""))
    return lines


def remark(contact, motion):
    """What a reader must know about one amplitude; empty when nothing."""
    if math.isnan(motion.conicity):
        return "no such motion: something inside turns the wheelset back or drives it out"
    if contact.reaches_flank(motion):
        return "beyond the flange"
    return "nothing drives it back" if math.isinf(motion.wavelength) else ""


def _number(value, digits):
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def _jump(contact, i):
    before, after = contact.radius_difference[[i, i + 1]] * 1e3
    return f"y = {contact.y[i] * 1e3:.3f} mm, delta-r {before:.3f} -> {after:.3f} mm"


def as_json(settings, names, with_roll, contact, motions, curves):
    """Everything `railcli conicity` prints, for a machine; units in the names."""
    return {
        "profiles": names,
        "settings": settings,
        "roll": with_roll,
        "base_m": contact.wheelset.base,
        "radius_m": contact.wheelset.radius,
        "flank_from_mm": [place * 1e3 for place in contact.clearance],
        "amplitudes": [
            {
                "amplitude_mm": motion.amplitude * 1e3,
                "conicity": motion.conicity,
                "linearised": motion.linearised,
                "wavelength_m": motion.wavelength,
                "centre_mm": motion.centre * 1e3,
                "remark": remark(contact, motion),
            }
            for motion in motions
        ],
        "jumps": [
            {"y_mm": contact.y[i] * 1e3, "delta_r_mm": (contact.radius_difference[[i, i + 1]] * 1e3).tolist()}
            for i in contact.jumps
        ],
        "steering": [
            {
                "curve_m": row.curve,
                "needed_mm": row.needed * 1e3,
                "outwards_mm": row.outwards * 1e3,
                "index": row.index,
            }
            for row in curves
        ],
    }


def conicity_csv(contact, motions):
    """Conicity over amplitude as CSV."""
    rows = [
        f"{m.amplitude * 1e3:g},{m.conicity:.6f},{m.linearised:.6f},{m.wavelength:.4f},{m.centre * 1e3:.4f},"
        f"{remark(contact, m)}"
        for m in motions
    ]
    header = "amplitude_mm,conicity,linearised,wavelength_m,centre_mm,remark"
    return "\n".join([header, *rows]) + "\n"


def functions_csv(contact):
    """The contact functions over y as CSV; both sides of each jump have a row."""
    v = contact.values
    table = np.column_stack(
        [
            contact.y * 1e3, contact.radius_difference * 1e3, contact.angle_difference,
            np.degrees(v["angle_right"]), np.degrees(v["angle_left"]), v["s_right"] * 1e3, v["s_left"] * 1e3,
            v["rail_right"] * 1e3, v["rail_left"] * 1e3, v["roll"] * 1e3,
        ]
    )  # fmt: skip
    header = (
        "y_mm,delta_r_mm,delta_tan_gamma,angle_right_deg,angle_left_deg,on_wheel_right_mm,on_wheel_left_mm,"
        "on_rail_right_mm,on_rail_left_mm,roll_mrad"
    )
    rows = [",".join([f"{row[0]:.7f}", *(f"{cell + 0.0:.6f}" for cell in row[1:])]) for row in table]
    return "\n".join([header, *rows]) + "\n"


def plot(title, contact, motions, path):
    """Draw profiles with contact lines, delta-r, conicity, contact angles and their difference.

    Parameters
    ----------
    title : str
    contact : Rolling
    motions : list of Swing
        Drawn over amplitude; many make a smooth curve.
    path : path-like
    """

    def paint(figure):
        figure.suptitle(title, fontsize=11)
        grid = figure.add_gridspec(3, 2, height_ratios=(0.62, 1.0, 1.0))
        sides = [figure.add_subplot(grid[0, k]) for k in (0, 1)]
        for axis, side in zip(sides, ("left", "right"), strict=True):
            colours = _profiles(axis, contact, side)
        figure.colorbar(colours, ax=sides, aspect=12, label="y of the wheelset [mm]")
        y = contact.y * 1e3
        axis = figure.add_subplot(grid[1, 0])
        _function(axis, contact, contact.radius_difference * 1e3, "Rolling radius difference, right less left")
        axis.set_ylabel("$\\Delta r$ [mm]")
        _conicity(figure.add_subplot(grid[1, 1]), contact, motions)
        axis = figure.add_subplot(grid[2, 0])
        for side, colour, line in SIDES:
            values = np.degrees(contact.values[f"angle_{side}"])
            axis.plot(*_broken(contact, values), color=colour, linestyle=line, label=f"{side} wheel")
        axis.set_title("Contact angles")
        axis.set_ylabel("contact angle [degrees]")
        axis.set_xlabel("lateral position y of the wheelset, to the right [mm]")
        axis.set_xlim(y[0], y[-1])
        axis.legend(loc="upper center")
        axis = figure.add_subplot(grid[2, 1])
        _function(axis, contact, contact.angle_difference, "Slope difference of the contact planes, right less left")
        axis.set_ylabel("$\\tan\\gamma_R - \\tan\\gamma_L$")

    draw(paint, path, (12.0, 11.0))


def _broken(contact, values):
    """y [mm] and values with a gap at each jump."""
    after = contact.jumps + 1
    return np.insert(contact.y * 1e3, after, np.nan), np.insert(values, after, np.nan)


def _function(axis, contact, values, title):
    y = contact.y * 1e3
    axis.plot(*_broken(contact, values), color=BLUE)
    for i in contact.jumps:
        axis.plot(y[[i, i + 1]], values[[i, i + 1]], color=BLUE, linewidth=0.8, linestyle=":")
    for place in contact.clearance:
        if math.isfinite(place):
            axis.axvline(place * 1e3, color=ORANGE, linewidth=0.9, linestyle="--")
            axis.text(place * 1e3, 0.02, " flange", color=ORANGE, fontsize=8, transform=axis.get_xaxis_transform())
    axis.set_title(title)
    axis.set_xlabel("lateral position y of the wheelset, to the right [mm]")
    axis.set_xlim(y[0], y[-1])


def _conicity(axis, contact, motions):
    amplitude = np.array([motion.amplitude for motion in motions]) * 1e3
    exact = np.array([motion.conicity for motion in motions])
    linear = np.array([motion.linearised for motion in motions])
    axis.plot(amplitude, exact, color=BLUE, label="integrated")
    axis.plot(amplitude, linear, color=GREEN, linestyle="--", label="harmonic linearisation")
    beyond = amplitude[[contact.reaches_flank(motion) for motion in motions]]
    if beyond.size:
        axis.axvspan(beyond[0], amplitude[-1], color=ORANGE, alpha=0.12, label="beyond the flange")
    axis.set_title("Equivalent conicity")
    axis.set_xlabel("amplitude [mm]")
    axis.set_ylabel("$\\tan\\gamma_e$")
    axis.set_xlim(amplitude[0], amplitude[-1])
    top = np.nanmax(np.concatenate([exact, linear, [0.0]]))
    axis.set_ylim(0.0, min(SHOWN, 1.05 * top) if top > 0.0 else 1.0)
    axis.legend(loc="upper left")


def _profiles(axis, contact, side):
    """One wheel lifted off its rail, and lines between the points that touch at each mm of y; returns the colours."""
    mounting = getattr(contact.wheelset, side)
    sign = 1.0 if side == "right" else -1.0
    s = 1e3 * (mounting.wheel_start + mounting.wheel_step * np.arange(mounting.wheel.shape[0]))
    across = 1e3 * (mounting.rail_start - mounting.seat + mounting.rail_step * np.arange(mounting.rail.shape[0]))
    wheel, rail = 1e3 * mounting.wheel[:, 0] - LIFT, 1e3 * mounting.rail[:, 0]
    reach = math.floor(contact.y[-1] * 1e3 + 1e-6)
    colours = ScalarMappable(Normalize(-reach, reach), "turbo")
    for whole in range(-reach, reach + 1):
        i = int(np.argmin(np.abs(contact.y - whole * 1e-3)))
        on_wheel = 1e3 * contact.values[f"s_{side}"][i]
        on_rail = 1e3 * (contact.values[f"rail_{side}"][i] - mounting.seat)
        axis.plot(
            [sign * on_wheel, sign * on_rail],
            [np.interp(on_wheel, s, wheel), np.interp(on_rail, across, rail)],
            color=colours.to_rgba(whole), linewidth=1.0, marker="o", markersize=3,
        )  # fmt: skip
    axis.plot(sign * s, wheel, color="black", linewidth=1.4, zorder=1)
    axis.plot(sign * across, rail, color="black", linewidth=1.4, zorder=1)
    axis.set_aspect("equal")
    axis.set_ylim(max(wheel.max(), rail.max()) + 3.0, wheel.min() - 3.0)
    axis.set_title(f"{side.capitalize()} wheel, drawn {LIFT:g} mm above its rail")
    axis.set_xlabel("from the tape circle, to the right [mm]")
    axis.set_ylabel("down [mm]")
    return colours


def validation_lines(result):
    """The comparison with EN 15302 as lines of text."""
    lines = ["Equivalent conicity against the reference tables of EN 15302", ""]
    rows = []
    for found in result.comparisons:
        shown = [int(np.argmin(np.abs(found.amplitude - place * 1e-3))) for place in TABLE_MM]
        name = f"{found.combination}, {found.edition} edition"
        if found.profiles == "sections":
            rows.append((name, "table", *(f"{found.table[i]:.3f}" for i in shown), "", ""))
            name = ""
        errors = f"{found.away:.4f}", f"{found.largest:.4f} ({found.share:.0%})"
        rows.append((name, f"from {found.profiles}", *(f"{found.ours[i]:.3f}" for i in shown), *errors))
    header = ("tan gamma_e at amplitude [mm]", "", *(f"{place:g}" for place in TABLE_MM), "away", "largest (tolerance)")
    lines += columns(rows, header)
    lines += ["  deviations from the table: away from jumps, and anywhere with the share of the tolerance", ""]
    rows = []
    for row in result.rows:
        verdict = ("kept" if row.kept else "MISSED") if row.counts else "shown only"
        rows.append((row.name, f"{row.found:.2g}", f"{row.limit:g}", verdict))
    lines += columns(rows, ("criterion", "found", "limit", ""))
    return [*lines, f"Verdict: {'accepted' if result.accepted else 'rejected'}"]


def validation_json(result):
    """The comparison with EN 15302 for a machine."""
    return {
        "verdict": "accepted" if result.accepted else "rejected",
        "criteria": [
            {"name": row.name, "found": row.found, "limit": row.limit, "kept": row.kept, "counts": row.counts}
            for row in result.rows
        ],
        "comparisons": [
            {
                "edition": found.edition,
                "combination": found.combination,
                "profiles": found.profiles,
                "amplitude_mm": found.amplitude * 1e3,
                "conicity": found.ours,
                "table": found.table,
                "tolerance": found.tolerance,
                "near_jump": found.near_jump,
            }
            for found in result.comparisons
        ],
    }


def validation_csv(result):
    """Every compared value as CSV."""
    rows = ["edition,combination,profiles,amplitude_mm,conicity,table,tolerance,near_jump"]
    for found in result.comparisons:
        for cells in zip(found.amplitude * 1e3, found.ours, found.table, found.tolerance, found.near_jump, strict=True):
            amplitude, ours, table, tolerance, near = cells
            rows.append(
                f"{found.edition},{found.combination},{found.profiles},{amplitude:.1f},{ours:.5f},{table:.3f},"
                f"{tolerance:.4f},{int(near)}"
            )
    return "\n".join(rows) + "\n"


def validation_plot(result, path):
    """Draw conicity and delta-r of every combination beside the published tables."""
    names = list(result.contact)

    def panels(figure):
        axes = figure.subplots(2, len(names), squeeze=False)
        for k, name in enumerate(names):
            _against_tables(axes[0, k], axes[1, k], result, name)

    draw(panels, path, (12.0, 8.5))


def _against_tables(upper, lower, result, name):
    found = {(item.edition, item.profiles): item for item in result.comparisons if item.combination == name}
    new, old = found["2021", "sections"], found["2008", "sections"]
    upper.fill_between(
        new.amplitude * 1e3, new.table - new.tolerance, new.table + new.tolerance, color=GREY, alpha=0.2,
        label="tolerance, 2021", linewidth=0.0,
    )  # fmt: skip
    upper.plot(old.amplitude * 1e3, old.ours, color=BLUE, label="railcli")
    upper.plot(new.amplitude * 1e3, new.table, "o", color=VERMILION, markersize=4, label="table, 2021")
    upper.plot(old.amplitude * 1e3, old.table, "x", color=GREEN, markersize=3, label="table, 2008")
    upper.set_title(f"{name}: equivalent conicity")
    upper.set_xlabel("amplitude [mm]")
    upper.set_ylabel("$\\tan\\gamma_e$")
    upper.legend(loc="upper left")
    contact, table = result.contact[name], result.tables["2021", name]
    lower.plot(*_broken(contact, contact.radius_difference * 1e3), color=BLUE, label="railcli")
    lower.plot(table.y * 1e3, table.difference * 1e3, "o", color=VERMILION, markersize=3, label="table, 2021")
    lower.set_xlim(0.0, 7.0)
    lower.set_ylim(-0.3, 12.0)
    lower.set_title(f"{name}: rolling radius difference")
    lower.set_xlabel("lateral position y [mm]")
    lower.set_ylabel("$\\Delta r$ [mm]")
    lower.legend(loc="upper left")
