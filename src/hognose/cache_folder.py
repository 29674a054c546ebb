"""Where Hognose keeps things between runs: what took long to make, and what must not be lost.

In the user's cache and state folders, by the platform's convention; the environment variable `HOGNOSE_CACHE` names
another one for both, or is "off".
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path


def cache_folder() -> Path | None:
    """The folder of the cache, which need not be there yet; None if it is switched off or there is no home."""
    return _folder("cache", "Caches", "XDG_CACHE_HOME", Path(".cache"))


def state_folder() -> Path | None:
    """The folder of what must not be lost, which need not be there yet; None as of `cache_folder`."""
    return _folder("", "Application Support", "XDG_STATE_HOME", Path(".local", "state"))


def _folder(on_windows: str, on_mac: str, variable: str, elsewhere: Path) -> Path | None:
    given = os.environ.get("HOGNOSE_CACHE", "")
    if given.lower() == "off":
        return None
    if given:
        return Path(given)
    with suppress(RuntimeError):  # no home
        if sys.platform == "win32":
            return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "hognose" / on_windows
        if sys.platform == "darwin":
            return Path.home() / "Library" / on_mac / "hognose"
        return Path(os.environ.get(variable) or Path.home() / elsewhere) / "hognose"
    return None
