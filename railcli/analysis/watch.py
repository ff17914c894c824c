"""A run watches itself: a force that alternates from step to step is the integrator's, not the vehicle's.

Of the changes d_k of a wheel force from step to step, rho = sum d_k d_(k-1) / sum d_k^2 is 1 for a smooth course and -1
for one that alternates; half the root of their mean square is then its amplitude (theory.md 8.4).
"""

import numpy as np

from .faults import wheel_name

ALTERNATES = -0.8  # rho below which a force alternates; a rattle of the model at 110 Hz has -0.3 at 1 ms
AUDIBLE = 100.0  # amplitude from which it is told [N]
SPAN = 0.25  # over which sums are taken [s]


class Watch:
    """A sink of rows that looks for alternating wheel forces.

    Parameters
    ----------
    system : System
    """

    def __init__(self, system):
        self.system = system
        self.worst = (0.0, "")
        self._began, self._sums, self._count = None, 0.0, 0

    def __call__(self, rows):
        """Take rows with the means over the steps of their intervals: `turn` of d_k d_(k-1), `move` of d_k^2."""
        if self._began is None:
            self._began = float(rows.time[0])
        self._sums = self._sums + np.stack([rows.turn.sum(axis=0), rows.move.sum(axis=0)])
        self._count += len(rows.time)
        if rows.time[-1] - self._began < SPAN:
            return
        turn, move = self._sums
        amplitude = np.where(turn < ALTERNATES * move, 0.5 * np.sqrt(move / self._count), 0.0)
        k = int(np.argmax(amplitude))
        if amplitude[k] > max(AUDIBLE, self.worst[0]):
            force, wheel = divmod(k, self.system.model.wheel.size)
            self.worst = float(amplitude[k]), (
                f"{'YQ'[force]} of wheel {wheel_name(self.system, wheel)} alternates from step to step by "
                f"{amplitude[k] * 1e-3:.3g} kN at t = {rows.time[-1]:.2f} s, s = {rows.q[-1, 0, 0]:.1f} m"
            )
        self._began, self._sums, self._count = float(rows.time[-1]), 0.0, 0

    @property
    def warning(self):
        """One sentence, or nothing."""
        amplitude, what = self.worst
        if not amplitude:
            return ""
        step = float(self.system.model.param[0]["step"])
        return f"Numerically unstable, use step_ms <= {0.5e3 * step:.4g} and compare: {what}"
