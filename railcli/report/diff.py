"""The comparison of two results for readers: what differs, where, by how much."""

from .settings import differing, shown
from .text import columns, facts

FEW = 8  # names of channels in a line
ORIGIN = ("railcli", "kernels", "python", "numpy", "numba", "platform", "cpu")


def text(one, two, found, tolerances, most):
    """Lines for the terminal.

    Parameters
    ----------
    one, two : Results
    found : Comparison
    tolerances : Tolerances
    most : int
        Channels that are printed.
    """
    lines = []
    pairs = [(name, sampling_text(run, when)) for name, run, when in zip("AB", (one, two), found.sampling, strict=True)]
    lines += facts(pairs, indent="")
    for title, tables in (
        ("Settings", (one.settings, two.settings)),
        ("Origin", [{key: run.provenance.get(key) for key in ORIGIN} for run in (one, two)]),
    ):
        if rows := differing(tables):
            lines += [f"{title} that differ:", *columns([tuple(map(shown, row)) for row in rows], ("", "A", "B"))]
    if not found.same_instants:
        count = f"{found.time.size:,}" if found.time.size else "no"
        lines.append(f"Sampling differs: {count} instants that both have; values are compared only there.")
    for names, which in ((found.only_one, "A"), (found.only_two, "B")):
        if names:
            lines.append(f"Only in {which}: {_few(names)}")
    lines += [f"Units differ: {name} is in {a} in A, in {b} in B" for name, a, b in found.units_differ]
    lines.append(
        f"Compared: {len(found.differences):,} channels at {found.time.size:,} instants; tolerance: "
        f"{tolerances.relative:g} of a channel's range in A, at least {_absolute(found, tolerances)}"
    )
    if found.of_intervals:
        lines.append(f"Not compared: {found.of_intervals:,} channels of means and extremes, of intervals that differ.")
    worst = found.beyond
    if worst and most:
        lines.append("Channels that differ, the worst first:" if len(worst) <= most else
                     f"Channels that differ, the worst {most} of {len(worst):,}:")  # fmt: skip
        header = ("", "largest", "allowed", "unit", "at t [s]", "s [m]", "A", "B", "rows", "one only", "from t [s]")
        lines += columns([_row(item, found) for item in worst[:most]], header)
    return [*lines, f"Verdict: {verdict(found)}"]


def sampling_text(run, when):
    """`folder: 1,556 rows, every 10 ms from 0.01 to 15.56 s`."""
    name = run.settings.get("name", "")
    every = f", every {1e3 * when.interval:.6g} ms from {when.first:.6g} to {when.last:.6g} s" if when.rows > 1 else ""
    return f"{run.folder}{f' ({name})' if name else ''}: {when.rows:,} rows{every}"


def verdict(found):
    """One sentence: the same, or what differs most."""
    reasons = []
    if worst := found.beyond:
        first = worst[0]
        reasons.append(
            f"{len(worst):,} of {len(found.differences):,} channels differ beyond tolerance, most {first.name}: "
            f"{_size(first)} at t = {found.time[first.row]:.6g} s, s = {found.place[first.row]:.2f} m"
        )
    if found.units_differ:
        reasons.append(f"units of {len(found.units_differ)} channels differ")
    if not found.differences:
        reasons.append("they have no channel or no instant in common")
    if not found.common:
        if not found.same_instants:
            reasons.append("they were recorded at different instants")
        if alone := len(found.only_one) + len(found.only_two):
            reasons.append(f"{alone:,} channels are in one of them only")
    if reasons:
        return "; ".join(reasons)
    if all(item.largest == 0.0 for item in found.differences):
        return "the same, every value bit for bit"
    largest = max(found.differences, key=lambda item: item.excess)
    share = f"{largest.excess:.2g} of its tolerance"
    return f"the same within tolerance; nearest to it: {largest.name}, {_size(largest)}, {share}"


def as_json(one, two, found, tolerances):
    """Everything that was found, for a machine; SI."""
    return {
        "A": _about(one, found.sampling[0]),
        "B": _about(two, found.sampling[1]),
        "differs": found.differs,
        "verdict": verdict(found),
        "settings": [dict(zip(("key", "A", "B"), row, strict=True)) for row in differing((one.settings, two.settings))],
        "only_A": found.only_one,
        "only_B": found.only_two,
        "units_differ": [dict(zip(("channel", "A", "B"), row, strict=True)) for row in found.units_differ],
        "instants": found.time.size,
        "relative": tolerances.relative,
        "absolute": tolerances.absolute,
        "compared": len(found.differences),
        "not_compared_of_intervals": found.of_intervals,
        "channels": [
            {
                "channel": item.name,
                "unit": item.units,
                "largest": item.largest,
                "tolerance": item.tolerance,
                "range": item.extent,
                "time_s": found.time[item.row],
                "s_m": found.place[item.row],
                "A": item.one,
                "B": item.two,
                "rows_beyond": item.beyond,
                "rows_in_one_only": item.one_sided,
                "first_time_s": found.time[item.first_row],
            }
            for item in found.beyond
        ],
    }


def _about(run, when):
    return {"folder": run.folder, "rows": when.rows, "from_s": when.first, "to_s": when.last,
            "interval_s": when.interval}  # fmt: skip


def _row(item, found):
    return (
        item.name, f"{item.largest:.3g}", f"{item.tolerance:.2g}", item.units, f"{found.time[item.row]:.6g}",
        f"{found.place[item.row]:.2f}", f"{item.one:.6g}", f"{item.two:.6g}", f"{item.beyond:,}",
        f"{item.one_sided:,}", f"{found.time[item.first_row]:.6g}",
    )  # fmt: skip


def _size(item):
    if item.one_sided and item.excess <= 1.0:
        return f"only one of them has a value in {item.one_sided:,} rows, first"
    return f"{item.largest:.3g} {item.units}".removesuffix(" -")


def _absolute(found, tolerances):
    units = sorted({item.units for item in found.differences}, key=lambda unit: (unit == "-", unit))
    return ", ".join(f"{tolerances.absolute.get(unit, 0.0):g} {unit}".removesuffix(" -") for unit in units) or "nothing"


def _few(names):
    rest = len(names) - FEW
    return ", ".join(names[:FEW]) + (f" and {rest:,} more" if rest > 0 else "")
