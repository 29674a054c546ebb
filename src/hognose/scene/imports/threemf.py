"""Reading 3MF: every mesh that the build places, one body each time an object is placed.

Source: "3MF Core Specification" 1.3, sections 3.4 (build) and 4 (objects); Production Extension (objects in other
parts of the archive).
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import MOST_ELEMENTS, Content, Floats, RawBody, Source, body_at
from hognose.scene.imports.joining import joined
from hognose.scene.imports.threemf_model import METRES, Model, Object, Placement, read_model
from hognose.scene.imports.threemf_package import Package

#: An object: the part that it is in, and its id, which other parts may use too.
Key = tuple[str, int]
_DEEPEST = 100


def read(source: Source) -> Content:
    """Return the content of a 3MF file.

    Raises
    ------
    InputError
        It is cut, damaged, encrypted, or holds what cannot be taken as it is meant: see `docs/formats.md`.
    """
    return _Build(Package(source.data)).content()


class _Build:
    """What is being put together of one file."""

    def __init__(self, package: Package) -> None:
        self.package = package
        self.models: dict[str, Model] = {}
        self.root = package.start()
        self.sizes: dict[Key, int] = {}
        self.used: set[Key] = set()
        self.bodies: list[RawBody] = []
        self.types: Counter[str] = Counter()
        self.empty: set[Key] = set()

    def content(self) -> Content:
        root = self._model(self.root)
        if not root.items and root.objects:
            raise InputError(f"places none of its objects ({len(root.objects)}): its build is empty")
        places = [(self._key(self.root, item, "the build"), item) for item in root.items]
        if sum(self._size(key, ()) for key, _ in places) > MOST_ELEMENTS:
            raise InputError(f"holds more than {MOST_ELEMENTS:,} triangles, counting all components; make it coarser")
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is refused with its body's name, later
            for key, item in places:
                self._place(key, item.matrix, item.part_number)
            bodies, put = joined(self.bodies, "objects")
        return Content(bodies, metres=METRES[root.unit], notes=(*self._notes(), *put))

    def _model(self, path: str) -> Model:
        if path not in self.models:
            try:
                made = read_model(self.package.pieces(path))
            except InputError as error:
                raise InputError(f"part {path[:80]!r}: {error}") from None
            self.models[path] = made
            if path != self.root:
                self._refuse_other(path, made)
        return self.models[path]

    def _refuse_other(self, path: str, made: Model) -> None:
        """A part that is not the root has the same unit, no build, and no paths of its own (production, section 3)."""
        unit = self.models[self.root].unit
        if made.unit != unit:
            raise InputError(
                f"part {path[:80]!r} is in {made.unit}, but the file in {unit}; export it again in one unit"
            )
        if made.items:
            raise InputError(f"part {path[:80]!r} has a build of its own, which it must not have; export it again")
        if any(each.path for item in made.objects.values() for each in item.components):
            raise InputError(f"part {path[:80]!r} refers to other parts, which it must not do; export it again")

    def _key(self, path: str, place: Placement, what: str) -> Key:
        key = place.path or path, place.object_id
        if key[1] not in self._model(key[0]).objects:
            raise InputError(f"damaged: {what} places {self._called(key)}, which is not there")
        return key

    def _called(self, key: Key) -> str:
        return f"object {key[1]}" + ("" if key[0] == self.root else f" of {key[0][:80]!r}")

    def _object(self, key: Key) -> Object:
        return self.models[key[0]].objects[key[1]]

    def _parts(self, key: Key) -> list[tuple[Key, Placement]]:
        return [(self._key(key[0], each, self._called(key)), each) for each in self._object(key).components]

    def _size(self, key: Key, above: tuple[Key, ...]) -> int:
        """How many triangles an object has with all its components; each that is placed counts as one more."""
        if key in above:
            raise InputError(f"damaged: {self._called(key)} has itself as a component, directly or through others")
        if len(above) > _DEEPEST:
            raise InputError(
                f"has components within components, over {_DEEPEST} deep; export it again as simple objects"
            )
        if key not in self.sizes:
            parts = sum(self._size(part, (*above, key)) for part, _ in self._parts(key))
            self.sizes[key] = 1 + parts + max(len(self._object(key).faces), len(self._object(key).vertices) // 3)
        return self.sizes[key]

    def _place(self, key: Key, matrix: Floats, name: str) -> None:
        """Add the bodies of an object; `name` is that of what it is part of."""
        made = self._object(key)
        if key not in self.used:
            self.used.add(key)
            self._refuse_wrong(key, made)
        name = made.name or name
        for part, place in self._parts(key):
            self._place(part, place.matrix @ matrix, name)
        if len(made.faces):
            self.types[made.type] += 1
            # Rows are multiplied from the left (core, section 3.3).
            self.bodies.append(body_at(name, made.vertices, made.faces, matrix[:3, :3].T, matrix[3, :3]))
        elif not made.components:
            self.empty.add(key)

    def _refuse_wrong(self, key: Key, made: Object) -> None:
        if not len(made.faces):
            if made.sliced:
                raise InputError(f"{self._called(key)} consists of slices, which are not read; export it as triangles")
            return
        low, high = int(made.faces.min()), int(made.faces.max())
        if low < 0 or high >= len(made.vertices):
            raise InputError(
                f"damaged: {self._called(key)} has a triangle that names the vertex {low if low < 0 else high:,}, but "
                f"there are {len(made.vertices):,}"
            )

    def _notes(self) -> list[str]:
        told = list(dict.fromkeys(note for model in self.models.values() for note in model.notes))
        for kind in ("support", "other"):
            if self.types[kind]:
                told.append(f"{_count(self.types[kind], 'object')} of the type {kind!r} taken like the others")
        if self.empty:
            told.append(f"{_count(len(self.empty), 'object')} without triangles left out")
        idle = [
            item
            for path, model in self.models.items()
            for number, item in model.objects.items()
            if (path, number) not in self.used and len(item.faces)
        ]
        if idle:
            names = [repr(item.name[:40]) for item in idle[:3] if item.name]
            shown = f" ({', '.join(names)}{', …' if len(idle) > len(names) else ''})" if names else ""
            told.append(f"{_count(len(idle), 'object')} that the build does not place left out{shown}")
        unread = [name for name in self.package.names() if name.endswith(".model") and name not in self.models]
        if unread:
            told.append(f"{_count(len(unread), 'model part')} that nothing refers to left out")
        return told


def _count(number: int, one: str) -> str:
    return f"{number:,} {one}{'' if number == 1 else 's'}"
