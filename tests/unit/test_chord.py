"""Versines and what follows from them: the chord laid over a known line, point by point."""

import numpy as np
import pytest
import tolerances as tol
from numpy.testing import assert_allclose

from railcli.analysis.chord import lost, restored, transfer
from railcli.errors import InputError
from railcli.files.irregularity import Asked, recording
from railcli.files.track_table import read_alignment

STEP = 0.25
S = STEP * np.arange(4000)
WAVES = {7.5: 1e-3, 13.0: 2e-3, 28.0: 3e-3, 43.0: 2e-3}  # amplitudes [m] by wavelength [m]


def line(s):
    return sum(size * np.sin(2.0 * np.pi * s / wave + wave) for wave, size in WAVES.items())


def versine(of, s, before, after):
    """Offset of the line from a chord whose ends lie on it: no transfer function."""
    ends = (after * of(s - before) + before * of(s + after)) / (before + after)
    return of(s) - ends


@pytest.mark.parametrize("parts", [(5.0, 5.0), (10.0, 10.0), (4.0, 6.0)])
def test_a_line_comes_back_from_its_versines(parts):
    found = restored(versine(line, S, *parts), STEP, *parts)
    end = 20.0 * sum(parts)
    inner = (S > end) & (S < S[-1] - end)
    kept = [wave for wave in WAVES if abs(transfer(2 * np.pi / wave, *parts)) >= 0.2]
    assert len(kept) >= 3

    def wanted(s):
        return sum(WAVES[wave] * np.sin(2.0 * np.pi * s / wave + wave) for wave in WAVES if wave in kept)

    shares = [WAVES[wave] for wave in WAVES if wave not in kept]
    assert_allclose(found[inner], wanted(S[inner]), atol=tol.RESTORED + sum(shares))


def test_transfer_is_that_of_the_chord():
    """One wave, by the chord laid on it; zero where a whole number of waves fits into both halves."""
    wave = 17.0
    def cosine(s):
        return np.cos(2.0 * np.pi * s / wave)

    assert_allclose(versine(cosine, S, 3.0, 7.0).max(), abs(transfer(2 * np.pi / wave, 3.0, 7.0)), rtol=1e-3)
    assert abs(transfer(2 * np.pi / 5.0, 5.0, 5.0)) < tol.ROUNDING
    assert transfer(2 * np.pi / 10.0, 5.0, 5.0).real == pytest.approx(2.0)


def test_lost_waves_of_a_chord_of_10_m():
    """1 - cos(5 k) = 0.2: waves of 10 pi / arccos(0.8) = 48.8 m and longer, and about 5 m, 2.5 m ..."""
    long, five, *_ = lost(5.0, 5.0, STEP)
    edge = np.arccos(0.8)
    assert long == (pytest.approx(10.0 * np.pi / edge, rel=0.01), pytest.approx(200.0))
    assert five == (pytest.approx(10 * np.pi / (2 * np.pi + edge), rel=0.01),
                    pytest.approx(10 * np.pi / (2 * np.pi - edge), rel=0.01))  # fmt: skip


def test_versines_of_a_file(tmp_path):
    """Both rails, the chord in the name or given; told which waves are lost."""
    values = 1e3 * versine(line, S, 5.0, 5.0)
    rows = "\n".join(f"{s:.2f};{v:.6f};{-v:.6f}" for s, v in zip(S, values, strict=True))
    path = tmp_path / "v.csv"
    path.write_text("s_m;versine_left_10m [mm];versine_right_10m [mm]\n" + rows)
    found = recording(path)
    assert_allclose(found.samples.channels["left_alignment"], -found.samples.channels["right_alignment"], atol=1e-9)
    assert_allclose(found.samples.channels["left_alignment"], restored(values * 1e-3, STEP, 5.0, 5.0), atol=1e-8)
    assert sum("48.8 to 200 m" in one.reason for one in found.decisions) == 2
    path.write_text("s_m;versine_left [mm];versine_right [mm]\n" + rows)
    with pytest.raises(InputError, match="is a versine and needs its chord: give chord_m"):
        recording(path)
    again = recording(path, Asked(chord=(5.0, 5.0)))
    assert_allclose(again.samples.channels["left_alignment"], found.samples.channels["left_alignment"], atol=1e-12)


def test_curvature_of_versines(tmp_path):
    """20 m chord in a curve of 400 m: 125 mm."""
    path = tmp_path / "a.csv"
    path.write_text("km;versine [mm]\n" + "\n".join(f"{k / 100};125" for k in range(10)))
    assert_allclose(read_alignment(path, chord=20.0).curvature, 1.0 / 400.0, rtol=tol.ROUNDING)
    with pytest.raises(InputError, match="needs the length of its chord"):
        read_alignment(path)
