"""A perspective camera: where it stands, and where on the picture a point of the world lands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: From where a space is best seen: the insertion direction +z runs left to right, y is up.
THREE_QUARTER = (-0.84, 0.36, -0.62)
#: A picture is tipped over, so that an arm that enters upright lies along it, if it is then larger by this factor.
WORTH_TIPPING = 1.5
#: Looking back at the tip as it comes in: x to the right, y up.
FRONT = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Camera:
    """A camera without lens errors.

    Attributes
    ----------
    eye : (3,) float, m
    axes : (3, 3) float
        Rows: the picture's right, its up, and the direction of sight, in the world.
    half_height : float
        Tangent of half the vertical angle of view.
    """

    eye: Floats
    axes: Floats
    half_height: float

    def project(self, points: ArrayLike, size: tuple[int, int]) -> tuple[Floats, Floats]:
        """Return where points land on a picture, and how deep they lie.

        Parameters
        ----------
        points : (..., 3) float, m
        size
            Width and height of the picture, pixels.

        Returns
        -------
        pixels : (..., 2) float
            From the upper left corner of the picture: right and down.
        depth : (...) float, m
            Along the direction of sight; a point with a depth of zero or less has no place on a picture.
        """
        seen = (np.asarray(points, dtype=float) - self.eye) @ self.axes.T
        return pixels_of(seen, self.half_height, size), seen[..., 2]


def pixels_of(seen: Floats, half_height: float, size: tuple[int, int]) -> Floats:
    """Return the pixels (..., 2) of points (..., 3) that are given along the camera's own axes, m."""
    width, height = size
    focal = height / 2 / half_height
    depth = np.where(seen[..., 2] > 0, seen[..., 2], np.nan)
    return np.stack([width / 2 + focal * seen[..., 0] / depth, height / 2 - focal * seen[..., 1] / depth], axis=-1)


def view_axes(towards_eye: ArrayLike, up: ArrayLike = (0.0, 1.0, 0.0)) -> Floats:
    """Return the axes (right, up, sight) of a camera that stands in a direction, seen from the subject."""
    sight = -np.asarray(towards_eye, dtype=float)
    sight = sight / np.linalg.norm(sight)
    right = np.cross(sight, np.asarray(up, dtype=float))
    if np.linalg.norm(right) < 1e-9:
        right = np.cross(sight, (0.0, 0.0, 1.0) if abs(sight[2]) < 0.9 else (1.0, 0.0, 0.0))
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(right, sight), sight])


def fitted(
    points: ArrayLike,
    size: tuple[int, int],
    *,
    towards_eye: ArrayLike = THREE_QUARTER,
    up: ArrayLike = (0.0, 1.0, 0.0),
    half_angle: float = np.radians(9.0),
    border: float = 0.05,
) -> Camera:
    """Return the nearest camera in a direction that sees all points.

    Parameters
    ----------
    points : (k, 3) float, m
        What must be seen; the tighter of width and height is filled exactly.
    size
        Width and height of the picture, pixels.
    towards_eye : (3,) float
        From the subject towards the camera; its length does not matter.
    up : (3,) float
        What is up in the picture.
    half_angle
        Half the vertical angle of view, rad. Small angles distort little.
    border
        Share of the picture left free on each side.

    Notes
    -----
    Along the camera's axes, a point (x, y, z) lies within the left and right limits of a camera at
    (cx, cy, cz) when |x - cx| <= t (z - cz), t being the tangent of half the angle. Over all points this is
    max(x - t z) <= cx - t cz and max(-x - t z) <= -cx - t cz, so cz <= -(sum of both maxima) / 2 t, and cx
    is half their difference; likewise for y. The smaller cz of the two serves both.
    """
    axes = view_axes(towards_eye, up)
    x, y, z = (np.asarray(points, dtype=float).reshape(-1, 3) @ axes.T).T
    half_height = float(np.tan(half_angle))
    tangent_y = half_height * (1 - 2 * border)
    tangent_x = tangent_y * size[0] / size[1]
    centre, depth = zip(*(_closest(x, z, tangent_x), _closest(y, z, tangent_y)), strict=True)
    back = min(*depth, float(z.min()) - 1e-3)
    return Camera(np.array([*centre, back]) @ axes, axes, half_height)


def fitted_either_way(
    points: ArrayLike, size: tuple[int, int], *, towards_eye: ArrayLike, otherwise_up: ArrayLike
) -> Camera:
    """Return `fitted` with +y up; or with another direction up, if the picture is then much larger."""
    upright = fitted(points, size, towards_eye=towards_eye)
    tipped = fitted(points, size, towards_eye=towards_eye, up=otherwise_up)
    middle = np.asarray(points, dtype=float).reshape(-1, 3).mean(axis=0)
    far, near = (float(np.linalg.norm(middle - each.eye)) for each in (upright, tipped))
    return tipped if far > WORTH_TIPPING * near else upright


def _closest(x: Floats, z: Floats, tangent: float) -> tuple[float, float]:
    high, low = float(np.max(x - tangent * z)), float(np.max(-x - tangent * z))
    return (high - low) / 2, -(high + low) / (2 * tangent)
