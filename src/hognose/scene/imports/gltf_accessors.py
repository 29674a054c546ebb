"""The numbers of a glTF file: accessors, dense and sparse.

Source: "glTF 2.0 Specification", sections 3.6.2 (accessors, their layout and bounds, sparse ones) and 3.11 (the
decoding of normalised integers).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.content import MOST_ELEMENTS, Floats, Ints
from hognose.scene.imports.gltf_buffers import Buffers
from hognose.scene.imports.gltf_document import Accessor, Document

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_UNSIGNED = (5121, 5123, 5125)
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True)
class Values:
    """What an accessor holds, not yet decoded: rows (count, width) as stored, and whether integers are fractions."""

    stored: NDArray[Any]
    normalized: bool

    def __len__(self) -> int:
        return len(self.stored)

    def decoded(self, rows: Ints | slice) -> Floats:
        """Return some rows as numbers."""
        made = self.stored[rows].astype(np.float64)
        kind = self.stored.dtype
        if self.normalized and kind.kind != "f":
            made /= np.iinfo(kind).max
            np.maximum(made, -1.0, out=made)
        return made


@dataclass(frozen=True)
class Accessors:
    """All accessors of a file. Every one that is asked for is held to the bounds of its buffer."""

    document: Document
    buffers: Buffers
    _read: dict[int, Values] = field(default_factory=dict)

    def rows(self, number: int, kind: str, use: str) -> Values:
        """Return the rows of an accessor, expected of a kind ("VEC3"), for a use that a message can name."""
        if number not in self._read:
            if number >= len(self.document.accessors):
                raise InputError(
                    f"damaged: {use} are in accessor {number}, but it has {len(self.document.accessors)} of them"
                )
            accessor = self.document.accessors[number]
            if accessor.type != kind:
                raise InputError(f"damaged: accessor {number} is of {accessor.type[:20]!r}, but {use} need {kind}")
            self._read[number] = Values(self._stored(number, accessor), accessor.normalized)
        values = self._read[number]
        if values.stored.shape[1] != _WIDTHS[kind]:
            raise InputError(f"damaged: accessor {number} is not of {kind}, which {use} need")
        return values

    def indices(self, number: int) -> Ints:
        """Return the indices of a primitive, (count,)."""
        values = self.rows(number, "SCALAR", "indices")
        accessor = self.document.accessors[number]
        if accessor.component_type not in _UNSIGNED or accessor.normalized:
            raise InputError(f"damaged: accessor {number} holds no whole numbers from 0 on, as indices need")
        return values.stored[:, 0].astype(np.int64)

    def _stored(self, number: int, accessor: Accessor) -> NDArray[Any]:
        where, width = f"accessor {number}", _WIDTHS[accessor.type]
        kind = _component(accessor.component_type, where)
        if accessor.buffer_view is not None:
            dense = self._dense(accessor.buffer_view, accessor.byte_offset, accessor.count, width, kind, where)
        elif accessor.sparse is None:
            raise InputError(f"damaged: {where} says nothing of where its numbers are")
        elif accessor.count > MOST_ELEMENTS:
            raise InputError(f"{where} has more than {MOST_ELEMENTS:,} rows; make it coarser")
        else:
            dense = np.zeros((accessor.count, width), kind)
        return dense if accessor.sparse is None else self._with_sparse(dense, accessor, where)

    def _with_sparse(self, dense: NDArray[Any], accessor: Accessor, where: str) -> NDArray[Any]:
        sparse = accessor.sparse
        assert sparse is not None
        if sparse.indices.component_type not in _UNSIGNED:
            raise InputError(f"damaged: the sparse indices of {where} are no whole numbers from 0 on")
        named, count = _component(sparse.indices.component_type, where), sparse.count
        views = sparse.indices.buffer_view, sparse.values.buffer_view
        places = self._dense(views[0], sparse.indices.byte_offset, count, 1, named, where, packed=True)
        width, kind = dense.shape[1], dense.dtype
        values = self._dense(views[1], sparse.values.byte_offset, count, width, kind, where, packed=True)
        at = places[:, 0].astype(np.int64)
        if count and (np.diff(at) <= 0).any():
            raise InputError(f"damaged: the sparse indices of {where} are not in increasing order")
        if count and at[-1] >= len(dense):
            raise InputError(f"damaged: a sparse index of {where} is {at[-1]:,}, but it has {len(dense):,} rows")
        made = dense.copy()
        made[at] = values
        return made

    def _dense(
        self, view: int, offset: int, count: int, width: int, kind: Any, where: str, *, packed: bool = False
    ) -> NDArray[Any]:
        """Rows (count, width) as they lie in a view of a buffer; `packed` ones have nothing between them."""
        if view >= len(self.document.buffer_views):
            raise InputError(
                f"damaged: {where} lies in buffer view {view}, but there are {len(self.document.buffer_views)}"
            )
        said = self.document.buffer_views[view]
        whole = self.buffers.whole(said.buffer)
        if said.byte_offset + said.byte_length > len(whole):
            raise InputError(f"damaged: buffer view {view} goes beyond the end of buffer {said.buffer}")
        kind = np.dtype(kind)
        row = width * kind.itemsize
        stride = said.byte_stride or row
        if stride < row or (packed and stride != row):
            raise InputError(f"damaged: rows of {where} are {row} bytes long, but {stride} bytes apart")
        if count and offset + (count - 1) * stride + row > said.byte_length:
            raise InputError(
                f"cut or damaged: {where} has {count:,} rows, more than the {said.byte_length:,} bytes of buffer view "
                f"{view} hold"
            )
        held = whole[said.byte_offset : said.byte_offset + said.byte_length]
        if not count:
            return np.empty((0, width), kind)
        return np.ndarray((count, width), kind, held, offset, (stride, kind.itemsize))


def _component(number: int, where: str) -> str:
    if number not in _COMPONENTS:
        raise InputError(f"{where} has the component type {number}, expected one of {', '.join(map(str, _COMPONENTS))}")
    return _COMPONENTS[number]
