"""The published curve of the Manchester wagon against this model.

The printed table has no signs. Displacements here are towards the outer rail [mm]; in a right-hand curve that is -y.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from railcli.errors import SimulationError
from railcli.model.system import assemble

from .equilibrium import static, steady
from .simulate import SteadyWindow, simulate
from .steady_values import expected_forces, final_stretch, means, peaks_to_peaks
from .step_choice import with_step

FRICTION_RANGE = (0.05, 0.60)  # within which friction is identified
FRICTION_STEP = 0.025
READINGS = ("as_printed", "exchanged", "trailing_inside")
SUPPORTED = "exchanged"  # the reading that the balances bear out, and that the verdict uses
TRAILING = (1, 3)  # W2 and W4


@dataclass(frozen=True)
class Reference:
    """Published displacements as printed [mm], rows by printed speed [m/s], columns W1 ... W4."""

    speeds: tuple
    simulink: np.ndarray
    adams: np.ndarray

    def read(self, reading):
        """Simulink and ADAMS values towards the outer rail at true speed, in one of READINGS.

        as_printed: all outwards, each row at its printed speed.  exchanged: all outwards, the first and the last row
        with their labels exchanged.  trailing_inside: W2 and W4 towards the inner rail.
        """
        if reading == "exchanged":
            return self.simulink[::-1], self.adams[::-1]
        if reading == "trailing_inside":
            sign = np.ones(4)
            sign[list(TRAILING)] = -1.0
            return self.simulink * sign, self.adams * sign
        return self.simulink, self.adams


@dataclass(frozen=True)
class Curving:
    """Steady values of one run; SI but for displacements.

    Attributes
    ----------
    speed : float
        [m/s]
    outwards_mm, peak_to_peak_mm : array (4,)
        Lateral displacement of the wheelsets towards the outer rail.
    yaw : array (4,)
        Against the track's tangent, positive when the wheelset steers towards the outer rail (attack) [rad].
    q_outer, q_inner : array (4,)
        Vertical wheel forces on the rails [N].
    y_outwards : array (4,)
        Lateral force of both rails on each wheelset, outwards positive [N].
    expected_y, expected_q : float
        Mass times acceleration, in the track plane (outwards) and normal to it [N].
    hold : float
        Force that keeps the speed [N].
    """

    speed: float
    outwards_mm: np.ndarray
    peak_to_peak_mm: np.ndarray
    yaw: np.ndarray
    q_outer: np.ndarray
    q_inner: np.ndarray
    y_outwards: np.ndarray
    expected_y: float
    expected_q: float
    hold: float

    @property
    def sum_y(self):
        return float(self.y_outwards.sum())

    @property
    def sum_q(self):
        return float((self.q_outer + self.q_inner).sum())


def run_curve(scenario, tables, progress=None):
    """Run a scenario that ends in a curve and average its end.

    Returns
    -------
    Curving
    """
    scenario, system, _ = with_step(scenario, assemble(scenario, tables))
    window = SteadyWindow(scenario.distance - scenario.average_over)
    outcome = simulate(scenario, system, window, progress)
    if outcome.fault:
        raise SimulationError(f"{scenario.name}: {outcome.fault}")
    stretch = final_stretch(scenario)
    mean = means(system, stretch, window)
    on_rails_y, on_rails_q = expected_forces(scenario, stretch)
    return Curving(
        speed=scenario.run.speed,
        outwards_mm=mean.lateral * 1e3,
        peak_to_peak_mm=peaks_to_peaks(system, stretch, window).lateral * 1e3,
        yaw=mean.yaw,
        q_outer=mean.q_force[:, 0],
        q_inner=mean.q_force[:, 1],
        y_outwards=-mean.y_force.sum(axis=1),
        expected_y=-on_rails_y,
        expected_q=on_rails_q,
        hold=float(window.mean("traction")),
    )


def steady_displacements(scenario, tables, speeds):
    """Quasi-static displacements towards the outer rail [mm], (n_speed, n_wheelset); NaN where there is none."""
    system = assemble(scenario, tables)
    stretch = final_stretch(scenario)
    rows = []
    for speed in speeds:
        try:
            data = steady(system, stretch.curvature, stretch.cant, speed).data
            rows.append(stretch.outwards * data.q[list(system.wheelsets), 1] * 1e3)
        except SimulationError:
            rows.append(np.full(len(system.wheelsets), np.nan))
    return np.array(rows)


def holding_forces(scenario, tables, speeds, outwards_mm):
    """Lateral force that would have to hold W2 and W4 where a reading puts them, outwards positive [N], (n_speed, 2).

    The other wheelsets and bodies take their own steady places. NaN where the model has no such motion.
    """
    system = assemble(scenario, tables)
    stretch = final_stretch(scenario)
    forces = []
    for speed, row in zip(speeds, outwards_mm, strict=True):
        held = {system.wheelsets[k]: stretch.outwards * row[k] * 1e-3 for k in TRAILING}
        try:
            data = steady(system, stretch.curvature, stretch.cant, speed, held).data
            forces.append([-stretch.outwards * data.load[i, 1] for i in held])
        except SimulationError:
            forces.append([np.nan] * len(held))
    return np.array(forces)


def deviations(ours, simulink, adams):
    """Root mean square from either code and the largest deviation from either [mm]."""
    from_simulink, from_adams = ours - simulink, ours - adams
    return {
        "rms_simulink_mm": float(np.sqrt(np.mean(from_simulink**2))),
        "rms_adams_mm": float(np.sqrt(np.mean(from_adams**2))),
        "max_mm": float(max(np.abs(from_simulink).max(), np.abs(from_adams).max())),
    }


@dataclass(frozen=True)
class Scan:
    """Displacements over friction: `friction` (n,), `outwards_mm` (n, n_speed, n_wheelset)."""

    friction: np.ndarray
    outwards_mm: np.ndarray


def scan_friction(scenario, tables, speeds, progress=None):
    """Quasi-static curving over FRICTION_RANGE; values of friction without a steady motion are left out."""
    low, high = FRICTION_RANGE
    values = np.linspace(low, high, round((high - low) / FRICTION_STEP) + 1)
    kept, rows = [], []
    for number, friction in enumerate(values):
        moved = steady_displacements(scenario.varied(contact={"friction": float(friction)}), tables, speeds)
        if np.isfinite(moved).all():
            kept.append(friction)
            rows.append(moved)
        if progress:
            progress(number + 1, len(values))
    return Scan(np.array(kept), np.array(rows))


def identify_friction(scan, simulink, adams):
    """One friction for all runs by least squares against both codes, with a jackknife over the cells.

    It absorbs unknown differences between the models and is no measurement of friction.

    Returns
    -------
    best, low, high : float
        Estimate and twice its jackknife standard error to either side, within the scanned range.
    at_bound : bool
        The estimate lies at an end of the scanned range.
    """
    curve = CubicSpline(scan.friction, scan.outwards_mm.reshape(scan.friction.size, -1))
    targets = np.array([simulink.ravel(), adams.ravel()])
    bounds = (scan.friction[0], scan.friction[-1])

    def fit(weight):
        def misfit(friction):
            return float((weight * (curve(friction) - targets) ** 2).sum())

        coarse = min(scan.friction, key=misfit)
        near = (max(bounds[0], coarse - 2 * FRICTION_STEP), min(bounds[1], coarse + 2 * FRICTION_STEP))
        found = minimize_scalar(misfit, bounds=near, method="bounded", options={"xatol": 1e-6})
        return min((found.x, *bounds), key=misfit)

    n = targets.shape[1]
    best = fit(np.ones(n))
    left_out = np.array([fit(np.arange(n) != k) for k in range(n)])
    error = np.sqrt((n - 1) / n * ((left_out - left_out.mean()) ** 2).sum())
    return (
        float(best),
        float(max(best - 2.0 * error, bounds[0])),
        float(min(best + 2.0 * error, bounds[1])),
        bool(min(abs(best - bounds[0]), abs(best - bounds[1])) < 1e-4),
    )


def judge(criteria, nominal, identified, leading_mm, balance_kn):
    """Every criterion as (name, found, limit, unit, met, counts for the verdict).

    Parameters
    ----------
    criteria : dict
        Groups of accept.toml.
    nominal, identified : dict
        As `deviations`, for the supported reading.
    leading_mm : float
        Largest deviation of W1 and W3 from either code.
    balance_kn : float
        Largest error of a force balance.
    """
    rows = [
        ("nominal, rms from Simulink", nominal["rms_simulink_mm"], criteria["nominal"]["rms_mm"], "mm", True),
        ("nominal, rms from ADAMS", nominal["rms_adams_mm"], criteria["nominal"]["rms_mm"], "mm", True),
        ("nominal, largest of one cell", nominal["max_mm"], criteria["nominal"]["max_mm"], "mm", True),
        ("force balances, largest error", balance_kn, criteria["balance"]["force_kN"], "kN", True),
        ("nominal, largest of W1 and W3", leading_mm, criteria["leading"]["max_mm"], "mm", False),
        (
            "identified, rms from Simulink",
            identified["rms_simulink_mm"],
            criteria["identified"]["rms_simulink_mm"],
            "mm",
            False,
        ),
        ("identified, rms from ADAMS", identified["rms_adams_mm"], criteria["identified"]["rms_adams_mm"], "mm", False),
        ("identified, largest of one cell", identified["max_mm"], criteria["identified"]["max_mm"], "mm", False),
    ]
    return [(name, found, limit, unit, bool(found <= limit), counts) for name, found, limit, unit, counts in rows]


@dataclass(frozen=True)
class Validation:
    """All that the comparison found.

    Attributes
    ----------
    reference : Reference
    nominal, identified : list of Curving
        Runs at the true speeds, in the order of the reference's rows.
    friction : tuple
        Identified value, low and high end of its interval, and whether it lies at an end of the range.
    scan : Scan
        Over friction, quasi-static.
    variants : dict of str to array (n_speed, n_wheelset)
        Displacements of other assumptions [mm], quasi-static.
    holding : dict of str to list of two arrays (n_speed, 2)
        Forces that would have to hold W2 and W4 where each reading puts them by the mean of both codes [N]: nominal,
        and with the identified friction.
    static_q : array (n_wheel,)
        Wheel loads at rest on straight track [N].
    weight : float
        [N]
    rows : list
        As `judge`.
    """

    reference: Reference
    nominal: list
    identified: list
    friction: tuple
    scan: Scan
    variants: dict
    holding: dict
    static_q: np.ndarray
    weight: float
    rows: list

    def displacements(self, runs=None):
        """Towards the outer rail [mm], rows by true speed; of the nominal runs unless others are given."""
        return np.array([run.outwards_mm for run in (runs or self.nominal)])

    def readings(self, runs=None):
        """Deviations under every reading."""
        ours = self.displacements(runs)
        return {reading: deviations(ours, *self.reference.read(reading)) for reading in READINGS}


def balance_error(runs):
    """Largest error of the sums of Y and Q over runs [N]."""
    return max(max(abs(run.sum_y - run.expected_y), abs(run.sum_q - run.expected_q)) for run in runs)


def compare_manchester(reference, criteria, scenarios, tables, other_inclination, progress):
    """Run the published curve and compare it.

    Parameters
    ----------
    reference : Reference
    criteria : dict
        Groups of accept.toml.
    scenarios : sequence of Scenario
        One per reference row, at its speed: the nominal assumptions.
    tables : sequence of ContactTable
        Of these scenarios.
    other_inclination : tuple of Scenario, tables
        The curve on rails of another inclination.
    progress : callable
        Called with the number of steps done of 30, and a sentence.

    Returns
    -------
    Validation
    """
    speeds, base = reference.speeds, scenarios[0]
    supported = reference.read(SUPPORTED)
    rest = static(assemble(base, tables)).data
    nominal = []
    for number, scenario in enumerate(scenarios):
        progress(number, f"{scenario.run.speed:g} m/s, nominal")
        nominal.append(run_curve(scenario, tables))
    scan = scan_friction(base, tables, speeds, lambda done, of: progress(3 + 18 * done / of, "friction 0.05 to 0.60"))
    friction = identify_friction(scan, *supported)
    identified = []
    for number, scenario in enumerate(scenarios):
        progress(21 + number, f"{scenario.run.speed:g} m/s, friction {friction[0]:.3f}")
        identified.append(run_curve(scenario.varied(contact={"friction": friction[0]}), tables))
    progress(24, "other assumptions")
    other, other_tables = other_inclination
    variants = {
        "friction 0.40": steady_displacements(base.varied(contact={"friction": 0.4}), tables, speeds),
        "creep law smooth": steady_displacements(base.varied(contact={"creep_law": "smooth"}), tables, speeds),
        f"inclination 1:{other.contact.inclination:g}": steady_displacements(other, other_tables, speeds),
    }
    progress(26, "what would hold the trailing wheelsets")
    fitted = base.varied(contact={"friction": friction[0]})
    holding = {
        reading: [
            holding_forces(scenario, tables, speeds, np.mean(reference.read(reading), axis=0))
            for scenario in (base, fitted)
        ]
        for reading in READINGS
    }
    progress(30, "")
    ours = np.array([run.outwards_mm for run in nominal])
    leading = max(np.abs(ours[:, ::2] - code[:, ::2]).max() for code in supported)
    rows = judge(
        criteria,
        deviations(ours, *supported),
        deviations(np.array([run.outwards_mm for run in identified]), *supported),
        float(leading),
        balance_error(nominal) * 1e-3,
    )
    mass = sum(body.mass for body in base.vehicle.bodies)
    return Validation(
        reference, nominal, identified, friction, scan, variants, holding, rest.rail["q"].copy(),
        mass * base.run.gravity, rows,
    )  # fmt: skip
