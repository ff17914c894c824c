"""`railcli contact`: the contact overview of a wheelset on its track."""

import click

from .build_lut import setting
from .options import results_options
from .terminal import tell
from .wheelset import wheelset_of, wheelset_options

REACH_MM = 10.0  # lateral positions to both sides
MOST_PLACES = 5
LOADS_KN = (1.0, 300.0)
LARGEST_YAW_MRAD = 50.0
AMPLITUDE_STEP_MM = 0.1  # of the drawn conicity


def places(text):
    """Lateral positions [m] of `0,3,6`."""
    try:
        values = sorted({float(part) for part in text.split(",")})
    except ValueError:
        values = []
    if not 1 <= len(values) <= MOST_PLACES or not all(abs(value) <= REACH_MM for value in values):
        raise click.BadParameter(
            f"{text!r}: give lateral positions such as 0,3,6; {-REACH_MM:g} to {REACH_MM:g} mm, at most {MOST_PLACES}",
            param_hint="'--at'",
        )
    return [value * 1e-3 for value in values]


def within(value, low, high, option, unit):
    """The value, if it lies in its range."""
    if not low <= value <= high:
        raise click.BadParameter(f"must lie in {low:g} ... {high:g} {unit}, got {value:g}", param_hint=f"'{option}'")
    return value


@click.command(short_help="Contact overview of a wheelset on its track, in one picture.")
@wheelset_options
@click.option("--roll/--no-roll", default=True, show_default=True, help="Let the wheelset roll; else it stays level.")
@click.option("--yaw", type=float, default=0.0, show_default=True, metavar="MRAD", help="Yaw of the wheelset.")
@click.option("--at", default="0,3,6", show_default=True, metavar="MM", help="Lateral positions of the patches.")
@click.option("--load", type=float, default=55.0, show_default=True, metavar="KN", help="Vertical force on each wheel.")
@setting("--young", "210", "GPA", "Young's modulus of wheel and rail.", 1e-9)
@setting("--poisson", "0.28", "NUMBER", "Poisson's ratio of wheel and rail.")
@setting("--curvature-window", "2", "MM", "Arc length over which profile curvature is averaged.", 1e3)
@click.option(
    "--normal", type=click.Choice(["hertz", "overlap"]), default="hertz", show_default=True,
    help="Law of the patches: ellipses at contact points, or strips under the overlap.",
)
@click.option(
    "--picture", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True, help="Format of it."
)
@results_options
def contact(roll, yaw, at, load, normal, picture, output_format, output, overwrite, quiet, **given):
    """Contact overview: where wheels and rails touch for y = -10 to 10 mm, what it means, and the patches under load.

    Draws both profiles with contact lines, patches at chosen y, delta-r, contact angles and positions, and equivalent
    conicity into one picture for A4; prints the values, jumps of delta-r and flange contact. Writes contact.png,
    contact.json, contact.csv (each mm of y), functions.csv (finely, with jumps) and patches.csv.

    \b
    Examples:
      railcli contact
      railcli contact --normal overlap --at 5.5,6,6.4 --load 50
      railcli contact --inclination 40 --at=-5,0,5 --picture svg -o overview
    """
    from railcli.analysis.conicity import conicity, rolling
    from railcli.analysis.patches import standing
    from railcli.files.output import results_folder, write_json, write_text
    from railcli.files.progress import Progress
    from railcli.report import overview
    from railcli.report.conicity import functions_csv
    from railcli.report.wheelset import title

    at = places(at)
    load = 1e3 * within(load, *LOADS_KN, "--load", "kN")
    yaw = 1e-3 * within(yaw, -LARGEST_YAW_MRAD, LARGEST_YAW_MRAD, "--yaw", "mrad")
    settings, pair, names = wheelset_of(**given)
    reach = REACH_MM * 1e-3
    with Progress("Contact", 100, "%", quiet) as progress:
        found = rolling(pair, reach, roll, lambda share: progress.update(round(100 * share)), yaw)
    level = found if yaw == 0.0 and not roll else rolling(pair, reach)
    stand = standing(pair, load, settings.young, settings.poisson, roll, yaw, normal)
    patches = [stand(y) for y in at]

    def conicities(amplitudes):
        of_level = conicity(level, amplitudes)
        return of_level if level is found else conicity(found, amplitudes), of_level

    coarse = conicities([1e-3 * k for k in range(1, int(REACH_MM) + 1)])
    fine = conicities([1e-3 * AMPLITUDE_STEP_MM * k for k in range(5, round(REACH_MM / AMPLITUDE_STEP_MM) + 1)])
    head = title(names, settings, pair, roll) + (f", yaw {yaw * 1e3:g} mrad" if yaw else "")
    loading = overview.loading_text(load, settings, roll, normal)
    shown = (
        "inclination", "gauge", "flange_back", "tape_to_back", "radius", "young", "poisson", "curvature_window",
    )  # fmt: skip
    record = overview.as_json(
        names, {key: getattr(settings, key) for key in shown},
        {"left_radius": pair.left.radius, "roll": roll, "yaw_mrad": yaw * 1e3, "load_kN": load / 1e3},
        found, *coarse, patches, loading,
    )  # fmt: skip
    lines = overview.summary(head, found, *coarse, patches, loading)
    with results_folder("contact", f"{names['wheel']}-{names['rail']}", output, overwrite) as folder:
        write_json(folder / "contact.json", record)
        write_text(folder / "contact.csv", overview.contact_csv(found))
        write_text(folder / "functions.csv", functions_csv(found))
        write_text(folder / "patches.csv", overview.patches_csv(patches))
        overview.plot(head, found, *fine, patches, loading, folder / f"contact.{picture}")
    lines.append(f"Written to {folder}")
    tell(record, lines, output_format)
