"""Charts that follow the time line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hognose.planning import Plan
from hognose.planning.base_limits import BaseLimits
from hognose.planning.link_budgets import clearance_left
from hognose.viewer.verdict_panel import BEFORE

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

#: A chart has at most so many rows of a plan; the extremes of what is left out are kept.
MOST_ROWS = 240
TONES = ("#1f6f8b", "#b3202a", "#5a7d2c", "#7a4fa3", "#c9772b", "#3f6fb5", "#8b8b2e", "#a0527a", "#4b9a86", "#777777")
KINDS = ("clearance, mm", "bend angles, deg", "cable travel, mm", "cable speed, mm/s", "feed, mm", "feed speed, mm/s")


def series_of(plan: Plan, kind: str) -> tuple[list[str], Array, list[float]]:
    """Names (k), values (T, k) and limits to be drawn across, of one kind of chart."""
    sections = plan.robot.sections
    if kind == KINDS[0]:
        return [f"link {i + 1}" for i in range(sections)], 1e3 * clearance_left(plan), [1e3 * plan.task.margin]
    if kind == KINDS[1]:
        names = [f"{axis}{i + 1}" for i in range(sections) for axis in "αβ"]
        bounds = np.degrees(plan.robot.bend_bounds)
        return names, np.degrees(plan.angles.reshape(len(plan.feed), -1)), [float(bounds.max()), float(bounds.min())]
    if kind in KINDS[2:4]:
        names = [f"cable {i + 1}" for i in range(plan.robot.cables)]
        out = 1e3 * (plan.commanded_lengths - plan.robot.straight_cable_lengths)
        if kind == KINDS[2]:
            return names, out, []
        speed = np.gradient(out, plan.time, axis=0) if len(plan.time) > 1 else np.zeros_like(out)
        limit = 1e3 * plan.robot.spec.limits.cable_speed
        return names, speed, [limit, -limit] if np.abs(speed).max() > 0.5 * limit else []
    if kind == KINDS[4]:
        return ["feed"], 1e3 * plan.feed[:, None], []
    speed = np.gradient(1e3 * plan.feed, plan.time) if len(plan.time) > 1 else np.zeros(1)
    return ["feed speed"], speed[:, None], _fastest(plan)


def _fastest(plan: Plan) -> list[float]:
    """Limits (mm/s) of the feed's speed that a plan is judged by; none where the task does not say its carrier's."""
    limits = BaseLimits.of(plan.task)
    fastest = plan.task.spec.motion.profile_of(plan.retracts) == "fastest"
    limit = 1e3 * (limits.speed if fastest else limits.judged_speed)
    if math.isinf(limit):
        return []
    return [limit, -limit] if plan.retracts else [limit]


class Plots:
    """One chart at a time, of the kind that is chosen, with a line at the row that is shown."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._plan: Plan | None = None
        self._rows = np.arange(1)
        self._stale = False
        self._at = -1
        self._data: list[Array] = []
        self._kind = gui.add_dropdown("chart", KINDS, initial_value=KINDS[0])
        self._chart: Any = None
        self._gui = gui
        self._before = gui.add_markdown(BEFORE, visible=False)
        self._folder = gui.add_folder("over time, s", expand_by_default=True)

        @self._kind.on_update
        def _(event: viser.GuiEvent) -> None:
            del event
            self._stale = True

    def show(self, plan: Plan) -> None:
        """Draw another plan, when next asked to follow."""
        self._plan, self._stale, self._before.visible = plan, True, False

    def outdate(self) -> None:
        """Say that what is drawn is not of the task as it is now."""
        self._before.visible = self._plan is not None

    def follow(self, row: int) -> None:
        """Move the line to a row, and draw what is stale. Only the page's thread may call this."""
        if self._plan is None:
            return
        if self._stale:
            self._stale = False
            self._draw(self._plan)
            self._at = -1
        if row != self._at and self._chart is not None:
            self._at = row
            self._chart.data = (*self._data, self._now(row))

    def _draw(self, plan: Plan) -> None:
        names, values, limits = series_of(plan, self._kind.value)
        every = max(1, -(-len(values) // MOST_ROWS))
        self._rows = np.unique(np.append(np.arange(0, len(values), every), len(values) - 1))
        shown = values[self._rows]
        lines = [np.full(len(self._rows), limit) for limit in limits]
        low, self._high = float(min([shown.min(), *limits])), float(max([shown.max(), *limits]))
        self._low = low - 0.08 * max(self._high - low, 1e-3)  # below all lines, so as to hide none
        self._data = [plan.time[self._rows], *shown.T, *lines]
        series = (
            {"label": "s"},
            *({"label": n, "stroke": TONES[k % len(TONES)], "width": 1.3} for k, n in enumerate(names)),
            *({"label": "limit", "stroke": "#b3202a", "dash": [6, 4], "width": 1.5} for _ in limits),
            {"label": "now", "stroke": "#111111", "width": 2.0},
        )
        self._put((*self._data, self._now(0)), series)

    def _now(self, row: int) -> Array:
        """A line that stands up at a row; what is not a number would leave the chart without a scale."""
        now = np.full(len(self._rows), self._low)
        now[int(np.argmin(np.abs(self._rows - row)))] = self._high
        return now

    def _put(self, data: Sequence[Array], series: Sequence[Any]) -> None:
        if self._chart is not None and len(self._chart.series) == len(series):
            self._chart.series, self._chart.data = tuple(series), tuple(data)
            return
        if self._chart is not None:
            self._chart.remove()
        with self._folder:
            self._chart = self._gui.add_uplot(
                tuple(data),
                tuple(series),
                height=230,
                legend={"show": False},
                scales={"x": {"time": False}},
            )
