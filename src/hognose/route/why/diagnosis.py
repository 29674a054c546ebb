"""Why no route was found: what blocks, what bends too far, what is too short, what helps, and how far the arm gets."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hognose.errors import InfeasibleError
from hognose.planning.base_limits import BaseLimits
from hognose.planning.checks import Check
from hognose.planning.checks.mechanics import why_it_cannot_begin
from hognose.planning.plan import Plan
from hognose.planning.task import Task
from hognose.robot import bends
from hognose.robot.base import mounted
from hognose.robot.own_body import OwnBody, part_of_body
from hognose.route.fit.objective import Judged, judge
from hognose.route.search.clearance_grid import search_grid
from hognose.route.search.search import Search
from hognose.route.why import partial
from hognose.route.why.causes import Cause, feed_speed, likely_cause, plain_cause
from hognose.route.why.relaxations import Relaxations, objective_of
from hognose.wording import at_least_mm, beside_limit, point


class DiagnosisInterrupted(KeyboardInterrupt):
    """Ctrl-C while it was found out why there is no route; its text says what was known by then.

    Attributes
    ----------
    plan
        The farthest good insertion found by then, or None.
    """

    def __init__(self, message: str, plan: Plan | None) -> None:
        super().__init__(message)
        self.plan = plan


def explained(search: Search) -> InfeasibleError:
    """What stands against a route, what would help, and the farthest insertion that was found, as an error.

    While that is found out a route may be found after all: the search has it then, as its best.

    Raises
    ------
    DiagnosisInterrupted
        On Ctrl-C: with all that was known by then.
    """
    if search.unmendable is not None:
        return _refused(search, search.unmendable)
    diagnosis = _Diagnosis(search)
    try:
        diagnosis.run()
    except KeyboardInterrupt:
        more = "interrupted before all was tried"
        raise DiagnosisInterrupted(diagnosis.text(more), diagnosis.part) from None
    return InfeasibleError(diagnosis.text(), diagnosis.part if search.best is None else search.best.plan)


def _refused(search: Search, check: Check) -> InfeasibleError:
    """The error of a search that a check ended, along whatever route it is."""
    plans = "a plan" if len(search.refused) == 1 else f"each of {len(search.refused)} plans"
    return InfeasibleError(
        f"{search.task.name}: no good motion; {plans} along a searched route failed a check that no other route is "
        f"likely to pass.\n  {check.sentence}",
        search.refused[-1],
    )


class _Diagnosis:
    """What is known of a search that found nothing: more and more, so that it can be said at any time."""

    def __init__(self, search: Search) -> None:
        self.search, self.task = search, search.task
        self.cause: Cause | None = None
        self.said: list[str] = []
        self.relaxations = Relaxations(search)
        self.part: Plan | None = None

    def run(self) -> None:
        """Find out what is wrong, what helps, and how far the arm gets."""
        search, task = self.search, self.task
        search.progress("finding out what stands in the way")
        if search.closest is not None:
            self._offer(search.closest)
        self.cause = plain_cause(task) or likely_cause(
            task, search_grid(task), search.closest, not search.cut_short or search.attempts > 0
        )
        self.said += self.cause.sentences
        for relaxation in self.relaxations.run(self.cause):
            self._offer(relaxation.judged)
        if not self.relaxations.found:
            for spline in self.relaxations.closest:
                self._offer(spline)
        if search.best is not None:
            return
        if self.cause.limits:
            self.said += self._faults()
        fast_enough = feed_speed(task) <= BaseLimits.of(task).judged_speed
        if self.part is None and search.asks_on() and fast_enough and not why_it_cannot_begin(task):
            search.progress("trying how far the arm gets")
            self.part = partial.nearest(search)

    def text(self, more: str | None = None) -> str:
        """All that is known, in lines; `more` comes last."""
        search, relaxations, task = self.search, self.relaxations, self.task
        if search.best is not None:
            return f"{task.name}: a route was found at last, {at_least_mm(search.best.clearance, 1)} mm certified."
        if self.cause is not None and self.cause.proven:
            lines = [f"{task.name}: there is no route to the target."]
        else:
            passages = "one passage" if search.passages == 1 else f"{search.passages} passages"
            among = f" among {passages}" if search.passages else ""
            lines = [f"{task.name}: no route to the target was found{among}."]
            if search.cut_short:
                lines.append(search.cut_short)
        lines += self.said
        lines += [relaxation.sentence for relaxation in relaxations.found]
        if relaxations.in_vain:
            lines.append(f"{'not even' if not relaxations.found else 'not'} with {'; '.join(relaxations.in_vain)}")
        if relaxations.untried:
            lines.append(f"no time was left to try {'; '.join(relaxations.untried)}; give more time, or no limit")
        if self.part is not None:
            lines.append(
                f"the good insertion that comes closest feeds {1e3 * self.part.feed[-1]:.0f} mm and ends at "
                f"{point(self.part.body[-1, -1], '.0f')}, {1e3 * self._left(self.part):.0f} mm from the target"
            )
        return "\n  ".join([*lines, *([more] if more else [])])

    def _offer(self, judged: Judged) -> None:
        """Keep the insertion along the beginning of a spline if it comes closest to the target so far."""
        part = partial.along(self.task, judged)
        if part is not None and (self.part is None or self._left(part) < self._left(self.part)):
            self.part = part

    def _left(self, part: Plan) -> float:
        """How far (m) a partial insertion ends from the target."""
        return float(np.linalg.norm(part.body[-1, -1] - self.task.way_points[-1]))

    def _faults(self) -> list[str]:
        """What the closest spline exceeds: the one of a relaxation, if there is one, as it needs no more than that."""
        relaxations, where = self.relaxations, "on the way that came closest"
        spline = self.search.closest or next(iter(relaxations.closest), None)
        if relaxations.found:
            spline, where = relaxations.found[0].judged, f"on the way found with {relaxations.found[0].words}"
        closest = None if spline is None else judge(objective_of(self.task, spline.objective), spline.way_points)
        said = [] if closest is None else list(faults(self.task, closest))
        if not relaxations.found:
            said += [check.sentence for plan in self.search.refused[:1] for check in plan.checks if check.failed]
        return [f"{where}: {'; '.join(said)}"] if said else []


def faults(task: Task, closest: Judged) -> Iterator[str]:
    """What a spline exceeds, in sentences."""
    robot, motion, used = closest.objective.robot, closest.motion, closest.overruns
    # Where the base would have to leave the slider its angle means nothing.
    most = closest.objective.base.feed_limit(robot)
    within = motion.feeds <= most
    ratio = bends.used(motion.angles[within], robot.bend_bounds)
    step, section, axis = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    if ratio[step, section, axis] > 1:
        angles = motion.angles[step]
        angle, limit = np.degrees([np.abs(angles), bends.on_side(angles, robot.bend_bounds)])[:, section, axis]
        place, more = point(motion.joints[step, section], ".0f"), angle - limit
        yield f"section {section + 1} would have to bend {angle:.1f} deg at {place}, {more:.1f} deg more than it can"
    speed, limit = np.degrees(np.abs(closest.speeds[within[1:]]).max(initial=0.0)), robot.spec.limits.joint_speed_deg_s
    if speed > limit:
        yield f"a joint would have to turn at {speed:.1f} deg/s; it can at {limit:g} deg/s"
    if used["turn"] > 1:
        turned, most = np.degrees([closest.turn_rates.max(), closest.objective.turn_speed])
        yield f"the carrier would have to turn the arm at {turned:.1f} deg/s; it can at {most:g} deg/s"
    if used["reach"] > 1:
        yield f"the arm is {1e3 * (motion.feeds[-1] - most):.1f} mm too short for the way that was found"
    if used.get("workspace", 0.0) > 1:
        away = np.linalg.norm(closest.outside, axis=1)
        step = int(np.argmax(away))
        place = point(motion.joints[step, 0], ".0f")
        yield f"the first joint would have to be at {place}, {1e3 * away[step]:.1f} mm outside base.workspace"
    if used.get("tip", 0.0) > 1:
        angle = used["tip"] * np.degrees(closest.objective.tip_cone)
        cone = task.spec.path.tip_cone_deg
        yield f"the nose points {angle:.1f} deg away from tip_direction; tip_cone_deg is {cone:g}"
    if closest.touching is not None:
        row, first, second = closest.touching
        own = OwnBody.chain(robot.link_lengths, robot.body_radii, task.base.mount)
        body = mounted(task.base, motion.joints[row, None], motion.at[row, None])[0]
        _, place = own.apart(body, first, second)
        both = f"{part_of_body(first, 'section')} and {part_of_body(second, 'section')}"
        yield f"the arm would touch itself: {both}, at {point(place, '.0f')}"
    if closest.clearance < closest.objective.margin:
        yield _tightest(closest)


def _tightest(judged: Judged) -> str:
    """Where the links of a spline come closest, in a sentence."""
    row = int(np.argmin(judged.clearances))
    step, chord = judged.step[row], judged.chord[row]
    witness = judged.objective.scene.witness(judged.motion.line[step, chord], judged.motion.line[step, chord + 1])
    at = f"{witness.obstacle!r} at {point(witness.on_mesh, '.0f')}"
    if witness.distance < 1e-6:
        return f"a link would run into {at}"
    away, wanted = beside_limit(1e3 * judged.clearance, 1e3 * judged.objective.margin, lower_bound=True)
    return f"a link would be {away} mm from {at}; {wanted} mm are wanted"
