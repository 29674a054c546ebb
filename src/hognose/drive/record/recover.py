"""Making a whole file again of a record that was cut off."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from hognose.drive.record.container import Container, read_container
from hognose.drive.record.reader import record_of
from hognose.write_whole import write_whole


def recover(file: Path | str, to: Path | str) -> int:
    """Write all whole messages of a record into a closed MCAP file, which every reader takes; returns how many.

    Raises
    ------
    InputError
        The record cannot be read, or the file cannot be written.
    MissingExtraError
        The package mcap is not installed.
    """
    held = read_container(Path(file))
    record_of(Path(file), held)  # what is no record is refused
    write_whole(to, _finished(held))
    return len(held.messages)


def _finished(held: Container) -> bytes:
    """The same schemas, channels, messages, metadata and attachments, with the index that is at the end of a file."""
    from mcap.writer import CompressionType, Writer

    stream = BytesIO()
    writer = Writer(stream, compression=CompressionType.NONE)
    writer.start("ros2", "hognose")
    schemas = {
        number: writer.register_schema(each.name, each.encoding, each.data) for number, each in held.schemas.items()
    }
    channels = {
        number: writer.register_channel(each.topic, each.message_encoding, schemas[each.schema_id], each.metadata)
        for number, each in held.channels.items()
    }
    for each in held.metadata:
        writer.add_metadata(each.name, each.metadata)
    for each in held.attachments:
        writer.add_attachment(each.create_time, each.log_time, each.name, each.media_type, each.data)
    for each in held.messages:
        writer.add_message(channels[each.channel_id], each.log_time, each.data, each.publish_time, each.sequence)
    writer.finish()
    return stream.getvalue()
