"""Files of ours that must not have changed: HDF5 behind a head of 512 bytes with size and SHA-256 of all that follows.

HDF5 readers skip the head. One bit changed anywhere is found before a library reads the file.
"""

import hashlib

from railcli.errors import InputError

HEAD_SIZE = 512
UNREADABLE = (  # what h5py, json and our own descriptions raise on a file that holds something else
    OSError, KeyError, TypeError, ValueError, AttributeError, RuntimeError, ArithmeticError, MemoryError,
)  # fmt: skip


def head(title, image):
    """The head of a file of this title whose HDF5 bytes are `image`."""
    return head_of(title, hashlib.sha256(image).hexdigest(), len(image))


def head_of(title, digest, size):
    """The head of a file of this title whose HDF5 bytes have this digest and size."""
    return f"{title}\nsha256 {digest}\nbytes {size}\n".encode().ljust(HEAD_SIZE, b"\n")


def check(path, title, what, advice, absent):
    """Raise an InputError unless a file is what was written, bit for bit.

    Parameters
    ----------
    path : pathlib.Path
    title : str
        First line of its head.
    what : str
        What it should be, with its article.
    advice : str
        What to do about a file that is not that.
    absent : str
        What to say of a file that is not there.
    """
    try:
        if path.is_dir():
            raise InputError(path, f"is a folder, not {what}")
        with open(path, "rb") as file:
            found = file.read(HEAD_SIZE)
            size = path.stat().st_size - HEAD_SIZE
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except FileNotFoundError:
        raise InputError(path, absent) from None
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror or error}") from error
    lines = found.split(b"\n")
    if lines[0] != title.encode() or len(found) < HEAD_SIZE:
        raise InputError(path, f"is not {what} of railcli; {advice}")
    words = lines[2].split()
    if len(words) == 2 and words[1].isdigit() and size < int(words[1]):
        raise InputError(path, f"is truncated: {size} of {int(words[1])} bytes are left; {advice}")
    if found != head_of(title, digest, size):
        raise InputError(path, f"is damaged: its checksum does not fit its contents; {advice}")
