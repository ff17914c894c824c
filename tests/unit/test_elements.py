"""Air spring, matrix and torque against closed forms, and what is refused of them."""

import numpy as np
import pytest
import scenes
from numpy.testing import assert_allclose
from pairs import element, forces, pair
from scipy.integrate import solve_ivp

from railcli.errors import InputError
from railcli.files import toml
from railcli.kernels.layout import Axes, Kind
from railcli.model.air import AirSpring
from railcli.model.moments import Matrix
from railcli.model.vehicle import Vehicle, pack

AIR = {
    "name": "air", "at": (0.0, 1.0, 0.5), "area": 0.25, "area_change": 0.4, "volume": 0.05, "reservoir": 0.08,
    "orifice_damping": 3e4, "polytropic": 1.38,
}  # fmt: skip
LOAD = 8e4  # [N]


def air_stiffness(omega):
    """Complex vertical stiffness from pressures and volumes: dp_b = n p (A z - V) / V_b, dp_r = n p V / V_r."""
    n, area, gauge = 1.38, 0.25, LOAD / 0.25
    pressure = gauge + 101325.0
    resistance = 3e4 / area**2  # pressure over volume flow
    # unknowns dp_b, dp_r, V for z = 1
    a = np.array([[1, 0, n * pressure / 0.05], [0, 1, -n * pressure / 0.08], [1, -1, -1j * omega * resistance]])
    change = np.linalg.solve(a, [n * pressure * area / 0.05, 0, 0])
    return gauge * 0.4 + area * change[0]


def packed_air(**values):
    """Element record of an air spring under LOAD."""
    body = {"name": "box", "mass": LOAD / 9.81, "inertia": (1e3, 1e3, 1e3), "x": 0.0, "y": 1.0, "height": 1.0}
    wheelset = {"name": "w", "mass": 1e3, "inertia": (500.0, 100.0, 500.0), "x": 0.0, "wheel_radius": 0.5}
    joint = {"name": "j", "pairs": (("w", "box"),), "axes": "upper", "air_springs": ({**AIR, **values},)}
    return pack(Vehicle(name="v", bodies=(body, wheelset), joints=(joint,)), 9.81, 0.75, 0.3)


def compiled_stiffness(wagon, packed, omega):
    """Of the compiled element, from slopes of its force and its state's rate over height and state."""
    row = packed.element[0].copy()
    system = scenes.replaced(pair(wagon, Axes.UPPER, [row]), curve=packed.curve)
    h = 1e-5

    def at(z, x):
        q = np.zeros((2, 6))
        q[1] = [0.0, row["lower"][1] - row["upper"][1], row["lower"][2] - row["upper"][2] + z, 0, 0, 0]
        force, _, data = forces(system, q, damper=(x,))
        return np.array([force[1, 2], data.damper_rate[0]])

    by_z, by_x = (at(h, 0.0) - at(-h, 0.0)) / (2 * h), (at(0.0, h) - at(0.0, -h)) / (2 * h)
    state = by_z[1] / (1j * omega - by_x[1])
    return -(by_z[0] + by_x[0] * state)


def test_air_spring_over_frequency(wagon):
    packed = packed_air()
    assert packed.element[0]["preload"][2] == pytest.approx(-LOAD)
    for omega in (1e-6, 0.5, 3.0, 20.0, 100.0, 1e5):
        assert compiled_stiffness(wagon, packed, omega) == pytest.approx(air_stiffness(omega), rel=1e-6)
    polytropic = 1.38 * (LOAD / 0.25 + 101325.0) * 0.25**2
    spring = AirSpring(**AIR).stiffness(LOAD)
    slow = spring.area + 1 / (1 / spring.bellows + 1 / spring.reservoir)
    assert abs(air_stiffness(1e-6)) == pytest.approx(slow) and slow == pytest.approx(
        LOAD / 0.25 * 0.4 + polytropic / (0.05 + 0.08)
    )


def test_air_spring_against_masses_of_air():
    """The law of the gas itself: p V^n over mass^n constant in both volumes, air driven by their difference."""
    n, area, gauge, amplitude, omega = 1.38, 0.25, LOAD / 0.25, 2e-4, 8.0
    p0 = gauge + 101325.0
    resistance = 3e4 / area**2

    def pressures(t, share):
        z = amplitude * np.sin(omega * t)
        return p0 * ((1 - share) * 0.05 / (0.05 - area * z)) ** n, p0 * (1 + share * 0.05 / 0.08) ** n

    def flow(t, share):
        bellows, reservoir = pressures(t, share)
        return (bellows - reservoir) / resistance / 0.05

    period = 2 * np.pi / omega
    t = np.linspace(6 * period, 7 * period, 400, endpoint=False)
    share = solve_ivp(flow, (0, t[-1]), [0.0], t_eval=t, rtol=1e-9, atol=1e-14).y[0]
    z = amplitude * np.sin(omega * t)
    force = (pressures(t, share)[0] - 101325.0) * (area + 0.4 * z)
    phasor = 2 * np.mean(force * np.exp(-1j * omega * t)) / (amplitude / 1j)
    assert phasor == pytest.approx(air_stiffness(omega), rel=2e-3)


def test_settled_air_spring_is_the_slow_one(wagon):
    """Equilibria let the air flow: a half step that is very long gives the stiffness of both volumes."""
    row = packed_air().element[0].copy()
    system = pair(wagon, Axes.UPPER, [row])
    q = np.zeros((2, 6))
    q[1, 1:3] = row["lower"][1:] - row["upper"][1:]
    found = []
    for z in (0.0, 1e-3):
        q[1, 2] += z
        found.append(forces(system, q, damper=(0.0,), half_step=1e9)[0][1, 2])
    assert (found[0] - found[1]) / 1e-3 == pytest.approx(abs(air_stiffness(1e-6)), rel=1e-6)


def test_matrix_is_linear_for_small_motions(wagon):
    """Loads of all six motions and rates, one at a time, are minus the columns of both matrices."""
    row = element(Kind.MATRIX, np.random.default_rng(0), matrix=0, lower=0.0, upper=0.0)
    for axes in Axes:
        system = pair(wagon, axes, [row])
        stiffness, damping = np.split(system.model.matrix[0], 2)
        for k in range(6):
            q, v = np.zeros((2, 6)), np.zeros((2, 6))
            q[1, k] = 1e-6
            force, moment, _ = forces(system, q)
            found = np.concatenate([force[1], moment[1]])
            assert_allclose(found, -1e-6 * stiffness[k], atol=1e-11 * np.abs(stiffness).max())
            v[1, k] = 1e-6
            force, moment, _ = forces(system, 0.0 * q, v)
            found = np.concatenate([force[1], moment[1]])
            assert_allclose(found, -1e-6 * damping[k], atol=1e-12 * np.abs(damping).max())


def test_matrix_seen_in_a_mirror():
    """Mirrored twice it is itself; the energy of a mirrored motion in the mirrored matrix is the same."""
    rng = np.random.default_rng(0)
    root = rng.uniform(-1, 1, (6, 6))
    full = root @ root.T
    full = 0.5 * (full + full.T)
    blocks = {"stiffness": full[:3, :3], "coupling_stiffness": full[:3, 3:], "turn_stiffness": full[3:, 3:]}
    blocks = {key: tuple(map(tuple, value)) for key, value in blocks.items()}
    one = Matrix(name="m", at=(0.1, 1.0, 0.5), mirror="xy", **blocks)
    assert_allclose(one.packed((1, 1))[:6], full)
    x = rng.uniform(-1, 1, 6)
    in_y, in_x = np.array([1, -1, 1, -1, 1, -1]), np.array([-1, 1, 1, 1, -1, -1])
    for sign, flip in (((1, -1), in_y), ((-1, 1), in_x), ((-1, -1), in_x * in_y)):
        there = flip * x
        assert there @ one.packed(sign)[:6] @ there == pytest.approx(x @ full @ x)


def test_torsional_swing(wagon):
    """Angular accelerations of two bodies on a torsion bar: k theta / I, opposite."""
    row = element(Kind.TORQUE, np.random.default_rng(0), lower=(1.0, 0.0, 0.0), k=(3e4, 0, 0), c=(50.0, 0, 0))
    system = pair(wagon, Axes.MEAN, [row])
    q, v = np.zeros((2, 6)), np.zeros((2, 6))
    q[1, 3], v[1, 3] = 1e-4, 0.02
    _, moment, _ = forces(system, q, v)
    assert_allclose(moment, [[4.0, 0, 0], [-4.0, 0, 0]], atol=1e-8)


@pytest.mark.parametrize("spins", [(1, 0), (0, 1)], ids=["wheelset below", "wheelset above"])
def test_torque_about_an_axle_turns_its_spin(wagon, spins):
    """It acts on the spin and reacts on the other body, whose power and its own are minus torque times rate."""
    row = element(Kind.TORQUE, np.random.default_rng(0), lower=(0.0, 1.0, 0.0), c=(30.0, 0, 0), preload=(200.0, 0, 0))
    system = pair(wagon, Axes.UPPER, [row], spins=spins)
    wheelset = spins.index(1)
    rng = np.random.default_rng(1)
    q, v = 0.1 * rng.uniform(-1, 1, (2, 6)), rng.uniform(-1, 1, (2, 6))
    q[:, 0] += 5.0
    q[wheelset, 4], v[wheelset, 4] = 0.0, -80.0
    _, moment, data = forces(system, q, v)
    axle = data.frame["axes"][wheelset][:, 1]
    rate = axle @ (data.frame["omega"][1] - data.frame["omega"][0])
    assert_allclose(moment[1], (200.0 - 30.0 * rate) * axle, rtol=1e-9)
    assert_allclose(moment[0], -moment[1])
    assert data.load[wheelset, 4] == pytest.approx((1 if wheelset else -1) * (200.0 - 30.0 * rate), rel=1e-2)


BAD = [
    ("matrix", "stiffness_N_per_m = [[1, 2, 0], [3, 1, 0], [0, 0, 1]]",
     "matrix[1]: stiffness_N_per_m must be symmetric; row 1, column 2 is 2, row 2, column 1 is 3"),
    ("matrix", "stiffness_N_per_m = [[1e6, 2e6, 0], [2e6, 1e6, 0], [0, 0, 1]]",
     "matrix[1]: the stiffness matrix must not have a negative eigenvalue"),
    ("matrix", "stiffness_N_per_m = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
     "coupling_damping_Ns_per_rad = [[0, 5, 0], [0, 0, 0], [0, 0, 0]]",
     "matrix[1]: the damping matrix must not have a negative eigenvalue"),
    ("matrix", "", "matrix[1]: does nothing"),
    ("matrix", "stiffness_N_per_m = [[1, 0], [0, 1]]", "stiffness_N_per_m"),
    ("torque", "axis = [0, 0, 0]\nfriction_Nm = 5", "torque[1]: axis = [0, 0, 0] is no direction"),
    ("torque", "", "torque[1]: does nothing"),
    ("torque", "friction_Nm = -5", "torque[1].friction_Nm: must be >= 0 N m, got -5"),
    ("torque", "turn_table = { angle_rad = [-1, 0, 1], moment_Nm = [-5, 0, -1] }", "moment must not decrease"),
    ("air_spring", "area_m2 = 0.2\nvolume_m3 = 0.05\nreservoir_volume_l = 80", "give either orifice_damping"),
    ("air_spring", "area_m2 = 0\nvolume_m3 = 0.05\nreservoir_volume_m3 = 0.08\norifice_damping_Ns_per_m = 1",
     "air_spring[1].area_m2: must be > 0 m^2, got 0"),
    ("bushing", "damping_Ns_per_m = [0, 5, 0]\n"
     "damper_table_y = { rate_m_per_s = [0, 1], force_N = [0, 1], odd = true }",
     "bushing[1]: give either damping_Ns_per_m along y or damper_table_y, not both"),
    ("bushing", "damper_table_y = { rate_m_per_s = [0, 1, 2], force_N = [0, 2, 1], odd = true }", "must not decrease"),
]  # fmt: skip
PAIR = """
name = "pair"
[[body]]
name = "box"
mass_kg = 1000
inertia_kg_m2 = [1, 1, 1]
x_m = 0
height_m = 1
[[body]]
name = "w"
mass_kg = 1000
inertia_kg_m2 = [1, 1, 1]
x_m = 0
wheel_radius_m = 0.5
[[joint]]
name = "spring"
pairs = [["w", "box"]]
axes = "upper"
[[joint.bushing]]
name = "spring"
at_m = [0, 0, 0.5]
carries_weight = true
[[joint]]
name = "more"
pairs = [["{lower}", "box"]]
[[joint.{kind}]]
name = "it"
{place}
{keys}
"""


def refused(kind, keys, tmp_path, lower="w"):
    place = "" if kind == "torque" else "at_m = [0, 1, 0.5]"
    (tmp_path / "pair.toml").write_text(PAIR.format(kind=kind, keys=keys, place=place, lower=lower))
    with pytest.raises(InputError) as error:
        toml.build(Vehicle, toml.read(tmp_path / "pair.toml"), "pair.toml")
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(("kind", "keys", "message"), BAD)
def test_bad_element(kind, keys, message, tmp_path):
    assert message in refused(kind, keys, tmp_path)


def test_what_a_wheelset_does_not_take(tmp_path):
    passive = "stiffness_N_per_m = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
    assert "would hold the axle of 'w' from turning" in refused("matrix", passive, tmp_path)
    assert "give axis = [0, 1, 0]" in refused("torque", "axis = [1, 0, 0]\nfriction_Nm = 5", tmp_path)
    assert "turns without end about its axle" in refused("torque", "turn_stiffness_Nm_per_rad = 5", tmp_path)
