"""An HDF5 file that grows during a run and stays readable when the disk fills up.

The HDF5 library cannot cope with a write that fails: it can no longer close its file and takes the process down at its
end (seen with h5py 3.16). So it writes through an object of ours into space that the file system has granted before.
"""

import hashlib
import os
from contextlib import contextmanager, suppress
from functools import partial

from railcli.interruption import uninterrupted

from . import seal
from .output import whole_file

ZEROS = bytes(1 << 20)
CHUNK_CACHE = 1 << 16  # of each dataset [bytes]; whole chunks are written once, and HDF5 2.0 would keep 8 MB of them
RESERVE = 1 << 20  # room kept for what HDF5 writes about its data [bytes]


class Granted:
    """Binary file for h5py whose writes cannot fail as long as they stay within the space that `grant` got.

    Parameters
    ----------
    path : path-like
        An existing file, which is overwritten.
    """

    def __init__(self, path):
        self._file = open(path, "r+b", buffering=0)
        self._end = 0  # of what HDF5 wrote
        self._place = 0
        self.failure = None

    def grant(self, count):
        """Get room for `count` more bytes now, or raise the system's OSError."""
        start = self._file.seek(0, os.SEEK_END)
        while start < self._end + count:
            start += self._file.write(ZEROS[: self._end + count - start])

    def close(self, head=None):
        """Give back the room that was not used, and close; raises what failed unnoticed.

        head : callable, optional
            Gives the head for the SHA-256 and the size of what HDF5 wrote behind it.
        """
        try:
            self._file.truncate(self._end)
            if head is not None:
                self._file.seek(seal.HEAD_SIZE)
                digest = hashlib.sha256()
                while part := self._file.read(len(ZEROS)):
                    digest.update(part)
                self._file.seek(0)
                self._file.write(head(digest.hexdigest(), self._end - seal.HEAD_SIZE))
        finally:
            self._file.close()
        if self.failure is not None:
            raise self.failure

    # What h5py asks for

    def seek(self, offset, whence=os.SEEK_SET):
        self._place = offset + (0, self._place, self._end)[whence]
        return self._place

    def tell(self):
        return self._place

    def read(self, size=-1):
        self._file.seek(self._place)
        data = self._file.read(size)
        self._place += len(data)
        return data

    def readinto(self, buffer):
        self._file.seek(self._place)
        count = self._file.readinto(buffer)
        self._place += count
        return count

    def write(self, data):
        view = memoryview(data).cast("B")
        done = 0
        try:
            self._file.seek(self._place)
            while done < len(view):
                done += self._file.write(view[done:])
        except OSError as failure:
            self.failure = self.failure or failure
        self._place += len(view)
        self._end = max(self._end, self._place)
        return len(view)

    def truncate(self, size=None):
        self._end = self._place if size is None else size
        return self._end

    def flush(self):
        pass


class GrowingHdf5:
    """A new HDF5 file that appears under its name when it is closed, sealed (see `seal`).

    Parameters
    ----------
    path : path-like
    title : str
        First line of its head.

    Attributes
    ----------
    file : h5py.File
    """

    def __init__(self, path, title):
        import h5py

        self._whole, self._title = whole_file(path), title
        self._granted = Granted(self._whole.__enter__())
        with self._refusals():
            self._granted.grant(RESERVE)
            self.file = h5py.File(self._granted, "w", rdcc_nbytes=CHUNK_CACHE, userblock_size=seal.HEAD_SIZE)

    @contextmanager
    def growing(self, count):
        """Get room for `count` bytes, and hold Ctrl-C back while the block writes them.

        Raises
        ------
        OSError
            There is no room: nothing was written, and the file is as it was.
        """
        with uninterrupted():
            self._granted.grant(count + RESERVE)
            yield
            self.file.flush()

    def close(self):
        """Close the file and give it its name."""
        with uninterrupted(), self._refusals():
            self.file.close()
            self._granted.close(partial(seal.head_of, self._title))
            self._whole.__exit__(None, None, None)

    def drop(self):
        """Close the file and delete it."""
        with uninterrupted():
            self.file.close()
            with suppress(OSError):
                self._granted.close()
            self._whole.__exit__(_Dropped, _Dropped(), None)

    @contextmanager
    def _refusals(self):
        """Leave no file behind when the system refuses to write it."""
        try:
            yield
        except OSError as error:
            self._whole.__exit__(type(error), error, error.__traceback__)
            raise


class _Dropped(Exception):
    pass
