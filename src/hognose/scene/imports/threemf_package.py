"""The ZIP archive of a 3MF file and its parts, unpacked piece by piece within a bound.

Source: 3MF Consortium, "3MF Core Specification" 1.3, chapter 2 and appendix C; ECMA-376 part 2 (Open Packaging
Conventions): part names are the same whatever the case of their letters.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Iterator
from urllib.parse import unquote

from hognose.errors import InputError
from hognose.scene.imports.content import LARGEST_PART
from hognose.scene.imports.xml_stream import Stream

_DAMAGE = (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, RuntimeError, ValueError, OverflowError)
_PIECE = 1 << 20
_START = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_RELATIONSHIP = "http://schemas.openxmlformats.org/package/2006/relationships Relationship"
#: How an encrypted part begins (3MF Secure Content, section 3).
_ENCRYPTED = b"%3McF"


class Package:
    """A 3MF archive.

    Raises
    ------
    InputError
        It is no ZIP archive, is cut or damaged, or has a part twice.
    """

    def __init__(self, data: bytes) -> None:
        if data[:2] != b"PK":
            raise InputError("not a 3MF file: it is no ZIP archive")
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(data))
            entries = [info for info in self._archive.infolist() if not info.is_dir()]
        except _DAMAGE as error:
            raise InputError(f"cut or damaged: the archive cannot be opened: {error}") from None
        self._parts: dict[str, zipfile.ZipInfo] = {}
        self._left = LARGEST_PART
        for info in entries:
            if part_name(info.filename) in self._parts:
                raise InputError(f"damaged: the archive has the part {info.filename[:80]!r} twice")
            self._parts[part_name(info.filename)] = info

    def names(self) -> list[str]:
        """The names of all parts, as `part_name` makes them."""
        return list(self._parts)

    def start(self) -> str:
        """Return the name of the part that the archive says to begin with (core, section 2.1)."""
        found: list[str] = []

        def begin(name: str, attributes: dict[str, str]) -> None:
            if name == _RELATIONSHIP and attributes.get("Type") == _START:
                found.append(part_name(unquote(attributes.get("Target", ""))))

        if "/_rels/.rels" in self._parts:
            Stream(begin, lambda _: None).read(self.pieces("/_rels/.rels"))
        if not found:
            raise InputError("damaged, or not a 3MF file: it does not say which of its parts is the model")
        if len(set(found)) > 1:
            raise InputError(
                f"damaged: it names {len(found)} parts as its model: {', '.join(sorted(set(found)))[:200]}"
            )
        return found[0]

    def pieces(self, name: str) -> Iterator[bytes]:
        """Yield the bytes of a part, piece after piece.

        Raises
        ------
        InputError
            It is not there, encrypted, damaged, or all parts unpacked so far are longer than `LARGEST_PART` together.
        """
        info = self._parts.get(name)
        if info is None:
            raise InputError(f"damaged: it refers to the part {name[:80]!r}, which is not in the archive")
        if info.flag_bits & 0x1:
            raise InputError(f"is encrypted: the part {name!r} needs a password; export it without")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise InputError(f"damaged: the part {name!r} is not packed as 3MF files are (method {info.compress_type})")
        self._left -= info.file_size
        if self._left < 0:
            raise InputError(f"unpacks to more than {LARGEST_PART / 1e6:,.0f} MB; make it coarser")
        yield from self._unpacked(name, info)

    def _unpacked(self, name: str, info: zipfile.ZipInfo) -> Iterator[bytes]:
        # The archive never gives more than the length it says. Its check sum is compared at the end.
        length = 0
        try:
            with self._archive.open(info) as file:
                while piece := file.read(_PIECE):
                    if not length and piece.startswith(_ENCRYPTED):
                        raise InputError(f"is encrypted: the part {name!r} needs a key; export it without")
                    length += len(piece)
                    yield piece
        except InputError:
            raise
        except _DAMAGE as error:
            raise InputError(f"cut or damaged: the part {name!r} cannot be unpacked: {error}") from None
        if length != info.file_size:
            raise InputError(f"cut or damaged: the part {name!r} has {length:,} bytes, expected {info.file_size:,}")


def part_name(path: str) -> str:
    """Return the name of a part, from the root, in lower case, by which equal ones are found."""
    return "/" + path.strip().lstrip("/").lower()
