"""Obstacles as meshes for other programs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import distinct
from hognose.scene import Scene
from hognose.scene.imports.content import listed

Array = NDArray[np.float64]

# A point of a cloud is drawn as an octahedron, whose corners these are, times the radius of its ball.
_CORNERS = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


@dataclass(frozen=True, eq=False)
class ObstacleMesh:
    """An obstacle, or a body of one.

    Attributes
    ----------
    name
        No two have the same.
    centre : (3,) m
        The middle of its bounds.
    vertices : (v, 3) m
        From there, so that programs with short numbers lose nothing of a mesh far away.
    faces : (m, 3) int
        Anticlockwise seen from outside.
    """

    name: str
    centre: Array
    vertices: Array
    faces: NDArray[np.int64]


def obstacle_meshes(subject: Subject) -> list[ObstacleMesh]:
    """All obstacles, those that move as they are at time 0."""
    scene = subject.scene
    first = np.searchsorted(scene.owner, np.arange(len(scene.names) + 1))
    return [
        _mesh(name, scene.triangles[first[k] : first[k + 1]], float(scene.growth[k]))
        for k, name in enumerate(distinct(scene.names))
    ]


def remarks_on_obstacles(subject: Subject) -> list[str]:
    """What of the obstacles is not in their meshes, in sentences."""
    scene, told = subject.scene, []
    if subject.moving:
        told.append(f"obstacles that move in the task ({listed(subject.moving)}) stand here where they are at time 0")
    clouds = _clouds(scene)
    if clouds.any():
        names = listed([scene.names[k] for k in np.flatnonzero(clouds)])
        told.append(f"points ({names}) are octahedra here, with their corners on the balls that they are in the task")
    thick = (scene.growth > 0) & ~clouds
    if thick.any():
        names = listed([scene.names[k] for k in np.flatnonzero(thick)])
        most = 1e3 * float(scene.growth[thick].max())
        told.append(f"meshes ({names}) are thickened on all sides in the task, by up to {most:g} mm, but not here")
    return told


def _clouds(scene: Scene) -> NDArray[np.bool_]:
    """Which obstacles (k,) are point clouds."""
    is_point = _are_points(scene.triangles)
    return np.array([bool(is_point[scene.owner == k].any()) for k in range(len(scene.names))], np.bool_)


def _are_points(triangles: Array) -> NDArray[np.bool_]:
    return (triangles[:, 0] == triangles[:, 1]).all(axis=1) & (triangles[:, 0] == triangles[:, 2]).all(axis=1)


def _mesh(name: str, triangles: Array, growth: float) -> ObstacleMesh:
    is_point = _are_points(triangles) & (growth > 0)
    balls = triangles[is_point, :1, None] + growth * _CORNERS[_FACES]
    corners = np.concatenate([triangles[~is_point], balls.reshape(-1, 3, 3)]).reshape(-1, 3)
    vertices, faces = np.unique(corners, axis=0, return_inverse=True)
    centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    return ObstacleMesh(name, centre, vertices - centre, faces.reshape(-1, 3))
