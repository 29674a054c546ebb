"""Closed triangle meshes of simple solids, erring to the safe side.

Every mesh contains the solid it stands for: round outsides are circumscribed, bores and holes inscribed.
Meshes are `(m, 3, 3)` arrays in metres, wound so that normals point out of the solid, with every edge shared
by exactly two triangles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import manifold3d
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: A sphere has at most 20 × this² triangles.
MOST_SPHERE_DIVISIONS = 16
#: How far the corners of a circumscribed geodesic sphere stick out: at most this × radius / divisions².
SPHERE_EXCESS = 0.292

_FEWEST_FACETS = 16
_GOLDEN = (1 + math.sqrt(5)) / 2
_BOX_CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_BOX_FACES = np.array(
    [
        [(0, 1, 3), (0, 3, 2)],
        [(4, 6, 7), (4, 7, 5)],
        [(0, 4, 5), (0, 5, 1)],
        [(2, 3, 7), (2, 7, 6)],
        [(0, 2, 6), (0, 6, 4)],
        [(1, 5, 7), (1, 7, 3)],
    ]
).reshape(12, 3)


def facet_count(radius: float, tolerance: float) -> int:
    """Return the even number of facets, at least 16, that stay within `tolerance` of a circle.

    Parameters
    ----------
    radius
        Radius of the circle, m; for an ellipse its larger semi-axis.
    tolerance
        Largest distance between the circle and its inscribed or circumscribed polygon, m.
    """
    half_facet = math.acos(radius / (radius + tolerance))
    return max(_FEWEST_FACETS, 2 * math.ceil(math.pi / (2 * half_facet)))


def frame_along(axis: Array) -> Array:
    """Return a right-handed frame, (3, 3), whose columns are x, y and z, with z along `axis` (3,)."""
    z = axis / np.linalg.norm(axis)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def placed(triangles: Array, frame: Array, origin: Iterable[float]) -> Array:
    """Return triangles (m, 3, 3) of a local frame in the world; the frame's columns are its axes."""
    return triangles @ frame.T + np.asarray(origin, dtype=np.float64)


def box(size: tuple[float, float, float]) -> Array:
    """Return a box of edge lengths `size` (m) centred on the origin, (12, 3, 3)."""
    return (_BOX_CORNERS * size)[_BOX_FACES]


def cylinder(radius: float, length: float, tolerance: float) -> Array:
    """Return a cylinder from the origin along z with flat ends, circumscribed, (4 k, 3, 3)."""
    k = facet_count(radius, tolerance)
    rim = _circle(k) * (radius / math.cos(math.pi / k))
    bottom, top = _raised(rim, 0.0), _raised(rim, length)
    foot, head = np.zeros((1, 3)), np.array([[0.0, 0.0, length]])
    return np.concatenate([_band(bottom, top), _fan(foot, bottom[::-1]), _fan(head, top)])


def pipe(radius: float, bore: float, length: float, tolerance: float) -> Array:
    """Return a pipe from the origin along z with open ends, (8 k, 3, 3).

    The outside, of `radius`, is circumscribed; the inside, of radius `bore`, is inscribed.
    """
    k = facet_count(radius, tolerance)
    outer, inner = _circle(k) * (radius / math.cos(math.pi / k)), _circle(k) * bore
    rings = [_raised(outer, 0.0), _raised(outer, length), _raised(inner, length), _raised(inner, 0.0)]
    return np.concatenate([_band(a, b) for a, b in zip(rings, rings[1:] + rings[:1], strict=True)])


def sphere(radius: float, tolerance: float) -> Array:
    """Return a geodesic sphere round the origin whose every face plane is at least `radius` away.

    Its corners stick out by at most `tolerance`, or by `SPHERE_EXCESS` × radius / `MOST_SPHERE_DIVISIONS`²
    (0.12 % of the radius) where that is more: the number of triangles is capped at 5120.
    """
    wanted = math.ceil(math.sqrt(SPHERE_EXCESS * radius / tolerance))
    unit = _geodesic(min(max(wanted, 2), MOST_SPHERE_DIVISIONS))
    normals = np.cross(unit[:, 1] - unit[:, 0], unit[:, 2] - unit[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    nearest_plane = np.einsum("mi,mi->m", normals, unit[:, 0]).min()
    return unit * (radius / nearest_plane)


def ellipse(center: tuple[float, float], semi_axes: tuple[float, float], angle: float, tolerance: float) -> Array:
    """Return the corners (k, 2) of a polygon inscribed in an ellipse turned by `angle` (rad)."""
    c, s = math.cos(angle), math.sin(angle)
    corners = _circle(facet_count(max(semi_axes), tolerance)) * semi_axes
    return corners @ np.array([[c, s], [-s, c]]) + center


def plate(size: tuple[float, float, float], holes: Iterable[Array]) -> Array:
    """Return a plate of edge lengths `size` centred on the origin, pierced along z by polygons (k, 2)."""
    solid = manifold3d.Manifold.cube(size, center=True)
    for polygon in holes:
        solid -= _prism(polygon, -size[2], size[2])
    return _triangles(solid)


def hollow_box(size: tuple[float, float, float], wall: float, holes: Iterable[tuple[int, int, Array]]) -> Array:
    """Return a closed hollow box centred on the origin, pierced through single walls.

    Parameters
    ----------
    size
        Outer edge lengths, m.
    wall
        Wall thickness, m.
    holes
        One (axis, side, polygon) a hole: the axis 0, 1 or 2 the wall is normal to, the side -1 or +1 it is
        on, and the corners (k, 2) of the hole along the two other axes in their order.
    """
    inner = (size[0] - 2 * wall, size[1] - 2 * wall, size[2] - 2 * wall)
    solid = manifold3d.Manifold.cube(size, center=True) - manifold3d.Manifold.cube(inner, center=True)
    for axis, side, polygon in holes:
        # The prism ends in the middle of the cavity, so it reaches no other wall.
        low, high = sorted((0.0, side * size[axis]))
        solid -= _prism(polygon, low, high).transform(_upright_along(axis))
    return _triangles(solid)


def _prism(polygon: Array, low: float, high: float) -> manifold3d.Manifold:
    """Return the prism over a polygon (k, 2) between two heights; built without rounding coordinates."""
    k = len(polygon)
    middle = polygon.mean(axis=0, keepdims=True)
    corners = np.concatenate([_raised(polygon, low), _raised(polygon, high), _raised(middle, low)])
    corners = np.concatenate([corners, _raised(middle, high)])
    here = np.arange(k)
    after = np.roll(here, -1)
    faces = [
        np.column_stack([here, after, after + k]),
        np.column_stack([here, after + k, here + k]),
        np.column_stack([np.full(k, 2 * k), after, here]),
        np.column_stack([np.full(k, 2 * k + 1), here + k, after + k]),
    ]
    return manifold3d.Manifold(manifold3d.Mesh64(corners, np.concatenate(faces).astype(np.uint64)))


def _upright_along(axis: int) -> Array:
    """Return the (3, 4) map taking x, y, z to the two axes other than `axis`, in order, and `axis`."""
    across = [i for i in range(3) if i != axis]
    return np.column_stack([np.eye(3)[:, [*across, axis]], np.zeros(3)])


def _triangles(solid: manifold3d.Manifold) -> Array:
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts).astype(np.int64)]


def _circle(k: int) -> Array:
    turns = np.arange(k) * (2 * math.pi / k)
    return np.column_stack([np.cos(turns), np.sin(turns)])


def _raised(polygon: Array, height: float) -> Array:
    return np.column_stack([polygon, np.full(len(polygon), height)])


def _band(lower: Array, upper: Array) -> Array:
    """Join two rings (k, 3), running anticlockwise seen from outside and above, by 2 k triangles."""
    lower_next, upper_next = np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0)
    first = np.stack([lower, lower_next, upper_next], axis=1)
    second = np.stack([lower, upper_next, upper], axis=1)
    return np.concatenate([first, second])


def _fan(middle: Array, ring: Array) -> Array:
    around = np.broadcast_to(middle, ring.shape)
    return np.stack([around, ring, np.roll(ring, -1, axis=0)], axis=1)


def _geodesic(divisions: int) -> Array:
    """Return an icosahedron, each face divided into `divisions`² and pushed out to the unit sphere."""
    corners = np.array([np.roll((0.0, y, z * _GOLDEN), shift) for shift in range(3) for y in (-1, 1) for z in (-1, 1)])
    edge = np.linalg.norm(corners[:, None] - corners, axis=2)
    near = np.isclose(edge, 2.0)
    faces = [
        (a, b, c) for a in range(12) for b in range(a + 1, 12) for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[c, a]
    ]  # fmt: skip
    base = corners[np.array(faces)]
    inward = np.linalg.det(base) < 0
    base[inward] = base[inward][:, ::-1]
    weights = _barycentric_pieces(divisions)
    points = np.einsum("pkw,fwi->fpki", weights, base).reshape(-1, 3, 3)
    # Rounding makes the shared corners of neighbouring faces differ in the last bit; snap them together.
    points = np.round(points, 12)
    return points / np.linalg.norm(points, axis=2, keepdims=True)


def _barycentric_pieces(divisions: int) -> Array:
    """Return the weights (divisions², 3 corners, 3) of a triangle's regular division."""
    pieces = []
    for i in range(divisions):
        for j in range(divisions - i):
            pieces.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j + 1 < divisions:
                pieces.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    ij = np.array(pieces, dtype=np.float64)
    return np.concatenate([ij, divisions - ij.sum(axis=2, keepdims=True)], axis=2) / divisions
