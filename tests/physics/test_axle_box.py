"""Elements beside the axle of a wheelset: on an axle box they carry moments and keep energy; without one: refused."""

import numpy as np
import pytest
import scenes
import tolerances as tol

from railcli.analysis.equilibrium import steady
from railcli.errors import InputError
from railcli.files import toml
from railcli.files.scenario import load
from railcli.model.system import assemble
from railcli.model.vehicle import Vehicle

CAR = """
name = "two-axle wagon"
[[body]]
name = "car"
mass_kg = 30000
inertia_kg_m2 = [40e3, 350e3, 350e3]
x_m = 0
height_m = 1.6
"""
WHEELSET = """
[[body]]
name = "ws {n}"
mass_kg = 1200
inertia_kg_m2 = [600, 110, 600]
x_m = {x}
wheel_radius_m = 0.5
"""
BOX = """
[[body]]
name = "box {n} {side}"
mass_kg = 100
inertia_kg_m2 = [3, 4, 3]
x_m = {x}
y_m = {y}
height_m = 0.5
"""
ON_AXLE = """
[[joint]]
name = "primary"
pairs = [["ws 1", "car"], ["ws 2", "car"]]
axes = "upper"
[[joint.bushing]]
name = "leaf spring"
at_m = [0, 1, {height}]
mirror = "y"
stiffness_N_per_m = [2.5e5, 2.5e5, 1.5e6]
damping_Ns_per_m = [{c}, {c}, {c}]
carries_weight = true
"""
ON_BOX = """
[[joint]]
name = "bearing {side}"
pairs = [["ws 1", "box 1 {side}"], ["ws 2", "box 2 {side}"]]
axes = "upper"
[[joint.bushing]]
name = "bearing"
at_m = [0, {y}, 0.5]
stiffness_MN_per_m = [100, 100, 100]
turn_stiffness_kNm_per_rad = [1000, 0, 1000]
carries_weight = true
[[joint]]
name = "primary {side}"
pairs = [["box 1 {side}", "car"], ["box 2 {side}", "car"]]
[[joint.bushing]]
name = "leaf spring"
at_m = [0, {y}, {height}]
stiffness_N_per_m = [2.5e5, 2.5e5, 1.5e6]
damping_Ns_per_m = [{c}, {c}, {c}]
turn_stiffness_kNm_per_rad = [0, 200, 0]
carries_weight = true
"""


def text(boxes, height, c=1e4):
    wheelsets = "".join(WHEELSET.format(n=n, x=x) for n, x in ((1, 4.5), (2, -4.5)))
    if not boxes:
        return CAR + wheelsets + ON_AXLE.format(height=height, c=c)
    found, joints = "", ""
    for side, y in (("right", 1.0), ("left", -1.0)):
        found += "".join(BOX.format(n=n, x=x, y=y, side=side) for n, x in ((1, 4.5), (2, -4.5)))
        joints += ON_BOX.format(side=side, y=y, height=height, c=c)
    return CAR + wheelsets + found + joints


def build(words, tmp_path):
    (tmp_path / "wagon.toml").write_text(words)
    return toml.build(Vehicle, toml.read(tmp_path / "wagon.toml"), "wagon.toml")


def running(words, table, tmp_path, **run):
    case = load("curve-1200-45").varied(vehicle=build(words, tmp_path), run={"speed": 20.0, **run})
    return assemble(case.varied(contact={"creep_law": "table"}), [table])


@pytest.mark.parametrize("boxes, height", [(False, 0.5), (True, 0.5), (True, 0.9), (True, 0.2)])
def test_creep_power_is_traction_power(boxes, height, table, tmp_path):
    """In a steady curve all that the traction feeds in slips away between wheels and rails."""
    system = running(text(boxes, height), table, tmp_path)
    data = steady(system, 1.0 / 400.0, 0.06).data
    patch = data.contact
    creep = -system.speed * np.sum(
        patch["creep_x"] * patch["xi"] + patch["creep_t"] * patch["eta"] + patch["spin_moment"] * patch["phi"]
    )
    traction = data.traction[0] * data.rate[0, 0]
    assert traction > 500.0 and creep == pytest.approx(traction, rel=tol.CREEP_POWER_BALANCE)


def test_free_wheelsets_keep_energy(table, tmp_path):
    """In free space, wheelsets spinning at 40 rad/s in swinging boxes: springs beside the axle keep energy."""
    system = running(text(True, 0.9, c=0.0), table, tmp_path)
    errors = []
    for step in (0.25e-3, 0.125e-3):
        free = scenes.edited(scenes.floating(system, scenes.SMOOTH), "element", preload=0.0)
        free = scenes.tuned(free, step=step)
        rng = np.random.default_rng(1)
        v = rng.uniform(-0.05, 0.05, (7, 6))
        v[:, 0] += 20.0
        v[1:3, 4] -= 40.0
        data = scenes.data_at(free.model, free.rest + [12.0, 0, 0, 0, 0, 0], v)
        found = []
        for _ in range(50):
            scenes.run(free, data, 0.02)
            found.append(scenes.energy(free, data))
        swing = 0.5 * free.model.body["mass"].sum() * 0.05**2
        found = np.array(found)
        assert abs(found[25:].mean() - found[:25].mean()) < found.std() + tol.ROUNDING * found[0]
        errors.append(found.std() / swing)
    assert errors[0] < tol.AXLE_BOX_ENERGY and errors[0] / errors[1] > 3.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (text(False, 0.9), r"bushing\[1\] acts 0 mm ahead of and 400 mm over the axle of 'ws 1', which turns freely; "
                           r"put that end on the axle or let it act on an axle box"),
        (text(False, 0.5).replace('axes = "upper"', ""),
         r"bushing\[1\] would drive the spin of 'ws 1' .* axes = \"upper\""),
        (text(False, 0.5).replace('["ws 1", "car"]', '["car", "ws 1"]').replace("at_m = [0,", "at_m = [4.5,"),
         "name the wheelset first in the pair"),
        (text(False, 0.5) + '[[joint.link]]\nname = "rod"\nlower_m = [0.1, 0, 0.5]\nupper_m = [0.9, 0, 0.5]\n'
         "stiffness_N_per_m = 1e6\n", r"link\[1\] acts 100 mm ahead of"),
    ],
)  # fmt: skip
def test_elements_beside_the_axle_are_refused(words, message, tmp_path):
    with pytest.raises(InputError, match=message) as error:
        build(words, tmp_path)
    assert "\n" not in str(error.value)
