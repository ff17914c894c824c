"""The contact at the flange root by two normal laws: force over y at one height, and patches by the law of strips.

Run `python benchmarks/contact/root.py [PNG]` in the repository. A minimum of the gap folds at this roll and yaw as the
wheel moves towards its flange; what bore there by Hertz's law at contact points is lost there at once.
"""

import math
import sys

import numpy as np

from railcli.analysis.certify import direct_minima
from railcli.analysis.certify_forces import direct
from railcli.analysis.overlap import Law
from railcli.files.profiles import load_profile
from railcli.model.contact_table import TableSettings, mount
from railcli.report.figures import BLUE, GREY, SERIES, draw

ROLL, YAW = 1.221e-3, 4.663e-3  # [rad]
Y = np.arange(6.40, 6.561, 0.005) * 1e-3  # [m]
SHOWN = np.array([6.44, 6.48, 6.5, 6.52, 6.56]) * 1e-3  # of patches [m]
DEPTH = 80e-6  # at 6.5 mm beyond first touch [m]


def main(path):
    """Draw the picture."""
    settings = TableSettings(normal="hertz")
    mounting = mount(load_profile("ORES1002", "wheel"), load_profile("UIC60", "rail"), settings)
    law = Law(mounting, settings.young, settings.poisson)
    points = direct(mounting, settings)
    z = direct_minima(mounting, (6.5e-3, ROLL, YAW), law.stations)[:, 1].min() + DEPTH
    strips = np.array([law(y, z, ROLL, YAW).gradient[1] for y in Y]) / 1e3
    minima = [direct_minima(mounting, (y, ROLL, YAW), law.stations) for y in Y]
    hertz = np.array([points((y, ROLL, YAW), z, each).q for y, each in zip(Y, minima, strict=True)]) / 1e3

    def paint(figure):
        force, shape, pressure = figure.subplots(1, 3, width_ratios=(1.1, 1.0, 1.0))
        force.plot(Y * 1e3, hertz, color=GREY, label="hertz: ellipses at contact points")
        force.plot(Y * 1e3, strips, color=BLUE, label="overlap: strips")
        force.set(xlabel="lateral position y [mm]", ylabel="vertical force Q [kN]")
        force.set_title(f"Q at one height; roll {ROLL * 1e3:g}, yaw {YAW * 1e3:g} mrad")
        force.legend(loc="upper left")
        for colour, y in zip(SERIES, SHOWN, strict=False):
            found = law(y, z, ROLL, YAW)
            on = found.line_load > 0.0
            place, half = found.overlap["lateral"][on] * 1e3, found.overlap["half"][on] * 1e3
            label = f"y = {y * 1e3:.2f} mm, Q = {found.gradient[1] / 1e3:.0f} kN"
            shape.fill_between(place, -half, half, color=colour, alpha=0.25)
            shape.plot(place, half, color=colour)
            shape.plot(place, -half, color=colour)
            greatest = 2.0 * found.line_load[on] / (math.pi * half * 1e-3)
            pressure.plot(place, greatest / 1e6, color=colour, label=label)
        shape.set(xlabel="on the wheel, to the field side [mm]", ylabel="rolling direction [mm]")
        shape.set_title("Patches by strips")
        pressure.set(xlabel="on the wheel, to the field side [mm]", ylabel="greatest pressure of a strip [MPa]")
        pressure.set_title("and their pressure")
        pressure.legend(loc="upper right", fontsize="small")

    draw(paint, path, (13.0, 4.6))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "root.png")
