"""Reading glTF 2.0 and GLB: every mesh that the scene places, one body a node.

A mesh of several primitives (exporters make one for each material) is one body; so are all instances of a node that
has many. Lengths are metres (section 3.4). Axes are taken as they are.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import MOST_ELEMENTS, Content, Floats, RawBody, Source, body_at
from hognose.scene.imports.gltf_accessors import Accessors
from hognose.scene.imports.gltf_buffers import Buffers, opened
from hognose.scene.imports.gltf_document import Document, document, unread_extensions
from hognose.scene.imports.gltf_nodes import called, instances, placed, roots
from hognose.scene.imports.gltf_primitives import Meshes, Shape
from hognose.scene.imports.joining import joined

#: Names that OpenCASCADE makes up for nodes that have none: a label of its tree, a number of a STEP entity.
_MADE_UP = re.compile(r"=>\[.*\]|NAUO\d*")


def read(source: Source) -> Content:
    """Return the content of a glTF or GLB file.

    Raises
    ------
    InputError
        It is cut, damaged, of another version, compressed, or holds what cannot be taken as it is meant: see
        `docs/formats.md`.
    """
    container = opened(source.data)
    if source.path.suffix.lower() == ".glb" and not container.is_glb:
        raise InputError("not a GLB file: it does not begin with `glTF`")
    tree = document(container.text)
    buffers = Buffers(tree.buffers, container, source.path.parent)
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused with the body's name, later
        content = _Scene(tree, Accessors(tree, buffers)).content()
    if container.unknown_chunks:
        note = f"{_count(container.unknown_chunks, 'chunk')} of an unknown kind left out"
        return replace(content, notes=(*content.notes, note))
    return content


class _Scene:
    """What is being put together of one file."""

    def __init__(self, tree: Document, accessors: Accessors) -> None:
        self.tree, self.accessors, self.meshes = tree, accessors, Meshes(accessors)
        self.bodies: list[RawBody] = []
        self.points: list[Floats] = [np.empty((0, 3))]
        self.others: Counter[str] = Counter()
        self.elements = 0

    def content(self) -> Content:
        tops, note = _shown(self.tree)
        seen: set[int] = set()
        for number, matrix in placed(self.tree, tops):
            seen.add(number)
            if self.tree.nodes[number].mesh is not None:
                self._place(number, matrix)
        notes = [note] if note else []
        notes += [f"{_count(many, 'primitive')} {what} left out" for what, many in sorted(self.others.items())]
        notes += _left_out(self.tree, seen)
        bodies, put = joined(self.bodies, "nodes")
        notes += put
        return Content(bodies, np.concatenate(self.points), 1.0, tuple(notes))

    def _place(self, number: int, matrix: Floats) -> None:
        node = self.tree.nodes[number]
        assert node.mesh is not None
        if node.skin is not None:
            raise InputError(
                f"{called(self.tree, number)} is bent by a skeleton (a skin), which is not read; apply it to the mesh "
                "and export it again"
            )
        shape = self.meshes.shape(node.mesh, node.weights)
        size = max(1, len(shape.faces), len(shape.vertices) // 3) + len(shape.points)
        places = instances(self.accessors, number, (MOST_ELEMENTS - self.elements) // size)
        self.elements += size * len(places)
        name = self._name(number, node.mesh)
        made = [_moved(name, shape, matrix @ place) for place in places]
        self.points += [each.points for each in made]
        self.others.update(shape.others)
        if len(shape.faces) and made:
            joined = _joined(made)
            self.bodies.append(RawBody(name, joined.vertices, joined.faces))

    def _name(self, node: int, mesh: int) -> str:
        """The name of a node, or of its mesh where it has none of its own; empty if neither has."""
        for name in (self.tree.nodes[node].name, self.tree.meshes[mesh].name):
            if name and not _MADE_UP.fullmatch(name):
                return name
        return ""


def _shown(tree: Document) -> tuple[list[int], str]:
    """The roots to take, and a note if the file does not say which.

    Of a file that says which scene is shown, that one; of others, all scenes; without a scene, all nodes.
    """
    free = roots(tree)
    if tree.scene is not None:
        if tree.scene >= len(tree.scenes):
            raise InputError(f"damaged: its scene is {tree.scene}, but it has {len(tree.scenes)}")
        return _roots_of(tree, [tree.scene], free), ""
    if not tree.scenes:
        return free, "has no scene: all nodes are taken" if free else ""
    count = len(tree.scenes)
    note = f"does not say which of its {count} scenes is meant: all are taken" if count > 1 else ""
    return _roots_of(tree, list(range(count)), free), note


def _roots_of(tree: Document, scenes: list[int], free: list[int]) -> list[int]:
    named = dict.fromkeys(node for scene in scenes for node in tree.scenes[scene].nodes)  # each once, in order
    allowed = set(free)
    for number in named:
        if number >= len(tree.nodes):
            raise InputError(f"damaged: a scene places node {number}, but it has {len(tree.nodes)}")
        if number not in allowed:
            raise InputError(f"damaged: a scene places {called(tree, number)}, which is the child of another")
    return list(named)


def _left_out(tree: Document, seen: set[int]) -> list[str]:
    """Notes of what the file holds beside the scene."""
    told: list[str] = []
    hidden = [k for k, node in enumerate(tree.nodes) if node.mesh is not None and k not in seen]
    if hidden:
        names = [repr(tree.nodes[k].name[:40]) for k in hidden[:3] if tree.nodes[k].name]
        shown = f" ({', '.join(names)}{', …' if len(hidden) > len(names) else ''})" if names else ""
        told.append(f"{_count(len(hidden), 'node')} with a mesh, not in its scene, left out{shown}")
    unused = len(tree.meshes) - len({node.mesh for node in tree.nodes if node.mesh is not None})
    if unused > 0:
        told.append(f"{_count(unused, 'mesh', 'meshes')} that no node places left out")
    if tree.animations:
        told.append(f"{_count(len(tree.animations), 'animation')} left out: everything is where it is at rest")
    unread = unread_extensions(tree)
    if unread:
        told.append(f"holds data of extensions that are not read: {', '.join(unread)[:200]}")
    return told


def _moved(name: str, shape: Shape, matrix: Floats) -> Shape:
    """A shape in the scene (section 3.7.4)."""
    if np.array_equal(matrix, np.eye(4)):
        return shape
    turn, shift = matrix[:3, :3], matrix[:3, 3]
    body = body_at(name, shape.vertices, shape.faces, turn, shift)
    return Shape(body.vertices, body.faces, shape.points @ turn.T + shift)


def _joined(shapes: list[Shape]) -> Shape:
    if len(shapes) == 1:
        return shapes[0]
    first = np.cumsum([0] + [len(shape.vertices) for shape in shapes])
    faces = [shape.faces + offset for shape, offset in zip(shapes, first, strict=False)]
    return Shape(np.concatenate([s.vertices for s in shapes]), np.concatenate(faces), np.empty((0, 3)))


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number:,} {one if number == 1 else many or one + 's'}"
