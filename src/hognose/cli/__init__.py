"""The command line: one thin file a command.

Exit codes: 0 the plan is good, 1 no good motion exists or was found, 2 the input is wrong or the output cannot be
written, 130 interrupted, 70 a fault of Hognose itself.

This file is what is loaded first, and imports next to nothing, so that Ctrl-C is in good hands from the start.
"""

from __future__ import annotations

import os
import sys

from hognose.cli.exit_codes import INTERRUPTED, INTERRUPTION

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType
    from typing import NoReturn


def entry_point() -> None:
    """The `hognose` command: `main`, without the interpreter's way down.

    Collecting garbage of imports and taking the compiler's library down would be a quarter of a short command's
    time. All files are on disk by then, and the output is flushed.
    """
    try:
        import gc
        import signal

        gc.set_threshold(50_000, 20, 20)  # what imports make is no garbage: looking through it often takes time
        signal.signal(signal.SIGINT, _interrupt)
        sys.unraisablehook = _unraisable
        from hognose.cli.running import run, stand_alone

        stand_alone()
        code = run(sys.argv[1:])
    except KeyboardInterrupt:  # where nothing of ours was at work
        _leave()
    os._exit(code)


def main(arguments: list[str] | None = None) -> None:
    """Run one command and exit with its code; errors are one message without a traceback."""
    from hognose.cli.running import run

    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def _interrupt(number: int, frame: FrameType | None) -> None:
    """What Ctrl-C does: an exception, but in an import, which libraries do not take well, the end at once."""
    del number
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            _leave()
        frame = frame.f_back
    raise KeyboardInterrupt


def _unraisable(lost: sys.UnraisableHookArgs) -> None:
    """An exception that Python cannot raise: an interrupt is obeyed, and others are nobody's business here."""
    if lost.exc_type is KeyboardInterrupt:
        _leave()


def _leave() -> NoReturn:
    """End at once, in one line; written past all buffers, which may be in use."""
    as_json = "--json" in sys.argv
    line = f'{{"good": false, "exit_code": {INTERRUPTED}, "error": "{INTERRUPTION}"}}' if as_json else ""
    try:
        cursor = "\r\033[K\033[?25h" if os.isatty(2) else ""  # a progress bar hides it
        os.write(1 if as_json else 2, f"{line or f'{cursor}hognose: {INTERRUPTION}'}\n".encode())
    except OSError:
        pass
    os._exit(INTERRUPTED)
