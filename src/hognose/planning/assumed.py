"""What of a motion rests on values that nobody measured or gave."""

from __future__ import annotations

from hognose.planning.base_limits import BaseLimits
from hognose.planning.motion import Motion
from hognose.wording import mm


def assumed_values(motion: Motion) -> list[str]:
    """All values that are assumed, in words: the robot's, those of the task's tolerances, and limits nobody gave.

    A tolerance counts if something is taken for it. Limits of the base that are not given count where they are used.
    """
    return [*_of_robot(motion), *_of_tolerances(motion), *_of_base(motion)]


def _of_robot(motion: Motion) -> list[str]:
    return [f"robot: {key}" for key in motion.robot.assumed if key != "tolerance" and not key.startswith("tolerance.")]


def _of_tolerances(motion: Motion) -> list[str]:
    """Parts of the budget with their values; a tolerance of the robot that the task replaces is none of them."""
    budget, spec = motion.task.budget, motion.task.spec
    given = () if budget is None else budget.given
    parts = [] if budget is None else [budget.label(name) for name in given if name in budget.assumed]
    said = [f"tolerance: {part.removesuffix(' (assumed)')}" for part in parts]
    own = any(item.timing_s is None and item.motion for item in spec.obstacle)
    if "timing_s" in spec.tolerance.assumed and spec.tolerance.timing_s > 0 and own:
        said.append(f"tolerance: timing {spec.tolerance.timing_s:g} s of moving obstacles")
    return said


def _of_base(motion: Motion) -> list[str]:
    """Limits of the base that nobody gave, where the fastest profile keeps to them."""
    if motion.task.spec.motion.profile_of(motion.retracts) != "fastest":
        return []
    limits = BaseLimits.of(motion.task)
    said = []
    if limits.speed_source:
        said.append(f"base: carrier speed {mm(limits.speed, 'g')}/s, feed.speed of the robot")
    if limits.acceleration_source:
        what = "base: carrier acceleration" if motion.task.base.follows else "robot: feed acceleration"
        said.append(f"{what} {limits.acceleration:g} m/s²")
    return said
