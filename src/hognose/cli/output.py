"""Output that does not break what a command does: the first failure is kept, and told at the end."""

from __future__ import annotations

import errno
import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TextIO


class Output(io.TextIOBase):
    """A stream that is written to until that fails.

    Attributes
    ----------
    lost
        Why nothing can be written any more, or None.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self.lost: OSError | None = None

    def write(self, text: str, /) -> int:
        """Write, if that is possible."""
        self._attempt(lambda stream: stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Hand on what is in the buffer, if that is possible."""
        self._attempt(lambda stream: stream.flush())

    def writable(self) -> bool:
        """Yes."""
        return True

    def isatty(self) -> bool:
        """Whether it is a terminal."""
        return self._stream is not None and not self._stream.closed and self._stream.isatty()

    def fileno(self) -> int:
        """The descriptor below it."""
        if self._stream is None:
            raise io.UnsupportedOperation("fileno")
        return self._stream.fileno()

    @property
    def encoding(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        """That of the stream."""
        return getattr(self._stream, "encoding", None) or "utf-8"

    def _attempt(self, act: Callable[[TextIO], object]) -> None:
        if self.lost is not None:
            return
        try:
            if self._stream is None or self._stream.closed:
                raise OSError(errno.EBADF, os.strerror(errno.EBADF))
            act(self._stream)
        except OSError as error:
            self.lost = error
            with suppress(OSError, ValueError):  # what is left in the buffer goes nowhere
                os.dup2(os.open(os.devnull, os.O_WRONLY), self.fileno())


@contextmanager
def kept() -> Iterator[Output]:
    """Standard output and standard error in such streams for a while; yields the first."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = output, complaints = Output(sys.stdout), Output(sys.stderr)
    try:
        yield output
    finally:
        output.flush()
        complaints.flush()
        sys.stdout, sys.stderr = before


def open_streams() -> None:
    """Give a process that was started with closed streams something in their place.

    Else the next file that is opened would take their number, and what is printed would end up in it. What is written
    to standard output fails, as it did before, and what is complained goes nowhere.
    """
    for number, mode in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, mode)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
    if sys.stdout is None:
        sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
    if sys.stderr is None:
        sys.stderr = os.fdopen(2, "w", encoding="utf-8", closefd=False)
