"""`railcli conicity`: rolling radius difference and equivalent conicity of a wheelset on its track."""

import re
from contextlib import nullcontext

import click

from .build_lut import setting
from .options import results_options
from .terminal import Terminal, show
from .wheelset import wheelset_of, wheelset_options

LIMITS_MM = (0.1, 20.0)
MOST = 500  # amplitudes
DEEPEST = 1e-3  # a wheel is pressed in [m]


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
@wheelset_options
@click.option("--roll/--no-roll", default=False, show_default=True, help="Let the wheelset roll; EN 15302 does not.")
@setting("--pressed", "0", "MM", "Quasi-elastic contact points, pressed in by this much; the rigid beside.", 1e3)
@click.option("--amplitude", default="1-10", show_default=True, metavar="MM", help="As 1-10, 1-10:0.5 or 2,3,4.5.")
@click.option("--curve", default="300,500,1000", show_default=True, metavar="M", help="Curve radii for steering.")
@click.option("--plot", is_flag=True, help="Draw profiles, delta-r, conicity and contact angles into the folder.")
@results_options
def conicity(roll, pressed, amplitude, curve, plot, output_format, output, overwrite, quiet, **given):
    """Rolling radius difference and equivalent conicity of a rigid wheelset (EN 15302, UIC 519).

    Prints tan gamma_e over amplitude, jumps of delta-r and the steering in curves. With -o or --plot it also writes
    conicity.json, conicity.csv and functions.csv (contact over y).

    \b
    Examples:
      railcli conicity --inclination 40
      railcli conicity --pressed 0.2 --plot -o pressed
      railcli conicity --wheel worn.csv --amplitude 1-8:0.5 --plot -o worn
    """
    from railcli.files.output import results_folder
    from railcli.studies.conicity import conicity as study

    wanted, radii, voice = amplitudes(amplitude), curves(curve), Terminal(quiet)
    if pressed is not None and not 0.0 <= pressed <= DEEPEST:
        raise click.BadParameter(f"must lie in 0 ... {DEEPEST * 1e3:g} mm", param_hint="'--pressed'")
    wheelset = wheelset_of(**given)
    place = nullcontext()
    if output or plot:
        place = results_folder("conicity", f"{wheelset.names['wheel']}-{wheelset.names['rail']}", output, overwrite)
    with place as folder:
        answer = study(wheelset, wanted, radii, roll, pressed, folder, plot, voice)
    show(answer, output_format)
