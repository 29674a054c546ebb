"""The CAN bus as the executor needs it, on any interface of python-can."""

from __future__ import annotations

import errno
import socket
from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

from hognose.drive.frames import Frame
from hognose.drive.network_spec import EMULATED, BusSpec
from hognose.errors import HognoseError, InputError, MissingExtraError

#: No more frames are taken at a time: more than two buses carry in a cycle.
_MOST_AT_ONCE = 4000


#: Bytes that the kernel keeps of what was sent: above a quarter of it in use, python-can takes it for full.
_SEND_BUFFER = 1 << 20
#: Classes of error frames (linux/can/error.h): a frame was damaged, nobody acknowledged it, the controller is off.
_DAMAGED, _NO_ACKNOWLEDGEMENT, _BUS_OFF = 0x08, 0x20, 0x40


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


@runtime_checkable
class Ailing(Protocol):
    """A bus that knows what is wrong with itself."""

    @property
    def ailment(self) -> str:
        """What the bus reports to be wrong, in a sentence; empty if it reports nothing."""
        ...


def ailment_of(bus: Bus) -> str:
    """What a bus reports to be wrong, in a sentence; empty if it reports nothing, or cannot know."""
    return bus.ailment if isinstance(bus, Ailing) else ""


def ailment_words(errors: int, classes: int, bitrate: int) -> str:
    """What error frames say, in a sentence.

    Parameters
    ----------
    errors
        How many came.
    classes
        The bits of all of their identifiers, as SocketCAN has them (linux/can/error.h); 0 where nothing is known.
    bitrate
        Of the network file.
    """
    if not errors:
        return ""
    came = f"{errors:,} error frame{'s' if errors > 1 else ''} came from the bus"
    if classes & _NO_ACKNOWLEDGEMENT and not classes & _DAMAGED:
        return (
            f"{came}: nobody acknowledges what is sent. Is a drive on and plugged in, and has the bus a resistor at "
            "both ends?"
        )
    off = ", and the controller took itself off the bus" if classes & _BUS_OFF else ""
    return (
        f"{came}{off}: its bitrate is probably another than bus.bitrate, {bitrate:,} bit/s; or a resistor at an end, "
        "or a wire, is missing"
    )


class CanBus:
    """A bus of python-can.

    Attributes
    ----------
    errors
        How many error frames came.
    """

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
        self._spec, self.errors, self._classes = spec, 0, 0
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

            return TcpBus(spec.channel, bitrate=spec.bitrate)
        given = {"channel": spec.channel or None, "interface": spec.interface, "bitrate": spec.bitrate}
        bus = self._can.Bus(**given, receive_own_messages=False, **spec.options)
        if spec.interface == "socketcan":  # all frames of a cycle at once; Linux doubles it, up to net.core.wmem_max
            bus.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        return bus

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
            if _is_full(error):
                raise BusError(self._full(len(frames))) from None
            raise BusError(f"bus: frames are not taken any more: {error}; is it off, or unplugged?") from None

    def receive(self) -> list[Frame]:
        """See `Bus.receive`."""
        found: list[Frame] = []
        try:
            if hasattr(self._bus, "receive_frames"):
                found = self._bus.receive_frames()
                self.errors = self._bus.errors
                return found
            while len(found) < _MOST_AT_ONCE and (message := self._bus.recv(0.0)) is not None:
                if not message.is_rx and self._spec.interface != "socketcan":
                    continue  # our own: gs_usb gives it back. On SocketCAN it is of another program on this machine
                if message.is_error_frame:
                    self.errors += 1
                    self._classes |= message.arbitration_id
                elif not (message.is_extended_id or message.is_remote_frame):
                    found.append(Frame(message.arbitration_id, bytes(message.data)))
        except (self._can.CanError, OSError) as error:
            raise BusError(f"bus: nothing comes any more: {error}; is it off, or unplugged?") from None
        return found

    @property
    def ailment(self) -> str:
        """See `Ailing.ailment`."""
        return ailment_words(self.errors, self._classes, self._spec.bitrate)

    def _full(self, count: int) -> str:
        """What to do about a queue that takes no more frames."""
        channel = self._spec.channel or "can0"
        told = (
            f"bus: {channel}: its queue is full, of {count:,} frames that were to be sent at once. Linux queues 10 "
            f"unless told otherwise: `sudo ip link set {channel} txqueuelen 1000`"
        )
        ails = self.ailment or "If it is long enough already, nobody acknowledges what is sent: is a drive on?"
        return f"{told}. {ails}"

    def close(self) -> None:
        """See `Bus.close`."""
        self._bus.shutdown()


def _is_full(error: Exception) -> bool:
    """Whether python-can says that there is no room for frames: in the kernel's queue (ENOBUFS), or the socket's."""
    code = getattr(error, "error_code", None) or getattr(error, "errno", None)
    return code == errno.ENOBUFS or "buffer full" in str(error).lower()
