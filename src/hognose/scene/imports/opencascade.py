"""Run as a process of its own: a STEP file on the standard input becomes a GLB on the standard output.

OpenCASCADE may crash on a damaged file, or never end; here that ends nothing else. Only the standard library and
cascadio are imported. Arguments: the folder that cascadio is in, how far triangles may lie off surfaces (mm), the
largest turn between two of them (rad), the seconds after which the process ends itself.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress

#: Exit codes: cascadio cannot be imported, and OpenCASCADE made nothing of the file.
NO_CASCADIO, NOTHING_MADE = 3, 4


def main() -> int:
    """Convert; return the exit code."""
    folder, tolerance, turn, seconds = sys.argv[1], *map(float, sys.argv[2:])
    _bound(seconds)
    data = sys.stdin.buffer.read()
    answer = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # OpenCASCADE writes there what it finds wrong
    sys.path.append(folder)
    try:
        import cascadio
    except ImportError as error:
        print(error, file=sys.stderr)
        return NO_CASCADIO
    # Each face stays a primitive of its own, so that they can be counted.
    made = cascadio.load(data, file_type="step", tol_linear=tolerance, tol_angular=turn, merge_primitives=False)
    if not made:
        return NOTHING_MADE
    with os.fdopen(answer, "wb") as stream:
        stream.write(made)
    return 0


def _bound(seconds: float) -> None:
    """Let this process end itself, even if who started it has died, and take no more memory than there is."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, seconds)
    with suppress(OSError), open("/proc/self/oom_score_adj", "w") as score:
        score.write("1000")  # if memory runs out this process is to go, not another one
    with suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        hardest = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (there if hardest < 0 else min(there, hardest), hardest))


if __name__ == "__main__":
    sys.exit(main())
