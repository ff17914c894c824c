"""`railcli sweep`: many runs with other values."""

from pathlib import Path

import click

from .options import results_options
from .terminal import Terminal, show


@click.command(short_help="Many runs with other values: a parameter study.")
@click.argument("source", required=False, metavar="[STUDY|SCENARIO]")
@click.option("--list", "only_list", is_flag=True, help="List the built-in studies and stop.")
@click.option("--vary", multiple=True, metavar="KEY=VALUES",
              help="Key and values: A,B,C or FROM:TO:COUNT or a distribution such as 'normal(0.3,0.05,0.1,0.5)' "
              "(mean, sd, min, max); may be repeated.")  # fmt: skip
@click.option("--sample", type=click.IntRange(2), metavar="COUNT", help="Points at which distributions are drawn.")
@click.option("--method", type=click.Choice(["latin-hypercube", "sobol", "random", "sobol-indices"]),
              help="How they are drawn  [default: latin-hypercube]")  # fmt: skip
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), metavar="N", help="Of the sample  [default: 1]")
@click.option("--seeds", type=click.IntRange(1), metavar="COUNT", help="Seeds of irregularity for every point.")
@click.option("--outputs", multiple=True, metavar="GLOB",
              help="Outputs to keep, such as 'assessment.*'; may be repeated  [default: all]")  # fmt: skip
@click.option("--quasi-static", is_flag=True, help="Steady motions alone, no runs: as --outputs 'steady.*'.")
@click.option("--workers", type=click.IntRange(0), metavar="N",
              help="Processes; 0: in this one  [default: as many as processors]")  # fmt: skip
@click.option("--scheduler", metavar="ADDRESS", help="A dask scheduler whose workers make the runs: tcp://HOST:PORT.")
@click.option("--yes", is_flag=True, help="However many runs there are.")
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def sweep(
    source, only_list, vary, sample, method, seed, seeds, outputs, quasi_static, workers, scheduler, yes, no_figures,
    output_format, output, overwrite, quiet,
):  # fmt: skip
    """Make many runs of a scenario with other values: a study file, or a scenario and options; without either a small
    built-in study.

    Writes a row for every run, with its inputs, outputs, verdict, cause of failure and time, as CSV and Parquet, and
    figures. A study that was stopped goes on when the same command is given with the same -o FOLDER.

    \b
    Examples:
      railcli sweep
      railcli sweep curve-300 --vary contact.friction=0.1:0.5:9 --quasi-static
      railcli sweep my-study.toml -o my-study --workers 8
    """
    from railcli.files.study import DEFAULT_STUDY, builtin_studies, load_study
    from railcli.files.study import vary as entry
    from railcli.studies.sweep.study import sweep as study

    if only_list:
        studies = builtin_studies()
        for name, title in studies.items():
            click.echo(f"{name.ljust(max(map(len, studies)))}  {title}")
        return
    drawn = {"count": sample, "method": method, "seed": seed}
    more = {
        "vary": [entry(text) for text in vary],
        "sample": {key: value for key, value in drawn.items() if value is not None},
        "seeds": seeds,
        "outputs": [*outputs, *(["steady.*"] if quasi_static else [])],
    }
    plan = load_study(source or DEFAULT_STUDY, {key: value for key, value in more.items() if value})
    place = Path(output) if output else None
    answer = study(*plan, place, workers, scheduler, yes, overwrite, not no_figures, Terminal(quiet))
    show(answer, output_format)
