"""A profile for readers: the account of its import, its dimensions, its picture."""

import numpy as np

from railcli.model.smoothing import WINDOW, mean_curvature

from .figures import BLUE, GREY, VERMILION, draw
from .text import facts

RANGES_SHOWN = 6
SAMPLES = 4000
HEIGHT = {"rail": 2.2, "wheel": 1.4}  # of the profile's axes over the others'
STEEPEST = 85.0  # slopes are shown up to this [degrees]
CURVATURE_SHARE = 0.995  # of the running surface's curvatures lies inside the picture
LABELS = {
    "y_mm": ("y", "{0[0]:.2f} to {0[1]:.2f} mm"),
    "z_mm": ("z", "{0[0]:.2f} to {0[1]:.2f} mm"),
    "width_mm": ("width", "{:.2f} mm"),
    "flange_height_mm": ("flange height", "{:.2f} mm"),
    "flange_thickness_mm": ("flange thickness", "{:.2f} mm, 10 mm below the tape circle"),
    "qr_mm": ("qR", "{:.2f} mm"),
    "head_width_mm": ("head width", "{:.2f} mm"),
    "lean_degrees": ("lean of the head", "{:.2f} degrees, inwards positive"),
    "gauge_point_y_mm": ("gauge point", "y = {:.2f} mm, the innermost to 14 mm below the top"),
}


def summary(account):
    """Lines of the report on one profile.

    Parameters
    ----------
    account : dict
        As `Imported.account`.
    """
    lines = [f"{account['file']}: {account['kind']}, {account['format']}"]
    if "points_read" in account:
        lines.append(f"Points: {account['points_read']} read, {account['points']} now")
        lines += [
            "Decisions:",
            *facts([(d["subject"], f"{d['choice']} ({d['reason']})") for d in account["decisions"]]),
        ]
        lines += _listed("Notes:", account["notes"])
        lines += _listed("Repairs:" if account["faults"] else "Repairs: none", map(_fault, account["faults"]))
        lines += _listed("Corners, kept:", map(_kink, account["kinks"]))
        lines += [_smoothing(account["smoothing"]), *_resampling(account["resampling"])]
    dimensions = [(LABELS[key][0], LABELS[key][1].format(value)) for key, value in account["dimensions"].items()]
    lines += ["Dimensions:", *facts(dimensions)]
    lines += _listed("Advice:", account["advice"])
    return lines


def verdict(account, as_it_is):
    """One line: can a contact table be built?"""
    if account["unfit"]:
        return f"Not fit for a contact table: {account['unfit'][0]}"
    if as_it_is:
        return "Fit for a contact table."
    return "Fit for a contact table once imported (railcli profile import)."


def plot(profile, path, raw=None):
    """Draw a profile, its slope and its curvature over y; with `raw`, also as it was before smoothing.

    Parameters
    ----------
    profile : Profile
    path : path-like
    raw : Profile, optional
    """
    shown = [(profile, BLUE, "smoothed" if raw else None)]
    if raw:
        shown.insert(0, (raw, GREY, "as measured"))

    def paint(figure):
        ratios = [HEIGHT[profile.kind], 1, 1]
        top, middle, bottom = figure.subplots(3, 1, sharex=True, gridspec_kw={"height_ratios": ratios})
        limits = []
        for curve, colour, label in shown:
            sigma = np.linspace(0.0, curve.arc[-1], SAMPLES)
            y, z, angle, _ = curve.at(sigma)
            curvature = mean_curvature(curve, sigma)
            running = np.abs(np.degrees(angle)) < STEEPEST
            top.plot(y * 1e3, z * 1e3, color=colour, label=label)
            middle.plot(y * 1e3, np.where(running, np.degrees(angle), np.nan), color=colour)
            bottom.plot(y * 1e3, np.where(running, curvature, np.nan), color=colour)
            limits = np.quantile(curvature[running], [1.0 - CURVATURE_SHARE, CURVATURE_SHARE])
        top.plot(0.0, 0.0, "+", color=VERMILION, markersize=10)
        top.annotate(
            "highest point" if profile.kind == "rail" else "tape circle",
            (0.0, 0.0),
            xytext=(0, 10),
            textcoords="offset points",
            ha="center",
            color=VERMILION,
            fontsize=8,
        )
        top.set_aspect("equal", adjustable="datalim")
        top.invert_yaxis()
        top.set(title=f"{profile.name}: {profile.kind}", ylabel="z [mm], down")
        if raw:
            top.legend()
        middle.set(ylabel="slope [degrees]")
        margin = 0.1 * (limits[1] - limits[0]) + 1.0
        bottom.set(
            ylabel=f"curvature [1/m]\nmean over {WINDOW * 1e3:g} mm",
            xlabel="y [mm], to the field side",
            ylim=(limits[0] - margin, limits[1] + margin),
        )

    draw(paint, path, (8.0, 8.5))


def _listed(title, items):
    items = [f"  {item}" for item in items]
    return [title, *items] if items or title.endswith("none") else []


def _fault(fault):
    ranges = [f"{first}" if first == last else f"{first}-{last}" for first, last in fault["lines"]]
    where = ", ".join(ranges[:RANGES_SHOWN]) + (", ..." if len(ranges) > RANGES_SHOWN else "")
    text = f"{fault['points']} point{'s' if fault['points'] != 1 else ''} {fault['treatment']}: {fault['reason']}"
    text += f"; lines {where}" if where else ""
    return text + (f"; at most {fault['largest_mm']:.3g} mm" if fault["largest_mm"] else "")


def _kink(kink):
    return f"y = {kink['y_mm']:.2f}, z = {kink['z_mm']:.2f} mm: {kink['turn_degrees']:.0f} degrees"


def _smoothing(smoothing):
    if smoothing is None:
        return "Smoothing: none"
    change, running = smoothing["largest_change"], smoothing["largest_change_on_running_surface"]
    (y, z), (y_bent, z_bent) = change["position_at_mm"], change["curvature_at_mm"]
    return (
        f"Smoothing: cut-off wavelength {smoothing['cutoff_mm']:g} mm; largest change of position "
        f"{change['position_mm'] * 1e3:.3g} micrometres at y = {y:.2f}, z = {z:.2f} mm; of curvature (mean over "
        f"{WINDOW * 1e3:g} mm) {change['curvature_per_m']:.3g} 1/m at y = {y_bent:.2f}, z = {z_bent:.2f} mm; on the "
        f"running surface {running['position_mm'] * 1e3:.3g} micrometres and {running['curvature_per_m']:.3g} 1/m"
    )


def _resampling(resampling):
    if resampling is None:
        return []
    return [
        f"Resampling: {resampling['points']} points every {resampling['distance_mm']:.4g} mm of arc; the points before "
        f"lie at most {resampling['position_mm'] * 1e3:.3g} micrometres off"
    ]
