"""The account of an imported track geometry, as text."""

from railcli.analysis.track_quality import NOT_CONSULTED

from .text import columns, facts
from .track import radius_text


def lines(imported):
    """Lines of the report; `imported` as files.track_import gives it."""
    account, text = imported.account, []
    for path, decisions in account["decisions"].items():
        text += [f"{path}", *facts([(one["subject"], f"{one['choice']} ({one['reason']})") for one in decisions])]
    if "alignment" in account:
        found = account["alignment"]
        where = f"{found['from_m']:.10g} to {found['to_m']:.10g} m"
        text += ["", f"Alignment, {where}, {found['positions']} positions; found in it:"]
        rows = [(one["kind"], f"{one['from_m']:.10g}", f"{one['to_m']:.10g}", radius_text(one["curvature_1_per_m"]))
                for one in found["sections"]]  # fmt: skip
        text += columns(rows, ("section", "from [m]", "to [m]", "mean radius [m]"))
    if "irregularity" in account:
        found = account["irregularity"]
        text += ["", f"Irregularity, {found['from_m']:.10g} to {found['to_m']:.10g} m, {found['samples']} samples:"]
        text += columns([_row(row) for row in imported.quality],
                        ("", "band", "rms", "lowest", "highest", "", "largest at", "range k", ""))  # fmt: skip
        text.append(f"  k: {NOT_CONSULTED}")
    return text


def for_scenario(imported):
    """The tables of a scenario that take the files which were written."""
    text = ["In a scenario beside them:"]
    if imported.alignment:
        text += ["  [[track]]", '  kind = "measured"', '  file = "alignment.csv"']
    if imported.samples:
        text += ["  [[irregularity]]", '  kind = "measured"', '  file = "irregularity.csv"']
        text += ['  # with vertical_positive = "down" or lateral_positive = "left" if the recording counts so']
    return text


def _row(row):
    unit = "mm/m" if row.quantity == "twist" else "mm"
    name = f"{row.quantity}, {row.side}" if row.side else row.quantity
    numbers = (f"{1e3 * value:.3g}" for value in (row.rms, row.lowest, row.highest))
    return (name, row.band, *numbers, unit, f"{row.at:.8g} m", f"{1e3 * row.low:g} to {1e3 * row.high:g}",
            row.words or "within")  # fmt: skip
