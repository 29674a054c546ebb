"""What is drawn of a scene: its triangles, and for the points of a cloud small octahedra."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from hognose.scene import Scene

Floats = NDArray[np.float64]

#: Of a cloud of more points only some are drawn, and larger.
MOST_POINTS = 4000
_CORNERS = np.concatenate([np.eye(3), -np.eye(3)])
_FACES = np.array([(x, y, z) if flip else (x, z, y) for x in (0, 3) for y in (1, 4) for z in (2, 5)
                   for flip in [((x == 0) + (y == 1) + (z == 2)) % 2 == 1]])  # fmt: skip


def drawable(scene: Scene) -> tuple[Floats, NDArray[np.integer], int]:
    """Return triangles (k, 3, 3) m to draw, the obstacle of each (k,), and how many of them, the first, have edges."""
    triangles, owner = scene.triangles, scene.owner
    is_point = (triangles[:, 0] == triangles[:, 1]).all(axis=1) & (triangles[:, 0] == triangles[:, 2]).all(axis=1)
    if not is_point.any():
        return triangles, owner, len(triangles)
    every = -(-int(is_point.sum()) // MOST_POINTS)
    chosen = np.flatnonzero(is_point)[::every]
    radius = scene.growth[owner[chosen]] * np.sqrt(every)
    balls = triangles[chosen, :1, None] + radius[:, None, None, None] * _CORNERS[_FACES]
    solid = ~is_point
    return (
        np.concatenate([triangles[solid], balls.reshape(-1, 3, 3)]),
        np.concatenate([owner[solid], owner[chosen].repeat(len(_FACES))]),
        int(solid.sum()),
    )
