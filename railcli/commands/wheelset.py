"""Options that describe a wheelset on its track, and what they describe."""

import click

from .build_lut import DEFAULT_RAIL, DEFAULT_WHEEL, setting
from .completion import RAILS, WHEELS


def wheelset_options(command):
    """Decorator for profiles, track and wheels of a wheelset whose sides may differ."""
    name = "NAME|FILE"
    for option in reversed(
        (
            click.option(
                "--wheel", default=DEFAULT_WHEEL, show_default=True, metavar=name, type=WHEELS, help="Wheel profile."
            ),
            click.option(
                "--rail", default=DEFAULT_RAIL, show_default=True, metavar=name, type=RAILS, help="Rail profile."
            ),
            click.option(
                "--left-wheel",
                metavar=name,
                type=WHEELS,
                help="Left wheel, as a right-hand profile.  [default: as right]",
            ),
            click.option(
                "--left-rail", metavar=name, type=RAILS, help="Left rail, as a right-hand profile.  [default: as right]"
            ),
            setting("--inclination", "20", "N", "Rail inclination 1:N; 0: as in the profile."),
            setting("--gauge", "1435", "MM", "Track gauge, 14 mm below the top of the inclined rails.", 1e3),
            setting("--flange-back", "1360", "MM", "Distance of the flange backs.", 1e3),
            setting("--tape-to-back", "70", "MM", "Distance of the tape circle from the flange back.", 1e3),
            setting("--radius", "460", "MM", "Wheel radius at the tape circle.", 1e3),
            setting("--left-radius", "as right", "MM", "Radius of the left wheel.", 1e3),
        )
    ):
        command = option(command)
    return command


def wheelset_of(wheel, rail, left_wheel, left_rail, left_radius, **given):
    """What the options describe, a studies.conicity.Mounted; its sides are checked to fit."""
    from railcli.model.contact_table import LIMITS, TableSettings
    from railcli.studies.conicity import mounted

    settings = TableSettings(**{key: value for key, value in given.items() if value is not None})
    if left_radius is not None:
        low, high, _ = LIMITS["radius"]
        if not low <= left_radius <= high:
            raise click.BadParameter(f"must lie in {low * 1e3:g} ... {high * 1e3:g} mm", param_hint="'--left-radius'")
    return mounted(settings, wheel, rail, left_wheel, left_rail, left_radius, given["inclination"])
