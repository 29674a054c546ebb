"""The machine that results were measured on, without its name."""

from __future__ import annotations

import platform
from pathlib import Path


def machine() -> dict[str, str]:
    """Processor, Python and the compiler's version."""
    import numba

    return {
        "architecture": platform.machine(),
        "processor": _processor(),
        "python": platform.python_version(),
        "numba": numba.__version__,
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return ""
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, "")
