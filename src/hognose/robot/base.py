"""What the arm stands on: where its first joint is, which way it points, and what of it follows behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hognose.robot.robot import Robot

Array = NDArray[np.float64]

#: How the arm lies at rest, in its own frame.
FORWARD = (0.0, 0.0, 1.0)
#: Places this close (m) are one: in a task file coordinates may be rounded to 0.001 mm, which moves them by 0.87 µm.
SAME_PLACE = 1e-6


@dataclass(frozen=True)
class Mount:
    """The straight rigid body behind the first joint, in line with the arm's own z axis.

    Attributes
    ----------
    length, radius : m
        A length above 0.
    turns
        Whether it turns with the first link; else it keeps its direction.
    """

    length: float
    radius: float
    turns: bool


@runtime_checkable
class Base(Protocol):
    """Puts the arm's own frame, in which it lies along +z, into the frame of the task.

    Where a base is, at T steps, is said by k numbers each, its coordinates `at` (T, k): the feed alone, or a pose.
    Planning, certificate, steering, routes and pictures ask the base; nothing else names an axis.
    """

    @property
    def start(self) -> Array:
        """Position (3,) m of the first joint at feed 0, in the frame of the task."""
        ...

    @property
    def direction(self) -> Array:
        """Unit vector (3,) of the path where it comes to the entrance, in the frame of the task."""
        ...

    @property
    def run(self) -> float:
        """Length (m) of the path before the entrance: at feed 0 the arm lies on it."""
        ...

    @property
    def follows(self) -> bool:
        """Whether it takes the first joint along the path without end, so that its coordinates are poses."""
        ...

    @property
    def straight(self) -> bool:
        """Whether the arm lies straight on it at feed 0."""
        ...

    @property
    def farthest(self) -> float:
        """The feed (m) beyond which the first joint cannot be."""
        ...

    def feed_limit(self, robot: Robot) -> float:
        """The feed (m) beyond which this robot's first joint is not taken: by the base, or by the slider's travel."""
        ...

    def reach(self, robot: Robot) -> float:
        """How far (m) beyond the entrance the nose gets along a straight path; infinite where the base follows it."""
        ...

    def outside(self, places: Array) -> Array:
        """Ways (T, 3) m from where the base can take the first joint to places (T, 3) m; 0 where it can be there."""
        ...

    @property
    def mount(self) -> Mount | None:
        """What is rigidly behind the first joint and counts as the arm's own body; None if nothing does."""
        ...

    def lead(self) -> tuple[Array, Array] | None:
        """Breaks (S+1,) and coefficients (S, k+1, 3) of the path before the entrance; None for a straight one."""
        ...

    def coordinates(self, feeds: Array, joints: Array) -> Array:
        """Coordinates (T, k) at feeds (T,) m, with joints (T, n+1, 3) m on the path."""
        ...

    def settled(self, at: Array) -> Array:
        """Coordinates (T, k) as they count, of the middle of others: a quaternion in the middle of two is too short."""
        ...

    def along(self, at: Array) -> Array:
        """How far (T,) m the first joint is along the z axis of the arm's own frame."""
        ...

    def placed(self, points: Array, at: Array) -> Array:
        """Points (T, ..., 3) m of the arm's own frame, such as `Robot.joint_positions` gives, in the task's."""
        ...

    def turned(self, vectors: Array, at: Array) -> Array:
        """Vectors (T, ..., 3) of the arm's own axes in those of the task."""
        ...

    def aligned(self, vectors: Array, at: Array) -> Array:
        """Vectors (T, ..., 3) of the task's axes in the arm's own, as `Robot.angles` wants them: undoes `turned`."""
        ...

    def spin(self, low: Array, high: Array) -> Array:
        """Angular velocity (T, 3) rad, in the arm's axes at `low`, while coordinates go to high in unit time."""
        ...

    def swing(self, low: Array, high: Array) -> Array:
        """Largest acceleration (T,) m of the first joint while coordinates go from low to high in unit time."""
        ...

    def feed_at(self, point: Array, arc: float) -> tuple[float, float]:
        """Feed (m) at which the first joint is closest to a point (3,) m, at an arc length (m) of the path.

        Also how far off it is (m).
        """
        ...

    def behind(self, at: Array) -> tuple[Array, Array, Array]:
        """Ends (q, 3), (q, 3) and radii (q,) m of capsules that contain what the body behind the first joint sweeps."""
        ...


@dataclass(frozen=True, eq=False)
class Slider:
    """A straight slider, on which the arm points the way it is fed; its coordinate is the feed.

    Attributes
    ----------
    start : (3,) m
        The first joint at feed 0.
    run : m
        The straight way before the entrance, to whose end the first joint can be fed.
    length_behind, radius_behind : m
        Of the mount behind the first joint.
    R_task_base : (3, 3), optional
        A rotation, whose third column is the direction of the feed; unless given, the arm's axes are the task's.
    """

    start: Array
    run: float
    length_behind: float
    radius_behind: float
    R_task_base: Array | None = None

    @classmethod
    def before(cls, entrance: Array, robot: Robot, R_task_base: Array | None = None) -> Slider:
        """The slider on which, at feed 0, the straight arm has its nose at the entrance (3,) m.

        The mount behind the first joint is as thick as the first link.
        """
        along = np.array(FORWARD) if R_task_base is None else R_task_base[:, 2]
        start, radius = entrance - robot.length * along, float(robot.body_radii[0])
        return cls(start, robot.length, robot.spec.base_length, radius, R_task_base)

    @property
    def follows(self) -> bool:
        """See `Base.follows`: it goes along its own line."""
        return False

    @property
    def straight(self) -> bool:
        """See `Base.straight`."""
        return True

    @property
    def direction(self) -> Array:
        """See `Base.direction`."""
        return self._in_task(np.array(FORWARD))

    @property
    def farthest(self) -> float:
        """See `Base.farthest`."""
        return self.run

    def feed_limit(self, robot: Robot) -> float:
        """See `Base.feed_limit`: its travel, or the run."""
        return robot.reach

    def reach(self, robot: Robot) -> float:
        """See `Base.reach`: the run is as long as the arm, so the nose is as far as the slider."""
        return robot.reach

    def outside(self, places: Array) -> Array:
        """See `Base.outside`: only the feed is limited."""
        return np.zeros(places.shape)

    @property
    def mount(self) -> Mount | None:
        """See `Base.mount`: it never turns."""
        return Mount(self.length_behind, self.radius_behind, turns=False) if self.length_behind > 0 else None

    def lead(self) -> None:
        """See `Base.lead`: it is straight."""
        return

    def coordinates(self, feeds: Array, joints: Array) -> Array:
        """See `Base.coordinates`."""
        return feeds[:, None]

    def settled(self, at: Array) -> Array:
        """See `Base.settled`."""
        return at

    def along(self, at: Array) -> Array:
        """See `Base.along`: the feed."""
        return at[:, 0]

    def placed(self, points: Array, at: Array) -> Array:
        """See `Base.placed`."""
        return self._in_task(points) + self.start

    def turned(self, vectors: Array, at: Array) -> Array:
        """See `Base.turned`."""
        return self._in_task(vectors)

    def aligned(self, vectors: Array, at: Array) -> Array:
        """See `Base.aligned`."""
        return vectors if self.R_task_base is None else vectors @ self.R_task_base

    def spin(self, low: Array, high: Array) -> Array:
        """See `Base.spin`: it never turns."""
        return np.zeros((len(low), 3))

    def swing(self, low: Array, high: Array) -> Array:
        """See `Base.swing`: it goes straight."""
        return np.zeros(len(low))

    def feed_at(self, point: Array, arc: float) -> tuple[float, float]:
        """See `Base.feed_at`: the place on the slider's line."""
        along = self.aligned(point - self.start, np.empty(0))
        return float(along[2]), float(np.linalg.norm(along[:2]))

    def behind(self, at: Array) -> tuple[Array, Array, Array]:
        """See `Base.behind`: one piece, as the mount only slides along the run."""
        low, high = float(at.min()), float(at.max())
        first = self.start - self.direction * (self.length_behind - low)
        return first[None], (self.start + self.direction * high)[None], np.array([self.radius_behind])

    def _in_task(self, vectors: Array) -> Array:
        return vectors if self.R_task_base is None else vectors @ self.R_task_base.T


def straight_joints(base: Base, robot: Robot) -> Array:
    """Joints and tip (1, n+1, 3) m at feed 0 of an arm that lies straight on its base."""
    arcs = np.append(0.0, np.cumsum(robot.link_lengths))
    return (base.start + arcs[:, None] * base.direction)[None]


def axes_of(base: Base, at: Array) -> Array:
    """Rotations R_task_base (T, 3, 3) at coordinates (T, k)."""
    return np.swapaxes(base.turned(np.broadcast_to(np.eye(3), (len(at), 3, 3)), at), 1, 2)


def turns(base: Base, at: Array) -> Array:
    """Rotation vectors (T-1, 3) rad, in the axes of the task, from each of the coordinates (T, k) to the next."""
    return base.turned(base.spin(at[:-1], at[1:]), at[:-1])


def joints_on(base: Base, robot: Robot, angles: Array, at: Array, lengths: Array | None = None) -> Array:
    """Joints and tip (T, n+1, 3) m in the task's frame, of angles (T, n, 2) rad on a base at coordinates (T, k).

    Sections have lengths (T, n) m, or else those at rest.
    """
    return base.placed(robot.joint_positions(angles, base.along(at), lengths), at)


def angles_on(base: Base, robot: Robot, joints: Array, at: Array) -> Array:
    """Joint angles (T, n, 2) rad of joints (T, n+1, 3) m in the task's frame, on a base at coordinates (T, k)."""
    return robot.angles(base.aligned(joints, at))


def lengths_on(base: Base, robot: Robot, joints: Array, at: Array) -> Array:
    """Section lengths (T, n) m of joints (T, n+1, 3) m in the task's frame, on a base at coordinates (T, k)."""
    return robot.section_lengths(base.aligned(joints, at))


def nose_on(base: Base, robot: Robot, angles: Array, at: Array) -> Array:
    """Where the nose points: unit vectors (T, 3) in the task's frame, arguments as of `joints_on`."""
    return base.turned(robot.tip_pose(angles)[:, None, :3, 2], at)[:, 0]


def centre_line(base: Base, robot: Robot, joints: Array, at: Array, angles: Array | None = None) -> Array:
    """Ends (T, p+1, 3) m of the chords of a body whose joints (T, n+1, 3) m are given in the frame of the task.

    Its angles (T, n, 2) rad are found unless they are known.
    """
    return base.turned(robot.model.vertices(base.aligned(joints, at), angles), at)


def centre_line_on(base: Base, robot: Robot, angles: Array, at: Array, lengths: Array | None = None) -> Array:
    """As `centre_line`, of angles (T, n, 2) rad on a base at coordinates (T, k); lengths as of `joints_on`."""
    return centre_line(base, robot, joints_on(base, robot, angles, at, lengths), at, angles)


def outline(base: Base, robot: Robot, joints: Array, at: Array, angles: Array | None = None) -> Array:
    """Ends (T, c+1, 3) m of the chords of `Robot.outline`, arguments as of `centre_line`; of round bodies the same."""
    lines = robot.outline.lines
    if lines is None:
        return centre_line(base, robot, joints, at, angles)
    own = base.aligned(joints, at)
    bent = robot.angles(own) if angles is None else angles
    return base.turned(lines.place(robot.model.vertices(own, bent), bent), at)


def outline_on(base: Base, robot: Robot, angles: Array, at: Array, lengths: Array | None = None) -> Array:
    """As `outline`, of angles (T, n, 2) rad on a base at coordinates (T, k); lengths as of `joints_on`."""
    return outline(base, robot, joints_on(base, robot, angles, at, lengths), at, angles)


def mounted(base: Base, vertices: Array, at: Array) -> Array:
    """The far end of the mount in front of the ends (T, p+1, 3) m of a body's chords, as (T, p+2, 3) m.

    The base is at coordinates (T, k), of which the places do not count. Without a mount, the ends alone.
    """
    mount = base.mount
    if mount is None:
        return vertices
    behind = np.broadcast_to(-mount.length * np.array(FORWARD), (len(at), 3))
    out = np.empty((len(vertices), vertices.shape[1] + 1, 3))
    out[:, 1:] = vertices
    out[:, 0] = vertices[:, 0] + base.turned(behind, at)
    return out
