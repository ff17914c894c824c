"""`railcli profile`: import, draw and judge rail and wheel profiles."""

import sys
from pathlib import Path

import click

from railcli.errors import harmless

from .completion import PROFILES
from .options import format_option, output_option, overwrite_option
from .terminal import tell

LENGTHS = ("shift_y", "smooth", "resample", "tape_to_back")  # options in mm
MIRROR = click.Choice(["auto", "yes", "no"])


def shape_options(command):
    """Decorator for what a user may say about a profile file."""
    for option in reversed(
        (
            click.option("--kind", type=click.Choice(["rail", "wheel"]), help="What it is.  [default: found]"),
            click.option("--units", type=click.Choice(["mm", "m", "inch"]), help="Of its numbers.  [default: found]"),
            click.option(
                "--mirror-y", type=MIRROR, default="auto", show_default=True, help="Multiply the file's y by -1."
            ),
            click.option(
                "--mirror-z", type=MIRROR, default="auto", show_default=True, help="Multiply the file's z by -1."
            ),
            click.option(
                "--shift-y",
                type=float,
                default=0.0,
                metavar="MM",
                help="Move a wheel to the field side after its origin was found.  [default: 0]",
            ),
            click.option(
                "--tape-to-back",
                type=float,
                metavar="MM",
                help="Distance of a wheel's tape circle from its flange back.  [default: as the file says, else 70]",
            ),
            click.option(
                "--smooth",
                type=float,
                metavar="MM",
                help="Smooth; the wavelength that is halved.  [default: not at all]",
            ),
            click.option(
                "--resample", type=float, metavar="MM", help="Points at this distance.  [default: those of the file]"
            ),
            click.option(
                "--inclination",
                type=click.Choice(["included", "upright"]),
                help="How a rail stands in the file.  [default: as the file says]",
            ),
        )
    ):
        command = option(command)
    return command


@click.group(short_help="Import, draw and judge rail and wheel profiles.")
def profile():
    """Import, draw and judge rail and wheel profiles.

    Reads MiniProf (.ban, .whl, .mpt), SIMPACK (.prr, .prw), GENSYS (.rail, .wheel), and text or CSV with two columns.
    """


@profile.command("import", short_help="Convert a profile file to the canonical form.")
@click.argument("file", type=click.Path(path_type=Path))
@shape_options
@output_option("a new folder in railcli-out")
@overwrite_option
@format_option
def import_(file, output, overwrite, output_format, **given):
    """Convert a profile file to the canonical form.

    Finds unit, mirror, order and origin or takes them from the options, repairs faults of the measurement, smooths if
    asked, and writes a CSV file with y_mm, z_mm and angle_rad that build-lut takes. What was decided and changed is
    printed and written beside it, as JSON and text.

    \b
    Examples:
      railcli profile import wheel.whl -o wheel.csv
      railcli profile import rail.ban --smooth 4 -o rail.csv
    """
    from railcli.errors import InputError
    from railcli.files.output import output_file, results_folder
    from railcli.files.profile_import import beside, import_profile, write
    from railcli.report.profile import summary, verdict

    if output is not None:
        if output.suffix.lower() != ".csv":
            raise InputError(output, "the canonical profile is a CSV file; end its name with .csv")
        for path in (output, beside(output, "json"), beside(output, "txt")):
            output_file(path, overwrite)
    settings = _settings(given)
    imported = import_profile(file, settings)
    account = imported.account
    lines = [*summary(account), verdict(account, as_it_is=True)]
    if output is not None:
        write(imported, settings, output, "\n".join(lines) + "\n")
    else:
        with results_folder("profile", file.stem) as folder:
            output = folder / f"{file.stem}.csv"
            write(imported, settings, output, "\n".join(lines) + "\n")
    lines.append(f"Profile: {output}")
    lines.append(f"Report: {beside(output, 'json')}, {beside(output, 'txt')}")
    tell({**account, "profile": output}, lines, output_format)


@profile.command("show", short_help="Draw a profile, its slope and its curvature.")
@click.argument("file", metavar="NAME|FILE", type=PROFILES)
@shape_options
@output_option("profile.png in a new folder in railcli-out")
@overwrite_option
@format_option
def show(file, output, overwrite, output_format, **given):
    """Draw a profile, its slope and its curvature.

    NAME is a bundled profile (UIC60, 60E1, ORES1002); a FILE is read as import reads it. With --smooth the curve before
    smoothing is drawn too.

    \b
    Examples:
      railcli profile show UIC60
      railcli profile show wheel.whl --smooth 4 -o wheel.svg
    """
    from railcli.files.output import output_file, results_folder
    from railcli.files.profile_import import open_profile
    from railcli.report import profile as report
    from railcli.report.figures import check_format

    if output is not None:
        check_format(output_file(output, overwrite))
    settings = _settings(given)
    found = open_profile(file, settings)
    raw = found.raw if settings.smooth and found.raw is not found.profile else None
    if output is not None:
        report.plot(found.profile, output, raw)
    else:
        with results_folder("profile", found.profile.name) as folder:
            output = folder / "profile.png"
            report.plot(found.profile, output, raw)
    lines = [*report.summary(found.account), f"Figure: {output}"]
    tell({**found.account, "figure": output}, lines, output_format)


@profile.command("check", short_help="Judge whether a profile is fit for a contact table.")
@click.argument("file", metavar="NAME|FILE", type=PROFILES)
@shape_options
@format_option
def check(file, output_format, **given):
    """Judge whether a profile is fit for a contact table; writes nothing.

    Exit code 0: fit, as it is or once imported; 4: not fit; 2: the file cannot be read.

    \b
    Example:
      railcli profile check rail.ban
    """
    from railcli.errors import CheckError, InputError
    from railcli.files.output import json_text
    from railcli.files.profile_import import is_bundled, open_profile, readable, stands_as_it_is
    from railcli.report.profile import summary, verdict

    settings = _settings(given)
    if not is_bundled(file):
        readable(file, settings)
    try:
        account = open_profile(file, settings).account
    except InputError as error:
        account, lines, reason = {"file": file, "unfit": [str(error)]}, [], str(error)
    else:
        reason = account["unfit"][0] if account["unfit"] else None
        lines = [*summary(account), verdict(account, is_bundled(file) or stands_as_it_is(file, account["kind"]))]
    account["verdict"] = "not fit" if reason else "fit"
    if output_format == "json":
        click.echo(json_text(account))
    elif lines:
        click.echo(harmless("\n".join(lines)))
    if reason:
        sys.stdout.flush()
        raise CheckError(f"not fit for a contact table: {reason}")


def _settings(given):
    from railcli.files.profile_import import ImportSettings

    lengths = {key: None if given[key] is None else given[key] / 1e3 for key in LENGTHS}
    return ImportSettings(**{**given, **lengths})
