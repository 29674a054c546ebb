"""Arrays that took long to make, kept on disk under a digest of what they were made from.

Nothing here ever fails: what cannot be read is made anew, what cannot be written is not kept.
"""

from __future__ import annotations

import json
import os
import re
import tempfile
import time
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from hognose.cache_folder import cache_folder

#: Version of what is kept: anything that changes what is made from the same input counts it up.
LAYOUT = 4
#: The longest unused are thrown away when all together are larger than this (bytes).
LARGEST_CACHE = 2_000_000_000
_MAGIC = b"hognose cache\n"
_SUFFIX = ".hognose"
# What a run that was killed has left half written: as `remember` names it, and older than this (s).
_ASIDE = re.compile(r"\.[A-Za-z0-9]{1,16}\.[a-z0-9_]{8}")
_LEFT_BEHIND = 24 * 3600.0
_BUFFER = 1 << 20


def recall(key: str) -> dict[str, NDArray] | None:
    """Return the arrays kept under a key, or None if there are none or they are damaged.

    Parameters
    ----------
    key
        Letters and digits.
    """
    place = cache_folder()
    if place is None:
        return None
    with suppress(OSError, ValueError, KeyError, TypeError, MemoryError):
        file = place / (key + _SUFFIX)
        with file.open("rb", buffering=0) as stream:
            arrays = _read(stream, file.stat().st_size)
        os.utime(file)
        return arrays
    return None


def remember(key: str, arrays: Mapping[str, NDArray]) -> None:
    """Keep arrays under a key, whole or not at all."""
    place = cache_folder()
    if place is None:
        return
    with suppress(OSError, ValueError):
        place.mkdir(parents=True, exist_ok=True)
        descriptor, aside = tempfile.mkstemp(prefix=f".{key[:16]}.", dir=place)
        try:
            with os.fdopen(descriptor, "wb", buffering=_BUFFER) as stream:
                _write(stream, arrays)
            os.replace(aside, place / (key + _SUFFIX))
        finally:
            with suppress(OSError):
                os.unlink(aside)
        _make_room(place)


def _write(stream: IO[bytes], arrays: Mapping[str, NDArray]) -> None:
    whole = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    held = [[name, array.dtype.str, list(array.shape)] for name, array in whole.items()]
    check = zlib.crc32(json.dumps(held).encode())
    for array in whole.values():
        check = zlib.crc32(_bytes(array), check)
    head = json.dumps({"layout": LAYOUT, "arrays": held, "crc": check}).encode() + b"\n"
    stream.write(_MAGIC + len(head).to_bytes(8, "little") + head)
    for array in whole.values():
        stream.write(_bytes(array))


def _read(stream: IO[bytes], size: int) -> dict[str, NDArray] | None:
    if stream.read(len(_MAGIC)) != _MAGIC:
        return None
    length = int.from_bytes(stream.read(8), "little")
    if length > size:
        return None
    head = json.loads(stream.read(length))
    kinds = [(name, np.dtype(kind), tuple(shape)) for name, kind, shape in head["arrays"]]
    needed = sum(kind.itemsize * int(np.prod(shape)) for _, kind, shape in kinds)
    if head["layout"] != LAYOUT or size != len(_MAGIC) + 8 + length + needed:
        return None
    arrays, check = {}, zlib.crc32(json.dumps(head["arrays"]).encode())
    for name, kind, shape in kinds:
        array = np.fromfile(stream, kind, int(np.prod(shape))).reshape(shape)
        check = zlib.crc32(_bytes(array), check)
        arrays[name] = array
    return arrays if check == head["crc"] else None


def _bytes(array: NDArray) -> memoryview:
    return array.reshape(-1).view(np.uint8).data


def _make_room(place: Path) -> None:
    """Throw away what killed runs have left, and the longest unused files until the rest fit."""
    now = time.time()
    for entry in os.scandir(place):
        if _ASIDE.fullmatch(entry.name) and now - entry.stat(follow_symlinks=False).st_mtime > _LEFT_BEHIND:
            with suppress(OSError):
                os.unlink(entry.path)
    files = [(entry.stat().st_mtime, entry.stat().st_size, entry.path) for entry in os.scandir(place)
             if entry.name.endswith(_SUFFIX)]  # fmt: skip
    total = sum(size for _, size, _ in files)
    for _, size, path in sorted(files):
        if total <= LARGEST_CACHE:
            return
        with suppress(OSError):
            os.unlink(path)
            total -= size
