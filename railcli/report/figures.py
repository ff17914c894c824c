"""What all figures share: size, colours, how they are saved. No global state of matplotlib is used.

What stands in a figure is words, whoever wrote them: no mathematics is read out of it, and letters that the font lacks
are taken from other fonts of the machine.
"""

import logging
import re
import warnings
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from railcli.errors import InputError, RailcliWarning
from railcli.files.output import whole_file

# Okabe and Ito (2008): told apart by colour-blind readers too
BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9"
SERIES = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
GREY = "#777777"
FORMATS = ("png", "svg", "pdf")
DPI = 150
MORE_FONTS = (  # for letters that matplotlib's own font lacks, where the machine has them
    "Noto Sans", "Noto Sans CJK SC", "Noto Sans CJK JP", "Source Han Sans SC", "WenQuanYi Zen Hei",
    "Droid Sans Fallback",
    "Microsoft YaHei", "Yu Gothic", "Malgun Gothic", "PingFang SC", "Hiragino Sans", "Arial Unicode MS",
    "Noto Sans Arabic", "Noto Sans Devanagari", "Noto Sans Thai", "Noto Sans Hebrew", "Segoe UI Symbol",
)  # fmt: skip
STYLE = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "svg.fonttype": "none",
}


def draw(painter, path, size, dpi=DPI):
    """Let `painter(figure)` fill a new figure and write it, whole or not at all.

    Parameters
    ----------
    painter : callable
    path : path-like
        Its ending, one of FORMATS, decides the format.
    size : tuple
        Width and height [inch].
    dpi : float
        Pixels per inch of a PNG.
    """
    from matplotlib import rc_context  # takes half a second to load, so only where something is drawn
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    path = Path(path)
    check_format(path)
    with rc_context({**STYLE, "font.family": fonts()}), any_letter():
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        painter(figure)
        words(figure)
        with whole_file(path) as temporary:
            figure.savefig(temporary, format=path.suffix[1:].lower(), dpi=dpi)


def plain(text):
    """A user's words as the label of a curve, which matplotlib leaves out of a legend when they begin with _."""
    return f" {text}" if text.startswith("_") else text


def words(figure):
    """Let no text of a figure be read as mathematics, but for the numbers that matplotlib puts on axes."""
    from matplotlib.text import Text

    numbers = set()
    for axes in figure.findobj(lambda artist: hasattr(artist, "xaxis")):
        for axis in (axes.xaxis, axes.yaxis):
            numbers |= {axis.offsetText, *axis.get_ticklabels(which="both")}
    for text in figure.findobj(Text):
        if text not in numbers:
            text.set_parse_math(False)


@cache
def fonts():
    """Families of fonts: matplotlib's own, then those of the machine that have more letters."""
    from matplotlib import font_manager

    found = {font.name for font in font_manager.fontManager.ttflist}
    return ["DejaVu Sans", *(name for name in MORE_FONTS if name in found)]


@contextmanager
def any_letter():
    """Say once, in one line, which letters no font has; they are drawn as boxes."""
    logger, lacking = logging.getLogger("matplotlib"), []
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
    finally:
        logger.setLevel(level)
    for warning in caught:
        if match := re.match(r"Glyph (\d+) ", str(warning.message)):
            lacking.append(chr(int(match[1])))
        else:
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    if letters := "".join(sorted(set(lacking) - _told)):
        _told.update(letters)
        warnings.warn(
            f"no font here has the letters {letters[:40]}: figures show boxes; a font such as Noto Sans CJK has them",
            RailcliWarning,
            stacklevel=3,
        )


_told = set()


def check_format(path):
    """Raise an InputError when the ending of a figure's path names no format."""
    if path.suffix[1:].lower() not in FORMATS:
        raise InputError(path, f"figures end with one of: {', '.join('.' + name for name in FORMATS)}")
