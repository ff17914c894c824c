"""One process at a time: a lock beside a file, which the system lets go when its process ends, however it ends."""

import os
from contextlib import contextmanager, suppress

try:
    import fcntl
except ImportError:  # there is none on Windows, where no one waits and whole files keep the peace
    fcntl = None


@contextmanager
def alone(path, waiting=None):
    """Hold the lock of a file that is to be made; threads of one process exclude one another too.

    Where the system or its file system knows no such locks, nobody waits.

    Parameters
    ----------
    path : pathlib.Path
        Its folder exists. The lock is a file beside it, gone when no one holds it.
    waiting : callable, optional
        Called once when another one holds it.
    """
    held = None if fcntl is None else _take(path.with_name(f".{path.name}.lock"), waiting)
    try:
        yield
    finally:
        if held is not None:
            place, descriptor = held
            with suppress(OSError):
                place.unlink()  # while it is held: who waits for it sees that it is gone, and takes another
            os.close(descriptor)


def _take(place, waiting):
    """The lock file and its descriptor; None where there are no locks."""
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
                return place, descriptor
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
