"""Everything that `railcli validate curves` compares: R = 150 m, the Cooperrider wagon, and R = 1200 m beside them."""

from dataclasses import dataclass

from . import curving_check, decay_check
from .validate import SUPPORTED, deviations, steady_displacements

SHARE_OF_CURVE, SHARE_OF_WAGON = 0.6, 0.35  # of the progress


@dataclass(frozen=True)
class References:
    """Values of other programs.

    Attributes
    ----------
    codes : curving_check.Codes
    decays : decay_check.Decays
    manchester : validate.Reference
        The curve of 1200 m.
    """

    codes: curving_check.Codes
    decays: decay_check.Decays
    manchester: object


@dataclass(frozen=True)
class Outcome:
    """What was found.

    Attributes
    ----------
    references : References
    curves : dict of str to curving_check.Curve
        R = 150 m, by variation.
    wagon : decay_check.Wagon
    wide : dict of str to dict
        R = 1200 m by the laws that were taken: deviations from both codes in the supported reading [mm].
    rows : list of Row
    """

    references: References
    curves: dict
    wagon: decay_check.Wagon
    wide: dict
    rows: list

    @property
    def accepted(self):
        return all(row.kept for row in self.rows if row.counts)


def compare_curves(references, criteria, curve, wagon, wheelset, wide, tables_of, progress):
    """Run every comparison.

    Parameters
    ----------
    references : References
    criteria : dict
        Groups of accept.toml.
    curve, wagon, wide : Scenario
        R = 150 m, the Cooperrider wagon, R = 1200 m: each with the laws of its own.
    wheelset : rigid_contact.Wheelset
        Of the wagon.
    tables_of : callable
        Contact tables of a scenario.
    progress : callable
        Called with the share done and a sentence.

    Returns
    -------
    Outcome
    """
    curves = curving_check.compare_curve(
        references.codes, curve, tables_of, lambda share, text: progress(SHARE_OF_CURVE * share, text)
    )
    found = decay_check.compare_wagon(
        references.decays, wagon, tables_of(wagon), wheelset,
        lambda share, text: progress(SHARE_OF_CURVE + SHARE_OF_WAGON * share, text),
    )  # fmt: skip
    progress(SHARE_OF_CURVE + SHARE_OF_WAGON, "R = 1200 m")
    own = {key: getattr(curve.contact, key) for key in ("creep_law", "normal")}
    speeds, supported = references.manchester.speeds, references.manchester.read(SUPPORTED)
    compared = {
        f"creep {case.contact.creep_law}, normal {case.contact.normal}": deviations(
            steady_displacements(case, tables_of(case), speeds), *supported
        )
        for case in (wide, wide.varied(contact=own))
    }
    progress(1.0, "")
    rows = curving_check.judge(criteria["curve_150"], references.codes, curves)
    rows += decay_check.judge(criteria["cooperrider"], references.decays, found)
    return Outcome(references, curves, found, compared, rows)


