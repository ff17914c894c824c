"""Standing on a gradient: patches hold what friction can hold, for every creep law (theory.md section 8.3)."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
import tolerances as tol

from railcli.analysis.equilibrium import rising, steady
from railcli.analysis.simulate import settled_start
from railcli.files.resources import resource
from railcli.files.scenario import load
from railcli.kernels.recording import new_rows
from railcli.kernels.step import record
from railcli.model.submodels import CREEP_LAWS
from railcli.model.system import assemble
from railcli.model.track import constant_track, pack

SLOPE, GRAVITY, WEIGHT = 0.04, 9.81, 44482.0 * 9.81
PULL = WEIGHT * np.sin(np.arctan(SLOPE))  # of the weight along the track: 17.4 kN
BRAKES = """
[[joint]]
name = "brakes"
pairs = [["wheelset 1", "bogie 1"], ["wheelset 2", "bogie 1"], ["wheelset 3", "bogie 2"], ["wheelset 4", "bogie 2"]]
[[joint.torque]]
name = "brake"
friction_Nm = 3000
"""
SCENARIO = """
vehicle = "braked.toml"
[run]
speed_m_per_s = 1
step_ms = 1
[contact]
creep_law = "{law}"
friction = {friction}
[[track]]
kind = "straight"
length_m = 100
"""
STRAIGHT, CURVE = (0.0, 0.0), (1.0 / 300.0, 0.1)  # curvature [1/m], cant [m]


@pytest.fixture(scope="module")
def braked(table, tmp_path_factory):
    """Function that gives the wagon on 40 per mille with a brake on every wheelset, which holds up to 26 kN in all."""
    folder = tmp_path_factory.mktemp("braked")
    wagon = resource("benchmarks/manchester/vehicle.toml").read_text()
    (folder / "braked.toml").write_text(wagon + BRAKES)

    def system(law="table", friction=0.3, shape=STRAIGHT):
        file = folder / f"{law}-{friction}.toml"
        file.write_text(SCENARIO.format(law=law, friction=friction))
        return on_slope(assemble(load(file), [table]), *shape)

    return system


def on_slope(system, curvature, cant):
    track = pack(constant_track(curvature, cant), 800.0, gradients=rising(SLOPE), pivot="inner")
    return scenes.replaced(system, track=track)


def watched(system, data, seconds=1.0):
    """Every step of some time."""
    rows = new_rows(system.model, round(seconds / system.model.param["step"][0]))
    assert record(system.model, data, rows, 1) == (rows.time.size, 0)
    return rows


def drift(system, data, seconds=10.0):
    """Speed at which bodies moved along and aside [m/s]."""
    before = data.q[:, :2].copy()
    scenes.run(system, data, seconds)
    return np.abs(data.q[:, :2] - before).max() / seconds


@pytest.mark.parametrize("shape", [STRAIGHT, CURVE], ids=["straight", "canted curve"])
@pytest.mark.parametrize("law", CREEP_LAWS)
def test_brakes_hold_the_wagon(braked, law, shape):
    """It rolls up at 1 m/s, braked and pulled; nobody pulls any more: it stops, and the rails carry m g sin."""
    system = braked(law, shape=shape)
    found = steady(system, *shape, gradient=SLOPE).data
    free = scenes.tuned(system, hold=0.0)
    data = free.start()
    data.q[:], data.v[:], data.damper[:] = found.q, found.v, found.damper
    scenes.run(free, data, 20.0)
    assert 0.4 < data.q[0, 0] < 0.6
    assert drift(free, data) < tol.STANDING_DRIFT
    rail = watched(free, data).rail
    assert -rail["x"].sum(axis=1).mean() == pytest.approx(PULL, rel=tol.STANDING_PULL)
    for force in (rail["y"], rail["q"]):
        assert np.ptp(force, axis=0).max() < tol.STANDING_SWING
        assert np.abs(np.diff(force, 2, axis=0)).max() / 4.0 < tol.STANDING_ALTERNATION


@pytest.mark.parametrize("law", ["table", "hard"])
def test_driver_starts_holds_and_goes_on(table, law):
    """From rest to 2 m/s and back, 20 s of standing, and on to 3 m/s; free wheels carry nothing along the track."""
    system = on_slope(scenes.wagon(table, run={"step": 1e-3}, contact={"creep_law": law}), *STRAIGHT)
    system = system.following([0.0, 2.0, 8.0, 10.0, 30.0, 33.0, 40.0], [0.0, 2.0, 2.0, 0.0, 0.0, 3.0, 3.0])
    data = settled_start(system)
    scenes.run(system, data, 8.0)
    assert data.rate[0, 0] == pytest.approx(2.0, abs=tol.COURSE_SPEED)
    scenes.run(system, data, 10.0)
    assert drift(system, data) < tol.STANDING_DRIFT
    rows = watched(system, data)
    assert rows.traction.mean() == pytest.approx(PULL, rel=tol.STANDING_PULL)
    assert abs(rows.rail["x"].sum(axis=1).mean()) < tol.STANDING_PULL * PULL
    scenes.run(system, data, 11.0)
    assert data.rate[0, 0] == pytest.approx(3.0, abs=tol.COURSE_SPEED)


@pytest.mark.parametrize("law", ["table", "hard"])
def test_locked_wheels_slide_where_friction_does_not_hold(braked, law):
    """Friction 0.03 on a slope of 0.04: wheels stand still and the wagon slides back with g (sin - mu cos)."""
    system = scenes.tuned(replace(braked(law, 0.03), speed=0.0), hold=0.0, speed=0.0)
    data = settled_start(system)
    scenes.run(system, data, 2.0)
    before = data.v[0, 0]
    scenes.run(system, data, 2.0)
    expected = -GRAVITY * (np.sin(np.arctan(SLOPE)) - 0.03 * np.cos(np.arctan(SLOPE)))
    assert (data.v[0, 0] - before) / 2.0 == pytest.approx(expected, rel=tol.SLIDING_BACK)
    assert np.abs(data.v[list(system.wheelsets), 4]).max() < tol.LOCKED
