"""The bytes that a glTF file refers to: in the GLB container, in the JSON itself, or in files beside it.

Source: "glTF 2.0 Specification", sections 3.6.1 (buffers) and 4 (GLB).
"""

from __future__ import annotations

import base64
import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from hognose.errors import InputError
from hognose.read_whole import read_whole
from hognose.scene.imports.content import LARGEST_PART
from hognose.scene.imports.gltf_document import Buffer

_JSON, _BIN = b"JSON", b"BIN\0"


@dataclass(frozen=True)
class Container:
    """The parts of a file: its JSON, whether it is GLB, the buffer in that, how many chunks are of no known kind."""

    text: bytes
    is_glb: bool
    binary: memoryview | None = None
    unknown_chunks: int = 0


def opened(data: bytes) -> Container:
    """Return the parts of a GLB file, or of one that is JSON alone.

    Raises
    ------
    InputError
        It is cut, goes on after its end, or is not version 2.
    """
    if data[:4] != b"glTF":
        return Container(data.removeprefix(b"\xef\xbb\xbf"), is_glb=False)
    if len(data) < 20:
        raise InputError(f"cut: it ends after {len(data)} bytes, within its header")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(f"is a GLB file of version {version}, expected 2; export it again as glTF 2.0")
    if length > len(data):
        raise InputError(f"cut: it says it is {length:,} bytes long, but it is {len(data):,}")
    if length < len(data):
        raise InputError(f"damaged: it says it ends after {length:,} bytes, but goes on to {len(data):,}")
    chunks = _chunks(memoryview(data))
    if chunks[0][0] != _JSON:
        raise InputError("damaged: its first chunk is not JSON")
    binary = chunks[1][1] if len(chunks) > 1 and chunks[1][0] == _BIN else None
    rest = chunks[1:] if binary is None else chunks[2:]
    if any(kind in (_JSON, _BIN) for kind, _ in rest):
        raise InputError("damaged: it has more than one chunk of JSON or of numbers")
    return Container(bytes(chunks[0][1]), True, binary, len(rest))


def _chunks(data: memoryview) -> list[tuple[bytes, memoryview]]:
    found: list[tuple[bytes, memoryview]] = []
    at = 12
    while at < len(data):
        if at + 8 > len(data):
            raise InputError("damaged: it ends within the header of a chunk")
        length, kind = struct.unpack_from("<I4s", data, at)
        at += 8
        if at + length > len(data):
            raise InputError(
                f"cut: chunk {len(found) + 1} says it is {length:,} bytes long, but {len(data) - at:,} are left"
            )
        found.append((kind, data[at : at + length]))
        at += length
    return found


@dataclass(frozen=True)
class Buffers:
    """The buffers of a file, each fetched when it is first used.

    Attributes
    ----------
    said
        What the JSON says of each.
    container
        The parts of the file.
    folder
        Where the files beside it are.
    """

    said: list[Buffer]
    container: Container
    folder: Path
    _fetched: dict[int, memoryview] = field(default_factory=dict)

    def whole(self, number: int) -> memoryview:
        """Return all bytes of a buffer."""
        if number not in self._fetched:
            if number >= len(self.said):
                raise InputError(f"damaged: it refers to buffer {number}, but has {len(self.said)}")
            data, length = self._fetch(number), self.said[number].byte_length
            if len(data) < length:
                raise InputError(f"cut: buffer {number} should have {length:,} bytes, but has {len(data):,}")
            self._fetched[number] = data[:length]
        return self._fetched[number]

    def _fetch(self, number: int) -> memoryview:
        uri = self.said[number].uri
        if uri is None:
            if number or self.container.binary is None:
                raise InputError(f"damaged: it does not say where the bytes of buffer {number} are")
            return self.container.binary
        if uri.startswith("data:"):
            return _decoded(uri, number)
        if self.container.is_glb:
            # What is read of a GLB file may be remembered by its own bytes alone.
            raise InputError(f"refers to the file {uri[:80]!r}, which is read of .gltf files only; export it whole")
        return _beside(self.folder, uri)


def _decoded(uri: str, number: int) -> memoryview:
    head, comma, text = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise InputError(f"damaged: the bytes of buffer {number} are in its text, but not as base64")
    try:
        return memoryview(base64.b64decode(text, validate=True))
    except ValueError:
        raise InputError(f"cut or damaged: the text of buffer {number} is not base64") from None


def _beside(folder: Path, uri: str) -> memoryview:
    name = unquote(uri)
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:", name):
        raise InputError(f"refers to {uri[:80]!r}, which is not a file beside it; export it as GLB, in one file")
    try:
        home = folder.resolve()
        path = (home / name).resolve()
        if not path.is_relative_to(home) or "\\" in name:
            raise InputError(f"refers to {name[:80]!r}, which is outside its folder; put both into one folder")
        if not path.is_file():
            raise InputError(f"refers to the file {name[:80]!r}, which is not there; bring both, or export it as GLB")
        return memoryview(read_whole(path, LARGEST_PART, f"the file {name[:80]!r} that it refers to"))
    except InputError:
        raise
    except (OSError, ValueError) as error:
        said = getattr(error, "strerror", None) or error
        raise InputError(f"refers to the file {name[:80]!r}, which cannot be read: {said}") from None
