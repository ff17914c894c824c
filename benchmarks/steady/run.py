"""`python benchmarks/steady/run.py`: the steady motion of time runs against that of Newton's method.

Each case runs in one curve, from Newton's state with all bodies but the car body turned by 0.3 mrad, until two windows
repeat; means over the last window are compared. Some run from the straight through a transition into the curve. The
eigenvalues of the linearised model about Newton's motion say whether that motion is stable (docs/theory.md, 9).
"""

import argparse
import itertools
import json
import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from railcli.analysis.equilibrium import steady  # noqa: E402
from railcli.analysis.faults import copied  # noqa: E402
from railcli.analysis.linear import linear_about  # noqa: E402
from railcli.errors import SimulationError  # noqa: E402
from railcli.files.scenario import load  # noqa: E402
from railcli.kernels.layout import Status, freeze  # noqa: E402
from railcli.kernels.recording import new_rows  # noqa: E402
from railcli.kernels.step import record  # noqa: E402
from railcli.model.sections import Curve, Straight, Transition  # noqa: E402
from railcli.model.submodels import CREEP_LAWS  # noqa: E402
from railcli.model.system import assemble  # noqa: E402
from railcli.model.track import Track, pack  # noqa: E402
from railcli.studies.tables import tables_for  # noqa: E402

CURVES = {150.0: 0.10, 300.0: 0.09, 1200.0: 0.09, 5000.0: 0.09}  # radius: cant [m]
SPEEDS = {  # radius: speeds at which a vehicle can go there [m/s]
    150.0: (0.2, 0.5, 1.0, 2.0, 4.0, 10.0),
    300.0: (0.2, 0.5, 1.0, 2.0, 4.0, 10.0),
    1200.0: (0.2, 0.5, 1.0, 2.0, 4.0, 10.0, 45.0),
    5000.0: (90.0,),
}
FRICTION = (0.1, 0.2, 0.3, 0.45, 0.6)
STEPS = (1e-3, 0.5e-3)  # [s]
TURNED = 0.3e-3  # yaw of bogies and wheelsets at the start [rad]
WINDOW, SHORTEST = 10.0, 1.0  # a mean is over this length [m], at least this time [s]
LONGEST = 150.0  # of a run [m]
LONGEST_TIME = 20.0  # or this [s], whichever is more
REPEATS = 2e-6, 10.0  # windows differ by less [m], [N]
APART = 20e-6, 100.0  # largest difference that is none: displacement [m], force [N]
WATCHED = 1000  # steps at the end, each looked at
QUIET, SLOW = 100.0, 3.0  # a wheel force that swings by less [N] or slower [Hz] does not vibrate
BLOCK = 500  # rows between two returns
STRAIGHT, INTO = 30.0, 40.0  # before the curve, where a run begins on straight track [m]


@dataclass(frozen=True)
class Case:
    """One run; lengths in m, speed in m/s, step in s."""

    law: str
    friction: float
    radius: float
    speed: float
    step: float
    from_straight: bool = False


@dataclass(frozen=True)
class Found:
    """What a run shows beside Newton's motion.

    Attributes
    ----------
    lateral, force : float
        Largest difference of means over wheelsets [m], and over X, Y, Q of all wheels [N].
    swing : float
        Largest peak-to-peak of a wheel force over the last steps [N].
    alternation : float
        Its part that changes sign from step to step: amplitude [N].
    frequency : float
        Of the swing [Hz].
    growth, at : float
        Largest real part of an eigenvalue about Newton's motion [1/s], and its frequency [Hz].
    distance : float
        Run [m].
    fault : str
    """

    lateral: float
    force: float
    swing: float
    alternation: float
    frequency: float
    growth: float
    at: float
    distance: float
    fault: str = ""

    @property
    def agrees(self):
        return not self.fault and self.lateral < APART[0] and self.force < APART[1]

    @property
    def verdict(self):
        if self.fault:
            return self.fault
        if self.alternation > QUIET:
            return "alternates"
        if self.agrees:
            return "ok" if self.swing < QUIET or self.frequency < SLOW else "ok, vibrates"
        return "vibrates" if self.swing >= QUIET else "differs"


def system_of(case, tables=None):
    """The wagon on the case's track."""
    scenario = load("curve-300").varied(
        run={"speed": case.speed, "step": case.step}, contact={"creep_law": case.law, "friction": case.friction}
    )
    curve = Curve(length=LONGEST + LONGEST_TIME * case.speed + 100.0, radius=case.radius, hand="right",
                  cant=CURVES[case.radius])  # fmt: skip
    into = (Straight(length=STRAIGHT), Transition(length=INTO, shape="bloss")) if case.from_straight else ()
    system = assemble(scenario, tables or tables_for(scenario))
    return replace(system, model=freeze(system.model._replace(track=pack(Track((*into, curve))))))


def against_newton(case, tables=None):
    """Run a case.

    Returns
    -------
    Found
    """
    system = system_of(case, tables)
    solved = steady(system, 1.0 / case.radius, CURVES[case.radius]).data
    data = system.start(0.0)
    if case.from_straight:
        data.q[:, 2:] = steady(system, 0.0, 0.0).data.q[:, 2:]
        growth = at = np.nan
    else:
        data.q[:] = solved.q
        data.q[:, 0] -= data.q[0, 0]
        data.v[:] = solved.v
        data.damper[:], data.held[:] = solved.damper, solved.held
        value = np.linalg.eigvals(linear_about(system, copied(data), case.speed, curved=True).matrix)
        most = value[value.real.argmax()]
        growth, at = float(most.real), abs(float(most.imag)) / (2.0 * np.pi)
        data.q[1:, 5] += TURNED
    wanted = _seen(system, solved.q[None], solved.rail[None])
    mean, swing, alternation, frequency, fault = _run(system, case, data)
    apart = np.abs(mean - wanted.mean(axis=0))
    count = len(system.wheelsets)
    return Found(float(apart[:count].max()), float(apart[count:].max()), swing, alternation, frequency, growth, at,
                 float(data.q[0, 0]), fault)  # fmt: skip


def _seen(system, q, rail):
    """Rows (n, channels): lateral place of wheelsets [m], then X, Y, Q of all wheels [N]."""
    return np.hstack([q[:, list(system.wheelsets), 1], rail["x"], rail["y"], rail["q"]])


def _run(system, case, data):
    count, steps = len(system.wheelsets), max(WINDOW / case.speed, SHORTEST) / case.step
    stride = 1 + 2 * int(steps / (8 * BLOCK))  # odd, so that alternate steps are both seen
    rows = new_rows(system.model, BLOCK)
    blocks = max(1, round(steps / (stride * BLOCK)))
    before, most = None, max(LONGEST, LONGEST_TIME * case.speed) + (STRAIGHT + INTO) * case.from_straight
    settled = False
    while not settled and data.q[0, 0] < most:
        total = 0.0
        for _ in range(blocks):
            _, status = record(system.model, data, rows, stride)
            if status:
                return np.full(count + 6 * count, np.nan), np.nan, np.nan, np.nan, Status(status).name
            total = total + _seen(system, rows.q, rows.rail).mean(axis=0)
        mean = total / blocks
        inside = data.q[0, 0] > WINDOW + (STRAIGHT + INTO) * case.from_straight
        if before is not None and inside:
            change = np.abs(mean - before)
            settled = change[:count].max() < REPEATS[0] and change[count:].max() < REPEATS[1]
        before = mean
    rows = new_rows(system.model, WATCHED)
    record(system.model, data, rows, 1)
    force = _seen(system, rows.q, rows.rail)[:, count:]
    change = np.diff(force, axis=0)
    flips = np.sum(change[1:] * change[:-1], axis=0) / np.maximum(np.sum(change**2, axis=0), 1e-30)
    alternation = np.where(flips < -0.8, 0.5 * np.sqrt(np.mean(change**2, axis=0)), 0.0)
    swing = np.ptp(force, axis=0)
    widest = force[:, swing.argmax()] - force[:, swing.argmax()].mean()
    power = np.abs(np.fft.rfft(widest * np.hanning(WATCHED)))
    frequency = float(np.argmax(power[1:]) + 1) / (WATCHED * case.step)
    return mean, float(swing.max()), float(alternation.max()), frequency, ""


def grid(laws, frictions, radii, steps):
    """All cases, those from the straight at friction 0.3 with the first step."""
    for law, radius, friction, step in itertools.product(laws, radii, frictions, steps):
        for speed in SPEEDS[radius]:
            yield Case(law, friction, radius, speed, step)
            if friction == 0.3 and step == steps[0] and speed in (0.5, 4.0, 45.0):
                yield Case(law, friction, radius, speed, step, True)


def line(case, found):
    start = "straight" if case.from_straight else "Newton"
    return (
        f"{case.law:8} {case.friction:5.2f} {case.radius:6.0f} {case.speed:5.1f} {1e3 * case.step:5.2f} {start:9}"
        f"{1e3 * found.lateral:9.4f} {1e-3 * found.force:8.3f} {1e-3 * found.swing:8.3f} "
        f"{1e-3 * found.alternation:8.3f} {found.frequency:7.1f} {found.growth:9.3f} {found.at:7.1f} "
        f"{found.distance:7.0f}  {found.verdict}"
    )


HEAD = (
    "law         mu      R     V    ms start          mm       kN  p-p kN   alt kN      Hz    growth  its Hz      m"
    "  verdict"
)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--laws", nargs="+", default=sorted(CREEP_LAWS), choices=sorted(CREEP_LAWS))
    parser.add_argument("--friction", nargs="+", type=float, default=FRICTION)
    parser.add_argument("--radius", nargs="+", type=float, default=sorted(CURVES), choices=sorted(CURVES))
    parser.add_argument("--step-ms", nargs="+", type=float, default=[1e3 * step for step in STEPS])
    parser.add_argument("--json", type=Path, help="file to which each case is added as a line")
    options = parser.parse_args()
    print(HEAD)
    for case in grid(options.laws, options.friction, options.radius, [1e-3 * step for step in options.step_ms]):
        try:
            found = against_newton(case)
        except SimulationError as error:
            print(f"{case.law:8} {case.friction:5.2f} {case.radius:6.0f} {case.speed:5.1f}  {error}", flush=True)
            continue
        print(line(case, found), flush=True)
        if options.json:
            with options.json.open("a") as file:
                file.write(json.dumps({**asdict(case), **asdict(found), "verdict": found.verdict}) + "\n")


if __name__ == "__main__":
    main()
