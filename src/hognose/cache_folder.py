"""Where what took long to make is kept between runs.

In the user's cache folder, by the platform's convention; the environment variable `HOGNOSE_CACHE` names another one, or
is "off".
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path


def cache_folder() -> Path | None:
    """The folder of the cache, which need not be there yet; None if it is switched off or there is no home."""
    given = os.environ.get("HOGNOSE_CACHE", "")
    if given.lower() == "off":
        return None
    if given:
        return Path(given)
    with suppress(RuntimeError):  # no home
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "hognose" / "cache"
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "hognose"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hognose"
    return None
