"""Profile files of any kind to the canonical form, with an account of all that was decided and changed."""

import hashlib
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from railcli import __version__
from railcli.errors import InputError
from railcli.model.curation import Curation
from railcli.model.profile import TAPE_TO_BACK, Profile
from railcli.model.smoothing import change, resample, smooth

from .alignment import align, find_kind
from .decision import WARNING, Decision
from .formats import ENDINGS, read_points, recognised
from .output import write_json, write_text
from .profiles import (
    BUNDLED,
    LARGEST_FILE_MB,
    LEAN,
    STANDS,
    canonical,
    check_angle,
    check_curve,
    checked_tape,
    load_profile,
    profile_text,
    stated_inclination,
    stated_tape,
)  # fmt: skip
from .user_file import read_bytes, title_of

ROUGH_CUTOFF = 4e-3  # what is shorter counts as roughness [m]
ROUGH = 5e-6  # rms from which smoothing is advised [m]
RAIL_REACH = 0.010  # running surface to both sides of the top that a table needs [m]
WHEEL_REACH = (-0.035, 0.020)  # running surface that a table needs: flange root and tread [m]
GAUGE_DEPTH = 0.014  # below the top, where gauge is measured [m]
RUNNING_SLOPE = np.tan(np.radians(60.0))
GAP = 3e-3  # between neighbouring points, from which the report warns [m]
LARGEST_SHIFT = 0.1  # of a wheel to the field side [m]
TREAD = (0.010, 0.040)  # y between which the slope of a tread is taken [m]
TREAD_USUAL = (0.020, 0.070)  # of cones 1:40 and 1:20, S1002 and worn ones; a wheel turned by 2 degrees is outside
FLANGE_USUAL = (0.025, 0.037)  # flange height, new and worn [m]
SIDE = 0.002  # a running surface that ends this near to the field side of a head ends with it [m]


@dataclass(frozen=True)
class ImportSettings:
    """What a user may decide; lengths in m.

    Attributes
    ----------
    kind, units : str or None
    mirror_y, mirror_z : "auto", "yes" or "no"
    shift_y : float
        Moves a wheel to the field side after its origin was found.
    smooth : float or None
        Cut-off wavelength.
    resample : float or None
        Distance of points.
    inclination : "included", "upright" or None
        How a rail stands in the file; None: as the file says, if it does.
    tape_to_back : float or None
        Of a wheel; None: as the file says, else 70 mm.
    """

    kind: str | None = None
    units: str | None = None
    mirror_y: str = "auto"
    mirror_z: str = "auto"
    shift_y: float = 0.0
    smooth: float | None = None
    resample: float | None = None
    inclination: str | None = None
    tape_to_back: float | None = None


@dataclass(frozen=True, eq=False)
class Imported:
    """A profile in the canonical form.

    Attributes
    ----------
    profile : Profile
    raw : Profile
        Before smoothing and resampling.
    account : dict
        What was found, decided and changed, and `unfit`: reasons why no contact table can be built; for machines.
    """

    profile: Profile
    raw: Profile = field(repr=False)
    account: dict = field(repr=False)


def import_profile(path, settings):
    """Read a file and `convert` it."""
    return convert(read_points(path), settings)


def convert(measured, settings):
    """The canonical profile of a file's points.

    Parameters
    ----------
    measured : Measured
    settings : ImportSettings

    Returns
    -------
    Imported

    Raises
    ------
    InputError
        The points cannot be made into a profile.
    """
    path = measured.path
    kind = find_kind(measured, settings.kind)
    tape = _tape(path, kind.choice, settings)
    aligned = align(measured, kind.choice, settings.units, settings.mirror_y, settings.mirror_z, tape)
    decisions = [kind, *aligned.decisions]
    y = aligned.y
    if settings.shift_y:
        if kind.choice == "rail":
            raise InputError("--shift-y", "is for wheels; a rail's origin is its highest point")
        if not abs(settings.shift_y) <= LARGEST_SHIFT:
            most = f"{LARGEST_SHIFT * 1e3:g} mm"
            raise InputError("--shift-y", f"is {settings.shift_y * 1e3:g} mm; allowed: -{most} to {most}")
        y = y + settings.shift_y
        decisions.append(Decision("shift y", f"{settings.shift_y * 1e3:g} mm", "given"))
    stands = _stands(path, kind.choice, settings)
    decisions += [stands] if stands else []
    curation = Curation(path, kind.choice, y, aligned.z, aligned.lines).run()
    raw = Profile.from_points(title_of(path), kind.choice, curation.y, curation.z, tape_to_back=tape)
    raw = raw.translated(*_to_origin(path, raw))
    _as_source(measured, raw, curation.lines)
    corners = curation.kinks()
    profile, smoothing, resampling = raw, None, None
    if settings.smooth:
        profile = smooth(title_of(path), kind.choice, raw.y, raw.z, settings.smooth, corners)
        smoothing = {
            "cutoff_mm": settings.smooth * 1e3,
            "largest_change": change(raw, profile),
            "largest_change_on_running_surface": change(raw, profile, _running_surface(profile)),
        }
    if settings.resample:
        before = profile
        profile = resample(profile, settings.resample)
        spacing = profile.arc[-1] / (profile.arc.size - 1)
        resampling = {"distance_mm": spacing * 1e3, "points": profile.y.size, "position_mm": _distance(before, profile)}
    if smoothing or resampling:
        move = _to_origin(path, profile)
        raw, profile = raw.translated(*move), profile.translated(*move)
        check_curve(path, kind.choice, profile.y * 1e3, profile.z * 1e3, np.arange(profile.y.size))
    profile = replace(profile, inclined=STANDS[stands.choice] if stands else None, tape_to_back=tape)
    decisions += _doubts(profile)
    account = {
        "file": str(path),
        "sha256": hashlib.sha256(read_bytes(path, "a profile file", LARGEST_FILE_MB)).hexdigest(),
        "format": measured.source,
        "kind": kind.choice,
        "points_read": int(measured.y.size),
        "points": int(profile.y.size),
        "notes": list(measured.notes),
        "decisions": [decision._asdict() for decision in decisions],
        "faults": [fault.as_dict() for fault in curation.faults.values()],
        "kinks": _places(raw, corners),
        "smoothing": smoothing,
        "resampling": resampling,
        "dimensions": dimensions(profile),
        "advice": _advice(profile, raw, corners, settings),
        "unfit": unfit(profile),
        "railcli": __version__,
    }
    return Imported(profile, raw, account)


def readable(path, settings):
    """Raise an InputError unless the file holds points and it is clear of what; its shape is not looked at."""
    find_kind(read_points(path), settings.kind)


def is_bundled(name):
    """True for the name of a bundled profile, upper or lower case."""
    return str(name).lower() in map(str.lower, BUNDLED)


def is_foreign(path, text):
    """True if a file is not of the canonical form but of a format that says of itself what it is."""
    return Path(path).suffix.lower() in ENDINGS or recognised(text) is not None


def can_import(path, kind):
    """True if a file can be made into a profile of this kind that is fit for a contact table."""
    try:
        return not import_profile(path, ImportSettings(kind=kind)).account["unfit"]
    except InputError:
        return False


def told(account):
    """One line on a file that was imported without being asked how."""
    chosen = {one["subject"]: one["choice"] for one in account["decisions"]}
    keys = ("units", "mirror y", "mirror z", "origin", "inclination")
    words = [f"{key} {chosen[key]}" for key in keys if key in chosen]
    dropped = sum(fault["points"] for fault in account["faults"] if fault["treatment"] == "dropped")
    words += [f"{dropped} points dropped"] if dropped else []
    doubts = [f"{one['choice']} {one['reason']}" for one in account["decisions"] if one["subject"] == WARNING]
    doubts += account["advice"]
    advice = f" Mind: {'; '.join(doubts)}." if doubts else ""
    line = f"Imported {account['file']} ({account['format']}) with default decisions: {', '.join(words)}.{advice}"
    line = "".join(letter if letter.isprintable() else "?" for letter in line)
    return f"{line} `railcli profile import` tells all and takes options."


def open_profile(name_or_path, settings):
    """A bundled profile by name, or the converted one of a file."""
    if not is_bundled(name_or_path):
        return import_profile(Path(name_or_path), settings)
    name = next(name for name in BUNDLED if name.lower() == str(name_or_path).lower())
    profile = load_profile(name, BUNDLED[name][0])
    account = {
        "file": name,
        "format": "bundled",
        "kind": profile.kind,
        "points": int(profile.y.size),
        "dimensions": dimensions(profile),
        "advice": [],
        "unfit": unfit(profile),
    }
    return Imported(profile, profile, account)


def stands_as_it_is(path, kind):
    """True if a table can be built from the file without import."""
    try:
        canonical(path, kind)
    except InputError:
        return False
    return True


def dimensions(profile):
    """Main dimensions [mm, degrees]; those that the profile does not have are missing."""
    found = {"y_mm": _ends(profile.y), "z_mm": _ends(profile.z)}
    if profile.kind == "wheel":
        try:
            flange = profile.flange_dimensions()
        except InputError:
            return found
        names = {"height": "flange_height_mm", "thickness": "flange_thickness_mm", "qr": "qr_mm", "width": "width_mm"}
        return found | {name: getattr(flange, key) * 1e3 for key, name in names.items()}
    found["head_width_mm"] = float(np.ptp(profile.y)) * 1e3
    found["lean_degrees"] = float(np.degrees(profile.lean))
    try:
        found["gauge_point_y_mm"] = profile.gauge_point()[0] * 1e3
    except InputError:
        pass
    return found


def unfit(profile):
    """Reasons, one line each, why no contact table can be built from a profile; empty: it is fit."""
    try:
        start, step, graph = profile.graph()
        end = start + step * (len(graph) - 1)
        profile.gauge_point() if profile.kind == "rail" else profile.flange_dimensions()
    except InputError as error:
        return [str(error)]
    if profile.kind == "rail":
        top = start + step * int(np.argmin(graph[:, 0]))
        low, high = top - RAIL_REACH, top + RAIL_REACH
        if start <= low and end < high and profile.y.max() - end < SIDE:
            if profile.lean > LEAN:
                return []
            return [
                f"{profile.name}: the head ends {(profile.y.max() - top) * 1e3:.4g} mm to the field side of its "
                f"highest point though it does not lean to the gauge side; at least {RAIL_REACH * 1e3:g} mm is needed: "
                "give the head from side to side, or correct --mirror-y"
            ]
    else:
        low, high = WHEEL_REACH
    if start > low or end < high:
        return [
            f"{profile.name}: the running surface, without a slope over 80 degrees, is y = {start * 1e3:.4g} to "
            f"{end * 1e3:.4g} mm; at least {low * 1e3:.4g} to {high * 1e3:.4g} mm is needed: smooth a rough profile"
        ]
    return []


def canonical_text(imported, settings):
    """The canonical file: comments that say where it is from, then y_mm, z_mm, angle_rad.

    The angles are left out where points are so rough that a reader would doubt them; it finds the same ones.
    """
    account, profile = imported.account, imported.profile
    origin = "the highest point of the head" if profile.kind == "rail" else "the tape circle"
    smoothed = f"cut-off wavelength {settings.smooth * 1e3:g} mm" if settings.smooth else "none"
    head = [
        f"# name: {profile.name}",
        f"# kind: {profile.kind}",
        *(f"# inclination: {word}" for word, inclined in STANDS.items() if profile.inclined is inclined),
        f"# axes: right-hand {profile.kind}, y to the field side, z down, origin at {origin}",
        *([f"# tape circle: {profile.tape_to_back * 1e3:.9g} mm from the flange back"] if profile.tape_to_back else []),
        f"# source: {Path(account['file']).name}, {account['format']}, SHA-256 {account['sha256']}",
        f"# smoothing: {smoothed}",
        f"# written by railcli {account['railcli']} profile import",
    ]
    head = ["".join(character if character.isprintable() else "?" for character in line) for line in head]
    rows = zip(profile.y * 1e3, profile.z * 1e3, profile.angle, strict=True)
    if _tangents_follow(profile):
        rows = [f"{y:.9f},{z:.9f},{angle:.12f}" for y, z, angle in rows]
        return "\n".join([*head, "y_mm,z_mm,angle_rad", *rows]) + "\n"
    return "\n".join([*head, "y_mm,z_mm", *(f"{y:.9f},{z:.9f}" for y, z, _ in rows)]) + "\n"


def write(imported, settings, place, report):
    """Write the canonical file at `place` and the account beside it, as JSON and as the text `report`."""
    write_text(place, canonical_text(imported, settings))
    write_json(beside(place, "json"), imported.account)
    write_text(beside(place, "txt"), report)


def beside(place, ending):
    """Where the account of the canonical file at `place` goes."""
    return place.with_name(f"{place.stem}.curation.{ending}")


def _doubts(profile):
    """Warning about a wheel that seems to stand turned in its file."""
    if profile.kind != "wheel":
        return []
    try:
        height = profile.flange_dimensions().height
    except InputError:
        return []
    ends = np.interp(TREAD, profile.y, profile.z)
    slope = float(ends[0] - ends[1]) / (TREAD[1] - TREAD[0])
    found = []
    if not FLANGE_USUAL[0] <= height <= FLANGE_USUAL[1]:
        usual = f"{FLANGE_USUAL[0] * 1e3:g} to {FLANGE_USUAL[1] * 1e3:g} mm"
        found.append(f"flange height {height * 1e3:.4g} mm, usual are {usual}")
    if TREAD[1] < profile.y[-1] and not TREAD_USUAL[0] <= slope <= TREAD_USUAL[1]:
        usual = f"{TREAD_USUAL[0] * 1e3:g} to {TREAD_USUAL[1] * 1e3:g}"
        found.append(
            f"the tread rises by {slope * 1e3:.3g} mm/m from {TREAD[0] * 1e3:g} to {TREAD[1] * 1e3:g} mm outside the "
            f"tape circle, usual are {usual}; one degree is 17.5 mm/m, and 1 mm of flange height"
        )
    if not found:
        return []
    return [Decision(WARNING, "turned?", f"{'; '.join(found)}: check how the instrument stood, or if it is so worn")]


def _running_surface(profile):
    """Nodes where wheels and rails run: slopes below 60 degrees, on a wheel from its flank to the field side, on a rail
    down to where gauge is measured."""
    flat = np.abs(np.tan(profile.angle)) < RUNNING_SLOPE
    if profile.kind == "rail":
        return flat & (profile.z - profile.z.min() < GAUGE_DEPTH)
    inner = profile.y < 0.0
    return flat & (profile.y > profile.y[np.argmin(np.where(inner, profile.angle, np.inf))])


def _tangents_follow(profile):
    try:
        check_angle(profile.name, profile.y, profile.z, profile.angle, np.arange(profile.y.size))
    except InputError:
        return False
    return True


def _as_source(measured, profile, lines):
    """Check the repaired points as those of a canonical file, with the lines of their source."""
    known = np.where(lines > 0, lines, lines.max())
    check_curve(measured.path, profile.kind, profile.y * 1e3, profile.z * 1e3, known)


def _to_origin(path, profile):
    """How far to move a profile [m] so that a rail's highest point or a wheel's tape circle is the origin."""
    if profile.kind == "rail":
        top = int(np.argmin(profile.z))
        y, z, *_ = profile.at(
            np.linspace(profile.arc[max(top - 1, 0)], profile.arc[min(top + 1, profile.arc.size - 1)], 401)
        )
        return -y[np.argmin(z)], -z.min()
    y = profile.y
    if not y[0] < 0.0 < y[-1]:
        raise InputError(path, "the profile does not reach the tape circle, y = 0")
    before = int(np.flatnonzero((y[:-1] <= 0.0) & (y[1:] > 0.0))[-1])
    sigma = np.interp(0.0, y[before : before + 2], profile.arc[before : before + 2])
    for _ in range(4):
        at_y, z, angle, _ = profile.at(sigma)
        sigma = sigma - at_y / max(np.cos(angle), 0.1)
    return 0.0, -float(z)


def _distance(before, after):
    """Largest distance of the nodes of one profile from the curve of another, across it [mm]."""
    sigma = before.arc * (after.arc[-1] / before.arc[-1])
    y, z, angle, _ = after.at(sigma)
    for _ in range(3):
        along = (before.y - y) * np.cos(angle) + (before.z - z) * np.sin(angle)
        sigma = np.clip(sigma + along, 0.0, after.arc[-1])
        y, z, angle, _ = after.at(sigma)
    across = (before.z - z) * np.cos(angle) - (before.y - y) * np.sin(angle)
    return float(np.abs(across).max()) * 1e3


def _tape(path, kind, settings):
    """Distance of a wheel's tape circle from its flange back [m]: as given, as the file says, else the usual one."""
    if kind != "wheel":
        if settings.tape_to_back is not None:
            raise InputError("--tape-to-back", "is for wheels")
        return None
    if settings.tape_to_back is not None:
        return checked_tape(settings.tape_to_back, "--tape-to-back")
    return stated_tape(profile_text(path), path) or TAPE_TO_BACK


def _stands(path, kind, settings):
    """Decision on how a rail stands in its file; None if nobody says."""
    if kind != "rail":
        if settings.inclination:
            raise InputError("--inclination", "is for rails")
        return None
    if settings.inclination:
        return Decision("inclination", settings.inclination, "given")
    found = stated_inclination(profile_text(path), path)
    return Decision("inclination", found, "as the file says") if found else None


def _places(profile, index):
    turn = np.degrees(np.diff(np.unwrap(np.arctan2(np.diff(profile.z), np.diff(profile.y)))))
    return [
        {"y_mm": float(profile.y[i]) * 1e3, "z_mm": float(profile.z[i]) * 1e3, "turn_degrees": float(turn[i - 1])}
        for i in index
    ]


def _ends(values):
    return [float(values.min()) * 1e3, float(values.max()) * 1e3]


def _advice(profile, raw, corners, settings):
    """What a user should know before a table is built."""
    advice = []
    if profile.kind == "rail" and profile.inclined is None and abs(lean := profile.lean) > LEAN:
        advice.append(
            f"the middle of the head leans by {abs(np.degrees(lean)):.2f} degrees to the "
            f"{'gauge' if lean > 0 else 'field'} side: if it was measured in the track, it has its inclination "
            "already; import it with --inclination included, or build the table with --inclination 0"
        )
    if profile.kind == "rail" and (beyond := float(profile.y.max())) < RAIL_REACH:
        advice.append(
            f"the head leans so that its highest point lies {beyond * 1e3:.3g} mm from its field side: no rail is "
            "beyond it, where a wheel may stand that moves far away from its flange"
        )
    wide = float(np.hypot(np.diff(raw.y), np.diff(raw.z)).max())
    if wide > GAP:
        advice.append(f"neighbouring points are up to {wide * 1e3:.2g} mm apart; what lies between is interpolated")
    smoothed = smooth(raw.name, raw.kind, profile.y, profile.z, ROUGH_CUTOFF, () if settings.resample else corners)
    across = (smoothed.z - profile.z) * np.cos(smoothed.angle) - (smoothed.y - profile.y) * np.sin(smoothed.angle)
    running = np.abs(np.tan(smoothed.angle)) < 1.0
    rough = float(np.sqrt(np.mean(across[running] ** 2))) if running.any() else 0.0
    if rough > ROUGH:
        advice.append(
            f"rough: {rough * 1e6:.3g} micrometres rms at wavelengths below {ROUGH_CUTOFF * 1e3:g} mm, which contact "
            "sees as curvature: consider --smooth 4 or more"
        )
    return advice
