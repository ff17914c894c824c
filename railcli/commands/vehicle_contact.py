"""What `modes` and `critical-speed` share: one thread, and a scenario."""

import os


def one_thread():
    """Keep linear algebra to one thread, before numpy is loaded: with these small matrices more only wait."""
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


def scenario_of(name, default, speed=None):
    """A built-in or a user's scenario, with another speed [m/s] where one is given."""
    from railcli.files.changes import changed
    from railcli.files.scenario import load

    case = load(name or default)
    return case if speed is None else changed(case, {"run.speed_m_per_s": speed})
