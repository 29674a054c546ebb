"""Reading Wavefront OBJ: vertices, faces and the names of objects and groups."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.content import Content, RawBody, Source
from hognose.scene.imports.joining import joined
from hognose.scene.imports.numeric_text import Rows, name, plain, rows, shown
from hognose.scene.imports.polygons import loose, triangles

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Statements that change nothing about where surfaces are, those of free-form geometry that come with one of `_SHAPES`
#: among them.
_IGNORED = frozenset(
    b"vt vn vp s mg usemtl mtllib usemap maplib bevel c_interp d_interp lod shadow_obj trace_obj ctech stech deg bmat "
    b"step cstype parm trim hole scrv sp end con cdc cdp res".split()
)
#: Statements of geometry that is not read, and what to call it.
_SHAPES = {
    b"surf": "free-form surfaces", b"bsp": "free-form surfaces", b"bzp": "free-form surfaces",
    b"curv": "free-form curves", b"curv2": "free-form curves", b"l": "lines", b"p": "lists of points",
}  # fmt: skip
_CONTINUED = re.compile(rb"(?:[^\n]*\\\n)+[^\n]*")
_REFUSED = {b"call": "takes in another file", b"csh": "runs a command"}


@dataclass
class _Statements:
    """The statements of a file.

    Attributes
    ----------
    text
        The file, with lines that go on in the next one put together.
    vertices, faces
        What follows each `v` and each `f`.
    known
        How many vertices come before each face.
    heads
        The name of each object or group, and how many faces come before it.
    shapes
        How often there is geometry that is not read.
    """

    text: bytes
    vertices: list[bytes] = field(default_factory=list)
    faces: list[bytes] = field(default_factory=list)
    known: list[int] = field(default_factory=list)
    heads: list[tuple[bytes, int]] = field(default_factory=lambda: [(b"", 0)])
    shapes: Counter[str] = field(default_factory=Counter)

    def line(self, kind: bytes, number: int) -> int:
        """The line of the vertex or face (`kind`) of an index."""
        kinds = (b"v",) if kind == b"v" else (b"f", b"fo")
        lines = (
            k for k, line in enumerate(self.text.split(b"\n"), 1) if line.split(None, 1)[:1] in ([k] for k in kinds)
        )
        return next(islice(lines, number, None))


def read(source: Source) -> Content:
    """Return the content of an OBJ file: one body an object or group that has faces of its own.

    Groups that are parts of one surface are one body. Materials, normals and colours are left out.

    Raises
    ------
    InputError
        A line that is not what it says, tells its number; or nothing but free-form geometry.
    """
    said = _statements(plain(source.data))
    vertices, notes = _vertices(said)
    notes += [f"{number:,} {what} left out" for what, number in said.shapes.items()]
    if not said.faces:
        if any(what.startswith("free-form") for what in said.shapes):
            raise InputError(f"holds no polygons, but {', '.join(notes)}: export it as polygons, or as STEP")
        return Content(points=vertices, notes=tuple(notes))
    index, corners = _corners(said, len(vertices))
    faces, bent = triangles(vertices, index, corners, first=1)
    ends = np.append(0, np.cumsum(corners - 2))
    parts: dict[str, list[Ints]] = {}  # those of one name, as exporters write them for each material, are one body
    for (called, begin), (_, end) in zip(said.heads, [*said.heads[1:], (b"", len(corners))], strict=True):
        if end > begin:
            parts.setdefault(name(called), []).append(faces[ends[begin] : ends[end]])
    bodies = [RawBody(called, vertices, np.concatenate(pieces)) for called, pieces in parts.items()]
    whole_ones, put = joined(bodies, "groups")
    return Content(whole_ones, loose(vertices, faces), notes=(*notes, *bent, *put))


def _statements(text: bytes) -> _Statements:
    if b"\\\n" in text:
        text = _CONTINUED.sub(lambda m: m[0].replace(b"\\\n", b"  ") + b"\n" * m[0].count(b"\\\n"), text)
    said = _Statements(text)
    for number, line in enumerate(text.split(b"\n"), 1):
        kind = line[:2]
        if kind == b"v ":
            said.vertices.append(line[2:])
        elif kind == b"f ":
            said.faces.append(line[2:])
            said.known.append(len(said.vertices))
        elif line:
            _statement(said, number, line)
    return said


def _statement(said: _Statements, number: int, line: bytes) -> None:
    kind, rest = [*line.split(None, 1), b"", b""][:2]
    if kind.startswith(b"#") or not kind:
        return
    if kind == b"v":
        said.vertices.append(rest)
    elif kind in (b"f", b"fo"):
        said.faces.append(rest)
        said.known.append(len(said.vertices))
    elif kind in (b"o", b"g"):
        said.heads.append((re.split(rb"(?<!\S)#", rest, maxsplit=1)[0].strip(), len(said.faces)))
    elif kind in _SHAPES:
        said.shapes[_SHAPES[kind]] += 1
    elif kind in _REFUSED:
        raise InputError(f"line {number}: `{kind.decode()}` {_REFUSED[kind]}, which is not done; export it whole")
    elif kind not in _IGNORED:
        raise InputError(f"line {number} is {shown(line)}, which is no statement of OBJ; is it cut, damaged or a text?")


def _rows(said: _Statements, kind: bytes, what: str) -> tuple[Rows, Ints]:
    """The numbers of all vertices or faces, and how many each has, three at least."""
    texts = said.vertices if kind == b"v" else said.faces
    text = b"\n".join(texts)
    if b"#" in text:
        text = re.sub(rb"#[^\n]*", b"", text)
    if kind == b"f" and b"/" in text:
        text = re.sub(rb"/\S*", b"", text)
    try:
        table = rows(text)
    except InputError as error:
        place = re.match(r"line (\d+)", str(error))
        assert place is not None
        raise InputError(f"line {said.line(kind, int(place[1]) - 1)}{str(error)[place.end() :]}") from None
    width = np.zeros(len(texts), np.int64)
    width[table.lines - 1] = np.diff(table.ends, prepend=0)
    few = np.flatnonzero(width < 3)
    if few.size:
        first = int(few[0])
        raise InputError(f"line {said.line(kind, first)} is {shown(texts[first])}, expected {what}; is it cut?")
    return table, width


def _vertices(said: _Statements) -> tuple[Floats, list[str]]:
    """Coordinates (v, 3), and what is to be said of what follows them: a weight, or a colour, or both."""
    if not said.vertices:
        return np.empty((0, 3)), []
    table, width = _rows(said, b"v", "three numbers")
    odd = np.flatnonzero(~np.isin(width, (3, 4, 6, 7, 8)))
    if odd.size:
        raise InputError(
            f"line {said.line(b'v', int(odd[0]))} is a vertex of {width[odd[0]]} numbers; expected x y z, and perhaps "
            "a weight or a colour"
        )
    weight = table.numbers[table.begins[width == 4] + 3]
    heavy = int((weight != 1).sum())
    notes = [f"{heavy:,} vertices have a weight that is not 1: it means nothing for polygons"] if heavy else []
    return table.numbers[table.begins[:, None] + [0, 1, 2]], notes


def _corners(said: _Statements, vertices: int) -> tuple[Ints, Ints]:
    """The vertices of all faces, from 0, and how many each has."""
    table, corners = _rows(said, b"f", "three vertices or more")
    numbers = table.numbers
    before = np.repeat(np.array(said.known, np.float64), corners)
    index = np.where(numbers < 0, before + numbers, numbers - 1)
    right = (numbers % 1 == 0) & (numbers != 0) & (index >= 0) & (index < vertices)
    if not right.all():
        wrong = int(np.argmin(right))
        row = int(np.searchsorted(table.ends, wrong, side="right"))
        raise InputError(
            f"line {said.line(b'f', row)}: a face names the vertex {numbers[wrong]:.12g}, but there are {vertices:,}, "
            "counted from 1, or back from -1; is the file cut or damaged?"
        )
    return index.astype(np.int64), corners
