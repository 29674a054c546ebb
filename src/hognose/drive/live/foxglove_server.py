"""A run shown live in Foxglove: the server of foxglove-sdk on this machine, which nobody can ask for anything."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from hognose.drive.record import RecordWriter
from hognose.errors import InputError

_LAST_PORT = 65535


@contextmanager
def shown_in_foxglove(writer: RecordWriter, port: int) -> Iterator[str]:
    """Serve what is recorded to Foxglove on 127.0.0.1; yields where, and who can read it, in sentences.

    Raises
    ------
    InputError
        The port cannot be listened on.
    """
    import foxglove  # there, as the record is written with it

    if not 1 <= port <= _LAST_PORT:
        raise InputError(f"foxglove: port {port}: expected a number from 1 to {_LAST_PORT}, such as 8765")
    try:
        # No capabilities: clients can publish nothing, call nothing and set nothing.
        server = foxglove.start_server(
            name="hognose", host="127.0.0.1", port=port, capabilities=[], context=writer.context
        )
    except RuntimeError as error:
        raise InputError(f"foxglove: port {port} cannot be listened on: {error}. Take another") from None
    try:
        yield (
            f"Foxglove shows this run from ws://127.0.0.1:{server.port}, read-only. That has no token: every program, "
            "and every page in a browser of this machine, can read along"
        )
    finally:
        server.stop()
