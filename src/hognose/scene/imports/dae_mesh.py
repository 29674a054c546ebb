"""The meshes of a COLLADA file: sources of positions, and primitives of every kind.

Source: Khronos, "COLLADA – Digital Asset Schema Release 1.4.1" and 1.5.0, chapter 5 (geometry: mesh, source, accessor,
triangles, tristrips, trifans, polylist, polygons).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import Floats, Ints
from hognose.scene.imports.polygons import fans


@dataclass(frozen=True, eq=False)
class Shape:
    """One mesh: vertices (v, 3), faces (m, 3), and how many of its primitives are curves."""

    vertices: Floats
    faces: Ints
    curves: int = 0


def local(element: Element) -> str:
    """The name of an element without its namespace."""
    return element.tag.rpartition(" ")[2]


def child(element: Element, name: str) -> Element | None:
    """The first child of a name."""
    return next((each for each in element if local(each) == name), None)


def children(element: Element, *names: str) -> list[Element]:
    """All children of some names."""
    return [each for each in element if local(each) in names]


def reference(element: Element, key: str) -> str:
    """The id that an element refers to within its file.

    Raises
    ------
    InputError
        It refers to nothing, or to another file.
    """
    said = element.get(key, "")
    file, mark, name = said.partition("#")
    if file:
        raise InputError(
            f"<{local(element)}> refers to another file, {file[:80]!r}, which is not read; export it whole"
        )
    if not mark or not name:
        raise InputError(f"damaged: <{local(element)}> has the {key} {said[:40]!r}, expected #id")
    return name


def shape_of(geometry: Element, called: str) -> Shape:
    """Return the triangles of a geometry, in its own frame; polygons become fans.

    Raises
    ------
    InputError
        It is damaged, or a shape of a kind that is not read.
    """
    for kind in children(geometry, "convex_mesh", "brep"):
        raise InputError(f"{called} is a <{local(kind)}>, which is not read; export it as a mesh")
    mesh = child(geometry, "mesh")
    if mesh is None:
        return Shape(np.empty((0, 3)), np.empty((0, 3), np.int64), len(children(geometry, "spline")))
    faces, curves = [np.empty((0, 3), np.int64)], 0
    places = np.empty((0, 3))
    for primitive in mesh:
        kind = local(primitive)
        if kind in ("lines", "linestrips"):
            curves += 1
        elif kind in _KINDS:
            places = places if len(places) else _positions(mesh, called)
            corners = _corners(primitive, called)
            for row in corners:
                if len(row) and not 0 <= int(row.min()) <= int(row.max()) < len(places):
                    raise InputError(
                        f"damaged: {called} names a vertex that is not there; it has {len(places):,} of them"
                    )
            faces += _KINDS[kind](primitive, corners, called)
        elif kind not in ("source", "vertices", "extra"):
            raise InputError(f"{called} has <{kind}>, which is not read")
    return Shape(places, np.concatenate(faces), curves)


def _positions(mesh: Element, called: str) -> Floats:
    """The positions of a mesh's vertices (v, 3): the rows X, Y, Z of their source."""
    vertices = child(mesh, "vertices")
    inputs = [] if vertices is None else [v for v in children(vertices, "input") if v.get("semantic") == "POSITION"]
    name = reference(inputs[0], "source") if inputs else ""
    source = next((each for each in children(mesh, "source") if each.get("id") == name), None)
    if source is None:
        raise InputError(f"damaged: {called} has no positions ({name[:40]!r})")
    technique, array = child(source, "technique_common"), child(source, "float_array")
    accessor = None if technique is None else child(technique, "accessor")
    if accessor is None or array is None:
        raise InputError(f"damaged: the positions of {called} are no numbers with an accessor")
    values = _floats(array, called)
    count, stride, offset = (
        _whole(accessor, key, least) for key, least in (("count", None), ("stride", 1), ("offset", 0))
    )
    names = [each.get("name") for each in children(accessor, "param")]
    if not {"X", "Y", "Z"} <= set(names) or stride < len(names):
        raise InputError(f"damaged: the positions of {called} have no X, Y and Z")
    if _whole(array, "count", len(values)) != len(values) or offset + count * stride > len(values):
        raise InputError(f"cut or damaged: the positions of {called} are {len(values):,} numbers, fewer than it says")
    return values[offset : offset + count * stride].reshape(count, stride)[:, [names.index(axis) for axis in "XYZ"]]


def _corners(primitive: Element, called: str) -> list[Ints]:
    """The vertices that each <p> of a primitive names."""
    inputs = children(primitive, "input")
    width = 1 + max((_whole(each, "offset", 0) for each in inputs), default=0)
    column = next((_whole(each, "offset", 0) for each in inputs if each.get("semantic") == "VERTEX"), None)
    if column is None:
        raise InputError(f"damaged: <{local(primitive)}> of {called} does not say where its vertices are")
    if children(primitive, "ph"):
        raise InputError(f"{called} has polygons with holes (<ph>), which are not read; export it as triangles")
    rows: list[Ints] = []
    for each in children(primitive, "p"):
        numbers = _integers(each, called)
        if len(numbers) % width:
            raise InputError(f"cut or damaged: <p> of {called} has {len(numbers):,} numbers, no multiple of {width}")
        rows.append(numbers.reshape(-1, width)[:, column])
    return rows


def _triangles(primitive: Element, corners: list[Ints], called: str) -> Iterator[Ints]:
    row = np.concatenate([np.empty(0, np.int64), *corners])
    if len(row) != 3 * _whole(primitive, "count", len(row) // 3):
        raise InputError(
            f"cut or damaged: {called} says it has {primitive.get('count')} triangles, but has {len(row)} corners"
        )
    yield row.reshape(-1, 3)


def _tristrips(primitive: Element, corners: list[Ints], called: str) -> Iterator[Ints]:
    for row in _enough(primitive, corners, called):
        k = np.arange(len(row) - 2)
        yield _whole_triangles(row[np.stack([k, k + 1 + k % 2, k + 2 - k % 2], axis=1)])


def _trifans(primitive: Element, corners: list[Ints], called: str) -> Iterator[Ints]:
    for row in _enough(primitive, corners, called):
        yield _whole_triangles(fans(row, np.array([len(row)])))


def _polygons(primitive: Element, corners: list[Ints], called: str) -> Iterator[Ints]:
    for row in _enough(primitive, corners, called):
        yield fans(row, np.array([len(row)]))


def _polylist(primitive: Element, corners: list[Ints], called: str) -> Iterator[Ints]:
    row = np.concatenate([np.empty(0, np.int64), *corners])
    counts = child(primitive, "vcount")
    sizes = np.empty(0, np.int64) if counts is None else _integers(counts, called)
    if len(sizes) != _whole(primitive, "count", len(sizes)) or sizes.sum() != len(row) or (sizes < 3).any():
        raise InputError(f"cut or damaged: the polygons of {called} have not the {len(row):,} corners that they name")
    yield fans(row, sizes)


_KINDS = {
    "triangles": _triangles, "tristrips": _tristrips, "trifans": _trifans, "polygons": _polygons, "polylist": _polylist,
}  # fmt: skip


def _enough(primitive: Element, corners: list[Ints], called: str) -> list[Ints]:
    said = _whole(primitive, "count", len(corners))
    if said != len(corners) or any(len(row) < 3 for row in corners):
        raise InputError(
            f"cut or damaged: <{local(primitive)}> of {called} has not {said} rows of three corners or more"
        )
    return corners


def _whole_triangles(triangles: Ints) -> Ints:
    """Without those that repeat a corner: these go on elsewhere, and are no surface."""
    return triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def _whole(element: Element, key: str, default: int | None) -> int:
    said = element.get(key)
    try:
        made = int(said) if said is not None else default
    except ValueError:
        made = None
    if made is None or not 0 <= made < 2**31:
        raise InputError(f"damaged: <{local(element)}> has the {key} {str(said)[:40]!r}, expected a number")
    return made


def _floats(element: Element, called: str) -> Floats:
    words = (element.text or "").split()
    try:
        return np.array([float(word) for word in words], np.float64)
    except ValueError:
        raise _no_number(element, called, words, float) from None


def _integers(element: Element, called: str) -> Ints:
    words = (element.text or "").split()
    try:
        return np.array([int(word) for word in words], np.int64)
    except (ValueError, OverflowError):
        raise _no_number(element, called, words, int) from None


def _no_number(element: Element, called: str, words: list[str], kind: type) -> InputError:
    """What is said of the first word that is no number."""
    for word in words:
        try:
            np.array(kind(word), np.float64 if kind is float else np.int64)
        except (ValueError, OverflowError):
            return InputError(f"damaged: <{local(element)}> of {called} has {word[:40]!r}, expected a number")
    return InputError(f"damaged: <{local(element)}> of {called} has what is no number")
