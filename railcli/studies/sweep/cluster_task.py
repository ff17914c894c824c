"""What a worker of a cluster does: it unpacks a study once, and makes rows of it."""

import tempfile
import threading
from pathlib import Path

import numba
import numpy
import scipy

from railcli import __version__
from railcli.files.sweep import unpack
from railcli.kernels import jit

from .one_run import Runner
from .worker import given

MOST = 2  # studies that a worker keeps at hand
_runners: dict = {}
_lock = threading.Lock()


def versions():
    """What must be the same everywhere for rows to be alike."""
    return {
        "railcli": __version__, "kernels": jit.source_digest(), "numba": numba.__version__,
        "numpy": numpy.__version__, "scipy": scipy.__version__,
    }  # fmt: skip


def unpacked(package):
    """The package of a study, as a task of its own: dask hands it to each worker once, and again if one is lost."""
    return package


def row(package, task):
    """The row of a run."""
    return _runner(package).row(*task)


def _runner(package):
    """The Runner of a study, one for all threads of this process."""
    key = package["digest"]
    with _lock:
        if key not in _runners:
            while len(_runners) >= MOST:
                del _runners[next(iter(_runners))]
            with tempfile.TemporaryDirectory(prefix="railcli-sweep-") as folder:
                unpack(package, Path(folder))
                _runners[key] = Runner(given(folder))
        return _runners[key]
