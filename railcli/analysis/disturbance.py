"""Response of the wagon to track disturbances, against the linear vertical model where disturbances are small.

Both rails rise and fall alike in the vertical cases. Wheel forces are changes against the same run on perfect track, so
that what has nothing to do with the disturbance cancels out. Displacements of the rails: down and to the right.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from railcli.errors import SimulationError
from railcli.model.irregularity import Defect
from railcli.model.system import assemble
from railcli.model.track import Straight, Track

from .equilibrium import static
from .simulate import simulate
from .step_choice import with_step
from .vertical_model import Contact, vertical_model

SPEED = 40.0  # [m/s]
BEGIN = 20.0  # where disturbances begin [m]
STEPS = (0.5e-3, 0.25e-3)  # the usual one, halved [s]
LINEAR_STEP = 62.5e-6  # of the linear model, whose rail runs straight within it [s]
LIMIT_HZ = 100.0  # up to which models are compared
SMALL = {0.4: 4e-6, 3.0: 0.3e-3, 10.0: 2e-3}  # bumps: height over length [m]; contact forces change by 2.5 to 3.2 %
FREQUENCIES = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 70.0, 85.0, 100.0)  # [Hz]
FINE = 600  # frequencies of the linear response in figures
WAVE_FORCE = 0.03  # of the static wheel force, in the waves
HIGHEST_WAVE = 0.02  # [m]
SETTLE, MEASURE = 7.0, 2.0  # time for a wave to settle, and over which it is measured [s]
LARGE = (3e-3, 10e-3, 15e-3, 20e-3)  # heights of bumps 3 m long [m]
LARGE_LENGTH = 3.0  # [m]
LATERAL = {"step": 4e-3, "bump": 4e-3}  # [m]
LATERAL_LENGTH = {"step": 5.0, "bump": 10.0}  # [m]
TAIL = 140.0  # run after the beginning of a disturbance [m]


@dataclass(frozen=True)
class Trace:
    """One run; times are those of the recorded forces, in the middle of their steps.

    Attributes
    ----------
    time : array (n,)
        [s]
    force : array (n, n_wheel)
        Q of every wheel [N].
    side_force : array (n, n_wheel)
        Y [N].
    acceleration : array (n, n_body, 3)
        [m/s^2]
    lateral : array (n, n_body)
        [m]
    patches : array (n, n_wheel)
    """

    time: np.ndarray
    force: np.ndarray
    side_force: np.ndarray
    acceleration: np.ndarray
    lateral: np.ndarray
    patches: np.ndarray


@dataclass(frozen=True)
class SmallBump:
    """A small bump: changes of wheel force and accelerations of both models, below LIMIT_HZ.

    `force`, `linear_force` (n, n_wheelset) [N]; `acceleration`, `linear_acceleration` (n,) of the first body [m/s^2].
    """

    length: float
    height: float
    step: float
    time: np.ndarray
    force: np.ndarray
    linear_force: np.ndarray
    acceleration: np.ndarray
    linear_acceleration: np.ndarray
    share: float  # largest change of force over the static force

    @property
    def force_error(self):
        """Largest difference of a wheel force over the largest change of the same wheel's force [-]."""
        return _worst(self.force, self.linear_force)

    @property
    def acceleration_error(self):
        return _worst(self.acceleration[:, None], self.linear_acceleration[:, None])


@dataclass(frozen=True)
class Waves:
    """Frequency response per metre of rail height, complex; `force` (n, n_wheelset) [N/m], `acceleration` (n,).

    `fine` (m,) are more frequencies, at which there is the linear response alone, `fine_response` (m, n_wheelset + 1).
    """

    frequency: np.ndarray
    force: np.ndarray
    linear_force: np.ndarray
    acceleration: np.ndarray
    linear_acceleration: np.ndarray
    fine: np.ndarray
    fine_response: np.ndarray

    @property
    def force_error(self):
        """Magnitude of the complex difference over that of the linear response, (n,): the worst wheelset."""
        return (np.abs(self.force - self.linear_force) / np.abs(self.linear_force)).max(axis=1)

    @property
    def acceleration_error(self):
        """The same of the first body, over the largest response of all waves: it all but vanishes at high ones."""
        return np.abs(self.acceleration - self.linear_acceleration) / np.abs(self.linear_acceleration).max()


@dataclass(frozen=True)
class LargeBump:
    """A bump beyond the linear range: what both models say of the first wheelset's wheel."""

    height: float
    time: np.ndarray
    force: np.ndarray  # (n,) Q of the leading right wheel [N]
    linear_force: np.ndarray
    lifted: float  # time without contact of the wheel that is off its rail longest [s]
    peak: float  # largest Q of all wheels [N]
    acceleration: float  # largest vertical acceleration of the first body [m/s^2]
    linear_acceleration: float


@dataclass(frozen=True)
class Lateral:
    """A lateral disturbance of both rails: the run, and its mirror image."""

    shape: str
    trace: Trace
    mirror_error: float  # largest difference of lateral places from those of the mirrored disturbance [m]


@dataclass(frozen=True)
class Disturbance:
    """All that the comparison found; `rows` as `validate.judge`."""

    static_force: float
    bumps: list
    waves: Waves
    large: list
    lateral: list
    rows: list


def _worst(found, wanted):
    return float((np.abs(found - wanted).max(axis=0) / np.abs(wanted).max(axis=0)).max())


def traced(scenario, tables):
    """Run a scenario and keep what is compared."""
    scenario, system, _ = with_step(scenario, assemble(scenario, tables))
    parts = []

    def sink(rows):
        copies = (rows.time, rows.rail["q"], rows.rail["y"], rows.acceleration, rows.q[:, :, 1], rows.rail["patches"])
        parts.append([part.copy() for part in copies])

    outcome = simulate(scenario, system, sink)
    if outcome.fault:
        raise SimulationError(f"{scenario.name}: {outcome.fault}")
    time, *others = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Trace(time - 0.5 * scenario.run.step, *others)


def straight(scenario, distance, step, *sources):
    """The scenario on straight track at SPEED with these disturbances, every step recorded."""
    return scenario.varied(
        run={"speed": SPEED, "distance": distance, "duration": None, "step": step, "output_interval": step},
        track=Track((Straight(length=distance + 20.0),)), irregularity=sources, start={"lateral": 0.0},
    )  # fmt: skip


def linear_of(scenario, tables):
    """The linear vertical model of a scenario, its contacts from the static equilibrium; and the static force [N]."""
    system = assemble(scenario, tables)
    rest = static(system).data
    right = rest.contact[::2, 0]
    (_, stiffness), (_, damping) = scenario.track_support.packed()
    rail = (stiffness, damping) if scenario.track_support.gives_way else None
    contacts = [
        Contact(
            force=float(one["normal"]),
            depth=float(one["depth"]),
            cosine=float(np.cos(np.arctan(one["slope"]))),
            creep=float(one["f11"]),
            damping=scenario.contact.damping,
            rail=rail,
        )
        for one in right
    ]
    hold = float(system.model.param[0]["hold"])
    model = vertical_model(scenario.vehicle, contacts, scenario.run.speed, hold, scenario.run.gravity)
    return model, float(rest.rail["q"].mean())


def bump_course(height, length):
    """Rail place (down) and slope over s of a cosine bump at BEGIN."""

    def rail(s):
        angle = 2.0 * np.pi * np.clip((s - BEGIN) / length, 0.0, 1.0)
        return -0.5 * height * (1.0 - np.cos(angle)), -np.pi * height / length * np.sin(angle)

    return rail


def _both(scenario, tables, plain, height, length, step):
    """Trace over a bump, the linear model's outputs at its times, and the static wheel force."""
    case = straight(scenario, BEGIN + TAIL, step, Defect(shape="bump", begin=BEGIN, length=length, amplitude=height))
    model, rest = linear_of(case, tables)
    trace = traced(case, tables)
    per_step = round(step / LINEAR_STEP)
    time = LINEAR_STEP * np.arange(per_step * trace.time.size + 1)
    return trace, model.response(time, bump_course(height, length))[per_step // 2 :: per_step], rest


def small_bump(scenario, tables, plain, length, step):
    """Both models over one of the SMALL bumps, low-passed alike at LIMIT_HZ (Butterworth, fourth order, no phase)."""
    height, wheelsets = SMALL[length], len(scenario.vehicle.wheelsets)
    trace, linear, rest = _both(scenario, tables, plain, height, length, step)
    sections = butter(4, LIMIT_HZ, fs=1.0 / step, output="sos")
    series = (
        (trace.force - plain.force)[:, ::2], linear[:, :wheelsets],
        (trace.acceleration - plain.acceleration)[:, 0, 2], linear[:, wheelsets],
    )  # fmt: skip
    share = float(np.abs(linear[:, :wheelsets]).max() / rest)
    filtered = (sosfiltfilt(sections, one, axis=0) for one in series)
    return SmallBump(length, height, step, trace.time, *filtered, share)


def waves(scenario, tables, step, progress=None):
    """Response to long rows of waves, one frequency after the other, against the linear transfer functions."""
    wheelsets = len(scenario.vehicle.wheelsets)
    rows, linear_rows = [], []
    for number, frequency in enumerate(FREQUENCIES):
        length = SPEED / frequency
        distance = BEGIN + SPEED * (SETTLE + MEASURE)
        plain = straight(scenario, distance, step)
        model, rest = linear_of(plain, tables)
        linear = model.transfer(frequency)[0]
        size = min(WAVE_FORCE * rest / np.abs(linear[:wheelsets]).max(), 0.5 * HIGHEST_WAVE)
        train = Defect(
            shape="bump", begin=BEGIN, length=length, amplitude=2.0 * size,
            repeat=int(np.ceil((distance + 20.0) / length)), every=length,
        )  # fmt: skip
        trace = traced(straight(scenario, distance, step, train), tables)
        late = trace.time >= trace.time[-1] - np.floor(MEASURE * frequency) / frequency
        angle = 2.0 * np.pi * frequency * (trace.time[late] - BEGIN / SPEED)
        basis = np.column_stack([np.cos(angle), np.sin(angle), np.ones(angle.size)])
        values = np.column_stack([trace.force[late, ::2], trace.acceleration[late, 0, 2]])
        fit = np.linalg.lstsq(basis, values, rcond=None)[0] / size
        rows.append(fit[0] - 1j * fit[1])
        linear_rows.append(linear[: wheelsets + 1])
        if progress:
            progress(number + 1)
    found, wanted = np.array(rows), np.array(linear_rows)
    fine = np.geomspace(FREQUENCIES[0], FREQUENCIES[-1], FINE)
    fine_response = model.transfer(fine)[:, : wheelsets + 1]
    return Waves(
        np.array(FREQUENCIES), found[:, :-1], wanted[:, :-1], found[:, -1], wanted[:, -1], fine, fine_response
    )


def large_bump(scenario, tables, plain, height, step):
    """Both models over a bump at which the contact is not linear, and lifts."""
    wheelsets = len(scenario.vehicle.wheelsets)
    trace, linear, rest = _both(scenario, tables, plain, height, LARGE_LENGTH, step)
    off = trace.patches == 0
    return LargeBump(
        height=height,
        time=trace.time,
        force=trace.force[:, 0],
        linear_force=rest + linear[:, 0],
        lifted=float(step * off.sum(axis=0).max()),
        peak=float(trace.force.max()),
        acceleration=float(np.abs(trace.acceleration[:, 0, 2]).max()),
        linear_acceleration=float(np.abs(linear[:, wheelsets]).max()),
    )


def lateral(scenario, tables, shape, step):
    """Both rails move aside: a run, and the same to the other side."""
    traces = []
    for sign in (1.0, -1.0):
        source = Defect(
            shape=shape, direction="lateral", begin=BEGIN, length=LATERAL_LENGTH[shape], amplitude=sign * LATERAL[shape]
        )
        traces.append(traced(straight(scenario, BEGIN + TAIL, step, source), tables))
    return Lateral(shape, traces[0], float(np.abs(traces[0].lateral + traces[1].lateral).max()))


def judge(criteria, bumps, found):
    """Every criterion as (name, found, limit, unit, met, counts for the verdict)."""
    limits = criteria["disturbance"]
    halved = [bump for bump in bumps if bump.step == STEPS[1]]
    rows = [
        (f"bump of {bump.length:g} m, wheel force", 100.0 * bump.force_error, limits["force_percent"])
        for bump in halved
    ]
    rows += [
        ("bumps, car-body acceleration", 100.0 * max(bump.acceleration_error for bump in halved),
         limits["acceleration_percent"]),
        ("waves to 100 Hz, wheel force", 100.0 * found.force_error.max(), limits["response_percent"]),
        ("waves to 100 Hz, car-body acceleration", 100.0 * found.acceleration_error.max(), limits["response_percent"]),
    ]  # fmt: skip
    return [(f"disturbance: {name}", value, limit, "%", bool(value <= limit), True) for name, value, limit in rows]


def compare_disturbance(scenario, tables, criteria, progress):
    """Run every disturbance.

    Parameters
    ----------
    scenario : Scenario
        Whose vehicle, contact and gravity are used.
    tables : sequence of ContactTable
    criteria : dict
        Groups of accept.toml.
    progress : callable
        Called with the share done and a text.

    Returns
    -------
    Disturbance
    """
    plain = {}
    for step in STEPS:
        progress(0.0, "perfect track")
        plain[step] = traced(straight(scenario, BEGIN + TAIL, step), tables)
    bumps = []
    for length in SMALL:
        for step in STEPS:
            progress(0.05 + 0.05 * len(bumps), f"bump of {length:g} m")
            bumps.append(small_bump(scenario, tables, plain[step], length, step))
    found = waves(
        scenario, tables, STEPS[1], lambda done: progress(0.35 + 0.4 * done / len(FREQUENCIES), "frequency response")
    )
    progress(0.75, "wheel lift")
    large = [large_bump(scenario, tables, plain[STEPS[1]], height, STEPS[1]) for height in LARGE]
    progress(0.9, "lateral disturbance")
    aside = [lateral(scenario, tables, shape, STEPS[1]) for shape in LATERAL]
    progress(1.0, "")
    _, rest = linear_of(straight(scenario, BEGIN + TAIL, STEPS[1]), tables)
    return Disturbance(rest, bumps, found, large, aside, judge(criteria, bumps, found))
