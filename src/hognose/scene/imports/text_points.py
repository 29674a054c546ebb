"""Reading point clouds written as text: x, y, z and perhaps more on every line."""

from __future__ import annotations

import io
import warnings

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.content import Content, Source


def read(source: Source) -> Content:
    """Return the points of a text with one a line, between blanks, commas or semicolons.

    What follows the third number is left out, and so are empty lines, those that begin with # or //, and a first line
    of headings.

    Raises
    ------
    InputError
        A line that does not begin with three numbers; tells its number.
    """
    return Content(points=_points(source.data))


def _points(data: bytes) -> NDArray[np.float64]:
    if b"\0" in data[:4096]:
        raise InputError("not a text file; expected lines of x y z")
    text = data.replace(b",", b" ").replace(b";", b" ")
    skip = 0 if _starts_with_numbers(_first_line(text)) else 1
    stream = io.BytesIO(text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that there is none is said by the caller
            return np.loadtxt(
                stream, comments=("#", "//"), usecols=(0, 1, 2), skiprows=skip, ndmin=2, encoding="latin-1"
            )
    except ValueError:
        for number, line in enumerate(text.splitlines(), 1):
            said = line.split(b"#")[0].split(b"//")[0]
            if number > skip and said.strip() and not _starts_with_numbers(said):
                shown = line.strip()[:40].decode("utf-8", "replace")
                raise InputError(f"line {number} is {shown!r}; expected x y z; is the file cut?") from None
        raise InputError("cannot be read as lines of x y z") from None


def _first_line(text: bytes) -> bytes:
    return text.split(b"\n", 1)[0]


def _starts_with_numbers(line: bytes) -> bool:
    parts = line.split()[:3]
    if line.lstrip()[:1] == b"#" or line.lstrip()[:2] == b"//" or not parts:
        return True  # a line that is skipped anyway
    try:
        return len([float(part) for part in parts]) == 3
    except ValueError:
        return False
