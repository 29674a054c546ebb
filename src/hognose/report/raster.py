"""Triangles into pixels: the nearest opaque one, and see-through ones laid over it.

Depth is decided for every pixel, so bodies may pass through holes and through each other, and long thin
triangles need no sorting. What is kept of depth is its inverse, the nearness: in perspective it is linear
over the picture, and zero is infinitely far.
"""

from __future__ import annotations

import numpy as np

from hognose.kernels import kernel


@kernel()
def _crossing(a, b, y):  # pragma: no cover - compiled
    # Always from the upper end: two triangles that share an edge then get the very same number, and
    # neither leave a gap nor paint a pixel twice.
    if a[1] > b[1]:
        a, b = b, a
    return a[0] + (y - a[1]) * ((b[0] - a[0]) / (b[1] - a[1]))


@kernel()
def _span(triangle, y, width):  # pragma: no cover - compiled
    """Return the half-open range of columns whose centres lie in the triangle, in the row centred at y."""
    left, right = np.inf, -np.inf
    for i in range(3):
        a, b = triangle[i], triangle[(i + 1) % 3]
        if (a[1] <= y) != (b[1] <= y):
            x = _crossing(a, b, y)
            left, right = min(left, x), max(right, x)
    if left > right:
        return 0, 0
    return int(max(np.ceil(left - 0.5), 0.0)), int(min(np.ceil(right - 0.5), float(width)))


@kernel()
def _rows(triangle, height):  # pragma: no cover - compiled
    top = min(triangle[0, 1], triangle[1, 1], triangle[2, 1])
    bottom = max(triangle[0, 1], triangle[1, 1], triangle[2, 1])
    return int(max(np.ceil(top - 0.5), 0.0)), int(min(np.ceil(bottom - 0.5), float(height)))


@kernel()
def _plane(triangle, nearness):  # pragma: no cover - compiled
    """Return the nearness at the picture's corner, and its change per column and per row."""
    ux, uy = triangle[1, 0] - triangle[0, 0], triangle[1, 1] - triangle[0, 1]
    vx, vy = triangle[2, 0] - triangle[0, 0], triangle[2, 1] - triangle[0, 1]
    u, v = nearness[1] - nearness[0], nearness[2] - nearness[0]
    area = ux * vy - uy * vx
    if area == 0.0:
        return nearness[0], 0.0, 0.0
    gx, gy = (u * vy - v * uy) / area, (v * ux - u * vx) / area
    return nearness[0] - gx * triangle[0, 0] - gy * triangle[0, 1], gx, gy


@kernel()
def keep_nearest(triangles, nearness, colours, image, depth):  # pragma: no cover - compiled
    """Paint opaque triangles where they are nearer than all before, in place.

    Parameters
    ----------
    triangles : (k, 3, 2) float, pixels
    nearness : (k, 3) float, 1/m
    colours : (k, 3) float
    image : (height, width, 3) float
    depth : (height, width) float, 1/m
        The nearness of what has been painted; zero for nothing.
    """
    for t in range(len(triangles)):
        w, gx, gy = _plane(triangles[t], nearness[t])
        first, last = _rows(triangles[t], image.shape[0])
        for row in range(first, last):
            start, stop = _span(triangles[t], row + 0.5, image.shape[1])
            for column in range(start, stop):
                near = w + gx * (column + 0.5) + gy * (row + 0.5)
                if near > depth[row, column]:
                    depth[row, column] = near
                    for c in range(3):
                        image[row, column, c] = colours[t, c]


@kernel()
def _open_columns(depth):  # pragma: no cover - compiled
    """Return the half-open range of columns in each row outside which the depth is negative."""
    first, last = np.full(len(depth), depth.shape[1]), np.zeros(len(depth), np.int64)
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            if depth[row, column] >= 0.0:
                first[row], last[row] = min(first[row], column), column + 1
    return first, last


@kernel()
def lay_over(triangles, nearness, colours, opacity, image, depth, front, veil):  # pragma: no cover - compiled
    """Lay see-through triangles over what they do not lie behind, in the order given, in place.

    Parameters
    ----------
    triangles, nearness, colours
        As for `keep_nearest`.
    opacity : (k,) float
        Of each triangle, 0 to 1.
    image : (height, width, 3) float
    depth : (height, width) float, 1/m
        The nearness of what is opaque; not changed. Pixels where it is negative are left alone.
    front : (height, width) float, 1/m
        The nearness of the nearest triangle that is more opaque than `veil`, kept up.
    """
    from_column, to_column = _open_columns(depth)
    for t in range(len(triangles)):
        w, gx, gy = _plane(triangles[t], nearness[t])
        first, last = _rows(triangles[t], image.shape[0])
        for row in range(first, last):
            start, stop = _span(triangles[t], row + 0.5, image.shape[1])
            for column in range(max(start, from_column[row]), min(stop, to_column[row])):
                near = w + gx * (column + 0.5) + gy * (row + 0.5)
                if near > depth[row, column] >= 0.0:
                    if opacity[t] > veil:
                        front[row, column] = max(front[row, column], near)
                    for c in range(3):
                        image[row, column, c] += opacity[t] * (colours[t, c] - image[row, column, c])


@kernel()
def shrunk(image, factor):  # pragma: no cover - compiled
    """Return a picture averaged over squares of `factor` pixels: (h f, w f, 3) -> (h, w, 3)."""
    height, width = image.shape[0] // factor, image.shape[1] // factor
    small = np.zeros((height, width, 3), image.dtype)
    for row in range(height * factor):
        for column in range(width * factor):
            for c in range(3):
                small[row // factor, column // factor, c] += image[row, column, c]
    return small / (factor * factor)
