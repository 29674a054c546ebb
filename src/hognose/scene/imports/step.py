"""Reading STEP: OpenCASCADE, in the package cascadio, makes triangles of its surfaces, in a process of its own.

What the text of the file says it holds is held against what came out, so that no face is missing without a word.
"""

from __future__ import annotations

import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

from hognose.errors import InputError, MissingExtraError
from hognose.scene.imports import opencascade
from hognose.scene.imports.content import Content, Source, listed
from hognose.scene.imports.gaps import widest_gap
from hognose.scene.imports.step_glb import Made, read_made
from hognose.scene.imports.step_text import StepText, step_text
from hognose.wording import point

#: OpenCASCADE is given this long for a file, s.
LONGEST = 600.0
#: Steps round bends of surfaces, rad, if the tolerance allows larger ones.
_LARGEST_TURN = 0.35
_AGAIN = "export it again, as AP214 or AP242, or as 3MF"
_AS_TRIANGLES = "or export it as 3MF or STL, whose triangles the CAD system makes"


def read(source: Source) -> Content:
    """Return the bodies of a STEP file as triangles within the tolerance of its surfaces.

    Raises
    ------
    MissingExtraError
        Without the extra `step`.
    InputError
        It is damaged, OpenCASCADE crashed on it or was not done in time, or left something out.
    """
    said = step_text(source.data)
    if said.not_made:
        raise InputError(
            f"holds shapes that OpenCASCADE makes no surfaces of ({listed(said.not_made)}); export its solids by their "
            "boundaries (advanced BREP), as AP214 or AP242, or as 3MF"
        )
    if said.documents and not said.faces and not said.tessellated:
        raise InputError(
            f"holds no geometry itself, but refers to other files: {listed(said.documents)}. Name these as obstacles "
            "of their own, or export the assembly as one file"
        )
    made = read_made(_converted(source.data, source.tolerance))
    _refuse_missing(said, made, source.tolerance)
    return Content(made.bodies, metres=1.0, notes=tuple(_notes(said, made)))


def _converted(data: bytes, tolerance: float) -> bytes:
    """The GLB that OpenCASCADE makes, given the bytes that were read, so that they are what was hashed."""
    package = find_spec("cascadio")
    if package is None or not package.origin:
        raise MissingExtraError(
            "STEP files need the package cascadio; install it with: pip install 'hognose[step]' "
            "(or export the model as 3MF, which needs nothing more)"
        )
    folder = str(Path(package.origin).parents[1])
    # In mm; a little less than asked, for the rounding to single precision.
    numbers = (0.9e3 * tolerance, _LARGEST_TURN, LONGEST + 5.0)
    command = [sys.executable or "python3", "-P", opencascade.__file__, folder, *map(repr, numbers)]
    try:
        code, answer, complaint = _run(command, data)
    except subprocess.TimeoutExpired:
        raise InputError(
            f"OpenCASCADE was not done with it after {LONGEST:.0f} s; give a larger `tolerance`, leave out in CAD what "
            f"the arm does not come near, {_AS_TRIANGLES}"
        ) from None
    except OSError as error:
        raise InputError(
            f"cannot start {command[0]!r}, in which OpenCASCADE reads STEP files: {error.strerror or error}"
        ) from None
    if code == opencascade.NO_CASCADIO:
        said = complaint.decode("utf-8", "replace").strip()
        raise MissingExtraError(f"the package cascadio does not work: {said}; install it again: pip install cascadio")
    if code == opencascade.NOTHING_MADE:
        raise InputError(f"damaged, or not a STEP file that OpenCASCADE can read; {_AGAIN}")
    if code or answer[:4] != b"glTF":
        raise InputError(
            f"OpenCASCADE crashed on it ({_end(code)}): it is damaged, holds what OpenCASCADE cannot read, "
            f"or needs more memory than there is; {_AGAIN}"
        )
    return answer


def _run(command: list[str], data: bytes) -> tuple[int, bytes, bytes]:
    """The exit code of a command that is given data, and what it wrote; whatever ends this call ends it too."""
    hidden = getattr(subprocess, "CREATE_NO_WINDOW", 0)
    pipe = subprocess.PIPE
    # In a session of its own, so that Ctrl-C reaches only us.
    with subprocess.Popen(
        command, stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True, creationflags=hidden
    ) as process:
        try:
            answer, complaint = process.communicate(data, LONGEST)
        except BaseException:
            process.kill()
            process.wait()
            raise
    return process.returncode, answer, complaint


def _end(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit code {code}"


def _refuse_missing(said: StepText, made: Made, tolerance: float) -> None:
    """Refuse what OpenCASCADE made of a file if it lacks a face, as a whole or in part."""
    wanted = said.faces + said.tessellated
    if made.faces < wanted:
        raise InputError(
            f"OpenCASCADE made triangles of only {made.faces:,} of its {wanted:,} faces, so part of a surface "
            f"would be missing. Look for faulty faces in CAD and repair them; {_AS_TRIANGLES}"
        )
    if made.places < said.places:
        raise InputError(
            f"OpenCASCADE put only {made.places:,} of its {said.places:,} parts in their places, so some would be "
            f"missing. Look for parts without a place in CAD; {_AS_TRIANGLES}"
        )
    if not said.closed:
        return
    for body in made.bodies:
        gap = widest_gap(body.vertices, body.faces)
        if gap is not None and gap.width > 2 * tolerance:  # the thickening closes smaller ones
            raise InputError(
                f"the solid {body.name!r} is closed in the file, but OpenCASCADE left a gap of {1e3 * gap.width:.3g} "
                f"mm in it, at {point(gap.place)}. Look for a faulty face there in CAD and repair it; {_AS_TRIANGLES}"
            )


def _notes(said: StepText, made: Made) -> list[str]:
    """What it holds that is not taken."""
    told = []
    if said.documents:
        told.append(
            f"refers to other files, which are not read: {listed(said.documents)}; what of them is in the way must be "
            "an obstacle of its own"
        )
    if made.without:
        told.append(f"parts without any geometry in this file: {listed(made.without)}")
    if made.curves or made.points:
        both = ((made.curves, "curve"), (made.points, "point"))
        counted = [f"{count:,} {what}{'s' * (count > 1)}" for count, what in both if count]
        told.append(f"{' and '.join(counted)} of no face left out")
    if said.tessellated:
        told.append(
            f"{said.tessellated:,} of its faces are triangles in the file, which does not say how far they lie off the "
            "real surface; `tolerance` does"
        )
    if not said.says_unit:
        told.append("does not say its unit of length: read as mm; `scale` corrects it")
    return told
