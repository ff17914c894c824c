"""What is read off limit cycles: frequency, rms of sum Y, and the speeds at which they end, count and break a limit."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.stability import Cycle, Measures, _frequency, _rms_around_peak, end_of
from railcli.files.scenario import load
from railcli.model.assessment import Limits
from railcli.report.stability import speeds_json, speeds_text


def test_frequency_of_a_sine():
    t = np.arange(0.0, 4.0, 2.5e-3)
    assert _frequency(1.3 + 2e-3 * np.sin(2 * np.pi * 5.37 * t + 0.4), 2.5e-3) == pytest.approx(5.37, rel=tol.SINE)
    assert np.isnan(_frequency(np.exp(-t), 2.5e-3))


def test_end_of_hunting_ignores_what_died_above_it():
    """Hunting that is born again at a lower speed: the end is that of the branch at high speed."""
    cycles = [Cycle(v, np.array([1e-3]), 5.0, np.array([1e3]), 4.0, True, alive) for v, alive in
              ((80.0, True), (70.0, True), (60.0, False), (50.0, True))]  # fmt: skip
    assert end_of(cycles) == (60.0, 70.0)
    assert end_of(cycles[2:3])[0] == 60.0 and np.isnan(end_of(cycles[2:3])[1])
    assert np.isnan(end_of([])).all()


def test_rms_of_sum_y_is_that_of_its_dominant_frequency():
    """A swing of 5.3 Hz counts, a mean and a harmonic far from it do not.

    Second order forwards and backwards with -3 dB at 3.3 and 7.3 Hz: 1 / (1 + (root 2 - 1) ratio^4) for each.
    """
    t = np.arange(0.0, 4.0, 2.5e-3)
    signal = 7e3 + 5e3 * np.sin(2 * np.pi * 5.3 * t + 0.3) + 2e3 * np.sin(2 * np.pi * 15.9 * t)
    low, high = (1.0 / (1.0 + (np.sqrt(2.0) - 1.0) * ratio**4) for ratio in (3.3 / 5.3, 5.3 / 7.3))
    found = _rms_around_peak(np.stack([signal, 0.0 * t], axis=1), 400.0)
    assert found[0] == pytest.approx(low * high * 5e3 / np.sqrt(2.0), rel=tol.BAND_RMS)
    assert found[1] == 0.0


def test_measures_of_cycles():
    """Manchester wagon: half of 10 kN + P0/3, P0 = 109.09 kN; each measure has an end of its own."""
    measures = Measures.of(load("stability"), 1e-3, Limits())
    assert_allclose(measures.limit, 0.5 * (10e3 + 8.0 * 54546.0 / 4.0 / 3.0), atol=0.2)
    cycles = [
        Cycle(v, np.array([size * 1e-3]), 5.0, np.array([force, 0.0]), 4.0, True, size > 0.1)
        for v, size, force in ((80.0, 4.0, 25e3), (70.0, 2.0, 12e3), (60.0, 0.5, 4e3), (50.0, 0.05, 25e3))
    ]
    limited = Measures(1e-3, np.array([23e3, 23e3]))
    assert end_of(cycles) == (50.0, 60.0)
    assert end_of(cycles, limited.counts) == (60.0, 70.0)
    assert end_of(cycles, limited.breaks) == (70.0, 80.0)
    text = "\n".join(speeds_text([None], cycles, limited))
    for words in ("smallest limit cycle", "60.00   216  0.50 mm, 4.0 kN; no more at 50.00 m/s (180 km/h)",
                  "limit cycle of 1 mm",
                  "70.00   252", "at its limit of 23.0 kN  80.00   288", "linear, swing of 3 mm"):  # fmt: skip
        assert words in text
    found = speeds_json([None], cycles[1:], limited)
    assert found["counted_cycle"]["lives_m_per_s"] == 70.0 and found["counted_cycle"]["counted_from_mm"] == 1.0
    assert np.isnan(found["sum_Y_rms"]["lives_m_per_s"]) and found["linear"]["critical_m_per_s"] is None
    assert "> 70" in "\n".join(speeds_text([None], cycles[1:], limited))
