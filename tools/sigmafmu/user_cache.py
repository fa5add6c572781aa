"""Where files are kept that can be made or fetched again."""

import os
import sys
from pathlib import Path

VARIABLE = "SIGMAFMU_CACHE"
"""Environment variable that names another folder."""


def user_cache() -> Path:
    """Folder of this package in the user's cache."""
    if os.environ.get(VARIABLE):
        return Path(os.environ[VARIABLE])
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "sigmafmu"
