"""What `modes` and `critical-speed` share: a scenario and its quasi-linear contact."""

import os


def one_thread():
    """Keep linear algebra to one thread, before numpy is loaded: with these small matrices more only wait."""
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def scenario_of(name, default, speed=None):
    """A built-in or a user's scenario, with another speed [m/s] where one is given."""
    from railcli.files.scenario import load, varied

    case = load(name or default)
    return case if speed is None else varied(case, "run", "speed_m_per_s", speed)


def quasi_linear_contact(case, amplitudes_mm, quiet):
    """Quasi-linear contact of a scenario for each amplitude [mm]: one QuasiLinear for each wheel radius."""
    from railcli.analysis.quasi_linear import lines_of
    from railcli.files.profiles import profile_of
    from railcli.files.progress import Progress

    wheel = profile_of(case, case.contact.wheel_profile, "wheel")
    rail = profile_of(case, case.contact.rail_profile, "rail")
    with Progress("Contact", 100, "%", quiet) as progress:
        return lines_of(
            case, wheel, rail, [value * 1e-3 for value in amplitudes_mm],
            lambda share: progress.update(round(100 * share)),
        )  # fmt: skip
