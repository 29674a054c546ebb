"""The arm as triangles to look at: a cylinder of true diameter for each link, a ball in each joint."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.report.edges import Edges, edges_of

Floats = NDArray[np.float64]

_SIDES = 40
#: A joint's ball is a little thinner than the links, so that it shows as a neck.
_BALL = 0.86


def _unit_prism(square: bool) -> Floats:
    """Return (k, 3, 3): a circle of radius 1, or a square of side 2, from z = 0 to z = 1, normals outwards."""
    turn = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(_SIDES)], axis=-1)
    if square:
        ring /= np.abs(ring).max(axis=1, keepdims=True)
    following, up = np.roll(ring, -1, axis=0), np.array([0.0, 0.0, 1.0])
    bottom, top = np.zeros_like(ring), np.zeros_like(ring) + up
    parts = [
        (ring, following, following + up),
        (ring, following + up, ring + up),
        (following, ring, bottom),
        (ring + up, following + up, top),
    ]
    return np.concatenate([np.stack(part, axis=1) for part in parts])


def _unit_ball() -> Floats:
    """Return (k, 3, 3): radius 1 round the origin, normals outwards."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 21), np.linspace(-np.pi / 2, np.pi / 2, 11))
    grid = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    return np.concatenate([np.stack([a, b, c], -2), np.stack([a, c, d], -2)]).reshape(-1, 3, 3)


_CYLINDER, _BOX, _SPHERE = _unit_prism(square=False), _unit_prism(square=True), _unit_ball()


def link_bodies(joints: ArrayLike, radii: ArrayLike, across: ArrayLike | None = None) -> Floats:
    """Return the cylinders round the links, and the boxes of flat ones.

    Parameters
    ----------
    joints : (n + 1, 3) float, m
    radii : (n,) float, m
    across : (n, 2, 3) float, m, optional
        Half the width and half the height of flat links, as vectors; 0 of round ones.

    Returns
    -------
    triangles : (n, k, 3, 3) float, m
    """
    joints, radii = np.asarray(joints, dtype=float), np.asarray(radii, dtype=float)
    along = np.diff(joints, axis=0)
    frames = np.stack([*_across(along), along], axis=-2)
    frames[:, :2] *= radii[:, None, None]
    found = joints[:-1, None, None] + np.einsum("ktc,ncx->nktx", _CYLINDER, frames)
    if across is not None:
        flat = np.asarray(across, dtype=float).any(axis=(1, 2))
        frames[flat, :2] = np.asarray(across)[flat]
        found[flat] = joints[:-1][flat, None, None] + np.einsum("ktc,ncx->nktx", _BOX, frames[flat])
    return found


def joint_balls(joints: ArrayLike, radii: ArrayLike, smooth: ArrayLike = False) -> Floats:
    """Return the balls in the joints between links, (n - 1, k, 3, 3) m; arguments as for `link_bodies`.

    Where the body is smooth, (n - 1,) bool, they are as thick as the links and close the gap between them.
    """
    joints, radii = np.asarray(joints, dtype=float), np.asarray(radii, dtype=float)
    size = np.where(smooth, 1.0, _BALL) * np.minimum(radii[:-1], radii[1:])
    return joints[1:-1, None, None] + size[:, None, None, None] * _SPHERE


def link_edges(links: int, seamless: ArrayLike = False) -> Edges:
    """Return the edges of the bodies of that many links, flattened to one list of triangles.

    Where two of them join without a seam, (links - 1,) bool, neither has a rim.
    """
    bodies = np.broadcast_to(_CYLINDER, (links, *_CYLINDER.shape)).reshape(-1, 3, 3)
    edges = edges_of(bodies, np.repeat(np.arange(links), len(_CYLINDER)))
    seamless = np.broadcast_to(np.asarray(seamless, dtype=bool), (links - 1,))
    open_ends = np.zeros((links, 2), dtype=bool)  # of each link, at its beginning and at its end
    open_ends[1:, 0], open_ends[:-1, 1] = seamless, seamless
    link, part = np.divmod(edges.sides, len(_CYLINDER))
    end = part // _SIDES - 2  # 0 and 1 on the faces of the ends, less on the round side
    kept = ~((end >= 0) & open_ends[link, np.maximum(end, 0)]).any(axis=1)
    return Edges(edges.corners[kept], edges.sides[kept], edges.lone[kept])


def _across(along: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors across each direction (n, 3)."""
    unit = along / np.linalg.norm(along, axis=1, keepdims=True)
    # The least of the direction's components belongs to an axis that is surely not parallel to it.
    helper = np.eye(3)[np.argmin(np.abs(unit), axis=1)]
    first = np.cross(helper, unit)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(unit, first)
