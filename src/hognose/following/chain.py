"""The arm as a chain of universal joints on a slider that runs along the path: frames, angles, a first posture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.follower import Array
from hognose.kernels import kernel
from hognose.path import Path
from hognose.robot.kinematics import turned


@kernel()
def angles_in_frame(joints: NDArray, frame: NDArray, angles: NDArray) -> None:
    """Angles (n, 2) rad of joints (n+1, 3) m on a base whose frame has the rows x, y, z (eqs. 14–16)."""
    xx, xy, xz = frame[0, 0], frame[0, 1], frame[0, 2]
    yx, yy, yz = frame[1, 0], frame[1, 1], frame[1, 2]
    zx, zy, zz = frame[2, 0], frame[2, 1], frame[2, 2]
    for i in range(angles.shape[0]):
        dx = joints[i + 1, 0] - joints[i, 0]
        dy = joints[i + 1, 1] - joints[i, 1]
        dz = joints[i + 1, 2] - joints[i, 2]
        x, y, z = dx * xx + dy * xy + dz * xz, dx * yx + dy * yy + dz * yz, dx * zx + dy * zy + dz * zz
        angles[i, 0] = math.atan2(x, z)
        angles[i, 1] = math.atan2(-y, math.sqrt(x * x + z * z))
        xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, angles[i, 0], angles[i, 1])


@kernel()
def placed(base: NDArray, frame: NDArray, lengths: NDArray, angles: NDArray, joints: NDArray, axes: NDArray) -> None:
    """Joints (n+1, 3) m of the angles (n, 2), and the axes (n, 2, 3) about which each α and β turns the rest."""
    xx, xy, xz = frame[0, 0], frame[0, 1], frame[0, 2]
    yx, yy, yz = frame[1, 0], frame[1, 1], frame[1, 2]
    zx, zy, zz = frame[2, 0], frame[2, 1], frame[2, 2]
    joints[0] = base
    for i in range(lengths.size):
        axes[i, 0, 0], axes[i, 0, 1], axes[i, 0, 2] = yx, yy, yz
        xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, angles[i, 0], angles[i, 1])
        axes[i, 1, 0], axes[i, 1, 1], axes[i, 1, 2] = xx, xy, xz
        joints[i + 1, 0] = joints[i, 0] + lengths[i] * zx
        joints[i + 1, 1] = joints[i, 1] + lengths[i] * zy
        joints[i + 1, 2] = joints[i, 2] + lengths[i] * zz


def base_frames(path: Path, feeds: Array) -> Array:
    """Frames (T, 3, 3) with the rows x, y, z of the slider at the feeds (T,) m: z along the path, least twisted."""
    return _least_twisted(path.tangent(feeds))


def carried_frames(path: Path, feeds: Array, start: Array) -> Array:
    """As `base_frames`, of a base whose axes turn the shortest way from those at the start, (3, 3) in rows."""
    return _least_twisted(path.tangent(feeds) @ start.T) @ start


def _least_twisted(z: Array) -> Array:
    """Frames (T, 3, 3), in rows, turned the shortest way from the axes to z (T, 3)."""
    frames = np.empty((len(z), 3, 3))
    # The smallest turn of the z axis to the tangent; straight back, half a turn about x.
    w = 1.0 + z[:, 2]
    back = w < 1e-12
    w = np.where(back, 1.0, w)
    x, y = z[:, 0], z[:, 1]
    frames[:, 0] = np.stack([1 - x * x / w, -x * y / w, -x], axis=1)
    frames[:, 1] = np.stack([-x * y / w, 1 - y * y / w, -y], axis=1)
    frames[:, 2] = z
    frames[back] = np.diag([1.0, -1.0, -1.0])
    return frames


def laid_along(path: Path, lengths: Array, feed: float) -> Array:
    """Joints (n+1, 3) m of an arm whose links point from arc length to arc length of the path; a first guess."""
    arcs = feed + np.append(0.0, np.cumsum(lengths))
    inside = np.minimum(arcs, path.length)
    places = path.point(inside) + (arcs - inside)[:, None] * path.tangent(path.length)
    links = np.diff(places, axis=0)
    size = np.linalg.norm(links, axis=1, keepdims=True)
    # Where the path closes on itself after just a link there is no direction: go along it.
    ahead = path.tangent(inside[:-1])
    links = np.where(size > 0.1 * lengths[:, None], links / np.maximum(size, 1e-300), ahead) * lengths[:, None]
    return np.concatenate([places[:1], places[0] + np.cumsum(links, axis=0)])
