"""Left and right side that differ: profiles, wheel radii, contact tables; mirror images, and cones of unequal radii."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose
from scipy.optimize import fsolve

from railcli.analysis.build_table import build_table
from railcli.analysis.equilibrium import static, steady
from railcli.analysis.simulate import settled_start
from railcli.files.scenario import load
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.scenario import Contact, Run, Scenario
from railcli.model.system import assemble, needed, table_settings
from railcli.model.vehicle import Body, Vehicle

MIRRORED = np.array([1, -1, 1, -1, 1, -1])  # coordinates of a mirrored motion
OTHER_SIDE = [1, 0, 3, 2, 5, 4, 7, 6]
SLOPE = 0.05
COARSE = {"y_range": 8e-3, "y_step": 1e-3, "roll_range": 4e-3, "roll_step": 1e-3, "yaw_range": 12e-3, "yaw_count": 4}

THIN = {"y_step": 0.25e-3, "roll_range": 7.5e-3, "yaw_range": 13.5e-3, "yaw_count": 3}


@pytest.fixture(scope="module")
def smaller(profiles):
    """The usual small table, for wheels with 1 mm less radius."""
    return build_table(*profiles, replace(scenes.SMALL, radius=0.459))[0]


def unequal(case, right, left):
    """The Manchester wagon with these wheel radii on every wheelset."""
    vehicle = case.vehicle
    bodies = [
        body.model_copy(update={"wheel_radius": right, "left_wheel_radius": left}) if body.is_wheelset else body
        for body in vehicle.bodies
    ]
    return case.varied(vehicle=Vehicle(**{**dict(vehicle), "bodies": tuple(bodies)}))


def into_curve(hand):
    """Straight, transition and half a curve, at 20 m/s."""
    curve = scenes.Curve(length=30.0, radius=300.0, hand=hand, cant=0.1)
    track = scenes.Track((scenes.Straight(length=30.0), scenes.Transition(length=40.0), curve))
    return load("curve-1200-45").varied(run={"speed": 20.0, "distance": 90.0, "average_over": 5.0}, track=track)


def ran(system, seconds, stride=20):
    """Rows of a run from rest, which reaches its end."""
    rows = new_rows(system.model, round(seconds / system.model.param[0]["step"] / stride))
    assert record(system.model, settled_start(system), rows, stride) == (rows.time.size, 0)
    return rows


def test_exchanged_sides_mirror_the_run(table, smaller):
    """Small wheels on the right in a right-hand curve: the mirror image of small wheels on the left in a left-hand one.

    The order of the pool follows the wheels, so it is exchanged too.
    """
    right = assemble(unequal(into_curve("right"), 0.459, 0.460), [smaller, table])
    left = assemble(unequal(into_curve("left"), 0.460, 0.459), [table, smaller])
    one, other = ran(right, 4.5), ran(left, 4.5)
    assert np.abs(one.q[:, 3:, 1]).max() > 2e-3
    assert np.abs(one.q - ran(assemble(into_curve("right"), [table]), 4.5).q).max() > 1e-3
    assert_allclose(other.q * MIRRORED, one.q, rtol=0, atol=tol.MIRRORED_PLACE)
    for key, sign in (("x", 1.0), ("y", -1.0), ("q", 1.0)):
        assert_allclose(sign * other.rail[key][:, OTHER_SIDE], one.rail[key], rtol=0, atol=tol.MIRRORED_FORCE)


def test_exchanged_sides_mirror_steady_curving(table, smaller):
    right = steady(assemble(unequal(into_curve("right"), 0.459, 0.460), [smaller, table]), 1 / 1200, 0.09).data
    left = steady(assemble(unequal(into_curve("left"), 0.460, 0.459), [table, smaller]), -1 / 1200, -0.09).data
    assert_allclose(left.q * MIRRORED, right.q, rtol=0, atol=tol.MIRRORED_PLACE)
    assert_allclose(left.rail["q"][OTHER_SIDE], right.rail["q"], rtol=0, atol=tol.MIRRORED_FORCE)


def test_sides_given_alike_change_no_bit(table):
    """Left side and right side spelt out, or left out: one table, one digest, the same bits."""
    case = into_curve("right")
    same = {"left_wheel_profile": "ORES1002", "left_rail_profile": "UIC60"}
    spelt = unequal(case.varied(contact=same), 0.460, 0.460)
    assert needed(spelt) == needed(case) and spelt.digest() == case.digest()
    one, other = (ran(assemble(scenario, [table]), 3.0) for scenario in (case, spelt))
    for array, twin in zip(one, other, strict=True):
        assert array.tobytes() == twin.tobytes()


def test_sides_alike_in_two_tables_are_the_same_motion(table):
    """The left wheels on a table of their own that holds the same: nothing moves but by the first guess at rest."""
    case = into_curve("right")
    two = assemble(case.varied(contact={"left_rail_profile": "other"}), [table, table])
    assert two.model.wheel["table"].tolist() == [0, 1] * 4
    one, other = ran(assemble(case, [table]), 3.0), ran(two, 3.0)
    assert_allclose(other.q, one.q, rtol=0, atol=tol.MIRRORED_PLACE)


def cone_pair(right, left, track=None):
    """One wheelset on cones of these radii, on round rails."""
    settings = scenes.round_settings(**COARSE)
    tables = [
        build_table(scenes.cone(SLOPE), scenes.round_rail(), replace(settings, radius=radius))[0]
        for radius in (right, left)
    ]
    inertia = (1000.0, 100.0, 1000.0)
    body = Body(name="wheelset", mass=2000.0, inertia=inertia, x=0.0, wheel_radius=right, left_wheel_radius=left)
    scenario = Scenario(
        name="unequal radii",
        vehicle=Vehicle(name="wheelset", bodies=(body,)),
        run=Run(speed=5.0, step=0.2e-3, output_interval=0.2e-3),
        track=track or scenes.Track((scenes.Straight(length=500.0),)),
        contact=Contact(flange_back=settings.flange_back),
    )
    return assemble(scenario, tables)


@pytest.mark.parametrize(("right", "left"), [(0.4598, 0.4602), (0.4602, 0.4598)])
def test_cones_of_unequal_radii_run_where_their_rolling_radii_are_equal(right, left):
    """y = (r_left - r_right) / (2 tan(angle)): towards the smaller wheel, level, and there the wheelset stays."""
    system = cone_pair(right, left)
    place = (left - right) / (2.0 * np.tan(SLOPE))
    found = steady(system, 0.0, 0.0).data
    assert found.q[0, 1] == pytest.approx(place, abs=tol.CONE_PLACE)
    assert found.contact["radius"][0, 0] == pytest.approx(found.contact["radius"][1, 0], abs=tol.CONE_PLACE)
    start = system.start()
    start.q[0, 1:], start.v[:], start.dv[:] = found.q[0, 1:], found.v, found.dv
    ended = scenes.run(system, start, 2.0)
    assert ended.q[0, 0] > 9.0
    assert ended.q[0, 1] == pytest.approx(place, abs=tol.CONE_PLACE)


def test_wheelset_of_unequal_radii_at_rest():
    """Held in the middle by friction it leans: two lines at +- the cone's angle in its axes touch the two circles.

    The line of the right cone is n . p = r cos(angle) + b sin(angle) in the wheelset's axes, n = (sin, cos) of the
    angle; a roll turns n, and the circle's centre must lie HEAD below the line. Likewise on the left.
    """
    right, left = 0.4598, 0.4602
    found = static(cone_pair(right, left)).data
    b = scenes.round_settings().lateral

    def miss(unknown):
        z, roll = unknown
        below = [
            b * np.sin(SLOPE - side * roll) + (scenes.HEAD - z) * np.cos(SLOPE - side * roll)
            - (radius * np.cos(SLOPE) + b * np.sin(SLOPE))
            for side, radius in ((1.0, right), (-1.0, left))
        ]  # fmt: skip
        return np.array(below) - scenes.HEAD

    z, roll = fsolve(miss, (-0.46, 0.0), xtol=1e-13)
    assert found.q[0, 1] == 0.0 and abs(roll) > 2e-4
    assert found.q[0, 3] == pytest.approx(roll, abs=tol.CONE_ROLL)
    assert found.q[0, 2] == pytest.approx(z, abs=tol.PRESSED_IN)


@pytest.mark.parametrize(
    ("gauge", "inclination", "flange_back"),
    [
        (1.425, 0.0, 1.357),
        (1.425, 20.0, 1.360),
        (1.435, 40.0, 1.360),
        (1.450, 0.0, 1.360),
        (1.470, 40.0, 1.360),
        (1.470, 20.0, 1.360),
    ],
)
def test_gauges_and_inclinations_run(profiles, gauge, inclination, flange_back):
    """Narrow and wide gauge, upright and inclined rails: straight, transition and a tight curve without a fault.

    On the widest gauge the flange is reached more than 20 mm off centre, where the table must still answer. On 1425 mm
    over upright rails wheelsets 1425 mm wide ride on both flange roots when centred, so there they are narrower.
    """
    curve = scenes.Curve(length=40.0, radius=300.0, hand="right", cant=0.1)
    track = scenes.Track((scenes.Straight(length=20.0), scenes.Transition(length=30.0), curve))
    groups = {"run": {"speed": 20.0, "distance": 80.0, "average_over": 5.0}, "track": track}
    track_and_wheels = {"gauge": gauge, "inclination": inclination, "flange_back": flange_back}
    case = load("curve-1200-45").varied(**groups, contact=track_and_wheels)
    settings = replace(table_settings(case, 0.46), **THIN)
    system = assemble(case, [build_table(*profiles, settings)[0]])
    rows = ran(system, 3.9)
    assert np.isfinite(rows.q).all()
    play = 0.5 * (gauge - flange_back - 0.065)
    leading = rows.q[-1, 3, 1]
    assert -play - 3e-3 < leading < -play - 0.5e-3
    assert rows.rail["q"][-1].min() > 20e3


def test_table_reaches_as_far_beyond_the_flange_on_a_wide_gauge():
    """20 mm to both sides on 1435 mm and less, and half of what the gauge is wider on others."""
    case = load("curve-1200-45")
    for gauge, reach in ((1.425, 20e-3), (1.435, 20e-3), (1.470, 37.5e-3)):
        settings = table_settings(case.varied(contact={"gauge": gauge}), 0.46)
        assert settings.y_range == pytest.approx(reach, abs=tol.GRID_ROUNDING)
