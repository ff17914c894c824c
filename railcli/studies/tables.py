"""Contact tables: those that a scenario needs from the user's cache, or built and certified."""

from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial

from railcli.analysis.build_table import build_table
from railcli.analysis.certify import LIMITS, SEED, certify
from railcli.analysis.certify import shortcomings as of_geometry
from railcli.analysis.warm import warm_tables
from railcli.errors import InputError
from railcli.files import kept_tables
from railcli.files.lock import alone
from railcli.files.profiles import profile_of, settings_on
from railcli.files.tables import OF_A_SCENARIO, Expected, cached_path, check_expected, load, read, save
from railcli.files.user_file import is_there
from railcli.kernels import jit
from railcli.model.contact_table import ContactTable, check_tape
from railcli.model.submodels import NORMAL_LAWS
from railcli.model.system import needed, table_settings

from .voice import SILENT

POSES_UNASKED = 2000  # of the certificate of a table that a study builds because it needs one


@dataclass(frozen=True)
class Built:
    """A new contact table.

    Attributes
    ----------
    table : ContactTable
    facts : dict
        As `analysis.build_table`.
    certificate : dict
        Empty when it was built without.
    stages : list of analysis.refine.Stage
        The grids on the way to a wanted accuracy.
    """

    table: ContactTable
    facts: dict
    certificate: dict
    stages: list = field(default_factory=list)


def make(wheel, rail, settings, method="simplex", poses=POSES_UNASKED, voice=SILENT, seed=None):
    """Build a contact table and certify it.

    Parameters
    ----------
    wheel, rail : Profile
    settings : TableSettings
    method : {"simplex", "locus"}
    poses : int
        Poses of the certificate; 0: none.
    voice : Voice
    seed : int, optional
        Of these poses.

    Returns
    -------
    Built
    """
    warm_tables(wheel, rail, settings, voice.announce)
    total, unit = (100.0, "%") if settings.stores_heights else (settings.positions, "positions")
    with voice.job("Contact table", total, unit) as job:
        table, facts = build_table(wheel, rail, settings, method, lambda share: job.update(share * total))
    return Built(table, facts, measure(table, wheel, rail, poses, voice, seed) if poses else {})


def refined(wheel, rail, settings, goal, largest, method="simplex", poses=POSES_UNASKED, voice=SILENT, seed=None):
    """Build a contact table as accurate as `goal` (analysis.refine) and no larger than so many bytes; else as `make`.

    Raises
    ------
    CheckError
        It would be larger.
    """
    from railcli.analysis.refine import refine, refine_knots

    def build(settings):
        built = make(wheel, rail, settings, method, poses, voice, seed)
        return built.table, built.facts, built.certificate

    def along(table, axis):
        return measure(table, wheel, rail, max(poses // 4, 1), voice, seed, axis)

    if settings.stores_heights:
        return Built(*refine_knots(settings, goal, largest, build))
    return Built(*refine(settings, goal, largest, build, along))


def measure(table, wheel, rail, poses, voice=SILENT, seed=None, axis=None):
    """Certificate of a table at its usual poses or those of another seed.

    axis : of geometry alone, along one axis, as `analysis.certify` takes it.

    Returns
    -------
    dict
        As `analysis.certify` gives it, but poses and seed alone of a table of heights; `forces` as
        `analysis.certify_forces`.
    """
    from railcli.analysis import certify_forces

    seed = SEED if seed is None else seed
    certificate = {"poses": poses, "seed": seed}

    def measured(title, certify, *rest):
        with voice.job(title, poses, "poses") as job:
            found = certify(table, wheel, rail, poses, seed, lambda share: job.update(share * poses), *rest)
            job.update(poses)
        return found

    if not table.settings.stores_heights:
        certificate = measured("Certificate of geometry", certify, axis)
    if axis is None:
        certificate["forces"] = measured("Certificate of forces", certify_forces.certify_forces)
    return certificate


def doubt(certificate, wheel, rail, voice):
    """Warn of what a table falls short of."""
    if found := shortcomings(certificate):
        voice.warn(
            f"contact table of {wheel.name} on {rail.name}: {'; '.join(found)}; smooth measured profiles "
            "(railcli profile import --smooth 4, or 8) or refine the grid (railcli build-lut --accuracy)"
        )


def shortcomings(certificate):
    """Sentences that say in what a table falls short of its limits, geometry and forces; none for a good one."""
    from railcli.analysis import certify_forces

    found = of_geometry(certificate) if "branches" in certificate else []
    return found + (certify_forces.shortcomings(certificate["forces"]) if "forces" in certificate else [])


def limits(table):
    """Limits of p99 errors that a good table keeps, by the keys of its certificate."""
    from railcli.analysis import certify_forces

    return certify_forces.LIMITS if table.settings.stores_heights else {**LIMITS, **certify_forces.LIMITS}


def table_for(settings, wheel, rail, voice=SILENT):
    """The table of these settings and profiles from the user's cache; built and kept there when it is missing.

    A file there that is damaged, or that other sources of the kernels built, is replaced; the tables that were used
    longest ago make room for a new one. A cache that cannot be written costs time only. Of several processes that
    need the same table at once one builds it; the others wait and read.

    Parameters
    ----------
    settings : TableSettings
    wheel, rail : Profile
    voice : Voice
    """
    path, expect = cached_path(settings, wheel, rail), Expected(wheel, rail, settings)
    table, _ = _kept(path, expect)
    if table is not None:
        return table
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
    waits = f"Another process builds the contact table of {wheel.name} on {rail.name}: waiting for it ..."
    with alone(path, lambda: voice.announce(waits)):
        table, complaint = _kept(path, expect)
        if table is not None:
            return table
        if complaint:
            voice.warn(f"{complaint}; it is built again")
        built = make(wheel, rail, settings, voice=voice)
        doubt(built.certificate, wheel, rail, voice)
        try:
            save(built.table, path, built.certificate)
            kept_tables.make_room(path)
        except InputError as error:
            voice.warn(f"the contact table cannot be kept, every run builds it again: {error}")
    return built.table


def _kept(path, expect):
    """The table in a file of the cache, None when there is none to use, and what is wrong with the file."""
    if not is_there(path):
        return None, ""
    try:
        stored = read(path)
        check_expected(stored.table, path, expect)
    except InputError as error:
        return None, str(error).partition("; build it")[0]
    if stored.kernels != jit.source_digest():
        return None, ""
    kept_tables.used(path)
    return stored.table, ""


def tables_for(scenario, voice=SILENT, shelf=None):
    """Contact tables of a scenario, one for each pairing that `model.system.needed` names, in this order.

    shelf : what keeps tables at hand between scenarios; its `get(key, make)` gives that of a key.
    """
    tables, told = [], set()
    for pairing in needed(scenario):
        wheel, rail = profile_of(scenario, pairing.wheel, "wheel"), profile_of(scenario, pairing.rail, "rail")
        settings = table_settings(scenario, pairing.radius)
        check_tape(wheel, settings.tape_to_back)
        settings = settings.on(rail) if rail in told else settings_on([rail], settings)
        told.add(rail)
        if pairing.file is None:
            key, make = cached_path(settings, wheel, rail), partial(table_for, settings, wheel, rail, voice)
        else:
            expect = Expected(wheel, rail, settings, OF_A_SCENARIO, pairing.wheel, pairing.rail)
            key = pairing.file, expect.settings, wheel.digest(), rail.digest()
            make = partial(load, pairing.file, expect)
        tables.append(make() if shelf is None else shelf.get(key, make))
    return tables


def benchmark_tables(voice=SILENT):
    """Contact tables of the Manchester contact benchmark from the cache, or built: normal law -> ContactTable."""
    from railcli.analysis.contact_benchmark import SETTINGS
    from railcli.files.contact_reference import benchmark_profiles

    profiles = benchmark_profiles()
    return {law: table_for(replace(SETTINGS, normal=law), *profiles, voice) for law in NORMAL_LAWS}
