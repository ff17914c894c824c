"""The certificates of a contact table for readers: the errors of its look-up in geometry and in forces."""

from railcli.analysis.certify_forces import AIMS, COUNTED, DEPTHS, OFF, SIZES, beyond_aims

from .text import columns

QUANTITIES = {  # channel of the certificate: name, unit
    "gap_um": ("distance D", "um"),
    "position_mm": ("position", "mm"),
    "angle_mrad": ("contact angle", "mrad"),
    "radius_um": ("rolling radius", "um"),
}
FORCES = {  # channel of the certificate of forces: name, unit
    "normal_percent": ("resultant N", "%"),
    "lateral_percent": ("lateral Y", "% of N"),
    "vertical_percent": ("vertical Q", "% of N"),
    "centre_mm": ("load centre", "mm"),
    "radius_mm": ("rolling radius", "mm"),
}


def certificate_lines(certificate):
    """The error of look-up as tables of text, of what was measured."""
    lines = _of_geometry(certificate) if "gap_um" in certificate else []
    forces = certificate.get("forces", {})
    return lines + (_of_forces(certificate, forces) if "normal_percent" in forces else [])


def _of_geometry(certificate):
    names = {key: f"{name} [{unit}]" for key, (name, unit) in QUANTITIES.items()}
    parts = [
        (part, f"{count:,}", *(_sizes(certificate[key]["by_region"][part], 2) for key in QUANTITIES))
        for part, count in certificate["contacts"].items()
    ]
    return [
        f"Error of look-up against direct minimisation at {certificate['poses']:,} random poses "
        f"(seed {certificate['seed']}), loaded branches:",
        *_errors(certificate, names),
        "By part of the wheel profile, p99 / p99.9:",
        *columns(parts, ("", "contacts", *names.values())),
        f"  {certificate['near_end_share']:.2%} of the contact points lie within one cell of a branch's end: they are "
        "counted apart and left out",
        f"  elsewhere missed: {certificate['missed']}, invented: {certificate['invented']}, poses with more contacts "
        f"than a wheel keeps: {certificate['overfull']}",
    ]


def _of_forces(certificate, forces):
    names = {key: f"{name} [{unit}]" for key, (name, unit) in FORCES.items()}
    low, high = (depth * 1e6 for depth in DEPTHS)
    parts = [
        (part, f"{count:,}", *(_sizes(forces[key]["by_region"][part]) for key in FORCES))
        for part, count in forces["by_region"].items()
    ]
    return [
        f"Error of forces by look-up against the same law evaluated directly, {low:g} to {high:g} um beyond first "
        f"touch, at {forces['compared']:,} random poses (seed {certificate['seed']}), ends of branches included:",
        *_errors(forces, names),
        "By the part of the wheel that bears most, p99 / p99.9 / max:",
        *columns(parts, ("", "poses", *names.values())),
        f"  resultant off by more than {OFF:g} %: {forces['off_share']:.2%} of the poses",
        f"  patches with more than {COUNTED:.0%} of the load missed: {forces['missed']}, invented: "
        f"{forces['invented']}; poses refused: {forces['refused']}",
        *aim_lines(forces),
    ]


def aim_lines(forces):
    """Which aims of p99, p99.9 and largest error are kept."""
    aims = "; ".join(
        f"{FORCES[key][0]} {' / '.join(f'{aim:g}' for aim in sizes)} {FORCES[key][1]}" for key, sizes in AIMS.items()
    )
    beyond = beyond_aims(forces)
    if not beyond:
        return [f"Aims of p99 / p99.9 / max: {aims}: all kept"]
    missed = []
    for key in AIMS:
        where = [part or "overall" for quantity, part in beyond if quantity == key]
        if where:
            missed.append(f"{FORCES[key][0]}: {', '.join(where)}")
    return [f"Aims of p99 / p99.9 / max: {aims}: missed by {'; '.join(missed)}"]


def _errors(certificate, names):
    rows = []
    for key, name in names.items():
        error = certificate[key]
        at = error["worst_at"]
        worst = f"y {at['y_mm']:+.2f} mm, roll {at['roll_mrad']:+.2f} mrad, yaw {at['yaw_mrad']:+.2f} mrad"
        if "depth_um" in at:
            worst += f", {at['depth_um']:.0f} um"
        rows.append((name, *(f"{error[size]:.3g}" for size in SIZES), worst))
    return columns(rows, ("", "p99", "p99.9", "max", "worst at"))


def _sizes(error, count=3):
    return " / ".join(f"{error[size]:.2g}" for size in SIZES[:count])
