"""Vibration of wheel forces, and alternation from step to step: frequency and size of known ones."""

from types import SimpleNamespace

import numpy as np
import pytest
import tolerances as tol

from railcli.analysis.simulate import Filtered
from railcli.analysis.vibration import Listener, vibration
from railcli.analysis.watch import Watch
from railcli.report.run import VIBRATES, vibrates

N_WHEEL, RATE, SPEED = 8, 500.0, 20.0
SECONDS = 3.0


def listening(signal, start=20.0):
    """A Listener that heard Q of the third wheel follow signal(time), in three blocks."""
    time = np.arange(1, round(SECONDS * RATE) + 1) / RATE
    filtered = np.zeros((time.size, 60))
    filtered[:, N_WHEEL + 2] = 50e3 + signal(time)
    place = np.repeat(SPEED * time[:, None], 7, axis=1)
    listener = Listener(N_WHEEL, start)
    for k in range(0, time.size, 600):
        part = slice(k, k + 600)
        listener(Filtered(time[part], filtered[part], place[part], None))
    return listener


@pytest.mark.parametrize("frequency", [1.7, 6.3, 110.0])
def test_frequency_of_a_sine_over_a_drift(frequency):
    """Within a quarter of a line; what came before the stretch does not count."""

    def signal(time):
        early = 5e3 * np.sin(2.0 * np.pi * 30.0 * time) * (time < 0.9)
        return 100.0 * np.sin(2.0 * np.pi * frequency * time) + 400.0 * time + early

    found = listening(signal).frequency(1, 2)
    assert found == pytest.approx(frequency, abs=0.25 / (SECONDS - 1.0))


def test_a_motion_that_has_not_settled_is_no_vibration():
    assert np.isnan(listening(lambda time: 3e3 * np.exp(-2.0 * time)).frequency(1, 2))


def test_the_force_that_moves_most_is_told(wagon):
    swings = {"y_force": np.full(N_WHEEL, 20.0), "q_force": np.full(N_WHEEL, 30.0)}
    swings["q_force"][2] = 240.0
    window = SimpleNamespace(peak_to_peak=swings.__getitem__)
    found = vibration(wagon, window, listening(lambda time: 100.0 * np.sin(2.0 * np.pi * 6.0 * time)))
    assert found[:3] == ("Q", "W2 right", 240.0) and found.frequency == pytest.approx(6.0, rel=tol.SPECTRUM_LINE)
    text = vibrates(found)
    assert "Q of wheel W2 right vibrates" in text and "0.24 kN" in text and text.endswith(f"{found.frequency:.3g} Hz.")
    assert vibrates(found._replace(peak_to_peak=0.9 * VIBRATES)) == ""
    assert vibrates(None) == ""


def rows_of(forces):
    """Rows of one step each, whose wheel forces (n, 2 n_wheel) are these."""
    moved = np.diff(forces, axis=0, prepend=forces[:1])
    before = np.vstack([np.zeros_like(moved[:1]), moved[:-1]])
    time = 1e-3 * np.arange(1, len(forces) + 1)
    q = np.zeros((len(forces), 1, 6))
    q[:, 0, 0] = SPEED * time
    return SimpleNamespace(time=time, turn=moved * before, move=moved * moved, q=q)


@pytest.mark.parametrize(("hertz", "told"), [(500.0, True), (470.0, True), (110.0, False), (8.0, False)])
def test_a_force_that_alternates_from_step_to_step_is_told(wagon, hertz, told):
    """At 1 ms, 500 Hz is what turns with every step; 110 Hz is a rattle of the model."""
    forces = np.full((600, 2 * N_WHEEL), 50e3)
    forces[:, N_WHEEL + 5] += 800.0 * np.sin(2.0 * np.pi * hertz * 1e-3 * np.arange(600) + 0.3)
    watch = Watch(wagon)
    watch(rows_of(forces))
    assert bool(watch.warning) is told
    if told:
        assert "Q of wheel W3 left alternates" in watch.warning and "use step_ms <=" in watch.warning
