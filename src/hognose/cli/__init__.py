"""The command line: one thin file a command.

Exit codes: 0 the plan is good, 1 no good motion exists or was found, 2 the input is wrong, 130 interrupted.
"""

from __future__ import annotations

import gc
import io
import json
import logging
import os
import sys

from cyclopts import App, CycloptsError

from hognose import __version__
from hognose.cli.bench import bench
from hognose.cli.check import check
from hognose.cli.demo import demo
from hognose.cli.export import export
from hognose.cli.methods import methods
from hognose.cli.plan import plan
from hognose.cli.report import report
from hognose.cli.robot import robot
from hognose.cli.scene import scene
from hognose.cli.view import view
from hognose.errors import HognoseError, InfeasibleError

GOOD, NOT_FEASIBLE, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130

app = App(
    name="hognose",
    help="Plan, verify, show and export the motion of snake-arm robots through confined spaces.",
    version=__version__,
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)
for command in (plan, check, view, export, report, robot, scene, methods, bench, demo):
    app.command(command)


def entry_point() -> None:
    """The `hognose` command: `main`, without the interpreter's way down.

    Collecting garbage of imports and taking the compiler's library down would be a quarter of a short command's
    time. All files are on disk by then, and the output is flushed.
    """
    gc.set_threshold(100_000, 50, 50)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that knows no ≥ shows a question mark
    _show_log()
    code = _run(sys.argv[1:])
    sys.stderr.flush()
    os._exit(code)


def _show_log() -> None:
    """Show what the package logs, such as why the first plan takes so long, as lines on the standard error."""
    handler = logging.StreamHandler()
    handler.setFormatter(logging.Formatter("hognose: %(message)s"))
    log = logging.getLogger("hognose")
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    log.propagate = False


def main(arguments: list[str] | None = None) -> None:
    """Run one command and exit with its code; errors are one message without a traceback."""
    tokens = sys.argv[1:] if arguments is None else arguments
    sys.exit(_run(tokens))


def _run(tokens: list[str]) -> int:
    try:
        code = app(tokens, exit_on_error=False, print_error=False)
        sys.stdout.flush()
        return code if isinstance(code, int) else GOOD
    except CycloptsError as error:
        return _complain(tokens, f"{error}\nTry: hognose --help", WRONG_INPUT)
    except InfeasibleError as error:
        return _complain(tokens, str(error), NOT_FEASIBLE)
    except HognoseError as error:
        return _complain(tokens, str(error), WRONG_INPUT)
    except KeyboardInterrupt as error:
        return _complain(tokens, str(error) or "interrupted; files written so far are whole", INTERRUPTED)
    except BrokenPipeError:
        _drop_output()
        return GOOD
    except OSError as error:
        if error.filename is None:
            _drop_output()
        return _complain(tokens, f"{error.filename or 'output'}: {error.strerror or error}", WRONG_INPUT)


def _complain(tokens: list[str], message: str, code: int) -> int:
    if "--json" in tokens:
        try:
            sys.stdout.write(json.dumps({"good": False, "exit_code": code, "error": message}) + "\n")
            sys.stdout.flush()
            return code
        except BrokenPipeError:
            _drop_output()
            return code
        except OSError:
            _drop_output()
    sys.stderr.write(f"hognose: {message}\n")
    return code


def _drop_output() -> None:
    """Let what is left of the output go nowhere: whoever read it has left, or it has no room."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
