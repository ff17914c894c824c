"""Tables as text."""


def columns(rows, header=(), indent="  "):
    """Lines of text with aligned columns: the first to the left, the others to the right.

    Parameters
    ----------
    rows : sequence of sequences of str
    header : sequence of str
    """
    rows = [tuple(header), *rows] if header else list(rows)
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        lines.append((indent + "  ".join(cells)).rstrip())
    return lines


def facts(pairs, indent="  "):
    """Lines of `name  value`, the values aligned to the left."""
    width = max(len(name) for name, _ in pairs)
    return [f"{indent}{name.ljust(width)}  {value}" for name, value in pairs]


def sectioned(head, sections, last):
    """Text of a head, sections of a title and lines each, and a last line, with empty lines between."""
    lines = [head]
    for title, body in sections:
        lines += ["", title, *body]
    return "\n".join([*lines, "", last])


def speed(metres_per_second, form="g"):
    """A speed in both units."""
    return f"{metres_per_second:{form}} m/s ({3.6 * metres_per_second:.4g} km/h)"


def conditions(scenario):
    """What decides a result beside vehicle and track, as `facts`: speed, friction, laws, and what was changed."""
    run, contact = scenario.run, scenario.contact
    if run.course is None:
        asked = speed(run.speed)
    else:
        asked = f"{min(run.course.speed):g} to {speed(run.speed)}, over time"
    if scenario.is_free:
        asked = f"{speed(scenario.first_speed)} at the beginning"
    falls = (
        f", falling with the speed of sliding to {contact.friction * contact.friction_ratio:.3g}"
        if contact.friction_decay > 0.0
        else ""
    )
    pairs = [
        ("speed", asked),
        ("friction", _of_line(scenario.adhesion) if scenario.adhesion else f"{contact.friction:g}{falls}"),
        ("laws", f"creep {contact.creep_law}, normal {contact.normal}"),
    ]
    return [*pairs, ("changed", "; ".join(scenario.changes))] if scenario.changes else pairs


def _of_line(adhesion):
    """The stretches of a line in words."""
    words = []
    for stretch in adhesion.stretches:
        name = " ".join([*([stretch.set] if stretch.set else []),
                         *([f"{stretch.friction:g}"] if stretch.friction is not None else [])])  # fmt: skip
        words.append(f"{name} from {stretch.start:g} m" if stretch.start else name)
    return ", ".join(words)


def conditions_json(scenario):
    """As `conditions`, for a machine; units in the names."""
    return {
        "speed_m_per_s": scenario.run.speed,
        "speed_kmh": 3.6 * scenario.run.speed,
        "friction": None if scenario.adhesion else scenario.contact.friction,
        "creep_law": scenario.contact.creep_law,
        "normal": scenario.contact.normal,
        "changes": list(scenario.changes),
    }
