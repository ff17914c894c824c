"""Descriptions of dry friction, leaf springs and given preloads: what is packed, what is refused."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.errors import InputError
from railcli.files import toml
from railcli.kernels.layout import Kind
from railcli.model.vehicle import Vehicle, carried, pack, static_wheel_loads

G, TAPE_CIRCLE = 9.81, 0.75

WAGON = """
name = "two-axle wagon on leaf springs"

[[body]]
name = "box"
mass_kg = 20000
inertia_kg_m2 = [2e4, 2e5, 2e5]
x_m = 0
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
name = "shackles"
at_m = [0, 1, 0.5]
mirror = "y"
stiffness_N_per_m = [1e6, 3e5, 0]
carries_weight = true

[[joint.bushing]]
name = "helper spring"
at_m = [0, 0, 0.5]
stiffness_N_per_m = [0, 0, 1e5]
preload_N = 20000

[[joint.leaf_spring]]
name = "leaves"
at_m = [0, 1, 0.5]
mirror = "y"
stiffness_N_per_m = 8e5
friction_N = 3000
decay_mm = 2

[[joint.friction]]
name = "shackle friction"
at_m = [0, 1, 0.5]
mirror = "y"
directions = "xy"
limit_N = 100
coefficient = 0.1
load_of = "shackles"
series_stiffness_MN_per_m = 5

[[joint.friction]]
name = "strut"
lower_m = [0, 0, 0.5]
upper_m = [0.3, 0, 0.9]
limit_N = 500
series_stiffness_N_per_m = 2e6
series_damping = 0
"""


def build(text, tmp_path):
    path = tmp_path / "wagon.toml"
    path.write_text(text)
    return toml.build(Vehicle, toml.read(path), "wagon.toml")


@pytest.fixture
def packed(tmp_path):
    return pack(build(WAGON, tmp_path), G, TAPE_CIRCLE, 0.3)


def test_each_friction_feels_the_bushing_beside_it(packed):
    dry = [row for row in packed.element if row["kind"] == Kind.DRY]
    assert len(dry) == 4
    for row in dry:
        source = packed.element[row["source"]]
        assert source["kind"] == Kind.BUSHING and source["lower"].tolist() == row["lower"].tolist()
        assert (row["limit"], row["coefficient"], row["series"]) == (100.0, 0.1, 5e6)
        assert row["k"].tolist() == [5e6, 5e6, 0.0]


def test_series_spring_is_damped_by_five_per_cent(packed):
    """Of critical damping of the two bodies against each other, 1500 kg and 20 t, unless said otherwise."""
    mass = 1500.0 * 20000.0 / 21500.0
    for row in packed.element:
        if row["kind"] == Kind.DRY:
            assert row["c"][0] / (2.0 * np.sqrt(5e6 * mass)) == pytest.approx(0.05, rel=tol.ROUNDING)
        if row["kind"] == Kind.DRY_LINK:
            assert row["c"][0] == 0.0 and row["length"] == pytest.approx(0.5)


def test_states_do_not_overlap(packed):
    """Two for friction in a plane, one along a line, two for a leaf spring; they start without force."""
    count = {Kind.DRY: 2, Kind.DRY_LINK: 1, Kind.LEAF: 2, Kind.BUSHING: 0}
    places = [p for row in packed.element for p in range(row["state"], row["state"] + count[Kind(row["kind"])])]
    assert sorted(places) == list(range(packed.damper.size))
    for row in packed.element:
        if row["kind"] == Kind.DRY_LINK:
            assert packed.damper[row["state"]] == pytest.approx(0.5)
        elif row["state"] >= 0:
            assert not packed.damper[row["state"] : row["state"] + 2].any()


def test_given_preload_is_taken_off_the_rest(tmp_path, packed):
    """The helpers carry 20 kN each, the shackles share what is left of 20 t; the rails bear all."""
    vehicle = build(WAGON, tmp_path)
    loads = {place.element.name: load for place, load in carried(vehicle, G)}
    assert loads["helper spring"] == 20000.0
    assert loads["shackles"] == pytest.approx((20000.0 * G - 40000.0) / 4.0, rel=tol.ROUNDING)
    helpers = [row["preload"][2] for row in packed.element if row["k"][2] == 1e5]
    assert helpers == [-20000.0, -20000.0]
    assert_allclose(static_wheel_loads(vehicle, G, TAPE_CIRCLE), 23000.0 * G / 4.0, rtol=tol.ROUNDING)


def test_envelopes_as_tables(tmp_path):
    tables = """upper_envelope = { displacement_mm = [-50, 0, 50], force_N = [-38e3, 3e3, 60e3] }
lower_envelope = { displacement_mm = [-50, 50], force_N = [-42e3, 40e3] }"""
    text = WAGON.replace("stiffness_N_per_m = 8e5\nfriction_N = 3000", tables).replace("decay_mm = 2", "decay_mm = 1")
    vehicle = build(text, tmp_path)
    (spring,) = vehicle.joints[0].leaf_springs
    packed = pack(vehicle, G, TAPE_CIRCLE, 0.3)
    row = next(row for row in packed.element if row["kind"] == Kind.LEAF)
    upper, lower = (packed.curve[i] for i in row["spring_curve"][:2])
    assert upper["y"][: upper["count"]].tolist() == [-38e3, 3e3, 60e3]
    assert lower["y"][: lower["count"]].tolist() == [-42e3, 40e3]
    assert spring.middle == pytest.approx((3e3 - 1e3) / 2.0) and packed.damper[row["state"] + 1] == spring.middle
    assert spring.soft_stiffness == pytest.approx((3e3 + 1e3) / 2e-3)


BAD = [
    ("series_stiffness_MN_per_m = 5", "", "friction[1]: friction needs series_stiffness_N_per_m > 0"),
    ("limit_N = 100", "limit_N = -100", "friction[1].limit_N: must be >= 0 N, got -100"),
    ("coefficient = 0.1", "coefficient = -0.1", "friction[1].coefficient: must be >= 0, got -0.1"),
    ("coefficient = 0.1\n", "", "friction[1]: coefficient and load_of go together"),
    ('load_of = "shackles"', "", "friction[1]: coefficient and load_of go together"),
    ('load_of = "shackles"', 'load_of = "shackels"', "no bushing of this joint is named 'shackels'; did you mean"),
    ('"helper spring"', '"shackles"', "friction[1].load_of: several bushings are named 'shackles'"),
    ('mirror = "y"\ndirections', "directions", "'shackles' has mirror = 'y', 'shackle friction' 'none'"),
    ('directions = "xy"', 'directions = "yx"', "friction[1].directions: must be 'x', 'y', 'z'"),
    ('directions = "xy"', "", "friction[1]: directions: goes with at_m, and only with it"),
    ("lower_m = [0, 0, 0.5]\n", "", "friction[2]: give either at_m with directions, or lower_m and upper_m"),
    ("upper_m = [0.3, 0, 0.9]", "upper_m = [0, 0, 0.5]", "friction[2]: lower_m and upper_m are the same point"),
    ("limit_N = 500", "limit_N = 0", "friction[2]: does nothing; give limit_N, or coefficient and load_of"),
    ("friction_N = 3000", "", "leaf_spring[1]: give either stiffness_N_per_m and friction_N, or upper_envelope"),
    ("friction_N = 3000", "friction_N = -3000", "leaf_spring[1].friction_N: must be > 0 N, got -3000"),
    ("decay_mm = 2", "decay_mm = 5", "decay_m: 0.005 m is too long"),
    ("decay_mm = 2", "decay_mm = 0", "leaf_spring[1].decay_mm: must be >= 0.001 mm, got 0"),
    (
        "stiffness_N_per_m = 8e5\nfriction_N = 3000",
        "upper_envelope = { displacement_mm = [-1, 1], force_N = [5, 4] }\n"
        "lower_envelope = { displacement_mm = [-1, 1], force_N = [-5, -4] }",
        "leaf_spring[1].upper_envelope: force must not decrease",
    ),
    (
        "stiffness_N_per_m = 8e5\nfriction_N = 3000",
        "upper_envelope = { displacement_mm = [-10, 10], force_N = [-100, 100] }\n"
        "lower_envelope = { displacement_mm = [-10, 10], force_N = [-300, 90] }",
        "leaf_spring[1]: the upper envelope must lie above the lower one",
    ),
    ("preload_N = 20000", "preload_N = 20000\ncarries_weight = true", "give either carries_weight = true or preload_N"),
    ("preload_N = 20000", "preload_N = -1", "bushing[2].preload_N: must be >= 0 N, got -1"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), BAD)
def test_bad_element(old, new, message, tmp_path):
    assert old in WAGON
    with pytest.raises(InputError) as error:
        build(WAGON.replace(old, new, 1), tmp_path)
    assert message in str(error.value) and "wagon.toml: " in str(error.value)
    assert "\n" not in str(error.value)
