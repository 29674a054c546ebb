"""The serial line that a board is on, which never makes a cycle wait."""

from __future__ import annotations

import errno
import select
from typing import Any, Protocol

from hognose.errors import HognoseError, MissingExtraError

#: What is read at a time, bytes: more than a line of 4 Mbit/s carries in 10 ms.
_AT_ONCE = 4096
#: So much may wait to be written (bytes) before the line counts as stuck: messages of a second and more.
_MOST_WAITING = 4096


class LineError(HognoseError):
    """A line that is not there, or not any more; says what about it."""


class Line(Protocol):
    """Bytes both ways, without waiting."""

    def open(self) -> None:
        """Open it anew, without what came before; a `LineError` if it cannot be opened."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes; a `LineError` if the line does not take them."""
        ...

    def read(self) -> bytes:
        """The bytes that came since; a `LineError` if the line is gone."""
        ...

    def close(self) -> None:
        """Let it go; it can be opened again."""
        ...


class SerialLine:
    """A port of pyserial: /dev/ttyUSB0, COM3, socket://127.0.0.1:7782 and what else it knows."""

    def __init__(self, port: str, baud: int) -> None:
        """Nothing is opened yet.

        Raises
        ------
        MissingExtraError
            pyserial is not installed.
        """
        try:
            import serial
        except ImportError as error:
            said = "" if error.name == "serial" else f", which cannot be imported: {error}"
            raise MissingExtraError(
                f"a slider on a serial board needs the package pyserial{said}; install it with: "
                "pip install 'hognose[drive]'"
            ) from None
        self._serial: Any = serial
        self._port: Any = None
        self.port, self.baud = port, baud
        self._waiting = bytearray()

    def open(self) -> None:
        """See `Line.open`; nobody else can open it then, where the system knows how."""
        self.close()
        try:
            patience = None if self.port.startswith("loop://") else 0  # a loop takes nothing without
            self._port = self._serial.serial_for_url(
                self.port, baudrate=self.baud, timeout=0, write_timeout=patience, exclusive=True
            )
            self._port.reset_input_buffer()
        except Exception as error:  # every kind of port has errors of its own
            raise LineError(self._why(error)) from None

    def write(self, data: bytes) -> None:
        """See `Line.write`: what the system does not take at once waits for the next time."""
        self._waiting += data
        port = self._opened()
        try:
            taken = port.write(bytes(self._waiting)) if _has_room(port) else 0
        except self._serial.SerialTimeoutException:
            taken = 0
        except OSError as error:
            raise LineError(f"its line at {self.port} takes nothing any more: {error}; is it unplugged?") from None
        del self._waiting[: len(self._waiting) if taken is None else taken]
        if len(self._waiting) > _MOST_WAITING:
            raise LineError(f"its line at {self.port} is stuck: {len(self._waiting)} bytes wait to be sent")

    def read(self) -> bytes:
        """See `Line.read`."""
        try:
            return self._opened().read(_AT_ONCE)
        except OSError as error:
            raise LineError(f"its line at {self.port} is gone: {error}; is it unplugged?") from None

    def close(self) -> None:
        """See `Line.close`."""
        port, self._port = self._port, None
        self._waiting.clear()
        if port is not None:
            port.close()

    def _opened(self) -> Any:
        if self._port is None:
            raise LineError(f"its line at {self.port} is not open")
        return self._port

    def _why(self, error: Exception) -> str:
        """Why it cannot be opened, and what to try."""
        number, words = getattr(error, "errno", None), str(error)
        where = f"port {self.port!r}"
        if number in (errno.EBUSY, errno.EAGAIN) or "lock port" in words:
            return f"{where} is busy: another program has it open ({words}). Close that, a terminal or monitor perhaps"
        if number == errno.EACCES:
            return f"{where} may not be opened ({words}). On Linux: join the group `dialout`, and log in anew"
        if number == errno.ENOENT or "FileNotFoundError" in words:
            known = ", ".join(self._ports()) or "none"
            return f"there is no {where}. Is the board plugged in, and `slider.port` right? Ports: {known}"
        if self.port.startswith("socket://"):
            return f"{where} cannot be opened: {words}. Does anything listen there?"
        return f"{where} cannot be opened: {words}"

    def _ports(self) -> list[str]:
        """The serial ports of this machine."""
        try:
            from serial.tools.list_ports import comports

            return sorted(each.device for each in comports())
        except Exception:  # a list of ports is only a hint
            return []


def _has_room(port: Any) -> bool:
    """Whether a port takes a byte at once: where none fits, pyserial tries again and again without a pause."""
    try:
        number = port.fileno()
    except (AttributeError, OSError):  # not one that can be asked; those do not wait
        return True
    return bool(select.select([], [number], [], 0)[1])
