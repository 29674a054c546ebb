"""Where a path leads through a gap that is narrower than the body: no detour helps, and the message should say so."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.path.path import Path
from hognose.scene import Scene
from hognose.wording import beside_limit, point

Array = NDArray[np.float64]

#: Distance (m) of the places along a path that are looked at.
SPACING = 0.001
#: Wider places are looked for across the path within so many times half the width needed, in rings of places.
WITHIN, RINGS, ROUND = 2.0, 16, 24
#: What is narrower than this part of what is needed is no gap but a wall.
WALL = 0.2


def too_narrow(path: Path, scene: Scene, radius: float, start: float) -> str | None:
    """Where a path leads through a gap that a body does not fit through, in a sentence; None if it does not.

    Parameters
    ----------
    path
        As it was asked for, without detours.
    scene
    radius : m
        Of the body, with its margin.
    start : m
        Arc length before which the path is not looked at.
    """
    if not scene.names:
        return None
    arcs = np.linspace(start, path.length, max(2, int(np.ceil((path.length - start) / SPACING)) + 1))
    room = _room(scene, path.point(arcs))
    tightest = int(np.argmin(room))
    if room[tightest] >= radius:
        return None
    place, half = _widest(scene, path.point(arcs[tightest]), path.tangent(arcs[tightest]), radius)
    if not WALL * radius < half < radius:
        return None
    shown, needed = beside_limit(2e3 * half, 2e3 * radius, lower_bound=True)
    return (
        f"the body does not fit: at {point(place)}, beside {scene.witness(place, place).obstacle!r}, the way is "
        f"{shown} mm wide; the body, margin included, needs {needed} mm"
    )


def _room(scene: Scene, points: Array) -> Array:
    """Distance (p,) m of points (p, 3) to obstacles, negative inside."""
    return scene.distance(points, points).value * np.where(scene.inside(points) >= 0, -1.0, 1.0)


def _widest(scene: Scene, place: Array, tangent: Array, radius: float) -> tuple[Array, float]:
    """The widest place (3,) m across a path near one, and its distance (m) to obstacles."""
    e1 = np.cross(tangent, np.eye(3)[int(np.argmin(np.abs(tangent)))])
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(tangent, e1)
    angles = 2 * np.pi / ROUND * np.arange(ROUND)
    sides = np.cos(angles)[:, None] * e1 + np.sin(angles)[:, None] * e2
    rings = np.arange(1.0, RINGS + 1)[:, None, None] / RINGS * sides
    reach, half = WITHIN * radius, -np.inf
    for _ in range(4):
        places: Array = np.concatenate([place[None], (place + reach * rings).reshape(-1, 3)]).astype(np.float64)
        room = _room(scene, places)
        best = int(np.argmax(room))
        place, half, reach = places[best], float(room[best]), 0.15 * reach
    return place, half
