"""Folders of the user that railcli keeps things in."""

import os
import sys
from pathlib import Path


def cache_root():
    """Folder of the user's caches: RAILCLI_CACHE_DIR, else what the platform uses."""
    if given := os.environ.get("RAILCLI_CACHE_DIR"):
        return Path(given)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData/Local") / "railcli"
    if sys.platform == "darwin":
        return Path.home() / "Library/Caches/railcli"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "railcli"
