"""Scans that other packages read, each in a process of its own: some damaged files crash it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from hognose.errors import InputError, MissingExtraError
from hognose.scene.imports import scan_child
from hognose.scene.imports.content import Content, Source

#: A package is given this long for a file, s.
LONGEST = 600.0


def read_by(package: str, extra: str, source: Source, metres: float | None = None) -> Content:
    """Return the points of a LAS, LAZ or E57 file.

    Parameters
    ----------
    package
        What reads it: laspy or pye57.
    extra
        What installs the package: las or e57.
    source
        The file.
    metres
        Metres in its unit, if that is known.

    Raises
    ------
    MissingExtraError
        Without the extra.
    InputError
        It is cut or damaged, holds more than it says, or has no coordinates.
    """
    spec = find_spec(package)
    if spec is None or not spec.origin:
        raise MissingExtraError(
            f"{extra.upper()} files need the package {package}; install it with: pip install 'hognose[{extra}]' (or "
            "export the scan as PLY, PCD or XYZ, which need nothing more)"
        )
    if source.scan.columns:
        raise InputError(f"{extra.upper()} files say which of their columns are x, y and z; leave `columns` out")
    with tempfile.TemporaryDirectory() as folder:  # of the bytes that were read, whatever becomes of the file
        file = Path(folder) / "scan"
        file.write_bytes(source.data)
        answer = _run([extra, str(Path(spec.origin).parents[1]), str(file)], package)
    head, _, rest = answer.partition(b"\n")
    said = json.loads(head)
    points = np.frombuffer(rest, "<f8", 3 * said["points"]).reshape(-1, 3)
    return Content(points=points, metres=metres, notes=tuple(said["notes"]))


def _run(arguments: list[str], package: str) -> bytes:
    command = [sys.executable or "python3", "-P", scan_child.__file__, *arguments]
    hidden = getattr(subprocess, "CREATE_NO_WINDOW", 0)
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=LONGEST, creationflags=hidden
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"{package} was not done with it after {LONGEST:.0f} s; thin it out") from None
    except OSError as error:
        raise InputError(
            f"cannot start {command[0]!r}, in which {package} reads it: {error.strerror or error}"
        ) from None
    if done.returncode == scan_child.REFUSED:
        raise InputError(done.stderr.decode("utf-8", "replace").rpartition("\n")[2])
    if done.returncode:
        raise InputError(f"cut or damaged: {package} crashed on it; export it again, or as PLY, PCD or XYZ")
    return done.stdout
