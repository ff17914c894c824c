"""`railcli conicity`: rolling radius difference and equivalent conicity of a wheelset on its track."""

import re

import click

from .build_lut import DEFAULT_RAIL, DEFAULT_WHEEL, setting
from .options import results_options

LIMITS_MM = (0.1, 20.0)
MOST = 500  # amplitudes
PLOT_STEP_MM = 0.05
UNEVEN_MM = 3.0  # how far beyond the largest amplitude a wheelset with unlike sides is looked at


def amplitudes(text):
    """Amplitudes [mm] of `1-10`, `1-10:0.5` or `2,3,4.5`."""
    span = re.fullmatch(r"\s*([\d.]+)\s*-\s*([\d.]+)\s*(?::\s*([\d.]+)\s*)?", text)
    try:
        if span:
            low, high, step = float(span[1]), float(span[2]), float(span[3] or 1.0)
            count = int((high - low) / step + 1e-9) + 1 if step > 0.0 and high >= low else 0
            values = [low + i * step for i in range(min(count, MOST + 1))]
        else:
            values = sorted({float(part) for part in text.split(",")})
    except ValueError:
        values = []
    if not values or len(values) > MOST or not all(LIMITS_MM[0] <= value <= LIMITS_MM[1] for value in values):
        raise click.BadParameter(
            f"{text!r}: give 1-10, 1-10:0.5 or 2,3,4.5; {LIMITS_MM[0]:g} to {LIMITS_MM[1]:g} mm, at most {MOST} values",
            param_hint="'--amplitude'",
        )
    return values


def curves(text):
    """Curve radii [m] of `300,500,1000`."""
    try:
        values = [float(part) for part in text.split(",") if part.strip()]
    except ValueError:
        values = [0.0]
    if not all(10.0 <= value <= 1e6 for value in values):
        raise click.BadParameter(f"{text!r}: give radii of 10 to 1000000 m, such as 300,1000", param_hint="'--curve'")
    return values


@click.command(short_help="Equivalent conicity of a wheelset on its track.")
@click.option("--wheel", default=DEFAULT_WHEEL, show_default=True, metavar="NAME|FILE", help="Wheel profile.")
@click.option("--rail", default=DEFAULT_RAIL, show_default=True, metavar="NAME|FILE", help="Rail profile, upright.")
@click.option("--left-wheel", metavar="NAME|FILE", help="Left wheel, as a right-hand profile.  [default: as right]")
@click.option("--left-rail", metavar="NAME|FILE", help="Left rail, as a right-hand profile.  [default: as right]")
@setting("--inclination", "20", "N", "Rail inclination 1:N; 0 is upright.")
@setting("--gauge", "1435", "MM", "Track gauge, 14 mm below the top of the inclined rails.", 1e3)
@setting("--flange-back", "1360", "MM", "Distance of the flange backs.", 1e3)
@setting("--radius", "460", "MM", "Wheel radius at the tape circle.", 1e3)
@setting("--left-radius", "as right", "MM", "Radius of the left wheel.", 1e3)
@click.option("--roll/--no-roll", default=False, show_default=True, help="Let the wheelset roll; EN 15302 does not.")
@click.option("--amplitude", default="1-10", show_default=True, metavar="MM", help="As 1-10, 1-10:0.5 or 2,3,4.5.")
@click.option("--curve", default="300,500,1000", show_default=True, metavar="M", help="Curve radii for steering.")
@click.option("--plot", is_flag=True, help="Draw profiles, delta-r, conicity and contact angles into the folder.")
@results_options
def conicity(wheel, rail, left_wheel, left_rail, left_radius, roll, amplitude, curve, plot, output_format, output,
             overwrite, quiet, **given):  # fmt: skip
    """Rolling radius difference and equivalent conicity of a rigid wheelset (EN 15302, UIC 519).

    Prints tan gamma_e over amplitude, jumps of delta-r and the steering in curves. With -o or --plot it also writes
    conicity.json, conicity.csv and functions.csv (contact over y).

    \b
    Examples:
      railcli conicity --inclination 40
      railcli conicity --wheel worn.csv --amplitude 1-8:0.5 --plot -o worn
    """
    from railcli.analysis.build_table import check_fit
    from railcli.analysis.conicity import conicity, rolling, steering, wheelset_on
    from railcli.files.output import json_text, results_folder, write_json, write_text
    from railcli.files.profiles import load_profile
    from railcli.files.progress import Progress
    from railcli.model.contact_table import LIMITS, TableSettings
    from railcli.report import conicity as report
    from railcli.report.contact import inclination

    wanted, radii = amplitudes(amplitude), curves(curve)
    settings = TableSettings(**{key: value for key, value in given.items() if value is not None})
    if left_radius is not None:
        low, high, unit = LIMITS["radius"]
        if not low <= left_radius <= high:
            raise click.BadParameter(f"must lie in {low * 1e3:g} ... {high * 1e3:g} mm", param_hint="'--left-radius'")
    right = load_profile(wheel, "wheel"), load_profile(rail, "rail")
    left = left_wheel and load_profile(left_wheel, "wheel"), left_rail and load_profile(left_rail, "rail")
    pair = wheelset_on(settings, *right, *left, left_radius)
    for mounting in (pair.right, pair.left):
        check_fit(mounting, settings)
    reach = wanted[-1] * 1e-3 + (0.0 if pair.alike else UNEVEN_MM * 1e-3)
    with Progress("Contact", 100, "%", quiet) as progress:
        contact = rolling(pair, reach, roll, lambda share: progress.update(round(100 * share)))
    motions = conicity(contact, [value * 1e-3 for value in wanted])
    rows = steering(contact, radii)
    names = {"wheel": right[0].name, "rail": right[1].name}
    names |= {f"left_{key}": item.name for key, item in zip(("wheel", "rail"), left, strict=True) if item}
    title = report.title(names, inclination(settings), settings, left_radius, roll)
    shown = {key: getattr(settings, key) for key in ("inclination", "gauge", "flange_back", "radius")}
    record = report.as_json(shown, names, roll, contact, motions, rows)
    lines = report.summary(title, contact, motions, rows)
    if output or plot:
        with results_folder("conicity", f"{right[0].name}-{right[1].name}", output, overwrite) as folder:
            write_json(folder / "conicity.json", record)
            write_text(folder / "conicity.csv", report.conicity_csv(contact, motions))
            write_text(folder / "functions.csv", report.functions_csv(contact))
            if plot:
                fine = amplitudes(f"{wanted[0]}-{wanted[-1]}:{max(PLOT_STEP_MM, (wanted[-1] - wanted[0]) / 200)}")
                smooth = conicity(contact, [value * 1e-3 for value in fine])
                report.plot(title, contact, smooth, folder / "conicity.png")
        lines.append(f"Written to {folder}")
    click.echo(json_text(record) if output_format == "json" else "\n".join(lines))
