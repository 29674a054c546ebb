"""The search for a route: passages, a spline through each, the best one verified by the planner."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.kernels import time_without_compiling
from hognose.planning.base_limits import BaseLimits
from hognose.planning.checks import Check
from hognose.planning.plan import Plan
from hognose.planning.planner import horizon_of, plan_along
from hognose.planning.task import Task
from hognose.route.fit.improve import improved
from hognose.route.fit.initial_splines import better_start, numbers_of_spans, spread
from hognose.route.fit.objective import Judged, Objective
from hognose.route.lengths import Lengths, longest_way
from hognose.route.polyline import even
from hognose.route.search.bottleneck import narrowest
from hognose.route.search.cheapest_ways import along, cost_to_go
from hognose.route.search.clearance_grid import ClearanceGrid, search_grid
from hognose.route.search.elastic_band import relaxed
from hognose.route.search.passages import Wish, noise, passage, price
from hognose.route.search.refusals import unmendable
from hognose.wording import at_least_mm

Array = NDArray[np.float64]
Progress = Callable[[str], None]

#: Where no time is given, one passage is enough that leaves so many margins of clearance.
ENOUGH = 3.0
#: Passages tried where no time is given: this many, and while nothing is found, up to so many.
PASSAGES, MOST_PASSAGES = 2, 14
#: After so many attempts without a plan it is looked whether all ways are too narrow.
BLOCKED = 8
#: What a passage is asked to bend at most, in parts of what joints can about one axis, and how greedy its search is.
MANNERS = ((0.85, 1.3), (0.97, 1.6), (0.7, 1.15), (1.2, 2.0))
#: After each round of manners without a plan passages may bend so many times as much: about both axes joints bend 1.4
#: times as far as about one, and links are chords, so that a curve may bend more sharply for a short while.
STRETCHES = (1.0, 1.45, 2.1)
#: What a passage may be narrower than needed, in parts of half the width: the grid is coarse, and links do not take the
#: curve's places.
SLACK = (0.13, 0.26, 0.0)
#: A plan is made of a spline whose clearance is better by this part of half the width needed than the best plan so far.
WORTH_A_PLAN = 0.016
#: Of the clearance that a plan lacked, this part must have been gained before the next is made.
LACKING = 0.3
#: Around a passage found this far, in parts of half the width needed, the next one pays more.
BESIDE = 1.6
#: Waves of the noise on the price of passages: so many radians on the arm's reach, in standard deviation.
WAVES = 22.0


@dataclass(frozen=True)
class Found:
    """A plan that the search found.

    Attributes
    ----------
    plan
        Good: all checks passed.
    clearance : m
        Certified.
    seconds
        Since the search began.
    passage
        Of which passage, counted from 1.
    """

    plan: Plan
    clearance: float
    seconds: float
    passage: int


class ClosedOffError(Exception):
    """No way over the grid is wide enough, however it bends."""


def _say_nothing(stage: str) -> None:
    """The progress of a search that nobody watches."""


@dataclass(eq=False)
class Search:
    """A search at work: what it has found, and what came closest.

    Attributes
    ----------
    found
        Every plan that was better than all before it.
    closest
        The spline that exceeds its limits least, while there is no plan.
    refused
        Plans that looked good coarsely and failed a check.
    unmendable
        What failed and would along any other route; the search ends with it.
    passages
        How many were found.
    attempts
        How often one was searched.
    most
        How many are tried where no time is given.
    gives_up
        Part of the time after which it ends if it has found nothing.
    began : s
        When, on the clock of `hognose.kernels.time_without_compiling`.
    interrupted
        Whether Ctrl-C ended it.
    """

    task: Task
    seconds: float | None
    seed: int
    progress: Progress = _say_nothing
    most: int = MOST_PASSAGES
    found: list[Found] = field(default_factory=list)
    closest: Judged | None = None
    refused: list[Plan] = field(default_factory=list)
    unmendable: Check | None = None
    passages: int = 0
    attempts: int = 0
    gives_up: float = 1.0
    began: float = field(default_factory=time_without_compiling)
    interrupted: bool = False
    _ended: str = ""
    _worth_a_try: float = 0.0  # clearance (m) of a spline below which its plan is known to fail

    @property
    def best(self) -> Found | None:
        """The best plan so far."""
        return self.found[-1] if self.found else None

    @property
    def spent(self) -> float:
        """Seconds since the search began, but for those in which something was compiled."""
        return time_without_compiling() - self.began

    @property
    def cut_short(self) -> str:
        """What ended the search before it had tried all it could, in a sentence; empty if nothing did."""
        if not self._ended:
            return ""
        tried = "one attempt" if self.attempts == 1 else f"{self.attempts} attempts"
        return f"the search was cut short: {self._ended} {tried}; more time may find a route"

    def asks_on(self) -> bool:
        """Whether there is time left to find out why nothing was found: half as much as was searched."""
        return self.seconds is None or self.spent < 1.5 * self.seconds + 1.0

    def goes_on(self) -> bool:
        """Whether there is time left."""
        return self.seconds is None or self.spent < self.seconds * (1.0 if self.found else self.gives_up)

    def run(self) -> None:
        """Try passage after passage until time or patience ends; interrupted, keep what there is if there is any."""
        try:
            for number, guide in enumerate(self._guides(), 1):
                self.passages = number
                fewer = None
                lengths = Lengths.of_task(self.task)
                for spans in numbers_of_spans(guide, self.task.robot, lengths):
                    if not self.goes_on():
                        self._ended = self._over
                        return
                    fewer = self._follow(guide, spans, number, fewer)
                    if self._is_enough or self.unmendable is not None:
                        return
                if self._is_done(number):
                    return
        except KeyboardInterrupt:
            self._ended, self.interrupted = "it was interrupted after", True
            if self.best is None:
                raise

    @property
    def _over(self) -> str:
        return "" if self.seconds is None else f"its {self.seconds:g} s were over after"

    @property
    def _is_enough(self) -> bool:
        """Whether no better plan is worth the time."""
        if self.best is None:
            return False
        wanted = self.task.clearance_wanted
        most = wanted + 0.9 * (horizon_of(self.task) - wanted)
        return self.best.clearance >= (most if self.seconds is not None else min(ENOUGH * wanted, most))

    def _is_done(self, number: int) -> bool:
        return self._is_enough or (self.seconds is None and self.best is not None and number >= PASSAGES)

    def _follow(self, guide: Array, spans: int, number: int, fewer: Judged | None) -> Judged | None:
        """The spline through one passage, made better and better; begun at one of fewer spans if that is better."""
        task, direction = self.task, self.task.spec.path.tip_direction
        way_points, free = spread(guide, task.way_points, spans)
        objective = Objective(
            robot=task.robot,
            base=task.base,
            scene=task.scene,
            draw=task.path_through,
            order=task.spec.path.order,
            feed_speed=task.spec.motion.feed_speed,
            margin=task.clearance_wanted,
            guide=even(guide, longest_way(task) / 200),
            free=free,
            tip_direction=None if direction is None else np.array(direction) / np.linalg.norm(direction),
            tip_cone=float(np.radians(task.spec.path.tip_cone_deg)),
            turn_speed=BaseLimits.of(task).turn_speed,
            method=task.spec.motion.method,
        )
        last, best = None, fewer
        objective, way_points = better_start(objective, way_points, fewer, task.way_points, spans)
        for judged in improved(objective, way_points, horizon_of(self.task), self.goes_on):
            last = judged
            if best is None or judged.score > best.score:
                best = judged
            if self.closest is None or judged.score > self.closest.score:
                self.closest = judged
            wanted = max(task.clearance_wanted, self._worth_a_try)
            if self.best is None and judged.feasible and judged.clearance >= wanted:
                self._verify(judged, number)
                if self.unmendable is not None:
                    return best
        worth = -np.inf if self.best is None else self.best.clearance + WORTH_A_PLAN * objective.lengths.half
        if last is not None and last.feasible and last.clearance >= max(worth, task.clearance_wanted):
            self._verify(last, number)
        return best

    def _verify(self, judged: Judged, number: int) -> None:
        try:
            made = plan_along(self.task, way_points=judged.way_points)
        except InfeasibleError as error:
            if error.plan is not None:
                self.refused.append(error.plan)
                self.unmendable = unmendable(self.refused) if self.best is None else None
                if not self.task.robot.straight_links:  # coarse steps see more clearance there than there is
                    lacks = self.task.clearance_wanted - (error.plan.certified_clearance or 0.0)
                    self._worth_a_try = judged.clearance + LACKING * max(lacks, 0.0)
            return
        clearance = made.certified_clearance or 0.0
        if self.best is None or clearance > self.best.clearance:
            self.found.append(Found(made, clearance, self.spent, number))
            self.progress(f"route with {at_least_mm(clearance, 1)} mm certified, passage {number}")

    def _guides(self) -> Iterator[Array]:
        """Passage after passage, each as points from the entrance to the target."""
        task = self.task
        if not self.goes_on():
            self._ended = self._over
            return
        self.progress("measuring the clearance grid")
        stops, lengths = task.way_points, Lengths.of_task(task)
        grid = search_grid(task)
        random = np.random.default_rng(self.seed)
        factor = np.ones(grid.distance.shape)
        closed: set[float] = set()
        for attempt in range(self.most if self.seconds is None else 10_000):
            if len(closed) == len(SLACK):
                return
            if not self.goes_on():
                self._ended = self._over
                return
            if attempt == BLOCKED and self.best is None:
                gap = narrowest(task, grid)
                if gap is not None and (gap.proven or self.seconds is None):
                    return
            self.attempts = attempt + 1
            self.progress(f"searching passage {attempt + 1}")
            bend, greed = MANNERS[attempt % len(MANNERS)]
            bend *= STRETCHES[attempt // len(MANNERS) % len(STRETCHES)]
            slack = SLACK[attempt % len(SLACK)]
            if slack in closed:
                continue
            need = (1.0 - slack) * lengths.half
            wide, longest = need + lengths.wide - lengths.half, 1.01 * lengths.reach
            wish = Wish(need, wide, bend / lengths.turn, longest, lengths.move)
            try:
                guide = _through(grid, price(grid, wish) * factor, stops, task.base.direction, wish, greed)
            except ClosedOffError:
                closed.add(slack)
                continue
            if guide is None:
                factor *= noise(grid, random, 0.3, WAVES / lengths.reach)
                continue
            yield guide
            beside = _beside(grid, guide, BESIDE * lengths.half)
            factor = np.minimum(factor * beside, 8.0) * noise(grid, random, 0.15, WAVES / lengths.reach)
        self._ended = "its fixed amount of work was done after"


def _through(grid: ClearanceGrid, cost: Array, stops: Array, heading: Array, wish: Wish, greed: float) -> Array | None:
    """A passage through all stops (k, 3) that begins with a heading (3,), or None.

    Raises
    ------
    ClosedOffError
        There is no way over the grid, however it bends.
    """
    guide = stops[:1]
    length = 0.0
    for target in stops[1:]:
        left = cost_to_go(grid, cost, target, guide[-1])
        i, j, k = grid.nodes(guide[-1:])[0]
        if not np.isfinite(left[i, j, k]):
            raise ClosedOffError
        rest = replace(wish, longest=wish.longest - length)
        leg = passage(grid, cost, left, guide[-1], heading, target, rest, greed)
        if leg is None:
            leg = relaxed(grid, along(grid, left, guide[-1], target), heading, rest)
        if leg is None:
            return None
        heading = _arrival(leg, heading)
        length += float(np.linalg.norm(np.diff(leg, axis=0), axis=1).sum())
        guide = np.concatenate([guide, leg[1:]])
    return guide


def _arrival(leg: Array, heading: Array) -> Array:
    """The heading (3,) at the end of a leg of arcs: that of the last chord, turned on by half of what it turned."""
    last = leg[-1] - leg[-2]
    last /= np.linalg.norm(last)
    before = heading
    if len(leg) > 2:
        before = leg[-2] - leg[-3]
        before /= np.linalg.norm(before)
    turned = last + 0.5 * (last - before)
    return turned / np.linalg.norm(turned)


def _beside(grid: ClearanceGrid, guide: Array, far: float) -> Array:
    """Factor (a, b, c) by which a metre costs more within `far` m of a passage that was found; not near its ends."""
    middle = even(guide, 0.4 * far)
    middle = middle[len(middle) // 6 : -max(1, len(middle) // 6)]
    out = np.ones(grid.distance.shape)
    reach = int(np.ceil(far / grid.cell))
    axis = np.arange(-reach, reach + 1)
    ball = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    ball = ball[(ball**2).sum(axis=1) <= reach**2]
    nodes = (grid.nodes(middle)[:, None] + ball[None]).reshape(-1, 3)
    nodes = nodes[((nodes >= 0) & (nodes < np.array(grid.distance.shape))).all(axis=1)]
    out[nodes[:, 0], nodes[:, 1], nodes[:, 2]] = 1.6
    return out
