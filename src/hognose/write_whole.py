"""Files are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from hognose.errors import InputError

# Of a file that is not complete yet; one older than this (s) was left by a run that was killed.
_SUFFIX = ".hognose-part"
_LEFT_BEHIND = 24 * 3600.0


def write_whole(path: Path | str, data: bytes, private: bool = False) -> None:
    """Write `data` to `path` so that a reader sees the old file or the new one, never a part.

    A `private` file can be read and written by its owner only, whatever the umask says.

    Raises
    ------
    InputError
        If the file cannot be written; says why. Whatever stood there before is untouched.
    """
    path = Path(path)
    try:
        path = Path(os.path.realpath(path))  # a link stays a link
        if path.exists() and not path.is_file():
            raise InputError(f"{path}: is not a regular file; nothing was written. Name another one.")
        prefix = f".{path.name[:40]}."
        _sweep(path.parent, prefix)
        descriptor, aside = tempfile.mkstemp(_SUFFIX, prefix, path.parent)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(_complaint(path, error)) from None
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(aside, 0o600 if private else 0o666 & ~_umask())
        os.replace(aside, path)
    except OSError as error:
        raise InputError(_complaint(path, error)) from None
    finally:
        with suppress(OSError):
            os.unlink(aside)


def write_together(path: Path | str, data: bytes, beside: Mapping[str, bytes]) -> None:
    """Write `data` to `path` and files that it names beside it, by their paths from its folder, before it.

    A reader of the file at `path` sees the old one or the new one, and beside either what it names, if the names of
    files beside it go with their content. One that is there with this content is left as it is.

    Raises
    ------
    InputError
        If a file cannot be written. What stood at `path` before is untouched, and what is new beside it is removed.
    """
    path, new = Path(path), []
    try:
        for name, content in beside.items():
            file = path.parent / name
            if not file.parent.is_dir():
                _make_folder(file.parent)
                new.append(file.parent)
            if not (file.is_file() and _content(file) == content):
                known = os.path.lexists(file)
                write_whole(file, content)
                if not known:
                    new.append(file)
        write_whole(path, data)
    except InputError:
        for made in reversed(new):
            with suppress(OSError):
                made.rmdir() if made.is_dir() else made.unlink()
        raise


def _make_folder(folder: Path) -> None:
    """A folder in one that is there."""
    try:
        folder.mkdir()
    except OSError as error:
        raise InputError(_complaint(folder, error)) from None


def _content(file: Path) -> bytes | None:
    """What is in a file; None if it cannot be read."""
    try:
        return file.read_bytes()
    except OSError:
        return None


def _sweep(folder: Path, prefix: str) -> None:
    """Remove what runs that were killed while they wrote the same file have left beside it."""
    with suppress(OSError):
        for entry in os.scandir(folder):
            if entry.name.startswith(prefix) and entry.name.endswith(_SUFFIX):
                with suppress(OSError):
                    if time.time() - entry.stat(follow_symlinks=False).st_mtime > _LEFT_BEHIND:
                        os.unlink(entry.path)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _complaint(path: Path, error: OSError | ValueError) -> str:
    return f"{path}: cannot write: {getattr(error, 'strerror', None) or error}. Nothing was written."
