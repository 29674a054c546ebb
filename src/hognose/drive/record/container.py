"""The records that an MCAP file is made of, as far as they are whole."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hognose.errors import InputError, MissingExtraError
from hognose.read_whole import read_whole

if TYPE_CHECKING:
    from mcap.records import Attachment, Channel, McapRecord, Message, Metadata, Schema

MAGIC = b"\x89MCAP0\r\n"
#: The file of no run is larger (bytes).
LARGEST_FILE = 16_000_000_000
#: Opcodes of the records whose content is needed, with the names of their classes in the package mcap.
_KINDS = {3: "Schema", 4: "Channel", 5: "Message", 6: "Chunk", 9: "Attachment", 12: "Metadata", 15: "DataEnd"}
#: Opcodes that there are; a disk that lost power may hold zeros.
_KNOWN, _DATA_END, _FOOTER = range(1, 16), 15, 2


@dataclass
class Container:
    """What a file holds.

    Attributes
    ----------
    channels, schemas
        By their numbers.
    messages
        In the order of the file.
    attachments, metadata
        In the order of the file.
    size : bytes
        Of the file.
    whole : bytes
        From the beginning to the end of the last whole record.
    finished
        Whether it was closed: it has its end.
    altered
        Whether its messages are not those that were written, which only a finished file tells.
    """

    channels: dict[int, Channel] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    messages: list[Message] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    size: int = 0
    whole: int = 0
    finished: bool = False
    altered: bool = False

    @property
    def lost(self) -> int:
        """Bytes behind the last whole record, of a file without its end."""
        return 0 if self.finished else self.size - self.whole


def read_container(path: Path) -> Container:
    """All whole records of an MCAP file, wherever it is cut.

    Raises
    ------
    InputError
        There is no such file, or it is no MCAP.
    MissingExtraError
        The package mcap is not installed.
    """
    _require_mcap()
    from mcap.exceptions import McapError
    from mcap.records import DataEnd

    data = read_whole(path, LARGEST_FILE, "a record (.mcap)")
    if data[:8] != MAGIC:
        raise InputError(f"{path}: not a record of a run: it does not begin as an MCAP file does")
    found = Container(size=len(data), whole=len(MAGIC))
    for opcode, start, end in _frames(data):
        if opcode == _FOOTER:
            found.finished = data[end : end + len(MAGIC)] == MAGIC
            found.whole = end + len(MAGIC) * found.finished
            break
        try:
            for record in _records(opcode, data[start:end]):
                if isinstance(record, DataEnd):
                    found.altered = record.data_section_crc not in (0, zlib.crc32(data[: start - 9]))
                else:
                    _keep(found, record)
        except (McapError, ValueError, struct.error, KeyError):
            break  # a damaged record: what is behind it may be anything
        found.whole = end
    return found


def _frames(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, start and end of the content of each whole record."""
    at = len(MAGIC)
    while at + 9 <= len(data):
        opcode, length = data[at], int.from_bytes(data[at + 1 : at + 9], "little")
        if opcode not in _KNOWN or at + 9 + length > len(data):
            return
        yield opcode, at + 9, at + 9 + length
        at += 9 + length


def _records(opcode: int, content: bytes) -> list[McapRecord]:
    """What a record says, and for a chunk, as other programs write them, those in it."""
    from mcap import records
    from mcap.data_stream import ReadDataStream
    from mcap.stream_reader import breakup_chunk

    kind, stream = _KINDS.get(opcode), ReadDataStream(BytesIO(content))
    if kind is None:
        return []
    if kind == "Message":
        return [records.Message.read(stream, len(content))]
    if kind == "Chunk":
        return breakup_chunk(records.Chunk.read(stream), validate_crc=True)
    return [getattr(records, kind).read(stream)]


def _keep(found: Container, record: Any) -> None:
    kind = type(record).__name__
    if kind == "Message":
        found.channels[record.channel_id]  # a KeyError if nothing says what it is
        found.messages.append(record)
    elif kind in ("Schema", "Channel"):
        (found.schemas if kind == "Schema" else found.channels)[record.id] = record
    else:
        (found.attachments if kind == "Attachment" else found.metadata).append(record)


def _require_mcap() -> None:
    try:
        import mcap.stream_reader  # noqa: F401
    except ImportError as error:
        said = "" if error.name == "mcap" else f", which cannot be imported: {error}"
        raise MissingExtraError(
            f"records need the package mcap{said}; install it with: pip install 'hognose[drive]'"
        ) from None
