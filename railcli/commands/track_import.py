"""`railcli track import`: recordings of track geometry to canonical tables."""

import re
from pathlib import Path

import click

from .options import format_option, output_option, overwrite_option
from .terminal import tell

LONGEST_CHORD = 100.0  # [m]


@click.command("import", short_help="Convert recordings of track geometry.")
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
@click.option("--chord", metavar="M", help="Chord of its versines, or its two parts: 20 or 4,6.")
@click.option("--bridge", type=click.FloatRange(0.0, 1000.0), default=0.0, metavar="M",
              help="Longest dropout over which a curve is drawn.  [default: none]")  # fmt: skip
@click.option("--gauge", type=click.FloatRange(500.0, 2000.0), default=1435.0, show_default=True, metavar="MM",
              help="Nominal gauge, from which an absolute one is counted.")  # fmt: skip
@click.option("--cross-level", type=click.Choice(["found", "absolute", "relative"]), default="found", show_default=True,
              help="Whether cross-levels hold the cant.")  # fmt: skip
@output_option("a new folder in railcli-out")
@overwrite_option
@format_option
def import_(files, chord, bridge, gauge, cross_level, output, overwrite, output_format):
    """Convert recordings of track geometry to alignment.csv and irregularity.csv, and judge them.

    One file or several, with alignment (curvature, radius or versine; cant, gradient, gauge), irregularity (level and
    alignment of each rail or their means, gauge, cross-level), or both. Units, separators, decimal commas, dropouts,
    rounded positions and absolute values are found; every decision is printed and written beside the tables. Files are
    brought together by their own positions. Scenarios read the same files without import; this shows what they see.

    \b
    Examples:
      railcli track import coach.csv
      railcli track import alignment.csv coach.csv --bridge 5 -o line
      railcli track import versines.csv --chord 20 -o line
    """
    from railcli.files.irregularity import Asked
    from railcli.files.output import results_folder, write_json, write_text
    from railcli.files.track_import import import_track, write
    from railcli.report import track_import as report

    parts = _parts(chord)
    asked = Asked(parts, bridge, gauge / 1e3, cross_level)
    imported = import_track(files, asked, sum(parts) if parts else None)
    text = report.lines(imported)
    with results_folder("track", files[0].stem, output, overwrite) as folder:
        written = write(imported, folder)
        write_json(folder / "import.json", imported.account)
        write_text(folder / "import.txt", "\n".join(text) + "\n")
    names = ", ".join(path.name for path in written)
    last = f"Written to {folder}: {names}, import.json, import.txt"
    tell({**imported.account, "written": written}, [*text, "", *report.for_scenario(imported), last], output_format)


def _parts(text):
    """Both parts of a chord [m] from `20` or `4,6`; None without one."""
    if text is None:
        return None
    match = re.fullmatch(r"\s*(\d+\.?\d*)\s*(?:,\s*(\d+\.?\d*)\s*)?", text)
    lengths = [float(one) for one in match.groups() if one] if match else []
    if not lengths or not all(0.1 <= one <= LONGEST_CHORD for one in lengths):
        raise click.BadParameter(f"{text!r}: give a length such as 20, or two parts such as 4,6, each 0.1 to "
                                 f"{LONGEST_CHORD:g} m", param_hint="'--chord'")  # fmt: skip
    return tuple(lengths) if len(lengths) == 2 else (lengths[0] / 2.0,) * 2
