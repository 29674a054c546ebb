"""Tip steering: the operator advances and steers the nose, the path grows behind it, and the body follows.

Every move is held back before the arm comes too close, by the bound of the certificate: with d₀, d₁ the clearances of a
link at two places of the nose and m the farther way of its ends between them, it keeps (d₀ + d₁ - m) / 2 in between. A
move is halved until that proves it. Bend limits of links need no search: a path gentler than every joint that comes
along it can bend is followed by all of them, so only the steering is limited (docs/steering.md). How sections of other
kinds are moved so that it can be proven: `hognose.steering.section_way`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, instance, positive, several
from hognose.errors import InfeasibleError, InputError
from hognose.path import Path
from hognose.planning.base_limits import BaseLimits
from hognose.planning.task import Task, TaskSpec
from hognose.planning.tolerance.budget import Budget
from hognose.planning.unfit_base import refuse_unfit_base
from hognose.robot import Robot
from hognose.robot.base import Base, axes_of
from hognose.scene import Obstacle, ObstacleModel, Scene
from hognose.steering.clearance import Surroundings
from hognose.steering.grown_curve import GrownCurve, carried, on_grid
from hognose.steering.limits import CurvatureLimit, Held, cannot_follow, out_of_range, too_fast
from hognose.steering.move import Move, given_length, shortened
from hognose.steering.stand import base_at, steering_method, way_of
from hognose.steering.steered_task import SteeredTask, plan_steered, refuse_moving, spec_without_way
from hognose.steering.way import PlacedArm
from hognose.wording import mm

Array = NDArray[np.float64]

#: A turn is taken up within this part of the last link, at the sharpest.
_TURN_IN = 0.25
#: The same of sections that bend evenly along their length: within one of them they follow no change of curvature.
_SECTIONS_TURN_IN = 1.0
#: Longest piece of path, in parts of the shortest link.
_PIECE = 1 / 16
#: More (rad/m) than any joint bends; far beyond it the squares of turns overflow.
SHARPEST_TURN = 1e9


class SteeredPath:
    """An arm that is driven by its nose; it starts straight on its base, with the nose at the entrance.

    Parameters
    ----------
    robot, scene
    entrance : (3,) m
        Where the nose is at first.
    margin : m
        Clearance that the whole motion keeps, between moves too.
    period_s : s, optional
        Time one call of `advance` or `retreat` takes; with it, joint, cable and feed speeds hold moves back too. A
        carrier's speeds are those of its task, see `of`: without one, or where it does not say them, they hold nothing.
    base : optional
        A slider along +z, unless given.
    tolerances, budget : (n,) m, optional
        What is kept from every link besides the margin, for it may be off so far; and a `Budget` for the mount.
    method : optional
        How sections that are no rigid links follow the path, `aim` or `exact`; `aim` unless given. Links: `exact`.

    Attributes
    ----------
    method
        With which the arm follows.
    horizon : m
        Clearances are exact below this and lower bounds at it.

    Raises
    ------
    InputError
        A base or a method on which the arm is not steered; or the straight arm, or the mount behind it, is closer to an
        obstacle than the margin.
    """

    def __init__(
        self,
        robot: Robot,
        scene: Scene,
        entrance: ArrayLike = (0.0, 0.0, 0.0),
        margin: float = 0.005,
        period_s: float | None = None,
        base: Base | None = None,
        tolerances: ArrayLike | None = None,
        budget: Budget | None = None,
        method: str | None = None,
    ) -> None:
        self.robot = instance("robot", robot, Robot, "a hognose.Robot")
        self.scene = instance("scene", scene, Scene, "a hognose.Scene")
        self.entrance = coordinates("entrance", entrance, "(3,)")
        self.margin = given_length(margin, "margin")
        self.period_s = None if period_s is None else positive("period_s", period_s, "s")
        self._spec: TaskSpec | None = None
        self._base = base_at(self.entrance, robot, base)
        self._limits = BaseLimits(math.inf, math.inf) if self._base.follows else BaseLimits.of_feed(robot)
        self.method = steering_method(robot, method)
        self._curve = GrownCurve(self.entrance, self._base.direction, robot.link_lengths)
        self._way = way_of(robot, self._base, self._curve, self.method)
        given = np.zeros(robot.sections) if tolerances is None else tolerances
        taken = floats("tolerances", given, f"({robot.sections},)")
        self._surroundings = Surroundings(robot, self._base, scene, self.margin, taken, budget)
        self.horizon = self._surroundings.horizon
        self._curvature_limit = CurvatureLimit(robot, self._base)
        self._longest = float(on_grid(_PIECE * robot.link_lengths.min()))
        # The depth up to which path has been proven: what has grown beyond it was left by a move that was interrupted.
        self._proven = 0.0
        self._stand(self._way.arm(0.0))
        self._surroundings.refuse_start(self._arm.joints)

    @classmethod
    def of(cls, task: Task, period_s: float | None = None, method: str | None = None) -> SteeredPath:
        """The robot, space, entrance, margin and, for sections that are no links, the method of a task, unless given.

        Its way-points are not followed.
        """
        instance("task", task, Task, "a hognose.Task")
        refuse_moving(task)
        refuse_unfit_base(task)
        nose, kept = task.way_points[0], (task.taken_at_most, task.budget)
        if method is None and not task.robot.straight_links:
            method = task.spec.motion.method
        steered = cls(task.robot, task.scene, nose, task.margin, period_s, task.base, *kept, method)
        steered._spec, steered._limits = task.spec, BaseLimits.of(task)
        return steered

    @property
    def depth(self) -> float:
        """How far (m) the nose is along its path from the entrance."""
        return self._arm.depth

    @property
    def feed(self) -> float:
        """How far (m) the base has gone on: 0 with the nose at the entrance."""
        return self._arm.feed

    @property
    def joints(self) -> Array:
        """Joints and tip (n+1, 3) m; those of links are exactly on the path."""
        return self._arm.joints.copy()

    @property
    def vertices(self) -> Array:
        """Ends (p+1, 3) m of the chords of the body: the joints, and places between them of sections that bend."""
        return self._arm.vertices.copy()

    @property
    def angles(self) -> Array:
        """α and β (n, 2) rad of every section."""
        return self._arm.angles.copy()

    @property
    def clearance(self) -> Array:
        """Clearance (n,) m of every link; at `horizon` a lower bound."""
        return self._surroundings.of_sections(self._of_chords).copy()

    @property
    def tip(self) -> Array:
        """Position (3,) m of the nose."""
        return self._arm.joints[-1].copy()

    @property
    def heading(self) -> Array:
        """Direction (3,) of the path at the nose, in which it goes on; the last link is a chord behind it."""
        return self.frame[:, 2]

    @property
    def frame(self) -> Array:
        """The tip's x and y, which `turn` refers to, and the heading: columns of a rotation (3, 3).

        The orientation of the last link, turned the shortest way to look along the path.
        """
        axes = self._base.turned(self.robot.tip_pose(self._arm.angles)[None, :3, :3].swapaxes(1, 2), self._at)[0]
        along = self._curve.derivatives(self.depth)[1]
        return carried(axes, axes[2], along).T

    @property
    def R_task_base(self) -> Array:
        """Axes (3, 3) of the arm where it stands on its base, in those of the task."""
        return axes_of(self._base, self._at)[0]

    @property
    def _at(self) -> Array:
        return self._base.coordinates(np.array([self.feed]), self._arm.joints[None])

    @property
    def sharpest(self) -> float:
        """The sharpest turn (rad/m) that is taken here, for a stick pushed all the way: what all joints can follow."""
        return self._curvature_limit.at(self.depth)[0]

    @property
    def path(self) -> Path:
        """The slider's run and the path grown so far, also beyond a nose that has retreated."""
        return self._curve.path()

    def advance(self, distance: float, turn: ArrayLike | None = None) -> Move:
        """Drive the nose forward, as far as it is proven to be safe.

        Parameters
        ----------
        distance : m
            By which the nose goes along its path.
        turn : (2,) rad/m, optional
            How fast the heading turns towards the tip's x and towards its y, a metre of way. With a turn the path is
            grown anew from the nose on; without, the nose goes along what has grown before it retreated, then straight.

        Returns
        -------
        Move

        Raises
        ------
        InputError
            A distance below 0, or a turn that is not two finite numbers.
        """
        start, goal = self._arm, self.depth + float(on_grid(given_length(distance, "distance")))
        curvature, taken, limited = self._wish((0.0, 0.0) if turn is None else turn)
        held = None
        if turn is not None and goal > self.depth:
            self._proven = self.depth
        self._cut()
        if turn is None:
            held = self._glide(start, min(goal, self._proven))
        while held is None and self.depth < goal:
            end = min(goal, self.depth + self._longest)
            curvature = self._curve.grow(self._way.end(self._arm), end, curvature, self._slew)
            held = self._grown(start, end)
        return Move(self.depth - start.depth, taken, held, limited)

    def retreat(self, distance: float) -> Move:
        """Drive back along the path; the same depths give the same joints, bit for bit, and 0 the straight arm.

        Nothing but speeds (with `period_s`) ever holds it before the entrance.

        Parameters
        ----------
        distance : m

        Raises
        ------
        InputError
            A distance below 0.
        """
        start, asked = self._arm, float(on_grid(given_length(distance, "distance")))
        held = self._glide(start, max(0.0, start.depth - asked))
        if held is None and asked > start.depth:
            words = f"the arm is straight at the entrance after {mm(start.depth)} of the {mm(asked)} asked"
            held = Held("feed range", words, -1e3 * (asked - start.depth), 0.0, "mm")
        return Move(self.depth - start.depth, (0.0, 0.0), held, None)

    def task(self, name: str, obstacles: Sequence[Obstacle] | None = None, tolerance: float = 0.0005) -> SteeredTask:
        """A task whose spline through way-points is the grown path, and its plan, in which every check passed.

        Parameters
        ----------
        name
            Of the task.
        obstacles
            What the scene was made of; those of the task that this was made `of` unless given.
        tolerance : m
            Largest distance of the grown path to the spline. Way-points are added until it is kept and the plan good.

        Raises
        ------
        InputError
            Nothing has grown yet, the name does not suit, or the obstacles are not known.
        InfeasibleError
            No spline of up to 500 way-points makes a good plan; what fails is in the message.
        """
        if obstacles is not None:
            obstacles = cast("Sequence[Obstacle]", several("obstacles", obstacles, ObstacleModel, "an obstacle"))
        if obstacles is None and self._spec is None and self.scene.names:
            raise InputError(
                f"obstacles: the scene has {len(self.scene.names)}, but a scene does not tell what they were made of; "
                "give them here, or start with SteeredPath.of(task)"
            )
        spec = spec_without_way(name, self.robot, self.margin, self._spec, obstacles, self._base, self.method)
        return plan_steered(spec, self.robot, self.path, tolerance)

    @property
    def _slew(self) -> float:
        """How fast (1/m²) the curvature may change at the nose."""
        part = _TURN_IN if self.robot.straight_links else _SECTIONS_TURN_IN
        return self.sharpest / (part * float(self.robot.link_lengths[-1]))

    def _wish(self, turn: ArrayLike) -> tuple[Array, tuple[float, float], Held | None]:
        """The curvature vector (3,) 1/m of a turn, the turn that is taken, and what limited it."""
        asked = floats("turn", turn, "(2,)", "rad/m", SHARPEST_TURN)
        held = self._curvature_limit.exceeded(math.hypot(*asked), self.depth)
        if held is not None:
            asked = asked * (held.limit / held.value)
        return self.frame[:, :2] @ asked, (float(asked[0]), float(asked[1])), held

    def _stand(self, arm: PlacedArm) -> None:
        clearance = self._surroundings.clearance(arm.vertices[None])[0]
        self._arm, self._of_chords = arm, clearance

    def _glide(self, start: PlacedArm, depth: float) -> Held | None:
        """Go along path that has been proven; only speeds hold."""
        arm, held = shortened(self._way, self._arm, self._way.arm(depth), lambda arm: self._too_fast(start, arm))
        self._stand(arm)
        return held

    def _grown(self, start: PlacedArm, end: float) -> Held | None:
        """Go along the newest piece of path as far as limits and clearance allow, and drop the rest of it."""
        try:
            self._way.reach()
        except InfeasibleError as error:
            self._cut()
            return cannot_follow(error, end, self.depth)
        at_end = self._way.arm(end)
        wanted, held = shortened(
            self._way, self._arm, at_end, lambda arm: self._stopped(arm) or self._too_fast(start, arm)
        )
        proven, close = self._surroundings.proven(self._way, self.depth, self._of_chords, wanted.depth)
        self._proven = proven  # nothing before this line counts if it is not reached
        self._stand(wanted if proven == wanted.depth else self._way.arm(proven))
        self._cut()
        return held if close is None else self._surroundings.held(self._arm.vertices, close)

    def _cut(self) -> None:
        """Drop what is not proven."""
        self._curve.cut(self._proven)
        self._way.cut(self._proven)

    def _stopped(self, arm: PlacedArm) -> Held | None:
        """The end of a range that an arm is beyond, or what its mount comes too close to on the way there."""
        held = out_of_range(self.robot, self._base, arm)
        if held is not None or not self._base.follows:
            return held  # what a mount that slides passes, the first link has passed before it
        feeds, joints = np.array([self.feed, arm.feed]), np.stack([self._arm.joints, arm.joints])
        return self._surroundings.mount_held(self._base.coordinates(feeds, joints))

    def _too_fast(self, start: PlacedArm, arm: PlacedArm) -> Held | None:
        if self.period_s is None:
            return None
        return too_fast(self.robot, self._base, self._limits, start, arm, self.period_s)
