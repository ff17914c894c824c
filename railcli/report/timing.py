"""Timed calls and stages for readers: the report of `railcli rt-bench`, its histogram and its stage bars."""

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from .figures import BLUE, GREEN, GREY, ORANGE, VERMILION, draw
from .text import columns, facts, speed

BINS_PER_DECADE = 40
SAMPLES = {"call": "call", "wake_up": "wake-up", "wake_up_and_call": "wake-up and call"}
COLOURS = {"call": BLUE, "wake_up": GREEN, "wake_up_and_call": ORANGE}
PERCENTILES = {"p50": "p50", "p95": "p95", "p99": "p99", "p999": "p99.9", "max": "max"}
STAGES = {
    "track": "track: frames, poses, velocities",
    "suspension": "suspension",
    "contact": "contact: table, normal forces",
    "creep": "creep: slip, creep forces",
    "integration": "integration: accelerations, rates",
}
WHY_NOT_THE_SUM = (
    "The stages do not add up to the step: a stage alone keeps its data and its branches at hand, two passes of it",
    "overlap or wait for one another otherwise than two stages do, and a step also keeps and moves its state.",
)


def histogram(*samples):
    """Counts of some samples [us] in common bins of equal width on a logarithmic axis.

    Returns
    -------
    edges : array (n + 1,)
        [us]
    counts : list of array (n,)
    """
    low = min(values.min() for values in samples)
    high = max(values.max() for values in samples)
    first = np.floor(np.log10(max(low, 1e-3)) * BINS_PER_DECADE)
    last = max(np.ceil(np.log10(max(high, 1e-3)) * BINS_PER_DECADE), first + 1)
    edges = 10.0 ** (np.arange(first, last + 1) / BINS_PER_DECADE)
    edges[-1] = max(edges[-1], high)
    return edges, [np.histogram(np.maximum(values, edges[0]), edges)[0] for values in samples]


def histogram_csv(samples):
    """Text of a CSV file: edges of the bins [us] and the counts of each of the named samples."""
    edges, counts = histogram(*samples.values())
    lines = [",".join(["from_us", "to_us", *samples])]
    for k in range(edges.size - 1):
        lines.append(",".join([f"{edges[k]:.6g}", f"{edges[k + 1]:.6g}", *(str(count[k]) for count in counts)]))
    return "\n".join(lines) + "\n"


def _time(us):
    return f"{us:.2f}" if us < 100.0 else f"{us:,.0f}"


def _row(name, percentiles):
    return (name, *(_time(percentiles[key]) for key in PERCENTILES))


def verdict(found):
    """Sentences: how many calls missed the budget; paced, how many ended after the next one was due."""
    count, budget = f"of {found['calls']:,} calls", f"{found['budget_ms']:g} ms"
    sentences = [f"{found['over_budget']:,} {count} over the budget of {budget}"]
    if found["paced"]:
        sentences.append(f"{found['paced']['late']:,} {count} ended later than {budget} after they were due")
    return sentences


def summary(found):
    """Lines of the report.

    Parameters
    ----------
    found : dict
        What `rt-bench` found, as it is written to JSON.
    """
    kept, source, real_time = found["kept_state"], found["provenance"], found["real_time"]
    load = found["machine"]["load_average"]
    cores = f"{found['machine']['cores']} cores"
    clocks = [
        f"{clock['clock']}, smallest step seen {clock['smallest_step_seen_ns']:g} ns"
        for clock in found["clocks"].values()
    ]
    back = {0: "not needed here", 1: "once"}.get(found["rewinds"], f"{found['rewinds']:,} times")
    pairs = [
        ("scenario", f"{found['scenario']}, {speed(found['speed_ms'])}"),
        ("rails", f"friction {found['friction']:g}, creep law {found['creep_law']}, normal law {found['normal']}"),
        ("kept state", f"t = {kept['time_s']:.2f} s, s = {kept['distance_m']:.1f} m, {_loaded(kept['patches'])}"),
        ("from there", f"{found['lap_s']:.4g} s to the end, then on from the kept state again ({back})"),
        ("calls", _calls(found)),
        ("step", _step(found["step"])),
        ("processor", ", ".join([source["cpu"], cores, *([f"load average {load[0]:.2f}"] if load else [])])),
        ("system", source["platform"]),
        ("versions", ", ".join(f"{name} {source[name]}" for name in ("railcli", "python", "numpy", "numba"))),
        ("wall clock", clocks[0]),
        ("processor clock", clocks[1]),
        ("real-time scheduling", real_time["scheduling"]),
        ("memory lock", real_time["memory"]),
    ]
    rows = [_row("call", found["step_us"])]
    if found["paced"]:
        rows.append(_row("wake-up", found["paced"]["wake_up_us"]))
        rows.append(_row("wake-up and call", found["paced"]["response_us"]))
    factor = found["real_time_factor_range"]
    return [
        f"Real-time benchmark: {found['title'] or found['scenario']}",
        *facts(pairs),
        f"Wall time of a call that advances {found['budget_ms']:g} ms [us], of which a call of no steps takes "
        f"{found['call_overhead_us']:.2f}:",
        *columns(rows, ("", *PERCENTILES.values())),
        f"Real-time factor: {found['real_time_factor']:.0f} (median; {factor[0]:.0f} to {factor[1]:.0f}), simulated "
        f"time over processor time of {found['batches']} batches of {found['batch_s']:g} s",
        f"One pass of each stage, of which each step of {found['step_ms']:g} ms makes one [us]:",
        *columns(_stage_rows(found), ("", "median", "min")),
        *(f"  {line}" for line in WHY_NOT_THE_SUM),
        f"Verdict: {'; '.join(verdict(found))}",
    ]


def _step(step):
    how = "chosen" if step["chosen"] else "given"
    return f"{step['step_ms']:.4g} ms, {how}; at most {step['longest_ms']:g} ms for {step['limited_by']}"


def _loaded(patches):
    return f"{sum(patches)} contact patches loaded on {sum(n > 0 for n in patches)} of {len(patches)} wheels"


def _calls(found):
    steps = f"{found['steps_per_call']} step{'s' if found['steps_per_call'] > 1 else ''} of {found['step_ms']:g} ms"
    order = "paced by the clock" if found["paced"] else "back to back"
    warm_up = f"after {found['warm_up_calls']:,} to warm up"
    return f"{found['calls']:,} of {found['budget_ms']:g} ms ({steps}), {order}, {warm_up}"


def _stage_rows(found):
    median, least, whole = found["stages_us"], found["stages_min_us"], found["whole_step_us"]
    rows = [(STAGES[key], f"{median[key]:.3f}", f"{least[key]:.3f}") for key in STAGES]
    rows.append(("sum", f"{sum(median.values()):.3f}", f"{sum(least.values()):.3f}"))
    rows.append(("whole step", f"{whole['median']:.3f}", f"{whole['min']:.3f}"))
    return rows


def plot_histogram(found, samples, path):
    """Draw how often each wall time was seen, with the percentiles of the calls and the budget.

    Parameters
    ----------
    found : dict
        As for `summary`.
    samples : dict of str to array
        Keys of SAMPLES: measured times [us].
    path : path-like
        File of the figure.
    """
    edges, counts = histogram(*samples.values())
    budget = found["budget_ms"] * 1e3

    def paint(figure):
        axis = figure.add_subplot()
        for name, count in zip(samples, counts, strict=True):
            filled, alpha = name == "call", 0.6 if name == "call" else 1.0
            axis.stairs(count, edges, color=COLOURS[name], fill=filled, alpha=alpha, label=SAMPLES[name])
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.xaxis.set_minor_formatter(NullFormatter())
        for direction in (axis.xaxis, axis.yaxis):
            direction.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,g}"))
        axis.set_ylim(0.7, 3.0 * max(count.max() for count in counts))
        _mark_percentiles(axis, found["step_us"])
        axis.axvline(budget, color=VERMILION, linewidth=1.6, label=f"budget {budget:,g} us")
        axis.set_title("\n".join([found["scenario"], *verdict(found)]))
        axis.set_xlabel(f"wall time [us]; each call advances {found['budget_ms']:g} ms")
        axis.set_ylabel("calls")
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=len(samples) + 1)

    draw(paint, path, (9.0, 5.0))


def _mark_percentiles(axis, percentiles):
    """Lines at the percentiles of the calls; labels at different heights, as the lines are often close."""
    for number, (key, name) in enumerate(PERCENTILES.items()):
        axis.axvline(percentiles[key], color=GREY, linewidth=0.9, linestyle="--")
        axis.annotate(
            f"{name} {_time(percentiles[key])}",
            (percentiles[key], 0.985 - 0.05 * number),
            xycoords=axis.get_xaxis_transform(),
            xytext=(3.0, 0.0),
            textcoords="offset points",
            verticalalignment="top",
            fontsize=8,
        )


def plot_stages(found, path):
    """Draw the cost of each stage beside that of the whole step, medians as bars, minima as marks.

    Parameters
    ----------
    found : dict
        As for `summary`.
    path : path-like
        File of the figure.
    """
    names = [*STAGES.values(), "whole step"]
    medians = [*(found["stages_us"][key] for key in STAGES), found["whole_step_us"]["median"]]
    minima = [*(found["stages_min_us"][key] for key in STAGES), found["whole_step_us"]["min"]]

    def paint(figure):
        axis = figure.add_subplot()
        bars = axis.barh(names, medians, color=[BLUE] * len(STAGES) + [ORANGE], height=0.6, label="median")
        axis.plot(minima, names, "|", color="black", markersize=12, label="minimum")
        axis.bar_label(bars, [f"{value:.2f}" for value in medians], padding=4)
        axis.invert_yaxis()
        axis.margins(x=0.12)
        axis.grid(axis="y", visible=False)
        loaded = _loaded(found["kept_state"]["patches"])
        axis.set_title(f"{found['scenario']}: one step of {found['step_ms']:g} ms, {loaded}")
        axis.set_xlabel("wall time of one pass, repeated alone [us]")
        axis.legend(loc="upper right")

    draw(paint, path, (9.0, 3.6))
