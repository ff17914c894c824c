"""Files of ours that must not have changed: HDF5 behind a head of 512 bytes with size and SHA-256 of all that follows.

HDF5 readers skip the head. One bit changed anywhere is found before a library reads the file.
"""

import hashlib

from railcli.errors import InputError

from .user_file import regular, unreadable

HEAD_SIZE = 512
MOST_PACKED = 1100  # times that deflate makes data smaller, at most; what a file declares beyond was never written
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
    size = regular(path, what, absent) - HEAD_SIZE
    try:
        with open(path, "rb") as file:
            found = file.read(HEAD_SIZE)
            lines = found.split(b"\n")
            if lines[0] != title.encode() or len(found) < HEAD_SIZE:
                raise InputError(path, f"is not {what} of railcli; {advice}")
            words = lines[2].split()
            declared = int(words[1]) if len(words) == 2 and words[1].isdigit() else -1
            if size < declared:
                raise InputError(path, f"is truncated: {size} of {declared} bytes are left; {advice}")
            if size > declared:
                raise InputError(path, f"is damaged: it has {size} bytes, but its head says {declared}; {advice}")
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise unreadable(path, error) from error
    if found != head_of(title, digest, size):
        raise InputError(path, f"is damaged: its checksum does not fit its contents; {advice}")


def whole(dataset):
    """All values of a dataset; a ValueError if it declares more than its file can hold."""
    check_size(dataset)
    return dataset[()]


def check_size(dataset):
    """Raise a ValueError if a dataset declares more values than those that its file holds."""
    held = dataset.id.get_storage_size()
    if dataset.nbytes > MOST_PACKED * held:
        raise ValueError(f"{dataset.name} declares {dataset.nbytes} bytes, its file holds {held} of them")
