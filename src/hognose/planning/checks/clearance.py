"""Criteria of how close the body comes to obstacles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hognose.planning.certificate import Certificate, Passing, judges_cables
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import CLEARANCE, Criterion
from hognose.planning.checks.findings import Place, agrees, informative, least, not_judged
from hognose.planning.checks.shared import Shared
from hognose.planning.checks.waiting import clearance_while_waiting
from hognose.planning.motion import Motion
from hognose.planning.penetration import contact
from hognose.robot.own_body import MOUNT, clearance_of_neighbours
from hognose.ties import first_smallest
from hognose.wording import point

_NO_CLOCK = "nothing is proven: obstacles move, and the times do not increase"


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
    return f"; {shared.allowance.words(shared.motion.outline, step, link)}"


def _closest(motion: Motion, step: int, link: int, clearance: float) -> tuple[str | None, str]:
    """The obstacle that a link is closest to, and where that is in words."""
    if clearance >= motion.horizon:
        return None, f"nothing is closer than {1e3 * motion.horizon:g} mm"
    scene, moving, time = motion.scene, motion.task.moving, float(motion.clock[step])
    found = contact(scene, moving, motion.robot, motion.outline[step], time, link, clearance)
    said = f"inside {found.obstacle}, deepest" if found.inside else f"closest to {found.obstacle}"
    at = f", at {time:.2f} s" if found.moves else ""
    return found.obstacle, f"{said} at {point(found.place)}{at}"


def certified_along_path(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Between the steps, too, the body is clear by the margin while joints glide along the path.

    Made for methods whose joints do.
    """
    shared.prove_all()
    if motion.follower.glides:
        if shared.glides:
            why = "the path turns so sharply within a link that joints may jump"
            yield _certified(motion, shared, shared.along_path, shared.passing_along_path, why)
        else:
            straight = motion.robot.straight_links
            yield not_judged(
                "how a flat body on a carrier rolls while joints glide is not known"
                if straight
                else "gliding is proven for straight links only"
            )


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
    why = "the cables turn joints too far between steps, or do not determine them; a smaller motion.step may help"
    yield _certified(motion, shared, shared.cables_interpolated, shared.passing_cables, why)


def _certified(
    motion: Motion, shared: Shared, proof: Certificate | None, passing: tuple[Passing, ...] | None, otherwise: str = ""
) -> Check:
    margin = motion.task.margin
    if proof is None or passing is None:
        return least(0.0, margin, detail=f"nothing is proven: {otherwise}")
    if passing and not np.all(np.diff(motion.time) > 0):
        return least(0.0, margin, detail=_NO_CLOCK)
    values = np.array([proof.clearance, *(each.clearance for each in passing)])
    (which,), worst = first_smallest(values), float(values.min())
    halvings = proof.halvings + sum(each.halvings for each in passing)
    proven = "proven between the steps too" if worst > 0 else "as far as was looked"
    detail = f"{proven}, {halvings} configurations added"
    if which == 0:
        detail += _with_tolerances(shared, proof.step, proof.link)
        far = worst >= motion.horizon
        return least(worst, margin, far, step=proof.step, link=proof.link, detail=detail)
    closest = passing[which - 1]
    detail = f"closest to {closest.obstacle}, which moves, at {closest.time:.2f} s; {detail}"
    detail += _with_tolerances(shared, closest.step, closest.link)
    place: Place = {"step": closest.step, "link": closest.link, "obstacle": closest.obstacle, "detail": detail}
    return least(worst, margin, **place)


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
    """What there is of a body behind the first joint is clear by the margin over its whole travel.

    Of obstacles that stand still over all that it sweeps, of those that move when it is where.
    """
    margin, detail = motion.task.margin, "the body behind the first joint"
    found = _mount_past_still(motion, shared)
    if found is None:
        return
    if shared.mount.gliding is not None:
        found = min(found, shared.mount.certified(shared.mount.gliding).clearance)
    passing = shared.mount.passing
    if passing and not np.all(np.diff(motion.clock) > 0):
        yield least(0.0, margin, detail=_NO_CLOCK)
        return
    closest, obstacle = min(passing, key=lambda each: each.clearance, default=None), None
    if closest is not None and closest.clearance < min(found, motion.horizon):
        found, obstacle = closest.clearance, closest.obstacle
        detail += f", closest to {obstacle}, which moves, at {closest.time:.2f} s"
    far = found >= motion.horizon
    yield least(min(found, motion.horizon), margin, far, obstacle=obstacle, detail=detail)


def _mount_past_still(motion: Motion, shared: Shared) -> float | None:
    """The clearance (m) of the mount from what stands still, if the base goes linearly; None with nothing behind."""
    base, budget = motion.task.base, motion.task.budget
    starts, ends, radii = base.behind(motion.at)
    if not len(starts):
        return None
    if budget is not None:
        radii = radii + budget.of_mount(base, starts, ends, radii)
    found = float((motion.scene.distance(starts, ends).value - radii).min())
    if found >= motion.task.margin and found > 0:
        return found
    turns = base.mount is not None and base.mount.turns
    # The capsules of a mount that turns are thicker, by half of its way from step to step: too thick to fail for.
    return shared.mount.certified(shared.mount.linear).clearance if turns and shared.mount.linear else found


def own_body(motion: Motion, shared: Shared) -> Iterator[Check]:
    """At the steps and between them the body does not touch itself or its mount; places beside joints always do."""
    if not clearance_of_neighbours(motion.robot, motion.task.base.mount) > 0.0:
        yield not_judged("where sections are short they may bend so sharply beside others that nothing is known")
        return
    proof = shared.within_body
    if proof.step is None:
        shortest = proof.clearance == clearance_of_neighbours(motion.robot, motion.task.base.mount)
        beside = ", which may where sections are as short and as bent as they can be" if shortest else " excepted"
        detail = f"nowhere do two links come closer, beside joints{beside}"
        yield least(proof.clearance, 0.0, True, detail=detail)
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
    Criterion("clearance_while_waiting", "clearance while waiting", "m", clearance_while_waiting, CLEARANCE),
    Criterion("clearance_of_mount", "clearance of the mount", "m", clearance_of_mount, CLEARANCE),
    Criterion("own_body", "clearance within the body", "m", own_body, CLEARANCE),
)
#: Keys of the criteria whose verdicts hold between the steps.
CERTIFIED = ("certified_along_path", "certified_interpolated", "certified_cables")
