"""Obstacles at random, and slow second opinions on what the scene says about them."""

import itertools
import math

import numpy as np
from scipy.spatial.transform import Rotation

from hognose.scene import Board, Box, Cylinder, FaceHole, Hole, Pipe, Sphere, Tank

KINDS = ["sphere", "cylinder", "pipe", "box", "board", "tank"]


def random_obstacle(kind, rng):
    """An obstacle of decimetres at a random pose."""
    center, other = rng.uniform(-0.3, 0.3, (2, 3))
    turn = tuple(rng.uniform(-180, 180, 3))
    diameter = rng.uniform(0.03, 0.2)
    if kind == "sphere":
        return Sphere(center=center, diameter=diameter)
    if kind == "cylinder":
        return Cylinder(start=center, end=other, diameter=diameter)
    if kind == "pipe":
        return Pipe(start=center, end=other, diameter=diameter, wall=diameter * rng.uniform(0.05, 0.4))
    size = tuple(rng.uniform(0.25, 0.6, 3))
    if kind == "box":
        return Box(center=center, size=size, rotation_deg=turn)
    if kind == "board":
        holes = tuple(
            Hole(center=place, diameters=tuple(rng.uniform(0.03, 0.1, 2)), angle_deg=rng.uniform(0, 180))
            for place in rng.uniform(-0.06, 0.06, (2, 2))
        )
        normal, up = rng.normal(size=(2, 3))
        return Board(center=center, normal=normal, up=up, size=size[:2], thickness=rng.uniform(0.005, 0.03), hole=holes)
    holes = tuple(
        FaceHole(
            face=face,
            center=rng.uniform(-0.03, 0.03, 2),
            diameters=tuple(rng.uniform(0.03, 0.1, 2)),
            angle_deg=rng.uniform(0, 180),
        )
        for face in ("-x", "+y", "-z")
    )
    return Tank(center=center, size=size, wall=rng.uniform(0.005, 0.03), rotation_deg=turn, hole=holes)


def contains(item, points, grow=0.0):
    """Whether the analytic solid, made thicker by `grow` everywhere, contains the points."""
    if isinstance(item, Sphere):
        return np.linalg.norm(points - item.center, axis=1) <= item.diameter / 2 + grow
    if isinstance(item, Cylinder | Pipe):
        axis = np.subtract(item.end, item.start)
        length = np.linalg.norm(axis)
        height = (points - item.start) @ (axis / length)
        off = np.linalg.norm(np.cross(points - item.start, axis / length), axis=1)
        found = (np.abs(height - length / 2) <= length / 2 + grow) & (off <= item.diameter / 2 + grow)
        if isinstance(item, Pipe):
            found &= off >= item.diameter / 2 - item.wall - grow
        return found
    local = points - item.center
    if isinstance(item, Board):
        z = np.divide(item.normal, np.linalg.norm(item.normal))
        y = item.up - np.dot(item.up, z) * z
        y /= np.linalg.norm(y)
        local = np.column_stack([local @ np.cross(y, z), local @ y, local @ z])
        found = _in_box(local, (*item.size, item.thickness), grow)
        for hole in item.hole:
            found &= ~_in_hole(local[:, :2], hole, grow)
        return found
    local = Rotation.from_euler("xyz", item.rotation_deg, degrees=True).inv().apply(local)
    found = _in_box(local, item.size, grow)
    if isinstance(item, Tank):
        found &= ~_in_box(local, np.subtract(item.size, 2 * item.wall), -grow - 1e-15)
        for hole in item.hole:
            axis, side = "xyz".index(hole.face[1]), float(hole.face[0] + "1")
            across = np.delete(local, axis, axis=1)
            found &= ~(_in_hole(across, hole, grow) & (side * local[:, axis] > 0))
    return found


def _in_box(local, size, grow):
    return (np.abs(local) <= np.divide(size, 2) + grow).all(axis=1)


def _in_hole(across, hole, grow):
    turn = math.radians(hole.angle_deg)
    x, y = (across - hole.center).T
    u, v = x * math.cos(turn) + y * math.sin(turn), y * math.cos(turn) - x * math.sin(turn)
    a, b = hole.diameters if hole.diameters else (hole.diameter, hole.diameter)
    return (u / (a / 2 - grow)) ** 2 + (v / (b / 2 - grow)) ** 2 < 1


def mesh_volume(triangles):
    return np.linalg.det(triangles).sum() / 6


def mesh_area(triangles):
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return np.linalg.norm(sides, axis=1).sum() / 2


def surface_points(triangles, rng, count):
    """Points spread over a mesh, and the unit normals there."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    chosen = rng.choice(len(triangles), count, p=areas / areas.sum())
    weights = rng.dirichlet((1, 1, 1), count)
    return np.einsum("pk,pki->pi", weights, triangles[chosen]), normals[chosen] / areas[chosen, None]


# A segment and a triangle in barycentric terms: the corners that stay when a face of each is chosen.
_FACES = list(itertools.product([(0,), (1,), (0, 1)], [(0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)]))


def brute_distance(starts, ends, triangles):
    """Distances (q, m) of all segments to all triangles: the convex problem, solved on every face.

    The closest pair is inside some face of the segment and some face of the triangle; there it is the least
    squares solution. Solutions that leave their face are pulled back, which can only make them longer.
    """
    segments = np.stack([starts, ends], axis=1)
    best = np.full((len(segments), len(triangles)), np.inf)
    for on_segment, on_triangle in _FACES:
        p, a = segments[:, on_segment[0]], triangles[:, on_triangle[0]]
        d = [segments[:, i] - p for i in on_segment[1:]]
        e = [triangles[:, i] - a for i in on_triangle[1:]]
        gap = a[None] - p[:, None]
        columns = [np.broadcast_to(v[:, None], gap.shape) for v in d]
        columns += [np.broadcast_to(-v[None], gap.shape) for v in e]
        if columns:
            matrix = np.stack(columns, axis=-1)
            weights = np.einsum("qmki,qmi->qmk", np.linalg.pinv(matrix, rcond=1e-13), gap)
            weights = np.clip(weights, 0, 1)
            inner = weights[..., len(d) :]
            excess = np.maximum(inner.sum(axis=-1, keepdims=True), 1)
            weights = np.concatenate([weights[..., : len(d)], inner / excess], axis=-1)
            gap = gap - np.einsum("qmik,qmk->qmi", matrix, weights)
        best = np.minimum(best, np.linalg.norm(gap, axis=-1))
    return best
