"""The vehicle description, its statics and its packed arrays."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.errors import InputError
from railcli.files import toml
from railcli.files.scenario import load_vehicle
from railcli.kernels.layout import Axes, Kind
from railcli.model.vehicle import Vehicle, pack, static_wheel_loads

G = 9.81
TAPE_CIRCLE = 0.75

WAGON = """
name = "two-axle wagon"

[[body]]
name = "box"
mass_kg = 20000
inertia_kg_m2 = [2e4, 2e5, 2e5]
x_m = 0.5
height_m = 1.5

[[body]]
name = "front"
mass_kg = 1500
inertia_kg_m2 = [800, 100, 800]
x_m = 4
wheel_radius_m = 0.5

[[body]]
name = "rear"
mass_kg = 1500
inertia_kg_m2 = [800, 100, 800]
x_m = -4
wheel_radius_m = 0.5

[[joint]]
name = "suspension"
pairs = [["front", "box"], ["rear", "box"]]
axes = "upper"

[[joint.bushing]]
name = "spring"
at_m = [0, 1, 0.5]
mirror = "y"
stiffness_N_per_m = [1e6, 1e6, 5e5]
carries_weight = true
spring_table_y = { displacement_mm = [-20, -10, 0, 5], force_N = [-300, 0, 0, 0] }

[[joint.link]]
name = "damper"
lower_m = [0, 1, 0.5]
upper_m = [0, 1, 0.9]
mirror = "y"
damper_table = { rate_m_per_s = [0, 0.1, 0.5], force_N = [0, 1000, 2000], odd = true }
series_stiffness_MN_per_m = 2

[[joint.link]]
name = "valve"
lower_m = [0, 0, 0.5]
upper_m = [0.3, 0, 0.9]
damper_table = { rate_m_per_s = [-0.5, 0, 0.5], force_N = [-2000, 0, 500] }
"""


def build(text, tmp_path):
    path = tmp_path / "wagon.toml"
    path.write_text(text)
    return toml.build(Vehicle, toml.read(path), "wagon.toml")


@pytest.fixture(scope="module")
def manchester():
    return load_vehicle("manchester")


@pytest.fixture(scope="module")
def packed(manchester):
    return pack(manchester, G, TAPE_CIRCLE, 0.3)


@pytest.fixture
def wagon(tmp_path):
    return build(WAGON, tmp_path)


def elements_with_joint(packed):
    for joint in packed.joint:
        for element in packed.element[joint["first"] : joint["first"] + joint["count"]]:
            yield joint, element


def test_manchester_static_loads(manchester, packed):
    """Derived from the masses by hand, see SOURCES.md: 54.546, 45.653 and 78.48 kN."""
    assert_allclose(static_wheel_loads(manchester, G, TAPE_CIRCLE), np.full((4, 2), 54.546e3), atol=tol.PRINTED_LOAD)
    preloads = -packed.element["preload"][:, 2]
    assert_allclose(preloads[preloads != 0.0][:8], 45.653e3, atol=tol.PRINTED_LOAD)
    assert_allclose(preloads[preloads != 0.0][8:], 78.48e3, atol=tol.PRINTED_LOAD)
    assert np.count_nonzero(preloads) == 12
    assert packed.body["mass"].sum() == 44482.0


@pytest.mark.parametrize("which", ["manchester", "wagon"])
def test_preloads_balance_every_sprung_body(which, request):
    vehicle = request.getfixturevalue(which)
    packed = pack(vehicle, G, TAPE_CIRCLE, 0.3)
    force = np.zeros((packed.body.size, 3))
    moment = np.zeros((packed.body.size, 3))
    force[:, 2] = G * packed.body["mass"]
    for joint, element in elements_with_joint(packed):
        for end, sign in (("upper", 1.0), ("lower", -1.0)):
            force[joint[end]] += sign * element["preload"]
            moment[joint[end]] += np.cross(element[end], sign * element["preload"])
    sprung = packed.body["spins"] == 0
    assert_allclose(force[sprung], 0.0, atol=tol.STATICS)
    assert_allclose(moment[sprung], 0.0, atol=tol.STATICS)
    loads = static_wheel_loads(vehicle, G, TAPE_CIRCLE)
    assert_allclose(force[~sprung, 2], loads.sum(axis=1), rtol=tol.ROUNDING)


def test_ends_meet_in_the_nominal_geometry(packed):
    def place(body, arm):
        return packed.rest[body, [0, 1, 2]] + arm

    for joint, element in elements_with_joint(packed):
        apart = place(joint["upper"], element["upper"]) - place(joint["lower"], element["lower"])
        if element["kind"] == Kind.BUSHING:
            assert_allclose(apart, 0.0, atol=tol.PLACE)
        else:
            assert_allclose(np.linalg.norm(apart), element["length"], atol=tol.PLACE)


def test_elements_are_the_same_seen_in_a_mirror(packed):
    def picture(side):
        flip = np.array([1.0, side, 1.0])
        rows = []
        for joint, element in elements_with_joint(packed):
            ends = (element["lower"] * flip, element["upper"] * flip)
            rows.append(
                (joint["lower"], joint["upper"], *np.round(np.concatenate((*ends, element["preload"])), 6) + 0.0)
            )
        return sorted(rows)

    assert picture(1.0) == picture(-1.0)


def test_manchester_arms(packed):
    """Attachment points of the sources less the centres of mass, z down."""
    primary, secondary = packed.joint[0], packed.joint[4]
    spring, damper = packed.element[primary["first"]], packed.element[primary["first"] + 2]
    assert (primary["lower"], primary["upper"], primary["axes"]) == (3, 1, Axes.UPPER)
    assert_allclose(spring["lower"], [0.0, 1.0, 0.0], atol=tol.PLACE)
    assert_allclose(spring["upper"], [1.28, 1.0, 0.14], atol=tol.PLACE)
    assert_allclose(damper["upper"], [1.28, 1.0, -0.28], atol=tol.PLACE)
    assert (secondary["lower"], secondary["upper"], secondary["axes"]) == (1, 0, Axes.MEAN)
    assert_allclose(secondary["turn"], [961e3, 21e3, 0.0])
    spring, stop, rod = packed.element[secondary["first"] + np.array([0, 2, 7])]
    assert_allclose(spring["lower"], [0.0, 1.0, 0.6 - 0.8275], atol=tol.PLACE)
    assert_allclose(spring["upper"], [9.5, 1.0, 1.8 - 0.8275], atol=tol.PLACE)
    assert_allclose(stop["lower"], [0.0, 0.0, -0.05], atol=tol.PLACE)
    assert_allclose(stop["upper"], [9.5, 0.0, 1.15], atol=tol.PLACE)
    assert_allclose(rod["upper"], [10.7, 0.0, 1.2], atol=tol.PLACE)
    rear = packed.element[packed.joint[5]["first"] + 7]
    assert_allclose(rear["upper"], [-8.3, 0.0, 1.2], atol=tol.PLACE)
    assert_allclose((rod["k"][0], rod["c"][0], rod["series"], rod["state"]), (5e6, 25e3, 0.0, -1))


def test_manchester_bump_stop(packed):
    """Two points of the published table, the clearance, both signs, and the slope beyond its end."""
    (curve,) = packed.curve
    x, y = curve["x"][: curve["count"]], curve["y"][: curve["count"]]
    assert_allclose(np.interp([0.0, 0.025, -0.025, 0.040, -0.0575], x, y), [0.0, 0.0, 0.0, 3730.0, -23185.0], atol=1e-9)
    assert_allclose((y[-1] - y[-2]) / (x[-1] - x[-2]), 40.16e6)
    used = packed.element["spring_curve"]
    assert np.argwhere(used >= 0).tolist() == [[18, 1], [26, 1]]


def test_damper_states(packed):
    """Two primary dampers on each wheelset, two vertical and two lateral secondary ones on each bogie."""
    states = packed.element["state"]
    assert sorted(states[states >= 0]) == list(range(16))
    assert_allclose(packed.damper[states[states >= 0]], packed.element["length"][states >= 0])
    assert (packed.element["series"][states >= 0] > 0.0).all()


def test_rest_and_wheels(manchester, packed):
    assert_allclose(packed.rest[:, 0], [0.0, 9.5, -9.5, 10.78, 8.22, -8.22, -10.78])
    assert_allclose(packed.rest[:, 2], [-1.8, -0.6, -0.6, -0.46, -0.46, -0.46, -0.46])
    assert_allclose(packed.rest[:, [1, 3, 4, 5]], 0.0)
    assert packed.wheel["body"].tolist() == [3, 3, 4, 4, 5, 5, 6, 6]
    assert packed.wheel["side"].tolist() == [1.0, -1.0] * 4
    assert (packed.wheel["lateral"] == TAPE_CIRCLE).all() and (packed.wheel["radius"] == 0.46).all()
    assert packed.body["spins"].tolist() == [0, 0, 0, 1, 1, 1, 1]
    assert {manchester.bodies[i].wheel_radii for i in manchester.wheelsets} == {(0.46, 0.46)}
    assert not any(array.flags.writeable for array in packed)


def test_wagon_with_a_load_off_centre(wagon):
    """Lever rule: the box stands 3.5 m behind the front axle and 4.5 m before the rear one."""
    loads = static_wheel_loads(wagon, G, TAPE_CIRCLE)
    front = G * (1500.0 + 20000.0 * 4.5 / 8.0)
    rear = G * (1500.0 + 20000.0 * 3.5 / 8.0)
    assert_allclose(loads, [[front / 2] * 2, [rear / 2] * 2], rtol=tol.ROUNDING)
    assert pack(wagon, G, TAPE_CIRCLE, 0.3).wheel["radius"].tolist() == [0.5] * 4


def test_springs_beside_the_middle_load_one_wheel_more(tmp_path):
    """A box on two springs, 0.2 m right of the middle in front and 0.2 m left behind: wheel loads by the lever."""
    text = WAGON.replace("x_m = 0.5", "x_m = 0").split("[[joint]]")[0]
    for name, y in (("front", 0.2), ("rear", -0.2)):
        text += f"""
            [[joint]]
            name = "{name} suspension"
            pairs = [["{name}", "box"]]
            axes = "upper"
            [[joint.bushing]]
            name = "spring"
            at_m = [0, {y}, 0.5]
            carries_weight = true
            """
    more = G * 10000.0 * 0.2 / (2.0 * TAPE_CIRCLE)
    half = G * 11500.0 / 2.0
    loads = static_wheel_loads(build(text, tmp_path), G, TAPE_CIRCLE)
    assert_allclose(loads, [[half + more, half - more], [half - more, half + more]], rtol=tol.ROUNDING)


def test_mirrored_table_is_turned_round(wagon):
    """The table acts on one side only: pushed left it resists on the right, pushed right on the left."""
    packed = pack(wagon, G, TAPE_CIRCLE, 0.3)

    def force(element, displacement):
        curve = packed.curve[element["spring_curve"][1]]
        return np.interp(displacement, curve["x"][: curve["count"]], curve["y"][: curve["count"]])

    for element in packed.element[:2]:
        side = np.sign(element["lower"][1])
        assert force(element, -0.015 * side) == pytest.approx(-150.0 * side)
        assert force(element, 0.004 * side) == 0.0


def test_damper_tables(wagon):
    """Force over rate, mirrored; in series with a spring or not."""
    packed = pack(wagon, G, TAPE_CIRCLE, 0.3)
    series, plain = packed.element[2], packed.element[4]
    assert (series["series"], series["state"]) == (2e6, 0) and plain["state"] == -1
    curve = packed.curve[series["damper_curve"][0]]
    assert curve["x"][: curve["count"]].tolist() == [-0.5, -0.1, 0.0, 0.1, 0.5]
    assert curve["y"][: curve["count"]].tolist() == [-2000.0, -1000.0, 0.0, 1000.0, 2000.0]
    curve = packed.curve[plain["damper_curve"][0]]
    assert curve["x"][: curve["count"]].tolist() == [-0.5, 0.0, 0.5]
    assert packed.damper.tolist() == pytest.approx([0.4] * 4)


def test_single_wheelset_is_a_vehicle(tmp_path):
    text = 'name = "one"\n[[body]]' + WAGON.split("[[body]]")[2]
    vehicle = build(text, tmp_path)
    packed = pack(vehicle, G, TAPE_CIRCLE, 0.3)
    assert packed.joint.size == packed.element.size == packed.damper.size == 0
    assert_allclose(static_wheel_loads(vehicle, G, TAPE_CIRCLE), [[750.0 * G, 750.0 * G]])


BAD = [
    ("mass_kg = 20000", "mass_kg = -3.0", "body[1].mass_kg: must be > 0 kg, got -3.0"),
    ("mass_kg = 20000", "mass_t = -3", "body[1].mass_t: must be > 0 t, got -3"),
    ("mass_kg = 20000", "mass_kg = nan", "body[1].mass_kg: must be a finite number, got nan"),
    ("mass_kg = 20000", 'mass_kg = "20 t"', "body[1].mass_kg: must be a number, got '20 t'"),
    ("mass_kg = 20000", "mass_kg = true", "body[1].mass_kg: must be a number, got true"),
    ("mass_kg = 20000", "mass_kN = 200", "body[1].mass_kN: unknown key; did you mean 'mass_kg' or 'mass_t'?"),
    ("mass_kg = 20000", "mas_kg = 20000", "body[1].mas_kg: unknown key; did you mean 'mass_kg'?"),
    ("mass_kg = 20000", "mass = 20000", "body[1].mass: unknown key; did you mean 'mass_kg' or 'mass_t'?"),
    ("mass_kg = 20000", "", "body[1]: key 'mass_kg' is missing"),
    ("mass_kg = 20000", "mass_kg = 2\nmass_t = 3", "body[1].mass_t: 'mass_kg' says the same"),
    ("[2e4, 2e5, 2e5]", "[2e4, 0, 2e5]", "body[1].inertia_kg_m2[2]: must be > 0 kg m^2, got 0"),
    ("[2e4, 2e5, 2e5]", "[2e4, 2e5]", "body[1].inertia_kg_m2: must have more than 2 values"),
    ("[2e4, 2e5, 2e5]", "[1, 2, 3, 4]", "body[1].inertia_kg_m2: must have at most 3 entries, got 4"),
    ("[2e4, 2e5, 2e5]", "7", "body[1].inertia_kg_m2: must be a list, got 7"),
    ("height_m = 1.5", "", "body[1]: give either height_m"),
    (
        "wheel_radius_m = 0.5",
        "wheel_radius_m = 0.5\nleft_wheel_radius_mm = 480",
        "left_wheel_radius_m: must be within 10 mm of wheel_radius_m, got 0.48 m and 0.5 m",
    ),
    ("height_m = ", "left_wheel_radius_m = 0.5\nheight_m = ", "left_wheel_radius_m: only beside wheel_radius_m"),
    ("wheel_radius_m = 0.5", "wheel_radius_mm = 5", "body[2].wheel_radius_mm: must be >= 50 mm, got 5"),
    ('name = "rear"', 'name = "front"', "body[3].name: 'front' is taken by body[2]"),
    ('["rear", "box"]', '["raer", "box"]', "joint[1].pairs[2]: no body is named 'raer'; did you mean 'rear'?"),
    ('["rear", "box"]', '["rear"]', "joint[1].pairs[2]: must have more than 1 values"),
    ('["rear", "box"]', '["rear", "rear"]', "joint[1].pairs[2]: joins 'rear' with itself"),
    ('mirror = "y"', 'mirror = "yx"', "joint[1].bushing[1].mirror: must be 'none', 'x', 'y' or 'xy', got 'yx'"),
    ('mirror = "y"', 'miror = "y"', "joint[1].bushing[1].miror: unknown key; did you mean 'mirror'?"),
    ("at_m = [0, 1, 0.5]", "at_m = [0, 0, 0.5]", "joint[1].bushing[1]: mirror = 'y', but its y is 0"),
    ("at_m = [0, 1, 0.5]", "at_m = [0.5, 1, 0.5]", "bushing[1] acts 500 mm ahead of and 0 mm over the axle of 'front'"),
    ("x_m = -4\n", "x_m = -4\ny_m = 0.1\n", "body[3]: y_m: a wheelset stands in the middle of the track, got 0.1 m"),
    ("[-20, -10, 0, 5]", "[-20, -10, -10, 5]", "bushing[1].spring_table_y: displacement must increase"),
    ("[-20, -10, 0, 5]", "[-20, -10, 0]", "bushing[1].spring_table_y: displacement has 3 values, force has 4"),
    ("[-300, 0, 0, 0]", "[-300, 0, 0, -1]", "bushing[1].spring_table_y: force must not decrease"),
    ("[-300, 0, 0, 0]", "[-300, 0, 1, 1]", "bushing[1].spring_table_y: must pass through (0, 0)"),
    ("[0, 1000, 2000]", "[0, 1000, 900]", "link[1].damper_table: force must not decrease"),
    ('["rear", "box"]]', '["rear", "box"], ["box", "rear"]]', "joint[1].pairs[3]: 'box' and 'rear' are joined by this"),
    ("carries_weight = true", "carries_weight = false", "nothing carries 'box' at rest"),
    ("x_m = 0.5", "x_m = 50", "'rear' would lift off at rest"),
    ('name = "suspension"', "turn_stiffness_Nm_per_rad = [0, 1, 0]", "joint[1]: key 'name' is missing"),
    ("[[joint.bushing]]", "turn_stiffness_kNm_per_rad = [0, 1, 0]\n[[joint.bushing]]", "a wheelset spins"),
    ("upper_m = [0, 1, 0.9]", "upper_m = [0, 1, 0.5]", "link[1]: lower_m and upper_m are the same point"),
    ("series_stiffness_MN_per_m = 2", "damping_Ns_per_m = 2", "link[1]: give either damping_Ns_per_m or damper_table"),
    ("[[body]]", "[body]", "is not valid TOML"),
    ("wheel_radius_m", "height_m", "no body is a wheelset"),
]


@pytest.mark.parametrize(("old", "new", "message"), BAD)
def test_bad_vehicle(old, new, message, tmp_path):
    assert old in WAGON
    count = 2 if old == "wheel_radius_m" else 1
    with pytest.raises(InputError) as error:
        build(WAGON.replace(old, new, count), tmp_path)
    assert message in str(error.value) and "wagon.toml: " in str(error.value)
    assert "\n" not in str(error.value)


def test_several_faults_are_counted(tmp_path):
    with pytest.raises(InputError, match=r"body\[2\]\.mass_kg: must be > 0 kg, got 0 \(and 1 more\)$"):
        build(WAGON.replace("mass_kg = 1500", "mass_kg = 0"), tmp_path)


def test_unknown_vehicle():
    with pytest.raises(InputError, match="mancester: .*did you mean 'manchester'"):
        load_vehicle("mancester")


def test_elements_follow_the_axle_of_worn_wheels(tmp_path):
    """Wheels 4 mm smaller in radius under the same heights: the springs act on the axle, unstretched as before."""
    worn = build(WAGON.replace("wheel_radius_m = 0.5", "wheel_radius_m = 0.496", 1), tmp_path)
    packed = pack(worn, G, TAPE_CIRCLE, 0.3)
    for joint, element in elements_with_joint(packed):
        assert element["lower"][[0, 2]].tolist() == [0.0, 0.0]
        apart = packed.rest[joint["upper"], :3] + element["upper"] - packed.rest[joint["lower"], :3] - element["lower"]
        length = 0.0 if element["kind"] == Kind.BUSHING else element["length"]
        assert_allclose(np.linalg.norm(apart), length, atol=tol.PLACE)
