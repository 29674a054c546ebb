"""What a task file says, and the task made of it: a robot, a space, way-points and how to move."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from hognose.arguments import coordinates, instance, real, several
from hognose.cached import cached_property
from hognose.mechanics import Held, Mechanics, postures, why_unknown
from hognose.path import Path
from hognose.path.constructors import checked_points
from hognose.planning.base_spec import BaseSpec
from hognose.planning.gravity import DOWN, Gravity
from hognose.planning.motion_spec import MotionSpec
from hognose.planning.out_of_place import remark_of_distance
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot import Robot
from hognose.robot.base import SAME_PLACE, Base
from hognose.scene import Box, MovingObstacle, Obstacle, Scene
from hognose.scene.imports.imported import Imported
from hognose.scene.moving import parted, parts_of
from hognose.units import Direction, FileModel, NonNegativeLength, Number, Point

#: Letters in the name of a task.
LONGEST_NAME = 80


class PathSpec(FileModel):
    """The desired path: its way-points, from the entrance to the target, or a target to which a way is searched.

    What is asked of the way besides, `via`, `tip_direction` and `keep_out`, holds for both.
    """

    way_points: Annotated[tuple[Point, ...], Field(max_length=500)] = ()
    kind: Literal["spline", "bezier", "bspline"] = "spline"
    order: Annotated[int, Field(ge=1, le=9)] = 3
    detour: bool = True
    entrance: Point = (0.0, 0.0, 0.0)
    target: Point | None = None
    via: Annotated[tuple[Point, ...], Field(max_length=20)] = ()
    tip_direction: Direction | None = None
    tip_cone_deg: Annotated[float, Field(gt=0, le=180, allow_inf_nan=False)] = 10.0
    keep_out: tuple[Box, ...] = ()

    @field_validator("way_points")
    @classmethod
    def _are_places(cls, way_points: tuple[Point, ...]) -> tuple[Point, ...]:
        if way_points:
            checked_points(way_points)
        return way_points

    @model_validator(mode="after")
    def _leads_somewhere(self) -> PathSpec:
        if self.way_points and self.target is not None:
            raise ValueError("give either `way_points` or a `target` to which a way is searched, not both")
        if self.target is None:
            if not self.way_points:
                raise ValueError("`way_points` are missing; or give a `target`, and a way to it is searched")
            if self.entrance != type(self).model_fields["entrance"].default:
                raise ValueError("`entrance` goes with a `target`; of `way_points` the first is the entrance")
        else:
            if self.kind != "spline" or self.order < 2:
                raise ValueError("a way to a `target` is a spline of order 2 or more; leave out `kind` and `order`")
            checked_points(self.stops)
        return self

    @property
    def stops(self) -> tuple[Point, ...]:
        """The places to be passed: the way-points; of a search the entrance, what is via, and the target."""
        return self.way_points if self.target is None else (self.entrance, *self.via, self.target)


class ReportSpec(FileModel):
    """What a report shows."""

    times_s: Annotated[tuple[Number, ...], Field(max_length=50)] = ()


class TaskSpec(FileModel):
    """A whole task file."""

    schema_version: Annotated[int, Field(alias="schema", ge=1, le=1)] = 1
    name: Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
    description: str = ""
    robot: Annotated[str, Field(min_length=1)]
    margin: NonNegativeLength = 0.005
    tolerance: ToleranceSpec = ToleranceSpec()
    gravity_m_s2: Gravity = DOWN
    base: BaseSpec = BaseSpec()
    path: PathSpec
    motion: MotionSpec = MotionSpec()
    report: ReportSpec = ReportSpec()
    obstacle: tuple[Obstacle, ...] = ()

    @model_validator(mode="after")
    def _knows_when(self) -> TaskSpec:
        for number, box in enumerate(self.path.keep_out, 1):
            if box.motion:
                raise ValueError(f"keep_out {number} moves; only obstacles may: make it an [[obstacle]]")
        motion = self.motion
        another = motion.profile_of(True) != motion.profile_of(False)
        if another and motion.retraction_start_s is None and any(item.motion for item in self.obstacle):
            raise ValueError(
                "obstacles move, and the retraction has another profile than the insertion: give "
                "motion.retraction_start_s, the time on the obstacles' clock at which it begins"
            )
        return self

    @property
    def direction(self) -> tuple[float, float, float]:
        """Unit vector along which the arm enters, in the frame of the task."""
        return self.base.along


@dataclass(frozen=True, eq=False)
class Task:
    """A robot, a space and a path to take through it.

    Attributes
    ----------
    spec
        What the task file says, in SI.
    robot
        The robot the spec names, resolved.
    """

    spec: TaskSpec
    robot: Robot

    def __post_init__(self) -> None:
        instance("spec", self.spec, TaskSpec, "a TaskSpec; `hognose.load_task` reads one from a file")
        instance("robot", self.robot, Robot, "a hognose.Robot")

    @property
    def name(self) -> str:
        """The task's name."""
        return self.spec.name

    @property
    def margin(self) -> float:
        """Clearance (m) the whole motion must keep, certified."""
        return self.spec.margin

    @property
    def way_points(self) -> NDArray[np.float64]:
        """Places (m, 3) m that the path must pass: entrance first, target last; of a cart, the nose before them."""
        stops, nose = np.array(self.spec.path.stops), self.nose
        return stops if nose is None else np.concatenate([nose[None], stops])

    @property
    def nose(self) -> NDArray[np.float64] | None:
        """Where (3,) m a cart has the nose of the straight arm, if the path leads from there to the entrance."""
        nose = self.spec.base.nose(self.robot)
        return None if nose is None or np.linalg.norm(nose - self.spec.path.stops[0]) <= SAME_PLACE else nose

    @cached_property
    def scene(self) -> Scene:
        """All obstacles that stand still and the boxes to be kept out of, in one distance tree."""
        boxes = enumerate(self.spec.path.keep_out, 1)
        closed = [box.model_copy(update={"name": box.name or f"keep-out {k}"}) for k, box in boxes]
        return Scene.from_obstacles((*parted(self.spec.obstacle)[0], *closed))

    @cached_property
    def moving(self) -> tuple[MovingObstacle, ...]:
        """The obstacles that move, each a scene of its own."""
        return tuple(parted(self.spec.obstacle, self.spec.tolerance.timing_s)[1])

    def with_obstacles(self, scene: Scene, moving: tuple[MovingObstacle, ...] = ()) -> Task:
        """The same task among other obstacles than its spec says: a scene that stands still, and those that move."""
        other = Task(self.spec, self.robot)
        instance("scene", scene, Scene, "a hognose.Scene")
        moving = tuple(several("moving", moving, MovingObstacle, "a list of hognose.scene.MovingObstacle"))
        vars(other).update(scene=scene, moving=moving)  # where `cached_property` keeps them
        return other

    def share_obstacles(self, other: Task) -> None:
        """Take over what was prepared of the obstacles of a task that has the same ones: large ones take long.

        Those that move are made anew if their timing is another.
        """
        instance("other", other, Task, "a hognose.Task")
        names = {"scene", "moving", "placed_scene"}
        if self.spec.tolerance.timing_s != other.spec.tolerance.timing_s:
            names.remove("moving")
        for name in names & vars(other).keys():
            vars(self).setdefault(name, vars(other)[name])

    @cached_property
    def placed_scene(self) -> Scene:
        """All obstacles as they are placed, those that move, too: for pictures."""
        if not self.moving:
            return self.scene
        return Scene.from_parts([*parts_of(self.scene), *(p for each in self.moving for p in parts_of(each.scene))])

    def scene_at(self, time: float) -> Scene:
        """All obstacles as they stand at a time (s) on the clock of those that move; that of the last time is kept.

        Raises
        ------
        InputError
            A time that is not finite.
        """
        time = real("time", time, "a number in s", math.isfinite)
        if not self.moving:
            return self.scene
        if time not in self._last_scene:
            moved = [part for each in self.moving for part in each.parts_at(time)]
            self._last_scene.clear()
            self._last_scene[time] = Scene.from_parts([*parts_of(self.scene), *moved])
        return self._last_scene[time]

    @cached_property
    def _last_scene(self) -> dict[float, Scene]:
        return {}

    @property
    def remarks(self) -> list[str]:
        """What a person should know of the files that obstacles come from, and of where those are, in sentences."""
        told = [words for item in self.spec.obstacle if isinstance(item, Imported) for words in item.remarks()]
        distant = None if self.moving else remark_of_distance(self.scene, self.way_points, self.robot)
        return told if distant is None else [*told, distant]

    @cached_property
    def base(self) -> Base:
        """What the arm stands on."""
        return self.spec.base.base(self.way_points[0], self.robot)

    @cached_property
    def clearances_wanted(self) -> NDArray[np.float64]:
        """Clearance (n,) m of every link to look for: the margin, and about what tolerances take at most."""
        return self.margin + self.taken_at_most

    @cached_property
    def taken_at_most(self) -> NDArray[np.float64]:
        """About what tolerances take (n,) m of every link's clearance at most: of the straight arm, farthest out."""
        if self.budget is None:
            return np.zeros(self.robot.sections)
        return self.budget.straight(self.base, self.way_length)

    @property
    def way_length(self) -> float:
        """Length (m) of the straight lines between the places to be passed."""
        return float(np.linalg.norm(np.diff(self.way_points, axis=0), axis=1).sum())

    @property
    def clearance_wanted(self) -> float:
        """The largest of them (m)."""
        return float(self.clearances_wanted.max())

    @cached_property
    def budget(self) -> Budget | None:
        """How far the body can be from where it is planned to be; None without tolerances."""
        return Budget.of(self.spec.tolerance, self.robot, self.base.start, self.spec.gravity_m_s2)

    @cached_property
    def mechanics(self) -> Mechanics | None:
        """The mechanics of the robot; None if they are not known."""
        return None if why_unknown(self.robot) else Mechanics.of(self.robot)

    def gravity(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gravity (T, 3) m/s² in the arm's own axes, with its base at coordinates (T, k), as `Plan.at` has them.

        Raises
        ------
        InputError
            Wrong shape, or values that are not finite.
        """
        at = self._checked(at, "T")
        return self.base.aligned(np.broadcast_to(self.spec.gravity_m_s2, (len(at), 3)), at)

    def _checked(self, at: NDArray[np.float64], rows: int | str) -> NDArray[np.float64]:
        """Coordinates of the base: the feed alone, or the pose of a carrier."""
        return coordinates("at", at, f"({rows}, {7 if self.base.follows else 1})")

    def held(
        self, angles: NDArray[np.float64], at: NDArray[np.float64], lengths: NDArray[np.float64] | None = None
    ) -> Held | None:
        """How cables hold the arm at angles (T, n, 2) rad, with its base at coordinates (T, k).

        Its sections have lengths (T, n) m. None if mechanics are not known. What was asked last is remembered.

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        if self.mechanics is None:
            return None
        angles = postures(self.robot, angles, lengths)
        at = self._checked(at, len(angles))
        key = (angles.tobytes(), at.tobytes())
        held = self._last_held.get(key)
        if held is None:
            held = self.mechanics.hold(angles, self.gravity(at))
            self._last_held.clear()
            self._last_held[key] = held
        return held

    def commanded_lengths(
        self, angles: NDArray[np.float64], at: NDArray[np.float64], lengths: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Cable lengths (T, c) m that motors command for angles (T, n, 2) rad, with the base at coordinates (T, k).

        Those of the angles, and of sections of lengths (T, n) m if that is given, without the stretch; with it, if the
        mechanics of the robot are not known. Errors as of `held`.
        """
        cables, held = self.robot.cable_lengths(angles, lengths), self.held(angles, at, lengths)
        return cables if held is None else cables - held.stretch

    @cached_property
    def _last_held(self) -> dict[tuple[bytes, bytes], Held]:
        return {}

    def path_through(self, way_points: NDArray[np.float64]) -> Path:
        """The way before the entrance, on which the arm lies at feed 0, and the task's kind of curve through (m, 3) m.

        The last one is remembered: planning, checking and showing all ask for the same.
        """
        way_points = coordinates("way_points", way_points, "(m, 3)")
        key = (way_points.shape, way_points.tobytes())
        path = self._last_path.get(key)
        if path is None:
            path = self._draw(way_points)
            self._last_path.clear()
            self._last_path[key] = path
        return path

    @cached_property
    def _last_path(self) -> dict[tuple[tuple[int, ...], bytes], Path]:
        return {}

    def _draw(self, way_points: NDArray[np.float64]) -> Path:
        spec = self.spec.path
        lead = self.base.lead()
        if spec.order == 1 and spec.kind != "bezier" and lead is None:  # a polyline leaves the run with a kink
            return Path.through(np.concatenate([self.base.start[None], way_points]), 1)
        if spec.kind == "spline":
            curve = Path.through(way_points, spec.order, self.base.direction if spec.order > 1 else None)
        elif spec.kind == "bspline":
            curve = Path.bspline(way_points, spec.order, self.base.direction)
        else:
            curve = Path.bezier(way_points, self.base.direction)
        return curve.with_run(self.base.run) if lead is None else curve.with_lead(Path(*lead))
