"""A plan on the twin: what the arm does that the plan wants moved."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance, positive
from hognose.errors import InputError
from hognose.mechanics.sensitivity import bends_of_cables
from hognose.planning import Plan
from hognose.sim.changes import Changes
from hognose.sim.set_points import SetPoints, planned_at
from hognose.sim.simulated import ContactStop, Simulated, Touched
from hognose.sim.twin import Twin

Array = NDArray[np.float64]

#: For so long (s) the motors hold after a contact that stopped them.
SETTLING = 1.0


class SimulationInterrupted(KeyboardInterrupt):
    """Ctrl-C while a plan was simulated.

    Attributes
    ----------
    done
        What was done by then.
    """

    def __init__(self, done: Simulated) -> None:
        super().__init__(f"{done.plan.task.name}: {done.stopped}")
        self.done = done


def simulate(
    plan: Plan,
    changes: Changes | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    stop_at_contact: float | None = None,
) -> Simulated:
    """Move the twin through a plan, with set-points interpolated within the periods.

    It begins at rest at the first step, or near it where an arm with such changes rests. It is stopped at once if a
    link is inside an obstacle; else when an axis crosses a surface, when the arm buckles, or, if asked for, by a
    contact.

    Parameters
    ----------
    plan
    changes
        How arm and space differ from what was planned with.
    progress
        Called with the periods that are done, and how many there are.
    stop_at_contact : N
        Where a link is pressed with more than this all motors hold their set-points, and so does the base.

    Raises
    ------
    InputError
        An argument is of another kind, the mechanics of the robot are not known, the changes do not fit, or the time
        step is too long for the stiffness.
    MissingExtraError
        MuJoCo is not installed.
    SimulationInterrupted
        On Ctrl-C: with what was done.
    """
    instance("plan", plan, Plan, "a hognose.Plan")
    if not callable(progress):
        raise InputError("progress: expected a function of the periods that are done, and how many there are")
    limit = None if stop_at_contact is None else positive("stop_at_contact", stop_at_contact, "N")
    run, last = _Run(plan, Changes() if changes is None else changes, limit), len(plan.time) - 1
    try:
        for period in range(1, last + 1):
            if run.stopped:
                break
            run.go(SetPoints.of(plan, period, run.longest_step, run.changes.lag), period)
            progress(period, last)
    except KeyboardInterrupt:
        run.stopped = run.stopped or f"period {run.period}: interrupted"
        raise SimulationInterrupted(run.simulated()) from None
    return run.simulated()


class _Row(NamedTuple):
    """The end of a period; names as of `Simulated`, where each is a column."""

    time: float
    commanded: Array
    at: Array
    section_lengths: Array
    angles: Array
    joints: Array
    tensions: Array
    lowest_tensions: Array
    highest_tensions: Array
    end_tensions: Array
    smallest_stiffness: float
    load_factor: float
    contact: Array
    pressing: NDArray[Any]


class _Run:
    """A plan on its way through the twin."""

    def __init__(self, plan: Plan, changes: Changes, limit: float | None) -> None:
        twin = Twin(plan.task, changes)
        self.plan, self.changes, self.limit, self.twin = plan, changes, limit, twin
        self.stopped, self.period = "", 0
        self.touches: dict[str, Touched] = {}
        self.contact_stop: ContactStop | None = None
        self._rows: list[_Row] = []
        first = plan.at[0], plan.angles[0]
        bends, still = float(bends_of_cables(plan.robot, plan.angles).sum(axis=1).max()), np.zeros(plan.robot.sections)
        # Short sections are lighter and stiffer: the step is for the shortest, and the longest, that they get.
        lengths = plan.section_lengths
        for extreme in (lengths.min(axis=0), lengths.max(axis=0)) if plan.robot.extends else ():
            self._extend(extreme, still)
            twin.put(*first)
            twin.shorten_step(bends)
        self._extend(lengths[0], still)
        twin.put(*first)
        twin.shorten_step(bends)
        self.longest_step = twin.time_step
        self._begun = time.perf_counter()
        self._most, self._by = np.zeros(plan.robot.sections), np.full(plan.robot.sections, "", object)
        if changes.of_the_arm:
            rest = twin.resting(*first, plan.commanded_lengths[0])
            twin.put(first[0], first[1] if rest is None else rest, plan.commanded_lengths[0])
        self._end(0.0)
        within = twin.inside(float(plan.clock[0]))
        if within is not None:
            self.stopped = f"start: link {within[0] + 1} is inside {within[1]}"

    def go(self, given: SetPoints, period: int) -> None:
        """A control period, or what of it is done until something stops it."""
        self.period, self.twin.time_step = period, given.step
        done = self._steps(given, self.limit)
        self._end(given.begin + done * given.step)
        self.stopped = self._reason()
        if self.contact_stop is not None and not self.stopped:
            self._hold(given, done)

    def _steps(self, given: SetPoints, limit: float | None) -> int:
        """Go through set-points; how many steps were done."""
        twin = self.twin
        self._within()
        for k in range(len(given.lengths)):
            clock = given.clock + k * given.step
            self._extend(given.sections[k], given.section_speeds)
            twin.step(given.lengths[k], given.speeds, given.bases[k], given.base_speeds[k], clock)
            if twin.touches:
                now = given.begin + k * given.step
                link, obstacle, force = self._press(now)
                if limit is not None and force > limit:
                    self.contact_stop = ContactStop(now, link, obstacle, limit, force)
                    twin.carry(given.bases[k])
                    return k + 1
            if twin.crossed:
                return k + 1
        twin.carry(given.bases[-1])
        self._extend(given.sections[-1], given.section_speeds)
        return len(given.lengths)

    def _extend(self, lengths: Array, speeds: Array) -> None:
        if self.plan.robot.extends:
            self.twin.extend(lengths, speeds)

    def _within(self) -> None:
        """Begin to note what happens until the next row."""
        n = self.plan.robot.sections
        self.twin.tension_range()
        self._most, self._by = np.zeros(n), np.full(n, "", object)

    def _press(self, now: float) -> tuple[int, str, float]:
        """Note what presses the links; the link, the obstacle and the force (N) that are the worst."""
        forces: dict[tuple[int, str], float] = {}
        for touch, force in self.twin.touches:
            forces[touch.link, touch.obstacle] = forces.get((touch.link, touch.obstacle), 0.0) + force
        for (link, obstacle), force in forces.items():
            if force > self._most[link] or not self._by[link]:
                self._by[link] = obstacle
            before = self.touches.get(obstacle, Touched(now, -1.0, link))
            if force > before.largest:
                self.touches[obstacle] = Touched(before.first, force, link)
        np.maximum(self._most, self.twin.pressed, out=self._most)
        (link, obstacle), force = max(forces.items(), key=lambda item: item[1])
        return link, obstacle, force

    def _end(self, now: float) -> None:
        """Add a row at a time (s)."""
        twin, stop = self.twin, self.contact_stop
        commanded, at = planned_at(self.plan, now if stop is None else min(now, stop.time))
        lowest, highest = twin.tension_range()
        pulls = twin.tensions, lowest, highest, twin.end_tensions
        pressed = self._most, self._by
        self._rows.append(
            _Row(now, commanded, at, twin.sections, twin.angles, twin.joints, *pulls, *twin.stability(), *pressed)
        )

    def _reason(self) -> str:
        """Why it must stop; empty if it need not."""
        twin, row = self.twin, self._rows[-1]
        if twin.fell_apart or not np.isfinite(row.smallest_stiffness):
            return (
                f"period {self.period}: the integration fell apart; its step of {1e3 * twin.time_step:g} ms is too long"
            )
        if twin.crossed:
            link, obstacle = twin.crossed
            return f"period {self.period}: the axis of link {link + 1} has crossed the surface of {obstacle}"
        if row.smallest_stiffness < 0:
            return f"period {self.period}: {self._buckles(row.smallest_stiffness)}"
        return ""

    def _buckles(self, smallest: float) -> str:
        """That the arm buckles by its smallest eigenvalue (N m/rad): where, and what has to do with it."""
        twin = self.twin
        touched = {(touch.link + 1, touch.obstacle): None for touch, _ in twin.touches}  # in order, each once
        beside = [f"link {link} touches {obstacle}" for link, obstacle in touched]
        slack = int(np.count_nonzero(twin.tensions <= 0))
        if slack:
            beside.append(f"{slack} {'cable is' if slack == 1 else 'cables are'} slack")
        return (
            f"the arm buckles: the smallest eigenvalue of its stiffness is {smallest:.3g} N m/rad; section "
            f"{twin.softest_section() + 1} turns most{''.join(f', {words}' for words in beside)}; `hognose mechanics` "
            "says how far the plan is from it"
        )

    def _hold(self, given: SetPoints, done: int) -> None:
        """All motors hold, until the arm has settled."""
        duration, held, gone = len(given.lengths) * given.step, 0.0, done
        peak, failed = 0.0, ""
        while held < SETTLING - 1e-9 and not failed:
            given = given.held(gone, min(duration, SETTLING - held))
            gone = self._steps(given, None)
            held += gone * given.step
            self._end(given.begin + gone * given.step)
            peak, failed = max(peak, float(self._most.max())), self._reason()
        stop = self.contact_stop
        assert stop is not None, "only called after a contact"
        self.contact_stop = replace(
            stop,
            peak=peak,
            settled=round(held, 9),
            remaining=float(self.twin.pressed.max()),
            tip_error=self._tip_error(),
        )
        self.stopped = failed or f"period {self.period}: {self.contact_stop.sentence}"

    def _tip_error(self) -> float:
        return float(self.simulated().tip_errors[-1])

    def simulated(self) -> Simulated:
        """What was done so far."""
        columns = {name: np.array([getattr(row, name) for row in self._rows]) for name in _Row._fields}
        took = time.perf_counter() - self._begun
        contact = {"touches": dict(self.touches), "stopped": self.stopped, "contact_stop": self.contact_stop}
        return Simulated(self.plan, self.changes, **columns, **contact, seconds=took)
