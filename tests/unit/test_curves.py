"""Curves of a report: no peak is lost to thinning, spectra have the power of their signal."""

import h5py
import numpy as np
import pytest
import tolerances as tol

from railcli.files.read_results import Results
from railcli.report import curves
from railcli.report.curves import Curves
from railcli.report.settings import differing, flat


@pytest.fixture
def opened(recorded):
    with Results(recorded()) as results:
        yield results


def test_thinned_curves_keep_every_peak(opened, recorded, monkeypatch):
    """At most 60 points for 450 rows, in pieces of 30 rows; the extremes of every bucket are among them."""
    whole = Curves(opened, "whole")
    full = whole.single("wheels/W1_left/Y")
    with h5py.File(recorded() / "timeseries.h5", locking=False) as file:
        assert np.array_equal(full, file["wheels/W1_left/Y"])
    monkeypatch.setattr(curves, "MOST_POINTS", 60)
    monkeypatch.setattr(curves, "PIECE", 30)
    few = Curves(opened, "few")
    thin, s = few.single("wheels/W1_left/Y"), few.s
    assert thin.size == s.size <= 60 + 2 < full.size
    assert (np.diff(s) >= 0.0).all() and s[0] == whole.s[0] and s[-1] == whole.s[-1]
    for start, low, high in zip(range(0, full.size, few.bucket), thin[::2], thin[1::2], strict=True):
        part = full[start : start + few.bucket]
        assert (low, high) == (part.min(), part.max())


def test_creepages_are_those_of_the_patch_that_bears_most(opened, recorded):
    found = Curves(opened, "a").creepages("W1_right")
    with h5py.File(recorded() / "timeseries.h5", locking=False) as file:
        contact = file["wheels/W1_right/contact"]
        for values, name in zip(found, ("xi", "eta", "phi", "on_wheel"), strict=True):
            expected = [row[load.argmax()] for row, load in zip(contact[name][:], contact["normal"][:], strict=True)]
            assert np.array_equal(values, expected)


def test_quotient_is_positive_towards_the_flange(opened, recorded):
    """Forces that press a wheel's flange against its rail point to the field side: right there, left there."""
    one = Curves(opened, "a")
    with h5py.File(recorded() / "timeseries.h5", locking=False) as file:
        for name, sign in (("W1_right", 1.0), ("W1_left", -1.0)):
            y, q = file[f"wheels/{name}/Y"][:], file[f"wheels/{name}/Q"][:]
            np.testing.assert_allclose(one.quotient(name), sign * y / q, rtol=tol.ROUNDING)


class Sine:
    """Ten seconds of a sine of amplitude 2 at 7 Hz, as results give them."""

    time = np.arange(1, 1001) * 0.01

    def read(self, _):
        return 3.0 + 2.0 * np.sin(2.0 * np.pi * 7.0 * self.time)[:, None]


def test_spectrum_has_the_power_of_its_signal():
    """The mean square of a sine is half the square of its amplitude, whatever the constant beside it."""
    frequency, density = Curves(Sine(), "a").spectrum("", 0)
    assert density.sum() * frequency[0] == pytest.approx(2.0, rel=tol.WELCH_POWER)
    assert frequency[density.argmax()] == pytest.approx(7.0) and frequency[-1] == pytest.approx(50.0)


def test_uneven_rows_have_no_spectrum():
    uneven = Sine()
    uneven.time = np.append(Sine.time, 11.0)
    one = Curves(uneven, "a")
    assert one.spectrum("", 0) is None and "even intervals" in one.notes[0]


def test_settings_are_compared_flat():
    one = {"run": {"v": 1.0}, "body": [{"m": 1.0, "i": [1, 2]}, {"m": 2.0}], "title": "a"}
    two = {"run": {"v": 1.0}, "body": [{"m": 1.0, "i": [1, 3]}], "title": "b"}
    assert flat(one)["body[2].m"] == 2.0
    assert differing([one, two]) == [("body[1].i", [1, 2], [1, 3]), ("body[2].m", 2.0, None)]
    assert differing([one, one]) == []
