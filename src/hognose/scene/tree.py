"""The bounding-volume tree over a scene's triangles, flat in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.scene.faces import face_rows

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

_LEAF_SIZE = 4
_BINS = 16
# Below this depth splits are by the median, which bounds the depth and with it the search's stack.
_SURFACE_DEPTH = 32

_STACK = 80


@kernel(error_model="numpy")
def _divide(low, high, order, first, last, depth, bins, held, costs):
    """Reorder the triangles first … last - 1 into two groups; return where the second begins.

    The cheapest of the splits between equal bins of the middles, by surface area times number; the median
    where that has no answer or the tree is deep already.
    """
    best, best_axis, best_cut, best_start, best_scale = np.inf, -1, 0, 0.0, 0.0
    for axis in range(3):
        start, stop = np.inf, -np.inf
        for k in range(first, last):
            middle = low[order[k], axis] + high[order[k], axis]
            start, stop = min(start, middle), max(stop, middle)
        if not stop > start or depth >= _SURFACE_DEPTH:
            continue
        scale = _BINS * (1.0 - 1e-9) / (stop - start)
        for at in range(_BINS):
            held[at] = 0
            for i in range(3):
                bins[at, i], bins[at, i + 3] = np.inf, -np.inf
        for k in range(first, last):
            triangle = order[k]
            at = int((low[triangle, axis] + high[triangle, axis] - start) * scale)
            held[at] += 1
            for i in range(3):
                bins[at, i] = min(bins[at, i], low[triangle, i])
                bins[at, i + 3] = max(bins[at, i + 3], high[triangle, i])
        for turn in range(2):  # costs of what lies below each cut, then of what lies above it
            x0, y0, z0, x1, y1, z1, sum_held = np.inf, np.inf, np.inf, -np.inf, -np.inf, -np.inf, 0
            for step in range(_BINS - 1):
                at = step if turn == 0 else _BINS - 1 - step
                cut = at + 1 if turn == 0 else at
                x0, y0, z0 = min(x0, bins[at, 0]), min(y0, bins[at, 1]), min(z0, bins[at, 2])
                x1, y1, z1 = max(x1, bins[at, 3]), max(y1, bins[at, 4]), max(z1, bins[at, 5])
                sum_held += held[at]
                x, y, z = x1 - x0, y1 - y0, z1 - z0
                cost = (x * y + y * z + z * x) * sum_held if sum_held > 0 else np.inf
                costs[cut] = cost if turn == 0 else costs[cut] + cost
        for cut in range(1, _BINS):
            if costs[cut] < best:
                best, best_axis, best_cut, best_start, best_scale = costs[cut], axis, cut, start, scale
    if best_axis < 0:
        return (first + last) // 2
    left = first
    for k in range(first, last):
        triangle = order[k]
        if int((low[triangle, best_axis] + high[triangle, best_axis] - best_start) * best_scale) < best_cut:
            order[k], order[left] = order[left], triangle
            left += 1
    return left


@kernel(error_model="numpy")
def _build(low, high, order, boxes, child):
    """Fill the tree over boxes low, high (k, 3), k > 0; return its number of nodes."""
    bins, held, costs = np.empty((_BINS, 6)), np.empty(_BINS, np.int64), np.empty(_BINS)
    spans = np.empty((_STACK, 4), np.int64)  # first triangle, past the last, node, depth
    total = len(low)
    spans[0, 0], spans[0, 1], spans[0, 2], spans[0, 3] = 0, total, 0, 0
    nodes, waiting = 1, 1
    while waiting > 0:
        waiting -= 1
        first, last, node, depth = spans[waiting, 0], spans[waiting, 1], spans[waiting, 2], spans[waiting, 3]
        middle = _divide(low, high, order, first, last, depth, bins, held, costs)
        for side in range(2):
            begin, end = (first, middle) if side == 0 else (middle, last)
            if total == 1:
                begin, end = 0, 1
            for axis in range(3):
                bottom, top = np.inf, -np.inf
                for k in range(begin, end):
                    bottom = min(bottom, low[order[k], axis])
                    top = max(top, high[order[k], axis])
                boxes[node, 6 * side + axis] = 0.5 * (bottom + top)
                boxes[node, 6 * side + axis + 3] = 0.5 * (top - bottom)
            if end - begin <= _LEAF_SIZE:
                child[node, side] = -1 - (4 * begin + end - begin - 1)
                continue
            child[node, side] = nodes
            spans[waiting, 0], spans[waiting, 1] = begin, end
            spans[waiting, 2], spans[waiting, 3] = nodes, depth + 1
            waiting += 1
            nodes += 1
    return nodes


@dataclass(frozen=True, eq=False)
class Tree:
    """A binary tree of boxes, flat in memory; each node carries the boxes of its two children.

    Attributes
    ----------
    boxes : (nodes, 12)
        Middle and half extent of the first child's box, then of the second child's, m.
    child : (nodes, 2) int32
        The child's node; or, for a leaf of 1 to 4 faces, -1 - (4 × its first face + their number - 1).
    faces : (m, 16)
        The triangles as the search reads them, leaf after leaf; see `faces.face_rows`.
    grown : (m,)
        How far each face is thickened on all sides, m; empty if none is.
    triangle : (m,) int32
        Each face's triangle.
    """

    boxes: Floats
    child: Ints
    faces: Floats
    grown: Floats
    triangle: Ints

    @property
    def arrays(self) -> tuple[Floats, Ints, Floats, Floats, Ints]:
        """All of them, in the order in which the searches take them."""
        return self.boxes, self.child, self.faces, self.grown, self.triangle


def build_tree(triangles: Floats, grown: Floats) -> Tree:
    """Return the tree over triangles (m, 3, 3), m > 0, thickened by `grown` (m,); they may be degenerate."""
    m = len(triangles)
    low, high = triangles.min(axis=1) - grown[:, None], triangles.max(axis=1) + grown[:, None]
    order, boxes, child = np.arange(m, dtype=np.int32), np.empty((m, 12)), np.empty((m, 2), np.int32)
    nodes = _build(low, high, order, boxes, child)
    faces, thick = face_rows(triangles[order], grown[order]), grown[order] if grown.any() else np.empty(0)
    return Tree(boxes[:nodes].copy(), child[:nodes].copy(), faces, thick, order)
