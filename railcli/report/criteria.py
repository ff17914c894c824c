"""What the validations share: criteria, the verdict, and the report as a document."""

from .text import columns


def words(row):
    """What a `Row` amounts to."""
    if row.counts:
        return "kept" if row.kept else "MISSED"
    return "shown, kept" if row.kept else "shown, missed"


def criteria_lines(rows):
    """Every criterion with what was found."""
    cells = [(row.name, f"{row.found:.2g}", f"{row.limit:.3g}", words(row)) for row in rows]
    return columns(cells, ("criterion", "found", "limit", ""))


def criteria_json(rows):
    """The same for a machine."""
    return [
        {"name": row.name, "found": row.found, "limit": row.limit, "kept": row.kept, "counts": row.counts}
        for row in rows
    ]


def verdict(rows):
    return "accepted" if all(row.kept for row in rows if row.counts) else "rejected"


def verdict_line(rows):
    """One line: the verdict and what it rests on."""
    counted = [row for row in rows if row.counts]
    kept = sum(row.kept for row in counted)
    return f"Verdict: {verdict(rows)} ({kept} of {len(counted)} criteria that count are kept)"


def document(title, line, sections, figures, origin):
    """A report as Markdown.

    Parameters
    ----------
    title, line : str
        Heading, and the verdict below it.
    sections : sequence of (str, list of str)
        Titles and lines.
    figures : sequence of str
        Names of PNG files beside it.
    origin : dict
        As `files.provenance.provenance`.
    """
    lines = [f"# {title}", "", f"**{line}**"]
    for name, body in sections:
        lines += ["", f"## {name}", "", "```text", *body, "```"]
    if figures:
        lines += ["", "## Figures", ""]
        lines += [f"![{name}]({name}.png)" for name in figures]
    versions = ", ".join(f"{name} {origin[name]}" for name in ("railcli", "kernels", "python", "numpy", "numba"))
    lines += ["", "## Origin", "", f"{versions}, {origin['cpu']}, {origin['date']}"]
    return "\n".join(lines) + "\n"
