"""Files that a person names are read once, whole, and only if they are files."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from hognose.errors import InputError

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def read_whole(path: Path | str, largest: int, expected: str = "a file", too_large: str = "") -> bytes:
    """Return all bytes of a regular file; devices, pipes and sockets, which may never end, are not opened.

    Parameters
    ----------
    path
    largest
        Most bytes that are read.
    expected
        What the file should be, for messages.
    too_large
        What to do about a larger one, for the message.

    Raises
    ------
    InputError
        There is no such file, it is no regular file, too large, may not be read, or changed meanwhile.
    """
    path = Path(path)
    try:
        _refuse_others(path, os.stat(path), largest, expected, too_large)
        # Looked at again once it is open: it may be another one by now.
        with open(os.open(path, os.O_RDONLY | _FLAGS), "rb") as file:
            before = os.fstat(file.fileno())
            _refuse_others(path, before, largest, expected, too_large)
            # Files without a size, as below /proc, have content that may never end.
            data = file.read(before.st_size)
            after = os.fstat(file.fileno())
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: cannot read: {getattr(error, 'strerror', None) or error}") from None
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns) or len(data) < before.st_size:
        raise InputError(f"{path}: was written to while it was read; try again when it is complete")
    return data


#: A pipe that took the file's place must not be waited for; text must not be translated.
_FLAGS = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOCTTY", 0)


def _refuse_others(path: Path, found: os.stat_result, largest: int, expected: str, too_large: str) -> None:
    for is_one, kind in _KINDS:
        if is_one(found.st_mode):
            raise InputError(f"{path}: is {kind}, expected {expected}")
    if found.st_size > largest:
        hint = f"; {too_large}" if too_large else ""
        raise InputError(f"{path}: {found.st_size / 1e6:,.0f} MB is too large (at most {largest / 1e6:,.0f} MB){hint}")
