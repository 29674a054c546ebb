"""Criteria of how close the body comes to obstacles."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.planning.certificate import Certificate, Passing, certify_standing, judges_cables
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import CLEARANCE, Criterion
from hognose.planning.checks.findings import Place, agrees, informative, least, not_judged
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.penetration import deepest_place, penetration
from hognose.robot.own_body import MOUNT
from hognose.scene import MovingObstacle, Scene
from hognose.ties import first_smallest
from hognose.wording import point

Array = NDArray[np.float64]


def clearance_agrees_with_angles(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Clearances are those of the body at the angles."""
    yield agrees(np.abs(shared.clearance - motion.clearance))


def clearance_at_steps(motion: Motion, shared: Shared) -> Iterator[Check]:
    """At every step the body is clear of all obstacles by the margin, tolerances taken off."""
    step, link = first_smallest(shared.left)
    obstacle, detail = _closest(motion, step, link, shared.clearance[step, link])
    detail += _with_tolerances(shared, step, link)
    far = shared.clearance[step, link] >= motion.horizon
    place: Place = {"step": step, "link": link, "obstacle": obstacle, "detail": detail}
    yield least(shared.left[step, link], motion.task.margin, far, **place)


def _with_tolerances(shared: Shared, step: int, link: int) -> str:
    """What tolerances take of a clearance, and most of it, in words; none without tolerances."""
    if shared.allowance is None:
        return ""
    return f"; {shared.allowance.words(shared.motion.centre_line, step, link)}"


def _closest(motion: Motion, step: int, link: int, clearance: float) -> tuple[str | None, str]:
    """The obstacle that a link is closest to, and where that is in words."""
    if clearance >= motion.horizon:
        return None, f"nothing is closer than {1e3 * motion.horizon:g} mm"
    chords = np.flatnonzero(motion.robot.chord_sections == link)
    ends = motion.centre_line[step, [*chords, chords[-1] + 1]]
    first = (_distance(motion.scene, ends), motion.scene, ends, None)
    found: list[tuple[float, Scene, Array, MovingObstacle | None]] = [first]
    for each in motion.task.moving:
        seen = each.motion.into_frame(ends[None], motion.clock[step, None])[0]
        found.append((_distance(each.scene, seen), each.scene, seen, each))
    _, scene, ends, moving = min(found, key=lambda one: one[0])
    nearest = int(np.argmin(scene.distance(ends[:-1], ends[1:]).value)) if len(chords) > 1 else 0
    start, end = ends[nearest], ends[nearest + 1]
    inside = clearance < -motion.robot.chord_radii[chords[nearest]]
    if inside:
        obstacle, place = deepest_place(scene, start, end)
    else:
        witness = scene.witness(start, end)
        obstacle, place = witness.obstacle, witness.on_mesh
    said = f"inside {obstacle}, deepest" if inside else f"closest to {obstacle}"
    if moving is None:
        return obstacle, f"{said} at {point(place)}"
    time = float(motion.clock[step])
    return obstacle, f"{said} at {point(moving.motion.out_of_frame(np.array(place), time))}, at {time:.2f} s"


def _distance(scene: Scene, ends: Array) -> float:
    """Distance (m) of chords that end at (p+1, 3) m to a scene; minus their depth where they are inside."""
    starts, ends = ends[:-1], ends[1:]
    found = scene.distance(starts, ends).value
    return float((found - penetration(scene, starts, ends).depth).min()) if scene.names else math.inf


def certified_along_path(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Between the steps, too, the body is clear by the margin while joints glide along the path.

    Made for methods whose joints do.
    """
    if motion.follower.glides:
        if motion.robot.model.chords == 1:
            why = "the path turns so sharply within a link that joints may jump"
            yield _certified(motion, shared, shared.along_path, shared.passing_along_path, why)
        else:
            yield not_judged("gliding is proven for straight links only")


def certified_interpolated(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Between the steps, too, the body is clear by the margin while feed and angles go linearly from step to step."""
    yield _certified(motion, shared, shared.interpolated, shared.passing_interpolated)


def certified_cables(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Between the steps, too, the body is clear by the margin while feed and motor counts go linearly.

    Not judged for sections of which it is not known how cables bend them.
    """
    if not judges_cables(motion.robot):
        yield not_judged("how cables bend sections of this kind is not known")
        return
    why = "the cables turn joints too far from one step to the next, or do not determine them"
    yield _certified(motion, shared, shared.cables_interpolated, shared.passing_cables, why)


def _certified(
    motion: Motion, shared: Shared, proof: Certificate | None, passing: tuple[Passing, ...] | None, otherwise: str = ""
) -> Check:
    margin = motion.task.margin
    if proof is None or passing is None:
        return least(0.0, margin, detail=f"nothing is proven: {otherwise}")
    if passing and not np.all(np.diff(motion.time) > 0):
        return least(0.0, margin, detail="nothing is proven: obstacles move, and the times do not increase")
    halvings = proof.halvings + sum(each.halvings for each in passing)
    detail = f"proven between the steps too, {halvings} configurations added"
    closest = min(passing, key=lambda each: each.clearance, default=None)
    if closest is None or closest.clearance >= proof.clearance:
        detail += _with_tolerances(shared, proof.step, proof.link)
        far = proof.clearance >= motion.horizon
        return least(proof.clearance, margin, far, step=proof.step, link=proof.link, detail=detail)
    detail = f"closest to {closest.obstacle}, which moves, at {closest.time:.2f} s; {detail}"
    detail += _with_tolerances(shared, closest.step, closest.link)
    place: Place = {"step": closest.step, "link": closest.link, "obstacle": closest.obstacle, "detail": detail}
    return least(closest.clearance, margin, **place)


def moving_obstacles(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The obstacles move for as long as the plan does. Never fails; made where obstacles move."""
    said = []
    for each in motion.task.moving:
        last = float(each.motion.times[-1])
        if each.motion.repeats:
            said.append(f"{each.name} moves all the time")
        elif last < motion.clock[-1]:
            said.append(f"{each.name} stands still from {last:g} s on, the plan ends at {motion.clock[-1]:.2f} s")
        else:
            said.append(f"{each.name} moves until {last:g} s, the plan ends at {motion.clock[-1]:.2f} s")
    if said:
        yield informative("; ".join(said))


def clearance_of_mount(motion: Motion, shared: Shared) -> Iterator[Check]:
    """What there is of a body behind the first joint is clear by the margin over its whole travel."""
    starts, ends, radii = motion.task.base.behind(motion.at)
    if not len(starts):
        return
    if motion.task.budget is not None:
        radii = radii + motion.task.budget.of_mount(starts, ends)
    found, detail = float((motion.scene.distance(starts, ends).value - radii).min()), "the body behind the first joint"
    times, obstacle = motion.clock[np.isfinite(motion.clock)], None
    for each in motion.task.moving:
        proof = certify_standing(starts, ends, radii, each, times, motion.horizon, motion.task.margin)
        if proof.clearance < min(found, motion.horizon):
            found, obstacle = proof.clearance, each.name
            detail = f"the body behind the first joint, closest to {each.name}, which moves, at {proof.time:.2f} s"
    far = found >= motion.horizon
    yield least(min(found, motion.horizon), motion.task.margin, far, obstacle=obstacle, detail=detail)


def own_body(motion: Motion, shared: Shared) -> Iterator[Check]:
    """At the steps and between them the body does not touch itself or its mount; places beside joints always do."""
    proof = shared.within_body
    if proof.step is None:
        yield least(proof.clearance, 0.0, True, detail="nowhere do two links come closer, beside joints excepted")
        return
    first, second = proof.links
    proven = ", proven between the steps too" if proof.clearance > 0 else ""
    if first == MOUNT:
        first, both = second, f"the mount and link {second + 1}"
    else:
        both = f"links {first + 1} and {second + 1}"
    detail = f"{both} at {point(proof.place)}{proven}"
    yield least(proof.clearance, 0.0, step=proof.step, link=first, detail=detail)


CRITERIA = (
    Criterion(
        "clearance_agrees_with_angles", "clearance agrees with angles", "m", clearance_agrees_with_angles, CLEARANCE
    ),
    Criterion("clearance_at_steps", "clearance at steps", "m", clearance_at_steps, CLEARANCE),
    Criterion("certified_along_path", "certified clearance, along the path", "m", certified_along_path, CLEARANCE),
    Criterion(
        "certified_interpolated", "certified clearance, joints interpolated", "m", certified_interpolated, CLEARANCE
    ),
    Criterion("certified_cables", "certified clearance, cables interpolated", "m", certified_cables, CLEARANCE),
    Criterion("moving_obstacles", "moving obstacles", "s", moving_obstacles, CLEARANCE),
    Criterion("clearance_of_mount", "clearance of the mount", "m", clearance_of_mount, CLEARANCE),
    Criterion("own_body", "clearance within the body", "m", own_body, CLEARANCE),
)
#: Keys of the criteria whose verdicts hold between the steps.
CERTIFIED = ("certified_along_path", "certified_interpolated", "certified_cables")
