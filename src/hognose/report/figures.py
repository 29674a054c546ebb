"""The figures of a plan: the arm at chosen instants, and the charts of its numbers.

Each function takes a plan and returns a matplotlib figure of its own; save it with ``figure.savefig``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from hognose.errors import InputError
from hognose.report.camera import FRONT, Camera, fitted
from hognose.report.canvas import HALO, draw_marks, draw_step, place, prepare
from hognose.report.charts import body_deviation, cable_lengths, clearance_map, joint_angles, tip_error
from hognose.report.render import Stage, with_the_arm
from hognose.report.style import FAINT, GRID, HEAD, INK, SMALL, clearance_colours, new_figure

if TYPE_CHECKING:
    from hognose.planning.plan import Plan

__all__ = ["body_deviation", "cable_lengths", "clearance_map", "instants", "joint_angles", "steps_at", "tip_error"]


def instants(plan: Plan, times: Sequence[float] | None = None, *, colour: str = "links") -> Figure:
    """Return the arm at some instants, each seen from the side with a small view from the front.

    Parameters
    ----------
    plan
    times
        Instants, s; the nearest steps are shown. By default four, spread evenly from the first step to the
        last.
    colour
        ``"links"``: two tones in turn; ``"clearance"``: by each link's clearance at the instant.

    Raises
    ------
    InputError
        If a time lies outside the plan, or `colour` is neither of the two.
    """
    if colour not in ("links", "clearance"):
        raise InputError(f"colour = {colour!r}: there is no such colouring. Take 'links' or 'clearance'.")
    steps = steps_at(plan, times)
    columns = 2 if len(steps) > 1 else 1
    rows = -(-len(steps) // columns)
    foot = 0.55 if colour == "clearance" else 0.0
    height = 2.35 * rows * (2 / columns) + foot
    figure = new_figure(9.6, height, 200.0)
    boxes = [
        (
            (k % columns) / columns + 0.004,
            (foot + (rows - 1 - k // columns) * (height - foot) / rows) / height + 0.004,
            1 / columns - 0.008,
            (height - foot) / height / rows - 0.008,
        )
        for k in range(len(steps))
    ]
    sides = [figure.add_axes(box) for box in boxes]
    insets = [figure.add_axes(_corner(figure, box)) for box in boxes]
    side, front = prepare(sides[0], plan), prepare(insets[0], plan, camera=_front_camera(plan), density=0.6)
    for k, step in enumerate(steps):
        _show(sides[k], side, plan, step, colour, labels=k == 0)
        _show(insets[k], front, plan, step, colour, labels=False)
        _frame(sides[k], f"({chr(97 + k)})  t = {plan.time[step]:.2f} s", (0.015, 0.965), GRID)
        _frame(insets[k], "front", (0.06, 0.94), FAINT)
    if colour == "clearance":
        _bar(figure, plan, height)
    return figure


def steps_at(plan: Plan, times: Sequence[float] | None = None) -> list[int]:
    """Return the steps nearest to instants in s, by default four spread evenly over the plan."""
    if times is None:
        return [int(step) for step in np.unique(np.linspace(0, len(plan.time) - 1, 4).round().astype(int))]
    first, last = float(plan.time[0]), float(plan.time[-1])
    slack = 0.5 * (last - first) / max(len(plan.time) - 1, 1) + 1e-9
    for time in times:
        if not first - slack <= time <= last + slack:
            raise InputError(f"times: {time:g} s lies outside the plan, which runs from {first:g} s to {last:g} s.")
    if not len(times):
        raise InputError("times: give at least one instant, or none at all for four spread evenly.")
    return [int(np.argmin(np.abs(plan.time - time))) for time in times]


def _show(axes: Axes, stage: Stage, plan: Plan, step: int, colour: str, labels: bool) -> None:
    place(axes, stage)
    draw_step(axes, stage, plan, step, colour=colour)
    draw_marks(axes, stage, plan, labels=labels)


def _frame(axes: Axes, title: str, at: tuple[float, float], colour: str) -> None:
    axes.add_patch(Rectangle((0, 0), 1, 1, transform=axes.transAxes, fill=False, color=colour, linewidth=0.9, zorder=8))
    size = HEAD if at[0] < 0.05 else SMALL
    words = axes.text(*at, title, transform=axes.transAxes, fontsize=size, color=INK, va="top", zorder=9)
    words.set_path_effects(HALO)


def _corner(figure: Figure, box: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """Return the square in a panel's upper left corner, below its title."""
    left, low, width, height = box
    wide = 0.235 * width
    tall = wide * figure.get_figwidth() / figure.get_figheight()
    return left + 0.016 * width, low + 0.88 * height - tall, wide, tall


def _front_camera(plan: Plan) -> Camera:
    """Return a camera that looks back at the last pose, near enough to show the body in the openings."""
    around = 4 * float(plan.robot.body_radii.max())
    points = plan.path.point(np.linspace(0, plan.path.length, 50))
    points = np.concatenate([points + np.array([0, 0, around]), points - around, points + around])
    return fitted(points, (100, 100), towards_eye=with_the_arm(plan, FRONT), half_angle=np.radians(5.0), border=0.0)


def _bar(figure: Figure, plan: Plan, height: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    horizon = plan.horizon * 1e3
    place = figure.add_axes((0.3, 0.32 / height, 0.4, 0.1 / height))
    bar = figure.colorbar(
        ScalarMappable(Normalize(0, horizon), clearance_colours()),
        cax=place,
        orientation="horizontal",
        extend="max",
    )
    ticks = np.linspace(0, horizon, 6)
    bar.set_ticks(list(ticks), labels=[f"{tick:g}" for tick in ticks[:-1]] + [f"≥ {horizon:g}"])
    bar.ax.tick_params(labelsize=SMALL, labelcolor=INK, length=2)
    bar.set_label("Clearance of the link (mm)", fontsize=SMALL, color=INK, labelpad=1)
