"""What a chord measures, and what can be told from it of the line it was laid on.

A chord from `before` behind a point to `after` ahead of it shows the offset of the point (its versine)

    v(s) = y(s) - (after y(s - before) + before y(s + after)) / (before + after),

so a wave exp(i k s) of the line appears H(k) times, with

    H(k) = 1 - (after exp(-i k before) + before exp(i k after)) / (before + after);

1 - cos(k c / 2) where the point is the middle of a chord c. H is zero for waves of which a whole number fits into both
parts, and nearly zero for waves much longer than the chord: such waves cannot be told.
"""

import numpy as np

LEAST, FULL = 0.1, 0.2  # |H| below which a wave is given up, and from which it is restored whole
LONGEST = 200.0  # waves looked at [m]
SHORTEST = 0.1  # likewise, of the chord: shorter ones are lost in the same places, ever closer
PADDED = 10.0  # chords by which the record is continued at both ends


def transfer(wavenumber, before, after):
    """H over wavenumbers [rad/m], complex; `before` and `after` [m] are the parts of the chord."""
    ends = after * np.exp(-1j * wavenumber * before) + before * np.exp(1j * wavenumber * after)
    return 1.0 - ends / (before + after)


def restored(versine, step, before, after):
    """The line of which a chord showed this versine, without the waves that it cannot show.

    Parameters
    ----------
    versine : array (n,)
        Offsets of the point from the chord, in the signs of the line [m].
    step : float
        Their distance [m].
    before, after : float
        Parts of the chord [m].

    Returns
    -------
    array (n,)
        [m]; within some 15 chords of its ends it follows from the mirror image too by which the record is continued.
    """
    count = min(versine.size - 1, int(np.ceil(PADDED * (before + after) / step)))
    head, tail = 2.0 * versine[0] - versine[count:0:-1], 2.0 * versine[-1] - versine[-2 : -count - 2 : -1]
    long = np.concatenate([head, versine, tail])
    long = (long - long.mean()) * _tapered(long.size, count)
    wavenumber = 2.0 * np.pi * np.fft.rfftfreq(long.size, step)
    shown = transfer(wavenumber, before, after)
    size = np.abs(shown)
    share = _share(size)
    gain = share * np.conj(shown) / np.where(size > 0.0, size, 1.0) ** 2
    return np.fft.irfft(gain * np.fft.rfft(long), long.size)[count : count + versine.size]


def lost(before, after, step, longest=LONGEST):
    """Bands of wavelengths [m] that are not restored whole: list of (shortest, longest), long ones first."""
    shortest = max(2.0 * step, SHORTEST * (before + after))
    number = np.linspace(1.0 / longest, 1.0 / shortest, 20_001)
    weak = np.abs(transfer(2.0 * np.pi * number, before, after)) < FULL
    edges = np.flatnonzero(np.diff(weak.astype(int)))
    bounds = np.concatenate([[0], edges + 1, [number.size]])
    return [(float(1.0 / number[stop - 1]), float(1.0 / number[start]))
            for start, stop in zip(bounds[:-1], bounds[1:], strict=True) if weak[start]]  # fmt: skip


def _share(size):
    u = np.clip((size - LEAST) / (FULL - LEAST), 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def _tapered(size, count):
    """1, falling to 0 over half of what was added at both ends."""
    half = max(count // 2, 1)
    factor = np.ones(size)
    rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(half) + 0.5) / half)
    factor[:half], factor[size - half :] = rise, rise[::-1]
    return factor
