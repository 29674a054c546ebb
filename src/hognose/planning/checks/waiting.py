"""The criterion of an arm that waits inside, past what moves, until it is taken out again."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hognose.planning.certificate import OneChord, Passing, certify_passing, standing
from hognose.planning.checks.check import Check
from hognose.planning.checks.findings import least
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.tolerance.allowance import Allowance
from hognose.scene import MovingObstacle


def clearance_while_waiting(motion: Motion, shared: Shared) -> Iterator[Check]:
    """From the end of the insertion to a retraction at a given time, obstacles that move stay clear of the arm.

    Made of insertions where obstacles move and the task gives `motion.retraction_start_s`.
    """
    until, margin = motion.task.spec.motion.retraction_start_s, motion.task.margin
    if motion.retracts or not motion.task.moving or until is None:
        return
    arrived = float(motion.clock[-1])
    if not arrived <= until:
        early = f"`motion.retraction_start_s` is {until:g} s, but the insertion ends at {arrived:.2f} s"
        yield least(0.0, margin, detail=f"nothing is proven: {early}; give a later time")
        return
    times = np.array([arrived, until])
    closest = min(
        (proof for obstacle in motion.task.moving for proof in _past(motion, obstacle, times)),
        key=lambda proof: proof.clearance,
    )
    rounded = float(np.nan_to_num(shared.rounding[-1]).max())
    detail = f"closest to {closest.obstacle}, which moves, at {closest.time:.2f} s; the arm waits until {until:g} s"
    far = closest.clearance >= motion.horizon
    yield least(closest.clearance - rounded, margin, far, obstacle=closest.obstacle, detail=detail)


def _past(motion: Motion, obstacle: MovingObstacle, times: np.ndarray) -> Iterator[Passing]:
    """What is proven of the arm, and of its mount, that stand at the last step for an interval (2,) s."""
    task, last = motion.task, slice(-1, None)
    rest = (motion.horizon, task.margin)
    angles, at, body, line = (
        part[last].repeat(2, axis=0) for part in (motion.angles, motion.at, motion.body, motion.outline)
    )
    allowance = None if task.budget is None else Allowance.of(task.budget, task.base, angles, at, body)
    yield certify_passing(standing(line[0]), motion.robot, obstacle, times, line, *rest, allowance)
    starts, ends, radii = task.base.behind(motion.at[last])
    if task.budget is not None:
        radii = radii + task.budget.of_mount(task.base, starts, ends, radii)
    for axis, radius in zip(np.stack([starts, ends], axis=1), radii, strict=True):
        stands = axis[None].repeat(2, axis=0)
        yield certify_passing(standing(axis), OneChord(float(radius)), obstacle, times, stands, *rest)
