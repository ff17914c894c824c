"""Equivalent conicity for readers: tables, JSON, CSV, pictures, and the comparison with EN 15302."""

import math

import numpy as np

from . import wheelset
from .criteria import criteria_json, verdict
from .figures import BLUE, GREEN, GREY, VERMILION, draw
from .text import columns, facts

SHOWN = 2.0  # conicity beyond this is cut off in the picture [-]
MOST_JUMPS = 8  # printed
TABLE_MM = (2.0, 3.0, 4.0, 5.0, 6.0, 7.0)  # amplitudes of the comparison that are printed


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


def pressed_facts(contact, rigid):
    """What quasi-elastic contact points change of delta-r: largest difference to rigid ones, and their jumps."""
    y = np.unique(np.concatenate([contact.y, rigid.y]))
    change = np.interp(y, contact.y, contact.radius_difference) - np.interp(y, rigid.y, rigid.radius_difference)
    change, y = change[y >= 0.0], y[y >= 0.0]
    worst = int(np.argmax(np.abs(change)))
    hops = {name: np.abs(np.diff(one.radius_difference)[one.jumps]) * 1e3 for name, one in _both(contact, rigid)}
    return {
        "largest_change_mm": float(change[worst] * 1e3),
        "at_y_mm": float(y[worst] * 1e3),
        "share_of_y_changed_by_10_um": float(np.trapezoid(np.abs(change) > 10e-6, y) / (y[-1] - y[0])),
        "jumps": {name: len(found) for name, found in hops.items()},
        "largest_jump_mm": {name: float(found.max(initial=0.0)) for name, found in hops.items()},
    }


def _both(contact, rigid):
    return ("quasi_elastic", contact), ("rigid", rigid)


def pressed_lines(contact, rigid):
    """The same as lines of text."""
    found = pressed_facts(contact, rigid)
    pairs = [
        (
            "delta-r",
            f"differs by up to {found['largest_change_mm']:+.3f} mm, at y = {found['at_y_mm']:.3f} mm; by more than "
            f"0.01 mm over {found['share_of_y_changed_by_10_um']:.0%} of y",
        ),
        *(
            (
                name.replace("_", "-"),
                f"{found['jumps'][name]} jumps of the contact, the largest {found['largest_jump_mm'][name]:.3f} mm",
            )
            for name, _ in _both(contact, rigid)
        ),
    ]
    return ["Quasi-elastic against rigid contact points:", *facts(pairs)]


def plot(title, contact, motions, path, rigid=None):
    """Draw profiles with contact lines, delta-r, conicity, contact angles and their difference.

    Parameters
    ----------
    title : str
    contact : Rolling
    motions : list of Swing
        Drawn over amplitude; many make a smooth curve.
    path : path-like
    rigid : Rolling, optional
        With rigid contact points, whose delta-r is drawn beside.
    """

    def paint(figure):
        figure.suptitle(title, fontsize=11)
        grid = figure.add_gridspec(3, 2, height_ratios=(0.62, 1.0, 1.0))
        sides = [figure.add_subplot(grid[0, k]) for k in (0, 1)]
        for axis, side in zip(sides, ("left", "right"), strict=True):
            wheelset.profiles(axis, contact, side)
            axis.set_title(f"{side.capitalize()} wheel, drawn {wheelset.LIFT:g} mm above its rail")
        figure.colorbar(wheelset.colours_of(contact), ax=sides, aspect=12, label="y of the wheelset [mm]")
        wheelset.radius_difference(figure.add_subplot(grid[1, 0]), contact, rigid)
        curves = (
            (motions, "conicity", "integrated", BLUE, "-"),
            (motions, "linearised", "harmonic linearisation", GREEN, "--"),
        )
        amplitudes = [motion.amplitude for motion in motions]
        conicity_curves(figure.add_subplot(grid[1, 1]), contact, amplitudes, curves)
        axis = figure.add_subplot(grid[2, 0])
        wheelset.over_y(axis, contact, "Contact angles", "contact angle [degrees]")
        wheelset.both_sides(axis, contact, "angle", np.degrees)
        axis = figure.add_subplot(grid[2, 1])
        name = "Slope difference of the contact planes, right less left"
        wheelset.over_y(axis, contact, name, "tan γ right − tan γ left")
        axis.plot(*wheelset.broken(contact, contact.angle_difference), color=BLUE)

    draw(paint, path, (12.0, 11.0))


def conicity_curves(axis, contact, amplitudes, curves):
    """Draw conicity over amplitude; where a swing of the contact reaches a flank is shaded.

    Parameters
    ----------
    axis : Axes
    contact : Rolling
    amplitudes : sequence of float
        [m]
    curves : sequence of (sequence of Swing, str, str, str, str)
        Motions, name of their value, label, colour and line.
    """
    amplitude = np.array(amplitudes) * 1e3
    top = 0.0
    for motions, name, label, colour, line in curves:
        values = np.array([getattr(motion, name) for motion in motions])
        axis.plot(amplitude, values, color=colour, linestyle=line, label=label)
        top = np.nanmax([top, *values])
    beyond = amplitude[[contact.reaches_flank(motion) for motion in curves[0][0]]]
    if beyond.size:
        axis.axvspan(beyond[0], amplitude[-1], color=GREY, alpha=0.15, linewidth=0.0, label="beyond the flange")
    axis.set_title("Equivalent conicity")
    axis.set_xlabel("amplitude [mm]")
    axis.set_ylabel("tan γₑ")
    axis.set_xlim(amplitude[0], amplitude[-1])
    axis.set_ylim(0.0, min(SHOWN, 1.05 * top) if top > 0.0 else 1.0)
    axis.legend(loc="upper left")


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
        "verdict": verdict(result.rows),
        "criteria": criteria_json(result.rows),
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
    upper.set_ylabel("tan γₑ")
    upper.legend(loc="upper left")
    contact, table = result.contact[name], result.tables["2021", name]
    lower.plot(*wheelset.broken(contact, contact.radius_difference * 1e3), color=BLUE, label="railcli")
    lower.plot(table.y * 1e3, table.difference * 1e3, "o", color=VERMILION, markersize=3, label="table, 2021")
    lower.set_xlim(0.0, 7.0)
    lower.set_ylim(-0.3, 12.0)
    lower.set_title(f"{name}: rolling radius difference")
    lower.set_xlabel("lateral position y [mm]")
    lower.set_ylabel("Δr [mm]")
    lower.legend(loc="upper left")
