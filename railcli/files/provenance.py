"""Where a result comes from: versions, digests, machine, date."""

import platform
import re
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import h5py
import numba
import numpy

from railcli import __version__
from railcli.kernels import jit


def provenance(scenario=None, tables=()):
    """What a summary records about its origin.

    Parameters
    ----------
    scenario : Scenario, optional
    tables : sequence of ContactTable
    """
    facts = {
        "railcli": __version__,
        "kernels": jit.source_digest(),
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "numba": numba.__version__,
        "h5py": h5py.__version__,
        "platform": platform.platform(),
        "cpu": cpu_name(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if scenario is not None:
        facts["scenario"] = {"name": scenario.name, "digest": scenario.digest()}
    if tables:
        facts["contact_tables"] = [
            {
                "key": table.key,
                "method": table.method,
                "wheel_radius_m": table.settings.radius,
                "wheel": {"name": table.wheel_name, "sha256": table.wheel_digest},
                "rail": {"name": table.rail_name, "sha256": table.rail_digest},
            }
            for table in tables
        ]
    return facts


def cpu_name():
    """Name of the processor as the system gives it."""
    try:
        if sys.platform.startswith("linux"):
            text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
            if found := re.search(r"^(?:model name|Hardware|Model)\s*:\s*(.+)$", text, flags=re.M):
                return found[1].strip()
        if sys.platform == "darwin":
            command = ["sysctl", "-n", "machdep.cpu.brand_string"]
            return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        pass
    return platform.processor() or platform.machine() or "unknown"
