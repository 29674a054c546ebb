"""One model part of a 3MF file: its objects and what it places.

Source: "3MF Core Specification" 1.3, chapters 3 and 4; Production Extension 1.1 and 1.2 (`path`, alternatives); Slice
Extension 1.0 (`meshresolution`); Triangle Sets (section 4.1.5 of the core specification).
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import MOST_ELEMENTS, Floats, Ints
from hognose.scene.imports.threemf_package import part_name
from hognose.scene.imports.xml_stream import Stream

METRES = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
TYPES = ("model", "solidsupport", "support", "surface", "other")

_MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing"
CORE = f"{_MICROSOFT}/core/2015/02"
_PRODUCTION = f"{_MICROSOFT}/production/2015/06"
_ALTERNATIVES = f"{_MICROSOFT}/production/alternatives/2021/04"
_SLICES = f"{_MICROSOFT}/slice/2015/07"
#: Extensions that may be required: these are read, or change nothing of the triangles.
_KNOWN = (
    CORE, _PRODUCTION, _ALTERNATIVES, _SLICES, f"{_MICROSOFT}/material/2015/02", f"{_MICROSOFT}/trianglesets/2021/07",
)  # fmt: skip
#: Namespaces of the 3MF Consortium: what an object has of another one of these is a shape that is not read.
_OF_3MF = (_MICROSOFT, "http://schemas.3mf.io/")

_MODEL, _RESOURCES, _BUILD, _ITEM = (f"{CORE} {name}" for name in ("model", "resources", "build", "item"))
_OBJECT, _MESH, _COMPONENTS, _COMPONENT = (f"{CORE} {name}" for name in ("object", "mesh", "components", "component"))
_VERTICES, _VERTEX, _TRIANGLES, _TRIANGLE = (
    f"{CORE} {name}" for name in ("vertices", "vertex", "triangles", "triangle")
)
#: The only place of each element that matters.
_PARENT = {
    _RESOURCES: _MODEL, _BUILD: _MODEL, _OBJECT: _RESOURCES, _MESH: _OBJECT, _COMPONENTS: _OBJECT, _ITEM: _BUILD,
    _COMPONENT: _COMPONENTS, _VERTICES: _MESH, _TRIANGLES: _MESH, _VERTEX: _VERTICES, _TRIANGLE: _TRIANGLES,
}  # fmt: skip
#: Elements all of whose children matter.
_SHAPES = (_OBJECT, _MESH, _COMPONENTS)
_HARMLESS = (f"{CORE} metadatagroup", f"{_MICROSOFT}/trianglesets/2021/07 trianglesets")


@dataclass(frozen=True)
class Placement:
    """A build item or a component: the object that it places, the part that is in (empty: this one), and where.

    `matrix` (4, 4) is for rows: [x y z 1] @ matrix (core, section 3.3).
    """

    object_id: int
    path: str
    matrix: Floats
    part_number: str = ""


@dataclass
class Object:
    """An object: a mesh, or components."""

    number: int
    name: str
    type: str
    sliced: bool = False
    vertices: Floats = field(default_factory=lambda: np.empty((0, 3)))
    faces: Ints = field(default_factory=lambda: np.empty((0, 3), np.int64))
    components: list[Placement] = field(default_factory=list)


@dataclass
class Model:
    """A model part."""

    unit: str = "millimeter"
    objects: dict[int, Object] = field(default_factory=dict)
    items: list[Placement] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def read_model(pieces: Iterable[bytes]) -> Model:
    """Return a model part from its XML; raises InputError, without the part's name."""
    reader = _Reader()
    reader.stream.read(pieces)
    return reader.model


class _Reader:
    """The handlers of one part: what is open, and what has been found."""

    def __init__(self) -> None:
        self.model = Model()
        self.stream = Stream(self._start, self._end)
        self.open: list[str] = []
        self.skipped = 0  # depth within an element that is passed by
        self.object: Object | None = None
        self.lists: set[str] = set()  # of the mesh that is open
        self.numbers = array("d")
        self.corners = array("q")
        self.strange: set[str] = set()

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        if not self.open:
            self._begin_model(name, attributes)
        elif self.skipped or self.open[-1] != _PARENT.get(name):
            self._pass_by(name)
        else:
            handle = _HANDLERS.get(name)
            if handle:
                handle(self, attributes)
        self.open.append(name)

    def _end(self, name: str) -> None:
        self.open.pop()
        self.skipped = max(0, self.skipped - 1)
        if name == _OBJECT and not self.skipped:
            self.object = None

    def _pass_by(self, name: str) -> None:
        namespace, _, local = name.rpartition(" ")
        if name in _PARENT or name == _MODEL:
            raise self._wrong(f"<{local}> within <{self.open[-1].rpartition(' ')[2]}>, where it has no place")
        if not self.skipped and self.open[-1] in _SHAPES and name not in _HARMLESS:
            if namespace.startswith(_OF_3MF) or not namespace:
                raise self._wrong(f"<{local}>, a shape that is not read ({_short(namespace)}); export it as triangles")
            self._strange(namespace)
        self.skipped += 1

    def _strange(self, namespace: str) -> None:
        if namespace not in self.strange:
            self.strange.add(namespace)
            self.model.notes.append(f"holds data that are not read: {namespace[:80]}")

    def _wrong(self, what: str) -> InputError:
        which = "" if self.object is None else f"object {self.object.number} has "
        return InputError(f"line {self.stream.line}: {which}{what}")

    def _begin_model(self, name: str, attributes: dict[str, str]) -> None:
        if name != _MODEL:
            raise InputError(f"begins with <{name[:120]}>, expected <{_MODEL}>")
        self.model.unit = attributes.get("unit", "millimeter")
        if self.model.unit not in METRES:
            raise InputError(f"its unit is {self.model.unit[:40]!r}, expected one of {', '.join(METRES)}")
        for key in ("requiredextensions", "recommendedextensions"):
            spaces = [self.stream.prefixes.get(prefix, prefix) for prefix in attributes.get(key, "").split()]
            unknown = ", ".join(_short(space) for space in spaces if space not in _KNOWN)
            if unknown and key == "requiredextensions":
                raise InputError(f"needs extensions that are not read: {unknown}; export it without, as triangles")
            if unknown:
                self.model.notes.append(f"recommends extensions that are not read: {unknown}")

    def _begin_object(self, attributes: dict[str, str]) -> None:
        number = self._whole(attributes, "id")
        if number in self.model.objects:
            raise self._wrong(f"a second object with the id {number}")
        name = attributes.get("name") or attributes.get("partnumber") or ""
        made = Object(number, name, attributes.get("type", "model"), f"{_SLICES} slicestackid" in attributes)
        self.object = self.model.objects[number] = made
        if made.type not in TYPES:
            raise self._wrong(f"the type {made.type[:40]!r}, expected one of {', '.join(TYPES)}")
        for space in (_SLICES, _ALTERNATIVES):
            resolution = attributes.get(f"{space} meshresolution") or attributes.get(f"{space} modelresolution")
            if resolution not in (None, "fullres"):
                raise self._wrong(f"triangles that only stand for another shape ({resolution[:40]}), which is not read")

    def _begin_mesh(self, _: dict[str, str]) -> None:
        assert self.object is not None
        if len(self.object.faces) or len(self.object.vertices) or self.object.components:
            raise self._wrong("more than one shape")
        self.lists = set()

    def _begin_list(self, name: str) -> None:
        if name in self.lists:
            raise self._wrong(f"a second list of {name.rpartition(' ')[2]}")
        self.lists.add(name)

    def _begin_vertices(self, _: dict[str, str]) -> None:
        self._begin_list(_VERTICES)
        self.numbers = array("d")
        self.stream.use(self._vertex, self._end_vertices)

    def _vertex(self, name: str, attributes: dict[str, str]) -> None:
        if name != _VERTEX:
            raise self._wrong(f"<{name.rpartition(' ')[2]}> among its vertices")
        try:
            add = self.numbers.append
            add(float(attributes["x"]))
            add(float(attributes["y"]))
            add(float(attributes["z"]))
        except (KeyError, ValueError):
            raise self._wrong(f"the vertex {_shown(attributes)}, expected numbers x, y and z") from None

    def _end_vertices(self, name: str) -> None:
        if name == _VERTICES:
            assert self.object is not None
            self.object.vertices = np.frombuffer(self.numbers, np.float64).reshape(-1, 3)
            self._back(name)

    def _begin_triangles(self, _: dict[str, str]) -> None:
        self._begin_list(_TRIANGLES)
        self.corners = array("q")
        self.stream.use(self._triangle, self._end_triangles)

    def _triangle(self, name: str, attributes: dict[str, str]) -> None:
        if name != _TRIANGLE:
            raise self._wrong(f"<{name.rpartition(' ')[2]}> among its triangles")
        try:
            add = self.corners.append
            add(int(attributes["v1"]))
            add(int(attributes["v2"]))
            add(int(attributes["v3"]))
        except (KeyError, ValueError, OverflowError):
            raise self._wrong(f"the triangle {_shown(attributes)}, expected whole numbers v1, v2 and v3") from None

    def _end_triangles(self, name: str) -> None:
        if name == _TRIANGLES:
            assert self.object is not None
            self.object.faces = np.frombuffer(self.corners, np.int64).reshape(-1, 3)
            if len(self.object.faces) > MOST_ELEMENTS:
                raise self._wrong(f"more than {MOST_ELEMENTS:,} triangles; make it coarser")
            self._back(name)

    def _back(self, name: str) -> None:
        self.stream.use(self._start, self._end)
        self._end(name)

    def _begin_components(self, _: dict[str, str]) -> None:
        assert self.object is not None
        if len(self.object.faces) or len(self.object.vertices) or self.object.components:
            raise self._wrong("more than one shape")

    def _begin_component(self, attributes: dict[str, str]) -> None:
        assert self.object is not None
        self.object.components.append(self._placement(attributes))

    def _begin_item(self, attributes: dict[str, str]) -> None:
        self.model.items.append(self._placement(attributes))

    def _placement(self, attributes: dict[str, str]) -> Placement:
        path = attributes.get(f"{_PRODUCTION} path", "")
        number = self._whole(attributes, "objectid")
        matrix = self._matrix(attributes.get("transform"))
        return Placement(number, part_name(path) if path else "", matrix, attributes.get("partnumber", ""))

    def _whole(self, attributes: dict[str, str], key: str) -> int:
        try:
            return int(attributes[key])
        except (KeyError, ValueError):
            said = attributes.get(key)
            raise self._wrong(f"{key} {'missing' if said is None else repr(said[:40])}, expected a number") from None

    def _matrix(self, said: str | None) -> Floats:
        made = np.eye(4)
        if said is not None:
            try:
                made[:, :3] = np.array([float(number) for number in said.split()]).reshape(4, 3)
            except ValueError:
                raise self._wrong(f"the transform {said[:80]!r}, expected 12 numbers") from None
            if not np.isfinite(made).all():
                raise self._wrong(f"the transform {said[:80]!r}, which is not of finite numbers")
        return made


_HANDLERS = {
    _OBJECT: _Reader._begin_object, _MESH: _Reader._begin_mesh, _VERTICES: _Reader._begin_vertices,
    _TRIANGLES: _Reader._begin_triangles, _COMPONENTS: _Reader._begin_components,
    _COMPONENT: _Reader._begin_component, _ITEM: _Reader._begin_item,
}  # fmt: skip


def _short(namespace: str) -> str:
    """What a message calls an extension: its name in its namespace, "beamlattice/2017/02"."""
    for head in (_MICROSOFT + "/", "http://schemas.3mf.io/"):
        namespace = namespace.removeprefix(head)
    return namespace[:80] or "no namespace"


def _shown(attributes: dict[str, str]) -> str:
    return " ".join(f'{name.rpartition(" ")[2]}="{value[:20]}"' for name, value in list(attributes.items())[:6])
