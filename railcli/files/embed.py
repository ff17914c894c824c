"""Files inside other files: a picture or film as the text of a data URI."""

import base64
from pathlib import Path

TYPES = {".png": "image/png", ".svg": "image/svg+xml", ".gif": "image/gif", ".mp4": "video/mp4"}


def data_uri(path):
    """Content of a picture or film for the `src` of a page that needs no other file."""
    path = Path(path)
    return f"data:{TYPES[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode()}"
