"""Rolling radius difference and equivalent conicity of a wheelset on its track."""

from typing import NamedTuple

from railcli.analysis.build_table import check_fit
from railcli.analysis.conicity import conicity as motions_of
from railcli.analysis.conicity import rolling, steering
from railcli.analysis.rigid_contact import Wheelset, wheelset_on
from railcli.files.output import write_json, write_text
from railcli.files.profiles import load_profile, profile_of, settings_on
from railcli.model.contact_table import TableSettings
from railcli.model.system import table_settings

from .answer import Answer
from .voice import SILENT

UNEVEN_MM = 3.0  # how far beyond the largest amplitude a wheelset with unlike sides is looked at
PLOT_STEP_MM = 0.05
DRAWN = 200  # amplitudes of the figure, about
SHOWN = ("inclination", "gauge", "flange_back", "tape_to_back", "radius")


class Mounted(NamedTuple):
    """A wheelset over its track: settings, both sides, names of the profiles."""

    settings: TableSettings
    pair: Wheelset
    names: dict


def mounted(settings, wheel, rail, left_wheel=None, left_rail=None, left_radius=None, inclination=None):
    """A wheelset over its track, checked to fit.

    Parameters
    ----------
    settings : TableSettings
    wheel, rail, left_wheel, left_rail : str or Profile
        Profiles, or their names or files.
    left_radius : float, optional
        [m]
    inclination : float, optional
        That the user gave by word, as files.profiles.settings_on.

    Returns
    -------
    Mounted
        Names of the profiles: wheel, rail, and left_wheel, left_rail where given.
    """
    right = _profile(wheel, "wheel"), _profile(rail, "rail")
    left = left_wheel and _profile(left_wheel, "wheel"), left_rail and _profile(left_rail, "rail")
    settings = settings_on([one for one in (right[1], left[1]) if one], settings, inclination)
    pair = wheelset_on(settings, *right, *left, left_radius)
    for mounting in pair.mountings:
        check_fit(mounting, settings)
    names = {"wheel": right[0].name, "rail": right[1].name}
    names |= {f"left_{key}": item.name for key, item in zip(("wheel", "rail"), left, strict=True) if item}
    return Mounted(settings, pair, names)


def _profile(given, kind):
    return load_profile(given, kind) if isinstance(given, str) else given


def conicity(wheelset, amplitudes_mm, radii, roll=False, pressed=None, folder=None, figure=False, voice=SILENT):
    """Rolling radius difference, equivalent conicity and steering of a rigid wheelset.

    Parameters
    ----------
    wheelset : Mounted
    amplitudes_mm : sequence of float
        [mm], ascending
    radii : sequence of float
        Of curves [m].
    roll : bool
        Let the wheelset roll.
    pressed : float, optional
        Quasi-elastic contact points, pressed in by this much [m]; the rigid ones beside.
    folder : pathlib.Path, optional
        Results folder for files.
    figure : bool
        Draw into it.
    voice : Voice

    Returns
    -------
    Answer
    """
    from railcli.report import conicity as report
    from railcli.report import wheelset as head

    settings, rigid_pair, names = wheelset
    pair = rigid_pair.pressed_in(pressed) if pressed else rigid_pair
    reach = amplitudes_mm[-1] * 1e-3 + (0.0 if pair.alike else UNEVEN_MM * 1e-3)
    with voice.job("Contact", 100, "%") as job:
        contact = rolling(pair, reach, roll, lambda share: job.update(round(100 * share)))
    rigid = rolling(rigid_pair, reach, roll) if pressed else None
    motions = motions_of(contact, [value * 1e-3 for value in amplitudes_mm])
    rows = steering(contact, radii)
    title = head.title(names, settings, pair, roll)
    shown = {key: getattr(settings, key) for key in SHOWN} | {"pressed": pressed or 0.0}
    record = report.as_json(shown, names, roll, contact, motions, rows)
    lines = report.summary(title, contact, motions, rows)
    if rigid is not None:
        title += f", pressed in by {pressed * 1e3:g} mm"
        lines = [title, *lines[1:], *report.pressed_lines(contact, rigid)]
        record["rigid"] = report.pressed_facts(contact, rigid)
    if folder:
        write_json(folder / "conicity.json", record)
        write_text(folder / "conicity.csv", report.conicity_csv(contact, motions))
        write_text(folder / "functions.csv", report.functions_csv(contact))
        if figure:
            smooth = motions_of(contact, _finely(amplitudes_mm[0], amplitudes_mm[-1]))
            report.plot(title, contact, smooth, folder / "conicity.png", rigid)
        lines.append(f"Written to {folder}")
    return Answer(record, lines, folder)


def _finely(low, high):
    """Amplitudes of the figure [m] between two in [mm]."""
    step = max(PLOT_STEP_MM, (high - low) / DRAWN)
    count = int((high - low) / step + 1e-9) + 1
    return [(low + i * step) * 1e-3 for i in range(count)]


def mounted_of(scenario):
    """The first wheelset of a scenario over its track, as a Mounted."""
    (wheel, rail, _), (left_wheel, left_rail, _) = scenario.contact.sides
    right, left = scenario.vehicle.wheel_radii[0]
    wheels = [profile_of(scenario, place, "wheel") for place in (wheel, left_wheel)]
    rails = [profile_of(scenario, place, "rail") for place in (rail, left_rail)]
    other = (wheels[1] if left_wheel != wheel else None), (rails[1] if left_rail != rail else None)
    settings = table_settings(scenario, right)
    return mounted(settings, wheels[0], rails[0], *other, left if left != right else None)
