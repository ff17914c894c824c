"""Wear number T-gamma of every wheel, by the part of the profile on which its contacts lie."""

import numpy as np

from railcli.kernels.layout import Region

from .. import indices

CHANNELS = ("creep_x", "creep_t", "xi", "eta", "region")
PARTS = {Region.TREAD: "tread", Region.ROOT: "flange root", Region.FLANK: "flange flank", Region.TIP: "flange tip"}
ALL = "all contacts"
KEYS = ("wear_wheel", "wear_contact")


def assess_wear(run, outcome, tally):
    """Offer the wear numbers of every section, and fill `outcome.wear`."""
    wheels, sections, limit = run.source.wheels, outcome.sections, run.limits.t_gamma
    needed = ("T_gamma",) if run.filtered else [f"contact/{channel}" for channel in CHANNELS]
    if name := run.absent(f"wheels/{wheel}/{channel}" for wheel in wheels for channel in needed):
        tally.missing(KEYS, f"channel {name} was not recorded")
        return
    length = sum(section.end - section.start for section in sections)
    outcome.wear = {wheel: dict.fromkeys((*PARTS.values(), ALL), (0.0, 0.0)) for wheel in wheels}
    for group in run.blocks(sections):
        rows = run.rows(sections[group[0]].start, sections[group[-1]].end, 0.0)
        for w, wheel in enumerate(wheels):
            s = run.places(run.source.wheelsets[w // 2], *rows)
            by_part = _numbers(run, wheel, rows)
            for k in group:
                inside = slice(*np.searchsorted(s, [sections[k].start, sections[k].end]))
                if inside.start == inside.stop:
                    continue
                mean = {name: float(values[inside].mean()) for name, values in by_part.items()}
                worst = max(mean, key=mean.get)
                mean[ALL] = sum(mean.values())
                place = f"{wheel.replace('_', ' ')}, {sections[k].place}"
                tally.offer("wear_wheel", mean[ALL], limit, place, section=k)
                tally.offer("wear_contact", mean[worst], limit, place, worst, k)
                share = (sections[k].end - sections[k].start) / length
                for name, value in mean.items():
                    before, largest = outcome.wear[wheel][name]
                    outcome.wear[wheel][name] = (before + share * value, max(largest, value))


def _numbers(run, wheel, rows):
    """T-gamma of each part of a wheel's profile over rows [N]."""
    if run.filtered:
        return dict(zip(PARTS.values(), run.source.read(f"wheels/{wheel}/T_gamma", *rows).T.astype(float), strict=True))
    *state, region = (run.source.read(f"wheels/{wheel}/contact/{name}", *rows) for name in CHANNELS)
    number = indices.t_gamma(*state)
    region = np.rint(region)  # between the nodes of a contact table it is interpolated
    return {name: np.where(region == part, number, 0.0).sum(axis=1) for part, name in PARTS.items()}
