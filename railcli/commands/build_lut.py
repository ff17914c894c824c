"""`railcli build-lut`: build or check a contact table."""

import math
import sys
from pathlib import Path

import click

from .completion import RAILS, WHEELS
from .options import format_option, output_option, overwrite_option, quiet_option
from .terminal import Terminal, tell

DEFAULT_WHEEL, DEFAULT_RAIL = "ORES1002", "UIC60"
OF_A_GRID = "y_step", "roll_step", "yaw_count", "curvature_window"  # settings that a table of heights has no use for


def setting(option, default, unit, text, per_si=1.0, kind=float):
    """Decorator for an option that sets one value of a table; the command gets it in SI, or None when it is absent."""

    def to_si(ctx, param, value):
        return None if value is None else kind(value / per_si)

    return click.option(option, type=kind, callback=to_si, metavar=unit, help=f"{text}  [default: {default}]")


@click.command("build-lut", short_help="Build or check a wheel-rail contact table.")
@click.option(
    "--wheel", metavar="NAME|FILE", type=WHEELS, help=f"Wheel profile: bundled or a file.  [default: {DEFAULT_WHEEL}]"
)
@click.option(
    "--rail", metavar="NAME|FILE", type=RAILS, help=f"Rail profile: bundled or a file.  [default: {DEFAULT_RAIL}]"
)
@setting("--inclination", "20", "N", "Rail inclination 1:N; 0: as in the profile.")
@setting("--gauge", "1435", "MM", "Track gauge, 14 mm below the top of the inclined rails.", 1e3)
@setting("--flange-back", "1360", "MM", "Distance of the flange backs.", 1e3)
@setting("--tape-to-back", "70", "MM", "Distance of the tape circle from the flange back.", 1e3)
@setting("--radius", "460", "MM", "Wheel radius at the tape circle.", 1e3)
@setting("--young", "210", "GPA", "Young's modulus of wheel and rail.", 1e-9)
@setting("--poisson", "0.28", "NUMBER", "Poisson's ratio of wheel and rail.")
@setting("--y-range", "20", "MM", "Lateral position of the wheel about nominal, to both sides.", 1e3)
@setting("--y-step", "0.05", "MM", "Its step.", 1e3)
@setting("--roll-range", "25", "MRAD", "Roll, to both sides.", 1e3)
@setting("--roll-step", "1.25", "MRAD", "Its step.", 1e3)
@setting("--yaw-range", "30", "MRAD", "Yaw, to both sides.", 1e3)
@setting("--yaw-count", "11", "NUMBER", "Values of yaw from 0, in equal steps of its square.", 1, int)
@setting("--curvature-window", "2", "MM", "Arc length over which profile curvature is averaged.", 1e3)
@click.option(
    "--normal",
    type=click.Choice(["overlap", "hertz"]),
    help="Patches: strips under the overlap, whose force is the gradient of one energy, or Hertz's ellipses at rigid "
    "contact points, whose force makes or loses energy where these end.  [default: overlap]",
)
@setting("--fineness", "1", "NUMBER", "With --normal overlap, which chooses its own knots: divides their distances.")
@click.option(
    "--method",
    type=click.Choice(["simplex", "locus"]),
    default="simplex",
    show_default=True,
    help="Nelder and Mead on the difference surface, or its closed-form twin.",
)
@click.option(
    "--accuracy",
    type=click.FloatRange(min=0.001, max=100.0),
    metavar="PERCENT|MRAD",
    help="Refine the grid until 99.9 % of the normal forces are this accurate [%]; load centre in proportion. With "
    "--normal hertz: until 99.9 % of the contact angles on the tread are [mrad]; rolling radius, root and flange in "
    "proportion.",
)
@click.option(
    "--largest",
    type=click.FloatRange(min=0.1),
    default=500.0,
    show_default=True,
    metavar="MB",
    help="Size beyond which --accuracy gives up.",
)
@click.option("--check", type=click.Path(path_type=Path), metavar="FILE", help="Build nothing; verify this table.")
@click.option(
    "--poses",
    type=click.IntRange(0, 10_000_000),
    default=20_000,
    show_default=True,
    help="Random poses at which look-up is compared with direct minimisation, and its forces with the law evaluated "
    "directly; 0: no comparison.",
)
@click.option("--seed", type=click.IntRange(min=0), help="Of these poses.  [default: a fixed one; --check: a new one]")
@click.option(
    "--plot",
    is_flag=False,
    flag_value="",
    metavar="[FILE]",
    help="Draw profiles, contact points, rolling radius difference, contact angle and branches or patches "
    "(.png, .svg, .pdf)  [default: beside the table]",
)
@output_option("the cache, where runs look for it")
@overwrite_option
@quiet_option
@format_option
def build_lut(
    wheel, rail, method, accuracy, largest, check, poses, seed, plot, output, overwrite, quiet, output_format, **given
):
    """Build a wheel-rail contact table, or check one.

    Every contact point of a right-hand wheel is found by minimising the distance of wheel and rail, over a grid of
    lateral position, roll and yaw. The table holds the heights at which the wheel stores given energies there; its
    forces are compared with those of the same law evaluated directly at random poses. With --normal hertz it holds the
    contact points, which are compared with direct minimisation besides.

    \b
    Examples:
      railcli build-lut
      railcli build-lut --rail 60E1 --inclination 40 -o table.h5 --plot
      railcli build-lut --accuracy 2
      railcli build-lut --normal hertz -o hertz.h5
      railcli build-lut --check table.h5
    """
    from railcli.report.figures import check_format

    settings = {key: value for key, value in given.items() if value is not None}
    if plot:
        check_format(Path(plot))
    if check is not None:
        refused = [*settings, *(["output"] if output else []), *(["accuracy"] if accuracy else [])]
        if refused:
            option = refused[0].replace("_", "-")
            raise click.UsageError(f"--{option} is for building a table; --check only reads one.")
        lines, facts, complaint = _check(check, wheel, rail, poses, seed, plot, overwrite, quiet)
    else:
        if accuracy and poses == 0:
            raise click.UsageError("--accuracy compares at random poses: --poses must be at least 1.")
        goal = (accuracy, largest * 1e6) if accuracy else None
        lines, facts = _build(settings, wheel, rail, method, goal, poses, seed, plot, output, overwrite, quiet)
        complaint = None
    tell(facts, lines, output_format)
    if complaint is not None:
        sys.stdout.flush()
        raise complaint


def _build(settings, wheel, rail, method, goal, poses, seed, plot, output, overwrite, quiet):
    from railcli.errors import InputError
    from railcli.files import tables
    from railcli.files.output import output_file, results_folder
    from railcli.files.profiles import load_profile, settings_on
    from railcli.model.contact_table import TableSettings
    from railcli.report import contact
    from railcli.studies.tables import doubt, make, refined

    asked, given, settings = settings.get("inclination"), settings, TableSettings(**settings)
    if settings.stores_heights and (idle := [key for key in OF_A_GRID if key in given]):
        raise InputError(
            f"--{idle[0].replace('_', '-')}",
            "means nothing to --normal overlap, which chooses its own knots; give --fineness or --accuracy, or "
            "--normal hertz",
        )
    wheel = load_profile(wheel or DEFAULT_WHEEL, "wheel")
    rail = load_profile(rail or DEFAULT_RAIL, "rail")
    settings = settings_on([rail], settings, asked)
    path = output_file(output, overwrite) if output else None
    picture = None
    if plot:
        picture = output_file(plot, overwrite)
    elif plot is not None and path:
        picture = output_file(path.with_suffix(".png"), overwrite)
    voice = Terminal(quiet)
    how = method, poses, voice, seed
    built = refined(wheel, rail, settings, *goal, *how) if goal else make(wheel, rail, settings, *how)
    table, certificate, stages = built.table, built.certificate, built.stages
    doubt(certificate, wheel, rail, voice)
    path = path or tables.cached_path(table.settings, wheel, rail, method)
    tables.save(table, path, certificate)
    if plot is not None and picture is None:
        with results_folder("build-lut", f"{wheel.name}-{rail.name}") as folder:
            picture = folder / "contact.png"
            contact.plot(table, wheel, rail, picture)
    elif picture is not None:
        contact.plot(table, wheel, rail, picture)
    size = path.stat().st_size
    lines = [*contact.summary(table, certificate, size, built.facts["cpu_s"]), f"Table: {path}"]
    facts = {"table": path, "bytes": size, **built.facts, "certificate": certificate, **_identity(table)}
    if stages:
        lines += contact.refinement_lines(goal[0], stages)
        unit = "percent" if settings.stores_heights else "mrad"
        facts |= {f"accuracy_{unit}": goal[0], "refinement": contact.refinement_facts(stages)}
    if picture is not None:
        lines.append(f"Figure: {picture}")
        facts["figure"] = picture
    return lines, facts


def _check(path, wheel, rail, poses, seed, plot, overwrite, quiet):
    import secrets

    from railcli.errors import CheckError
    from railcli.files import tables
    from railcli.files.output import output_file
    from railcli.report import contact
    from railcli.studies.tables import limits, measure, shortcomings

    if poses == 0:
        raise click.UsageError("--check compares at random poses: --poses must be at least 1.")
    stored = tables.read(path)
    wheel, rail = tables.profiles_of(stored.table, path, wheel, rail)
    picture = None if plot is None else output_file(plot or path.with_suffix(".png"), overwrite)
    seed = secrets.randbits(32) if seed is None else seed
    certificate = measure(stored.table, wheel, rail, poses, Terminal(quiet), seed)
    found = shortcomings(certificate)
    if picture is not None:
        contact.plot(stored.table, wheel, rail, picture)
    size = path.stat().st_size
    lines = contact.summary(stored.table, certificate, size)
    if stored.certificate:
        lines += ["When it was built:", *contact.certificate_lines(stored.certificate)]
    kept = ", ".join(f"{key} {limit:g}" for key, limit in limits(stored.table).items())
    lines.append(f"Limits of p99: {kept}: " + ("kept" if not found else "; ".join(found)))
    facts = {
        "table": path,
        "bytes": size,
        "positions": math.prod(stored.table.counts),
        "certificate": certificate,
        "certificate_when_built": stored.certificate,
        "shortcomings": found,
        "verdict": "failed" if found else "passed",
        **_identity(stored.table),
    }
    return lines, facts, CheckError(f"{path}: {'; '.join(found)}") if found else None


def _identity(table):
    """What a table is for, in a machine's words."""
    return {
        "key": table.key,
        "method": table.method,
        "settings": table.settings.as_dict(),
        "wheel": {"name": table.wheel_name, "sha256": table.wheel_digest},
        "rail": {"name": table.rail_name, "sha256": table.rail_digest},
    }
