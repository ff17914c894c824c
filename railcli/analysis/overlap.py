"""The law of strips evaluated directly at one pose of a wheel (theory.md section 6.7)."""

from dataclasses import dataclass

import numpy as np

from railcli.kernels.columns import bear
from railcli.kernels.layout import ROW, Part
from railcli.kernels.overlap import OVERLAP
from railcli.model.strips import strips_of

from .certify import direct_minima
from .rigid_contact import fine_stations

TOLERANCE, MOST = 1e-8, 300


@dataclass(frozen=True, eq=False)
class Bearing:
    """A wheel that bears on its rail.

    Attributes
    ----------
    energy : float
        [J]
    gradient : array (4,)
        By y, z [N], roll and yaw [N m]: minus the force and moment on the wheel.
    patches : array (k, ROW)
        Loaded parts from the flange to the field side, members of `kernels.layout.Part`, semi-axes in [m].
    overlap : OVERLAP array (n,)
        Of every strip.
    line_load : array (n,)
        [N/m]
    """

    energy: float
    gradient: np.ndarray
    patches: np.ndarray
    overlap: np.ndarray
    line_load: np.ndarray


class Law:
    """The law of strips for one wheel on its rail.

    Parameters
    ----------
    mounting : Mounting
    young, poisson : float
        Of both bodies [Pa], [-].
    fineness : float
        Divides the widths of the strips.
    """

    def __init__(self, mounting, young, poisson, fineness=1.0):
        self.mounting, self.strips = mounting, strips_of(mounting, fineness)
        self.elastic = young / (2.0 * (1.0 - poisson**2))
        self.stations = fine_stations(mounting)

    def __call__(self, y, z, roll, yaw, minima=None, tolerance=TOLERANCE, most=MOST):
        """Bearing at a pose, T standing at z.

        minima : array, optional
            As `direct.direct_minima` gives them for this pose.
        """
        minima = direct_minima(self.mounting, (y, roll, yaw), self.stations) if minima is None else minima
        n = self.strips.strip.size
        row, h, q, chi = np.zeros(n, OVERLAP), np.zeros(n), np.zeros(n), np.zeros(self.strips.nodes)
        patches = np.zeros((minima.shape[0], 1, ROW))
        arguments = self.mounting.kernel_arguments[:5]
        energy, *gradient = bear(
            z, roll, yaw, y, *arguments, self.strips.strip, self.strips.apart, self.elastic,
            tolerance, most, minima, row, h, q, chi, patches,
        )  # fmt: skip
        loaded = patches[patches[:, 0, Part.SHARE] > 0.0, 0]
        return Bearing(energy, np.array(gradient), loaded, row, q)
