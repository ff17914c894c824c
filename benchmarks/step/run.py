"""`python benchmarks/step/run.py [SCENARIO ...]`: the longest stable step as predicted, and as time runs find it.

Every run crosses rails that wind by SWING, so that each wheelset passes all lateral places up to both flanges. It is
unstable when a wheel force alternates from step to step or when a fault comes that a quarter of the step does not know.
Steps grow from 0.7 of the prediction by RATIO; found is the last one before the first unstable run. Writes a table in
Markdown (docs/step.md holds one). Needs the `railcli` package; takes some minutes.
"""

import argparse
import math
import os
import sys
from dataclasses import replace
from pathlib import Path

for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from railcli.analysis.faults import copied, verdict  # noqa: E402
from railcli.analysis.simulate import settled_start  # noqa: E402
from railcli.analysis.step_limit import step_limit  # noqa: E402
from railcli.analysis.watch import ALTERNATES, AUDIBLE  # noqa: E402
from railcli.errors import RailcliError  # noqa: E402
from railcli.files.scenario import DEFAULT_SCENARIO, load  # noqa: E402
from railcli.kernels.layout import freeze  # noqa: E402
from railcli.kernels.recording import new_rows  # noqa: E402
from railcli.kernels.step import record  # noqa: E402
from railcli.model.sections import Straight  # noqa: E402
from railcli.model.system import assemble  # noqa: E402
from railcli.model.track import Track, pack  # noqa: E402
from railcli.studies.tables import tables_for  # noqa: E402

SWING = 6.5e-3  # of both rails [m]
WAVE = 16.0, 40.0  # shortest wave of theirs, and from which on it lasts one second instead of two [m]
SECONDS, WAVES = 6.0, 2.0  # of a run, at least
BLOCK = 0.25  # over which alternation is looked for [s]
RATIO = 1.03  # of one step to the next
FIRST, LAST = 0.7, 1.6  # of the prediction
USUAL_SPEED = 20.0  # of the varied vehicles [m/s]
SPEEDS = (1.0, 2.0, 5.0, 10.0, 20.0, 45.0, 90.0)  # of the vehicle as it is [m/s]
VARIED = (
    ("wheelset mass", (0.5, 0.66, 1.5, 2.0)),
    ("stiffness", (0.1, 10.0, 100.0, 300.0)),
    ("damping", (0.1, 10.0, 30.0, 100.0)),
    ("series stiffness", (0.1, 10.0, 100.0, 300.0, 3000.0)),
)


def varied(system, what, factor):
    """The system with one kind of its values times a factor."""
    model = system.model
    body, element, joint = model.body.copy(), model.element.copy(), model.joint.copy()
    if what == "wheelset mass":
        of_wheelsets = body["spins"] == 1
        body["mass"][of_wheelsets] *= factor
        body["inertia"][of_wheelsets] *= factor
    elif what == "stiffness":
        element["k"] *= factor
        joint["turn"] *= factor
    elif what == "damping":
        element["c"] *= factor
    else:
        element["series"] *= factor
    return replace(system, model=freeze(model._replace(body=body, element=element, joint=joint)))


def wave(speed):
    """Length of the waves of the rails [m]: gentle enough for wheel forces below about twice the static ones."""
    return max(WAVE[0], speed, min(2.0 * speed, WAVE[1]))


def lasts(speed):
    """Time of a run at this speed [s]."""
    return max(SECONDS, WAVES * wave(speed) / speed)


def winding(system, speed):
    """The system at another speed on straight track whose rails wind."""
    length = wave(speed)
    reach = speed * lasts(speed) + 100.0
    s = np.arange(-60.0, reach, 0.02)
    phase = 2.0 * math.pi * s / length
    rise = np.clip(s / length, 0.0, 1.0)  # within the first wave
    value = SWING * rise * np.sin(phase)
    slope = np.gradient(value, s)
    still = np.zeros_like(s)
    shift = np.stack([value, slope, still, still] * 2, axis=1)
    param = system.model.param.copy()
    param["speed"], param["shift_start"], param["shift_step"] = speed, s[0], s[1] - s[0]
    track = pack(Track((Straight(length=reach),)))
    model = freeze(system.model._replace(param=param, track=track, shift=np.ascontiguousarray(shift)))
    return replace(system, model=model, speed=speed)


def unstable(system, step):
    """What a run at this step shows of instability in words; empty when nothing."""
    system = system.stepped(step)
    data = settled_start(system)
    rows = new_rows(system.model, max(4, round(BLOCK / step)))
    for _ in range(math.ceil(lasts(system.speed) / BLOCK)):
        kept = copied(data)
        count, status = record(system.model, data, rows, 1)
        if status:
            told = verdict(system, data, status, kept)
            return told if "numerically unstable" in told else ""
        moved = np.diff(np.concatenate([rows.rail["y"], rows.rail["q"]], axis=1), axis=0)
        turn, move = (moved[1:] * moved[:-1]).sum(axis=0), (moved**2).sum(axis=0)
        amplitude = 0.5 * np.sqrt(move / len(moved))
        if ((turn < ALTERNATES * move) & (amplitude > AUDIBLE)).any():
            return f"alternates by {amplitude.max() * 1e-3:.2f} kN at t = {data.clock[0]:.2f} s"
    return ""


def found(system, predicted):
    """The longest step before the first unstable one; NaN when none up to LAST of the prediction is unstable."""
    step = FIRST * predicted
    while step < LAST * predicted:
        if unstable(system, step):
            return step / RATIO
        step *= RATIO
    return math.nan


def main():
    """Print the table row by row."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=[DEFAULT_SCENARIO], help="vehicles; the default wagon")
    print("| vehicle | speed, m/s | predicted, ms | found, ms | found over predicted | limited by |")
    print("|---|---|---|---|---|---|")
    for name in parser.parse_args().scenarios:
        scenario = load(name)
        system = assemble(scenario, tables_for(scenario))
        cases = [("as it is", system, speed) for speed in SPEEDS]
        cases += [
            (f"{what} x {factor:g}", varied(system, what, factor), USUAL_SPEED)
            for what, factors in VARIED
            for factor in factors
        ]
        for words, case, speed in cases:
            try:
                case = winding(case, speed)
                limit = step_limit(case)
                step = found(case, limit.stable)
            except RailcliError as error:
                print(f"| {scenario.vehicle.name}, {words} | {speed:g} | | | {error} | |", flush=True)
                continue
            predicted, seen = limit.stable * 1e3, step * 1e3
            print(
                f"| {scenario.vehicle.name}, {words} | {speed:g} | {predicted:.3f} | {seen:.3f} | "
                f"{seen / predicted:.2f} | {limit.limited_by} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
