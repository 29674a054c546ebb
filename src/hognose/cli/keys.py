"""Keys that are pressed while a command goes on, each as it is pressed."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager

#: Keys at a time.
_AT_ONCE = 64


class NoKeys:
    """Nobody is at a keyboard.

    Attributes
    ----------
    sources
        What can be waited for with `select` until a key is pressed.
    works
        Whether there is a keyboard.
    """

    works = False

    def __init__(self) -> None:
        self.sources: list[int] = []

    def pressed(self) -> str:
        """The keys that were pressed since this was asked before; never waits."""
        return ""


class _Terminal(NoKeys):
    """The terminal of a POSIX system."""

    works = True

    def __init__(self, number: int) -> None:
        super().__init__()
        self.sources = [number]

    def pressed(self) -> str:
        if not self.sources or not select.select(self.sources, [], [], 0.0)[0]:
            return ""
        try:
            data = os.read(self.sources[0], _AT_ONCE)
        except OSError:
            data = b""
        if not data:  # the terminal is gone
            self.sources = []
        return data.decode(errors="replace")


class _Console(NoKeys):
    """The console of Windows, which cannot be waited for."""

    works = True

    def pressed(self) -> str:
        found = ""
        if sys.platform == "win32":
            import msvcrt

            while msvcrt.kbhit():
                found += msvcrt.getwch()
        return found


@contextmanager
def keys() -> Iterator[NoKeys]:
    """Keys are read as they are pressed, and not shown, until this ends in whatever way."""
    if not sys.stdin or not sys.stdin.isatty():
        yield NoKeys()
    elif sys.platform == "win32":
        yield _Console()
    else:
        import termios
        import tty

        number = sys.stdin.fileno()
        before = termios.tcgetattr(number)
        try:
            tty.setcbreak(number)  # Ctrl-C stays what it is
            yield _Terminal(number)
        finally:
            termios.tcsetattr(number, termios.TCSADRAIN, before)
