"""What a person types while the program goes on: lines are read by a thread of their own."""

from __future__ import annotations

import queue
import sys
import threading
from contextlib import suppress


def _forget_typed() -> None:
    """Throw away what was typed and not read yet, where the terminal keeps it."""
    try:
        import termios
    except ImportError:  # not POSIX
        return
    with suppress(termios.error, OSError, ValueError):  # no terminal
        termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)


def agreed(question: str) -> bool:
    """Whether "yes" is typed to a question; what was typed before it is no answer."""
    _forget_typed()
    try:
        return input(question).strip().lower() == "yes"
    except EOFError:
        return False


class TypedLines:
    """Asks at the terminal, and has the answers when they are there.

    Parameters
    ----------
    patience : s
        How long an answer is waited for each time; where time is simulated, it would fly while somebody thinks.
    """

    def __init__(self, patience: float = 0.0) -> None:
        self._patience = patience
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._reads, self._ended = False, False

    def ask(self, question: str) -> None:
        """Print a question; what was typed before it is no answer to it."""
        _forget_typed()
        while self.answer():  # what was read already
            continue
        sys.stderr.write(question)
        sys.stderr.flush()
        if not self._reads:
            self._reads = True
            threading.Thread(target=self._read, daemon=True).start()

    def answer(self) -> str | None:
        """What was typed since, in lower case; None as long as nothing was, and empty at the end of the input."""
        if self._ended:
            return ""
        try:
            line = self._lines.get(timeout=self._patience) if self._patience else self._lines.get_nowait()
        except queue.Empty:
            return None
        self._ended = line is None
        return "" if line is None else line.strip().lower() or "?"

    def _read(self) -> None:
        for line in sys.stdin:
            self._lines.put(line)
        self._lines.put(None)
