"""Modes on blocked wheelsets against closed forms: the Manchester wagon's lateral plane with preload, plane vehicles.

docs/stability.md, section 1.4, derives the lateral plane. Nothing of the closed forms uses the code under test.
"""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.equilibrium import static
from railcli.analysis.linear import linear_about
from railcli.files.scenario import load
from railcli.model.elements import Joint
from railcli.model.system import assemble
from railcli.model.vehicle import Body, Vehicle, static_wheel_loads

G = 9.81


def blocked(system):
    """Eigenvalues [1/s] of a system whose wheelsets do not move, each pair once."""
    rest = static(system).data
    rest.damper[:] = system.damper
    linear = linear_about(system, rest, 0.0)
    n = linear.size
    body = linear.kept % (6 * n) // 6
    moves = (linear.kept >= 12 * n) | ~np.isin(body, list(system.wheelsets))
    values = np.linalg.eigvals(linear.matrix[np.ix_(moves, moves)])
    return values[values.imag > 0.0]


# --- the lateral plane of the Manchester wagon; y to the right, z down, small y, roll, yaw of three bodies ---

CAR, FRONT, REAR = 0, 1, 2
HEIGHT = {CAR: 1.8, FRONT: 0.6, REAR: 0.6}
PLACE = {CAR: 0.0, FRONT: 9.5, REAR: -9.5}


def moved(body, x, y, height):
    """Displacement (3, 9) of a point of a body over (y, roll, yaw) of all three: theta x u, with roll and yaw."""
    rows = np.zeros((3, 9))
    up, ahead = height - HEIGHT[body], x - PLACE[body]
    rows[:, 3 * body : 3 * body + 3] = [[0.0, 0.0, -y], [1.0, up, ahead], [0.0, y, 0.0]]
    return rows


def roll_of(body):
    row = np.zeros(9)
    row[3 * body + 1] = 1.0
    return row


def lateral_roots():
    """Of M q'' + (K + N G) q = dampers; the second-order height of a loaded spring's stretch is q^T G q / 2."""
    mass = np.array([32000.0, 56800.0, 1.97e6] + 2 * [2615.0, 1722.0, 3067.0])
    k, c = np.zeros((9, 9)), np.zeros((9, 9))
    series = []  # rows, damping, stiffness in series

    def spring(stretch, stiffness, damping=(0.0, 0.0, 0.0)):
        k[:] += stretch.T @ np.diag(stiffness) @ stretch
        c[:] += stretch.T @ np.diag(damping) @ stretch

    def preload(load, turning, stretch, rise):
        """load times the second-order part of the stretch downwards: its ends' own and what the turned axes take."""
        pair = np.outer(turning, stretch[1])
        k[:] += load * (rise - pair - pair.T)

    def own_rise(body, up):
        """u_z = -up below a turned body comes down by -u_z roll^2 / 2."""
        return up * np.outer(roll_of(body), roll_of(body))

    primary, secondary = (32000.0 + 2 * 2615.0) * G / 8.0, 32000.0 * G / 4.0
    for bogie in (FRONT, REAR):
        for y in (1.0, -1.0):
            for ahead in (1.28, -1.28):
                stretch = moved(bogie, PLACE[bogie] + ahead, y, 0.46)
                spring(stretch, (31.391e6, 3.884e6, 1.22e6), (15e3, 2e3, 0.0))
                preload(primary, roll_of(bogie), stretch, own_rise(bogie, 0.46 - 0.6))
                series.append((moved(bogie, PLACE[bogie] + ahead, y, 0.88)[2], 4e3, 1e6))
            stretch = moved(CAR, PLACE[bogie], y, 0.8275) - moved(bogie, PLACE[bogie], y, 0.8275)
            spring(stretch, (160e3, 160e3, 430e3))
            rise = own_rise(CAR, 0.8275 - 1.8) - own_rise(bogie, 0.8275 - 0.6)
            preload(secondary, 0.5 * (roll_of(CAR) + roll_of(bogie)), stretch, rise)
            vertical = moved(CAR, PLACE[bogie], 1.3 * y, 0.925) - moved(bogie, PLACE[bogie], 1.3 * y, 0.40)
            lateral = moved(CAR, PLACE[bogie], 0.665 * y, 0.70) - moved(bogie, PLACE[bogie], 0.23 * y, 0.70)
            series += [(vertical[2], 20e3, 6e6), (lateral[1], 32e3, 6e6)]
        turn = roll_of(CAR) - roll_of(bogie)
        k += (940e3 + 2 * 10.5e3) * np.outer(turn, turn)  # anti-roll bar, bending of both springs
    rows, damping, stiff = (np.array(part) for part in zip(*series, strict=True))
    k += rows.T @ np.diag(stiff) @ rows
    back = rows.T * stiff  # T = stiff (l - x), dx/dt = T / damping
    zero, one = np.zeros((9, 9)), np.eye(9)
    matrix = np.block(
        [
            [zero, one, np.zeros((9, stiff.size))],
            [-k / mass[:, None], -c / mass[:, None], back / mass[:, None]],
            [rows * (stiff / damping)[:, None], np.zeros((stiff.size, 9)), -np.diag(stiff / damping)],
        ]
    )
    values = np.linalg.eigvals(matrix)
    return values[values.imag > 1e-3]


def nearest(found, wanted):
    return found[np.abs(found[None, :] - wanted[:, None]).argmin(axis=1)]


def frequency_and_damping(values):
    """[Hz], [%]"""
    return np.stack([values.imag / (2.0 * np.pi), -100.0 * values.real / np.abs(values)], axis=-1)


def test_lateral_plane_of_the_manchester_wagon(wagon):
    """Every oscillation of the closed form, preload included, is one of the compiled model's."""
    wanted = lateral_roots()
    assert wanted.size == 9
    assert_allclose(nearest(blocked(wagon), wanted), wanted, rtol=tol.BLOCKED)


def test_sways_of_an_independent_derivation(wagon):
    """Lower and upper sway and two bogie modes as another author derived and printed them."""
    printed = np.array([[0.549, 22.15], [1.171, 43.09], [9.86, 42.0], [13.29, 17.4]])
    digit = np.array([[1e-3, 1e-2], [1e-3, 1e-2], [1e-2, 0.1], [1e-2, 0.1]])
    found = frequency_and_damping(blocked(wagon))
    place = [np.abs(found - row).sum(axis=1).argmin() for row in printed]
    assert (np.abs(found[place] - printed) < tol.HALF_A_DIGIT * digit).all()


# --- vehicles in the vertical plane: DanielCanteroNTNU/TTB-2D, which names the papers ---

PLANE = {  # body, bogie: mass, pitch inertia; wheelset; centres, wheelbase; primary per axle, secondary per bogie: k, c
    "Pioneer M": (42400, 1.0644e6, 3400, 7200, 2200, 18.0, 2.5, 1.04e6, 30e3, 400e3, 33e3),
    "Pioneer R": (44000, 2.74e6, 1700, 1700, 1900, 18.0, 2.5, 0.70e6, 38e3, 350e3, 40e3),
    "Manchester": (32000, 1.97e6, 2615, 1476, 1813, 19.0, 2.56, 2.44e6, 8e3, 860e3, 40e3),
}
PLANE_HZ = {  # of the undamped vehicle: body, then bogies
    "Pioneer M": (0.6318, 1.1291, 3.3814, 3.3814, 4.3076, 4.3294),
    "Pioneer R": (0.5669, 0.6462, 5.1144, 5.1168, 5.7091, 5.7091),
    "Manchester": (1.0739, 1.2991, 7.4705, 7.4772, 11.7138, 11.7138),
}
PLANE_KN = {"Pioneer M": 71.123, "Pioneer R": 67.444, "Manchester": 54.546}
STIFF = 1e9  # along and across the track, so that only the vertical plane moves
HUB = 0.46  # all centres and springs at one height: no preload turns anything


def plane_vehicle(name, damped):
    car, car_pitch, bogie, bogie_pitch, wheelset, centres, base, k1, c1, k2, c2 = PLANE[name]
    half, quarter = 0.5 * centres, 0.5 * base
    bodies = [Body(name="car body", mass=car, inertia=(1e6, car_pitch, 1e6), x=0.0, height=HUB)]
    pairs = []
    for k, x in enumerate((half, -half)):
        bodies.append(Body(name=f"bogie {k}", mass=bogie, inertia=(1e4, bogie_pitch, 1e4), x=x, height=HUB))
        for ahead in (quarter, -quarter):
            name_of = f"wheelset {len(pairs)}"
            bodies.append(
                Body(name=name_of, mass=wheelset, inertia=(1e3, 100.0, 1e3), x=x + ahead, wheel_radius=HUB)
            )
            pairs.append((name_of, f"bogie {k}"))

    def suspension(name, pairs, stiffness, damping, axes):
        spring = {
            "name": "spring", "at_m": [0.0, 1.0, HUB], "mirror": "y", "carries_weight": True,
            "stiffness_N_per_m": [STIFF, STIFF, 0.5 * stiffness],
            "damping_Ns_per_m": [0.0, 0.0, 0.5 * damping if damped else 0.0],
        }  # fmt: skip
        return Joint.model_validate({"name": name, "pairs": pairs, "axes": axes, "bushing": [spring]})

    joints = (
        suspension("primary", pairs, k1, c1, "upper"),
        suspension("secondary", [("bogie 0", "car body"), ("bogie 1", "car body")], k2, c2, "mean"),
    )
    return Vehicle(name=name, bodies=tuple(bodies), joints=joints)


def plane_roots(name, damped):
    """Of the plane vehicle, by hand: heights and pitches of body and bogies that move alike or opposed."""
    car, car_pitch, bogie, bogie_pitch, _, centres, base, k1, c1, k2, c2 = PLANE[name]
    values = []
    for mass in (car, car_pitch / (0.5 * centres) ** 2):  # bounce; pitch, as motion over a bogie
        m = np.diag([mass, 2.0 * bogie])
        k, c = (2.0 * np.array([[b, -b], [-b, b + 2.0 * a]]) for a, b in ((k1, k2), (c1, c2)))
        values += second_order(m, k, c * damped)
    pitch = 2.0 * (0.5 * base) ** 2
    turning = (np.array([[x]]) for x in (bogie_pitch, pitch * k1, pitch * c1 * damped))
    return np.array(values + 2 * second_order(*turning))


def second_order(m, k, c):
    """Eigenvalues of m q'' + c q' + k q = 0, of each pair the one with positive frequency."""
    zero, inverse = np.zeros_like(m, dtype=float), np.linalg.inv(m)
    found = np.linalg.eigvals(np.block([[zero, np.eye(len(m))], [-inverse @ k, -inverse @ c]]))
    return list(found[found.imag > 0.0])


def plane_system(name, table, damped):
    scenario = load("straight-60")
    return assemble(scenario.model_copy(update={"vehicle": plane_vehicle(name, damped)}), [table])


@pytest.mark.parametrize("name", PLANE)
def test_plane_vehicles_have_their_published_frequencies(name, table):
    system = plane_system(name, table, damped=False)
    found, wanted = blocked(system).imag / (2.0 * np.pi), np.array(PLANE_HZ[name])
    assert_allclose(nearest(found, wanted), wanted, rtol=0.0, atol=tol.PRINTED_HZ)
    loads = static_wheel_loads(plane_vehicle(name, False), G, 0.75)
    assert_allclose(1e-3 * loads, PLANE_KN[name], rtol=0.0, atol=1e-3 * tol.PRINTED_LOAD)


@pytest.mark.parametrize("name", PLANE)
def test_plane_vehicles_with_their_dampers(name, table):
    wanted = plane_roots(name, damped=True)
    found = blocked(plane_system(name, table, damped=True))
    assert_allclose(nearest(found, wanted), wanted, rtol=tol.BLOCKED_PLANE)
