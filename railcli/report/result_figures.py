"""Figures of one result, or of several overlaid: a panel for each wheelset or body, a colour for each result."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from . import assess
from .curves import SIDES
from .figures import BLUE, GREY, SERIES, VERMILION, draw, plain

COLUMNS = 4  # wheelsets side by side
PANEL = (2.9, 1.75)  # size of a panel [inch]
HEAD = 0.75  # title, labels and legend of a figure [inch]
MOST_BODIES = 6
LINES = {"right": "-", "left": "--"}
WHEEL_COLOURS = {"right": BLUE, "left": VERMILION}
BENT = 1e-7  # curvature that is shaded [1/m]


class Figure(NamedTuple):
    """One figure of a report.

    Attributes
    ----------
    name, title, caption : str
        The name is that of its file, without ending.
    write : callable
        Draws it into the file of a path.
    """

    name: str
    title: str
    caption: str
    write: Callable


def _painted(name, title, caption, paint, size, several):
    """A Figure that `paint(figure, several)` fills, with one legend; size in inch."""

    def both(figure):
        paint(figure, several)
        _legend(figure)

    return Figure(name, title, caption, lambda path: draw(both, path, size))


def figures(several):
    """The figures of a report.

    Parameters
    ----------
    several : list of Curves

    Returns
    -------
    list of Figure
    """
    wide = PANEL[0] * COLUMNS
    found = []
    if any(one.track is not None for one in several):
        caption = (
            "Curvature, positive to the right; cant, positive when the left rail is higher; where they are not zero, "
            "the gradient, positive where the track rises, and the displacement of both rails from their ideal places."
        )
        size = (wide, _track_rows(several) * PANEL[1] + HEAD)
        found.append(_painted("track", "Track", caption, _track, size, several))
    left_out = () if any([one.has_contact for one in several]) else OF_CONTACT
    found += [_of_wheelsets(several, *entry) for entry in WHEELSET_FIGURES if entry[0] not in left_out]
    if bodies := _bodies(several):
        size = (wide, len(bodies) * PANEL[1] + HEAD)
        caption = (
            "At the centre of mass, in track axes, as an accelerometer shows it; y to the right, z down and without "
            f"gravity. {OVER_S}"
        )
        found.append(_painted("accelerations", "Accelerations of the bodies", caption, _accelerations, size, several))
        caption = (
            "One-sided power spectral density of the same accelerations as recorded (Welch: Hann window, segments of "
            "5 s that overlap by half, mean removed). What is faster than half the recording rate folds back."
        )
        found.append(_painted("spectra", "Spectra of the accelerations", caption, _spectra, size, several))
    return found


def figure_of_braking(one, several):
    """Speeds, slide, pressures, valves and adhesion of a result with subsystems, as a list of one Figure."""
    from . import braking

    if "axles/W1/slide" not in one.results.channels or one.scenario is None:
        return []
    number = several.index(one) + 1
    caption = (
        "Speed of the vehicle and of the treads, slide, cylinder pressures, dump valves, and longitudinal over "
        "vertical force of each axle beside the friction offered at its slip velocity."
    )
    title = f"Brakes and drives of {one.label}" if len(several) > 1 else "Brakes and drives"
    return [Figure(f"braking-{number}", title, caption, partial(braking.over_time, one.scenario, one.results.read))]


def figure_of_assessment(one, outcome, several):
    """The signals of an assessment with their limits, as a list of one Figure; empty when there are none.

    Parameters
    ----------
    one : Curves
    outcome : Assessment or None
    several : list of Curves
        All results of the report.
    """
    if outcome is None or not outcome.traces:
        return []
    number, of = (f"-{several.index(one) + 1}", f": {one.label}") if len(several) > 1 else ("", "")
    caption = "As the assessment filters them, over arc length; dashed: limits, thin: sections."
    return [
        Figure(
            f"assessment{number}", f"Signals and limits{of}", caption,
            lambda path: assess.figure(plain(one.label), one.scenario, outcome, path),
        )
    ]  # fmt: skip


def _displacement(axis, one, style, k, _):
    name = one.results.wheelsets[k]
    axis.plot(one.s, 1e3 * one.component(f"bodies/{name}/position", 1), **style(one, None))


def _yaw(axis, one, style, k, _):
    name = one.results.wheelsets[k]
    axis.plot(one.s, 1e3 * one.component(f"bodies/{name}/rotation", 2), **style(one, None))


def _force(channel):
    def paint(axis, one, style, k, side):
        values = one.single(f"wheels/{one.wheelsets[k][SIDES.index(side)]}/{channel}")
        axis.plot(one.s, 1e-3 * values, **style(one, side))

    return paint


def _quotient(axis, one, style, k, side):
    axis.plot(one.s, one.quotient(one.wheelsets[k][SIDES.index(side)]), **style(one, side))


def _creepage(place, factor):
    def paint(axis, one, style, k, side):
        if one.has_contact:
            values = one.creepages(one.wheelsets[k][SIDES.index(side)])[place]
            axis.plot(one.s, factor * values, **style(one, side))

    return paint


OF_CONTACT = ("creepages", "contact")  # figures of channels that a run may leave out
OVER_S = "Over arc length of the first body; curves of the track are shaded."
WHEELSET_FIGURES = (  # name, title, caption, quantities: label, painter, painted for each side
    (
        "wheelsets", "Motions of the wheelsets", f"Against the track, y to the right, yaw to the right. {OVER_S}",
        (("y [mm]", _displacement, False), ("yaw [mrad]", _yaw, False)),
    ),
    (
        "forces", "Forces of the wheels on the rails", f"Q down, Y to the right. {OVER_S}",
        (("Q [kN]", _force("Q"), True), ("Y [kN]", _force("Y"), True)),
    ),
    (
        "quotients", "Y over Q", f"Positive towards the flange; as recorded, not filtered. {OVER_S}",
        (("Y/Q [-]", _quotient, True),),
    ),
    (
        "creepages", "Creepages", "Slip of wheel over rail, of the patch of each wheel that bears most: longitudinal, "
        f"lateral, spin. {OVER_S}",
        (("xi [1/1000]", _creepage(0, 1e3), True), ("eta [1/1000]", _creepage(1, 1e3), True),
         ("phi [1/m]", _creepage(2, 1.0), True)),
    ),
    (
        "contact", "Contact on the wheels", "Place of the patch that bears most, from the tape circle to the field "
        f"side: negative towards the flange. {OVER_S}",
        (("on wheel [mm]", _creepage(3, 1e3), True),),
    ),
)  # fmt: skip


def _of_wheelsets(several, name, title, caption, quantities):
    count = max(len(one.wheelsets) for one in several)
    width, blocks = min(count, COLUMNS), -(-count // COLUMNS)
    rows = blocks * len(quantities)

    def paint(figure, several):
        panels = figure.subplots(rows, width, sharex=True, squeeze=False)
        style = _styles(several)
        for row, (label, painter, sided) in enumerate(quantities * blocks):
            first = width * (row // len(quantities))
            for column, axis in enumerate(panels[row]):
                k = first + column
                if k >= count:
                    axis.set_axis_off()
                    continue
                for one in several:
                    if k < len(one.wheelsets):
                        for side in SIDES if sided else (None,):
                            painter(axis, one, style, k, side)
                _shade(axis, several)
                if row % len(quantities) == 0:
                    axis.set_title(f"W{k + 1}")
                if column:
                    axis.sharey(panels[row][0])
                    axis.tick_params(labelleft=False)
            panels[row][0].set_ylabel(label)
        for axis in panels[-1]:
            axis.set_xlabel("s [m]")

    return _painted(name, title, caption, paint, (PANEL[0] * COLUMNS, rows * PANEL[1] + HEAD), several)


def _rises(several):
    return any(one.track is not None and one.track.gradient.any() for one in several)


def _track_rows(several):
    return 2 + _rises(several) + 2 * any(one.rails is not None for one in several)


def _track(figure, several):
    panels = list(figure.subplots(_track_rows(several), 1, sharex=True))
    curves = {"curvature [1/km]": lambda found: 1e3 * found.curvature, "cant [mm]": lambda found: 1e3 * found.cant}
    if _rises(several):
        curves["gradient [per mille]"] = lambda found: 1e3 * np.tan(found.gradient)
    for axis, (label, values) in zip(panels, curves.items(), strict=False):
        axis.set_ylabel(label)
        for k, one in enumerate(several):
            if one.track is not None:
                style = _styles(several)(one, None)
                style["linewidth"] += 1.5 * (len(several) - 1 - k)  # like tracks stay visible under one another
                axis.plot(one.track.s, values(one.track), **style)
    places = (("rails up [mm]", 1, -1e3), ("rails to the right [mm]", 0, 1e3))
    for axis, (label, direction, factor) in zip(panels[len(curves) :], places, strict=False):
        axis.set_ylabel(label)
        for one in several:
            if one.rails is not None:
                s, moved = one.rails
                for side, values in zip(("right", "left"), moved[:, direction], strict=True):
                    style = _styles(several)(one, side)
                    style["label"] = style["label"].replace(" wheel", " rail")
                    axis.plot(s, factor * values, **style)
    panels[-1].set_xlabel("s [m]")


def _bodies(several):
    """Names of the bodies without the wheelsets, those of the first result first."""
    return list(dict.fromkeys(name for one in several for name in one.sprung))[:MOST_BODIES]


def _body_panels(figure, several, painter):
    bodies = _bodies(several)
    panels = figure.subplots(len(bodies), 2, sharex=True, squeeze=False)
    style = _styles(several)
    for row, body in zip(panels, bodies, strict=True):
        for axis, (direction, k) in zip(row, (("lateral", 1), ("vertical", 2)), strict=True):
            for one in several:
                if body in one.sprung:
                    painter(axis, one, f"bodies/{body}/acceleration", k, style(one, None))
            axis.set_title(plain(f"{body}, {direction}"))
    return panels


def _accelerations(figure, several):
    def paint(axis, one, channel, k, style):
        axis.plot(one.s, one.component(channel, k), **style)

    panels = _body_panels(figure, several, paint)
    for axis in panels.ravel():
        _shade(axis, several)
    for row in panels:
        row[0].set_ylabel("[m/s²]")
    for axis in panels[-1]:
        axis.set_xlabel("s [m]")


def _spectra(figure, several):
    def paint(axis, one, channel, k, style):
        found = one.spectrum(channel, k)
        if found is not None:
            axis.loglog(*found, **style)

    panels = _body_panels(figure, several, paint)
    for row in panels:
        row[0].set_ylabel("[(m/s²)²/Hz]")
    for axis in panels[-1]:
        axis.set_xlabel("frequency [Hz]")


def _styles(several):
    """Function that gives colour, line and label of a result's wheel: colours tell results apart, or else sides."""

    def style(one, side):
        if len(several) == 1:
            return {"color": WHEEL_COLOURS.get(side, BLUE), "linestyle": LINES.get(side, "-"),
                    "label": f"{side} wheel" if side else plain(one.label), "linewidth": 1.0}  # fmt: skip
        label = plain(f"{one.label}, {side} wheel" if side else one.label)
        colour = SERIES[several.index(one) % len(SERIES)]
        return {"color": colour, "linestyle": LINES.get(side, "-"), "label": label, "linewidth": 1.0}

    return style


def _shade(axis, several):
    """Shade where the track is curved, if all results have the same track."""
    scenarios = [one.scenario for one in several]
    if None in scenarios or any(scenario.track != scenarios[0].track for scenario in scenarios[1:]):
        return
    track = max((one.track for one in several), key=lambda track: track.s.size)
    axis.fill_between(track.s, 0.0, 1.0, where=np.abs(track.curvature) > BENT, transform=axis.get_xaxis_transform(),
                      color=GREY, alpha=0.12, linewidth=0.0, zorder=0)  # fmt: skip


def _legend(figure):
    """One legend below the panels, with every label once; none for a single line."""
    found = {}
    for axis in figure.axes:
        for line, label in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(label, line)
    if len(found) > 1:
        figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=min(len(found), 4))
