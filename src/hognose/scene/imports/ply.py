"""Reading PLY: vertices, polygons and strips of triangles, as text or binary."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.columns import axes
from hognose.scene.imports.content import Content, RawBody, Source
from hognose.scene.imports.numeric_text import plain, whole
from hognose.scene.imports.ply_header import Element, header
from hognose.scene.imports.ply_rows import Columns, read_rows
from hognose.scene.imports.polygons import loose, triangles

Ints = NDArray[np.int64]

_LISTS = ("vertex_indices", "vertex_index")
#: Elements that are no geometry, and are not spoken of.
#: Elements that are surfaces, whatever their properties are called.
_SURFACES = ("triangle", "triangles", "polygon", "polygons", "quad", "quads", "faces")
_NO_GEOMETRY = ("camera", "material", "materials", "multi_texture_vertex", "multi_texture_face")


def read(source: Source) -> Content:
    """Return the content of a PLY file; what else its vertices and faces have, colours and normals, is left out.

    Raises
    ------
    InputError
        It is cut, goes on after its end, or is not what its header says; or holds shapes that are not read.
    """
    data = source.data
    data = plain(data) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else data.removeprefix(b"\xef\xbb\xbf")
    head = header(data)
    names = [element.name for element in head.elements]
    for name in ("vertex", "face", "tristrips"):
        if names.count(name) > 1:
            raise InputError(f"has more than one element `{name}`; export it with one")
    asked = source.scan.columns
    found = read_rows(data, head, lambda element: _wanted(element, asked))
    parts = {element.name: (element, columns) for element, columns in zip(head.elements, found, strict=True)}
    if "vertex" not in parts:
        raise InputError("its header has no element `vertex`")
    element, columns = parts["vertex"]
    vertices = np.stack([columns.single[k] for k in _axes(element, asked)], axis=1)
    notes = tuple(note for element in head.elements for note in _left_out(element))
    faces, said = _faces(parts, vertices)
    if not len(faces):
        return Content(points=vertices, notes=(*notes, *said))
    return Content((RawBody("", vertices, faces),), loose(vertices, faces), notes=(*notes, *said))


def _wanted(element: Element, asked: tuple[str | int, ...] | None) -> list[int]:
    """The places of the properties that are read."""
    if element.name == "vertex":
        return sorted(set(_axes(element, asked)))
    if element.name in ("face", "tristrips"):
        place = element.index(*_LISTS)
        if sum(each.name in _LISTS for each in element.properties) > 1:
            raise InputError(f"`{element.name}` has two lists of vertices ({_names(element)}); export it with one")
        if place is not None and element.properties[place].count:
            return [place]
        if element.rows:
            raise InputError(f"`{element.name}` has no list `vertex_indices`; it names {_names(element)}")
    return []


def _axes(element: Element, asked: tuple[str | int, ...] | None) -> tuple[int, int, int]:
    found = axes([each.name for each in element.properties], asked, "properties of `vertex`")
    for place in found:
        if element.properties[place].count:
            raise InputError(f"the property `{element.properties[place].name}` of `vertex` is a list, expected numbers")
    return found


def _left_out(element: Element) -> list[str]:
    """What is to be said of an element that is not read; refused if it may be a surface."""
    if element.name in ("vertex", "face", "tristrips", *_NO_GEOMETRY) or not element.rows:
        return []
    shaped = element.index(*_LISTS) is not None or element.index("x") is not None or element.name in _SURFACES
    if shaped and element.name not in ("edge", "range_grid"):
        raise InputError(
            f"holds {element.rows:,} of an element `{element.name}` with {_names(element)}, which is not read; export "
            "it with vertices and faces only"
        )
    return [f"{element.rows:,} rows of `{element.name}` left out"]


def _names(element: Element) -> str:
    return ", ".join(f"`{each.name}`" for each in element.properties) or "nothing"


def _faces(parts: dict[str, tuple[Element, Columns]], vertices: NDArray[np.float64]) -> tuple[Ints, tuple[str, ...]]:
    made, notes = [np.empty((0, 3), np.int64)], ()
    for name in ("face", "tristrips"):
        if name not in parts or not parts[name][0].rows:
            continue
        ((items, counts),) = parts[name][1].lists.values()
        index = whole(items)
        if index is None:
            raise InputError(f"damaged: `{name}` names vertices that are not whole numbers")
        if name == "face":
            faces, notes = triangles(vertices, index, counts)
        else:
            faces = _strips(index, counts, len(vertices))
            collapsed = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
            faces = faces[~collapsed]
            if collapsed.any():  # by which strips are tied together
                notes = (*notes, f"{int(collapsed.sum()):,} triangles of strips without area left out")
        made.append(faces)
    return np.concatenate(made), notes


def _strips(index: Ints, counts: Ints, vertices: int) -> Ints:
    """Triangles (m, 3) of strips, in which -1 begins a new one; every other triangle is turned round."""
    if (counts < 3).any():
        raise InputError(
            f"a strip of triangles has {int(counts.min())} vertices, expected three or more; is it damaged?"
        )
    wrong = index[(index < -1) | (index >= vertices)]
    if wrong.size:
        raise InputError(f"a strip names the vertex {wrong[0]}, but there are {vertices:,}; is it damaged?")
    row = np.repeat(np.arange(len(counts)), counts)
    begins = np.append(True, (row[1:] != row[:-1]) | (index[:-1] < 0)) if len(index) else np.empty(0, np.bool_)
    strip = np.cumsum(begins)
    kept = index >= 0
    index, strip = index[kept], strip[kept]
    lengths = np.unique(strip, return_counts=True)[1]
    if (lengths < 3).any():
        raise InputError(
            f"a strip of triangles has {int(lengths.min())} vertices, expected three or more; is it damaged?"
        )
    place = np.arange(len(index)) - np.repeat(np.append(0, np.cumsum(lengths))[:-1], lengths)
    first = np.flatnonzero(strip[:-2] == strip[2:]) if len(index) > 2 else np.empty(0, np.int64)
    turned = place[first] % 2 == 1
    return np.stack([index[first], index[first + 1 + turned], index[first + 2 - turned]], axis=1)
