"""Compile the kernels, or read them from the cache, before they are needed."""

from dataclasses import replace

from railcli.kernels import jit, step

from .build_table import build_table
from .certify import certify

CORE = (step.advance, step.record_rows, step.finish, step.evaluate)
LAST_OF_TABLES = "branches.join_cells"  # the last function that a table needs


def warm(announce=None):
    """Make the entry functions of the core ready.

    Parameters
    ----------
    announce : callable, optional
        Called with a sentence when this compiles, which takes some minutes once for each version of the kernels.
    """
    if announce and jit.numba.config.DISABLE_JIT:
        announce("NUMBA_DISABLE_JIT is set: nothing is compiled, and all is a thousand times slower.")
    elif announce and not is_warm():
        announce("Compiling the core (once for this version and machine; some minutes) ...")
    for entry in CORE:
        entry.compiled()
    jit.forget_old_code()


def is_warm():
    """True when the compiled core is kept: `warm` only reads it."""
    return all(jit.is_kept(f"step.{entry.__name__}") for entry in CORE)


def warm_tables(wheel, rail, settings, announce=None):
    """Make the kernels ready that build and certify a contact table, by building a tiny one.

    Parameters
    ----------
    wheel, rail : Profile
    settings : TableSettings
        Of the table to come; what does not fit is found out here.
    announce : callable, optional
        As in `warm`.
    """
    from .certify_forces import certify_forces

    if announce and not jit.is_kept(LAST_OF_TABLES):
        announce("Compiling the kernels of contact tables (once for this version and machine; a minute or so) ...")
    tiny = replace(
        settings, y_range=1e-3, y_step=1e-3, roll_range=1e-3, roll_step=1e-3, yaw_range=1e-3, yaw_count=2, fineness=1.0
    )
    table = build_table(wheel, rail, tiny)[0]
    if not settings.stores_heights:
        certify(table, wheel, rail, poses=1)
    certify_forces(table, wheel, rail, poses=1)
