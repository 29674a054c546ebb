"""The equal-distance points of a path, among which some methods look joints up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.crossing import Sphere
from hognose.following.follower import Array
from hognose.kernels import kernel
from hognose.path import Path

#: Points as kernels take them: places (N, 3) m, their spacing in m, and the count (1,) of distances measured.
Lookup = tuple[NDArray, float, NDArray]


@kernel(inline="always")
def point_lacking(points: NDArray, index: int, sphere: Sphere) -> float:
    """How far (m) inside a sphere a point is."""
    dx, dy, dz = points[index, 0] - sphere.x, points[index, 1] - sphere.y, points[index, 2] - sphere.z
    return sphere.radius - math.sqrt(dx * dx + dy * dy + dz * dz)


def lookup_points(path: Path, spacing: float, beyond: int = 0) -> Array:
    """The points M(In) (N, 3) m of a path, and `beyond` more on its last tangent.

    Snapped joints drift by up to half a point a link, so at the end of the path the tip needs points behind it.
    """
    points = path.equal_distance_points(spacing)
    rest = path.length - spacing * (len(points) - 1)
    distances = spacing * np.arange(1, beyond + 1) - rest
    return np.concatenate([points, path.point(path.length) + distances[:, None] * path.tangent(path.length)])
