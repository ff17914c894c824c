"""The state of a simulation as a sealed file, to go on from in another process."""

from functools import partial
from pathlib import Path

from railcli.errors import InputError
from railcli.kernels import jit

from . import seal
from .output import whole_hdf5

TITLE = "railcli state of a simulation"
_AGAIN = "save the state again"


def save(path, arrays, digest):
    """Write the arrays of a state by their names; digest: of the scenario that they belong to."""
    with whole_hdf5(path, partial(seal.head, TITLE)) as file:
        file.attrs.update({"scenario": digest, "kernels": jit.source_digest()})
        for name, array in arrays.items():
            file[name] = array


def read(path, digest):
    """Arrays that `save` wrote, by name.

    Raises
    ------
    InputError
        The file is missing, damaged, or its state belongs to another scenario or version.
    """
    import h5py

    path = Path(path)
    seal.check(path, TITLE, "a state of a simulation", _AGAIN, "there is no such file")
    try:
        with h5py.File(path, "r", locking=False) as file:
            of_scenario, of_kernels = str(file.attrs["scenario"]), str(file.attrs["kernels"])
            arrays = {name: file[name][()] for name in file}
    except seal.UNREADABLE as error:
        raise InputError(path, f"does not hold a state ({' '.join(str(error).split())}); {_AGAIN}") from None
    if of_scenario != digest:
        raise InputError(path, "is a state of another scenario; restore it into a simulation of the one it belongs to")
    if of_kernels != jit.source_digest():
        raise InputError(path, f"was saved by another version of railcli, whose steps differ; {_AGAIN}")
    return arrays
