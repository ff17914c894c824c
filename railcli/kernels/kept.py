"""Compiled code kept on disk: it saves time and nothing else, so that a run never depends on it.

Numba's own cache keys a function by the contents of its own file only, so that a change in a callee goes unnoticed
(numba issue 1833); believes what it reads, so that one changed bit of machine code runs; falls back to a folder beside
the sources, where old code is found again; and ends the process where it cannot be written. Here a file is named by a
digest of all that determines the code and sealed by another one, and what cannot be read or written is compiled.
"""

import hashlib
import os
import re
import secrets
import sys
import warnings
from contextlib import suppress
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps, loads

from .place import cache_root

PACKAGE = Path(__file__).parent
NO_NUMBERS = ("kept.py", "place.py")  # where and in which form code is kept
ENDING = ".code"
SEAL = hashlib.sha256().digest_size
VERSION = 2  # of the form of these files
SETTINGS = (  # of numba that change the code
    "BOUNDSCHECK", "OPT", "DEBUGINFO_DEFAULT", "ENABLE_AVX", "LOOP_VECTORIZE", "SLP_VECTORIZE",
)  # fmt: skip
KEPT_DIGESTS = 3
FOLDER_NAME = re.compile(r"railcli-[0-9a-f]{16}")


def source_digest():
    """Hex digest of every file in this package that determines a number, and of the compiler's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(PACKAGE.glob("*.py")):
        if path.name not in NO_NUMBERS:
            digest.update(path.name.encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _surroundings():
    """What the code depends on beside its source."""
    settings = [getattr(numba.config, name, None) for name in SETTINGS]
    return repr((VERSION, _DIGEST, sys.version_info[:2], llvmlite.__version__, np.__version__, settings))


_DIGEST = source_digest()
_FOLDER = Path(os.environ.get("NUMBA_CACHE_DIR") or cache_root() / "code") / f"railcli-{_DIGEST}"
_SURROUNDINGS = _surroundings()


class KeptCode(NullCache):
    """The compiled variants of one function on disk, in the place of numba's cache of a dispatcher.

    Parameters
    ----------
    function : callable
        Not compiled. Sources outside this package count by the file that holds them.
    """

    def __init__(self, function):
        code = function.__code__
        path = Path(code.co_filename)
        outside = b"" if path.parent == PACKAGE else path.read_bytes() if path.is_file() else code.co_code
        closure = [cell.cell_contents for cell in function.__closure__ or ()]
        self._stem = f"{path.stem}.{function.__qualname__.rpartition('.')[2]}"
        self._own = repr((_SURROUNDINGS, self._stem, code.co_firstlineno, closure, hashlib.sha256(outside).digest()))

    @property
    def cache_path(self):
        return str(_FOLDER)

    def load_overload(self, sig, target_context):
        """The compiled code of a signature; None when it is not kept, or not as it was written."""
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        try:
            data = path.read_bytes()
        except OSError:
            return None
        try:
            image, seal = data[:-SEAL], data[-SEAL:]
            if hashlib.sha256(image).digest() != seal:
                raise ValueError("its checksum does not fit")
            return CompileResult._rebuild(target_context, *loads(image))
        except Exception as damage:  # whatever a damaged file makes its reader raise
            _tell(f"compiled code in {path} is damaged ({type(damage).__name__}: {damage}); it is compiled again")
            with suppress(OSError):
                path.unlink()
            return None

    def save_overload(self, sig, data):
        """Keep the compiled code of a signature, whole or not at all."""
        if data.lifted or data.library.has_dynamic_globals:
            return
        image = dumps(data._reduce())
        path = self._path(sig, data.codegen)
        temporary = path.with_name(f"{path.name}.{secrets.token_hex(4)}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            temporary.write_bytes(image + hashlib.sha256(image).digest())
            os.replace(temporary, path)
        except OSError as error:
            _tell(
                f"compiled code cannot be kept in {_FOLDER} ({error.strerror or error}): every run compiles again; "
                "RAILCLI_CACHE_DIR names another place"
            )
        finally:
            with suppress(OSError):
                temporary.unlink()

    def _path(self, sig, codegen):
        """Another file for every signature, processor and source."""
        key = f"{self._own}{sig!r}{codegen.magic_tuple()!r}"
        return _FOLDER / f"{self._stem}-{hashlib.sha256(key.encode()).hexdigest()[:24]}{ENDING}"


_told = set()


def _tell(text):
    """Warn once of each kind of trouble, for all functions have the same."""
    kind = text.split()[3]
    if kind not in _told:
        _told.add(kind)
        warnings.warn(text, RuntimeWarning, stacklevel=2)


def is_kept(name):
    """True when code of a function, such as ``step.advance``, is kept for these sources."""
    return any(_FOLDER.glob(f"{name}-*{ENDING}"))


def forget_old_code(keep=KEPT_DIGESTS):
    """Delete the compiled code of all but the `keep` versions of the kernels that were used last."""
    with suppress(OSError):
        os.utime(_FOLDER)
    for path in code_folders()[keep:]:
        forget(path)


def code_folders():
    """Folders of compiled code, the one that was used last first."""
    found = []
    with suppress(OSError):
        for path in _FOLDER.parent.iterdir():
            if FOLDER_NAME.fullmatch(path.name) and path.is_dir():
                found.append((path.stat().st_mtime, path))
    return [path for _, path in sorted(found, reverse=True)]


def forget(folder):
    """Delete a folder of compiled code, and of all files in it no other ones than ours and those of numba."""
    for path in sorted(folder.rglob("*"), reverse=True):
        with suppress(OSError):
            if path.is_dir():
                path.rmdir()
            elif re.search(r"\.(code|nbi|nbc)(\.|$)", path.name):
                path.unlink()
    with suppress(OSError):
        folder.rmdir()
