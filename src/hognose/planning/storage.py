"""Files are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from hognose.errors import InputError


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
        descriptor, aside = tempfile.mkstemp(prefix=f".{path.name[:40]}.", dir=path.parent)
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


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _complaint(path: Path, error: OSError | ValueError) -> str:
    return f"{path}: cannot write: {getattr(error, 'strerror', None) or error}. Nothing was written."
