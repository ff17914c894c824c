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
