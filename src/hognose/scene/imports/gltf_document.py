"""The JSON of a glTF 2.0 file with its fields checked, as far as it says where triangles are.

Source: Khronos, "glTF 2.0 Specification", version 2.0.1, section 5 (properties reference); KHR_mesh_quantization,
EXT_mesh_gpu_instancing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic.alias_generators import to_camel

from hognose.errors import InputError

#: Extensions that change or add nothing to where triangles are; of whole families, their beginnings.
_HARMLESS = (
    "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_node_",
    "KHR_xmp", "KHR_animation_", "KHR_audio", "EXT_texture_", "EXT_lights_", "EXT_mesh_features", "EXT_mesh_manifold",
    "EXT_instance_features", "EXT_structural_metadata", "CESIUM_primitive_outline", "MSFT_lod", "MSFT_texture_",
)  # fmt: skip
#: What only a decoder can read. Never passed by, required or not: what is beside it may be empty.
_COMPRESSIONS = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")

_Index = Annotated[int, Field(ge=0)]
_Number = Annotated[float, Field(allow_inf_nan=False)]


def _row(length: int) -> Any:
    return Field(default=None, min_length=length, max_length=length)


class Property(BaseModel):
    """What all properties share; fields that are of no use here are passed by."""

    model_config = ConfigDict(alias_generator=to_camel, extra="ignore", frozen=True)
    name: str = ""
    extensions: dict[str, Any] = {}


class Scene(Property):
    """Section 5.26."""

    nodes: list[_Index] = []


class Node(Property):
    """Section 5.25."""

    children: list[_Index] = []
    mesh: _Index | None = None
    skin: _Index | None = None
    matrix: list[_Number] | None = _row(16)
    translation: list[_Number] | None = _row(3)
    rotation: list[_Number] | None = _row(4)
    scale: list[_Number] | None = _row(3)
    weights: list[_Number] | None = None


class Primitive(Property):
    """Section 5.24."""

    attributes: dict[str, _Index]
    indices: _Index | None = None
    mode: int = 4
    targets: list[dict[str, _Index]] = []


class Mesh(Property):
    """Section 5.23."""

    primitives: list[Primitive]
    weights: list[_Number] = []


class SparseIndices(Property):
    """Section 5.3."""

    buffer_view: _Index
    byte_offset: _Index = 0
    component_type: int


class SparseValues(Property):
    """Section 5.4."""

    buffer_view: _Index
    byte_offset: _Index = 0


class Sparse(Property):
    """Section 5.2."""

    count: _Index
    indices: SparseIndices
    values: SparseValues


class Accessor(Property):
    """Section 5.1."""

    buffer_view: _Index | None = None
    byte_offset: _Index = 0
    component_type: int
    normalized: bool = False
    count: _Index
    type: str
    sparse: Sparse | None = None


class BufferView(Property):
    """Section 5.11."""

    buffer: _Index
    byte_offset: _Index = 0
    byte_length: _Index
    byte_stride: _Index | None = None


class Buffer(Property):
    """Section 5.10."""

    uri: str | None = None
    byte_length: _Index


class Document(Property):
    """Section 5.17: the whole."""

    extensions_used: list[str] = []
    extensions_required: list[str] = []
    scene: _Index | None = None
    scenes: list[Scene] = []
    nodes: list[Node] = []
    meshes: list[Mesh] = []
    accessors: list[Accessor] = []
    buffer_views: list[BufferView] = []
    buffers: list[Buffer] = []
    animations: list[Any] = []

    def holders(self) -> Iterator[Property]:
        """All parts whose extensions can say where triangles are."""
        yield from (self, *self.scenes, *self.nodes, *self.meshes, *self.accessors, *self.buffer_views, *self.buffers)
        yield from (primitive for mesh in self.meshes for primitive in mesh.primitives)


def document(text: bytes) -> Document:
    """Return the checked JSON of a file.

    Raises
    ------
    InputError
        It is not JSON, not glTF 2.0, has a field of another kind than the specification says, or needs an extension
        that is not read.
    """
    try:
        tree = json.loads(text, object_pairs_hook=_object, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cut, damaged, or not a glTF file: its JSON cannot be read: {_first_line(error)}") from None
    _refuse_other_versions(tree)
    try:
        made = Document.model_validate(tree)
    except (ValidationError, OverflowError) as error:
        raise InputError(f"damaged, or not a glTF file: {_complaint(error)}") from None
    _refuse_extensions(made)
    return made


def unread_extensions(made: Document) -> list[str]:
    """Extensions that hold something and are neither read nor known to be harmless, in order of their names."""
    found = {name for part in made.holders() for name in part.extensions}
    return sorted(name for name in found if not name.startswith(_HARMLESS))


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(pairs)
    if len(made) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"damaged: its JSON has {twice[:40]!r} twice in one place")
    return made


def _refuse_constant(word: str) -> None:
    raise InputError(f"damaged: its JSON holds {word}, which is no number")


def _refuse_other_versions(tree: Any) -> None:
    asset = tree.get("asset") if isinstance(tree, dict) else None
    if not isinstance(asset, dict) or not isinstance(asset.get("version"), str):
        raise InputError('not a glTF 2.0 file: it has no "asset" with a "version" (glTF 1.0 is not read)')
    said, least = asset["version"], asset.get("minVersion", "2.0")
    if said.split(".")[0] != "2" or least != "2.0":
        raise InputError(
            f"is glTF {str(said if least == '2.0' else least)[:20]}, expected 2.0; export it again as glTF 2.0"
        )


def _refuse_extensions(made: Document) -> None:
    named = {*made.extensions_used, *made.extensions_required, *(k for part in made.holders() for k in part.extensions)}
    for name in _COMPRESSIONS:
        if name in named:
            raise InputError(f"is compressed ({name}), which is not read; export it uncompressed")
    unknown = sorted(name for name in made.extensions_required if not name.startswith(_HARMLESS))
    if unknown:
        raise InputError(f"needs extensions that Hognose does not know: {', '.join(unknown)[:200]}; export it without")


def _complaint(error: ValidationError | OverflowError) -> str:
    if isinstance(error, OverflowError):
        return "a number in its JSON is too large"
    first = error.errors(include_url=False, include_input=False)[0]
    place = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in first["loc"]).lstrip(".")
    return f"{place}: {first['msg'][:1].lower()}{first['msg'][1:]}"


def _first_line(error: Exception) -> str:
    return "it is nested too deep" if isinstance(error, RecursionError) else str(error).splitlines()[0][:120]
