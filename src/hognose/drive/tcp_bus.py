"""A CAN bus over TCP on this machine, as an interface of python-can named `hognose`; see `tcp_hub`."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Sequence
from typing import Any

import can

from hognose.drive.frames import Frame
from hognose.drive.tcp_hub import AT_ONCE, BITRATE, ERROR, packed, unpacked

#: A hub answers within this (s).
_PATIENCE = 5.0


class TcpBus(can.BusABC):
    """The interface; its channel is `host:port` of a hub.

    Attributes
    ----------
    errors
        How many error frames came.
    """

    def __init__(self, channel: Any = None, bitrate: int | None = None, **kwargs: Any) -> None:
        """Connect, and say the bitrate (bit/s) if it is given: a hub with another one gives error frames alone.

        Raises
        ------
        can.CanInitializationError
            There is no hub.
        """
        host, _, port = str(channel or "").rpartition(":")
        try:
            self._socket = socket.create_connection((host or "127.0.0.1", int(port)), timeout=_PATIENCE)
        except (OSError, ValueError) as error:
            raise can.CanInitializationError(f"no hub at {channel!r} ({error})") from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._rest, self._came, self.errors = b"", list[Frame](), 0
        self._bitrate, self._is_strange = bitrate, False
        if bitrate is not None:
            self.send_frames([Frame(BITRATE, bitrate.to_bytes(4, "little"))])
        self.channel_info = f"hognose {channel}"
        super().__init__(channel=channel, **kwargs)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame."""
        del timeout
        self.send_frames([Frame(msg.arbitration_id, bytes(msg.data))])

    def send_frames(self, frames: Sequence[Frame]) -> None:
        """Send frames in order, all at once."""
        try:
            self._socket.sendall(packed(frames))
        except OSError as error:
            raise can.CanOperationError(f"the hub is gone ({error})") from None

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._came:
            self._read(timeout)
        if not self._came:
            return None, False
        cob, data = self._came.pop(0)
        return can.Message(arbitration_id=cob, data=data, is_extended_id=False, timestamp=time.time()), False

    def receive_frames(self) -> list[Frame]:
        """All frames that came, without waiting."""
        self._read(0.0)
        found, self._came = self._came, []
        return found

    def _read(self, timeout: float | None) -> None:
        while select.select([self._socket], [], [], timeout)[0]:
            try:
                data = self._socket.recv(AT_ONCE)
            except ConnectionError:
                data = b""
            except OSError as error:
                raise can.CanOperationError(f"the hub is gone ({error})") from None
            if not data:
                raise can.CanOperationError("the hub is gone")
            frames, self._rest = unpacked(self._rest + data)
            self._sort(frames)
            timeout = 0.0

    def _sort(self, frames: Sequence[Frame]) -> None:
        """Take what is good; at another bitrate than the hub's, nothing is."""
        for frame in frames:
            if frame.cob == BITRATE:
                self._is_strange = self._bitrate not in (None, int.from_bytes(frame.data, "little"))
            elif frame.cob == ERROR or self._is_strange:
                self.errors += 1
            else:
                self._came.append(frame)

    def fileno(self) -> int:
        """Of the socket."""
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Leave the bus."""
        super().shutdown()
        self._socket.close()
