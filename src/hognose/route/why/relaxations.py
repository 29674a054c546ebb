"""How much of a change makes a route possible, by solving the changed task again."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from hognose.errors import InfeasibleError
from hognose.planning.base_limits import BaseLimits
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.task import Task
from hognose.route.fit.improve import improved
from hognose.route.fit.objective import Judged, Objective, judge
from hognose.route.search.search import Found, Search
from hognose.route.why.causes import Cause
from hognose.route.why.changes import Change
from hognose.wording import at_least_mm

#: Passages that are tried for a changed task.
PASSAGES = 2
#: So many changes are searched for, while none helps; the others are only tried close to splines that are known.
SEARCHED = 3
#: Clearance (m) above the margin at which a spline is good enough.
SPARE = 1e-3


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A change with which there is a route.

    Attributes
    ----------
    words
        The change, to be read after "with".
    plan
        The route, of the changed task.
    judged
        Its spline, as the changed arm follows it.
    amount
        Of the change.
    smallest
        Whether smaller amounts were tried as far as they make sense.
    """

    words: str
    plan: Plan
    judged: Judged
    amount: float = 0.0
    smallest: bool = True

    @property
    def clearance(self) -> float:
        """Certified, m."""
        return self.plan.certified_clearance or 0.0

    @property
    def sentence(self) -> str:
        """What to say of it."""
        less = "" if self.smallest else "; less may do"
        return f"with {self.words} a route is found ({at_least_mm(self.clearance, 1)} mm certified){less}"


def has_all_time() -> bool:
    """The patience of whoever asks without a limit."""
    return True


@dataclass(eq=False)
class Variation(Search):
    """A search for a changed task: it ends at the first route, or when whoever asks has no more time."""

    most: int = PASSAGES
    has_time: Callable[[], bool] = has_all_time

    def goes_on(self) -> bool:
        """Whether there is no route yet, and time."""
        return self.best is None and self.has_time()


@dataclass(eq=False)
class Relaxations:
    """Changes tried one after another for a search that found nothing.

    Attributes
    ----------
    found
    in_vain
        Changes with which no route was found, in words.
    untried
        Changes for which there was no time.
    closest
        Splines that came closest with changes that were in vain.
    """

    search: Search
    found: list[Relaxation] = dataclasses.field(default_factory=list)
    in_vain: list[str] = dataclasses.field(default_factory=list)
    untried: list[str] = dataclasses.field(default_factory=list)
    closest: list[Judged] = dataclasses.field(default_factory=list)
    _at_hand: Relaxation | None = None

    def run(self, cause: Cause) -> Iterator[Relaxation]:
        """Yield the smallest amount that helps of each change; if none does, of two at once.

        Ends at once where nothing has to be changed after all: the search has found a route then.
        """
        for number, change in enumerate((*cause.changes, cause.pair)):
            if change is None or (change is cause.pair and (self.found or not self.search.asks_on())):
                return
            relaxation = self._tried(change, not self.found and (number < SEARCHED or change is cause.pair))
            if relaxation is None:
                continue
            if not cause.proven and relaxation.words == change.words(change.amounts[0]) and self._unchanged(relaxation):
                return
            self.found.append(relaxation)
            yield relaxation

    def _tried(self, change: Change, thoroughly: bool) -> Relaxation | None:
        """Try a change; once one has helped, and if it is not plausible, only close to the splines that are known."""
        words, self._at_hand = change.words(change.amounts[-1]), None
        known = [self.search.closest, *(relaxation.judged for relaxation in self.found)]
        near = [spline for spline in known if spline is not None]
        try:
            relaxation = self._least(change, near, thoroughly) if self.search.asks_on() else None
        except KeyboardInterrupt:
            if self._at_hand is not None:
                self.found.append(dataclasses.replace(self._at_hand, smallest=False))
            raise
        if relaxation is None and not self.search.asks_on():
            self.untried.append(words)
        elif relaxation is None and thoroughly:
            self.in_vain.append(words)
        return relaxation

    def _unchanged(self, relaxation: Relaxation) -> bool:
        """Whether the smallest of changes led to a spline that is good without any."""
        search = self.search
        made = self._refitted(search.task, relaxation.judged)
        if made is not None:
            search.found.append(Found(made.plan, made.clearance, search.spent, search.passages))
        return made is not None

    def _least(self, change: Change, near: list[Judged], thoroughly: bool) -> Relaxation | None:
        """The smallest amount with which a route is found, by bisection from the largest one."""
        low, high = -1, len(change.amounts) - 1
        best = self._made(change, high, near, thoroughly)
        if best is None:
            return None
        self._at_hand = best
        while high - low > 1 and self.search.asks_on():
            # The smallest one first: it is the one that was computed from what is missing.
            middle = 0 if low < 0 else (low + high) // 2
            found = self._made(change, middle, [best.judged], False)
            low, high = (middle, high) if found is None else (low, middle)
            self._at_hand = best = found or best
        best = dataclasses.replace(best, smallest=high - low <= 1)
        if change.then is None or not best.smallest:
            return best
        return self._least(change.then(best.amount), [best.judged], False) or best

    def _made(self, change: Change, index: int, near: list[Judged], thoroughly: bool) -> Relaxation | None:
        """A route with one amount of a change, close to splines that are known, or searched."""
        amount = change.amounts[index]
        words = change.words(amount)
        task = change.made(self.search.task, amount)
        if task is None:
            return None
        self.search.progress(f"trying {words}")
        made = next(filter(None, (self._refitted(task, spline) for spline in near)), None)
        if made is None and thoroughly:
            made = self._searched(task)
        return None if made is None else dataclasses.replace(made, words=words, amount=amount)

    def _refitted(self, task: Task, near: Judged) -> Relaxation | None:
        """A route close to a spline of another arm or task."""
        enough = task.clearance_wanted + SPARE
        good = [
            judged
            for judged in improved(objective_of(task, near.objective), near.way_points, enough, self.search.asks_on)
            if judged.feasible and judged.clearance >= task.clearance_wanted
        ]
        try:
            return Relaxation("", plan_along(task, way_points=good[-1].way_points), good[-1]) if good else None
        except InfeasibleError:
            return None

    def _searched(self, task: Task) -> Relaxation | None:
        """A route that is searched from scratch."""
        other = Variation(task, None, self.search.seed, has_time=self.search.asks_on)
        other.run()
        if other.closest is None:
            return None
        if other.best is None:
            self.closest.append(other.closest)
            return None
        judged = judge(other.closest.objective, other.best.plan.way_points)
        return None if judged is None else Relaxation("", other.best.plan, judged)


def objective_of(task: Task, old: Objective) -> Objective:
    """What is wanted of a route along the same passage, for another arm or task."""
    motion, direction = task.spec.motion, task.spec.path.tip_direction
    return dataclasses.replace(
        old,
        robot=task.robot,
        base=task.base,
        draw=task.path_through,
        feed_speed=motion.feed_speed,
        margin=task.clearance_wanted,
        tip_direction=None if direction is None else np.array(direction) / np.linalg.norm(direction),
        tip_cone=float(np.radians(task.spec.path.tip_cone_deg)),
        turn_speed=BaseLimits.of(task).turn_speed,
        method=motion.method,
    )
