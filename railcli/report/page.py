"""The report of one or several results as a page that needs nothing but itself: tables, figures, provenance."""

from dataclasses import dataclass

import numpy as np

from railcli.files.extras import optional
from railcli.model.assessment import GROUPS

from . import assess
from .curves import SIDES
from .settings import differing, flat, shown
from .text import speed

STATUSES = ("pass", "warn", "fail", "not evaluated", "no limit")


@dataclass
class Table:
    """A table of text: a heading, the heads of its columns, its rows, and what must be said about it.

    numbers : its cells but the first are some.
    """

    title: str
    head: list
    rows: list
    note: str = ""
    numbers: bool = False


def template(name="report.html", where="railcli report"):
    """A page's template.

    Raises
    ------
    InputError
        jinja2 is not installed.
    """
    jinja2 = optional("jinja2", "report", where)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("railcli.report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)


def title(several):
    """Of the page."""
    if len(several) == 1:
        return str(several[0].results.settings.get("title") or several[0].label)
    return " against ".join(one.label for one in several)


def tables(several):
    """Tables of the runs, by what they are called in the page.

    Parameters
    ----------
    several : list of Curves

    Returns
    -------
    dict of str to Table
    """
    labels = [one.label for one in several]
    found = {"runs": Table("Runs", ["", *labels], _side_by_side([_facts(one) for one in several]))}
    if len(several) > 1:
        rows = [list(map(shown, row)) for row in differing([one.results.settings for one in several])]
        found["settings"] = Table(
            "Settings that differ", ["", *labels], rows, "" if rows else "None: the same scenario, vehicle and track."
        )
    if any(one.results.summary.get("steady") for one in several):
        found["steady"] = _steady(several)
    found["largest"] = Table(
        "Largest values", ["", *labels], _side_by_side([_largest(one) for one in several]),
        "Q, Y and accelerations: of every step; all else of recorded rows, Y/Q of means over their intervals (in "
        "results of earlier versions all of rows). No filter: a single peak need not converge with the step, on flange "
        "impacts it does not, and is no figure to judge by. s is the arc length of the first body.",
    )  # fmt: skip
    origins = [{key: shown(value) for key, value in flat(one.results.provenance).items()} for one in several]
    found["provenance"] = Table("Provenance", ["", *labels], _side_by_side(origins))
    return found


def assessment_rows(judged):
    """Rows of the assessment: a heading, or a figure with what each result has for it.

    Parameters
    ----------
    judged : list of dict or None
        As `assess.as_json`, for each result; None where there is none.
    """
    first = next((one for one in judged if one), None)
    headings = {key: heading for heading, key in GROUPS.items()}
    rows = []
    for key, figure in first["figures"].items() if first else ():
        if key in headings:
            rows.append({"heading": headings[key]})
        about = f"{figure['processing']}. {figure['source']}" + ("" if figure["standard_consulted"] else " (k)")
        unit = figure["unit"].replace("^2", "\N{SUPERSCRIPT TWO}")
        cells = [_cell(one["figures"][key]) if one else None for one in judged]
        rows.append({"name": figure["title"], "unit": unit, "about": about, "cells": cells})
    return rows


def verdicts(judged):
    """How many figures of each result pass, warn, fail and so on: text, or None without an assessment."""
    return [
        one and ", ".join(f"{one['verdict'][status]} {status}" for status in STATUSES if one["verdict"][status])
        for one in judged
    ]


def render(several, found, judged, pictures, films, version, date):
    """The page.

    Parameters
    ----------
    several : list of Curves
    found : dict
        As `tables`.
    judged : list of dict or None
        As for `assessment_rows`.
    pictures : list of dict
        name, title, caption; file; uri (its content).
    films : list of dict
        label (of the result), caption, kind, rate (frames per second); file; uris: of the frames, or of the film.
    version, date : str
    """
    notes = [(one.label, note) for one in several for note in _notes(one)]
    notes += [
        (one.label, f"assessment: {text}")
        for one, outcome in zip(several, judged, strict=True)
        if outcome
        for text in outcome["warnings"]
    ]
    return template().render(
        title=title(several), labels=[one.label for one in several], notes=notes, tables=found, pictures=pictures,
        assessment=assessment_rows(judged), verdicts=verdicts(judged), legend=assess.LEGEND, films=films,
        version=version, date=date,
    )  # fmt: skip


def _notes(one):
    summary = one.results.summary
    if not summary:
        yield "the run broke off before it wrote a summary"
    elif summary.get("fault"):
        yield f"the run ended before its time: {summary['fault']}"
    if warning := (summary.get("steady") or {}).get("warning"):
        yield warning
    yield from one.notes


def _facts(one):
    settings, summary, results = flat(one.results.settings), one.results.summary, one.results

    def setting(group, key, text="{}"):
        value = settings.get(f"{group}.{key}")
        return text.format(value) if isinstance(value, float) else shown(value)

    time = results.read("time", results.rows - 1)[0]
    position = results.read(f"bodies/{results.bodies[0]}/position", results.rows - 1)[0, 0]
    profiles = f"{setting('contact', 'wheel_profile')} on {setting('contact', 'rail_profile')}"
    return {
        "folder": str(results.folder),
        "scenario": shown(settings.get("name")),
        "title": shown(settings.get("title") or None),
        "vehicle": setting("vehicle", "name"),
        "speed": speed(value) if isinstance(value := settings.get("run.speed_m_per_s"), float) else shown(value),
        "profiles": f"{profiles}, 1:{setting('contact', 'inclination', '{:g}')}",
        "friction, creep law": f"{setting('contact', 'friction', '{:g}')}, {setting('contact', 'creep_law')}",
        "normal contact": setting("contact", "normal"),
        "reached": f"{position:.1f} m, {time:.2f} s",
        "finished": {True: "yes", False: "no"}.get(summary.get("finished"), "-"),
        "step": setting("run", "step_s", "{:g} s"),
        "recorded": f"{results.rows:,} rows, every {setting('run', 'output_interval_s', '{:g} s')}",
        "real-time factor": f"{summary['real_time_factor']:.0f}" if summary.get("real_time_factor") else "-",
    }


def _side_by_side(dicts):
    """Rows (key, value in each dict) of the keys of all dicts."""
    keys = dict.fromkeys(key for one in dicts for key in one)
    return [[key, *(one.get(key, "-") for one in dicts)] for key in keys]


def _steady(several):
    columns = []
    for one in several:
        steady = one.results.summary.get("steady")
        found = {}
        if steady:
            found["over"] = f"the last {steady['averaged_over_m']:g} m, {steady['stretch']}"
            found["lateral values"] = steady["lateral_positive"]
        for k in range(len(one.wheelsets) if steady else 0):
            mean, swing, name = steady["mean"], steady["peak_to_peak"], f"W{k + 1}"
            found[f"{name} y [mm]"] = f"{mean['lateral_mm'][k]:.3f} (p-p {swing['lateral_mm'][k]:.3f})"
            found[f"{name} yaw [mrad]"] = f"{mean['yaw_mrad'][k]:.3f} (p-p {swing['yaw_mrad'][k]:.3f})"
            for force in "QY":
                both = zip(steady["wheels"], mean[f"{force}_kN"][k], strict=True)
                found[f"{name} {force} [kN]"] = ", ".join(f"{wheel} {value:.2f}" for wheel, value in both)
        columns.append(found)
    note = "Means, with peak to peak (p-p)."
    return Table("Steady values at the end", ["", *(one.label for one in several)], _side_by_side(columns), note)


def _largest(one):
    wheels = [(f"W{k + 1} {side}", pair[i]) for k, pair in enumerate(one.wheelsets) for i, side in enumerate(SIDES)]
    wheelsets = [(f"W{k + 1}", name) for k, name in enumerate(one.results.wheelsets)]

    def forces(name, end):
        return [(label, 1e-3 * one.single(one.of_steps(f"wheels/{w}/{name}", end))) for label, w in wheels]

    found = {
        "lateral displacement of a wheelset [mm]": _extreme(
            one, [(label, 1e3 * one.component(f"bodies/{name}/position", 1)) for label, name in wheelsets], np.abs
        ),
        "yaw of a wheelset [mrad]": _extreme(
            one, [(label, 1e3 * one.component(f"bodies/{name}/rotation", 2)) for label, name in wheelsets], np.abs
        ),
        "Q, largest [kN]": _extreme(one, forces("Q", "greatest"), _same),
        "Q, smallest [kN]": _extreme(one, forces("Q", "least"), np.negative),
        "Y [kN]": _extreme(one, [*forces("Y", "greatest"), *forces("Y", "least")], np.abs),
        "Y/Q towards the flange": _extreme(one, [(label, one.quotient(w)) for label, w in wheels], _same),
    }
    for body in one.sprung:
        for direction, k in (("lateral", 1), ("vertical", 2)):
            channels = (one.of_steps(f"bodies/{body}/acceleration", end) for end in ("greatest", "least"))
            both = [("", one.component(channel, k)) for channel in channels]
            found[f"{body}, {direction} acceleration [m/s\N{SUPERSCRIPT TWO}]"] = _extreme(one, both, np.abs)
    return found


def _same(values):
    return values


def _extreme(one, curves, rank):
    """Value, name and place where the rank of the curves' values is largest, as text."""
    best = None
    for label, values in curves:
        ranks = rank(values)
        if np.isnan(ranks).all():
            continue
        at = int(np.nanargmax(ranks))
        if best is None or ranks[at] > best[0]:
            best = (ranks[at], values[at], label, one.s[at])
    if best is None:
        return "-"
    _, value, label, place = best
    return f"{value:.4g}{f', {label}' if label else ''} at s = {place:.1f} m"


def _cell(figure):
    value, limit = figure["value"], figure["limit"]
    share = 100.0 * value / limit if value is not None and limit else None
    return {
        "value": "-" if value is None else f"{value:.4g}",
        "limit": "-" if limit is None else f"{limit:.4g}",
        "share": "" if share is None else f"{share:.0f} %",
        "status": figure["status"],
        "about": "; ".join(text for text in (figure["place"], figure["note"]) if text),
    }
