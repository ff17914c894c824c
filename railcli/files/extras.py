"""Optional libraries: imported where they are used, and named with their extra where they are missing."""

from importlib import import_module

from railcli.errors import InputError


def optional(library, extra, where):
    """Import a library that an extra brings.

    Parameters
    ----------
    library : str
        Name of the module.
    extra : str
        Of railcli, such as ``parquet``.
    where : str
        What asks for it, such as ``railcli report``.

    Raises
    ------
    InputError
        It is not installed; the line says how to get it.
    """
    try:
        return import_module(library)
    except ImportError:
        package = library.split(".")[0]
        message = f"needs {package}, which is not installed; `pip install 'railcli[{extra}]'` brings it"
        raise InputError(where, message) from None
