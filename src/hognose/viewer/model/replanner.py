"""A thread that plans a task anew whenever it was edited, the newest edit only."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError, InfeasibleError
from hognose.planning import Check, Plan, Task
from hognose.planning.link_budgets import clearance_left
from hognose.planning.planner import plan_along, refuse_buried_places
from hognose.viewer.model.edits import solids
from hognose.wording import at_least_mm

Array = NDArray[np.float64]

#: The thread does what can wait after so many seconds without a question, and after so many seconds at last.
REST, LONGEST_WITHOUT_REST = 0.5, 5.0


@dataclass(frozen=True, eq=False)
class Verdict:
    """What became of an edit.

    Attributes
    ----------
    number
        Of the edit it judges.
    task
        As it was edited.
    plan
        The motion as far as it was made, good or not; where the detour fails, without detours. None if there is none.
    good
        Whether every check passed.
    headline
        The verdict in one line.
    problems
        What is wrong, sentence by sentence, the worst first; empty if it is good.
    step
        Of the plan, where it fails by most; None if it fails nowhere in particular.
    seconds
        That planning took.
    """

    number: int
    task: Task = field(repr=False)
    plan: Plan | None = field(repr=False)
    good: bool
    headline: str
    problems: tuple[str, ...]
    step: int | None
    seconds: float

    @property
    def checks(self) -> tuple[Check, ...]:
        """Every check that was made of the plan, those too that passed or were not judged."""
        return () if self.plan is None else self.plan.checks


@dataclass(frozen=True, eq=False)
class Question:
    """A task to be judged.

    Attributes
    ----------
    route : (m, 3) m or None
        For a task with a target: way-points that a search found.
    """

    number: int
    task: Task
    route: Array | None = None


def share_scene(task: Task, other: Task) -> None:
    """Give a task the scene that was built for another one if both have the same obstacles."""
    if "scene" in vars(other) and "scene" not in vars(task) and solids(task.spec) == solids(other.spec):
        task.share_obstacles(other)


def judged(question: Question) -> Verdict:
    """The verdict on a task: the whole plan with all of its checks."""
    begin = time.perf_counter()
    plan, step = None, None
    problems: tuple[str, ...] = ()
    try:
        plan = _planned(question)
        headline = _praise(plan)
    except InfeasibleError as error:
        plan = error.plan
        failed = [] if plan is None else sorted((check for check in plan.checks if check.failed), key=_missed)[::-1]
        plan = plan or _as_it_is(question.task)
        sentences = tuple(check.sentence for check in failed)
        advice = tuple(line for line in _lines(error)[1:] if line not in sentences)
        problems = (*sentences, *advice) if sentences else _lines(error)
        headline, step = f"NOT GOOD: {problems[0]}", _where(plan, failed)
    except HognoseError as error:
        problems = _lines(error)
        headline = problems[0]
    except Exception as error:  # a fault of ours must not end the thread
        logging.getLogger(__name__).exception("planning failed")
        problems = (f"planning failed because of a fault in Hognose: {error!r}. Undo the edit.",)
        headline = problems[0]
    seconds = time.perf_counter() - begin
    return Verdict(question.number, question.task, plan, not problems, headline, problems, step, seconds)


def _planned(question: Question) -> Plan:
    task, route = question.task, question.route
    if task.spec.path.target is None:
        return plan_along(task)
    if route is None:
        refuse_buried_places(task)
        raise InfeasibleError("no route yet: press Find a route")
    between = np.concatenate([task.way_points[:1], route[1:-1], task.way_points[-1:]])
    return plan_along(task, way_points=between)


def _as_it_is(task: Task) -> Plan | None:
    """Where no detour leads round what the arm hits, the motion that hits it: something to look at."""
    if task.spec.path.target is not None or not task.spec.path.detour:
        return None
    try:
        return plan_along(task, way_points=task.way_points)
    except InfeasibleError as error:
        return error.plan
    except HognoseError:
        return None


def _praise(plan: Plan) -> str:
    proven, at_steps = (
        f"GOOD: {at_least_mm(plan.certified_clearance or 0.0)} mm certified",
        plan.check("clearance_at_steps"),
    )
    if at_steps.obstacle is None:
        return f"{proven}, nothing is closer than {1e3 * plan.horizon:g} mm at the steps"
    return f"{proven}, closest to {at_steps.obstacle}"


def _missed(check: Check) -> tuple[bool, float]:
    """By how much a check is missed, in parts of its limit; those that fail nowhere in particular count least."""
    over = check.limit - check.value if check.at_least else check.value - check.limit
    return check.step is not None, over / max(abs(check.limit), 1e-12)


def _where(plan: Plan | None, failed: list[Check]) -> int | None:
    """The step to look at: of the worst check, or where the arm is closest if it is too close."""
    if plan is None:
        return None
    if failed:
        return failed[0].step
    left = clearance_left(plan).min(axis=1)
    row = int(left.argmin())
    return row if left[row] < plan.task.margin else None


def _lines(error: HognoseError) -> tuple[str, ...]:
    return tuple(line.strip() for line in str(error).splitlines() if line.strip()) or (type(error).__name__,)


class Replanner:
    """The thread. Of questions that come while it plans, only the last is ever looked at.

    Parameters
    ----------
    rest
        Called by the thread when there is time for what can wait.

    Attributes
    ----------
    verdict
        The newest one, or None before the first.
    made
        How many verdicts there were.
    """

    def __init__(self, rest: Callable[[], None]) -> None:
        self.verdict: Verdict | None = None
        self.made = 0
        self._rest = rest
        self._changed = threading.Condition()
        self._question: Question | None = None
        self._closed = False
        self._asked_at: float | None = None  # the first and the last question since it rested
        self._asked_last = 0.0
        self._planned: Task | None = None
        self._thread = threading.Thread(target=self._work, name="hognose-replanner", daemon=True)
        self._thread.start()

    def ask(self, question: Question) -> None:
        """Have a task judged; one that still waits is forgotten."""
        with self._changed:
            self._question = question
            self._asked_last = time.monotonic()
            self._asked_at = self._asked_at or self._asked_last
            self._changed.notify_all()

    def settle(self, number: int, timeout: float) -> Verdict:
        """Wait for the verdict on this question, or a later one.

        Raises
        ------
        HognoseError
            It did not come in `timeout` seconds, or the thread was closed.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._has(number), timeout)
            if self.verdict is None or not self._has(number):
                why = "the workbench was closed" if self._closed else f"it takes longer than {timeout:g} s"
                raise HognoseError(f"no verdict on edit {number}: {why}. Wait longer, or take larger steps.")
            return self.verdict

    def close(self) -> None:
        """End the thread, after what it is doing; may be called again."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _has(self, number: int) -> bool:
        return self.verdict is not None and self.verdict.number >= number

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._question, self._until_rest())
                if self._closed:
                    return
                question, self._question = self._question, None
            if question is not None:
                self._judge(question)
            if self._until_rest() == 0:
                self._asked_at = None
                self._rest()

    def _judge(self, question: Question) -> None:
        if self._planned is not None:
            share_scene(question.task, self._planned)
        self._planned = question.task
        verdict = judged(question)
        with self._changed:
            self.verdict = verdict
            self.made += 1
            self._changed.notify_all()

    def _until_rest(self) -> float | None:
        """Seconds until there is time to rest; None if nothing was asked since."""
        if self._asked_at is None:
            return None
        return max(0.0, min(self._asked_last + REST, self._asked_at + LONGEST_WITHOUT_REST) - time.monotonic())
