"""`railcli diff`: two results channel by channel."""

import math
from pathlib import Path

import click

from .options import format_option, quiet_option
from .terminal import tell


def absolute_tolerances(given):
    """Unit -> tolerance of texts such as `N=10`."""
    found = {}
    for text in given:
        unit, equals, number = text.rpartition("=")
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not equals or not unit or not 0.0 <= value < math.inf:
            raise click.BadParameter(f"{text!r}: give UNIT=VALUE with a value >= 0, such as N=10 or m=1e-6 (SI)",
                                     param_hint="'--absolute'")  # fmt: skip
        found[unit.strip()] = value
    return found


@click.command(short_help="Compare two results channel by channel.")
@click.argument("one", metavar="A", type=click.Path(path_type=Path))
@click.argument("two", metavar="B", type=click.Path(path_type=Path))
@click.option(
    "--relative", type=click.FloatRange(0.0, 1.0), metavar="SHARE", help="Allowed share of a channel's range in A  "
    "[default: 1e-6]",
)  # fmt: skip
@click.option("--absolute", multiple=True, metavar="UNIT=VALUE", help="Always allowed in a unit; may be repeated.")
@click.option("--channel", "patterns", multiple=True, metavar="GLOB", help="Channels to compare; may be repeated.")
@click.option("--common", is_flag=True, help="Channels and instants that only one of them has are no difference.")
@click.option("--show", type=click.IntRange(0), default=20, show_default=True, metavar="N", help="Channels to print.")
@format_option
@quiet_option
def diff(one, two, relative, absolute, patterns, common, show, output_format, quiet):
    """Compare the time series of results folder B with those of A.

    A channel differs when a value is away by more than the larger of a share of the channel's range and an absolute
    value for its unit. Says which channels differ, by how much and where, and which settings and versions do. Exit code
    0: no difference beyond tolerance, 4: there is one.

    \b
    Examples:
      railcli diff before after
      railcli diff before after --relative 1e-3 --absolute N=50 --channel 'wheels/*/[YQ]'
    """
    from railcli.analysis.compare import ABSOLUTE, RELATIVE, Tolerances, compare_results
    from railcli.errors import CheckError
    from railcli.files.columns import columns_of
    from railcli.files.progress import Progress
    from railcli.files.read_results import Results
    from railcli.report import diff as report

    tolerances = Tolerances(RELATIVE if relative is None else relative, {**ABSOLUTE, **absolute_tolerances(absolute)})
    with Results(one) as a, Results(two) as b:
        with Progress("Compare", 100, "%", quiet) as progress:
            found = compare_results(a, b, *columns_of([a, b], patterns), tolerances, common, progress.update)
        tell(report.as_json(a, b, found, tolerances), report.text(a, b, found, tolerances, show), output_format)
    if found.differs:
        raise CheckError(f"diff: {report.verdict(found)}")
