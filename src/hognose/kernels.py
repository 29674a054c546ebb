"""The one decorator of compiled functions.

numba keeps what it has compiled on disk and compiles anew when the file of a function changes. It does not notice a
change in a function of another file that was compiled into it. Therefore the folder that the machine code is kept in
is named after the sources of all kernels: whichever of them changes, nothing old is found.

The folder is in `NUMBA_CACHE_DIR` if that is set, or in the cache folder. Where it cannot be written, kernels are
compiled in every run, and a warning says so when that happens.
"""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import config, njit
from numba.core import event

import hognose.forks  # noqa: F401 -- a fork waits for what is compiled
from hognose.cache_folder import cache_folder

Function = TypeVar("Function", bound=Callable[..., Any])

#: What marks a file as one with kernels.
_MARK = b"@kernel"
#: Folders of other sources, unused for so long (s), are thrown away.
_FORGOTTEN = 30 * 86400.0

_ANOTHER = "let the environment variable HOGNOSE_CACHE name a folder that can be written"
#: numba's setting, which it makes from NUMBA_CACHE_DIR.
_SETTING = "CACHE_DIR"

_log = logging.getLogger("hognose")


def kernel(**options: Any) -> Callable[[Function], Function]:
    """Compile a function with numba, without Python's lock, and keep the machine code on disk.

    Parameters
    ----------
    **options
        Of `numba.njit`: `fastmath`, `error_model`, `inline`.
    """

    def compiled(function: Function) -> Function:
        folder = _kept()[0]
        # numba reads its setting when a function is decorated.
        before = getattr(config, _SETTING)
        setattr(config, _SETTING, folder or "")
        try:
            return cast("Function", njit(nogil=True, cache=folder is not None, **options)(function))
        except RuntimeError:  # the folder has gone since it was tried
            return cast("Function", njit(nogil=True, **options)(function))
        finally:
            setattr(config, _SETTING, before)

    return compiled


@cache
def sources_digest() -> str | None:
    """Hexadecimal digest of all files with kernels, or None where the sources are not files."""
    package = Path(__file__).parent
    found = hashlib.sha256()
    with suppress(OSError):
        for file in sorted(package.rglob("*.py")):
            text = file.read_bytes()
            if _MARK in text:
                found.update(file.relative_to(package).as_posix().encode() + b"\0" + text)
        return found.hexdigest()
    return None


@cache
def _kept() -> tuple[str | None, str]:
    """The folder that machine code is kept in, made and tried; or None, and why there is none."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(given) if given else cache_folder()
    digest = sources_digest()
    if base is None:
        off = os.environ.get("HOGNOSE_CACHE", "").lower() == "off"
        return None, "HOGNOSE_CACHE is off" if off else f"there is no home folder; {_ANOTHER}"
    if digest is None:
        return None, "the sources are not files"
    folder = base / "kernels" / digest[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            os.utime(folder)
    except OSError as error:
        return None, f"{folder} cannot be written ({error.strerror}); {_ANOTHER}"
    _throw_away_forgotten(folder)
    return str(folder), ""


def _throw_away_forgotten(folder: Path) -> None:
    with suppress(OSError):
        for other in folder.parent.iterdir():
            if other != folder and time.time() - other.stat().st_mtime > _FORGOTTEN:
                shutil.rmtree(other, ignore_errors=True)


class _Compilations(event.Listener):
    """Says once that something is compiled, and so why it takes long; and adds up how long it takes."""

    def __init__(self) -> None:
        self.has_been = False
        self.then: Callable[[], None] = lambda: None
        self._depth = 0  # a kernel is compiled while one that calls it is
        self._spent: tuple[float, float | None] = (0.0, None)  # s; and since when something is compiled

    @property
    def seconds(self) -> float:
        """That this process has spent on compiling, in whichever thread."""
        spent, since = self._spent
        return spent if since is None else spent + time.perf_counter() - since

    def on_start(self, event: event.Event) -> None:
        """Called by numba, one thread at a time, when it begins to compile a function that is not kept."""
        if self._depth == 0:
            self._spent = (self._spent[0], time.perf_counter())
        self._depth += 1
        if self.has_been:
            return
        self.has_been = True
        folder, why_not = _kept()
        if folder is None:
            _log.warning(f"compiling for this processor, in every run: what is compiled cannot be kept: {why_not}")
        else:
            _log.info("compiling for this processor, which takes some seconds; this is done once")
            self.then()

    def on_end(self, event: event.Event) -> None:
        """Called by numba when it has compiled a function, or has failed to."""
        self._depth -= 1
        if self._depth == 0:
            self._spent = (self.seconds, None)


_compilations = _Compilations()
event.register("numba:compile", _compilations)


def time_without_compiling() -> float:
    """Seconds on a clock that stands still while anything is compiled: what limits a time is not used up by that."""
    return time.perf_counter() - _compilations.seconds


def on_first_compilation(then: Callable[[], None]) -> None:
    """Let something be called when this process first compiles a kernel that will be kept."""
    _compilations.then = then
