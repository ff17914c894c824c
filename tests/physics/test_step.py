"""The integrator and the compiled core: order, restart, constancy of the model, how it is compiled."""

from pathlib import Path

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis import warm
from railcli.analysis.equilibrium import touching_depth
from railcli.kernels import jit
from railcli.kernels.layout import new_data
from railcli.kernels.step import advance

STATE = ("q", "v", "dv", "damper", "tension", "lag", "clock", "held")
SCENE = """
import sys
import numpy as np
sys.path.insert(0, {tests!r})
import numba
from railcli.kernels import contact
if numba.config.DISABLE_JIT:  # vector instructions have no meaning outside compiled code
    def mix(node, n, w, sample, row):
        sample[row] = np.array(w) @ node[list(n)]
    def mix_bent(node, n, w, y, roll, yaw2, sample, row):
        weights = np.repeat([y, roll, yaw2, w], [3, 3, 3, node.shape[1] - 9], axis=0)
        sample[row] = sum(weights[:, c] * node[n[c]] for c in range(len(n)))
    contact.mix, contact.mix_bent = mix, mix_bent
import scenes
from railcli.analysis.equilibrium import touching_depth
system = scenes.lone_wheelset(scenes.cone_table(0.025), 20.0)
data = system.start(5.0, 1e-3)
data.q[0, 2] += touching_depth(system.model) + 0.05e-3
data.q[0, 5] = 2e-3
from railcli.kernels.step import advance
print(advance(system.model, data, {steps}), *data.q[0], *data.v[0], *data.rail["q"])
"""


def test_second_order():
    """On a smooth case (no saturation, no change of contact) the error falls with the square of the step."""
    table = scenes.cone_table(0.025)

    def ran(step):
        system = scenes.edited(scenes.lone_wheelset(table, 20.0, step=step), "wheel", friction=50.0)
        data = system.start(5.0, 1e-3)
        data.q[0, 2] += touching_depth(system.model) + 0.06e-3
        data.q[0, 5] = 1e-3
        data = scenes.data_at(system.model, data.q, data.v)
        return scenes.run(system, data, 0.1).q[0].copy()

    halvings = 4
    exact = ran(0.5e-3 / 2 ** (halvings + 3))
    coarse, fine = (np.linalg.norm(ran(step) - exact) for step in (0.5e-3, 0.5e-3 / 2**halvings))
    assert np.log2(coarse / fine) / halvings == pytest.approx(2.0, rel=tol.SECOND_ORDER)


def travelling(wagon):
    data = wagon.start(0.0, 2e-3)
    scenes.run(wagon, data, 0.5)
    return data


def copied(system, data):
    """New data with nothing but the state of another."""
    fresh = new_data(system.model, data.q, data.damper.size)
    for name in STATE:
        getattr(fresh, name)[:] = getattr(data, name)
    return fresh


def test_restart_is_equal_to_the_bit(wagon):
    """A run continued from its saved state is the run that was never interrupted."""
    data = travelling(wagon)
    again = copied(wagon, data)
    for one in (data, again):
        scenes.run(wagon, one, 1.0)
    for name in STATE:
        assert getattr(data, name).tobytes() == getattr(again, name).tobytes()
    assert data.rail.tobytes() == again.rail.tobytes()


def test_steps_in_one_call_or_in_many(wagon):
    """300 steps in one call are 300 calls of one step."""
    one, many = travelling(wagon), travelling(wagon)
    assert advance(wagon.model, one, 300) == 0
    assert not any(advance(wagon.model, many, 1) for _ in range(300))
    assert one.q.tobytes() == many.q.tobytes()


def test_model_stays_untouched(wagon):
    """No array of the model can be written, and none changes while the wagon runs."""
    before = [array.tobytes() for array in wagon.model]
    travelling(wagon)
    assert [array.tobytes() for array in wagon.model] == before
    assert not any(array.flags.writeable for array in wagon.model)


def test_core_cannot_allocate():
    """Compiled without numba's runtime nothing in the step can allocate; each entry has just one signature."""
    assert jit.OPTIONS["_nrt"] is False
    for entry in warm.CORE:
        assert len(entry.compiled().signatures) == 1


def test_other_types_are_refused(wagon):
    """Arguments of another type are an error, not a second compilation."""
    with pytest.raises(TypeError):
        advance(wagon.model, wagon.start(), "10")
    assert len(advance.compiled().signatures) == 1


def result(process):
    assert process.returncode == 0, process.stderr[-2000:]
    return np.array(process.stdout.split(), float)


def scene(steps):
    return SCENE.format(tests=str(Path(__file__).parents[1]), steps=steps)


def test_within_bounds(run_python, tmp_path):
    """With numba's bounds checks a run reads and writes inside its arrays, and ends at the same numbers."""
    plain = result(run_python(scene(200)))
    checked = result(run_python(scene(200), NUMBA_BOUNDSCHECK="1", NUMBA_CACHE_DIR=str(tmp_path / "code")))
    assert plain[0] == 0
    assert_allclose(checked, plain, rtol=tol.OTHER_CODE, atol=tol.OTHER_CODE)


def test_compiled_core_against_plain_python(run_python, tmp_path):
    """The same sources without compilation."""
    compiled = result(run_python(scene(5)))
    plain = result(run_python(scene(5), NUMBA_DISABLE_JIT="1"))
    assert_allclose(compiled, plain, rtol=tol.OTHER_CODE, atol=tol.OTHER_CODE)
