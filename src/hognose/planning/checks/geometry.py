"""Criteria of where joints, tip and path are."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import agrees, least, most, not_judged
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.thresholds import (
    COLUMN_TOLERANCE,
    LOOKUP_TIP_TOLERANCE,
    STRAIGHT_TOLERANCE,
    TIP_TOLERANCE,
    VIA_TOLERANCE,
)
from hognose.robot.base import nose_on
from hognose.robot.bends import on_side, used
from hognose.robot.sections import MixedSections
from hognose.ties import first_largest
from hognose.wording import point

Array = NDArray[np.float64]


def feed_on_path(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The joints can be followed at every feed. Made where they cannot; then nothing else is.

    Without the task's method it is not judged, and nothing else is either.
    """
    if motion.missing_method is not None:
        yield not_judged(f"nothing can be checked: the task's method {motion.missing_method!r} is not installed")
        return
    try:
        _ = shared.followed
    except HognoseError as error:
        step = int(np.argmax(np.abs(motion.feed - 0.5 * motion.path.length)))
        detail = f"nothing else can be checked: {error}"
        yield most(motion.feed[step], motion.path.length, ok=False, step=step, detail=detail)


def bend_limits(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No joint angle exceeds the bend limit of its section."""
    bounds = motion.robot.bend_bounds
    step, section, axis = first_largest(used(motion.angles, bounds))
    limit = on_side(motion.angles[step], bounds)[section, axis] * (1 + 1e-12)
    worst = abs(motion.angles[step, section, axis])
    yield most(worst, limit, step=step, section=section, detail="alpha" if axis == 0 else "beta")


def link_lengths(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Joints are as far apart as their links are long."""
    robot, said = motion.robot, motion.robot.link_lengths
    if not robot.straight_links:  # the ends of a section come closer as it bends
        joints = robot.joint_positions(motion.angles, lengths=motion.section_lengths)
        said = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    off = np.abs(np.linalg.norm(np.diff(motion.joints, axis=1), axis=2) - said)
    step, link = first_largest(off)
    yield most(off[step, link], shared.tolerance, step=step, link=link)


def section_lengths(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No section gets shorter or longer than it can. Made for arms whose sections extend."""
    if motion.robot.extends:
        lengths, (low, high) = motion.section_lengths, motion.robot.length_bounds.T
        beyond = np.maximum(lengths - high, low - lengths)
        step, section = first_largest(np.where(low < high, beyond, -np.inf))
        value, within = lengths[step, section], bool(beyond[step, section] <= COLUMN_TOLERANCE)
        if value > 0.5 * (low + high)[section]:
            yield most(value, high[section], within, step=step, section=section)
        else:
            yield replace(least(value, low[section], step=step, section=section), ok=within)


def joints_on_path(motion: Motion, shared: Shared) -> Iterator[Check]:
    """All joints and the tip are on the method's curve. Made for methods that let joints glide along it."""
    if motion.follower.glides:
        away = _off_path(motion, 2 * (motion.robot.sections + 1) * shared.tolerance)
        step, joint = first_largest(away)
        yield most(away[step, joint], shared.tolerance, step=step, section=min(joint, motion.robot.sections - 1))


def _off_path(motion: Motion, drift: float) -> Array:
    """Distance (T, n+1) m of joints to the method's curve, which goes on straight for `drift` behind the target."""
    curve = motion.follower.curve
    away = curve.distance_to(motion.joints.swapaxes(0, 1)).T
    from_end = motion.joints - curve.point(curve.length)
    along = from_end @ curve.tangent(curve.length)
    beside = np.linalg.norm(from_end, axis=2) ** 2 - along**2
    return np.where((along > 0) & (along < drift), np.sqrt(np.maximum(beside, 0.0)), away)


def joints_agree_with_following(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Joints are where following the path with the task's method puts them."""
    yield agrees(np.abs(motion.joints - shared.followed))


def tip_error(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The tip is, by forward kinematics, where exact following puts it; of other sections than links, on the path."""
    (step,) = first_largest(motion.tip_error)
    right = "the path" if isinstance(motion.robot.model, MixedSections) else "exact following"
    detail = f"forward kinematics against {right}"
    yield most(motion.tip_error[step], _tip_tolerance(motion, shared), step=step, detail=detail)


def tip_on_target(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The tip ends on the target, or begins there on the way out."""
    miss = np.linalg.norm(motion.body[shared.arrived, -1] - motion.task.way_points[-1])
    yield most(miss, _tip_tolerance(motion, shared), step=shared.arrived)


def _tip_tolerance(motion: Motion, shared: Shared) -> float:
    precise = shared.tolerance < TIP_TOLERANCE / motion.robot.sections
    return motion.task.spec.motion.tip_tolerance or (TIP_TOLERANCE if precise else LOOKUP_TIP_TOLERANCE)


def tip_direction(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The nose points at the target within the task's cone. Made where the task asks for a direction."""
    path, at = motion.task.spec.path, [shared.arrived]
    if path.tip_direction is not None:
        (tip,) = nose_on(motion.task.base, motion.robot, motion.angles[at], motion.at[at])
        wished = np.array(path.tip_direction)
        angle = np.arctan2(np.linalg.norm(np.cross(tip, wished)), tip @ wished)
        yield most(angle, math.radians(path.tip_cone_deg), step=shared.arrived)


def path_through_way_points(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The path passes the task's way-points. Made for splines."""
    if motion.task.spec.path.kind == "spline":
        yield agrees(motion.path.distance_to(motion.task.way_points))


def way_points_of_task(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The path's control polygon has the task's way-points in their order. Made for curves that need not pass them."""
    if motion.task.spec.path.kind != "spline":
        given = iter(motion.way_points)
        missing = sum(not any(np.array_equal(point, other) for other in given) for point in motion.task.way_points)
        yield most(missing, 0, detail="missing in the control polygon")


def path_through_via(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The path passes the places that are asked for besides, in their order. Made where way-points are given, too."""
    path = motion.task.spec.path
    if path.target is not None or not path.via:
        return
    places = np.array(path.via)
    off = motion.path.distance_to(places)
    worst = int(np.argmax(off))
    said = f"via {worst + 1} at {point(places[worst], 'g')}"
    passed = bool(off[worst] <= VIA_TOLERANCE)
    if passed and not _in_order(motion, places):
        passed, said = False, "all are passed, but in another order"
    yield most(off[worst], VIA_TOLERANCE, passed, detail=said)


def _in_order(motion: Motion, places: Array) -> bool:
    """Whether a path that passes places (k, 3) m passes one after the other."""
    samples = motion.path.point(np.linspace(0.0, motion.path.length, math.ceil(motion.path.length / 0.001) + 1))
    at = 0
    for place in places:
        near = np.flatnonzero(np.linalg.norm(samples[at:] - place, axis=1) <= 0.001)
        if not near.size:
            return False
        at += int(near[0])
    return True


def starts_straight(motion: Motion, shared: Shared) -> Iterator[Check]:
    """An insertion starts as the arm lies on its base at feed 0: with all joints straight, but on a drum."""
    if not motion.retracts:
        yield _straight(motion, shared)


def ends_straight(motion: Motion, shared: Shared) -> Iterator[Check]:
    """A retraction ends as the arm lies on its base at feed 0: with all joints straight, but on a drum."""
    if motion.retracts:
        yield _straight(motion, shared)


def _straight(motion: Motion, shared: Shared) -> Check:
    row = shared.outside
    straight, feed = np.abs(motion.angles[row] - shared.rest).max(), motion.feed[row]
    limit = max(STRAIGHT_TOLERANCE, float(2 * shared.tolerance / motion.robot.link_lengths.min()))
    at_zero = abs(feed) <= COLUMN_TOLERANCE
    detail = "" if at_zero else f"but at feed {1e3 * feed:g} mm, expected 0"
    longer = float(np.abs(motion.section_lengths[row] - motion.robot.link_lengths).max())
    at_rest = longer <= COLUMN_TOLERANCE
    if not at_rest:
        detail += f"but a section is {1e3 * longer:.3g} mm longer or shorter than at rest"
    return most(straight, limit, bool(straight <= limit and at_zero and at_rest), step=row, detail=detail)


CRITERIA = (
    Criterion("feed_on_path", "feed on path", "m", feed_on_path, KINEMATICS, basis=True),
    Criterion("bend_limits", "bend limits", "rad", bend_limits, KINEMATICS),
    Criterion("link_lengths", "link lengths", "m", link_lengths, KINEMATICS),
    Criterion("section_lengths", "section lengths", "m", section_lengths, KINEMATICS),
    Criterion("joints_on_path", "joints on path", "m", joints_on_path, KINEMATICS),
    Criterion(
        "joints_agree_with_following", "joints agree with following", "m", joints_agree_with_following, KINEMATICS
    ),
    Criterion("tip_error", "tip error", "m", tip_error, KINEMATICS),
    Criterion("tip_on_target", "tip on target", "m", tip_on_target, KINEMATICS),
    Criterion("tip_direction", "tip direction", "rad", tip_direction, KINEMATICS),
    Criterion("path_through_way_points", "path through way-points", "m", path_through_way_points, KINEMATICS),
    Criterion("way_points_of_task", "way-points of the task", "1", way_points_of_task, KINEMATICS),
    Criterion("path_through_via", "path through via", "m", path_through_via, KINEMATICS),
    Criterion("starts_straight", "starts as it lies on its base", "rad", starts_straight, KINEMATICS),
    Criterion("ends_straight", "ends as it lies on its base", "rad", ends_straight, KINEMATICS),
)
