"""The longest stable step: closed forms, and predicted against what time steps do."""

import numpy as np
import pytest
import scenes
import tolerances as tol

from railcli.analysis.simulate import settled_start
from railcli.analysis.step_limit import CEILING, FLOOR, by_rule, step_limit, stiffest
from railcli.kernels.layout import CURVE, ELEMENT, JOINT, Kind
from railcli.kernels.step import advance
from railcli.model.sections import Straight
from railcli.model.track import Track, pack

MASSES = 3000.0, 1500.0
REDUCED = MASSES[0] * MASSES[1] / sum(MASSES)


def closed(omega, zeta):
    """omega h <= 2 (sqrt(1 + 4 zeta^2) - 2 zeta): a root of the step's polynomial at -1."""
    return 2.0 * (np.sqrt(1.0 + 4.0 * zeta**2) - 2.0 * zeta) / omega


def one_mass(omega, zeta, h):
    """Matrix of one step on (q, v, dv): q_m = q + h/2 v, v_p = v + h/2 dv, dv = -omega^2 q_m - 2 zeta omega v_p."""
    dv = np.array([-(omega**2), -(omega**2) * h / 2 - 2 * zeta * omega, -2 * zeta * omega * h / 2])
    v = np.array([0.0, 1.0, 0.0]) + h * dv
    return np.array([np.array([1.0, h, 0.0]) + 0.5 * h * h * dv, v, dv])


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.2, 0.5, 1.0, 3.0])
def test_rule_is_the_closed_form(zeta):
    """The rule for one mode, its closed form, and the eigenvalues of the recurrence, which leave the circle there."""
    omega = 700.0
    limit = closed(omega, zeta)
    assert by_rule(np.array([[omega**2]]), np.array([[2 * zeta * omega]]), 1.0) == pytest.approx(
        limit, rel=tol.STEP_BISECTED
    )
    within, beyond = (np.abs(np.linalg.eigvals(one_mass(omega, zeta, f * limit))).max() for f in (0.999, 1.001))
    assert within <= 1.0 + tol.ROUNDING and beyond > 1.0
    assert min(abs(np.linalg.eigvals(one_mass(omega, zeta, limit)) + 1.0)) < tol.STEP_ROOT


def test_rule_of_a_damper_alone():
    """c h / m <= 1."""
    assert by_rule(np.zeros((1, 1)), np.array([[800.0]]), 1.0) == pytest.approx(1 / 800.0, rel=tol.STEP_BISECTED)


def test_rule_at_its_bounds():
    assert by_rule(np.zeros((2, 2)), np.zeros((2, 2)), CEILING) == CEILING
    assert by_rule(np.eye(1) * 1e18, np.zeros((1, 1)), CEILING) < 2.0 * FLOOR


@pytest.fixture(scope="module")
def pair(wagon):
    """Function that joins two free bodies by one spring and damper along y and lets them swing against each other."""

    def grown(stiffness, damping, step, seconds=0.4):
        system = scenes.bodies(wagon, MASSES, [(1000.0, 1000.0, 1000.0)] * 2, [0, 0])
        joint, element = np.zeros(1, JOINT), np.zeros(1, ELEMENT)
        joint["upper"], joint["count"] = 1, 1
        element["kind"], element["k"][0, 1], element["c"][0, 1] = Kind.BUSHING, stiffness, damping
        for key in ("spring_curve", "damper_curve", "stiff", "state", "source", "matrix"):
            element[key] = -1
        system = scenes.tuned(scenes.replaced(system, joint=joint, element=element), step=step)
        data = scenes.data_at(system.model, np.zeros((2, 6)), np.zeros((2, 6)))
        data.q[1, 1], data.v[1, 1] = 1e-6, 1e-4
        assert advance(system.model, data, round(seconds / step)) == 0
        return abs(data.v[1, 1] - data.v[0, 1])

    return grown


@pytest.mark.parametrize("zeta", [0.05, 0.3, 1.0])
def test_compiled_step_of_two_bodies(pair, zeta):
    """Two bodies and the element between them: the closed form with the reduced mass, in the compiled step."""
    omega = 500.0
    stiffness, damping = omega**2 * REDUCED, 2 * zeta * omega * REDUCED
    limit = closed(omega, zeta)
    assert pair(stiffness, damping, 0.98 * limit) < 1e-4 < 1.0 < pair(stiffness, damping, 1.03 * limit)


def settled(system, step, seconds=3.0):
    """Change of a wheel force from step to step at the end of a run on straight track, over the wheel's force [-]."""
    system = system.stepped(step)
    data = settled_start(system)
    data.q[:, 1] += 1e-6
    if advance(system.model, data, round(seconds / step)):
        return np.inf
    before = data.rail["q"].copy()
    if advance(system.model, data, 1):
        return np.inf
    return np.abs(data.rail["q"] / before - 1.0).max()


VARIED = {  # field of an element, factor; and what limits the step then
    "stiff": ("k", 100.0, "primary spring between wheelset"),
    "damped": ("c", 30.0, "primary spring between wheelset"),
    "series": ("series", 300.0, "secondary vertical damper between bogie"),
}


@pytest.fixture(scope="module")
def straight(wagon):
    return scenes.replaced(stiffest(wagon), track=pack(Track((Straight(length=200.0),))))


@pytest.mark.parametrize("name", VARIED)
def test_predicted_and_found_on_straight_track(straight, name):
    """A run is quiet below the limit and rattles or falls beyond; the element is named."""
    field, factor, culprit = VARIED[name]
    element = straight.model.element.copy()
    element[field] *= factor
    system = scenes.replaced(straight, element=element)
    limit = step_limit(system)
    assert culprit in limit.limited_by
    quiet, loud = (settled(system, share * limit.stable) for share in (1 / tol.STEP_FOUND, tol.STEP_FOUND))
    assert quiet < tol.STEP_QUIET < 0.1 < loud


def test_wagon_is_limited_at_the_flange_root(straight):
    """Three patches at 6 mm; found by runs through curves and over winding rails at 1.13 to 1.25 ms (docs/step.md)."""
    limit = step_limit(straight)
    assert limit.stable == pytest.approx(1.22e-3, rel=tol.STEP_FLANGE)
    assert "W1 on its rails 6" in limit.limited_by and "3 patches right" in limit.limited_by


def test_limit_grows_with_the_root_of_the_mass(straight):
    """Wheelsets on their contacts: K and C/sqrt(K) as they are, so that h grows with sqrt(m), but for the damping."""
    body = straight.model.body.copy()
    spins = body["spins"] == 1
    body["mass"][spins] *= 0.5
    body["inertia"][spins] *= 0.5
    light, usual = step_limit(scenes.replaced(straight, body=body)).stable, step_limit(straight).stable
    assert light / usual == pytest.approx(np.sqrt(0.5), rel=tol.STEP_MASS)


def test_speed_hardly_counts(straight):
    slow, fast = (step_limit(straight, (speed,)).stable for speed in (1.0, 90.0))
    assert slow == pytest.approx(fast, rel=tol.STEP_BISECTED)


def test_steep_end_of_a_table_counts(straight):
    """A table that is soft at rest limits the step as a spring of its steepest slope does."""
    steep = 2e9
    element = straight.model.element.copy()
    place = int(np.flatnonzero(element["kind"] == Kind.BUSHING)[0])
    linear = element.copy()
    linear["k"][place, 2] += steep
    curve = np.zeros(1, CURVE)
    curve["count"], curve["x"][0, :4] = 4, (-6e-3, -5e-3, 5e-3, 6e-3)
    curve["y"][0, :4] = -1e-3 * steep, 0.0, 0.0, 1e-3 * steep
    element["spring_curve"][place, 2] = straight.model.curve.size
    tabled = scenes.replaced(straight, element=element, curve=np.concatenate([straight.model.curve, curve]))
    limits = [step_limit(system) for system in (scenes.replaced(straight, element=linear), tabled)]
    assert limits[0].stable < 0.9 * step_limit(straight).stable
    assert limits[1].stable == pytest.approx(limits[0].stable, rel=tol.STEP_BISECTED)
    assert limits[0].limited_by == limits[1].limited_by and "primary spring" in limits[0].limited_by

