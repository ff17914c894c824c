"""The comparison of track disturbances with the linear vertical model as text, JSON and figures."""

import numpy as np

from railcli.analysis.disturbance import BEGIN, LARGE_LENGTH, LATERAL, LATERAL_LENGTH, LIMIT_HZ, SPEED, STEPS

from .figures import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION, draw
from .text import columns, speed

FIGURES = ("disturbance", "disturbance-lift", "disturbance-lateral")
WHEELSETS = (BLUE, VERMILION, GREEN, ORANGE)


def sections(result):
    """Titles and lines of the report."""
    return [
        (f"Small vertical disturbances at {speed(SPEED)} against the linear vertical model, up to {LIMIT_HZ:g} Hz",
         _small(result)),
        ("Frequency response to waves of both rails, per metre of height", _waves(result.waves)),
        (f"Bumps of {LARGE_LENGTH:g} m beyond the linear range, W1 right (described, not judged)", _large(result)),
        ("Lateral disturbances of both rails (described, not judged)", _lateral(result)),
    ]  # fmt: skip


def _small(result):
    rows = [
        (
            f"{bump.length:g} m, {bump.height * 1e3:g} mm", f"{bump.step * 1e3:g} ms",
            f"{1e-3 * np.abs(bump.force).max():.3f}", f"{1e-3 * np.abs(bump.linear_force).max():.3f}",
            f"{100 * bump.share:.1f}%", f"{100 * bump.force_error:.2f}%", f"{np.abs(bump.acceleration).max():.5f}",
            f"{np.abs(bump.linear_acceleration).max():.5f}", f"{100 * bump.acceleration_error:.2f}%",
        )
        for bump in result.bumps
    ]  # fmt: skip
    header = (
        "bump", "step", "dQ [kN]", "linear", "of static", "differs", "car z'' [m/s2]", "linear", "differs",
    )  # fmt: skip
    return columns(rows, header)


def _waves(waves):
    rows = []
    for k, frequency in enumerate(waves.frequency):
        found, wanted = waves.force[k, 0], waves.linear_force[k, 0]
        rows.append(
            (
                f"{frequency:g} Hz", f"{SPEED / frequency:.3g}", f"{1e-6 * abs(found):.4g}",
                f"{1e-6 * abs(wanted):.4g}", f"{np.degrees(np.angle(found / wanted)):+.2f}",
                f"{100 * waves.force_error[k]:.2f}%", f"{abs(waves.acceleration[k]):.4g}",
                f"{abs(waves.linear_acceleration[k]):.4g}", f"{100 * waves.acceleration_error[k]:.2f}%",
            )
        )  # fmt: skip
    header = (
        "", "wave [m]", "W1 dQ [kN/mm]", "linear", "phase [deg]", "worst differs", "car z'' [1/s2]", "linear",
        "differs",
    )  # fmt: skip
    return columns(rows, header)


def _large(result):
    rows = [
        (
            f"{bump.height * 1e3:g} mm", f"{1e-3 * bump.force.min():.1f}", f"{1e-3 * bump.linear_force.min():.1f}",
            f"{1e-3 * bump.force.max():.1f}", f"{1e-3 * bump.linear_force.max():.1f}",
            f"{1e3 * bump.lifted:.1f}", f"{bump.acceleration:.3f}", f"{bump.linear_acceleration:.3f}",
        )
        for bump in result.large
    ]  # fmt: skip
    header = (
        "height", "least Q [kN]", "linear", "largest Q", "linear", "off the rail [ms]", "car z'' [m/s2]", "linear",
    )  # fmt: skip
    return columns(rows, header)


def _lateral(result):
    rows = []
    for case in result.lateral:
        trace = case.trace
        name = f"{case.shape}, {LATERAL[case.shape] * 1e3:g} mm over {LATERAL_LENGTH[case.shape]:g} m"
        rows.append(
            (
                name, *(f"{1e3 * value:.2f}" for value in trace.lateral.max(axis=0)[[-4, -3, 0]]),
                f"{1e-3 * np.abs(trace.side_force).max():.2f}",
                f"{1e-3 * trace.force.min():.1f} ... {1e-3 * trace.force.max():.1f}",
                f"{np.abs(trace.acceleration[:, 0, 1]).max():.3f}", f"{np.abs(trace.acceleration[:, 0, 2]).max():.4f}",
                f"{case.mirror_error:.0e}",
            )
        )  # fmt: skip
    header = (
        "rails move", "W1 y [mm]", "W2 y", "car y", "largest Y [kN]", "Q [kN]", "car y'' [m/s2]", "car z''",
        "mirrored [m]",
    )  # fmt: skip
    return columns(rows, header)


def as_json(result):
    """The whole comparison as one object."""
    waves = result.waves
    return {
        "static_force_kN": result.static_force * 1e-3,
        "small_bumps": [
            {
                "length_m": bump.length,
                "height_mm": bump.height * 1e3,
                "step_ms": bump.step * 1e3,
                "force_change_kN": float(np.abs(bump.linear_force).max() * 1e-3),
                "share_of_static": bump.share,
                "force_error": bump.force_error,
                "acceleration_error": bump.acceleration_error,
            }
            for bump in result.bumps
        ],
        "frequency_response": [
            {
                "frequency_Hz": float(f),
                "force_N_per_m": np.abs(waves.force[k]).tolist(),
                "linear_force_N_per_m": np.abs(waves.linear_force[k]).tolist(),
                "force_error": float(waves.force_error[k]),
                "acceleration_per_s2": float(np.abs(waves.acceleration[k])),
                "linear_acceleration_per_s2": float(np.abs(waves.linear_acceleration[k])),
                "acceleration_error": float(waves.acceleration_error[k]),
            }
            for k, f in enumerate(waves.frequency)
        ],
        "large_bumps": [
            {
                "height_mm": bump.height * 1e3,
                "least_force_kN": float(bump.force.min() * 1e-3),
                "largest_force_kN": float(bump.force.max() * 1e-3),
                "largest_force_of_all_kN": bump.peak * 1e-3,
                "off_the_rail_ms": bump.lifted * 1e3,
                "acceleration_m_per_s2": bump.acceleration,
                "linear_acceleration_m_per_s2": bump.linear_acceleration,
            }
            for bump in result.large
        ],
        "lateral": [
            {
                "shape": case.shape,
                "largest_side_force_kN": float(np.abs(case.trace.side_force).max() * 1e-3),
                "largest_lateral_mm": (1e3 * np.abs(case.trace.lateral).max(axis=0)).tolist(),
                "mirror_error_m": case.mirror_error,
            }
            for case in result.lateral
        ],
    }


def figures(result, folder):
    """Draw the FIGURES."""
    painters = (_draw_small, _draw_large, _draw_lateral)
    for name, painter, size in zip(FIGURES, painters, ((11.0, 8.0), (9.5, 6.0), (9.5, 6.5)), strict=True):
        draw(lambda figure, painter=painter: painter(figure, result), folder / f"{name}.png", size)


def _draw_small(figure, result):
    bump = next(bump for bump in result.bumps if bump.length == 3.0 and bump.step == STEPS[1])
    upper, lower = figure.subfigures(2, 1, hspace=0.04)
    force, acceleration = upper.subplots(1, 2)
    title = f"Bump of {bump.height * 1e3:g} mm over {bump.length:g} m, below {LIMIT_HZ:g} Hz"
    for k, colour in enumerate(WHEELSETS[: bump.force.shape[1]]):
        force.plot(bump.time, 1e-3 * bump.linear_force[:, k], color=colour, linewidth=3.0, alpha=0.35)
        force.plot(bump.time, 1e-3 * bump.force[:, k], color=colour, linewidth=0.8, label=f"W{k + 1}")
    force.set(title=f"{title}: wheel force", ylabel="change of Q [kN]", xlabel="time [s]", xlim=(0.15, 1.1))
    force.legend(title="thin: railcli, wide: linear", ncols=2)
    acceleration.plot(bump.time, bump.linear_acceleration, color=BLUE, linewidth=3.0, alpha=0.35, label="linear")
    acceleration.plot(bump.time, bump.acceleration, color=BLUE, linewidth=0.8, label="railcli")
    acceleration.set(title="car body, down", ylabel="[m/s²]", xlabel="time [s]", xlim=(0.15, 2.2))
    acceleration.legend()
    waves = result.waves
    response, body, error = lower.subplots(1, 3)
    coarse, size = waves.frequency, np.abs(waves.fine_response)
    for k, colour in enumerate(WHEELSETS[: waves.force.shape[1]]):
        response.loglog(waves.fine, 1e-6 * size[:, k], color=colour, linewidth=0.8)
        response.loglog(coarse, 1e-6 * np.abs(waves.force[:, k]), ".", color=colour, label=f"W{k + 1}")
    response.set(title="Wheel force per height", ylabel="[kN/mm]", xlabel="frequency [Hz]")
    response.legend(title="lines: linear")
    body.loglog(waves.fine, size[:, -1], color=GREY, linewidth=0.8, label="linear")
    body.loglog(coarse, np.abs(waves.acceleration), ".", color=BLUE, label="railcli")
    body.set(title="Car body's acceleration per height", ylabel="[1/s²]", xlabel="frequency [Hz]", ylim=(1e-2, 3e2))
    body.legend()
    error.semilogx(coarse, 100 * waves.force_error, ".-", color=VERMILION, label="wheel force, worst")
    error.semilogx(coarse, 100 * waves.acceleration_error, ".-", color=BLUE, label="car body, of the largest")
    error.axhline(1.0, color=GREY, linewidth=0.8, linestyle="--")
    error.set(title="Difference", ylabel="[%]", xlabel="frequency [Hz]", ylim=(0.0, 1.2))
    error.legend()


def _draw_large(figure, result):
    for axis, bump in zip(figure.subplots(2, 2, sharex=True).flat, result.large, strict=True):
        axis.plot(bump.time, 1e-3 * bump.linear_force, color=GREY, label="linear")
        axis.plot(bump.time, 1e-3 * bump.force, color=BLUE, label="railcli")
        axis.axhline(0.0, color="black", linewidth=0.6)
        axis.set(title=f"Bump of {bump.height * 1e3:g} mm", xlim=(0.2, 0.42))
        axis.set(ylabel="Q of W1 right [kN]", xlabel="time [s]")
        axis.legend()


def _draw_lateral(figure, result):
    grid = figure.subplots(2, len(result.lateral), sharex=True)
    for (upper, lower), case in zip(grid.T, result.lateral, strict=True):
        trace = case.trace
        for body, colour, name in ((-4, BLUE, "W1"), (-3, VERMILION, "W2"), (1, GREEN, "bogie 1"), (0, PURPLE, "car")):
            upper.plot(trace.time, 1e3 * trace.lateral[:, body], color=colour, label=name)
        for wheel, name, colour in ((0, "W1 right", BLUE), (1, "W1 left", VERMILION)):
            lower.plot(trace.time, 1e-3 * trace.side_force[:, wheel], color=colour, label=name)
        upper.set(title=f"Both rails move by {LATERAL[case.shape] * 1e3:g} mm: {case.shape}", ylabel="y [mm]")
        lower.set(ylabel="Y [kN]", xlabel=f"time [s]; the disturbance begins at s = {BEGIN:g} m")
        upper.legend()
        lower.legend()
