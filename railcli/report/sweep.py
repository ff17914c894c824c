"""A parameter study for people: what was varied, how runs ended, what came out."""

import numpy as np

from . import sensitivity
from .text import columns, facts

SHOWN = 12  # outputs that are shown if none are chosen
CAUSES = 5
FIRST = (  # outputs that are shown and drawn first
    "assessment.Y_Q", "assessment.sum_Y_kN", "assessment.Q_max_kN", "assessment.wear_wheel_N",
    "assessment.ay_max_m_per_s2", "assessment.N_MV", "steady.Y_Q_largest", "steady.W1_y_mm", "steady.W1_yaw_mrad",
    "steady.W1_Y_outer_kN", "steady.W1_Q_outer_kN", "steady.W1_sum_Y_kN", "end.Y_Q_largest", "end.W1_y_mm",
)  # fmt: skip
APART = ("run", "status", "verdict", "cause", "cpu_s", "time_s")


def outputs_of(table, design):
    """Names of the outputs of a table of rows."""
    return [name for name in table.columns if name not in APART and name not in design.names]


def shown(study, design, table, most=SHOWN):
    """Outputs to show: those that the study chooses, else the first ones that were formed."""
    from fnmatch import fnmatchcase

    formed = [name for name in outputs_of(table, design) if table[name].notna().any()]
    if study.figures:
        return [name for name in formed if any(name == one or fnmatchcase(name, one) for one in study.figures)]
    first = [name for name in formed if "[" in name]
    first += [name for name in FIRST if name in formed]
    return [*first, *(name for name in formed if name not in first)][:most]


def numbers(table, name):
    """A column as floats (n,), NaN where there is none; None for texts."""
    try:
        return table[name].to_numpy(float)
    except (TypeError, ValueError):
        return None


def how_varied(parameter):
    """In words."""
    if parameter.values is not None:
        some = [str(value) if not isinstance(value, float) else f"{value:g}" for value in parameter.values]
        return ", ".join(some) if len(some) <= 6 else f"{some[0]}, {some[1]}, ... {some[-1]}: {len(some)} values"
    if parameter.first is not None:
        by = f"in {parameter.count} values" if parameter.count else f"by {parameter.step:g}"
        return f"{parameter.first:g} to {parameter.last:g} {by}"
    more = ", ".join(
        f"{name} {getattr(parameter, name):g}" for name in ("mean", "sd", "median", "factor", "mode")
        if getattr(parameter, name) is not None
    )  # fmt: skip
    return f"{parameter.distribution}, {parameter.min:g} to {parameter.max:g}{f', {more}' if more else ''}"


def counts(table):
    """How runs ended, and verdicts: numbers by word."""
    ends = {word: int((table["status"] == word).sum()) for word in ("done", "failed")}
    verdicts = {word: int((table["verdict"] == word).sum()) for word in ("pass", "warn", "fail")}
    return ends, {word: number for word, number in verdicts.items() if number}


def causes(table):
    """Why runs failed: sentence -> numbers of runs, the most frequent first."""
    failed = table[table["status"] == "failed"]
    found = {}
    for number, cause in zip(failed["run"], failed["cause"], strict=True):
        found.setdefault(cause, []).append(int(number))
    return dict(sorted(found.items(), key=lambda one: -len(one[1])))


def overview(study, scenario, design, table):
    """Facts of a study: name and text."""
    ends, verdicts = counts(table)
    failed = f", {ends['failed']:,} failed" if ends["failed"] else ""
    pairs = [("scenario", f"{scenario.name}: {scenario.title}" if scenario.title else scenario.name)]
    pairs += [("varied" if k == 0 else "", f"{one.name}: {how_varied(one)}") for k, one in enumerate(study.parameters)]
    if study.sample:
        sample = study.sample
        pairs.append(("sample", f"{sample.method}, {sample.count:,} points, seed {sample.seed}"))
    if study.seeds is not None:
        count = study.seeds if isinstance(study.seeds, int) else len(study.seeds)
        pairs.append(("seeds", f"{count} of irregularity"))
    pairs.append(("runs", f"{ends['done']:,} of {design.count:,} done{failed}"))
    if verdicts:
        pairs.append(("verdicts", ", ".join(f"{number:,} {word}" for word, number in verdicts.items())))
    cpu = table["cpu_s"].to_numpy(float)
    if cpu.size:
        pairs.append(("CPU time", f"{cpu.sum():.4g} s, {np.median(cpu):.3g} s a run (median)"))
    return pairs


def ranges(names, table):
    """Of outputs: name, least, median and greatest value, and the runs of the extremes."""
    found = []
    for name in names:
        x = numbers(table, name)
        if x is None or np.isnan(x).all():
            continue
        low, high = int(np.nanargmin(x)), int(np.nanargmax(x))
        found.append((name, x[low], float(np.nanmedian(x)), x[high], int(table["run"][low]), int(table["run"][high])))
    return found


def lines(study, scenario, design, table, found):
    """Lines for the terminal; found : as `sensitivity.indices`."""
    told = [f"{study.name}: {study.title}" if study.title else study.name]
    told += facts(overview(study, scenario, design, table))
    rows = [
        (name, *(f"{value:.4g}" for value in values), f"{low:,}", f"{high:,}")
        for name, *values, low, high in ranges(shown(study, design, table), table)
    ]
    if rows:
        told += ["", "Outputs", *columns(rows, ("", "least", "median", "greatest", "least in run", "greatest in run"))]
    hidden = len(outputs_of(table, design)) - len(rows)
    if rows and hidden > 0:
        told.append(f"  and {hidden} more in the tables")
    if found:
        inputs = [one.name for one in study.parameters if one.is_sampled]
        title = "Sobol indices: S1, and ST behind the stroke where the sample gives it, with 95 % intervals"
        told += ["", title, *columns(sensitivity.rows(inputs, found), ("", *inputs))]
    if failed := causes(table):
        told += ["", "Failed runs"]
        for cause, runs in list(failed.items())[:CAUSES]:
            some = ", ".join(map(str, runs[:5])) + (" ..." if len(runs) > 5 else "")
            told.append(f"  {len(runs):,} (run{'s' * (len(runs) > 1)} {some}): {cause}")
    return told


def summary(study, scenario, design, table, found):
    """As `lines`, for a machine."""
    ends, verdicts = counts(table)
    return {
        "study": study.name,
        "title": study.title,
        "scenario": scenario.name,
        "runs": design.count,
        **ends,
        "verdicts": verdicts,
        "cpu_s": float(table["cpu_s"].sum()),
        "outputs": {
            name: {"least": low, "median": middle, "greatest": high, "run_of_least": first, "run_of_greatest": last}
            for name, low, middle, high, first, last in ranges(outputs_of(table, design), table)
        },
        "indices": {name: one._asdict() for name, one in found.items()},
        "causes": {cause: len(runs) for cause, runs in causes(table).items()},
    }
