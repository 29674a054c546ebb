"""The CAN bus as the executor needs it, on any interface of python-can."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from hognose.drive.frames import Frame
from hognose.drive.network_spec import EMULATED, BusSpec
from hognose.errors import HognoseError, InputError, MissingExtraError

#: No more frames are taken at a time: more than two buses carry in a cycle.
_MOST_AT_ONCE = 4000


class BusError(HognoseError):
    """The bus does not carry frames any more: it is off, unplugged, or full."""


class Bus(Protocol):
    """Sends frames in order, and gives those that came."""

    def send(self, frames: Sequence[Frame]) -> None:
        """Send frames in order; a `BusError` if the bus does not take them."""
        ...

    def receive(self) -> list[Frame]:
        """All frames that came since, without waiting; a `BusError` if the bus is off."""
        ...

    def close(self) -> None:
        """Leave the bus."""
        ...


class CanBus:
    """A bus of python-can."""

    def __init__(self, spec: BusSpec) -> None:
        """Open it.

        Raises
        ------
        InputError
            There is no such interface or channel.
        MissingExtraError
            python-can is not installed.
        """
        try:
            import can
        except ImportError as error:
            said = "" if error.name == "can" else f", which cannot be imported: {error}"
            raise MissingExtraError(
                f"drives need the package python-can{said}; install it with: pip install 'hognose[drive]'"
            ) from None
        self._can: Any = can
        try:
            self._bus: Any = self._opened(spec)
        except Exception as error:  # every interface has errors of its own
            known = ", ".join(sorted(can.VALID_INTERFACES))
            raise InputError(
                f"bus: interface {spec.interface!r}, channel {spec.channel!r}: cannot be opened: {error}. Is it there, "
                f"up, and free? Interfaces: {known}"
            ) from None

    def _opened(self, spec: BusSpec) -> Any:
        if spec.interface == EMULATED:  # our own, which needs no search through all installed packages
            from hognose.drive.tcp_bus import TcpBus

            return TcpBus(spec.channel)
        given = {"channel": spec.channel or None, "interface": spec.interface, "bitrate": spec.bitrate}
        return self._can.Bus(**given, receive_own_messages=False, **spec.options)

    def send(self, frames: Sequence[Frame]) -> None:
        """See `Bus.send`."""
        message = self._can.Message
        try:
            if hasattr(self._bus, "send_frames"):
                self._bus.send_frames(frames)
                return
            for cob, data in frames:
                self._bus.send(message(arbitration_id=cob, data=data, is_extended_id=False, check=False))
        except (self._can.CanError, OSError) as error:
            raise BusError(f"bus: frames are not taken any more: {error}; is it off, or unplugged?") from None

    def receive(self) -> list[Frame]:
        """See `Bus.receive`."""
        found: list[Frame] = []
        try:
            if hasattr(self._bus, "receive_frames"):
                return self._bus.receive_frames()
            while len(found) < _MOST_AT_ONCE and (message := self._bus.recv(0.0)) is not None:
                if not (message.is_error_frame or message.is_extended_id or message.is_remote_frame):
                    found.append(Frame(message.arbitration_id, bytes(message.data)))
        except (self._can.CanError, OSError) as error:
            raise BusError(f"bus: nothing comes any more: {error}; is it off, or unplugged?") from None
        return found

    def close(self) -> None:
        """See `Bus.close`."""
        self._bus.shutdown()
