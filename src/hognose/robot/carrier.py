"""A carrier, such as a robot arm of six axes, that takes the first joint along the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.robot.base import FORWARD, SAME_PLACE, Mount
from hognose.robot.robot import Robot
from hognose.rotations import quaternion_of_rotation

Array = NDArray[np.float64]

#: A quaternion that is as good as none.
_NO_TURN = 1e-15


@dataclass(frozen=True, eq=False)
class Carrier:
    """The first joint goes along the path, and the arm's z axis points along the first link.

    Its coordinates are a pose: the place of the first joint, x, y, z in m, and a unit quaternion w, x, y, z. The axes
    are those of the start, turned the shortest way to where the first link points. How an arm is held whose first
    section is no link, its following method says, and where: see `posed`. Between two poses the place goes
    straight, and the axes turn about one axis at a steady rate.

    Attributes
    ----------
    start : (3,) m
        The first joint at feed 0.
    run : m
        The straight way before the entrance.
    length_behind, radius_behind : m
        Of the mount behind the first joint.
    R_task_start : (3, 3)
        Axes of the arm at feed 0 in those of the task.
    workspace : (2, 3) m, optional
        The lowest and the highest corner of the box that the first joint stays in.
    """

    start: Array
    run: float
    length_behind: float
    radius_behind: float
    R_task_start: Array
    workspace: Array | None = None

    @classmethod
    def before(cls, entrance: Array, robot: Robot, R_task_start: Array, workspace: Array | None = None) -> Carrier:
        """The carrier that, at feed 0, holds the straight arm with its nose at the entrance (3,) m."""
        start, radius = entrance - robot.length * R_task_start[:, 2], float(robot.body_radii[0])
        return cls(start, robot.length, robot.spec.base_length, radius, R_task_start, workspace)

    @property
    def follows(self) -> bool:
        """See `Base.follows`."""
        return True

    @property
    def straight(self) -> bool:
        """See `Base.straight`."""
        return True

    @property
    def direction(self) -> Array:
        """See `Base.direction`."""
        return self.R_task_start @ np.array(FORWARD)

    @property
    def farthest(self) -> float:
        """See `Base.farthest`: it follows the path wherever that leads."""
        return float("inf")

    def feed_limit(self, robot: Robot) -> float:
        """See `Base.feed_limit`: none."""
        return self.farthest

    def reach(self, robot: Robot) -> float:
        """See `Base.reach`: wherever the path leads. What limits it is where the first joint can be, see `outside`."""
        return self.farthest

    def outside(self, places: Array) -> Array:
        """See `Base.outside`: beyond the workspace, by more than what makes no other place of it."""
        if self.workspace is None:
            return np.zeros(places.shape)
        away = places - np.clip(places, *self.workspace)
        return np.where(np.linalg.norm(away, axis=-1, keepdims=True) <= SAME_PLACE, 0.0, away)

    @property
    def mount(self) -> Mount | None:
        """See `Base.mount`: in line with the first link."""
        return Mount(self.length_behind, self.radius_behind, turns=True) if self.length_behind > 0 else None

    def lead(self) -> None:
        """See `Base.lead`: it is straight."""
        return

    def coordinates(self, feeds: Array, joints: Array) -> Array:
        """See `Base.coordinates`: the pose, its quaternions with signs that do not jump."""
        first = joints[:, 1] - joints[:, 0]
        along = first / np.linalg.norm(first, axis=1, keepdims=True) @ self.R_task_start  # in the axes of the start
        turn = _normalised(np.stack([1.0 + along[:, 2], -along[:, 1], along[:, 0], np.zeros(len(along))], axis=1))
        return np.concatenate(
            [joints[:, 0], _steady(_product(quaternion_of_rotation(self.R_task_start), turn))], axis=1
        )

    def posed(self, places: Array, axes: Array) -> Array:
        """Coordinates (T, 7) with the first joint at places (T, 3) m and the arm's axes (T, 3, 3), in columns."""
        return np.concatenate([places, _steady(np.array([quaternion_of_rotation(each) for each in axes]))], axis=1)

    def settled(self, at: Array) -> Array:
        """See `Base.settled`: the middle of two unit quaternions, lengthened, is half the turn."""
        return np.concatenate([at[:, :3], _normalised(at[:, 3:])], axis=1)

    def along(self, at: Array) -> Array:
        """See `Base.along`: the first joint is the origin of the arm's frame."""
        return np.zeros(len(at))

    def placed(self, points: Array, at: Array) -> Array:
        """See `Base.placed`."""
        return self.turned(points, at) + at[:, :3].reshape(len(at), *(1,) * (points.ndim - 2), 3)

    def turned(self, vectors: Array, at: Array) -> Array:
        """See `Base.turned`."""
        return np.einsum("txy,t...y->t...x", _matrix(at[:, 3:]), vectors)

    def aligned(self, vectors: Array, at: Array) -> Array:
        """See `Base.aligned`."""
        return np.einsum("txy,t...x->t...y", _matrix(at[:, 3:]), vectors)

    def spin(self, low: Array, high: Array) -> Array:
        """See `Base.spin`: the axis and angle of the turn from one pose to the other."""
        turn = _product(_normalised(low[:, 3:]) * np.array([1.0, -1.0, -1.0, -1.0]), _normalised(high[:, 3:]))
        sine = np.linalg.norm(turn[:, 1:], axis=1)
        angle = 2.0 * np.arctan2(sine, turn[:, 0])
        return turn[:, 1:] * (angle / np.maximum(sine, _NO_TURN))[:, None]

    def swing(self, low: Array, high: Array) -> Array:
        """See `Base.swing`: the first joint goes straight."""
        return np.zeros(len(low))

    def feed_at(self, point: Array, arc: float) -> tuple[float, float]:
        """See `Base.feed_at`: the first joint is anywhere on the path."""
        return arc, 0.0

    def behind(self, at: Array) -> tuple[Array, Array, Array]:
        """See `Base.behind`: two capsules for each step.

        A point of the mount is at most half its way from its place at one end of the step, and its way differs from a
        straight one by no more than an eighth of its acceleration.
        """
        back = self.placed(np.broadcast_to([0.0, 0.0, -self.length_behind], (len(at), 3)), at)
        first = at[:, :3]
        if len(at) < 2:
            return back, first, np.full(len(at), self.radius_behind)
        way = np.maximum(*(np.linalg.norm(np.diff(ends, axis=0), axis=1) for ends in (back, first)))
        turn = np.linalg.norm(self.spin(at[:-1], at[1:]), axis=1)
        radii = self.radius_behind + way / 2 + self.length_behind * turn**2 / 8
        starts, ends = (np.concatenate([side[:-1], side[1:]]) for side in (back, first))
        return starts, ends, np.concatenate([radii, radii])


def axes_of_poses(poses: Array) -> Array:
    """Rotations (T, 3, 3) of poses (T, 7): the axes of a frame in those of the task."""
    return _matrix(poses[:, 3:])


def _product(one: Array, other: Array) -> Array:
    """Products (T, 4) of quaternions (…, 4), w first."""
    w, x, y, z = np.moveaxis(one, -1, 0)
    v, a, b, c = np.moveaxis(other, -1, 0)
    return np.stack(
        [
            w * v - x * a - y * b - z * c,
            w * a + x * v + y * c - z * b,
            w * b - x * c + y * v + z * a,
            w * c + x * b - y * a + z * v,
        ],
        axis=-1,
    )


def _normalised(quaternions: Array) -> Array:
    """Unit quaternions (T, 4); where there is no direction, half a turn about x."""
    size = np.linalg.norm(quaternions, axis=1, keepdims=True)
    return np.where(size > _NO_TURN, quaternions / np.maximum(size, _NO_TURN), [0.0, 1.0, 0.0, 0.0])


def _steady(quaternions: Array) -> Array:
    """The same turns (T, 4), with signs that make neighbours close."""
    flips = np.sign((quaternions[1:] * quaternions[:-1]).sum(axis=1))
    signs = np.cumprod(np.concatenate([[1.0], np.where(flips < 0, -1.0, 1.0)]))
    return quaternions * signs[:, None]


def _matrix(quaternions: Array) -> Array:
    """Rotations (T, 3, 3) of quaternions (T, 4) of any length above 0."""
    w, x, y, z = _normalised(quaternions).T
    rows = [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip
    return np.stack(rows, axis=1).reshape(-1, 3, 3)
