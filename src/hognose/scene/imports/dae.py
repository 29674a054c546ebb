"""Reading COLLADA (DAE): every mesh that its scene places, one body a node. Axes are taken as they are.

Source: Khronos, "COLLADA – Digital Asset Schema Release 1.4.1" and 1.5.0, chapter 5 (node and its transformations,
instances, scene, asset).
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import MOST_ELEMENTS, Content, Floats, RawBody, Source, body_at
from hognose.scene.imports.dae_mesh import Shape, child, children, local, reference, shape_of
from hognose.scene.imports.joining import joined
from hognose.scene.imports.xml_stream import tree

_DEEPEST = 500
_NAMESPACES = ("http://www.collada.org/2005/11/COLLADASchema", "http://www.collada.org/2008/03/COLLADASchema")


def read(source: Source) -> Content:
    """Return the content of a COLLADA file.

    Raises
    ------
    InputError
        It is cut, damaged, or holds what cannot be taken as it is meant: see `docs/formats.md`.
    """
    root = tree(source.data)
    if root.tag not in [f"{space} COLLADA" for space in _NAMESPACES]:
        raise InputError(f"not a COLLADA file of version 1.4 or 1.5: it begins with <{root.tag[:120]}>")
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused with the body's name, later
        return _File(root).content()


class _File:
    """What is being put together of one file."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.metres, self.up = _asset(root)
        self.ids = _ids(root)
        self.shapes: dict[str, Shape] = {}
        self.bodies: list[RawBody] = []
        self.elements = self.curves = 0

    def content(self) -> Content:
        scenes, notes = self._scenes()
        for scene in scenes:
            for node in children(scene, "node"):
                self._walk(node)
        bodies, put = joined(self.bodies, "nodes")
        return Content(bodies, metres=self.metres, notes=(*notes, *self._left_out(), *put))

    def _scenes(self) -> tuple[list[Element], list[str]]:
        """The scene that the file shows, or all if it does not say, and notes."""
        every = self._all("visual_scenes", "visual_scene")
        shown = child(self.root, "scene")
        named = [] if shown is None else children(shown, "instance_visual_scene")
        if named:
            scene = self._find(named[0], "url", "visual_scene")
            others = len(every) - 1
            return [scene], [f"{_count(others, 'scene')} that it does not show left out"] if others else []
        many = f"does not say which of its {len(every)} scenes is meant: all are taken"
        return every, [many] if len(every) > 1 else []

    def _walk(self, top: Element) -> None:
        waiting: list[tuple[Element, tuple[Element, ...]]] = [(top, ())]
        while waiting:
            node, above = waiting.pop()
            if any(node is each for each in above):
                raise InputError(f"damaged: {_called(node)} has itself as an instance, directly or through others")
            if len(above) > _DEEPEST:
                raise InputError(f"has nodes within nodes, over {_DEEPEST} deep; export it again with fewer")
            self._count_more(1)
            trail = (*above, node)
            self._place(node, trail)
            below = [
                self._find(each, "url", "node") if local(each) == "instance_node" else each
                for each in children(node, "node", "instance_node")
            ]
            waiting += [(each, trail) for each in reversed(below)]

    def _place(self, node: Element, trail: tuple[Element, ...]) -> None:
        for bent in children(node, "instance_controller"):
            raise InputError(
                f"{_called(node)} has the mesh {bent.get('url', '')[:40]!r}, which is bent by a skeleton or morphed; "
                "that is not read: apply it to the mesh and export it again"
            )
        geometries = [self._find(each, "url", "geometry") for each in children(node, "instance_geometry")]
        shapes = [self._shape(each) for each in geometries]
        self.curves += sum(shape.curves for shape in shapes)
        self._count_more(sum(max(len(shape.faces), len(shape.vertices) // 3) for shape in shapes))
        if not any(len(shape.faces) for shape in shapes):
            return
        matrix = np.eye(4)
        for each in trail:
            matrix = matrix @ _matrix(each)
        first = np.cumsum([0, *(len(shape.vertices) for shape in shapes)])
        faces = np.concatenate([shape.faces + offset for shape, offset in zip(shapes, first, strict=False)])
        vertices = np.concatenate([shape.vertices for shape in shapes])
        names = [node.get("name"), geometries[0].get("name"), node.get("id"), geometries[0].get("id")]
        called = next((name for name in names if name), "")
        self.bodies.append(body_at(called, vertices, faces, matrix[:3, :3], matrix[:3, 3]))

    def _shape(self, geometry: Element) -> Shape:
        name = geometry.get("id", "")
        if name not in self.shapes:
            self.shapes[name] = shape_of(geometry, _called(geometry))
        return self.shapes[name]

    def _count_more(self, number: int) -> None:
        self.elements += number
        if self.elements > MOST_ELEMENTS:
            raise InputError(f"holds more than {MOST_ELEMENTS:,} triangles, counting all instances; make it coarser")

    def _all(self, library: str, kind: str) -> list[Element]:
        return [each for place in children(self.root, f"library_{library}") for each in children(place, kind)]

    def _find(self, element: Element, key: str, kind: str) -> Element:
        name = reference(element, key)
        found = self.ids.get(name)
        if found is None or local(found) != kind:
            raise InputError(f"damaged: <{local(element)}> refers to the {kind} {name[:40]!r}, which is not there")
        return found

    def _left_out(self) -> list[str]:
        told: list[str] = []
        if self.curves:
            told.append(f"{_count(self.curves, 'primitive')} of lines left out")
        idle = sum(each.get("id", "") not in self.shapes for each in self._all("geometries", "geometry"))
        if idle:
            told.append(f"{_count(idle, 'mesh', 'meshes')} that no node places left out")
        if self._all("animations", "animation"):
            told.append("animations left out: everything is where it is at rest")
        if self._all("physics_models", "physics_model"):
            told.append("shapes of its physics models left out")
        if self.up != "Z_UP":
            told.append(f"its axis that points up is {self.up[0]}: its axes are taken as they are, not turned")
        return told


def _asset(root: Element) -> tuple[float, str]:
    """Metres in the file's unit and its up axis, which all its assets must share."""
    said: dict[str, set[str]] = {"unit": set(), "up_axis": set()}
    for asset in (each for each in root.iter() if local(each) == "asset"):
        for each in asset:
            if local(each) == "unit":
                said["unit"].add(each.get("meter", "1"))
            elif local(each) == "up_axis":
                said["up_axis"].add((each.text or "").strip())
    if any(len(values) > 1 for values in said.values()):
        raise InputError("has parts in different units or with different axes; export it again in one")
    unit, up = (said["unit"] or {"1"}).pop(), (said["up_axis"] or {"Y_UP"}).pop()
    try:
        metres = float(unit)
    except ValueError:
        metres = math.nan
    if not 0 < metres < math.inf or up not in ("X_UP", "Y_UP", "Z_UP"):
        raise InputError(
            f"damaged: its unit is {unit[:40]!r} metres and its axis {up[:40]!r}, expected e.g. 0.001, Z_UP"
        )
    return metres, up


def _ids(root: Element) -> dict[str, Element]:
    found: dict[str, Element] = {}
    for each in root.iter():
        name = each.get("id")
        if name is not None and local(each) in ("node", "geometry", "visual_scene"):
            if name in found:
                raise InputError(f"damaged: has the id {name[:40]!r} twice")
            found[name] = each
    return found


def _called(element: Element) -> str:
    return f"{local(element)} {(element.get('name') or element.get('id') or '')[:40]!r}"


def _matrix(node: Element) -> Floats:
    """T_parent_node: the product of the node's transformations in their order."""
    made = np.eye(4)
    for each in children(node, *_LENGTHS, "lookat", "skew"):
        kind = local(each)
        if kind not in _LENGTHS:
            raise InputError(f"{_called(node)} is placed by <{kind}>, which is not read; export it with a <matrix>")
        try:
            numbers = np.array([float(word) for word in (each.text or "").split()])
        except ValueError:
            numbers = np.array([math.nan])
        if len(numbers) != _LENGTHS[kind] or not np.isfinite(numbers).all():
            raise InputError(f"damaged: <{kind}> of {_called(node)} is not {_LENGTHS[kind]} numbers")
        made = made @ _one(kind, numbers, node)
    return made


_LENGTHS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3}


def _one(kind: str, numbers: Floats, node: Element) -> Floats:
    made = np.eye(4)
    if kind == "matrix":
        made = numbers.reshape(4, 4)
        if not np.array_equal(made[3], [0, 0, 0, 1]):
            raise InputError(f"damaged: <matrix> of {_called(node)} does not end in 0, 0, 0, 1")
    elif kind == "translate":
        made[:3, 3] = numbers
    elif kind == "scale":
        made[:3, :3] = np.diag(numbers)
    else:
        length = np.linalg.norm(numbers[:3])
        if length == 0 and numbers[3]:
            raise InputError(f"damaged: <rotate> of {_called(node)} has no axis")
        x, y, z = numbers[:3] / (length or 1.0)
        angle = math.radians(numbers[3])
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        made[:3, :3] += math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return made


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number:,} {one if number == 1 else many or one + 's'}"
