"""The machine that results were measured on, without its name, and the code that was measured."""

from __future__ import annotations

import hashlib
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


def measured_version() -> str:
    """Hognose's version and a digest of everything that the figures rest on, so that no old figure passes for a new."""
    import hognose

    digest = hashlib.sha256()
    for room in ("evaluation", "following", "path", "robot"):
        for file in sorted((Path(hognose.__file__).parent / room).glob("*.py")):
            digest.update(file.read_bytes())
    return f"{hognose.__version__} (code {digest.hexdigest()[:8]})"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return ""
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, "")
