"""Options that several commands share, each with one name, one meaning and one help text."""

from pathlib import Path

import click

format_option = click.option(
    "--format",
    "output_format",
    type=click.Choice(["text", "json"]),
    default="text",
    show_default=True,
    help="Print for a reader or, as one JSON object, for a machine.",
)

overwrite_option = click.option(
    "--overwrite", is_flag=True, help="Replace what railcli wrote there before; other files stay."
)

quiet_option = click.option("-q", "--quiet", is_flag=True, help="No progress on stderr.")


class Speed(click.ParamType):
    """A speed [m/s], given in m/s or, with its unit, in km/h: 20, 20m/s, 72kmh, 72km/h."""

    name = "speed"

    def __init__(self, low=None, high=None):
        self._low, self._high = low, high

    def convert(self, value, param, ctx):
        if isinstance(value, (int, float)):
            return float(value)
        number, factor = _split_unit(str(value))
        try:
            speed = float(number) / factor
        except ValueError:
            self.fail(f"{value!r} is no speed; give m/s, or km/h with its unit: 20 or 72kmh", param, ctx)
        if self._low is not None and not self._low < speed <= self._high:
            self.fail(f"{speed:g} m/s; allowed: above {self._low:g}, at most {self._high:g} m/s", param, ctx)
        return speed


def _split_unit(text):
    """A number as text, and how many of its unit are 1 m/s."""
    text = text.replace(" ", "").lower()
    for unit, factor in (("km/h", 3.6), ("kmh", 3.6), ("kph", 3.6), ("m/s", 1.0), ("mps", 1.0)):
        if text.endswith(unit):
            return text.removesuffix(unit), factor
    return text, 1.0


def output_option(default):
    """Decorator for ``-o/--output``.

    Parameters
    ----------
    default : str
        Where the command writes when no place is given, as the help text names it.
    """
    return click.option(
        "-o", "--output", type=click.Path(path_type=Path), metavar="PATH", help=f"Where to write  [default: {default}]"
    )


def results_options(command):
    """Decorator of a command that fills a results folder: format, output, overwrite, quiet."""
    for option in (quiet_option, overwrite_option, output_option("a new folder in railcli-out"), format_option):
        command = option(command)
    return command
