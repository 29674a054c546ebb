"""The plan: a whole motion, step by step, with the verdict of every check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import file_name
from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.following import Follower, body_deviation, follow, follower
from hognose.following.exact import Exact
from hognose.path import Path
from hognose.planning.task import SLIDER_DIRECTION, Task
from hognose.robot import Robot
from hognose.scene import Scene
from hognose.wording import at_least_mm, at_most, beside_limit

Array = NDArray[np.float64]

#: Clearances (m) are exact below this and lower bounds at it, unless the margin asks for more.
HORIZON = 0.05


def _from(feed: float) -> str:
    return f"{1e3 * feed:.1f}" if feed else "0"


@dataclass(frozen=True)
class Check:
    """One verdict: a figure, its limit, and the step and section that come closest to it.

    Attributes
    ----------
    value, limit
        In `unit`, as people read them. The value must not exceed the limit, or, where `at_least` is set,
        must not fall below it.
    step, section
        Row of the plan and section (1-based) of the worst case, or None where that has no meaning.
    detail
        The worst case in words.
    """

    name: str
    ok: bool
    value: float
    limit: float
    unit: str
    step: int | None = None
    section: int | None = None
    at_least: bool = False
    detail: str = ""

    @property
    def figures(self) -> tuple[str, str]:
        """Value and limit as people read them: the value rounded to the worse side, and apart if they are apart."""
        return beside_limit(self.value, self.limit, self.at_least)

    @property
    def relation(self) -> str:
        """How the value must lie to the limit; no clearance of zero is enough, even where none is asked for."""
        return "≤" if not self.at_least else "≥" if self.limit > 0 else ">"

    @property
    def sentence(self) -> str:
        """The verdict in words: what, how much, where."""
        where = [f"step {self.step}"] if self.step is not None else []
        where += [f"section {self.section}"] if self.section is not None else []
        place = f" at {', '.join(where)}" if where else ""
        value, limit = (f"{figure} {self.unit}" for figure in self.figures)
        text = f"{self.name}: {value} {self._verb} {limit}{place}"
        return f"{text} ({self.detail})" if self.detail else text

    @property
    def _verb(self) -> str:
        if self.at_least:
            return "is at least" if self.ok else "is below" if self.value < self.limit else "is not above"
        return "is within" if self.ok else "exceeds" if not self.value <= self.limit else "fails, though within"


@dataclass(frozen=True, eq=False)
class Plan:
    """A motion from the arm straight at the entrance to the tip on the target, or back, T steps long.

    Attributes
    ----------
    time, feed : (T,) s, (T,) m
    joints : (T, n+1, 3) m
        Joints and tip on the path, in the task's frame.
    angles : (T, n, 2) rad
        α and β of every section: what the arm is commanded.
    cable_lengths : (T, c) m
    motor_counts : (T, c) int
    clearance : (T, n) m
        Distance of every link's body to the obstacles with the arm at `angles`; at `horizon` a lower bound.
    way_points : (m, 3) m
        Those of the task and those the detour put between them.
    checks
        The verdicts.
    """

    task: Task
    way_points: Array
    time: Array
    feed: Array
    joints: Array
    angles: Array
    cable_lengths: Array
    motor_counts: NDArray[np.int64]
    clearance: Array
    checks: tuple[Check, ...] = field(default=())
    horizon: float = HORIZON

    @property
    def robot(self) -> Robot:
        """The robot the plan was made for."""
        return self.task.robot

    @property
    def scene(self) -> Scene:
        """The obstacles."""
        return self.task.scene

    @cached_property
    def path(self) -> Path:
        """The desired path: the slider's run and the curve through `way_points`."""
        return self.task.path_through(self.way_points)

    @property
    def retracts(self) -> bool:
        """Whether it leads from the target back to the straight arm, not the other way round."""
        return bool(self.feed[0] > self.feed[-1])

    @property
    def good(self) -> bool:
        """Whether every check was made and passed."""
        return bool(self.checks) and all(check.ok for check in self.checks)

    @cached_property
    def body(self) -> Array:
        """Joints and tip (T, n+1, 3) m where the commanded angles put them (forward kinematics, eq. 13)."""
        offset = self.task.start
        return self.robot.joint_positions(self.angles, self.feed) + offset

    @cached_property
    def follower(self) -> Follower:
        """The task's following method on this plan's path."""
        motion = self.task.spec.motion
        return follower(self.path, self.robot.link_lengths, motion.method, motion.spacing, self.robot.bend_limits)

    @cached_property
    def exact_joints(self) -> Array:
        """Joints (T, n+1, 3) m where exact following of the method's curve puts them at the same feeds."""
        if isinstance(self.follower, Exact):
            return self.joints
        return follow(self.follower.curve, self.robot.link_lengths, self.feed)

    @cached_property
    def tip_error(self) -> Array:
        """Distance (T,) m of the commanded tip from where exact following of the method's curve puts it."""
        return np.linalg.norm(self.body[:, -1] - self.exact_joints[:, -1], axis=1)

    @cached_property
    def body_deviation(self) -> Array:
        """How far (T, n) m each link leaves the path: the largest distance of points along it to the path."""
        return body_deviation(self.path, self.body)

    @property
    def slider_axis(self) -> Array:
        """The direction (3,) of the feed."""
        return np.array(SLIDER_DIRECTION)

    @property
    def certified_clearance(self) -> float | None:
        """Clearance (m) that is proven of the whole motion, however the joints move between steps.

        None if nothing was proven: the plan was not checked, or the checks came no further than the feed.
        """
        proven = [check.value for check in self.checks if check.name.startswith("certified clearance")]
        return min(proven) / 1e3 if proven else None

    def check(self, name: str) -> Check:
        """The check of this name; an InputError lists the names there are."""
        for check in self.checks:
            if isinstance(name, str) and check.name == name:
                return check
        raise InputError(
            f"name: no check is called {name!r:.60}; there are {', '.join(check.name for check in self.checks)}"
        )

    def summary(self) -> str:
        """A few lines that say what the plan does and whether it is good."""
        robot, limit = self.robot, self.horizon
        smallest = float(self.clearance.min())
        at_least = "≥ " if smallest >= limit else ""
        away = 1e3 * self.body_deviation
        way = ", on its way out" if self.retracts else ""
        lines = [
            f"{self.task.name}: {robot.name}, {robot.sections} sections, {robot.cables} cables{way}",
            f"{len(self.time) - 1} steps of {1e3 * self.task.spec.motion.step:g} mm in {self.time[-1]:.1f} s; "
            f"feed {_from(self.feed[0])} to {1e3 * self.feed[-1]:.1f} mm; "
            f"smallest clearance at the steps {at_least}{at_least_mm(smallest)} mm",
            f"body at most {at_most(away.max())} mm off the path, "
            f"{np.sqrt(np.mean(away**2)):.2f} mm in root mean square",
            *(f"note: {words}" for words in self.task.remarks),
        ]
        failed = [check for check in self.checks if not check.ok]
        if not self.checks:
            lines.append("NOT CHECKED")
        elif failed:
            lines.append(f"NOT GOOD: {len(failed)} of {len(self.checks)} checks failed")
            lines += [f"  {check.sentence}" for check in failed]
        else:
            lines.append(f"GOOD: all {len(self.checks)} checks passed")
        return "\n".join(lines)

    def verified(self, progress: Callable[[str], None] = lambda stage: None) -> Plan:
        """The same motion with every check made anew from its columns, whatever `checks` said.

        Whatever reads a plan or hands one on does this first; it takes about as long as planning.

        Parameters
        ----------
        progress
            Called with the name of each stage.

        Raises
        ------
        InputError
            A task that contradicts itself, so that nothing can be checked.
        """
        if not callable(progress):
            raise InputError("progress: expected a function that takes the name of a stage")
        from hognose.planning.checks.run import run_checks  # the checks know Plan, so Plan can know them only here

        return replace(self, checks=run_checks(self, progress))

    def save(self, path: FilePath | str) -> None:
        """Verify the plan and write it as a Parquet file that holds everything needed to check, show and run it.

        Raises
        ------
        InputError
            If the file cannot be written, or could not be read back; nothing is left half-written.
        """
        from hognose.planning import plan_file  # the file format knows Plan, so Plan can know it only here

        plan_file.save(self, file_name("path", path))

    @staticmethod
    def load(path: FilePath | str, progress: Callable[[str], None] = lambda stage: None) -> Plan:
        """Read a plan file and verify the plan: its `checks` are made anew, not those that the file holds.

        Parameters
        ----------
        path
        progress
            Called with the name of each stage.

        Raises
        ------
        InputError
            If the file is missing, cut, altered, not a plan, or of another schema.
        """
        from hognose.planning import plan_file

        return plan_file.load(file_name("path", path), progress)
