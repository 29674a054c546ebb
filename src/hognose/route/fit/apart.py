"""How far links are from obstacles, and which way leads away from them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.scene import Scene

Array = NDArray[np.float64]


def apart(
    scene: Scene, starts: Array, ends: Array, upper: float, guide: Array, deepest: float
) -> tuple[Array, Array, Array]:
    """Distance (q,) m of links, the direction (q, 3) in which it grows, and where (q,) along the link it is.

    Parameters
    ----------
    scene
    starts, ends : (q, 3) m
    upper
        Distances (m) beyond this are not looked for.
    guide : (g, 3) m
        Where a link cuts a surface, the way to this curve is the one that leads out.
    deepest
        How deep (m) such a link seems to be at most.
    """
    found = scene.distance(starts, ends, upper=upper, threads=1)
    along = ends - starts
    seen = found.triangle >= 0
    on_link = np.where(seen[:, None], found.on_segment, starts)
    away = np.where(seen[:, None], on_link - found.on_mesh, 0.0)
    value = found.value.copy()
    cut = seen & (value < 1e-6)
    if cut.any():
        gap = guide[None] - on_link[cut][:, None]
        nearest = np.argmin((gap**2).sum(axis=2), axis=1)
        away[cut] = gap[np.arange(len(nearest)), nearest]
        value[cut] = -np.minimum(np.linalg.norm(away[cut], axis=1), deepest)
    size = np.linalg.norm(away, axis=1)
    fraction = ((on_link - starts) * along).sum(axis=1) / (along**2).sum(axis=1)
    return value, away / np.maximum(size, 1e-12)[:, None], np.clip(fraction, 0.0, 1.0)
