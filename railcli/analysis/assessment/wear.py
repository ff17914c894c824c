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
    wheels, sections, limit = run.results.wheels, outcome.sections, run.limits.t_gamma
    if name := run.absent(f"wheels/{wheel}/contact/{channel}" for wheel in wheels for channel in CHANNELS):
        tally.missing(KEYS, f"channel {name} was not recorded")
        return
    length = sum(section.end - section.start for section in sections)
    outcome.wear = {wheel: dict.fromkeys((*PARTS.values(), ALL), (0.0, 0.0)) for wheel in wheels}
    for group in run.blocks(sections):
        rows = run.rows(sections[group[0]].start, sections[group[-1]].end, 0.0)
        for w, wheel in enumerate(wheels):
            s = run.results.read(f"bodies/{run.results.wheelsets[w // 2]}/position", *rows)[:, 0]
            *state, region = (run.results.read(f"wheels/{wheel}/contact/{name}", *rows) for name in CHANNELS)
            number = indices.t_gamma(*state)
            region = np.rint(region)  # between the nodes of a contact table it is interpolated
            by_part = {name: np.where(region == part, number, 0.0).sum(axis=1) for part, name in PARTS.items()}
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
