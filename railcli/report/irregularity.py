"""An irregularity as text, JSON and figures."""

import numpy as np

from railcli.model.spectra import BANDS, CHANNELS

from .figures import BLUE, GREY, VERMILION, draw
from .text import columns

TITLES = {
    "vertical": "vertical, up",
    "alignment": "alignment, to the right",
    "cross_level": "cross-level, left over right rail",
    "gauge": "gauge, wider",
}
LEAST = 1e-3  # of the largest density: what a figure of spectra shows below it is noise of the estimate


def in_a_run(record, rows):
    """The same for the report of a run: RMS of each channel."""
    text = [f"Irregularity, target {one.name}, {one.shortest:g} to {one.longest:g} m" for one in record.targets]
    return [*(text or ["Irregularity"]), *_table(rows)]


def lines(record, rows, read_back=None):
    """The report for a terminal."""
    length = record.position[-1] - record.position[0]
    text = [record.title, f"  {length:g} m, a value every {record.spacing:.4g} m"]
    if record.settled > record.position[0]:
        text.append(f"  full size from {record.settled:g} m on; RMS and spectra are taken there")
    for target in record.targets:
        text.append(f"  target {target.name}, wavelengths {target.shortest:g} to {target.longest:g} m")
    if read_back is not None:
        text.append(f"  read back from its file: largest difference {1e9 * read_back:.2g} nm")
    if not rows:
        return [*text, "  no channel has a band to show: the track is perfect, too short or too coarse"]
    return [*text, "RMS per channel and band of wavelengths:", *_table(rows)]


def _table(rows):
    table, last = [], None
    for row in rows:
        target, ratio, scatter = "-", "", ""
        if row.target is not None:
            target = f"{1e3 * row.target:.3f}"
            ratio, scatter = f"{row.rms / row.target:.3f}", f"{100 * row.scatter:.0f}%"
        table.append(
            (
                TITLES[row.channel] if row.channel != last else "", row.name, f"{row.shortest:g} to {row.longest:g} m",
                f"{1e3 * row.rms:.3f}", target, ratio, scatter,
            )
        )  # fmt: skip
        last = row.channel
    return columns(table, ("", "band", "", "RMS [mm]", "target", "ratio", "by chance"))


def as_json(record, rows, read_back=None):
    """The same as one object."""
    return {
        "title": record.title,
        "length_m": float(record.position[-1] - record.position[0]),
        "spacing_m": record.spacing,
        "settled_from_m": record.settled,
        "targets": [
            {"name": one.name, "channels": list(one.channels), "shortest_m": one.shortest, "longest_m": one.longest}
            for one in record.targets
        ],
        "bands": [
            {
                "channel": row.channel,
                "band": row.name,
                "shortest_m": row.shortest,
                "longest_m": row.longest,
                "rms_mm": 1e3 * row.rms,
                "target_mm": None if row.target is None else 1e3 * row.target,
                "standard_error": row.scatter,
            }
            for row in rows
        ],
        "read_back_difference_m": read_back,
    }


def figures(record, found, folder):
    """Draw channels.png and spectra.png."""
    draw(lambda figure: _channels(figure, record), folder / "channels.png", (9.0, 7.5))
    draw(lambda figure: _spectra(figure, record, found), folder / "spectra.png", (9.0, 7.0))


def _channels(figure, record):
    figure.suptitle(record.title)
    for axis, name in zip(figure.subplots(4, 1, sharex=True), CHANNELS, strict=True):
        axis.plot(record.position, 1e3 * record.channels[name], color=BLUE, linewidth=0.8)
        axis.set(title=TITLES[name], ylabel="[mm]")
    axis.set_xlabel("s [m]")


def _spectra(figure, record, found):
    figure.suptitle(f"{record.title}: spectra, one-sided")
    for axis, name in zip(figure.subplots(2, 2, sharex=True).flat, CHANNELS, strict=True):
        axis.set(title=TITLES[name], xscale="log", yscale="log")
        axis.set(xlabel="1 / wavelength [1/m]", ylabel="[mm² m]")
        if name not in found:
            axis.text(0.5, 0.5, "zero", transform=axis.transAxes, ha="center", color=GREY)
            axis.set_axis_off()
            continue
        f, density = found[name]
        axis.plot(f, 1e6 * density, color=BLUE, linewidth=0.9, label="Welch")
        fine = np.geomspace(f[0], f[-1], 2000)
        target = 2e6 * np.pi * record.target(name, 2 * np.pi * fine)
        if target.any():
            axis.plot(fine, np.where(target > 0.0, target, np.nan), color=VERMILION, label="target")
        top = max(1e6 * density.max(), target.max())
        least = target[target > 0.0].min(initial=top) if target.any() else LEAST * top
        axis.set_ylim(min(0.1 * least, LEAST * top), 5.0 * top)
        for band, (shortest, longest) in BANDS.items():
            if 1.0 / shortest > f[0] and 1.0 / longest < f[-1]:
                axis.axvline(1.0 / shortest, color=GREY, linewidth=0.5, linestyle=":")
                axis.text(1.0 / np.sqrt(shortest * longest), 0.97, band, transform=axis.get_xaxis_transform(),
                          ha="center", va="top", color=GREY)  # fmt: skip
        axis.legend(loc="lower center")
