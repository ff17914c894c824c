"""Linearisation: eigenvalues against closed forms, hand calculations and the motion of the compiled model itself."""

from functools import cache

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from railcli.analysis.equilibrium import static
from railcli.analysis.linear import linear_about, linearise, modes, on_straight
from railcli.analysis.mode_shapes import describe
from railcli.analysis.quasi_linear import PATCH, QuasiLinear, linear_table, lines_of, quasi_linear, quasi_linear_system
from railcli.analysis.rigid_contact import Wheelset
from railcli.analysis.stability import locus
from railcli.files.scenario import load
from railcli.kernels.layout import BODY, ELEMENT, JOINT, Kind, new_data
from railcli.kernels.step import advance, evaluate
from railcli.model.contact_table import mount
from railcli.model.elements import Bushing, Joint
from railcli.model.scenario import Contact, Run, Scenario
from railcli.model.track import Straight, Track
from railcli.model.vehicle import Body, Vehicle

G = 9.81


def two_masses(wagon, masses, **element):
    """Two bodies above each other in free space, joined by one element; upper one 1 m over the lower."""
    body = np.zeros(2, BODY)
    body["mass"], body["inertia"] = masses, 1.0
    joint, record = np.zeros(1, JOINT), np.zeros(1, ELEMENT)
    joint["upper"], joint["count"] = 1, 1
    for key in ("spring_curve", "damper_curve", "stiff", "state", "source", "matrix"):
        record[key] = -1
    for key, value in element.items():
        record[key] = value
    system = scenes.replaced(scenes.floating(wagon), body=body, joint=joint, element=record)
    data = new_data(system.model, [[0.0, 0, 0, 0, 0, 0], [0.0, 0, -1.0, 0, 0, 0]], int(record["state"][0] >= 0))
    data.damper[:] = 1.0
    return modes(linear_about(system, data, 0.0))


def nearest(found, wanted):
    """For each wanted value the nearest of those found."""
    return np.array([found[np.argmin(np.abs(found - value))] for value in np.atleast_1d(wanted)])


def test_two_masses_on_a_spring_and_damper(wagon):
    m1, m2, k, c = 2000.0, 3000.0, 4e5, 5e3
    found = two_masses(wagon, (m1, m2), kind=Kind.BUSHING, k=(k, k, k), c=(0.0, 0.0, c), upper=[0.0, 0.0, 1.0]).value
    m = m1 * m2 / (m1 + m2)
    wanted = np.roots([m, c, k])
    wanted = wanted[wanted.imag > 0]
    assert_allclose(nearest(found, wanted), wanted, rtol=tol.EIGENVALUE)


def test_damper_with_series_stiffness(wagon):
    """A spring beside a damper that has a spring in series: roots of m s^3 + (m ks/c) s^2 + (k + ks) s + k ks/c."""
    m1, m2, k, ks, c = 1500.0, 2500.0, 3e5, 1e6, 8e3
    found = two_masses(
        wagon, (m1, m2), kind=Kind.LINK, k=(k, 0, 0), c=(c, 0, 0), series=ks, state=0, length=1.0
    ).value  # fmt: skip
    m = m1 * m2 / (m1 + m2)
    wanted = np.roots([m, m * ks / c, k + ks, k * ks / c])
    wanted = wanted[wanted.imag >= 0]
    assert wanted.size == 2
    assert_allclose(nearest(found, wanted), wanted, rtol=tol.EIGENVALUE)


# --- one wheelset ---

F11, F22, LOAD, STIFF = 6e6, 5e6, 5e4, 1e12


def textbook_line(conicity):
    """Contact of the textbooks: a conicity, no contact angle, no spin creep, hard contact."""
    depth = (LOAD / STIFF) ** (2.0 / 3.0)
    values = {"HERTZ": STIFF, "SEMI_X": 1.0, "SEMI_Y": 1.0, "F11": F11 / depth, "F22": F22 / depth}
    patch = tuple(values.get(name, 0.0) for name in PATCH)
    return QuasiLinear(1e-3, conicity, conicity, 0.0, 0.0, 0.0, 0.0, 0.46, 0.0, patch, False)


def textbook_scenario(lateral, yaw, speed=20.0):
    """A wheelset under a body so heavy that it does not swing, in so little gravity that its wheel load is usual."""
    frame = Body(name="frame", mass=1e7, inertia=(1e9, 1e9, 1e9), x=0.0, height=0.5)
    wheelset = Body(name="wheelset", mass=1500.0, inertia=(800.0, 100.0, 900.0), x=0.0, wheel_radius=0.46)
    bushing = Bushing(
        name="spring", at=(0.0, 0.0, 0.46), stiffness=(1e9, lateral, 1e8), turn_stiffness=(1e9, 0.0, yaw),
        carries_weight=True,
    )  # fmt: skip
    joint = Joint(name="suspension", pairs=(("wheelset", "frame"),), axes="upper", bushings=(bushing,))
    return Scenario(
        name="textbook",
        vehicle=Vehicle(name="textbook", bodies=(frame, wheelset), joints=(joint,)),
        run=Run(speed=speed, gravity=2.0 * LOAD / (1e7 + 1500.0)),
        track=Track((Straight(length=500.0),)),
        contact=Contact(damping=0.0),
    )


def textbook_matrix(speed, conicity, lateral, yaw):
    """m y'' + 2 f22 (y'/V - psi) + ky y = 0;  I psi'' + 2 f11 (b^2 psi'/V + b conicity y/r) + kpsi psi = 0."""
    m, inertia, b, r = 1500.0, 900.0, 0.75, 0.46
    return np.array(
        [
            [0, 0, 1, 0],
            [0, 0, 0, 1],
            [-lateral / m, 2 * F22 / m, -2 * F22 / (m * speed), 0],
            [-2 * F11 * b * conicity / (r * inertia), -yaw / inertia, 0, -2 * F11 * b * b / (inertia * speed)],
        ]
    )


def textbook_critical(conicity, lateral, yaw):
    """Speed at which the equations above have a root on the imaginary axis, and its angular frequency."""
    m, inertia, b, r = 1500.0, 900.0, 0.75, 0.46
    omega2 = (F11 * b * b * lateral + F22 * yaw) / (F11 * b * b * m + F22 * inertia)
    rest = (lateral - m * omega2) * (yaw - inertia * omega2)
    return np.sqrt(4 * F11 * F22 * b * b * omega2 / (4 * F11 * F22 * conicity * b / r + rest)), np.sqrt(omega2)


@pytest.mark.parametrize("speed", [20.0, 45.0, 80.0])
def test_wheelset_on_springs_has_the_textbook_roots(speed):
    conicity, lateral, yaw = 0.1, 4e5, 1e6
    system = quasi_linear_system(textbook_scenario(lateral, yaw, speed), [textbook_line(conicity)])
    wanted = np.linalg.eigvals(textbook_matrix(speed, conicity, lateral, yaw))
    swings, creeps = wanted[wanted.imag > 0.0], wanted[wanted.imag == 0.0]
    found = modes(linearise(system)).value
    assert_allclose(nearest(found, swings), swings, rtol=tol.TEXTBOOK)
    assert_allclose(nearest(found, creeps), creeps, rtol=tol.TEXTBOOK_CREEP)


def test_wheelset_on_a_yaw_spring_has_the_textbook_critical_speed():
    conicity, lateral, yaw = 0.15, 2e5, 1.5e6
    critical, omega = textbook_critical(conicity, lateral, yaw)
    assert np.abs(np.linalg.eigvals(textbook_matrix(critical, conicity, lateral, yaw)).real).min() < 1e-6
    system = quasi_linear_system(textbook_scenario(lateral, yaw), [textbook_line(conicity)])

    def hunting(speed):
        found = modes(linearise(system, speed))
        k = int(np.argmin(np.abs(found.value - 1j * omega)))
        assert describe(found, k).words == "wheelset hunting"
        return found.value[k]

    found = brentq(lambda speed: hunting(speed).real, 0.8 * critical, 1.2 * critical)
    assert found == pytest.approx(critical, rel=tol.TEXTBOOK)
    assert hunting(found).imag == pytest.approx(omega, rel=tol.TEXTBOOK)


@pytest.mark.parametrize("angle", [0.01, 0.025])
def test_slow_cone_has_klingel_wavelength(angle):
    """Differences of the contact table itself: cones on round rails are smooth."""
    table = scenes.cone_table(angle)
    speed = 2.0
    system = scenes.lone_wheelset(table, speed)
    found = modes(linearise(system))
    hunting = [k for k in np.flatnonzero(found.oscillates) if describe(found, k).words == "wheelset hunting"]
    assert len(hunting) == 1
    half = table.settings.lateral - scenes.HEAD * np.sin(angle)
    wanted = 2 * np.pi * np.sqrt(half * table.settings.radius / np.tan(angle))
    assert speed / found.frequency[hunting[0]] == pytest.approx(wanted, rel=tol.KLINGEL)


def cone_line(angle, amplitude=3e-3):
    settings = scenes.round_settings()
    mounting = mount(scenes.cone(angle), scenes.round_rail(), settings)
    return quasi_linear(Wheelset(mounting, mounting, settings.lateral), [amplitude], settings)[0], settings


def test_cone_has_wickens_parameters():
    """Wickens (1965): conicity g (l + R g)/(l - r g), roll -g/(l - r g); the contact angle follows the roll."""
    angle = 0.04
    line, settings = cone_line(angle)
    half, radius = settings.lateral - scenes.HEAD * np.sin(angle), settings.radius
    apart = half - radius * angle
    assert line.conicity == pytest.approx(angle * (half + scenes.HEAD * angle) / apart, rel=tol.WICKENS)
    assert line.roll == pytest.approx(-angle / apart, rel=tol.WICKENS)
    assert line.angle == pytest.approx(angle / apart, rel=tol.WICKENS)
    assert line.equivalent == pytest.approx(line.conicity, rel=tol.WICKENS)


def test_quasi_linear_table_moves_as_the_cone_does():
    """Two ways to the same linear wheelset: its own contact table, and straight lines packed as one."""
    angle, speed = 0.04, 25.0
    own = scenes.lone_wheelset(scenes.cone_table(angle), speed)
    packed = scenes.lone_wheelset(linear_table(*cone_line(angle, 0.5e-3)), speed)
    table, lines = modes(linearise(own)), modes(linearise(packed))
    for one in (table, lines):
        assert one.oscillates.sum() == 3 and one.free == 1
    assert_allclose(lines.value[lines.oscillates], table.value[table.oscillates], rtol=tol.SAME_CONE)


# --- the wagon ---


def test_contact_table_and_quasi_linear_contact_agree_where_contact_is_smooth(wagon, profiles):
    """At 1:20 nothing jumps near the middle: differences of the table see the same wagon as lines over 0.5 mm."""
    case, lines = line_at(20.0, 0.5e-3, profiles)
    own = modes(linearise(wagon, 60.0))
    packed = modes(linearise(quasi_linear_system(case, lines), 60.0))
    for words in ("car body lower sway", "bogie hunting, bogies in phase", "bogie hunting, bogies in antiphase"):
        one, other = own.value[named(own, words)], packed.value[named(packed, words)]
        assert other == pytest.approx(one, rel=tol.TABLE_OR_LINES)


@cache
def line_at(inclination, amplitude, profiles):
    case = load("stability").varied(contact={"inclination": inclination})
    return case, lines_of(case, *profiles, [amplitude])[0]


@pytest.fixture(scope="module")
def quasi(profiles):
    """The wagon at 1:40 and 60 m/s with quasi-linear contact of 3 mm."""
    case, lines = line_at(40.0, 3e-3, profiles)
    return quasi_linear_system(case.varied(run={"speed": 60.0}), lines)


@pytest.fixture(scope="module")
def found(quasi):
    return modes(linearise(quasi))


def named(found, words):
    """Index of the only mode of these words."""
    (k,) = [k for k in np.flatnonzero(found.oscillates) if describe(found, k).words == words]
    return k


def vertical_twin(pitching):
    """Eigenvalues of car body and bogies, rigid wheels: bounce, or pitch of the car body with bogies opposed.

    Half lengths 1 or 9.5 m turn car body motion into that over a bogie. States: car body, bogie, their rates, length of
    secondary and primary damper.
    """
    arm = 9.5 if pitching else 1.0
    m = np.array([1.97e6 / arm**2 if pitching else 32000.0, 2 * 2615.0])
    k2, k1, c2, s2, c1, s1 = 4 * 430e3, 8 * 1.22e6, 4 * 20e3, 4 * 6e6, 8 * 4e3, 8 * 1e6
    a = np.zeros((6, 6))
    a[0, 2] = a[1, 3] = 1.0
    force2 = np.array([k2 + s2, -k2 - s2, 0, 0, -s2, 0])
    force1 = np.array([0, k1 + s1, 0, 0, 0, -s1])
    a[2] = -force2 / m[0]
    a[3] = (force2 - force1) / m[1]
    a[4] = np.array([s2, -s2, 0, 0, -s2, 0]) / c2
    a[5] = np.array([0, s1, 0, 0, 0, -s1]) / c1
    return np.linalg.eigvals(a)


@pytest.mark.parametrize("words, pitching", [("car body bounce", False), ("bogie bounce, in phase", False),
                                             ("bogie bounce, in antiphase", True)])  # fmt: skip
def test_vertical_modes_by_hand(found, words, pitching):
    """Masses, springs and dampers with series stiffness of the vehicle file, added up by hand."""
    value = found.value[named(found, words)]
    assert value == pytest.approx(nearest(vertical_twin(pitching), value)[0], rel=tol.BY_HAND)


def test_car_body_pitch_by_hand(found):
    """The same for its pitch, which the traction rods, 1.2 m under its centre, load a little."""
    value = found.value[named(found, "car body pitch")]
    assert value.imag == pytest.approx(nearest(vertical_twin(True), value)[0].imag, rel=tol.PITCH_BY_HAND)


def test_left_right_symmetry_parts_the_modes(found):
    """Of single modes not a trace of the other plane; equal ones may mix. No mode is mixed."""
    value = found.value
    for k in range(value.size):
        assert describe(found, k).plane in ("vertical", "lateral")
        if np.sum(np.abs(value - value[k]) < 1e-3 * np.abs(value[k])) == 1:
            q = np.abs(found.linear.coordinates(found.right[k]))
            assert min(q[:, [0, 2, 4]].max(), q[:, [1, 3, 5]].max()) < tol.OTHER_PLANE


def test_matrix_is_its_own_mirror_image(found):
    """Mirrored left to right, bodies move by the same matrix."""
    linear = found.linear
    n = 12 * linear.size
    sign = np.tile([1.0, -1, 1, -1, 1, -1], 2 * linear.size)[linear.kept[linear.kept < n]]
    part = linear.matrix[: sign.size, : sign.size]
    assert_allclose(sign[:, None] * part * sign, part, atol=tol.MIRRORED_MATRIX * np.abs(part).max())


def test_eigenvalues_do_not_depend_on_the_step(quasi, found):
    for scale in (0.5, 2.0):
        change = found.shift(linearise(quasi, scale=scale))
        assert np.abs(change / found.value).max() < tol.STEP_FREE


def test_linear_contact_knows_no_limit_of_creep(profiles, quasi):
    """Whatever law and friction a scenario has, quasi-linear contact is Kalker's linear theory."""
    case, lines = line_at(40.0, 3e-3, profiles)
    law = {"creep_law": "polach", "friction": 0.1, "slip_reduction": 0.5, "friction_ratio": 0.5, "friction_decay": 1.0}
    other = quasi_linear_system(case.varied(run={"speed": 60.0}, contact=law), lines)
    assert_allclose(linearise(other).matrix, linearise(quasi).matrix, rtol=0.0, atol=0.0)


def test_left_and_right_eigenvectors(found):
    a = found.linear.matrix
    size = np.abs(a) @ np.abs(found.right).T
    assert_allclose(a @ found.right.T, found.right.T * found.value, atol=tol.EIGENVECTOR * size.max())
    assert_allclose(found.left.conj() @ found.right.T, np.eye(found.value.size), atol=tol.BIORTHOGONAL)


def deviation(system, rest, x, size):
    """Data of the steady motion with a state x added, its largest displacement `size`."""
    data = type(rest)(*(array.copy() for array in rest))
    n = data.q.size
    data.q[:] += size * x[:n].reshape(data.q.shape)
    data.v[:] += size * x[n : 2 * n].reshape(data.v.shape)
    data.damper[:] += size * x[2 * n :]
    assert evaluate(system.model, data, 0.0) == 0
    return data


@pytest.mark.parametrize(
    "words",
    ["car body lower sway", "car body yaw", "car body bounce", "car body pitch", "bogie hunting, bogies in phase",
     "bogie hunting, bogies in antiphase", "bogie bounce, in phase", "bogie pitch, in antiphase"],
)  # fmt: skip
def test_compiled_model_swings_as_the_mode_says(found, words):
    """Begun on an eigenvector, a time run follows Re(x exp(s t)): frequency, damping and shape at once."""
    k, size, step = named(found, words), 1e-5, 0.1e-3
    system = on_straight(found.linear.system, 200.0, step=step)
    x = found.linear.expand(found.right[k])
    data, rest = (deviation(system, found.linear.data, x.real, share) for share in (size, 0.0))
    for _ in range(4):
        assert advance(system.model, data, round(0.1 / step)) == 0
        assert advance(system.model, rest, round(0.1 / step)) == 0
        moved = data.q - rest.q
        wanted = size * (x * np.exp(found.value[k] * data.clock[0])).real[: moved.size].reshape(moved.shape)
        for q in (moved, wanted):
            q[:, 0] -= q[0, 0]
            q[system.model.body["spins"] > 0, 4] = 0.0
        amplitude = size * np.exp(found.value[k].real * data.clock[0])
        assert np.abs(moved - wanted).max() < tol.FREE_SWING * amplitude


def test_bounce_decays_on_the_wagons_own_table(wagon):
    """A car body set 1 mm lower on real profiles: period and decay of its swing are those of the bounce mode."""
    system = on_straight(wagon, 400.0, speed=20.0)
    linear = modes(linearise(system))
    k = named(linear, "car body bounce")
    rest = static(system).data
    data = system.start()
    data.q[:, 2:] = rest.q[:, 2:]
    still, height = rest.q[0, 2], []
    data.q[0, 2] += 1e-3
    for _ in range(400):
        assert advance(system.model, data, 10) == 0
        height.append(data.q[0, 2] - still)
    height = np.array(height)
    crossings = np.flatnonzero(height[:-1] * height[1:] < 0.0)
    times = 5e-3 * (1 + crossings + height[crossings] / (height[crossings] - height[crossings + 1]))
    period = 2.0 * np.diff(times)[1:].mean()
    peaks = [np.abs(height[a:b]).max() for a, b in zip(crossings[:-1], crossings[1:], strict=True)]
    assert 1.0 / period == pytest.approx(linear.frequency[k], rel=tol.BOUNCE_RUN)
    decay = 2.0 * np.log(peaks[1] / peaks[2]) / period
    assert -decay == pytest.approx(linear.value[k].real, rel=tol.BOUNCE_DECAY)


def test_wagon_decays_below_its_critical_speed_and_grows_above(profiles):
    """Time runs with the quasi-linear contact on both sides of the linear critical speed, at the rate of the root."""
    case, lines = line_at(40.0, 3e-3, profiles)
    base = quasi_linear_system(case, lines)
    critical = locus(base, 3e-3, [60.0, 75.0, 90.0])
    assert critical.mode == "bogie hunting, bogies in phase"
    for share in (0.97, 1.03):
        system = on_straight(base, 400.0, speed=share * critical.critical, step=0.25e-3)
        found = modes(linearise(system))
        k = named(found, critical.mode)
        data = deviation(system, found.linear.data, found.linear.expand(found.right[k]).real, 1e-6)
        peaks = []
        for _ in range(160):
            assert advance(system.model, data, 100) == 0
            peaks.append(np.abs(data.q[list(system.wheelsets), 1]).max())
        early, late = max(peaks[:40]), max(peaks[-40:])
        assert (late > early) == (share > 1.0)
        assert np.log(late / early) / 3.0 == pytest.approx(found.value[k].real, rel=tol.GROWTH)


def test_all_motion_dies_when_all_roots_are_left(quasi, found):
    """A random disturbance of everything, in a run long enough for the slowest mode."""
    assert found.value.real.max() < 0.0
    system = on_straight(quasi, 800.0)
    rng = np.random.default_rng(4)
    x = found.linear.expand(rng.uniform(-1.0, 1.0, found.linear.kept.size))
    data = deviation(system, found.linear.data, x, 1e-5)
    data.v[:] = found.linear.data.v
    start = data.q - found.linear.data.q
    seconds = 12.0
    assert advance(system.model, data, round(seconds / system.model.param[0]["step"])) == 0
    left = np.abs((data.q - found.linear.data.q)[:, [1, 2, 3, 5]]).max()
    assert left < 5.0 * np.exp(found.value.real.max() * seconds) * np.abs(start).max()
