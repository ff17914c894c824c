"""The only decorators of compiled code, and the folder in which the compiled code is kept.

Numba keys a cached function by the contents of its own file only, so a change in a callee would go unnoticed
(numba issue 1833). The cache folder is therefore named by a digest of all kernel sources.
"""

import hashlib
import os
import shutil
from pathlib import Path

import numba
import numpy as np
from numba import types

from .place import cache_root

KEPT_DIGESTS = 3
OPTIONS = {"cache": True, "_nrt": False, "error_model": "numpy", "nogil": True, "fastmath": {"contract"}}


def source_digest():
    """Hex digest of every file in this package and of the compiler's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _code_folder():
    root = Path(os.environ.get("NUMBA_CACHE_DIR") or cache_root() / "code")
    return root / f"railcli-{source_digest()}"


def forget_old_code(keep=KEPT_DIGESTS):
    """Delete the compiled code of all but the newest `keep` versions of the kernels."""
    folders = sorted(_FOLDER.parent.glob("railcli-*"), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in folders[keep:]:
        shutil.rmtree(path, ignore_errors=True)


def is_cold():
    """True when no compiled code is kept for these sources, so that the first call compiles."""
    return not any(_FOLDER.rglob("*.nbc"))


_FOLDER = _code_folder()
numba.config.CACHE_DIR = str(_FOLDER)


def kernel(function):
    """Compile a function of the core into each of its callers; types are taken from its first call.

    A call that stays a call passes every array of Model and Data through memory.
    """
    return numba.njit(forceinline=True, **OPTIONS)(function)


def seldom(function):
    """As `kernel`, for a large function that few steps need: it stays a call."""
    return numba.njit(**OPTIONS)(function)


def guest(function, signature):
    """Compile a user's function for one signature: it cannot allocate, and every access to its arrays is checked."""
    compiled = numba.njit(function, _nrt=False, boundscheck=True, error_model="numpy")
    compiled.compile(signature)
    return compiled


def outward(function, signature):
    """Compile a function that C calls by its address."""
    return numba.cfunc(signature)(function)


def builder(function):
    """As `kernel`, for a function outside the step, which may allocate."""
    return numba.njit(**{**OPTIONS, "_nrt": True})(function)


class Entry:
    """A function that Python calls, compiled at its first call for exactly one signature.

    An argument of another type is a TypeError, not a second compiled variant.
    """

    def __init__(self, function, signature):
        self.function, self.signature, self._compiled = function, signature, None
        self.__doc__, self.__name__ = function.__doc__, function.__name__

    def compiled(self):
        """The compiled function; compiles it or reads it from the cache when needed."""
        if self._compiled is None:
            self._compiled = numba.njit([self.signature], **OPTIONS)(self.function)
        return self._compiled

    def __call__(self, *arguments):
        return self.compiled()(*arguments)


def entry(signature):
    """Decorator of an `Entry`."""
    return lambda function: Entry(function, signature)


def constant(dtype, dimensions=1):
    """Numba type of a read-only C-contiguous array."""
    return types.Array(numba.from_dtype(np.dtype(dtype)), dimensions, "C", readonly=True)


def mutable(dtype, dimensions=1):
    """Numba type of a writable C-contiguous array."""
    return types.Array(numba.from_dtype(np.dtype(dtype)), dimensions, "C")
