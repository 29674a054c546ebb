"""The checks a plan must pass, each made from the plan's own columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.following import follow
from hognose.planning import timing
from hognose.planning.certificate.bound import Certificate, certify_gliding, certify_interpolated
from hognose.planning.checks.check import Check
from hognose.planning.motion import Motion
from hognose.planning.penetration import deepest_place, penetration
from hognose.robot.spec import Limits
from hognose.scene import Scene
from hognose.ties import first_largest, first_smallest

Array = NDArray[np.float64]
Progress = Callable[[str], None]

#: How closely (m) the tip must reach the target and keep to exact following, unless the task says otherwise.
TIP_TOLERANCE = 1e-6
#: The same for methods that look joints up among points of the path.
LOOKUP_TIP_TOLERANCE = 1e-3
#: How closely (m) way-points must pass places that are via: both may be rounded to 0.001 mm in a task file.
VIA_TOLERANCE = 1e-6
#: A surface so close (m) to a link's axis is cut by it.
CUTS = 1e-12
#: How closely columns that follow from others must agree with them (m).
COLUMN_TOLERANCE = 1e-9
#: The same for times (s).
TIME_TOLERANCE = 1e-9


def clearance_of(scene: Scene, body: Array, radii: Array, horizon: float) -> Array:
    """Clearance (T, n) m of an arm with joints at `body` (T, n+1, 3).

    Inside a solid it is minus the radius and the depth of the link's axis. A mesh is a shell, so a link deep inside
    would look clear. An arm that starts outside and never touches stays outside, so only the start and motions that
    touch need the (slower) inside test.
    """
    value = scene.clearance(body[:, :-1], body[:, 1:], radii, horizon).value
    tested = slice(None) if value.min() <= 0 else slice(0, 1)
    middles = 0.5 * (body[tested, :-1] + body[tested, 1:])
    inside = scene.inside(middles.reshape(-1, 3)).reshape(middles.shape[:2]) >= 0
    row, link = np.nonzero(inside | (value[tested] <= -radii + CUTS))
    if len(row):
        deep = penetration(scene, body[row, link], body[row, link + 1])
        value[row, link] = -radii[link] - deep.depth
    return value


def run_checks(
    plan: Motion, progress: Progress = lambda stage: None, measured: Array | None = None
) -> tuple[Check, ...]:
    """Every check of a plan, from its angles, feeds and joints; nothing stored is believed.

    Parameters
    ----------
    plan
        With or without checks of its own.
    progress
        Called with the name of each stage.
    measured : (T, n) m, optional
        The clearance at `plan.body`, if it was only just measured.
    """
    motion, robot = plan.task.spec.motion, plan.robot
    try:
        # Not with `plan.follower`, which may remember: some methods go on from where they last were.
        followed = follow(plan.path, robot.link_lengths, plan.feed, motion.method, motion.spacing, robot.bend_limits)
    except HognoseError as error:
        step = int(np.argmax(np.abs(plan.feed - 0.5 * plan.path.length)))
        detail = f"nothing else can be checked: {error}"
        limit = 1e3 * plan.path.length
        return (_most("feed on path", 1e3 * plan.feed[step], limit, "mm", step, None, detail, ok=False),)
    progress("checking kinematics")
    with np.errstate(all="ignore"):  # times and limits may be anything; what is infinite or no number fails
        checks = [*_geometry(plan, followed), *_set_points(plan), *_motion(plan), *_actuation(plan)]
    progress("certifying clearance")
    return (*checks, *_clearance(plan, measured))


def _geometry(plan: Motion, followed: Array) -> Iterator[Check]:
    robot, task = plan.robot, plan.task
    tolerance = max(plan.follower.tolerance, 1e-11)
    precise = tolerance < TIP_TOLERANCE / robot.sections
    tip_limit = task.spec.motion.tip_tolerance or (TIP_TOLERANCE if precise else LOOKUP_TIP_TOLERANCE)
    ratio = np.abs(plan.angles) / robot.bend_limits
    step, section, axis = first_largest(ratio)
    limit = np.degrees(robot.bend_limits[section, axis])
    worst = abs(np.degrees(plan.angles[step, section, axis]))
    yield _most("bend limits", worst, limit * (1 + 1e-12), "deg", step, section, "alpha" if axis == 0 else "beta")

    off = np.abs(np.linalg.norm(np.diff(plan.joints, axis=1), axis=2) - robot.link_lengths)
    step, section = first_largest(off)
    yield _most("link lengths", 1e3 * off[step, section], 1e3 * tolerance, "mm", step, section)
    if plan.follower.glides:
        away = _off_path(plan, 2 * (robot.sections + 1) * tolerance)
        step, joint = first_largest(away)
        section = min(joint, robot.sections - 1)
        yield _most("joints on path", 1e3 * away[step, joint], 1e3 * tolerance, "mm", step, section)

    yield _agrees("joints agree with following", np.abs(plan.joints - followed))
    (step,) = first_largest(plan.tip_error)
    error = 1e3 * plan.tip_error[step]
    yield _most("tip error", error, 1e3 * tip_limit, "mm", step, None, "forward kinematics against exact following")
    inside, outside = (0, len(plan.time) - 1) if plan.retracts else (len(plan.time) - 1, 0)
    miss = np.linalg.norm(plan.body[inside, -1] - task.way_points[-1])
    yield _most("tip on target", 1e3 * miss, 1e3 * tip_limit, "mm", inside)
    if task.spec.path.tip_direction is not None:
        yield _tip_direction(plan, inside, np.array(task.spec.path.tip_direction))
    if task.spec.path.kind == "spline":
        yield _agrees("path through way-points", plan.path.distance_to(task.way_points))
    else:  # of a control polygon the path need not pass the points, but they must be in it
        missing = _not_in_order(task.way_points, plan.way_points)
        yield _most("way-points of the task", missing, 0, "missing")
    if task.spec.path.target is None and task.spec.path.via:
        yield _via(plan, np.array(task.spec.path.via))

    straight = np.degrees(np.abs(plan.angles[outside]).max())
    limit = max(1e-6, float(np.degrees(2 * tolerance / robot.link_lengths.min())))
    at_zero = abs(plan.feed[outside]) <= COLUMN_TOLERANCE
    detail = "" if at_zero else f"but at feed {1e3 * plan.feed[outside]:g} mm, expected 0"
    name = "ends straight" if plan.retracts else "starts straight"
    yield _most(name, straight, limit, "deg", outside, None, detail, ok=bool(straight <= limit and at_zero))


def _not_in_order(wanted: Array, given: Array) -> int:
    """How many of some points (m, 3) are not among others (k, 3), in this order."""
    rest = iter(given)
    return sum(not any(np.array_equal(point, other) for other in rest) for point in wanted)


def _tip_direction(plan: Motion, step: int, wished: Array) -> Check:
    """A check that the last link points at the target as wished."""
    tip = plan.body[step, -1] - plan.body[step, -2]
    across = np.linalg.norm(np.cross(tip, wished))
    angle = np.degrees(np.arctan2(across, tip @ wished))
    return _most("tip direction", angle, plan.task.spec.path.tip_cone_deg, "deg", step)


def _via(plan: Motion, places: Array) -> Check:
    """A check that a path along way-points passes the places (k, 3) m that are asked for besides, in their order."""
    off = plan.path.distance_to(places)
    worst = int(np.argmax(off))
    said = f"via {worst + 1} at ({', '.join(f'{1e3 * c:g}' for c in places[worst])}) mm"
    passed = bool(off[worst] <= VIA_TOLERANCE)
    if passed and not _in_order(plan, places):
        passed, said = False, "all are passed, but in another order"
    return _most("path through via", 1e3 * off[worst], 1e3 * VIA_TOLERANCE, "mm", detail=said, ok=passed)


def _in_order(plan: Motion, places: Array) -> bool:
    """Whether a path that passes places (k, 3) m passes one after the other."""
    samples = plan.path.point(np.linspace(0.0, plan.path.length, math.ceil(plan.path.length / 0.001) + 1))
    at = 0
    for place in places:
        near = np.flatnonzero(np.linalg.norm(samples[at:] - place, axis=1) <= 0.001)
        if not near.size:
            return False
        at += int(near[0])
    return True


def _off_path(plan: Motion, drift: float) -> Array:
    """Distance (T, n+1) m of joints to the method's curve, which goes on straight for `drift` behind the target."""
    curve = plan.follower.curve
    away = curve.distance_to(plan.joints.swapaxes(0, 1)).T
    from_end = plan.joints - curve.point(curve.length)
    along = from_end @ curve.tangent(curve.length)
    beside = np.linalg.norm(from_end, axis=2) ** 2 - along**2
    return np.where((along > 0) & (along < drift), np.sqrt(np.maximum(beside, 0.0)), away)


def _set_points(plan: Motion) -> Iterator[Check]:
    """Checks that nothing was left out, doubled, swapped or stretched: each row is one step and one period on."""
    motion, last = plan.task.spec.motion, len(plan.time) - 1
    feed = plan.feed[::-1] if plan.retracts else plan.feed
    steady = timing.steady(last + 1, motion.step, motion.period_s)
    off = np.abs(feed - steady.feed)
    off[-1] = 0.0  # what is left of the way, where the insertion ends or the retraction begins
    rest = float(feed[-1] - feed[-2]) if last else 0.0
    fits = timing.is_last_step(rest, feed[-1], motion.step, COLUMN_TOLERANCE) and bool(off.max() <= COLUMN_TOLERANCE)
    (row,) = first_largest(off)
    which, place = ("first", last - row) if plan.retracts else ("last", row)
    detail = f"feeds are {1e3 * motion.step:g} mm apart, the {which} two {1e3 * rest:.6g} mm"
    yield _most("set-points a step apart", 1e3 * off[row], 1e3 * COLUMN_TOLERANCE, "mm", place, None, detail, ok=fits)

    off = np.abs(plan.time - steady.time)
    (row,) = first_largest(off)
    detail = f"times are {motion.period_s:g} s apart"
    yield _most("set-points a period apart", 1e3 * off[row], 1e3 * TIME_TOLERANCE, "ms", row, None, detail)


def _motion(plan: Motion) -> Iterator[Check]:
    limits, axis = plan.robot.spec.limits, plan.robot.spec.feed
    intervals = np.diff(plan.time)
    speed = np.degrees(np.diff(plan.angles, axis=0)) / intervals[:, None, None]
    yield _peak("joint speed", np.abs(speed).max(axis=2), limits.joint_speed_deg_s, "deg/s")
    between = 0.5 * (intervals[1:] + intervals[:-1])
    acceleration = np.diff(speed, axis=0) / between[:, None, None]
    yield _peak("joint acceleration", np.abs(acceleration).max(axis=2), limits.joint_acceleration_deg_s2, "deg/s²")
    feed_speed = 1e3 * np.abs(np.diff(plan.feed)) / intervals
    yield _peak("feed speed", feed_speed[:, None], 1e3 * axis.speed, "mm/s", sections=False)
    (step,) = first_largest(plan.feed)
    within = bool(axis.min <= plan.feed.min() and plan.feed[step] <= axis.max)
    yield _most("slider travel", 1e3 * plan.feed[step], 1e3 * axis.max, "mm", step, ok=within)


def _actuation(plan: Motion) -> Iterator[Check]:
    robot, limits = plan.robot, plan.robot.spec.limits
    expected = robot.cable_lengths(plan.angles)
    yield _agrees("cables agree with angles", np.abs(expected - plan.cable_lengths))
    travel = expected - robot.straight_cable_lengths
    yield from _range("cable travel", 1e3 * travel, 1e3 * np.array(limits.cable_travel), "mm", robot.cable_sections)
    speed = 1e3 * np.abs(np.diff(expected, axis=0)) / np.diff(plan.time)[:, None]
    step, cable = first_largest(speed)
    section = robot.cable_sections[cable]
    yield _most(
        "cable speed",
        speed[step, cable],
        1e3 * limits.cable_speed,
        "mm/s",
        step,
        section,
        f"cable {cable + 1}",
    )
    yield from _counts(plan, limits, robot.motor_counts(expected))


def _counts(plan: Motion, limits: Limits, expected: NDArray[np.int64]) -> Iterator[Check]:
    differs = expected != plan.motor_counts
    size = np.abs(expected.astype(np.float64) - plan.motor_counts)
    step, cable = first_largest(np.where(differs, size + 1.0, 0.0))
    # In Python's whole numbers: the difference of two of 64 bits may need 65.
    wrong = abs(int(expected[step, cable]) - int(plan.motor_counts[step, cable]))
    section = plan.robot.cable_sections[cable]
    if wrong:
        yield _most("motor counts agree with cables", wrong, 0, "counts", step, section, f"cable {cable + 1}")
    else:
        yield _most("motor counts agree with cables", 0, 0, "counts")
    yield from _range("motor counts", expected, np.array(limits.motor_counts), "counts", plan.robot.cable_sections)


def _clearance(plan: Motion, measured: Array | None) -> Iterator[Check]:
    robot, scene, horizon = plan.robot, plan.scene, plan.horizon
    margin = plan.task.margin
    found = clearance_of(scene, plan.body, robot.body_radii, horizon) if measured is None else measured
    yield _agrees("clearance agrees with angles", np.abs(found - plan.clearance))
    step, link = first_smallest(found)
    yield _least(
        "clearance at steps",
        found[step, link],
        margin,
        int(step),
        int(link),
        _closest(plan, step, link, found),
    )

    if plan.follower.glides:
        yield _certified(plan, "along the path", _glided(plan, found))
    interpolated = certify_interpolated(
        robot, scene, plan.task.start, plan.feed, plan.angles, plan.body, found, horizon, margin
    )
    yield _certified(plan, "joints interpolated", interpolated)
    yield _least("clearance of the mount", _mount_clearance(plan), margin, detail="the body behind the first joint")


def _glided(plan: Motion, found: Array) -> Certificate | None:
    """What is proven of the motion that the method makes of a steady feed."""
    robot, scene, exact = plan.robot, plan.scene, plan.exact_joints
    if exact is plan.joints:
        glided = found - np.linalg.norm(plan.joints - plan.body, axis=2).max()
    else:
        glided = clearance_of(scene, exact, robot.body_radii, plan.horizon)
    return certify_gliding(plan.follower.curve, robot, scene, plan.feed, exact, glided, plan.horizon, plan.task.margin)


def _certified(plan: Motion, motion: str, proof: Certificate | None) -> Check:
    name, margin = f"certified clearance, {motion}", plan.task.margin
    if proof is None:
        jumps = "nothing is proven: the path turns so sharply within a link that joints may jump"
        return _least(name, 0.0, margin, detail=jumps)
    detail = f"proven between the steps too, {proof.halvings} configurations added"
    return _least(name, proof.clearance, margin, proof.step, proof.link, detail)


def _closest(plan: Motion, step: Any, link: Any, found: Array) -> str:
    if found[step, link] >= plan.horizon:
        return f"nothing is closer than {1e3 * plan.horizon:g} mm"
    start, end = plan.body[step, link], plan.body[step, link + 1]
    if found[step, link] < -plan.robot.body_radii[link]:
        obstacle, place = deepest_place(plan.scene, start, end)
        return f"inside {obstacle}, deepest at {_place(place)}"
    witness = plan.scene.witness(start, end)
    return f"closest to {witness.obstacle} at {_place(witness.on_mesh)}"


def _place(point: Any) -> str:
    return f"({', '.join(f'{1e3 * c:.1f}' for c in point)}) mm"


def _mount_clearance(plan: Motion) -> float:
    """Clearance (m) of the mount behind the first joint over its whole travel: it only slides along the run."""
    first = plan.task.start - plan.slider_axis * (plan.robot.spec.base_length - plan.feed.min())
    last = plan.task.start + plan.slider_axis * plan.feed.max()
    found = plan.scene.distance(first[None], last[None]).value[0]
    return float(min(found - plan.robot.body_radii[0], plan.horizon))


def _most(
    name: str,
    value: Any,
    limit: Any,
    unit: str,
    step: Any = None,
    section: Any = None,
    detail: str = "",
    ok: bool | None = None,
) -> Check:
    """A check that a value does not exceed its limit; sections come 0-based."""
    passed = bool(value <= limit) if ok is None else ok
    return Check(name, passed, float(value), float(limit), unit, _whole(step), _whole(section, 1), detail=detail)


def _agrees(name: str, off: Array) -> Check:
    """A check that figures (m) that follow from others agree with them."""
    return _most(name, 1e3 * float(off.max()), 1e3 * COLUMN_TOLERANCE, "mm")


def _least(
    name: str, value: Any, limit: float, step: int | None = None, link: int | None = None, detail: str = ""
) -> Check:
    """A check that a clearance (m) does not fall below its limit; links come 0-based."""
    passed = bool(value >= limit and value > 0)
    return Check(name, passed, 1e3 * float(value), 1e3 * limit, "mm", step, _whole(link, 1), True, detail)


def _whole(index: Any, shift: int = 0) -> int | None:
    return None if index is None else int(index) + shift


def _peak(name: str, values: Array, limit: float, unit: str, sections: bool = True) -> Check:
    if not values.size:
        return _most(name, 0.0, limit, unit)
    step, section = first_largest(values)
    return _most(name, values[step, section], limit, unit, step, section if sections else None)


def _range(
    name: str, values: NDArray[Any], limits: NDArray[Any], unit: str, sections: NDArray[np.int64]
) -> Iterator[Check]:
    """A check that values (T, c) stay between limits (low, high); reports the one closest to its own limit."""
    used = np.maximum(values / limits[1], values / limits[0])
    step, cable = first_largest(used)
    value, limit = (values[step, cable], limits[1]) if values[step, cable] >= 0 else (-values[step, cable], -limits[0])
    sense = "paid out" if values[step, cable] >= 0 else "pulled in"
    passed = bool(used[step, cable] <= 1)
    yield _most(name, value, limit, unit, step, sections[cable], f"cable {cable + 1}, {sense}", ok=passed)
