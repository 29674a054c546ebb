"""Running one command: every end it can come to is an exit code and at most one message."""

from __future__ import annotations

import errno
import gc
import io
import json
import logging
import os
import sys
import traceback
import warnings

from cyclopts import CycloptsError

from hognose.cli.application import LEAVE_MORE_THAN_OUTPUT, app
from hognose.cli.exit_codes import FAULT, GOOD, INTERRUPTED, INTERRUPTION, NOT_FEASIBLE, WRONG_INPUT
from hognose.cli.output import Output, kept, open_streams
from hognose.errors import HognoseError, InfeasibleError
from hognose.plain_text import plain

#: What is printed into fewer columns than this can no longer be read, or is not there at all.
NARROWEST = 20


def stand_alone() -> None:
    """Make the process one of its own: what libraries have to say to developers is not for its users."""
    gc.set_threshold(100_000, 50, 50)
    open_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that knows no ≥ shows a question mark
    os.environ["MPLBACKEND"] = "agg"  # nothing is drawn on a screen, and a backend that is not there is a traceback
    columns = os.environ.get("COLUMNS", "")
    if not columns.isdecimal() or int(columns) < NARROWEST:
        os.environ.pop("COLUMNS", None)
    warnings.resetwarnings()
    warnings.simplefilter("ignore")
    logging.getLogger().addHandler(logging.NullHandler())
    told = logging.StreamHandler()  # what Hognose itself could not do, and why the first plan takes so long
    told.setFormatter(logging.Formatter("hognose: %(message)s"))
    logging.getLogger("hognose").addHandler(told)
    logging.getLogger("hognose").setLevel(logging.INFO)


def run(tokens: list[str]) -> int:
    """Run a command; its exit code."""
    with kept() as output:
        code = _attempt(tokens, output)
        output.flush()
        if output.lost is None or isinstance(output.lost, BrokenPipeError):  # whoever read it has left
            return code
        closed = output.lost.errno == errno.EBADF
        sys.stderr.write(f"hognose: output: {'it is closed' if closed else output.lost.strerror}\n")
    return code if "--json" not in tokens and tokens[:1] and tokens[0] in LEAVE_MORE_THAN_OUTPUT else WRONG_INPUT


def _attempt(tokens: list[str], output: Output) -> int:
    try:
        code = app(tokens, exit_on_error=False, print_error=False)
        return code if isinstance(code, int) else GOOD
    except CycloptsError as error:
        from hognose.cli.wrong_use import told

        return _complain(tokens, output, told(error, tokens), WRONG_INPUT)
    except InfeasibleError as error:
        return _complain(tokens, output, str(error), NOT_FEASIBLE)
    except HognoseError as error:
        return _complain(tokens, output, str(error), WRONG_INPUT)
    except KeyboardInterrupt as error:
        return _complain(tokens, output, str(error) or INTERRUPTION, INTERRUPTED)
    except OSError as error:
        return _complain(tokens, output, f"{error.filename or 'system'}: {error.strerror or error}", WRONG_INPUT)
    except MemoryError:
        return _complain(tokens, output, "there is not enough memory for this", WRONG_INPUT)
    except Exception as error:
        from hognose.extensions import words_of

        fault = f"{words_of(error)}. This is a fault of Hognose, please report it"
        sys.stderr.write(plain(traceback.format_exc()))
        return _complain(tokens, output, fault, FAULT)


def _complain(tokens: list[str], output: Output, message: str, code: int) -> int:
    if "--json" in tokens:
        output.write(json.dumps({"good": False, "exit_code": code, "error": plain(message)}) + "\n")
        output.flush()
        if output.lost is None or isinstance(output.lost, BrokenPipeError):
            return code
    sys.stderr.write(f"hognose: {plain(message)}\n")
    return code
