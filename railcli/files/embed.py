"""Files inside other files: a picture or film as the text of a data URI."""

import base64
from pathlib import Path

TYPES = {".png": "image/png", ".svg": "image/svg+xml", ".gif": "image/gif", ".mp4": "video/mp4"}


def uri_of(content, ending):
    """Content of a picture or film for the `src` of a page that needs no other file.

    Parameters
    ----------
    content : bytes
    ending : str
        One of TYPES.
    """
    return f"data:{TYPES[ending]};base64,{base64.b64encode(content).decode()}"


def data_uri(path):
    """The same of a file."""
    path = Path(path)
    return uri_of(path.read_bytes(), path.suffix)
