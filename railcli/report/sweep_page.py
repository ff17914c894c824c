"""The page of a parameter study, which needs nothing but itself."""

from . import sensitivity
from .page import Table, template
from .sweep import causes, outputs_of, overview, ranges

NAME = "report.html"
WHERE = "the page of a study"


def tables(study, scenario, design, table, found):
    """Tables of the page by their place in it; parameters as of `sweep_figures.figures`."""
    made = {"study": Table("Study", ["", ""], [list(pair) for pair in overview(study, scenario, design, table)])}
    rows = [
        [name, *(f"{value:.5g}" for value in values), f"{low:,}", f"{high:,}"]
        for name, *values, low, high in ranges(outputs_of(table, design), table)
    ]
    if rows:
        head = ["", "least", "median", "greatest", "least in run", "greatest in run"]
        made["outputs"] = Table("Outputs", head, rows, "Runs are counted from 0, as in the tables.", numbers=True)
    if found:
        inputs = [one.name for one in study.parameters if one.is_sampled]
        note = "Of each input S1, and ST behind the stroke where the sample gives it; with 95 % intervals."
        made["sobol"] = Table("Sobol indices", ["", *inputs], sensitivity.rows(inputs, found), note)
    if failed := causes(table):
        rows = [[f"{len(runs):,}", ", ".join(map(str, runs[:8])) + (" ..." if len(runs) > 8 else ""), cause]
                for cause, runs in failed.items()]  # fmt: skip
        made["failed"] = Table("Failed runs", ["runs", "numbers", "cause"], rows)
    return made


def render(study, scenario, design, table, found, pictures, files, version, date):
    """The page; pictures as of `page.render`.

    Raises
    ------
    InputError
        jinja2 is not installed.
    """
    shown = tables(study, scenario, design, table, found)
    return template("sweep.html", WHERE).render(
        title=study.title or study.name, description=study.description, tables=shown, pictures=pictures, files=files,
        version=version, date=date,
    )  # fmt: skip
