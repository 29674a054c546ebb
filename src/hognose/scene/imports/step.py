"""Reading STEP: OpenCASCADE, in the package cascadio, makes triangles of its surfaces."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hognose.errors import InputError, MissingExtraError
from hognose.scene.imports import gltf
from hognose.scene.imports.content import Content, Source

#: Steps round bends of surfaces, rad, if the tolerance allows larger ones.
_LARGEST_TURN = 0.35


def read(source: Source) -> Content:
    """Return the bodies of a STEP file as triangles within the tolerance of its surfaces.

    Raises
    ------
    MissingExtraError
        Without the extra `step`.
    """
    try:
        import cascadio
    except ImportError:
        raise MissingExtraError(
            "STEP files need the package cascadio; install it with: pip install 'hognose[step]' "
            "(or export the model as 3MF, which needs nothing more)"
        ) from None
    with tempfile.TemporaryDirectory() as folder, _silent():
        made = Path(folder) / "made.glb"
        # In mm; a little less than asked, for the rounding to single precision.
        done = cascadio.step_to_glb(str(source.path), str(made), 0.9e3 * source.tolerance, _LARGEST_TURN)
        data = made.read_bytes() if made.is_file() else b""
    if done != 0 or not data:
        raise InputError("damaged, or not a STEP file that OpenCASCADE can read; export it again, as AP214 or AP242")
    return gltf.read(Source(made, data))


@contextmanager
def _silent() -> Iterator[None]:
    """Let OpenCASCADE, which writes what it finds wrong to the standard output by itself, write nowhere."""
    if sys.stdout is not None:
        sys.stdout.flush()
    try:
        saved, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    except OSError:  # there is no standard output
        yield
        return
    try:
        os.dup2(sink, 1)
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(sink)
