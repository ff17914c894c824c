"""A wheelset on its track for readers: its title, its profiles with contact lines, curves over its lateral position."""

import math

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize

from railcli.model.profile import TAPE_TO_BACK

from .figures import BLUE, GREY, VERMILION

SIDES = (("right", BLUE, "-"), ("left", VERMILION, "--"))
SIGN = {"right": 1.0, "left": -1.0}  # of the profile coordinate, to the field side, against y to the right
LIFT = 30.0  # the wheel is drawn this far above its rail [mm]
MARGIN = 3.0  # about the profiles [mm]
LABEL_ROOM = 7.0  # between two contact points that are labelled [mm]
LABEL_AWAY = 9.0  # of a label from its point [points]
FREE_SHARE = 0.7  # of the way to the flank is shown in the inset of delta-r
INSET_FROM = 4.0  # an inset is drawn when delta-r is this much larger beyond it
# told apart in print without colours, from dark (left) to light (right), and no line too light for white paper
LINES = ListedColormap(colormaps["cividis"](np.linspace(0.0, 0.8, 256)))


def inclination(settings):
    """`1:20`, or `as in the profile`."""
    return f"1:{settings.inclination:g}" if settings.inclination else "as in the profile"


def flange_back(settings):
    """`flange-back 1360 mm`, and the tape circle where it is not the usual one."""
    tape = settings.tape_to_back
    told = "" if tape == TAPE_TO_BACK else f", tape circle {tape * 1e3:g} mm from it"
    return f"flange-back {settings.flange_back * 1e3:g} mm{told}"


def title(names, settings, wheelset, with_roll):
    """`ORES1002 on UIC60, inclination 1:40, ...`"""
    radius = f"{settings.radius * 1e3:g}"
    if wheelset.left.radius != wheelset.right.radius:
        radius += f" (left {wheelset.left.radius * 1e3:g})"
    left = [names[key] for key in ("left_wheel", "left_rail") if key in names]
    return (
        f"{names['wheel']} on {names['rail']}{', left ' + ' on '.join(left) if left else ''}, "
        f"inclination {inclination(settings)}, gauge {settings.gauge * 1e3:g} mm, "
        f"{flange_back(settings)}, radius {radius} mm, {'with' if with_roll else 'without'} roll"
    )


def whole_positions(contact):
    """Indices of the lateral positions at whole mm."""
    reach = math.floor(contact.y[-1] * 1e3 + 1e-6)
    return [int(np.argmin(np.abs(contact.y - whole * 1e-3))) for whole in range(-reach, reach + 1)]


def colours_of(contact):
    """Colour of a lateral position [mm]."""
    reach = math.floor(contact.y[-1] * 1e3 + 1e-6)
    return ScalarMappable(Normalize(-reach, reach), LINES)


def outlines(mounting, lift=LIFT):
    """Wheel, lifted by some mm, and rail from the tape circle to the field side: two pairs of arrays [mm]."""
    s = 1e3 * (mounting.wheel_start + mounting.wheel_step * np.arange(mounting.wheel.shape[0]))
    across = 1e3 * (mounting.rail_start - mounting.seat + mounting.rail_step * np.arange(mounting.rail.shape[0]))
    return (s, 1e3 * mounting.wheel[:, 0] - lift), (across, 1e3 * mounting.rail[:, 0])


def frame(mounting):
    """Extent of the drawn profiles from the tape circle to the field side and down: (low, high), (low, high) [mm]."""
    wheel, rail = outlines(mounting)
    return [
        (float(min(one.min(), other.min())) - MARGIN, float(max(one.max(), other.max())) + MARGIN)
        for one, other in zip(wheel, rail, strict=True)
    ]


def profiles(axis, contact, side, labels=False):
    """Draw one wheel lifted off its rail, and lines between the points that touch at each whole mm of y.

    Parameters
    ----------
    axis : Axes
    contact : Rolling
    side : str
        "right" or "left".
    labels : bool
        Write y beside as many lines as there is room for.
    """
    mounting, sign, colours = getattr(contact.wheelset, side), SIGN[side], colours_of(contact)
    wheel, rail = outlines(mounting)
    places = {}
    for i in whole_positions(contact):
        on_wheel = 1e3 * contact.values[f"s_{side}"][i]
        on_rail = 1e3 * (contact.values[f"rail_{side}"][i] - mounting.seat)
        ends = [np.interp(on_wheel, *wheel), np.interp(on_rail, *rail)]
        y = round(1e3 * contact.y[i])
        axis.plot(
            [sign * on_wheel, sign * on_rail], ends,
            color=colours.to_rgba(y), linewidth=1.0, marker="o", markersize=2.5,
        )  # fmt: skip
        places[y] = (sign * on_wheel, ends[0]), sign * contact.values[f"angle_{side}"][i]
    for curve in (wheel, rail):
        axis.plot(sign * curve[0], curve[1], color="black", linewidth=1.4, zorder=1)
    if labels:
        _label(axis, places)
    across, down = frame(mounting)
    axis.set_aspect("equal")
    axis.set_xlim(*sorted(sign * place for place in across))
    axis.set_ylim(down[1], down[0])
    axis.set_xlabel("from the tape circle, to the right [mm]")
    axis.set_ylabel("z, down [mm]")


def _label(axis, places):
    """Write y [mm] inside the wheel at contact points that lie apart: 0 first, then from the outermost."""
    taken = []
    for y in sorted(places, key=lambda y: (y != 0, -abs(y))):
        place, angle = places[y]
        if all(math.dist(place, other) >= LABEL_ROOM for other in taken):
            taken.append(place)
            away = LABEL_AWAY * -math.sin(angle), LABEL_AWAY * math.cos(angle)
            axis.annotate(signed(y), place, away, textcoords="offset points", ha="center", va="center", fontsize=8)


def signed(value):
    """A number with a true minus sign."""
    return f"{value:g}".replace("-", "\N{MINUS SIGN}")


def broken(contact, values):
    """y [mm] and values with a gap at each jump of the contact."""
    after = contact.jumps + 1
    return np.insert(contact.y * 1e3, after, np.nan), np.insert(values, after, np.nan)


def over_y(axis, contact, title, unit):
    """Set an axis up for curves over the lateral position; where a flank touches is shaded."""
    y = contact.y * 1e3
    axis.set_xlim(y[0], y[-1])
    axis.locator_params(axis="x", integer=True)
    for low, high in ((y[0], contact.clearance[0] * 1e3), (contact.clearance[1] * 1e3, y[-1])):
        if low < high:
            label = None if axis.patches else "a flank touches"
            axis.axvspan(low, high, color=GREY, alpha=0.15, linewidth=0.0, label=label)
    axis.set_title(title)
    axis.set_ylabel(unit)
    axis.set_xlabel("lateral position y, to the right [mm]")


def both_sides(axis, contact, quantity, scale):
    """Curves of a quantity of both wheels, with gaps at jumps."""
    for side, colour, line in SIDES:
        curve = broken(contact, scale(contact.values[f"{quantity}_{side}"]))
        axis.plot(*curve, color=colour, linestyle=line, label=f"{side} wheel")
    axis.legend(loc="best")


def radius_difference(axis, contact, rigid=None):
    """Draw delta-r, and in an inset what it is before a flank touches; beside it that of rigid contact points."""
    over_y(axis, contact, "Rolling radius difference, right less left", "Δr [mm]")
    y, difference = broken(contact, contact.radius_difference * 1e3)
    axis.plot(y, difference, color=BLUE, label="quasi-elastic" if rigid else None)
    if rigid:
        axis.plot(*broken(rigid, rigid.radius_difference * 1e3), color=VERMILION, linestyle="--", label="rigid")
    if axis.patches or rigid:
        axis.legend(loc="lower right")
    limit = FREE_SHARE * 1e3 * min(-contact.clearance[0], contact.clearance[1], contact.y[-1])
    free = ~(np.abs(y) > limit)
    if np.nanmax(np.abs(difference)) < INSET_FROM * np.nanmax(np.abs(difference[free])):
        return
    inset = axis.inset_axes([0.12, 0.68, 0.36, 0.24])
    inset.plot(y[free], difference[free], color=BLUE)
    inset.set_title("on the treads", fontsize=8, fontweight="normal")
    inset.tick_params(labelsize=8)
    inset.set_xlim(-limit, limit)
    inset.locator_params(axis="x", integer=True)
    inset.yaxis.tick_right()
