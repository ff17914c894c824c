"""One process at a time: locks that the system lets go when their process ends, however it ends."""

import os
from contextlib import contextmanager, suppress

try:
    import fcntl
except ImportError:  # there is none on Windows, where no one waits and whole files keep the peace
    fcntl = None

HELD, FREE, UNKNOWN = "held", "free", "unknown"


@contextmanager
def alone(path, waiting=None):
    """Hold the lock of a file that is to be made; threads of one process exclude one another too.

    Where the system or its file system knows no such locks, nobody waits.

    Parameters
    ----------
    path : pathlib.Path
        The lock is a file beside it, gone when no one holds it.
    waiting : callable, optional
        Called once when another one holds it.
    """
    place = path.with_name(f".{path.name}.lock")
    descriptor = None if fcntl is None else _take(place, waiting)
    try:
        yield
    finally:
        if descriptor is not None:
            with suppress(OSError):
                place.unlink()  # while it is held: who waits for it sees that it is gone, and takes another
            os.close(descriptor)


@contextmanager
def busy(path):
    """Hold the lock of a file that exists, as long as it is written; gives False when another one holds it."""
    descriptor, free = None, True
    if fcntl is not None:
        with suppress(OSError):
            descriptor = os.open(path, os.O_RDWR)
    if descriptor is not None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            free = False
        except OSError:
            pass
    try:
        yield free
    finally:
        if descriptor is not None:
            os.close(descriptor)


def new(path):
    """Make an empty file and hold its lock; gives the descriptor to close when it is not written any more."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    if fcntl is not None:
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX)
    return descriptor


def delete_if_free(path):
    """Delete a file whose lock nobody holds; it stays where there are no locks."""
    if fcntl is None:
        return
    with suppress(OSError):
        descriptor = os.open(path, os.O_RDWR)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.unlink(path)  # while the lock is held: who made it meanwhile sees that it is gone
        finally:
            os.close(descriptor)


def state(path):
    """Whether a process holds the lock of a file: HELD, FREE, or UNKNOWN where there are no locks."""
    if fcntl is None:
        return UNKNOWN
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return UNKNOWN
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return HELD
    except OSError:
        return UNKNOWN
    else:
        return FREE
    finally:
        os.close(descriptor)


def _take(place, waiting):
    """Descriptor of the lock file; None where there are no locks."""
    while True:
        try:
            descriptor = os.open(place, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError:
            return None  # whatever forbids it forbids the file itself, and says so there
        try:
            if waiting is not None:
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    waiting()
                    waiting = None
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            if _same(place, descriptor):
                return descriptor
        except OSError:
            os.close(descriptor)
            return None
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _same(place, descriptor):
    """True when the lock file under this name is the one that is open."""
    with suppress(FileNotFoundError):
        return os.path.samestat(os.stat(place), os.fstat(descriptor))
    return False
