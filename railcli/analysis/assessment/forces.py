"""Wheel forces: Q, Y, their ratio and sums, filtered block by block and judged section by section."""

import math

import numpy as np

from railcli.errors import InputError
from railcli.model.assessment import TIGHTEST

from .. import indices
from .values import STEP, Trace

CORNER = 20.0  # [Hz]
WINDOW = 2.0  # [m]
RMS_WINDOW, RMS_STEP = 100.0, 10.0  # [m]
AROUND, LOWEST = 2.0, 0.4  # on both sides of the dominant frequency, but not below [Hz]
LOADED = 0.05  # share of the static wheel load below which Y/Q is not evaluated
SIDES = ("right", "left")
OUTWARDS = np.array([1.0, -1.0])  # sign of Y of the right and of the left wheel that presses to the field side
KEYS = ("sum_Y", "Y_Q", "Y_Q_peak", "unloading", "stability", "Q_max", "Y_qst", "Q_qst")


def assess_forces(run, outcome, tally, static, nadal, progress=None):
    """Offer every figure of the wheel forces, and draw their traces.

    Parameters
    ----------
    run : Run
    outcome : Assessment
    tally : Tally
    static : array (n_wheelset, 2)
        Static wheel loads, right and left [N].
    nadal : float
        Limit of Y/Q.
    progress : callable, optional
        Called with the share that is done.
    """
    limits, sections = run.limits, outcome.sections
    if name := run.absent(f"wheels/{wheel}/{force}" for wheel in run.source.wheels for force in "YQ"):
        tally.missing(KEYS, f"channel {name} was not recorded")
        return
    faster = f"set output_interval_ms = {1e3 / (5.0 * CORNER):g} or less"
    if run.rate < indices.lowest_rate(CORNER):
        tally.missing(KEYS, f"recorded at {run.rate:g} Hz, too slow for the {CORNER:g} Hz low-pass; {faster}")
        return
    if run.rate < 5.0 * CORNER:
        outcome.warnings.append(
            f"Forces: recorded at {run.rate:g} Hz, so that what is above {run.rate / 2.0:g} Hz folds towards the "
            f"{CORNER:g} Hz that the low-pass lets through; {faster}."
        )
    if not any(section.kind == "curve" for section in sections):
        tally.missing(("Y_qst", "Q_qst"), "no full curve in what is evaluated")
    tally.missing(("stability",), f"no {RMS_WINDOW:g} m without a gap in what is evaluated")
    lines = [f"W{k + 1}" for k in range(len(static))]
    for key, names in (("Y_Q", lines), ("sum_Y", lines), ("Q_max", run.source.wheels)):
        outcome.traces[key] = {name: Trace(sections, run.speed * run.interval) for name in names}
    outcome.bounds |= {
        "sum_Y": float(indices.prudhomme(static.sum(axis=1).min(), limits.sum_y_factor)),
        "Y_Q": limits.y_over_q,
        "Q_max": float(limits.largest_q(static.mean(axis=1).min(), run.speed)),
    }
    margin = max(indices.SETTLED * run.speed, RMS_WINDOW)
    for group in run.blocks(sections):
        start, end = sections[group[0]].start, sections[group[-1]].end
        rows = run.rows(start, end, margin)
        for k in range(len(static)):
            forces = Forces(run, k, static[k], rows, start, end)
            forces.draw(outcome.traces)
            for number in group:
                forces.judge(tally, number, sections[number], nadal)
            forces.judge_stability(tally)
        if progress:
            progress((group[-1] + 1) / len(sections))


class Forces:
    """Forces of one wheelset over a block of rows that holds a stretch of track with a margin."""

    def __init__(self, run, k, static, rows, start, end):
        read = run.source.read
        self.limits, self.speed, self.rate = run.limits, run.speed, run.rate
        self.name, self.static = f"W{k + 1}", static
        self.start, self.end = start, end
        self.wheels = run.source.wheels[2 * k : 2 * k + 2]
        wheelset = run.source.wheelsets[k]
        self.s = run.places(wheelset, *rows)
        if not np.all(np.diff(self.s) > 0.0):
            raise InputError("assessment", f"{wheelset!r} does not roll forward all the time, so places have no order")
        y, q = (np.stack([read(f"wheels/{wheel}/{name}", *rows) for wheel in self.wheels], 1) for name in "YQ")
        self.recorded_sum = y.sum(axis=1)
        y, self.q = (indices.filtered(force, self.rate, high=CORNER) for force in (y, q))
        self.outwards = OUTWARDS * y
        self.ratio = np.full(q.shape, np.nan)
        np.divide(self.outwards, self.q, out=self.ratio, where=self.q > LOADED * static)
        self.centres = STEP * np.arange(np.ceil(start / STEP), end / STEP)
        self.sum_mean = indices.sliding_mean(self.s, y.sum(axis=1), WINDOW, self.centres)
        self.ratio_mean = np.stack(
            [indices.sliding_mean(self.s, ratio, WINDOW, self.centres) for ratio in self.ratio.T], axis=1
        )

    def draw(self, traces):
        """Add sum Y, the larger Y/Q of both wheels, and Q to the traces."""
        traces["sum_Y"][self.name].add(self.centres, self.sum_mean)
        traces["Y_Q"][self.name].add(self.centres, np.fmax(*self.ratio_mean.T))
        inside = slice(*np.searchsorted(self.s, [self.start, self.end]))
        for wheel, q in zip(self.wheels, self.q.T, strict=True):
            traces["Q_max"][wheel].add(self.s[inside], q[inside])

    def judge(self, tally, number, section, nadal):
        """Offer the figures of one section."""
        limits = self.limits
        edges = section.start + 0.5 * WINDOW - 1e-9, section.end - 0.5 * WINDOW + 1e-9
        windows = slice(*np.searchsorted(self.centres, edges))  # those that lie wholly inside
        rows = slice(*np.searchsorted(self.s, [section.start, section.end]))
        if np.isnan(self.sum_mean[windows]).all():
            return  # this wheelset did not come so far
        total = np.abs(indices.extremes(self.sum_mean[windows])).max()
        bound = indices.prudhomme(self.static.sum(), limits.sum_y_factor)
        tally.offer("sum_Y", total, bound, f"{self.name}, {section.place}", section=number)
        tight = "" if section.radius >= TIGHTEST else f"no limit below R = {TIGHTEST:g} m"
        for side, name in enumerate(SIDES):
            place = f"{self.name} {name}, {section.place}"
            ratio, peak, q = self.ratio_mean[windows, side], self.ratio[rows, side], self.q[rows, side]
            if section.outer in (None, side) and not np.isnan(ratio).all():
                bound = None if tight else limits.y_over_q
                tally.offer("Y_Q", indices.extremes(ratio)[1], bound, place, tight, number)
            if not np.isnan(peak).all():
                lifted = 100.0 * np.isnan(peak).mean()
                note = f"without the {lifted:.1f}% of it where Q is below {LOADED:g} Q0" if lifted else ""
                tally.offer("Y_Q_peak", np.nanmax(peak), nadal, place, note, number)
            low, high = indices.extremes(q)
            note = "" if low > 0.0 else "the wheel lifts: filtered, Q swings below zero there"
            unloading = min(1.0 - low / self.static[side], 1.0)
            tally.offer("unloading", unloading, limits.unloading, place, note, number)
            bound = limits.largest_q(self.static.mean(), self.speed)
            tally.offer("Q_max", high, bound, place, section=number)
            if section.kind == "curve" and section.outer == side:
                bound = limits.largest_y_qst(section.radius)
                note = "" if bound else tight
                tally.offer("Y_qst", np.median(self.outwards[rows, side]), bound, place, note, number)
                tally.offer("Q_qst", np.median(q), limits.q_qst, place, section=number)

    def judge_stability(self, tally):
        """Offer the moving rms of sum Y around its dominant frequency."""
        if self.end - self.start < RMS_WINDOW:
            return
        inside = slice(*np.searchsorted(self.s, [self.start, self.end]))
        peak = indices.dominant_frequency(self.recorded_sum[inside], self.rate)
        if math.isnan(peak):
            band, note = (
                indices.HUNTING,
                "no peak between {:g} and {:g} Hz, which are let through".format(*indices.HUNTING),
            )
        else:
            band, note = (max(peak - AROUND, LOWEST), peak + AROUND), f"dominant frequency {peak:.2f} Hz"
        around = indices.filtered(self.recorded_sum, self.rate, *band)
        half = 0.5 * RMS_WINDOW
        centres = np.arange(self.start + half, self.end - half + 1e-9, RMS_STEP)
        rms = indices.sliding_rms(self.s, around, RMS_WINDOW, centres)
        if np.isnan(rms).all():
            return
        worst = int(np.nanargmax(rms))
        bound = self.limits.stability_share * indices.prudhomme(self.static.sum(), self.limits.sum_y_factor)
        place = f"{self.name}, {centres[worst] - half:.0f} to {centres[worst] + half:.0f} m"
        tally.offer("stability", rms[worst], bound, place, note)
