"""`railcli track irregularity`: make, read and judge the irregularity of a track."""

import click

from .completion import SCENARIOS
from .options import results_options
from .terminal import tell

DEFAULT_SPECTRUM = "b176-low"


@click.command(short_help="Make, read and judge the irregularity of a track.")
@click.argument("source", required=False, metavar="[NAME|FILE]", type=SCENARIOS)
@click.option("--spectrum", metavar="NAME", help=f"Spectrum to realise or compare with  [default: {DEFAULT_SPECTRUM}]")
@click.option("--list", "only_list", is_flag=True, help="List the spectra and stop.")
@click.option("--length", type=float, default=2000.0, show_default=True, metavar="M", help="Length of a track made.")
@click.option("--shortest", type=float, default=3.0, show_default=True, metavar="M", help="Shortest wavelength.")
@click.option("--longest", type=float, default=70.0, show_default=True, metavar="M", help="Longest wavelength.")
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), default=1, show_default=True, help="Of the random phases.")
@click.option("--sided", type=click.Choice(["one", "two"]), default="one", show_default=True,
              help="Whether the published density counts wavenumbers of one or of both signs.")  # fmt: skip
@click.option("--spacing", type=float, metavar="M",
              help="Distance of values written  [default: 0.25, or what a scenario needs]")  # fmt: skip
@click.option("--no-figures", is_flag=True, help="Draw no figures.")
@results_options
def irregularity(
    source, spectrum, only_list, length, shortest, longest, seed, sided, spacing, no_figures,
    output_format, output, overwrite, quiet,
):  # fmt: skip
    """Irregularity of a track: realise a power spectrum, or take that of a scenario or of a measured file (CSV).

    Writes irregularity.csv, reads it back, and prints the RMS of every channel in the bands of EN 13848 beside that of
    the target spectrum in closed form; draws the channels over the track, and their spectra (Welch) with the target. A
    measured file is read and judged; it has a target only with --spectrum.

    \b
    Examples:
      railcli track irregularity --spectrum b176-high --length 5000 --seed 3 -o made
      railcli track irregularity random-track
      railcli track irregularity measured.csv --spectrum b176-low
    """  # fmt: skip
    from railcli.analysis.irregularity_spectrum import USUAL_SPACING, bands, made, of_scenario, spectra
    from railcli.errors import InputError
    from railcli.files import irregularity as files
    from railcli.files.output import results_folder, write_json
    from railcli.files.scenario import load
    from railcli.model.irregularity import Spectrum
    from railcli.model.spectra import SPECTRA
    from railcli.model.submodels import choose
    from railcli.report import irregularity as report

    if only_list:
        width = max(len(name) for name in SPECTRA)
        record = {name: {"summary": family.summary, "source": family.source} for name, family in SPECTRA.items()}
        lines = [f"{name.ljust(width)}  {family.summary}; {family.source}" for name, family in SPECTRA.items()]
        tell(record, lines, output_format)
        return
    choose(SPECTRA, "--spectrum", spectrum or DEFAULT_SPECTRUM)
    if not 0.0 < shortest < longest:
        raise InputError("--shortest, --longest", f"must be > 0 and rise, got {shortest:g} and {longest:g} m")
    wanted = Spectrum(
        spectrum=spectrum or DEFAULT_SPECTRUM, shortest=shortest, longest=longest, seed=seed, sided=sided
    )
    if source is None:
        record, name = made(wanted, length, USUAL_SPACING if spacing is None else spacing), wanted.spectrum
    elif source.lower().endswith((".csv", ".txt", ".dat")):
        record, name = files.measured(source, wanted if spectrum else None), "measured"
    else:
        case = load(source)
        record, name = of_scenario(case, spacing), case.name
    with results_folder("irregularity", name, output, overwrite) as folder:
        difference = files.write_and_compare(folder / "irregularity.csv", record)
        rows = bands(record)
        result = report.as_json(record, rows, difference)
        write_json(folder / "irregularity.json", result)
        if not no_figures:
            report.figures(record, spectra(record), folder)
    tell(result, [*report.lines(record, rows, difference), f"Written to {folder}"], output_format)
