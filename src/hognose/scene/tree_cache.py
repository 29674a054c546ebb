"""Distance trees of large scenes, kept on disk."""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

from hognose.cache_folder import cache_folder
from hognose.scene import disk_cache
from hognose.scene.tree import Tree, build_tree

#: Trees of fewer triangles than this are built in less time than it takes to read them.
WORTH_KEEPING = 50_000


def cached_tree(triangles: NDArray[np.float64], grown: NDArray[np.float64]) -> Tree:
    """Return the tree over triangles (m, 3, 3) thickened by `grown` (m,), from disk if it was built before."""
    if len(triangles) < WORTH_KEEPING or cache_folder() is None:
        return build_tree(triangles, grown)
    digest = hashlib.sha256(f"tree {disk_cache.LAYOUT} {len(triangles)}".encode())
    digest.update(np.ascontiguousarray(triangles).view(np.uint8).data)
    digest.update(np.ascontiguousarray(grown).view(np.uint8).data)
    key = digest.hexdigest()
    kept = disk_cache.recall(key)
    if kept is not None:
        return Tree(**kept)
    tree = build_tree(triangles, grown)
    disk_cache.remember(key, vars(tree))
    return tree
