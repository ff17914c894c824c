"""The only decorators of compiled code; `kept` keeps what they compile."""

import numba
import numpy as np
from numba import types

from .kept import KeptCode, forget_old_code, is_kept, source_digest

__all__ = [
    "Entry", "builder", "constant", "entry", "forget_old_code", "is_kept", "kernel", "mutable", "seldom",
    "source_digest",
]  # fmt: skip
OPTIONS = {"_nrt": False, "error_model": "numpy", "nogil": True, "fastmath": {"contract"}}


def _compiled(function, **options):
    """The function behind numba's dispatcher, whose compiled code is kept; itself where numba is switched off."""
    dispatcher = numba.njit(**{**OPTIONS, **options})(function)
    if dispatcher is not function:
        dispatcher._cache = KeptCode(function)
    return dispatcher


def kernel(function):
    """Compile a function of the core into each of its callers; types are taken from its first call.

    A call that stays a call passes every array of Model and Data through memory.
    """
    return _compiled(function, forceinline=True)


def seldom(function):
    """As `kernel`, for a large function that few steps need: it stays a call."""
    return _compiled(function)


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
    return _compiled(function, _nrt=True)


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
            compiled = _compiled(self.function)
            if compiled is not self.function:
                compiled.compile(self.signature)
                compiled.disable_compile()
            self._compiled = compiled
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
