"""What could be changed about a task or its arm, more and more, so that there is a route."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from hognose.errors import HognoseError
from hognose.following import follow
from hognose.planning.base_limits import BaseLimits
from hognose.planning.checks.mechanics import why_it_cannot_begin
from hognose.planning.task import Task
from hognose.planning.unfit_base import refuse_unfit_base
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import angles_on

Values = dict[str, Any]

#: No more is taken off the body than this part of its diameter.
THINNEST = 0.6
#: No workspace is enlarged by more than this (m) on every side.
MOST_ROOM = 1.0
#: No more sections are added than the arm has, in this part.
MOST_SECTIONS = 1.0


@dataclass(frozen=True)
class Change:
    """One thing that can be changed by several amounts.

    Attributes
    ----------
    amounts
        The smallest change first; what suffices stays sufficient with a later one.
    words
        An amount in words, to be read after "with".
    made
        The task with an amount of it; None where that makes no sense.
    then
        What may be spared where an amount suffices: a change that is no larger.
    """

    amounts: tuple[float, ...]
    words: Callable[[float], str]
    made: Callable[[Task, float], Task | None]
    then: Callable[[float], Change] | None = None


def together(first: Change, second: Change) -> Change | None:
    """Two changes at once: the smallest amounts of both first, the largest of both last; None if one has none."""
    if not first.amounts or not second.amounts:
        return None
    steps, pair = max(len(first.amounts), len(second.amounts)), (first, second)

    def each(step: float) -> tuple[float, float]:
        part = step / max(steps - 1, 1)
        one, other = (change.amounts[round(part * (len(change.amounts) - 1))] for change in pair)
        return one, other

    return Change(
        tuple(float(k) for k in range(steps)),
        lambda step: _words(pair, each(step)),
        lambda task, step: _made(pair, each(step), task),
        lambda step: _sparing(pair, each(step), 0),
    )


def _sparing(pair: tuple[Change, Change], amounts: tuple[float, float], which: int) -> Change:
    """Less of one of two changes beside the other one; then less of the other."""

    def both(amount: float) -> tuple[float, float]:
        return (amount, amounts[1]) if which == 0 else (amounts[0], amount)

    known = pair[which].amounts
    return Change(
        known[: known.index(amounts[which]) + 1],
        lambda amount: _words(pair, both(amount)),
        lambda task, amount: _made(pair, both(amount), task),
        None if which else lambda amount: _sparing(pair, both(amount), 1),
    )


def _words(pair: tuple[Change, Change], amounts: tuple[float, float]) -> str:
    return " and ".join(change.words(amount) for change, amount in zip(pair, amounts, strict=True))


def _made(pair: tuple[Change, Change], amounts: tuple[float, float], task: Task) -> Task | None:
    changed = pair[0].made(task, amounts[0])
    return None if changed is None else pair[1].made(changed, amounts[1])


def narrower_margin(task: Task, half: float) -> Change:
    """Less margin, in whole mm, where a way has `half` m of room on each side."""
    taken = task.clearance_wanted - task.margin
    most = min(half - float(task.robot.body_radii.max()) - taken, task.margin - 1e-6)
    amounts = [*range(math.floor(1e3 * most + 1e-6), 0, -1)]
    if len(amounts) > 12:
        amounts = [amounts[k] for k in np.unique(np.linspace(0, len(amounts) - 1, 12).round().astype(int))]

    def made(task: Task, margin: float) -> Task:
        return varied(task, {"margin": 1e-3 * margin})

    return Change(tuple(map(float, amounts)), lambda margin: f"a margin of {margin:g} mm", made)


def thinner(task: Task, missing: float) -> Change:
    """Less body diameter, in whole mm, where `missing` m of room are missing on each side; the cables come along.

    No more than the arm bears: cables that are closer to its middle hold less.
    """
    thinnest = 2.0 * min(section.shape.radius for section in task.robot.spec.section)
    least, most = max(1, math.ceil(2e3 * missing - 1e-3)), math.floor(1e3 * THINNEST * thinnest)
    amounts = (float(k) for k in range(least, min(most, max(least + 14, 24)) + 1))

    def made(task: Task, less: float) -> Task | None:
        if task.robot.outline.flat:  # routes are searched with the round body that contains it
            return None

        def change(section: Values) -> None:
            part = 1.0 - 1e-3 * less / section["body_diameter"]
            section["body_diameter"] *= part
            for key in ("cable_radius", "passing_cable_radius"):
                if section.get(key) is not None:
                    section[key] *= part

        return _with_arm(task, change)

    def words(less: float) -> str:
        return f"{less:g} mm less body diameter ({1e3 * thinnest - less:g} mm)"

    return Change(tuple(itertools.takewhile(lambda less: _stands(made(task, less)), amounts)), words, made)


def bendier(task: Task) -> Change:
    """Joints that bend further, to whole five degrees."""
    now = np.degrees(np.abs(task.robot.bend_bounds).min())
    amounts = tuple(float(limit) for limit in range(5, 65, 5) if limit > now + 1e-6)

    def made(task: Task, limit: float) -> Task | None:
        def change(section: Values) -> None:
            given = section["bend_limit_deg"]
            bounds = given if isinstance(given, tuple | list) else (given, given)
            section["bend_limit_deg"] = tuple(max(bound, limit) for bound in bounds)
            for key in ("alpha_range_deg", "beta_range_deg"):
                if section.get(key) is not None:
                    low, high = section[key]
                    section[key] = (min(low, -limit), max(high, limit))

        return _with_arm(task, change)

    return Change(amounts, lambda limit: f"±{limit:g}° joints", made)


def longer(task: Task, over: float) -> Change:
    """More sections like the first, and a slider with as much more travel, where the arm is `over` m too short."""
    robot, slides = task.robot, task.spec.base.slides
    pitch = robot.spec.section[0].pitch
    # A slider that ends before the arm does has to be caught up with, too.
    spare = robot.reach - robot.length if slides else 0.0
    least, most = max(1, math.ceil((over + spare) / pitch - 1e-6)), max(2, round(MOST_SECTIONS * robot.sections))

    def made(task: Task, more: float) -> Task | None:
        data = task.robot.spec.model_dump(by_alias=True)
        data["section"][0]["count"] += int(more)
        if slides:
            data["feed"]["max"] = max(data["feed"]["max"], task.robot.length + more * pitch)
        return _with_spec(task, data)

    def words(more: float) -> str:
        travel = robot.length + more * pitch - robot.spec.feed.max
        slider = f", and {1e3 * travel:.0f} mm more slider travel" if slides and travel > 1e-6 else ""
        number = {1: "one more section", 2: "two more sections"}.get(int(more), f"{more:g} more sections")
        return f"{number} ({1e3 * more * pitch:.0f} mm{slider})"

    amounts = itertools.takewhile(
        lambda more: _stands(made(task, more)), (float(k) for k in range(least, min(most, least + 4) + 1))
    )
    if not slides:
        # The longer the arm, the farther it is coiled, or in front of the workspace.
        amounts = itertools.takewhile(lambda more: _can_start(made(task, more)), amounts)
    return Change(tuple(amounts), words, made)


def _stands(task: Task | None) -> bool:
    """Whether cables hold the straight arm before the entrance; so it is said of an arm that makes no sense, too."""
    return task is None or not why_it_cannot_begin(task)


def _can_start(task: Task | None) -> bool:
    """Whether the arm, with its nose at the entrance, pulls none of its cables too far."""
    if task is None:
        return False
    robot, base, feeds = task.robot, task.base, np.zeros(1)
    joints = follow(task.path_through(task.way_points), robot.link_lengths, feeds)
    travel = robot.cable_lengths(angles_on(base, robot, joints, base.coordinates(feeds, joints)))
    travel -= robot.straight_cable_lengths
    low, high = robot.spec.limits.cable_travel
    return bool(low <= travel.min() and travel.max() <= high)


def further(task: Task, over: float) -> Change | None:
    """A slider with more travel, in whole 10 mm, where it ends before the arm does; None where that is not enough.

    Or where the base is no slider.
    """
    spare = task.robot.length - task.robot.spec.feed.max
    if spare <= over or not task.spec.base.slides:
        return None
    most = 1e3 * spare
    amounts = (*np.arange(10 * math.ceil(max(1e2 * over, 1e-3)), most, 10).tolist(), most)

    def made(task: Task, more: float) -> Task | None:
        data = task.robot.spec.model_dump(by_alias=True)
        data["feed"]["max"] += 1e-3 * more
        return _with_spec(task, data)

    return Change(amounts, lambda more: f"{more:.0f} mm more slider travel", made)


def roomier(task: Task, over: float = 0.0) -> Change:
    """A larger workspace of the carrier, in steps of 50 mm on every side, where it is `over` m too small."""
    box = task.spec.base.workspace
    least = 50 * max(1, math.ceil(20 * over - 1e-6))
    amounts = () if box is None or 1e-3 * least > MOST_ROOM else tuple(float(least + k) for k in range(0, 250, 50))

    def made(task: Task, more: float) -> Task | None:
        if box is None:
            return None
        low, high = (tuple(sign * 1e-3 * more + c for c in at) for sign, at in ((-1, box.low), (1, box.high)))
        wider = box.model_copy(update={"low": low, "high": high})
        return varied(task, {"base": task.spec.base.model_copy(update={"workspace": wider})})

    return Change(amounts, lambda more: f"a base.workspace that is {more:g} mm larger on every side", made)


def slower(task: Task) -> Change:
    """A slower feed, in whole mm/s where it is not slow already."""
    motion = task.spec.motion
    now = 1e3 * motion.feed_speed
    fastest = min(now, 1e3 * BaseLimits.of(task).judged_speed)
    wanted = [fastest * part for part in (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1)]
    rounded = [math.floor(speed) if speed >= 5 else math.floor(10 * speed) / 10 for speed in wanted]
    amounts = tuple(float(speed) for speed in dict.fromkeys(rounded) if 0 < speed < now - 1e-9)

    def made(task: Task, speed: float) -> Task:
        slow = task.spec.motion.model_copy(update={"period_s": 1e3 * motion.step / speed})
        return varied(task, {"motion": slow})

    return Change(amounts, lambda speed: f"a feed of {speed:g} mm/s instead of {now:.4g} mm/s", made)


def wider_cone(task: Task) -> Change:
    """More freedom for the nose, to whole ten degrees."""
    now = task.spec.path.tip_cone_deg
    amounts = tuple(float(cone) for cone in range(10, 190, 10) if cone > now)

    def made(task: Task, cone: float) -> Task:
        return varied(task, {"path": task.spec.path.model_copy(update={"tip_cone_deg": cone})})

    return Change(amounts, lambda cone: f"tip_cone_deg = {cone:g}", made)


def varied(task: Task, changed: Values) -> Task:
    """The same task with other things in it; its obstacles stay."""
    return Task(task.spec.model_copy(update=changed), task.robot).with_obstacles(task.scene, task.moving)


def _with_arm(task: Task, change: Callable[[Values], None]) -> Task | None:
    """The same task with an arm whose sections are changed one by one."""
    data = task.robot.spec.model_dump(by_alias=True)
    for section in data["section"]:
        change(section)
    return _with_spec(task, data)


def _with_spec(task: Task, data: Values) -> Task | None:
    try:
        other = Task(task.spec, Robot.from_spec(RobotSpec.model_validate(data)))
        refuse_unfit_base(other)  # which makes it, too: a longer arm may not be coiled on the same drum
        return other.with_obstacles(task.scene, task.moving)  # large ones take long to prepare
    except (ValidationError, HognoseError):
        return None
