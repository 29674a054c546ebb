"""From a task to a plan: the flowchart of paper figure 6."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError, InputError
from hognose.following import Follower
from hognose.following.on_base import run_on
from hognose.path import Path
from hognose.path.bottleneck import too_narrow
from hognose.path.detour import lead_round
from hognose.planning import timing
from hognose.planning.advice import of_tolerances
from hognose.planning.arrival import arrival
from hognose.planning.checks.run import run_checks
from hognose.planning.followed import method_of
from hognose.planning.motion import HORIZON
from hognose.planning.motion_spec import LONGEST_MOTION, Profile
from hognose.planning.past_moving import led_past, refuse_covered_start
from hognose.planning.penetration import clearance_of_all
from hognose.planning.places import places
from hognose.planning.plan import Plan
from hognose.planning.profile import Fastest
from hognose.planning.room_for_tolerances import refuse_wide_tolerances
from hognose.planning.task import Task
from hognose.planning.unfit_base import refuse_distant_target, refuse_unfit_base
from hognose.robot.base import angles_on, lengths_on, outline_on
from hognose.threads import together
from hognose.wording import point

Array = NDArray[np.float64]
Progress = Callable[[str], None]

#: Clearances are exact up to so much (m) more than the margin at least.
BEYOND_MARGIN = 0.01
#: A plan of more positions of joints than this is a mistake in the step: it would take minutes and gigabytes.
MOST_POSITIONS = 3_000_000
#: Detours may make the way this many times as long as the arm before they come clear.
MOST_ROUNDABOUT = 4.0


def plan_along(task: Task, progress: Progress = lambda stage: None, way_points: Array | None = None) -> Plan:
    """Plan an insertion along the task's path, or through given way-points, and check it.

    It goes from the arm straight at the entrance to the tip on the target. No route is searched;
    `hognose.route.plan` does that.

    Parameters
    ----------
    task, progress
        As of `hognose.plan`.
    way_points : (m, 3) m, optional
        Those that a search found: the path is drawn through them as they are, without detours.

    Returns
    -------
    Plan
        All of its checks passed.

    Raises
    ------
    InputError
        The task contradicts itself: the arm starts inside an obstacle, a step that makes too many set-points.
    InfeasibleError
        No good motion: what fails, by how much and where. Its `plan` holds the motion as far as it was made.
    """
    given = way_points is not None
    progress("drawing the path")
    _refuse_coarse_step(task)
    refuse_buried_places(task)
    refuse_wide_tolerances(task)
    refuse_distant_target(task)
    try:
        if way_points is None:
            way_points, path = desired_path(task)
        else:
            path = task.path_through(way_points)
        progress("following the path")
        method = method_of(task, path)
        length = arrival(task, method.curve)
    except InfeasibleError as error:
        raise _no_detour(task, error) from None
    result = insertion_plan(task, way_points, method, length, task.spec.motion.profile, progress)
    result = dataclasses.replace(result, checks=run_checks(result, progress, result.clearance))
    if not result.good:
        failed = [check.sentence for check in result.checks if check.failed]
        failed += filter(None, [of_tolerances(result)])
        error = InfeasibleError(f"{task.name}: no good motion.\n  " + "\n  ".join(failed), result)
        if given:
            raise error
        return _evading(result, error, progress)
    return result


def _evading(plan: Plan, error: InfeasibleError, progress: Progress) -> Plan:
    """A plan past the moving obstacles that this one meets; the error, with advice, if it meets none or none is found.

    Before a plan is made its times are not known.
    """
    task, moving = plan.task, [each.name for each in plan.task.moving]
    met = [name for name in moving if any(check.failed and check.obstacle == name for check in plan.checks)]
    if not met:
        raise error
    if all(check.key == "clearance_of_mount" for check in plan.checks if check.failed and check.obstacle in met):
        raise InfeasibleError(
            f"{error}\n  {' and '.join(map(repr, met))} moves into the way of the mount behind the first joint, and "
            "detours are only sought for the arm. Change when it comes (`time_s` of its `motion`) or when the arm does "
            "(`motion.period_s`).",
            plan,
        )
    way_points = None
    if task.spec.path.detour:
        progress("looking for a way past what moves")
        way_points = led_past(plan)
    if way_points is not None:
        with suppress(InfeasibleError):  # else the plan as it was asked for tells more
            return plan_along(task, progress, way_points)
    tried = "no detour leads past it" if task.spec.path.detour else "detours are switched off (path.detour)"
    raise InfeasibleError(
        f"{error}\n  {' and '.join(map(repr, met))} moves into the arm's way, and {tried}. Put a way-point beside, "
        "change when it comes (`time_s` of its `motion`) or when the arm does (`motion.period_s`), or give a `target` "
        "in place of `way_points`, so that a route is searched.",
        plan,
    )


def insertion_plan(
    task: Task, way_points: Array, method: Follower, length: float, profile: Profile, progress: Progress
) -> Plan:
    """The plan, not checked yet, of an insertion on the path through way-points, up to a feed (m), with a profile."""
    robot = task.robot
    if profile == "fastest":
        points = Fastest(task, method, length).set_points(MOST_POSITIONS // (robot.sections + 1))
    else:
        points = _constant(task, length)
    joints, at = run_on(task.base, method, points.feed)
    angles = angles_on(task.base, robot, joints, at)
    sections = lengths_on(task.base, robot, joints, at)
    cable_lengths = robot.cable_lengths(angles, sections)
    if profile == "constant":
        points = _ending_softly(task, points, angles, sections, at)
    progress("measuring clearance")
    horizon, line = horizon_of(task), outline_on(task.base, robot, angles, at, sections)
    held, clearance = together(
        lambda: task.held(angles, at, sections),
        lambda: clearance_of_all(task.scene, task.moving, robot, line, horizon, points.time),
    )
    return Plan(
        task=task,
        way_points=way_points,
        time=points.time,
        feed=points.feed,
        joints=joints,
        angles=angles,
        cable_lengths=cable_lengths,
        motor_counts=robot.motor_counts(cable_lengths if held is None else cable_lengths - held.stretch),
        base_pose=at if at.shape[1] > 1 else None,
        clearance=clearance,
        horizon=horizon,
    )


def horizon_of(task: Task) -> float:
    """Up to where (m) clearances of a plan are exact.

    For thick bodies as far as their radius: where all clearances look alike, steps in proportion to the arm would be
    halved everywhere.
    """
    return max(HORIZON, task.clearance_wanted + BEYOND_MARGIN, float(task.robot.body_radii.max()))


def desired_path(task: Task) -> tuple[Array, Path]:
    """Way-points and path of a task; with detours round what the body would hit, if the task allows them."""
    if not task.spec.path.detour:
        return task.way_points, task.path_through(task.way_points)
    robot, least = task.robot, np.full(task.robot.sections, task.margin)
    tried = [robot.body_radii + task.clearances_wanted]
    if task.budget is not None:
        # What tolerances take is not known exactly before the motion is, and the checks tell it better.
        tried.append(robot.body_radii + least)
    if robot.outline.flat:
        # The same goes for which way a flat body lies where the way is narrower than it is wide.
        tried.append(robot.outline.inner_radii + least)
    for radii in tried[:-1]:
        with suppress(InfeasibleError):
            return _led_round(task, radii)
    return _led_round(task, tried[-1])


def _led_round(task: Task, radii: Array) -> tuple[Array, Path]:
    """Way-points and path with detours that leave so much (n,) m about the centre line of every link."""
    return lead_round(
        task.path_through,
        task.way_points,
        task.scene,
        radii=radii,
        link_lengths=task.robot.link_lengths,
        step=task.spec.motion.step,
        start=task.base.run,
        longest=_longest_detour(task),
    )


def _longest_detour(task: Task) -> float:
    """How long (m) detours may make the way: in proportion to the arm, or to the way of an arm that is carried on."""
    arm = MOST_ROUNDABOUT * task.robot.length
    if not task.base.follows:
        return arm
    return max(arm, MOST_ROUNDABOUT * (task.path_through(task.way_points).length - task.base.run))


def _no_detour(task: Task, error: InfeasibleError) -> InfeasibleError:
    """The same error, after what made a detour necessary if that is a gap which is too narrow for the body."""
    if not task.spec.path.detour or task.spec.path.target is not None:
        return error
    radius, start = float(task.robot.outline.inner_radii[-1] + task.clearances_wanted[-1]), task.base.run
    narrow = too_narrow(task.path_through(task.way_points), task.scene, radius, start)
    return error if narrow is None else InfeasibleError(f"{narrow}. No detour leads round it: {error}", error.plan)


def insertion(task: Task, path: Path) -> timing.SetPoints:
    """Set-points from feed 0 to where the tip is on the target, at constant feed.

    Parameters, errors as of `arrival`. An InputError, too, if they are more than a plan can have.
    """
    return _constant(task, arrival(task, path))


def _constant(task: Task, length: float) -> timing.SetPoints:
    motion = task.spec.motion
    _refuse_too_many(task, timing.steps_of(length, motion.step))
    return timing.set_points(length, motion.step, motion.period_s)


def _ending_softly(task: Task, points: timing.SetPoints, angles: Array, sections: Array, at: Array) -> timing.SetPoints:
    """Set-points of constant feed; the last, shorter step takes its part of a period if a whole one stops too hard."""
    if len(points.time) < 3:
        return points
    limits, square = task.robot.spec.limits, (points.time[-1] - points.time[-2]) ** 2
    too_hard = np.abs(np.diff(angles[-3:], 2, axis=0)).max() > np.radians(limits.joint_acceleration_deg_s2) * square
    if limits.cable_acceleration is not None:
        last = task.commanded_lengths(angles[-3:], at[-3:], sections[-3:])
        too_hard = too_hard or np.abs(np.diff(last, 2, axis=0)).max() > limits.cable_acceleration * square
    return points.with_short_end() if too_hard else points


def _refuse_too_many(task: Task, count: int) -> None:
    """Before so many set-points are made."""
    robot, motion = task.robot, task.spec.motion
    if count * (robot.sections + 1) > MOST_POSITIONS:
        raise InputError(
            f"motion.step: {1e3 * motion.step:g} mm makes {count:.3g} steps of {robot.sections} sections; at most "
            f"{MOST_POSITIONS // (robot.sections + 1):,} steps. Take a larger step."
        )
    if count * motion.period_s > LONGEST_MOTION:
        raise InputError(
            f"motion.period_s: {motion.period_s:g} s for each of {count:,} steps is a motion of "
            f"{count * motion.period_s:.3g} s; at most {LONGEST_MOTION:,.0f} s. Take a shorter period or a larger step."
        )


def _refuse_coarse_step(task: Task) -> None:
    """Before a detour is led round by it: one step that is longer than the arm is a wrong unit."""
    step, length = task.spec.motion.step, task.robot.length
    if step > length:
        raise InputError(
            f"motion.step: {1e3 * step:g} mm is longer than the arm, {1e3 * length:g} mm: take a smaller step "
            "(or check the file's `units`)"
        )


def refuse_buried_places(task: Task) -> None:
    """Raise an InputError that names the first place to be passed, or the base's, that lies inside an obstacle.

    Of one that moves, too, if the arm lies there before it begins to move; or what is wrong with the base itself: see
    `refuse_unfit_base`.
    """
    refuse_unfit_base(task)
    refuse_covered_start(task)
    owner = task.scene.inside(task.way_points)
    for index in np.flatnonzero(owner >= 0):
        place, name = places(task)[index], task.scene.names[owner[index]]
        raise InputError(
            f"{place.key}: {place.words} at {point(place.at, 'g')} lies inside the obstacle {name!r}; "
            "move it into free space; or, if the obstacle is a file's surface without an inside, such as a duct, give "
            "it `solid = false`"
        )
    start = task.base.start
    (owner_of_base,) = task.scene.inside(start[None])
    if owner_of_base >= 0:
        key, way_out = task.spec.base.way_out
        raise InputError(
            f"{key}: at feed 0 the first joint, at {point(start, 'g')}, lies inside the obstacle "
            f"{task.scene.names[owner_of_base]!r}; {way_out}"
        )
