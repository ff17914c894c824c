"""What is gathered at every step, against a slow twin that keeps every step and works with whole arrays."""

import numpy as np
import pytest
import scenes
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.simulate import SteadyWindow, settled_start
from railcli.kernels.layout import Region, Status
from railcli.kernels.recording import Count, instants, new_rows, new_stream
from railcli.kernels.step import advance, finish, record_rows
from railcli.model.low_pass import INTERVAL, PASSED, low_pass

STEPS = 1200
ASIDE = 4e-3  # a wagon that was put aside: wheels, flanges and bodies move [m]
PARTS = len(Region)


def felt(model, data):
    """Accelerations that accelerometers show in track axes, less gravity at rest (n_body, 3)."""
    gravity = model.param[0]["gravity"]
    carried = data.rate[:, :1] * np.cross(data.frame["rate"], data.v[:, :3])
    return data.dv[:, :3] + carried - gravity * (data.frame["track"][:, 2] - [0.0, 0.0, 1.0])


def wear(data, n_wheel):
    numbers = np.zeros((n_wheel, PARTS))
    for w in range(n_wheel):
        for patch in data.contact[w, : int(data.rail[w]["patches"])]:
            number = abs(patch["creep_x"] * patch["xi"]) + abs(patch["creep_t"] * patch["eta"])
            numbers[w, round(float(patch["region"]))] += number
    return numbers.ravel()


@pytest.fixture(scope="module")
def every_step(table):
    """System, and of each of STEPS steps: channels as the stream has them, places, instants."""
    system = scenes.wagon(table, "straight-60")
    data = settled_start(system, ASIDE)
    model = system.model
    sprung = ~model.body["spins"].astype(bool)
    n_wheel = model.wheel.size
    found = []
    for _ in range(STEPS):
        assert advance(model, data, 1) == 0
        rail = data.rail
        channels = [rail["y"], rail["q"], rail["x"], data.traction[:1], felt(model, data).ravel()]
        channels.append(data.dv[sprung, 3:].ravel())
        still = [data.q[:, 1], data.q[:, 3:].ravel(), data.v[:, 3:].ravel(), wear(data, n_wheel)]
        found.append((np.concatenate(channels), data.q[:, 0].copy(), np.concatenate(still)))
    return system, *(np.array(part) for part in zip(*found, strict=True))


@pytest.mark.parametrize("stride", [1, 3, 4, 10, 50])
def test_rows_hold_means_and_extremes_of_every_step(every_step, stride):
    system, channels, _, _ = every_step
    rows = new_rows(system.model, STEPS // stride)
    count, status = record_rows(system.model, settled_start(system, ASIDE), rows, new_stream(system.model), stride)
    assert (count, status) == (STEPS // stride, 0)
    n_mean, n_wheel = rows.mean.shape[1], system.model.wheel.size
    cut = channels[: count * stride, :n_mean].reshape(count, stride, n_mean)
    scale = np.abs(channels[:, :n_mean]).max()
    assert_allclose(rows.mean, cut.mean(axis=1), rtol=0.0, atol=tol.ROUNDING * scale)
    assert_allclose(rows.least, cut.min(axis=1), rtol=0.0, atol=tol.ROUNDING * scale)
    assert_allclose(rows.greatest, cut.max(axis=1), rtol=0.0, atol=tol.ROUNDING * scale)
    moved = np.diff(channels[: count * stride, : 2 * n_wheel], axis=0, prepend=channels[:1, : 2 * n_wheel])
    before = np.vstack([np.zeros((1, 2 * n_wheel)), moved[:-1]])
    for held, product in ((rows.turn, moved * before), (rows.move, moved * moved)):
        assert_allclose(held, product.reshape(count, stride, -1).mean(axis=1), rtol=tol.ROUNDING, atol=tol.ROUNDING)


def test_alternation_and_swing_of_a_window_do_not_know_the_interval(every_step):
    system, channels, _, _ = every_step
    n_wheel = system.model.wheel.size
    window = SteadyWindow()
    rows = new_rows(system.model, STEPS // 50)
    record_rows(system.model, settled_start(system, ASIDE), rows, new_stream(system.model), 50)
    window(rows)
    forces = channels[:, : 2 * n_wheel].reshape(-1, 2, n_wheel)
    for k, key in enumerate(("y_force", "q_force")):
        assert_allclose(window.peak_to_peak(key), np.ptp(forces[:, k], axis=0), rtol=tol.ROUNDING)
        assert_allclose(window.mean(key), forces[:, k].mean(axis=0), rtol=0.0, atol=tol.ROUNDING * forces.max())
    moved = np.diff(forces, axis=0)
    turn, amplitude = window.alternation()
    assert_allclose(turn, (moved[1:] * moved[:-1]).sum(axis=0) / (moved**2).sum(axis=0), atol=tol.SUMMED)
    assert_allclose(amplitude, 0.5 * np.sqrt((moved**2).sum(axis=0) / STEPS), rtol=tol.SUMMED)


@pytest.mark.parametrize("stride", [1, 7, 20])
def test_stream_is_the_convolution_of_every_step(every_step, stride):
    """At its own rate, whatever the interval of rows; before the first and behind the last step is what they had."""
    system, channels, places, stills = every_step
    taps = low_pass(0.5e-3).taps
    own = 4
    stream = new_stream(system.model, taps, own, STEPS)
    rows = new_rows(system.model, STEPS // stride)
    record_rows(system.model, settled_start(system, ASIDE), rows, stream, stride)
    finish(stream)
    made = STEPS // stride * stride
    count = int(stream.count[Count.DONE])
    assert count == made // own
    half = taps.size // 2
    padded = np.pad(channels[:made], ((half, half), (0, 0)), mode="edge")
    wanted = np.array([taps @ padded[k : k + taps.size] for k in range(own - 1, made, own)])
    scale = np.abs(channels).max(axis=0)
    assert np.abs((stream.filtered[:count] - wanted) / np.where(scale > 0.0, scale, 1.0)).max() < tol.SINGLE_SUM
    at = np.arange(own - 1, own * count, own)
    assert_allclose(stream.place[:count], places[at], rtol=tol.ROUNDING)
    n_body, n_wheel = system.model.body.size, system.model.wheel.size
    span = instants(n_wheel, n_body).t_gamma
    scale = np.abs(stills).max(axis=0)
    off = np.abs(stream.still[:count, : span.start] - stills[at, : span.start])
    assert np.all(off <= tol.SINGLE * scale[: span.start])
    numbers = stills[: own * count, span].reshape(count, own, -1).mean(axis=1)
    assert_allclose(stream.still[:count, span], numbers, rtol=0.0, atol=tol.SINGLE_SUM * stills[:, span].max())


def test_a_fault_in_the_midst_of_an_interval_loses_no_step(table):
    """Rows end before it; the stream has every step that was made."""
    system = scenes.wagon(table, "straight-60")
    model = system.model
    rows = new_rows(model, 100)
    stream = new_stream(model, low_pass(0.5e-3).taps, 4, 1000)
    data = settled_start(system)
    data.v[:, 1] = 1.8  # thrown against the rail, and over it
    count, status = record_rows(model, data, rows, stream, 10)
    assert status in (Status.LEFT_TABLE, Status.DERAILED)
    finish(stream)
    steps = int(stream.count[Count.STEP])
    made = round(float(data.clock[0]) / float(model.param[0]["step"]))
    assert count == made // 10 and made % 10 != 0
    assert int(stream.count[Count.DONE]) == made // 4 and steps >= made


@pytest.mark.parametrize("step", [2e-3, 1e-3, 0.8e-3, 0.5e-3, 0.25e-3, 0.1e-3, 0.05e-3])
def test_low_pass(step):
    """What passes below PASSED, and what of the rest folds there."""
    stride, taps = low_pass(step)
    assert stride * step <= INTERVAL * (1.0 + 1e-9) and (stride + 1) * step > INTERVAL
    assert taps.sum() == pytest.approx(1.0) and np.array_equal(taps, taps[::-1])
    frequency = np.linspace(0.0, 0.5 / step, 4001)
    at = np.arange(taps.size) - taps.size // 2
    gain = np.cos(2.0 * np.pi * step * np.outer(frequency, at)) @ taps
    assert np.abs(gain[frequency <= PASSED] - 1.0).max() < tol.PASSED_RIPPLE
    rate = 1.0 / (stride * step)
    folds = np.abs((frequency + rate / 2.0) % rate - rate / 2.0) <= PASSED
    assert stride == 1 or np.abs(gain[folds & (frequency > PASSED)]).max() < tol.FOLDED
