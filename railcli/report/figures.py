"""What all figures share: size, colours, how they are saved. No global state of matplotlib is used."""

from pathlib import Path

from railcli.errors import InputError
from railcli.files.output import whole_file

# Okabe and Ito (2008): told apart by colour-blind readers too
BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9"
SERIES = (BLUE, VERMILION, GREEN, ORANGE, PURPLE, SKY)
GREY = "#777777"
FORMATS = ("png", "svg", "pdf")
DPI = 150
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
    with rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(figure)
        painter(figure)
        with whole_file(path) as temporary:
            figure.savefig(temporary, format=path.suffix[1:].lower(), dpi=dpi)


def plain(text):
    """A user's words as a label of matplotlib, to which $ and a leading underscore mean something else."""
    text = text.replace("$", r"\$")
    return f" {text}" if text.startswith("_") else text


def check_format(path):
    """Raise an InputError when the ending of a figure's path names no format."""
    if path.suffix[1:].lower() not in FORMATS:
        raise InputError(path, f"figures end with one of: {', '.join('.' + name for name in FORMATS)}")
